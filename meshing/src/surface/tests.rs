//! Broken versions of generated solids, one for each finding and repair, and the meshes that other people made.

use std::path::{Path, PathBuf};

use super::*;
use crate::shapes::{ball, cuboid, cylinder, vase};
use glam::DVec3;

fn cube() -> TriMesh {
    cuboid(DVec3::ONE, DVec3::ZERO).unwrap()
}

fn joined(parts: &[TriMesh]) -> TriMesh {
    let mut all = TriMesh::default();
    for part in parts {
        let first = all.vertices.len() as u32;
        all.vertices.extend(&part.vertices);
        all.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    all
}

fn moved(mut mesh: TriMesh, by: DVec3) -> TriMesh {
    mesh.vertices.iter_mut().for_each(|p| *p += by);
    mesh
}

fn turned_over(mut mesh: TriMesh) -> TriMesh {
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh
}

/// Every triangle with its own three vertices, as STL stores it.
fn soup(mesh: &TriMesh) -> TriMesh {
    let vertices = (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t)).collect();
    TriMesh { vertices, triangles: (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect() }
}

fn repaired(mesh: TriMesh) -> (TriMesh, Vec<String>) {
    let (mesh, said) = prepare(mesh, PrepareOptions::default()).unwrap();
    assert!(check(&mesh).is_clean(), "{:?}", check(&mesh));
    (mesh, said)
}

fn refused(mesh: TriMesh) -> SurfaceError {
    let found = check(&mesh);
    let error = prepare(mesh, PrepareOptions::default()).unwrap_err();
    let sentence = error.to_string();
    assert!(found.errors.iter().any(|e| e.to_string() == sentence), "{:?} found, but {sentence}", found.errors);
    assert!(!sentence.ends_with('.') && !sentence.contains('\n') && sentence.contains(';'), "{sentence}");
    error
}

#[test]
fn a_soup_is_merged_to_the_solid_it_came_from() {
    for solid in [cube(), ball(1.0, 3).unwrap(), cylinder(0.2, 3.0, 100).unwrap()] {
        let mut soup = soup(&solid);
        // Rounding of a writer: a few parts in 1e10 of the size.
        let size = size(&soup);
        for (i, p) in soup.vertices.iter_mut().enumerate() {
            *p += size * 1e-10 * DVec3::new((i % 3) as f64, (i % 5) as f64, (i % 2) as f64);
        }
        let copies = soup.vertices.len() - solid.vertices.len();
        let (mesh, said) = repaired(soup);
        assert_eq!(said, [format!("{copies} vertices stored more than once: merged.")]);
        assert_eq!(mesh.vertices.len(), solid.vertices.len());
        assert!((mesh.volume() / solid.volume() - 1.0).abs() < 1e-8);
    }
}

#[test]
fn what_carries_no_shape_is_dropped() {
    let mut mesh = cube();
    mesh.triangles.extend([
        [3, 3, 5],
        mesh.triangles[4],
        [mesh.triangles[7][0], mesh.triangles[7][2], mesh.triangles[7][1]],
    ]);
    mesh.vertices.insert(0, DVec3::splat(9.0));
    mesh.triangles.iter_mut().flatten().for_each(|v| *v += 1);
    let found = check(&mesh);
    assert_eq!((found.degenerate_triangles, found.duplicate_triangles, found.unused_vertices), (1, 2, 1));
    assert!(found.errors.is_empty() && !found.is_clean());
    let (mesh, said) = repaired(mesh);
    assert_eq!(
        said,
        [
            "1 triangle without area: removed.",
            "2 triangles stored more than once: removed.",
            "1 vertex in no triangle: removed."
        ]
    );
    assert_eq!(mesh, cube());
}

#[test]
fn a_flat_triangle_is_dissolved_into_its_neighbour() {
    // Split one edge of the cube on one side only and close the slit with a triangle without area.
    let mut mesh = cube();
    let [a, b, c] = mesh.triangles[0];
    let middle = (mesh.vertices[a as usize] + mesh.vertices[b as usize]) / 2.0;
    mesh.vertices.push(middle);
    mesh.triangles[0] = [a, 8, c];
    mesh.triangles.extend([[8, b, c], [a, b, 8]]);
    assert_eq!(check(&mesh).degenerate_triangles, 1);
    let (whole, said) = repaired(mesh.clone());
    assert_eq!(said, ["1 triangle without area: removed."]);
    assert_eq!((whole.triangles.len(), whole.vertices.len()), (14, 9));
    assert!((whole.volume() - 1.0).abs() < 1e-15);
    // The same without the flat triangle is a slit as long as the cube's edge: closed, for it has no width.
    mesh.triangles.pop();
    let (whole, said) = repaired(mesh);
    assert_eq!(said.len(), 1);
    assert!(said[0].starts_with("1 hole closed, the widest 1 across near (-0.5, -0.5, 0)"), "{said:?}");
    assert!((whole.volume() - 1.0).abs() < 1e-15 && whole.triangles.len() == 14);
}

#[test]
fn winding_is_made_one_and_outward() {
    let solid = ball(1.0, 2).unwrap();
    let mut mesh = solid.clone();
    for t in [0, 5, 77, 78, 200] {
        mesh.triangles[t].swap(1, 2);
    }
    assert_eq!(check(&mesh).turned_triangles, 5);
    let (mesh, said) = repaired(mesh);
    assert_eq!(said, ["5 triangles wound against the neighbours: turned."]);
    assert_eq!(mesh.volume(), solid.volume());

    let inside_out = turned_over(moved(solid.clone(), DVec3::X * 3.0));
    assert_eq!(check(&inside_out).inside_out_pieces, 1);
    let (mesh, said) = repaired(inside_out);
    assert!(said[0].starts_with("1 inside-out piece near (3, 0, 0)"), "{said:?}");
    assert!(mesh.volume() > 0.0);
}

#[test]
fn cavities_are_told_from_solids_by_nesting() {
    let shell = |r: f64| ball(r, 2).unwrap();
    let unit = shell(1.0).volume();
    // Ball in a cavity of a ball, and a second ball beside it that only the box of the first contains.
    let nested = |flips: [bool; 4]| {
        let aside = moved(shell(0.1), DVec3::new(0.9, 0.9, 0.9));
        let parts = [shell(1.0), shell(0.8), shell(0.5), aside];
        let part = |i: usize| if flips[i] { turned_over(parts[i].clone()) } else { parts[i].clone() };
        joined(&[part(0), part(1), part(2), part(3)])
    };
    let right = nested([false, true, false, false]);
    let (same, said) = repaired(right.clone());
    assert!(said.is_empty() && same == right);
    for flips in 0..16 {
        let flips = [0, 1, 2, 3].map(|i| flips >> i & 1 == 1);
        let (mesh, said) = repaired(nested(flips));
        assert_eq!(mesh, right);
        let expected = usize::from(flips[0] || flips[2] || flips[3]) + usize::from(!flips[1]);
        assert_eq!(said.len(), expected, "{said:?}");
        assert!((mesh.volume() / unit - (1.0 - 0.512 + 0.125 + 0.001)).abs() < 1e-12);
    }
}

#[test]
fn small_holes_are_closed_and_said() {
    let solid = ball(1.0, 5).unwrap();
    let mut mesh = solid.clone();
    // All triangles at one vertex, and two neighbours elsewhere.
    let pole = mesh.triangles[0][0];
    let at = mesh.vertices[pole as usize];
    mesh.triangles.retain(|t| !t.contains(&pole));
    let found = check(&mesh);
    assert_eq!((found.holes.len(), found.unused_vertices), (1, 1));
    assert!(found.holes[0].vertices.len() >= 5 && found.holes[0].at.distance(at) < 0.05);
    let far = (0..mesh.triangles.len()).max_by(|&s, &t| mesh.corners(s)[0].x.total_cmp(&mesh.corners(t)[0].x)).unwrap();
    mesh.triangles.swap_remove(far);
    let (mesh, said) = repaired(mesh);
    assert!(said[1].starts_with("2 holes closed, the widest 0.09"), "{said:?}");
    assert!((mesh.volume() / solid.volume() - 1.0).abs() < 1e-4);
    // Many slits at once: every edge of the ball split on one side only.
    let mut slit = ball(1.0, 4).unwrap();
    for t in 0..slit.triangles.len() {
        let [a, b, c] = slit.triangles[t];
        if a < b {
            let m = slit.vertices.len() as u32;
            slit.vertices.push((slit.vertices[a as usize] + slit.vertices[b as usize]) / 2.0);
            slit.triangles[t] = [a, m, c];
            slit.triangles.push([m, b, c]);
        }
    }
    let slits = check(&slit).holes.len();
    let (mesh, said) = repaired(slit);
    assert!(slits > 2000 && said.len() == 1 && said[0].starts_with(&format!("{slits} holes closed")), "{said:?}");
    assert!((mesh.volume() / ball(1.0, 4).unwrap().volume() - 1.0).abs() < 1e-12);
    // The same hole is too wide for a coarse ball.
    let mut coarse = ball(1.0, 1).unwrap();
    coarse.triangles.swap_remove(3);
    let error = refused(coarse.clone());
    assert!(matches!(error, SurfaceError::Open { edges: 3, loops: 1, .. }), "{error}");
    let wide = PrepareOptions { fill_below: 0.5, ..Default::default() };
    assert_eq!(prepare(coarse, wide).unwrap().0.triangles.len(), 80);
}

#[test]
fn open_surfaces_say_where_and_what_helps() {
    let mut mesh = cube();
    mesh.triangles.retain(|t| !t.iter().all(|&v| mesh.vertices[v as usize].y > 0.0));
    let error = refused(mesh.clone());
    assert_eq!(
        error.to_string(),
        "the surface is open along 4 edges in 1 loop, the widest near (0, 0.5, 0) and 1.414 across; close it or give \
         `shell = 0.03` to make it a wall"
    );
    // A soup whose corners don't quite meet is not closed triangle by triangle.
    let mut loose = soup(&ball(1.0, 4).unwrap());
    for (i, p) in loose.vertices.iter_mut().enumerate() {
        *p *= 1.0 + 1e-6 * (i % 7) as f64;
    }
    let error = refused(loose.clone());
    assert!(matches!(error, SurfaceError::Open { edges: 10_000.., loops: 1000.., .. }), "{error}");
    let closer = PrepareOptions { merge_within: 1e-5, ..Default::default() };
    assert!(check(&prepare(loose, closer).unwrap().0).is_clean(), "a wider reach merges them");
    let (same, said) = prepare(mesh.clone(), PrepareOptions { for_shell: true, ..Default::default() }).unwrap();
    assert!(same == mesh && said.is_empty(), "an open surface is what a shell starts from");
}

#[test]
fn non_manifold_edges_are_placed() {
    let mesh = joined(&[cube(), moved(cube(), DVec3::new(1.0, 1.0, 0.0))]);
    let error = refused(mesh);
    let at = DVec3::new(0.5, 0.5, 0.0);
    assert_eq!(error, SurfaceError::NonManifold { edges: 1, triangles: 4, at });
}

#[test]
fn crossings_are_counted_and_placed() {
    // Two cubes whose corners interpenetrate.
    let mesh = joined(&[cube(), moved(cube(), DVec3::new(0.9, 0.8, 0.7))]);
    let SurfaceError::SelfIntersecting { pairs, first, at } = refused(mesh.clone()) else { panic!("not seen") };
    let mut all = Vec::new();
    for s in 0..24 {
        for t in s + 1..24 {
            all.extend(overlap::meeting_point(&mesh.vertices, mesh.triangles[s], mesh.triangles[t]).map(|_| [s, t]));
        }
    }
    assert_eq!((pairs, first.map(|t| t as usize)), (all.len(), all[0]));
    assert!(pairs >= 6 && first[0] < 12 && first[1] >= 12);
    assert!(at.cmpge(DVec3::new(0.39, 0.29, 0.19)).all() && at.cmple(DVec3::splat(0.51)).all(), "{at}");

    // A spike of one vertex through the far side of a ball, and a ball that rests on a cube.
    let mut pierced = ball(1.0, 3).unwrap();
    pierced.vertices[0] *= -2.0;
    assert!(matches!(refused(pierced), SurfaceError::SelfIntersecting { pairs: 5.., .. }));
    let mut resting = ball(0.5, 1).unwrap();
    let lowest = resting.vertices.iter().map(|p| p.y).fold(0.0, f64::min);
    resting.vertices.iter_mut().for_each(|p| p.y += 0.5 - lowest);
    let error = refused(joined(&[resting.clone(), cube()]));
    let SurfaceError::SelfIntersecting { at, .. } = error else { panic!("{error}") };
    assert!((at.y - 0.5).abs() < 1e-12, "touches on the top of the cube: {at}");
    assert!(check(&joined(&[moved(resting, DVec3::Y * 1e-6), cube()])).is_clean());
}

#[test]
fn triangle_numbers_are_those_of_the_input() {
    let mut mesh = joined(&[cube(), moved(cube(), DVec3::splat(0.5))]);
    let SurfaceError::SelfIntersecting { first, .. } = refused(mesh.clone()) else { panic!("not seen") };
    mesh.triangles.splice(0..0, [[1, 1, 2]; 10]);
    let SurfaceError::SelfIntersecting { first: shifted, .. } = refused(mesh) else { panic!("not seen") };
    assert_eq!(shifted, first.map(|t| t + 10));
}

#[test]
fn one_sided_and_flat_surfaces_are_refused() {
    // Möbius strip.
    let n = 40;
    let mut strip = TriMesh::default();
    for i in 0..n {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        let across =
            DVec3::new(angle.cos() * (angle / 2.0).cos(), (angle / 2.0).sin(), angle.sin() * (angle / 2.0).cos());
        let middle = DVec3::new(angle.cos(), 0.0, angle.sin());
        strip.vertices.extend([middle - 0.2 * across, middle + 0.2 * across]);
        let (a, b) = (2 * i as u32, 2 * i as u32 + 1);
        let (c, d) = if i + 1 < n { (a + 2, b + 2) } else { (1, 0) };
        strip.triangles.extend([[a, b, d], [a, d, c]]);
    }
    let error = refused(strip.clone());
    assert!(matches!(error, SurfaceError::NonOrientable { wall: 0.06, .. }), "{error}");
    assert!(prepare(strip, PrepareOptions { for_shell: true, ..Default::default() }).is_ok());

    let thin = cuboid(DVec3::new(1.0, 1e-8, 1.0), DVec3::ZERO).unwrap();
    assert!(check(&thin).is_clean(), "thin is not flat");
    // A disc with a front and a back that meet at the rim only.
    let mut disc = TriMesh { vertices: vec![DVec3::X * 0.1, DVec3::X * -0.1], triangles: Vec::new() };
    for k in 0..6 {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 6.0).sin_cos();
        disc.vertices.push(DVec3::new(cos, 0.0, sin));
        let (a, b) = (2 + k as u32, 2 + (k as u32 + 1) % 6);
        disc.triangles.extend([[0, b, a], [1, a, b]]);
    }
    let error = refused(disc);
    assert!(matches!(error, SurfaceError::ZeroVolume { triangles: 12, .. }), "{error}");
}

