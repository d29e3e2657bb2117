//! The project's own scenes, run short, and what is measured of them: pieces, crack faces, displacements.

use std::path::PathBuf;

use fissure_io::frames::Frame;
use fissure_io::scene::Scene;
use fissure_io::simulation::Simulation;
use fissure_meshing::crack::{GLUED, SEPARATED};
use fissure_meshing::tetmesh::FACES;
use glam::DVec3;

/// The scene `name` of the project at its start, with `sets` as `--set` takes them.
pub fn build(name: &str, sets: &[&str]) -> Simulation {
    let scenes = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let overrides: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    let scene = Scene::load(&scenes.join(name).with_extension("toml"), &overrides).unwrap_or_else(|e| panic!("{e}"));
    let simulation = Simulation::build(&scene, &fissure_materials::registry(), &mut |_| ());
    let simulation = simulation.unwrap_or_else(|e| panic!("{e}"));
    let world = &simulation.world;
    println!(
        "{name} {sets:?}: {} particles, {} bonds, dt {:.2e} s",
        world.particles.len(),
        world.bond_counts().0 / 2,
        world.dt
    );
    simulation
}

/// Steps until `time` [s].
pub fn run(simulation: &mut Simulation, time: f64) {
    while simulation.world.time < time - 0.5 * simulation.world.dt {
        simulation.step().unwrap_or_else(|e| panic!("{e}"));
    }
}

/// Sizes in particles, largest first, of what glued faces hold together: the fragments that a picture shows.
pub fn fragments(simulation: &Simulation) -> Vec<usize> {
    let (piece, count) = simulation.fragments();
    sizes(&piece, count)
}

/// For each particle of body `k` the number of the piece to which intact bonds hold it, and how many pieces there are.
pub fn bonded_pieces(simulation: &Simulation, k: usize) -> (Vec<u32>, usize) {
    let bonds = simulation.world.bodies[k].material.bonds().expect("a body of bonds");
    flood(bonds.rows(), |_| true, |i, visit| bonds.slots(i).for_each(|slot| visit(bonds.neighbours[slot] as usize)))
}

/// Sizes, largest first, of the connected regions of body `k` in which every particle is damaged by at least `least`,
/// joined through faces, glued or not: the cracks.
pub fn cracks(simulation: &Simulation, k: usize, least: f32) -> Vec<Vec<usize>> {
    let damage = &simulation.world.particles.damage[simulation.world.bodies[k].range.clone()];
    let neighbours = simulation.meshes[k].tets().expect("a body of bonds").mesh.neighbours();
    let near = |i: usize, visit: &mut dyn FnMut(usize)| {
        neighbours[i].iter().filter(|&&n| n != u32::MAX).for_each(|&n| visit(n as usize));
    };
    let (piece, count) = flood(damage.len(), |i| damage[i] >= least, near);
    let mut regions = vec![Vec::new(); count];
    (0..damage.len()).filter(|&i| piece[i] != u32::MAX).for_each(|i| regions[piece[i] as usize].push(i));
    regions.sort_by_key(|r| std::cmp::Reverse(r.len()));
    regions
}

/// A face whose bond is broken, at rest.
#[derive(Clone, Copy, Debug)]
pub struct CrackFace {
    /// Middle [m], in the world.
    pub centre: DVec3,
    /// Unit normal, to either side.
    pub normal: DVec3,
    /// Area [m²].
    pub area: f64,
    /// Whether it is open: a vertex of it has split.
    pub open: bool,
}

