//! Clipped families: gaps, slits, pre-cuts, and how little a whole body loses.

use super::meshes::{ball, barycentres, kuhn, tetgen};
use super::*;
use crate::{TetMesh, TriMesh};

/// Families with and without the clip.
fn both(mesh: &TetMesh, horizon: f64, cuts: Option<&TriMesh>) -> (Families, Families) {
    let points = barycentres(mesh);
    let clip = Clip::new(mesh, cuts).unwrap();
    let clipped = families(&points, horizon, Some(&clip)).unwrap();
    let whole = families(&points, horizon, None).unwrap();
    assert_symmetric(&clipped);
    let neighbours = mesh.neighbours().unwrap();
    for (t, row) in neighbours.iter().enumerate() {
        for &n in row.iter().filter(|&&n| n != u32::MAX && whole.row(t).contains(&n)) {
            let cut = clip.cut_links().contains(&(n.min(t as u32), n.max(t as u32)));
            assert_eq!(clipped.row(t).contains(&n), !cut, "face neighbours {t} {n}");
        }
    }
    (clipped, whole)
}

/// Directed bonds from points with `left` to points without.
fn across(mesh: &TetMesh, f: &Families, left: impl Fn(DVec3) -> bool) -> usize {
    let points = barycentres(mesh);
    let other = |i: usize| f.row(i).iter().filter(|&&j| !left(points[j as usize])).count();
    (0..f.len()).filter(|&i| left(points[i])).map(other).sum()
}

#[test]
fn no_bond_between_two_boxes() {
    // A gap of 0.2 after cell 2, and boxes that touch in one edge of vertices only.
    let mut gap = kuhn([6, 3, 3], 0.0, |c| c[0] != 2);
    for v in &mut gap.vertices {
        v.x -= if v.x >= 3.0 { 0.8 } else { 0.0 };
    }
    let (clipped, whole) = both(&gap, 1.4, None);
    assert_eq!(across(&gap, &clipped, |p| p.x < 2.1), 0);
    assert!(across(&gap, &whole, |p| p.x < 2.1) > 200);
    // All that a convex box may lose is what crosses the gap.
    assert_eq!(whole.neighbours.len() - clipped.neighbours.len(), 2 * across(&gap, &whole, |p| p.x < 2.1));

    let touching = kuhn([4, 4, 2], 0.0, |c| (c[0] < 2) == (c[1] < 2));
    let (clipped, _) = both(&touching, 1.4, None);
    assert_eq!(Clip::new(&touching, None).unwrap().parts(), 2);
    assert_eq!(across(&touching, &clipped, |p| p.x < 2.0), 0);
}

#[test]
fn no_bond_across_the_slit_of_a_u() {
    // Legs of the U are 3 wide, the slit of one cell, drawn together to 0.2, reaches down to y = 2.
    let mut u = kuhn([7, 6, 2], 0.2, |c| c[0] != 3 || c[1] < 2);
    for v in &mut u.vertices {
        v.x -= if v.x >= 3.5 { 0.8 } else { 0.0 };
    }
    let (clipped, whole) = both(&u, 1.4, None);
    let points = barycentres(&u);
    let crossing = |f: &Families| -> usize {
        let bad = |i: usize, j: u32| {
            let (p, q) = (points[i], points[j as usize]);
            let t = (3.0 - p.x) / (q.x - p.x); // the left wall of the slit is near x = 3
            p.x < 2.8 && q.x > 3.4 && p.y + t * (q.y - p.y) > 2.4
        };
        (0..f.len()).map(|i| f.row(i).iter().filter(|&&j| bad(i, j)).count()).sum()
    };
    assert_eq!(crossing(&clipped), 0);
    assert!(crossing(&whole) > 200, "{}", crossing(&whole));
    // The body of the U below the slit is untouched.
    let low = |f: &Families| (0..f.len()).filter(|&i| points[i].y < 0.6).map(|i| f.row(i).len()).sum::<usize>();
    assert_eq!(low(&clipped), low(&whole));
}

/// A box of `n` cells whose vertices with x = `at` and y > `tip` are doubled: a slit of no width.
fn slit(n: [usize; 3], at: f64, tip: f64) -> TetMesh {
    let mut mesh = kuhn(n, 0.0, |_| true);
    let first = mesh.vertices.len() as u32;
    let doubled: Vec<u32> =
        (0..first).filter(|&v| mesh.vertices[v as usize].x == at && mesh.vertices[v as usize].y > tip).collect();
    for t in 0..mesh.tets.len() {
        if mesh.barycentre(t).x > at {
            for v in &mut mesh.tets[t] {
                *v = doubled.binary_search(v).map_or(*v, |k| first + k as u32);
            }
        }
    }
    let copies: Vec<DVec3> = doubled.iter().map(|&v| mesh.vertices[v as usize]).collect();
    mesh.vertices.extend(copies);
    mesh
}