#[test]
fn unusable_numbers_are_named() {
    let with = |x: f64| {
        let mut mesh = cube();
        mesh.vertices[5].z = x;
        mesh
    };
    assert!(refused(with(f64::NAN)).to_string().starts_with("vertex 5 has a coordinate"));
    assert_eq!(refused(with(1e40)), SurfaceError::NotFinite { vertex: 5, coordinate: 1e40 });
    assert_eq!(refused(with(f64::INFINITY)), SurfaceError::NotFinite { vertex: 5, coordinate: f64::INFINITY });
    let mut mesh = cube();
    mesh.triangles[3][1] = 8;
    assert_eq!(refused(mesh), SurfaceError::IndexOutOfRange { triangle: 3, index: 8, vertices: 8 });
    assert_eq!(refused(TriMesh::default()), SurfaceError::Empty);
    let point = TriMesh { vertices: vec![DVec3::ONE], triangles: vec![[0; 3]; 4] };
    assert_eq!(refused(point), SurfaceError::Empty);
}

#[test]
fn same_bits_on_any_number_of_threads() {
    let broken = joined(&[vase(0.3, 0.012, 40).unwrap(), moved(ball(0.05, 4).unwrap(), DVec3::new(0.05, 0.1, 0.0))]);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| check(&broken))
    };
    let one = on(1);
    assert!(matches!(one.errors[..], [SurfaceError::SelfIntersecting { pairs: 100.., .. }]), "{:?}", one.errors);
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
}

