//! The promises of the mesher on simple bodies and, where they are at hand, on scans.

use super::*;
use crate::quality::boundary;
use std::time::Instant;

/// Meshes a surface, prints a line, and asserts what is promised for every surface.
fn promised(name: &str, surface: &TriMesh, options: &Options) -> (TetMesh, Report) {
    let start = Instant::now();
    let (mesh, r) = tetrahedralise(surface, options).unwrap_or_else(|e| panic!("{name}: {e}"));
    println!(
        "{name:14} {:6} tets  angles {:.1}..{:.1}  edge/size {:.3}  volume {:.4}  surface->mesh {:.3}  mesh->surface {:.3}  cubic {:+.2} %  {:.2} s",
        r.tets,
        r.min_dihedral,
        r.max_dihedral,
        r.mean_edge / options.size,
        r.volume_ratio.unwrap_or(f64::NAN),
        r.surface_to_mesh.sizes,
        r.mesh_to_surface.sizes,
        100.0 * r.cubic,
        start.elapsed().as_secs_f64(),
    );
    for w in &r.warnings {
        println!("    {w}");
    }
    assert!(r.min_dihedral >= MIN_DIHEDRAL, "{name}: {}", r.min_dihedral); // measured 10.4 on the armadillo, 16.0 elsewhere
    assert!((0..mesh.tets.len()).all(|t| mesh.volume(t) > 0.0), "{name}");
    assert_eq!(boundary_flaws(&mesh), (0, 0), "{name}");
    // measured 0.88 to 1.01; 0.71 and more where smaller elements were taken, which the report says
    assert!((r.mean_edge / r.size - 1.0).abs() < if r.warnings.is_empty() { 0.2 } else { 0.4 }, "{name}");
    (mesh, r)
}

/// As [`promised`], and close to the surface with as many holes.
fn faithful(name: &str, surface: &TriMesh, options: &Options) -> (TetMesh, Report) {
    let (mesh, r) = promised(name, surface, options);
    assert!(r.hausdorff().sizes <= MAX_DEVIATION, "{name}: {:?}", r.hausdorff());
    assert_eq!(r.euler, crate::quality::euler(&surface.triangles), "{name}");
    assert!(r.warnings.is_empty(), "{name}: {:?}", r.warnings);
    (mesh, r)
}

/// Boundary edges that don't have two triangles, and boundary vertices whose triangles don't form one fan.
pub(super) fn boundary_flaws(mesh: &TetMesh) -> (usize, usize) {
    let surface = TriMesh { vertices: mesh.vertices.clone(), triangles: crate::quality::boundary(mesh) };
    let edges = features::edges(&surface);
    let bad_edges = edges.chunk_by(|a, b| a.0 == b.0).filter(|e| e.len() != 2 || e[0].2 == e[1].2).count();
    let mut next: std::collections::BTreeMap<u32, Vec<(u32, u32)>> = Default::default();
    for t in &surface.triangles {
        for k in 0..3 {
            next.entry(t[k]).or_default().push((t[(k + 1) % 3], t[(k + 2) % 3]));
        }
    }
    let bad_vertices = next
        .values()
        .filter(|fan| {
            let mut at = fan[0].1;
            let mut steps = 1;
            while at != fan[0].0 && steps <= fan.len() {
                match fan.iter().find(|f| f.0 == at) {
                    Some(f) => at = f.1,
                    None => return true,
                }
                steps += 1;
            }
            steps != fan.len()
        })
        .count();
    (bad_edges, bad_vertices)
}

pub(super) fn read_ply(path: &std::path::Path) -> TriMesh {
    let bytes = std::fs::read(path).unwrap();
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let head = std::str::from_utf8(&bytes[..end]).unwrap();
    let count =
        |what: &str| -> usize { head.lines().find_map(|l| l.strip_prefix(what)).unwrap().trim().parse().unwrap() };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    let float = |at: usize| f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()));
    let int = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let start = end + 12 * vertices;
    TriMesh {
        vertices: (0..vertices)
            .map(|i| end + 12 * i)
            .map(|o| DVec3::new(float(o), float(o + 4), float(o + 8)))
            .collect(),
        triangles: (0..faces).map(|i| start + 13 * i + 1).map(|o| [int(o), int(o + 4), int(o + 8)]).collect(),
    }
}

fn unit() -> TriMesh {
    bodies::cuboid(DVec3::ZERO, DVec3::ONE)
}

pub(super) fn turned(mut surface: TriMesh) -> TriMesh {
    let q = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.8);
    surface.vertices.iter_mut().for_each(|v| *v = q * *v);
    surface
}

