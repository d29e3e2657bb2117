//! Generated solids: clean surfaces, volumes and areas in closed form, and the answers to bad parameters.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::*;
use crate::{TriMesh, surface::check};

/// Ratio of a regular n-gon's area to its circumscribed circle's.
fn polygon(n: usize) -> f64 {
    (TAU / n as f64).sin() * n as f64 / TAU
}

#[track_caller]
fn assert_close(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() <= relative, "{value} instead of {expected}");
}

/// Closed, manifold, outward-wound, uncrossed; V − E + F = 2 (1 − handles) per piece.
#[track_caller]
fn assert_clean(mesh: &TriMesh, euler: i64) {
    let found = check(mesh);
    assert!(found.is_clean(), "{found:?}");
    assert_eq!(mesh.vertices.len() as i64 - mesh.triangles.len() as i64 / 2, euler);
}

#[test]
fn boxes_have_their_axes_volume_and_area() {
    let at = DVec3::new(3.0, -2.0, 0.5);
    let cases = [
        (cuboid(DVec3::new(1.0, 2.0, 3.0), at), [1.0, 2.0, 3.0]),
        (beam(5.0, 0.5, at), [5.0, 0.5, 0.5]),
        (wall(4.0, 3.0, 0.2, at), [4.0, 3.0, 0.2]),
        (sheet(4.0, 3.0, 0.01, at), [4.0, 0.01, 3.0]),
    ];
    for (mesh, [x, y, z]) in cases {
        let mesh = mesh.unwrap();
        assert_clean(&mesh, 2);
        let (lo, hi) = mesh.bounds().unwrap();
        assert!((hi - lo).abs_diff_eq(DVec3::new(x, y, z), 1e-14) && ((lo + hi) / 2.0).abs_diff_eq(at, 1e-14));
        assert_close(mesh.volume(), x * y * z, 1e-12); // measured 3e-14
        assert_close(mesh.area(), 2.0 * (x * y + y * z + z * x), 1e-12);
    }
}

#[test]
fn balls_approach_the_sphere_with_the_square_of_the_edge() {
    let r = 0.7;
    let exact = 4.0 / 3.0 * PI * r * r * r;
    // icosahedron with circumradius r: edge a = r / sin(2π/5), V = 5(3+√5)/12 a³
    let edge = r / (TAU / 5.0).sin();
    assert_close(ball(r, 0).unwrap().volume(), 5.0 * (3.0 + 5.0_f64.sqrt()) / 12.0 * edge.powi(3), 1e-12);
    let mut last = 1.0 - ball(r, 0).unwrap().volume() / exact;
    for subdivisions in 1..=5 {
        let mesh = ball(r, subdivisions).unwrap();
        assert_eq!(mesh.triangles.len(), 20 << (2 * subdivisions));
        assert_clean(&mesh, 2);
        assert!(mesh.vertices.iter().all(|p| (p.length() - r).abs() < 1e-15));
        let missing = 1.0 - mesh.volume() / exact;
        let factor = last / missing;
        assert!((3.1..4.01).contains(&factor), "{factor}"); // measured 3.12, 3.74, 3.93, 3.98, 4.00
        last = missing;
    }
    assert_close(ball(r, 5).unwrap().area(), 4.0 * PI * r * r, 4e-4); // measured 3.0e-4
}

#[test]
fn solids_of_revolution_have_the_volume_of_pappus() {
    for n in [3, 4, 7, 64] {
        let mesh = cylinder(0.5, 2.0, n).unwrap();
        assert_clean(&mesh, 2);
        assert_close(mesh.volume(), PI * 0.25 * 2.0 * polygon(n), 1e-12);
        let side = 2.0 * 0.5 * (PI / n as f64).sin();
        assert_close(mesh.area(), n as f64 * side * 2.0 + 2.0 * PI * 0.25 * polygon(n), 1e-12);
        // A ring with a square section, given in either sense.
        let square = [(1.0, -0.1), (1.2, -0.1), (1.2, 0.1), (1.0, 0.1)];
        let turned: Vec<_> = square.into_iter().rev().collect();
        for profile in [&square[..], &turned] {
            let ring = revolution(profile, n).unwrap();
            assert_clean(&ring, 0);
            assert_close(ring.volume(), TAU * 1.1 * 0.04 * polygon(n), 1e-12);
        }
    }
    // A cone with extra points on the axis, and a hollow one whose profile runs along the axis twice.
    let cone = revolution(&[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, 0.6), (0.0, 0.3)], 12).unwrap();
    assert_clean(&cone, 2);
    assert_eq!(cone.vertices.len(), 14);
    assert_close(cone.volume(), PI / 3.0 * polygon(12), 1e-12);
    let hollow = [(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (0.0, 0.5), (0.5, 0.0), (0.0, -0.5)];
    let hollow = revolution(&hollow, 12).unwrap();
    assert_clean(&hollow, 4);
    assert_close(hollow.volume(), TAU / 3.0 * (1.0 - 0.125) * polygon(12), 1e-12);
}