/// The crack faces of body `k`, each once.
pub fn crack_faces(simulation: &Simulation, k: usize) -> Vec<CrackFace> {
    let mesh = &simulation.meshes[k].tets().expect("a body of bonds").mesh;
    let mut faces = Vec::new();
    for (t, tet) in mesh.tets().iter().enumerate() {
        for (f, corners) in FACES.iter().enumerate() {
            if mesh.status(t, f) == GLUED || mesh.neighbours()[t][f] < t as u32 {
                continue;
            }
            let [a, b, c] = corners.map(|v| mesh.rest_position(tet[v]));
            let across = (b - a).cross(c - a) / 2.0;
            faces.push(CrackFace {
                centre: (a + b + c) / 3.0,
                normal: across.normalize_or_zero(),
                area: across.length(),
                open: mesh.status(t, f) == SEPARATED,
            });
        }
    }
    faces
}

/// Shares of the area of `faces` by the angle of their normals in the plane of the unit vectors `x` and `y`, from `x`
/// towards `y`, in even bins from 0° to 180°. A normal counts by its length in the plane.
pub fn angles(faces: &[CrackFace], x: DVec3, y: DVec3, bins: usize) -> Vec<f64> {
    let mut shares = vec![0.0; bins];
    for face in faces {
        let (a, b) = (face.normal.dot(x), face.normal.dot(y));
        let turn = b.atan2(a).rem_euclid(std::f64::consts::PI) / std::f64::consts::PI;
        shares[((turn * bins as f64) as usize).min(bins - 1)] += face.area * a.hypot(b);
    }
    let total: f64 = shares.iter().sum();
    shares.iter_mut().for_each(|s| *s /= total.max(f64::MIN_POSITIVE));
    shares
}

/// How many times more area is within 30° of the angle 30° than at right angles to it, by nine bins of [`angles`].
pub fn around_30(shares: &[f64]) -> f64 {
    shares[..3].iter().sum::<f64>() / 3.0 / ((shares[5] + shares[6]) / 2.0)
}

/// Place at rest [m] and displacement [m] of every particle of body `k`.
pub fn displacements(simulation: &Simulation, k: usize) -> Vec<(DVec3, DVec3)> {
    let (body, p) = (&simulation.world.bodies[k], &simulation.world.particles);
    body.range
        .clone()
        .map(|i| {
            let rest = body.origin + p.rest[i].as_dvec3();
            (rest, p.position[i] - rest)
        })
        .collect()
}

/// Every edge of the surface is shared by as many triangles one way as the other.
///
/// # Panics
/// With `what`, where it is open.
pub fn assert_closed(frame: &Frame, what: &str) {
    let key = |v: u32| frame.positions[v as usize].map(f32::to_bits);
    let mut edges: Vec<([[u32; 3]; 2], i32)> = Vec::new();
    for t in &frame.triangles {
        for k in 0..3 {
            let (a, b) = (key(t[k]), key(t[(k + 1) % 3]));
            // an edge may be shorter than f32 can tell: then its ends are one point, with nothing open between them
            if a != b {
                edges.push(if a < b { ([a, b], 1) } else { ([b, a], -1) });
            }
        }
    }
    edges.sort_unstable();
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        assert_eq!(same.iter().map(|e| e.1).sum::<i32>(), 0, "{what}: open at {:?}", same[0].0);
    }
}

/// Numbers the connected parts of those of 0 .. `n` that `joins`; `u32::MAX` for the others.
fn flood(n: usize, joins: impl Fn(usize) -> bool, near: impl Fn(usize, &mut dyn FnMut(usize))) -> (Vec<u32>, usize) {
    let (mut piece, mut count, mut stack) = (vec![u32::MAX; n], 0, Vec::new());
    for first in 0..n {
        if piece[first] != u32::MAX || !joins(first) {
            continue;
        }
        piece[first] = count;
        stack.push(first);
        while let Some(i) = stack.pop() {
            near(i, &mut |j| {
                if piece[j] == u32::MAX && joins(j) {
                    piece[j] = count;
                    stack.push(j);
                }
            });
        }
        count += 1;
    }
    (piece, count as usize)
}

fn sizes(piece: &[u32], count: usize) -> Vec<usize> {
    let mut sizes = vec![0; count];
    piece.iter().for_each(|&p| sizes[p as usize] += 1);
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    sizes
}