/// All corners are vertices, and no point of an edge is farther than `far` from a boundary edge of the mesh.
fn keeps_features(surface: &TriMesh, mesh: &TetMesh, size: f64, far: f64) {
    let features = Features::of(surface, size);
    for c in &features.corners {
        assert!(mesh.vertices.iter().any(|v| v.distance(*c) < 1e-9), "corner {c}");
    }
    let edges = boundary(mesh).into_iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
    let segment = |e: [u32; 2]| e.map(|v| mesh.vertices[v as usize]);
    let tree = crate::distance::Distance::of_triangles(edges.map(segment).map(|[a, b]| [a, b, b]).collect());
    for [a, b] in features.creases {
        for i in 0..=100 {
            let p = a.lerp(b, f64::from(i) / 100.0);
            assert!(tree.distance(p) < far * size, "{p}: {}", tree.distance(p) / size);
        }
    }
}

#[test]
fn a_box_keeps_edges_and_corners() {
    for size in [0.1, 0.25] {
        let (mesh, r) = faithful("box", &unit(), &Options::new(size));
        keeps_features(&unit(), &mesh, size, 0.3);
        assert!((r.volume_ratio.unwrap() - 1.0).abs() < 0.005); // measured 0.001
    }
}

#[test]
fn a_turned_box_is_no_harder() {
    let surface = turned(unit());
    let (mesh, _) = faithful("turned box", &surface, &Options::new(0.1));
    keeps_features(&surface, &mesh, 0.1, 0.3);
}

#[test]
fn a_concave_edge_is_kept() {
    let (mesh, _) = faithful("ell", &bodies::ell(), &Options::new(0.1));
    keeps_features(&bodies::ell(), &mesh, 0.1, 0.35);
}

#[test]
fn a_thin_wall_is_kept() {
    let wall = bodies::cuboid(DVec3::ZERO, DVec3::new(1.0, 1.0, 0.05));
    faithful("wall", &wall, &Options::new(0.02));
    let coarse = bodies::cuboid(DVec3::ZERO, DVec3::new(1.0, 1.0, 0.13));
    faithful("coarse wall", &coarse, &Options::new(0.1));
}

#[test]
fn a_ball_has_no_preferred_axes() {
    let (mesh, r) = faithful("ball", &bodies::ball(4), &Options::new(0.12));
    assert!(r.cubic.abs() < 0.015); // measured 0.005; the body-centred lattice has 0.167
    // inner face normals by direction: 98 bins of equal solid angle on half a sphere
    let (mut bins, mut total) = ([0.0; 98], 0.0);
    let around = mesh.neighbours().unwrap();
    for (t, tet) in mesh.tets.iter().enumerate() {
        for (k, f) in crate::tetmesh::FACES.iter().enumerate() {
            if around[t][k] == u32::MAX {
                continue;
            }
            let [a, b, c] = f.map(|i| mesh.vertices[tet[i] as usize]);
            let mut n = (b - a).cross(c - a).normalize();
            if n.z < 0.0 {
                n = -n;
            }
            let turn = (n.y.atan2(n.x) / std::f64::consts::TAU + 0.5).min(0.999_999);
            bins[((n.z * 7.0) as usize).min(6) * 14 + (turn * 14.0) as usize] += 1.0;
            total += 1.0;
        }
    }
    let mean = total / 98.0;
    let spread = (bins.iter().map(|b| (b / mean - 1.0f64).powi(2)).sum::<f64>() / 98.0).sqrt();
    let highest = bins.iter().fold(0.0f64, |m, b| m.max(b / mean));
    println!("    directions: spread {spread:.3}, highest {highest:.3}, {mean:.0} faces a bin");
    assert!(spread < 0.2 && highest < 1.6); // measured 0.11 and 1.21; a lattice fills six directions only
}

#[test]
fn same_bits_on_any_number_of_threads() {
    let run = |surface: &TriMesh, size: f64, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| tetrahedralise(surface, &Options::new(size)).unwrap())
    };
    // a spike needs smaller elements at its tip
    let spike = bodies::cone(0.1, 1.0, 48);
    let size = size_for(&spike, 2000);
    assert!(run(&spike, size, 1) == run(&spike, size, 3));
    let (one, three) = (run(&bodies::ell(), 0.15, 1), run(&bodies::ell(), 0.15, 3));
    assert!(one == three);
    let other = tetrahedralise(&bodies::ell(), &Options { seed: 1, ..Options::new(0.15) }).unwrap();
    assert!(one.0 != other.0);
}