#[test]
fn no_bond_across_a_slit_of_no_width() {
    let mesh = slit([6, 6, 3], 3.0, 2.5); // doubled from y = 3, so the slit is open from y = 2 on
    let (clipped, whole) = both(&mesh, 1.4, None);
    let points = barycentres(&mesh);
    let crossing = |f: &Families, low: f64, high: f64| -> usize {
        let through = |i: usize, j: u32| {
            let (p, q) = (points[i], points[j as usize]);
            let y = p.y + (3.0 - p.x) / (q.x - p.x) * (q.y - p.y);
            p.x < 3.0 && q.x > 3.0 && low < y && y < high
        };
        (0..f.len()).map(|i| f.row(i).iter().filter(|&&j| through(i, j)).count()).sum()
    };
    assert_eq!(crossing(&clipped, 3.0 + 1e-9, 9.0), 0);
    assert!(crossing(&whole, 3.0 + 1e-9, 9.0) > 200);
    assert_eq!(crossing(&clipped, -1.0, 2.0 - 1e-9), crossing(&whole, -1.0, 2.0 - 1e-9));
}

#[test]
fn a_pre_cut_plane_cuts_bonds_and_reports_its_faces() {
    let mesh = kuhn([6, 5, 4], 0.4, |_| true);
    // Two triangles over the whole cross-section, a little tilted, and the same cut in the lower half only.
    let plane = |top: f64| TriMesh {
        vertices: [(2.8, -1.0, -1.0), (2.8, top, -1.0), (3.1, top, 5.0), (3.1, -1.0, 5.0)]
            .map(|(x, y, z)| DVec3::new(x, y, z))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let left = |p: DVec3| p.x < 2.85 + 0.05 * p.z;
    let (clipped, whole) = both(&mesh, 1.4, Some(&plane(6.0)));
    assert_eq!(across(&mesh, &clipped, left), 0);
    assert_eq!(whole.neighbours.len() - clipped.neighbours.len(), 2 * across(&mesh, &whole, left));

    let clip = Clip::new(&mesh, Some(&plane(6.0))).unwrap();
    let points = barycentres(&mesh);
    let mut expected = Vec::new();
    for (s, row) in mesh.neighbours().unwrap().iter().enumerate() {
        for &t in row.iter().filter(|&&t| t != u32::MAX && s < t as usize) {
            if left(points[s]) != left(points[t as usize]) {
                expected.push((s as u32, t));
            }
        }
    }
    expected.sort_unstable();
    assert!(expected.len() > 20);
    assert_eq!(clip.cut_links(), expected);

    let (half, _) = both(&mesh, 1.4, Some(&plane(2.5)));
    let lost = |f: &Families| whole.neighbours.len() - f.neighbours.len();
    assert!(0 < lost(&half) && lost(&half) < lost(&clipped) * 2 / 3);
}

#[test]
fn clips_of_bad_meshes_are_refused() {
    let mut mesh = kuhn([1, 1, 1], 0.0, |_| true);
    let clip = Clip::new(&mesh, None).unwrap();
    let error = families(&[DVec3::ZERO; 5], 1.0, Some(&clip)).unwrap_err();
    assert_eq!(error, FamilyError::OtherMesh { points: 5, tets: 6 });
    let cut = TriMesh { vertices: vec![DVec3::NAN], triangles: vec![[0, 0, 0]] };
    assert!(matches!(Clip::new(&mesh, Some(&cut)), Err(FamilyError::CutNotFinite { index: 0, .. })));
    let cut = TriMesh { vertices: vec![DVec3::ONE], triangles: vec![[0, 0, 7]] };
    assert!(matches!(Clip::new(&mesh, Some(&cut)), Err(FamilyError::NoVertex { what: "cut triangle", .. })));
    mesh.tets[3][1] = 99;
    assert!(matches!(Clip::new(&mesh, None), Err(FamilyError::NoVertex { index: 3, vertex: 99, .. })));
    let doubled = [mesh.tets[0]; 3];
    mesh.tets.truncate(1);
    mesh.tets.extend(doubled);
    assert!(matches!(Clip::new(&mesh, None), Err(FamilyError::CrowdedFace(_))));
}

#[test]
fn convex_bodies_lose_next_to_nothing() {
    let (clipped, whole) = both(&kuhn([5, 4, 3], 0.4, |_| true), 1.4, None);
    assert_eq!(clipped.neighbours, whole.neighbours);
    let ball = ball(5);
    let (clipped, whole) = both(&ball, 1.4 * ball.mean_edge(), None);
    let lost = (whole.neighbours.len() - clipped.neighbours.len()) as f64 / whole.neighbours.len() as f64;
    println!("ball: {lost:.2e} of the bonds lost");
    assert!(lost < 1e-3, "{lost}");
}

#[test]
fn steps_and_corners_are_no_gaps() {
    let steps = kuhn([5, 5, 3], 0.0, |c| c[0] + c[1] < 5);
    let corner = kuhn([6, 6, 2], 0.0, |c| c[0] < 3 || c[1] < 3);
    for mesh in [steps, corner] {
        let (clipped, whole) = both(&mesh, 1.6, None);
        assert_eq!(clipped.neighbours, whole.neighbours);
    }
}

#[test]
fn meshes_of_other_people() {
    // Measured: 0, 2e-6, 2e-5, 1e-4, and 0.003 for the bear, which is of stair-stepped cubes.
    let bodies = [
        ("sphere_5k", 1e-6),
        ("bunny_20k", 1e-4),
        ("spot_20k", 1e-4),
        ("armadillo_20k", 5e-4),
        ("bear_newton_4k", 0.01),
    ];
    for (name, most) in bodies {
        let Some(mesh) = tetgen(name) else { return };
        let start = std::time::Instant::now();
        let (clipped, whole) = both(&mesh, 1.4 * mesh.mean_edge(), None);
        let lost = (whole.neighbours.len() - clipped.neighbours.len()) as f64 / whole.neighbours.len() as f64;
        println!("{name}: {} bonds, {lost:.1e} lost, {:.2} s", whole.neighbours.len(), start.elapsed().as_secs_f64());
        assert!(lost < most, "{name} lost {lost}");
    }
}

#[test]
fn no_bond_crosses_the_notches_of_the_sheet() {
    let Some(mesh) = tetgen("sheet_notched_20k") else { return };
    let (clipped, whole) = both(&mesh, 1.4 * mesh.mean_edge(), None);
    let points = barycentres(&mesh);
    // Notches from x = ±0.5 to ±0.25 along y = ±0.1, 8 mm wide at the rim and closing to a point.
    let crossing = |f: &Families| -> usize {
        let through = |i: usize, j: u32| {
            let (p, q) = (points[i], points[j as usize]);
            let side = |y0: f64, sign: f64| {
                (p.y - y0) * (q.y - y0) < 0.0 && sign * (p.x + (y0 - p.y) / (q.y - p.y) * (q.x - p.x)) > 0.25 + 1e-6
            };
            side(0.1, -1.0) || side(-0.1, 1.0)
        };
        (0..f.len()).map(|i| f.row(i).iter().filter(|&&j| through(i, j)).count()).sum()
    };
    println!(
        "sheet: {} bonds cross a notch, {} lost of {}",
        crossing(&whole),
        whole.neighbours.len() - clipped.neighbours.len(),
        whole.neighbours.len()
    );
    assert_eq!(crossing(&clipped), 0);
    assert!(crossing(&whole) > 100);
    assert!(whole.neighbours.len() - clipped.neighbours.len() <= crossing(&whole) * 11 / 10);
}

/// Speed of the clip at the size that matters; by hand, as `big_cloud`.
#[test]
#[ignore = "takes seconds and is worth reading only in a release build"]
fn big_body() {
    let mut mesh = kuhn([37; 3], 0.4, |_| true);
    let order = crate::order::morton_order(&barycentres(&mesh));
    mesh.tets = order.iter().map(|&t| mesh.tets[t as usize]).collect();
    let (points, horizon) = (barycentres(&mesh), 1.85);
    for _ in 0..2 {
        let start = std::time::Instant::now();
        let clip = Clip::new(&mesh, None).unwrap();
        let prepared = start.elapsed().as_secs_f64();
        let clipped = families(&points, horizon, Some(&clip)).unwrap();
        let done = start.elapsed().as_secs_f64();
        let whole = families(&points, horizon, None).unwrap();
        println!(
            "{} particles, {} bonds: mesh {prepared:.2} s, families with clip {:.2} s, without {:.2} s",
            points.len(),
            whole.neighbours.len(),
            done - prepared,
            start.elapsed().as_secs_f64() - done
        );
        assert_eq!(clipped.neighbours, whole.neighbours);
    }
}