#[test]
fn profiles_that_make_no_solid_are_refused() {
    let square = [(1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0)];
    let crossed = [(1.0, 0.0), (2.0, 1.0), (2.0, 0.0), (1.0, 1.0)];
    assert_eq!(revolution(&crossed, 8), Err(ShapeError::Flat), "the two halves cancel");
    let lopsided = [(1.0, 0.0), (2.0, 1.0), (2.0, 0.0), (1.0, 2.0)];
    assert_eq!(revolution(&lopsided, 8), Err(ShapeError::Crossed { first: 0, second: 2 }));
    let repeated = [square[0], square[1], square[1], square[2], square[3]];
    assert_eq!(revolution(&repeated, 8), Err(ShapeError::Crossed { first: 0, second: 1 }));
    let spike = [(1.0, 0.0), (3.0, 0.0), (2.0, 0.0), (2.0, 1.0)];
    assert_eq!(revolution(&spike, 8), Err(ShapeError::Crossed { first: 0, second: 1 }));
    let touching = [(1.0, 0.0), (3.0, 0.0), (3.0, 1.0), (2.0, 0.0), (1.0, 1.0)];
    assert!(matches!(revolution(&touching, 8), Err(ShapeError::Crossed { first: 0, .. })));
    assert_eq!(revolution(&[(0.0, 0.0), (1.0, -1.0), (1.0, 1.0)], 8), Err(ShapeError::Pinched { point: 0 }));
    let across = revolution(&[(-0.5, 0.0), (1.0, 0.0), (1.0, 1.0)], 8).unwrap_err();
    assert!(across.to_string().contains("profile point 0 = (-0.5, 0)"), "{across}");
    assert!(matches!(revolution(&[(f64::NAN, 0.0), (1.0, 0.0), (1.0, 1.0)], 8), Err(ShapeError::AcrossAxis { .. })));
    assert_eq!(revolution(&[(1.0, 0.0), (2.0, 0.0), (3.0, 0.0)], 8), Err(ShapeError::Flat));
    assert_eq!(revolution(&square[..2], 8), Err(ShapeError::Flat));
    assert!(matches!(revolution(&square, 2), Err(ShapeError::OutOfRange { name: "segments", .. })));
}

#[test]
fn bad_lengths_are_named() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let name = |shape: Result<TriMesh, ShapeError>| match shape.unwrap_err() {
            ShapeError::OutOfRange { shape, name, .. } => format!("{shape} {name}"),
            other => other.to_string(),
        };
        assert_eq!(name(cuboid(DVec3::new(1.0, bad, 1.0), DVec3::ZERO)), "cuboid size along y");
        assert_eq!(name(wall(1.0, 1.0, bad, DVec3::ZERO)), "wall thickness");
        assert_eq!(name(sheet(1.0, bad, 1.0, DVec3::ZERO)), "sheet depth");
        assert_eq!(name(ball(bad, 1)), "ball radius");
        assert_eq!(name(cylinder(1.0, bad, 8)), "cylinder height");
        assert_eq!(name(vase(bad, 0.01, 50)), "vase height");
        assert!(vase(0.3, bad, 50).unwrap_err().to_string().contains("give 0.01 to 0.06 of the height"));
    }
    assert!(cuboid(DVec3::ONE, DVec3::splat(f64::NAN)).is_err() && cuboid(DVec3::ONE, DVec3::splat(1e10)).is_err());
    assert!(ball(1.0, 9).is_err() && vase(0.3, 0.012, 7).is_err());
    let too_thick = vase(0.3, 0.05, 50).unwrap_err();
    assert_eq!(too_thick, ShapeError::WallDoesNotFit { wall: 0.05, height: 0.3 });
}

#[test]
fn the_vase_stands_on_its_foot_and_has_its_measures() {
    let mesh = vase(0.3, 0.012, 50).unwrap();
    assert_clean(&mesh, 2);
    assert_eq!(mesh.triangles.len(), 7900);
    let (lo, hi) = mesh.bounds().unwrap();
    assert_eq!(lo.y, 0.0);
    assert!((hi.y - 0.3).abs() < 1e-4, "{}", hi.y); // measured 3e-5: the rim is sampled beside its top
    let radius = |from: f64, to: f64, least: bool| {
        let radii = mesh.vertices.iter().filter(|p| (from..to).contains(&p.y)).map(|p| p.x.hypot(p.z));
        if least { radii.filter(|r| *r > 0.033).fold(1.0, f64::min) } else { radii.fold(0.0, f64::max) }
    };
    let (belly, neck, rim) = (radius(0.1, 0.2, false), radius(0.24, 0.27, true), radius(0.28, 0.31, false));
    assert!((belly - 0.085).abs() < 0.002 && (neck - 0.04).abs() < 0.002 && (rim - 0.06).abs() < 0.004);
    let at_rest = mesh.vertices.iter().filter(|p| p.y == 0.0).map(|p| p.x.hypot(p.z)).fold(0.0, f64::max);
    assert!((at_rest - 0.0456).abs() < 1e-9, "foot radius {at_rest}");
    // Pappus for the outline, which runs counter-clockwise.
    let outline = vase_profile(0.3, 0.012, TAU * 0.283 * 0.3 / 50.0).unwrap();
    let next = outline.iter().cycle().skip(1);
    let swept: f64 =
        outline.iter().zip(next).map(|(p, q)| (q.1 - p.1) * (p.0 * p.0 + p.0 * q.0 + q.0 * q.0) / 3.0).sum();
    assert_close(mesh.volume(), PI * swept * polygon(50), 1e-12);
    assert!((1.4e-3..1.5e-3).contains(&mesh.volume()), "{} m³", mesh.volume());
    assert_eq!(vase(0.3, 0.012, 50).unwrap(), mesh, "same parameters, same bits");
    // Twice the size is the same vase.
    assert_close(vase(0.6, 0.024, 50).unwrap().volume(), 8.0 * mesh.volume(), 1e-9);
}

