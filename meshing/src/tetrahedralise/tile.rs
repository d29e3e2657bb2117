//! The irregular background: a periodic block of tetrahedra without lattice directions.
//!
//! A body-centred cubic lattice on a torus is molten: random flips and vertex moves that keep every angle above a floor.
//! Then it is annealed by flips and moves that only improve. What is left has no lattice in it (measured: see the
//! tests), while every intermediate state was a valid mesh, so no Delaunay code and no exact predicates are needed.
//! Copies of the block fill space. Tried: moving lattice points only. Face normals then keep the six {110} planes.

use super::complex::{Complex, angle_score, worst_from};
use super::smooth::{Random, smooth};
use crate::tetmesh::FACES;
use glam::DVec3;

/// A block of side `side` whose copies fill space.
pub struct Tile {
    /// Vertices in [0, side)³, in units of the mean edge length.
    pub points: Vec<DVec3>,
    /// Vertices of each tetrahedron.
    pub tets: Vec<[u32; 4]>,
    /// Side of the block in units of the mean edge length.
    pub side: f64,
}

/// Body-centred cubic tetrahedra on a torus of `n`³ cells of side 1: around each edge of the two simple lattices four
/// tetrahedra.
fn lattice(n: usize) -> Complex {
    let wrap = |i: usize| i % n;
    let corner = |x: usize, y: usize, z: usize| ((wrap(x) * n + wrap(y)) * n + wrap(z)) as u32;
    let body = |x: usize, y: usize, z: usize| corner(x, y, z) + (n * n * n) as u32;
    let mut points = Vec::new();
    for shift in [0.0, 0.5] {
        for i in 0..n * n * n {
            points.push(DVec3::new((i / (n * n)) as f64, (i / n % n) as f64, (i % n) as f64) + shift);
        }
    }
    let mut mesh = Complex::new(points, Vec::new(), Some(n as f64));
    for i in 0..n * n * n {
        let c = [i / (n * n), i / n % n, i % n];
        for axis in 0..3 {
            // the face between cells c − e and c, normal to the axis, with its four corners
            let step = |k: usize, by: usize| {
                let mut s = c;
                s[(axis + k) % 3] += by;
                s
            };
            let mut before = c;
            before[axis] += n - 1;
            let (low, high) = (body(before[0], before[1], before[2]), body(c[0], c[1], c[2]));
            let mut far = step(1, 1);
            far[(axis + 2) % 3] += 1;
            let quad = [c, step(1, 1), far, step(2, 1)].map(|s| corner(s[0], s[1], s[2]));
            let tets: Vec<[u32; 4]> = (0..4).map(|k| [low, high, quad[k], quad[(k + 1) % 4]]).collect();
            mesh.replace(&[], &tets);
        }
    }
    mesh
}

/// Tries random flips and moves that keep every angle above `floor` degrees.
fn melt(mesh: &mut Complex, floor: f64, random: &mut Random) {
    let floor_score = angle_score(floor);
    for _ in 0..mesh.tets.len() {
        let t = (random.next() % mesh.tets.len() as u64) as u32;
        if !mesh.alive(t) {
            continue;
        }
        let k = (random.next() % 12) as usize;
        if k < 4 {
            mesh.remove_face(t, k, Some(floor_score));
        } else {
            let [a, b, ..] = pair(mesh.tets[t as usize], k - 4);
            mesh.remove_edge(a, b, Some(floor_score), |_, _| false);
        }
    }
    for v in 0..mesh.points.len() as u32 {
        let wanted = mesh.points[v as usize] + random.cube() * 0.25;
        if worst_from(wanted, &mesh.view(v), floor_score) > floor_score {
            mesh.points[v as usize] = wanted;
        }
    }
}

fn pair(tet: [u32; 4], k: usize) -> [u32; 2] {
    const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    PAIRS[k % 6].map(|i| tet[i])
}

