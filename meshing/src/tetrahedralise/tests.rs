//! Meshes of simple bodies and, where they are at hand, of scans.

use super::*;
use std::time::Instant;

/// What a line of the table says.
fn show(name: &str, surface: &TriMesh, size: f64) -> (TetMesh, Report) {
    let start = Instant::now();
    let (mesh, r) = tetrahedralise(surface, &Options::new(size)).unwrap_or_else(|e| panic!("{name}: {e}"));
    println!(
        "{name:16} {:7} tets  dihedral {:5.1}..{:5.1}  edge/size {:.3}  vol {:.4}  s->m {:.3}  m->s {:.3}  cubic {:+.2}%  {:.2}s",
        r.tets, r.min_dihedral, r.max_dihedral, r.mean_edge / size, r.volume_ratio.unwrap_or(0.0), r.surface_to_mesh.sizes,
        r.mesh_to_surface.sizes, 100.0 * r.cubic, start.elapsed().as_secs_f64(),
    );
    println!("    area/h2 {:.1} volume/h3 {:.1} tets {}", surface.area() / size.powi(2), surface.volume() / size.powi(3), r.tets);
    println!("    s->m at {:.3} m->s at {:.3}; {:?} euler {} of {}", r.surface_to_mesh.at, r.mesh_to_surface.at, boundary_flaws(&mesh), euler(&crate::quality::boundary(&mesh)), euler(&surface.triangles));
    (mesh, r)
}

fn euler(triangles: &[[u32; 3]]) -> i64 {
    let mut v: Vec<u32> = triangles.iter().flatten().copied().collect();
    v.sort_unstable();
    v.dedup();
    v.len() as i64 - triangles.len() as i64 / 2
}

/// Boundary edges that don't have two triangles, and boundary vertices whose triangles don't form one fan.
fn boundary_flaws(mesh: &TetMesh) -> (usize, usize) {
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

fn read_ply(path: &std::path::Path) -> TriMesh {
    let bytes = std::fs::read(path).unwrap();
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let head = std::str::from_utf8(&bytes[..end]).unwrap();
    let count = |what: &str| -> usize {
        head.lines().find_map(|l| l.strip_prefix(what)).unwrap().trim().parse().unwrap()
    };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    let float = |at: usize| f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()));
    let int = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let start = end + 12 * vertices;
    TriMesh {
        vertices: (0..vertices).map(|i| end + 12 * i).map(|o| DVec3::new(float(o), float(o + 4), float(o + 8))).collect(),
        triangles: (0..faces).map(|i| start + 13 * i + 1).map(|o| [int(o), int(o + 4), int(o + 8)]).collect(),
    }
}

fn turned(mut surface: TriMesh) -> TriMesh {
    let q = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.8);
    surface.vertices.iter_mut().for_each(|v| *v = q * *v);
    surface
}

#[test]
fn probe_simple() {
    let unit = bodies::cuboid(DVec3::ZERO, DVec3::ONE);
    show("box .1", &unit, 0.1);
    show("box .25", &unit, 0.25);
    show("turned box .1", &turned(unit), 0.1);
    show("ball .15", &bodies::ball(4), 0.15);
    show("ell .1", &bodies::ell(), 0.1);
    show("wall .02", &bodies::cuboid(DVec3::ZERO, DVec3::new(1.0, 1.0, 0.05)), 0.02);
}

#[test]
fn probe_scans() {
    let Some(folder) = std::env::var_os("FISSURE_MESHES") else {
        println!("FISSURE_MESHES is not set: skipped");
        return;
    };
    let folder = std::path::Path::new(&folder).join("surface");
    let only = std::env::var("ONLY").unwrap_or_default();
    for (name, tets) in [("bunny_5k", 20_000), ("spot_3k", 20_000), ("armadillo_8k", 20_000), ("elephant_6k", 20_000), ("bunny_1.5k", 20_000), ("bunny_5k", 300_000)] {
        if !format!("{name}:{tets}").contains(&only) {
            continue;
        }
        let surface = read_ply(&folder.join(format!("{name}.ply")));
        let size = size_for(&surface, tets);
        show(name, &surface, size);
    }
}