#[test]
fn a_shell_is_a_wall_of_its_thickness() {
    let sheet = TriMesh {
        vertices: vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    for (name, surface, size) in [("open shell", sheet, 0.05), ("ball shell", bodies::ball(3), 0.1)] {
        let thickness = 0.1;
        let options = Options { shell: Some(thickness), ..Options::new(size) };
        let (_, r) = promised(name, &surface, &options);
        let expected = surface.area() * thickness;
        assert!((r.volume / expected - 1.0).abs() < 0.2, "{name} {}", r.volume / expected); // round rims: 1.15
        assert!(r.hausdorff().sizes <= MAX_DEVIATION, "{name}: {:?}", r.hausdorff());
    }
}

#[test]
fn a_part_that_is_lost_is_named() {
    let mut surface = unit();
    let spike = bodies::cuboid(DVec3::new(1.5, 0.4, 0.4), DVec3::new(2.5, 0.41, 0.41));
    surface.triangles.extend(spike.triangles.iter().map(|t| t.map(|v| v + 8)));
    surface.vertices.extend(spike.vertices);
    let (_, r) = promised("lost spike", &surface, &Options::new(0.2));
    assert!(r.surface_to_mesh.sizes > 1.0 && r.surface_to_mesh.at.x > 1.4);
    assert!(r.warnings.iter().any(|w| w.contains("was lost near")), "{:?}", r.warnings);
}

#[test]
fn bad_input_is_named() {
    let error = |surface: &TriMesh, options: Options| tetrahedralise(surface, &options).unwrap_err();
    let mut open = unit();
    open.triangles.pop();
    assert!(matches!(
        error(&open, Options::new(0.1)),
        MeshError::Open { forward: 0, backward: 1, .. } | MeshError::Open { forward: 1, backward: 0, .. }
    ));
    let mut inverted = unit();
    inverted.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert!(
        matches!(error(&inverted, Options::new(0.1)), MeshError::InsideOut { volume } if (volume + 1.0).abs() < 1e-12)
    );
    let mut broken = unit();
    broken.vertices[3].y = f64::NAN;
    assert_eq!(error(&broken, Options::new(0.1)), MeshError::Vertex { vertex: 3 });
    let mut astray = unit();
    astray.triangles[5][1] = 99;
    assert_eq!(error(&astray, Options::new(0.1)), MeshError::Index { triangle: 5 });
    assert_eq!(error(&TriMesh::default(), Options::new(0.1)), MeshError::Empty);
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(error(&unit(), Options::new(size)), MeshError::Number(_)));
    }
    assert!(matches!(error(&unit(), Options { shell: Some(0.0), ..Options::new(0.1) }), MeshError::Number(_)));
    assert!(matches!(error(&unit(), Options::new(1e-4)), MeshError::TooFine { tets, .. } if tets > 1e12));
    let thin = bodies::cuboid(DVec3::ZERO, DVec3::new(1.0, 1.0, 0.01));
    assert!(matches!(error(&thin, Options::new(0.1)), MeshError::TooCoarse { advice, .. } if advice < 0.02));
    let shell = Options { shell: Some(0.02), ..Options::new(0.1) };
    assert!(
        matches!(error(&unit(), shell), MeshError::ThinShell { advice, .. } if (advice - 0.02 / LAYERS).abs() < 1e-9)
    );
    assert!(
        matches!(error(&unit(), Options::new(40.0)), MeshError::TooCoarse { advice, .. } if advice > 0.05 && advice <= 0.5)
    );
}

#[test]
fn size_for_meets_the_wanted_number() {
    let surface = bodies::ball(4);
    let (mesh, _) = promised("ball", &surface, &Options::new(size_for(&surface, 8000)));
    assert!((mesh.tets.len() as f64 / 8000.0 - 1.0).abs() < 0.12); // measured 0.01
    assert!(size_for(&TriMesh::default(), 100).is_nan());
}

#[test]
fn scans_keep_the_promises() {
    let Some(folder) = std::env::var_os("FISSURE_MESHES") else {
        println!("FISSURE_MESHES is not set: skipped");
        return;
    };
    let folder = std::path::Path::new(&folder).join("surface");
    for name in ["bunny_5k", "spot_3k", "elephant_6k", "bunny_1.5k", "armadillo_8k"] {
        let surface = read_ply(&folder.join(format!("{name}.ply")));
        let (mesh, r) = promised(name, &surface, &Options::new(size_for(&surface, 20_000)));
        let more = mesh.tets.len() as f64 / 2e4;
        assert!((0.92..1.08).contains(&more) || (!r.warnings.is_empty() && more < 2.2), "{name}"); // measured 0.04
        assert!(r.hausdorff().sizes <= MAX_DEVIATION, "{name}: {:?}", r.hausdorff());
        assert_eq!(r.euler, crate::quality::euler(&surface.triangles), "{name}");
    }
}

#[test]
#[ignore = "five seconds and more: run with --ignored and FISSURE_MESHES"]
fn three_hundred_thousand_in_a_few_seconds() {
    let Some(folder) = std::env::var_os("FISSURE_MESHES") else {
        println!("FISSURE_MESHES is not set: skipped");
        return;
    };
    let surface = read_ply(&std::path::Path::new(&folder).join("surface/bunny_5k.ply"));
    let start = Instant::now();
    let (mesh, _) = faithful("bunny_5k", &surface, &Options::new(size_for(&surface, 300_000)));
    assert!(mesh.tets.len() > 280_000);
    assert!(start.elapsed().as_secs_f64() < 30.0); // 4.5 s on a shared machine
}
