//! Meshes for the tests of this crate: Kuhn lattices, and the project's TetGen files.

use crate::TetMesh;
use glam::DVec3;

/// A number in [0, 1) that depends on `seed` only (splitmix64).
pub(crate) fn random(seed: u64) -> f64 {
    let mut z = seed.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
}

/// A lattice of unit cubes, those whose lower corner `takes` accepts, six tetrahedra each. Vertices are moved by
/// `jitter` times a random part of the spacing, those on the faces of the lattice not across them.
pub(crate) fn kuhn(n: [usize; 3], jitter: f64, takes: impl Fn([usize; 3]) -> bool) -> TetMesh {
    const PATHS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let at = |c: [usize; 3]| (c[0] + (n[0] + 1) * (c[1] + (n[1] + 1) * c[2])) as u32;
    let mut mesh = TetMesh::default();
    for z in 0..=n[2] {
        for y in 0..=n[1] {
            for x in 0..=n[0] {
                let cell = [x, y, z];
                let shift = |k: usize| {
                    let free = cell[k] > 0 && cell[k] < n[k];
                    if free { jitter * (random((3 * at(cell) as usize + k) as u64) - 0.5) } else { 0.0 }
                };
                mesh.vertices.push(DVec3::new(x as f64 + shift(0), y as f64 + shift(1), z as f64 + shift(2)));
                if x == n[0] || y == n[1] || z == n[2] || !takes(cell) {
                    continue;
                }
                for (p, path) in PATHS.iter().enumerate() {
                    let mut corner = cell;
                    let mut tet = [at(corner); 4];
                    for (k, &axis) in path.iter().enumerate() {
                        corner[axis] += 1;
                        tet[k + 1] = at(corner);
                    }
                    if p >= 3 {
                        tet.swap(2, 3);
                    }
                    mesh.tets.push(tet);
                }
            }
        }
    }
    mesh
}

/// A well-rounded cube, 2 wide, convex, of `8 n³ · 6` tetrahedra: the lattice's shells drawn most of the way to spheres
/// (on a sphere, tetrahedra at the edges of the cube would be flat).
pub(crate) fn ball(n: usize) -> TetMesh {
    let mut mesh = kuhn([2 * n; 3], 0.1, |_| true);
    for v in &mut mesh.vertices {
        let x = *v / n as f64 - DVec3::ONE;
        let length = x.length();
        *v = if length > 0.0 { x * (0.3 + 0.7 * x.abs().max_element() / length) } else { x };
    }
    mesh
}

/// Particles of a mesh.
pub(crate) fn barycentres(mesh: &TetMesh) -> Vec<DVec3> {
    (0..mesh.tets.len()).map(|t| mesh.barycentre(t)).collect()
}

/// Reads `tet/<name>.node` and `.ele` below the folder that FISSURE_MESHES names, both 0-based and in order; `None`,
/// with a line printed, if it names none.
pub(crate) fn tetgen(name: &str) -> Option<TetMesh> {
    let Some(folder) = std::env::var_os("FISSURE_MESHES") else {
        println!("skipped: FISSURE_MESHES is not set, so there is no {name}");
        return None;
    };
    let rows = |extension: &str| -> Vec<Vec<f64>> {
        let path = std::path::Path::new(&folder).join("tet").join(format!("{name}.{extension}"));
        let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let lines = text.lines().filter(|l| !l.starts_with('#') && !l.trim().is_empty());
        lines.skip(1).map(|l| l.split_whitespace().skip(1).map(|n| n.parse().unwrap()).collect()).collect()
    };
    let vertices = rows("node").iter().map(|r| DVec3::new(r[0], r[1], r[2])).collect();
    let mut mesh = TetMesh { vertices, tets: rows("ele").iter().map(|r| [0, 1, 2, 3].map(|k| r[k] as u32)).collect() };
    for t in 0..mesh.tets.len() {
        if mesh.volume(t) < 0.0 {
            mesh.tets[t].swap(2, 3);
        }
    }
    Some(mesh)
}

#[test]
fn lattices_fill_their_box_and_the_ball_is_round() {
    let mesh = kuhn([4, 3, 2], 0.5, |_| true);
    assert!((0..mesh.tets.len()).all(|t| mesh.volume(t) > 0.01));
    assert!(((0..mesh.tets.len()).map(|t| mesh.volume(t)).sum::<f64>() - 24.0).abs() < 1e-12);
    let ball = ball(5);
    let volume: f64 = (0..ball.tets.len()).map(|t| ball.volume(t)).sum();
    assert!((0..ball.tets.len()).all(|t| ball.volume(t) > 0.0));
    assert!((4.19..6.0).contains(&volume), "between a ball of 4.19 and a cube of 8: {volume}");
}