#[test]
fn the_wall_of_the_vase_is_nowhere_thinner_than_asked() {
    for wall in [0.01, 0.04, 0.06] {
        let profile = vase_profile(1.0, wall, 0.005).unwrap();
        let points: Vec<glam::DVec2> = profile.iter().map(|&(r, y)| glam::DVec2::new(r, y)).collect();
        let top = (0..points.len()).max_by(|&i, &j| points[i].y.total_cmp(&points[j].y)).unwrap();
        // Outer and inner contour away from the rim, where they join.
        let outside = &points[..top];
        let inside = points[top..].iter().filter(|p| p.distance(points[top]) > 2.0 * wall);
        let thinnest = inside.flat_map(|p| outside.iter().map(move |q| p.distance(*q))).fold(f64::INFINITY, f64::min);
        // Measured 0.985, 0.995 and 1.000 of the wall for the three.
        assert!((0.98 * wall..1.03 * wall).contains(&thinnest), "{thinnest} for {wall}");
        assert_clean(&vase(1.0, wall, 31).unwrap(), 2);
    }
}

#[test]
fn the_lattice_counts_x_first() {
    let points = cubic_lattice([3, 2, 2], 0.5);
    assert_eq!(points.len(), 12);
    assert_eq!(points[0], DVec3::ZERO);
    assert_eq!(points[1], DVec3::new(0.5, 0.0, 0.0));
    assert_eq!(points[3], DVec3::new(0.0, 0.5, 0.0));
    assert_eq!(points[11], DVec3::new(1.0, 0.5, 0.5));
    assert!(cubic_lattice([4, 0, 4], 1.0).is_empty());
}

#[test]
fn jittered_boxes_of_tetrahedra_conform_and_fill_the_box() {
    let size = DVec3::new(2.0, 1.0, 0.5);
    for jitter in [0.0, 0.2, 0.5] {
        let mesh = tet_box(size, [8, 5, 4], jitter, 7).unwrap();
        assert_eq!(mesh.tets.len(), 6 * 8 * 5 * 4);
        let volumes: Vec<f64> = (0..mesh.tets.len()).map(|t| mesh.volume(t)).collect();
        let regular = size.element_product() / mesh.tets.len() as f64;
        assert!(volumes.iter().all(|v| *v >= 0.0999 * regular));
        assert_close(volumes.iter().sum(), size.element_product(), 1e-12);
        let spread = volumes.iter().fold(0.0_f64, |s, v| s.max((v / regular - 1.0).abs()));
        assert!(if jitter == 0.0 { spread < 1e-12 } else { spread > jitter }, "{spread} at {jitter}");
        // Each face has two tetrahedra or lies on the box; two triangles a cell side are on it.
        let outside = mesh.neighbours().unwrap().as_flattened().iter().filter(|&&t| t == u32::MAX).count();
        assert_eq!(outside, 4 * (8 * 5 + 5 * 4 + 4 * 8));
        let (lo, hi) = mesh.bounds().unwrap();
        assert!(lo.abs_diff_eq(-size / 2.0, 0.0) && hi.abs_diff_eq(size / 2.0, 0.0));
    }
    assert_eq!(tet_box(size, [3, 3, 3], 0.3, 1), tet_box(size, [3, 3, 3], 0.3, 1));
    assert_ne!(tet_box(size, [3, 3, 3], 0.3, 1), tet_box(size, [3, 3, 3], 0.3, 2));
    assert!(tet_box(size, [3, 0, 3], 0.3, 1).unwrap_err().to_string().contains("n = 0"));
    assert!(tet_box(size, [3, 3, 3], 0.6, 1).unwrap_err().to_string().contains("give 0 to 0.5"));
    assert!(tet_box(DVec3::new(1.0, f64::NAN, 1.0), [3, 3, 3], 0.1, 1).is_err());
}