/// Flips everything that improves.
fn anneal(mesh: &mut Complex) -> usize {
    let mut done = 0;
    for t in 0..mesh.tets.len() as u32 {
        for k in 0..6 {
            if mesh.alive(t) {
                let [a, b] = pair(mesh.tets[t as usize], k);
                done += usize::from(mesh.remove_edge(a, b, None, |_, _| false));
            }
        }
        for k in 0..FACES.len() {
            if mesh.alive(t) {
                done += usize::from(mesh.remove_face(t, k, None));
            }
        }
    }
    done
}

impl Tile {
    /// Melts and anneals `n`³ cells.
    pub fn new(n: usize, seed: u64) -> Self {
        let mut mesh = lattice(n);
        let mut random = Random::of(seed, 1);
        for _ in 0..HOT {
            melt(&mut mesh, FLOOR, &mut random);
        }
        let all: Vec<u32> = (0..mesh.points.len() as u32).collect();
        for round in 0..COLD {
            anneal(&mut mesh);
            smooth(&mut mesh, &all, 0.1, seed ^ round, |_, p| Some(p));
        }
        let living: Vec<[u32; 4]> = mesh.living().map(|t| mesh.tets[t as usize]).collect();
        let mut length = 0.0;
        for &tet in &living {
            let c = mesh.corners(tet);
            length +=
                (0..6).map(|k| pair([0, 1, 2, 3], k)).map(|[i, j]| c[i as usize].distance(c[j as usize])).sum::<f64>();
        }
        let mean = length / (6 * living.len()) as f64;
        let period = n as f64;
        let points = mesh.points.iter().map(|p| (p - (p / period).floor() * period) / mean).collect();
        Self { points, tets: living, side: period / mean }
    }
}

/// Sweeps of random change, and the smallest angle they leave [degrees].
const HOT: usize = 14;
const FLOOR: f64 = 5.0;
/// Sweeps of improvement.
const COLD: u64 = 7;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lattice_fills_the_torus() {
        let mesh = lattice(4);
        let size = |t: &[u32; 4]| {
            let [a, b, c, d] = mesh.corners(*t);
            (b - a).dot((c - a).cross(d - a)) / 6.0
        };
        let volume: f64 = mesh.tets.iter().map(size).sum();
        assert_eq!(mesh.tets.len(), 12 * 64);
        assert!((volume - 64.0).abs() < 1e-9);
        assert!((mesh.worst(&mesh.living().collect::<Vec<_>>()) - angle_score(60.0)).abs() < 1e-9);
    }

    #[test]
    fn the_tile_has_good_angles_and_no_preferred_axes() {
        let tile = Tile::new(8, 1);
        let mesh = Complex::new(tile.points.clone(), tile.tets.clone(), Some(tile.side));
        let all: Vec<u32> = mesh.living().collect();
        let mut volume = 0.0;
        let (mut quartic, mut tensor, mut count) = (0.0, glam::DMat3::ZERO, 0.0);
        for &tet in &tile.tets {
            let c = mesh.corners(tet);
            volume += (c[1] - c[0]).cross(c[2] - c[0]).dot(c[3] - c[0]) / 6.0;
            for f in FACES {
                let n = (c[f[1]] - c[f[0]]).cross(c[f[2]] - c[f[0]]).normalize();
                quartic += (n * n).length_squared();
                tensor += glam::DMat3::from_cols(n * n.x, n * n.y, n * n.z);
                count += 1.0;
            }
        }
        println!(
            "worst {:.1} cubic {:.4} tensor {}",
            (-mesh.worst(&all)).acos().to_degrees(),
            quartic / count / 0.6 - 1.0,
            tensor * (3.0 / count)
        );
        assert!((volume / tile.side.powi(3) - 1.0).abs() < 1e-9);
        assert!(mesh.worst(&all) > angle_score(20.0)); // measured 28.3
        assert!((quartic / count / 0.6 - 1.0).abs() < 0.015); // measured 0.004; the lattice has 0.167
        let thirds = tensor * (3.0 / count);
        assert!((thirds - glam::DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 0.03)); // measured 0.0135
    }
}