#[test]
fn meshes_that_other_people_made_pass_unchanged() {
    let Some(folder) = std::env::var_os("FISSURE_MESHES").map(PathBuf::from) else {
        println!("skipped: FISSURE_MESHES is not set");
        return;
    };
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder.join("surface")).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "ply"));
    files.sort();
    assert_eq!(files.len(), 11);
    for path in files {
        let mesh = read_ply(&path);
        let start = std::time::Instant::now();
        let found = check(&mesh);
        let elapsed = start.elapsed();
        println!("{}: {} triangles in {elapsed:.1?}", path.display(), mesh.triangles.len());
        assert!(found.is_clean(), "{}: {found:?}", path.display());
        assert!(elapsed.as_secs_f64() < 5.0, "{elapsed:?}"); // measured 0.08 to 0.36 s on a busy machine for 3e4 triangles, test profile
        let (same, said) = prepare(mesh.clone(), PrepareOptions::default()).unwrap();
        assert!(said.is_empty() && same == mesh, "{}: {said:?}", path.display());
        let (merged, _) = repaired(soup(&mesh));
        assert_eq!((merged.vertices.len(), merged.triangles.len()), (mesh.vertices.len(), mesh.triangles.len()));
    }
}

/// Binary little-endian PLY with float x y z and `list uchar int vertex_indices`, triangles only.
fn read_ply(path: &Path) -> TriMesh {
    let bytes = std::fs::read(path).unwrap();
    let mark = b"end_header\n";
    let start = bytes.windows(mark.len()).position(|w| w == mark).unwrap() + mark.len();
    let header = std::str::from_utf8(&bytes[..start]).unwrap();
    assert!(header.contains("binary_little_endian"));
    let count = |what: &str| -> usize {
        header.lines().find_map(|l| l.strip_prefix(&format!("element {what} "))).unwrap().trim().parse().unwrap()
    };
    let (vertices, faces) = bytes[start..].split_at(12 * count("vertex"));
    let float = |b: &[u8]| f64::from(f32::from_le_bytes(b.try_into().unwrap()));
    let index = |b: &[u8]| u32::from_le_bytes(b.try_into().unwrap());
    let vertices = vertices.chunks(12).map(|v| DVec3::new(float(&v[..4]), float(&v[4..8]), float(&v[8..]))).collect();
    assert_eq!(faces.len(), 13 * count("face"));
    let triangles = faces.chunks(13).map(|f| [index(&f[1..5]), index(&f[5..9]), index(&f[9..])]).collect();
    TriMesh { vertices, triangles }
}
