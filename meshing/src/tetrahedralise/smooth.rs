//! Vertex moves that raise the worst dihedral angle around a vertex.
//!
//! A pattern search along random directions: the star is small, its quality is a maximum of many smooth pieces, and no
//! derivative is right at the kinks where the optimum sits. Vertices are visited by colour so that no two of one colour
//! share a tetrahedron; one colour is computed in parallel from what the others left, so threads don't change a bit.

use super::complex::{Complex, worst_from};
use glam::DVec3;
use rayon::prelude::*;

/// A small random number generator (splitmix64).
#[derive(Clone, Copy, Debug)]
pub struct Random(pub u64);

impl Random {
    /// A generator for one object among many.
    pub fn of(seed: u64, index: u64) -> Self {
        let mut r = Self(seed ^ index.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        r.next();
        r
    }

    /// The next 64 bits.
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [−1, 1)³.
    pub fn cube(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

/// A better place for vertex `v`, or `None`. `place` says where a wanted position may truly be (onto the surface, say).
pub fn better_place(
    mesh: &Complex,
    v: u32,
    step: f64,
    random: &mut Random,
    place: impl Fn(DVec3) -> Option<DVec3>,
) -> Option<DVec3> {
    let view = mesh.view(v);
    let start = mesh.points[v as usize];
    let first = worst_from(start, &view, -2.0);
    let (mut best, mut at) = (first, start);
    let attempt = |wanted: DVec3, best: &mut f64, at: &mut DVec3| {
        let Some(p) = place(wanted) else { return false };
        let q = worst_from(p, &view, *best + 1e-6);
        let better = q > *best + 1e-6;
        if better {
            (*best, *at) = (q, p);
        }
        better
    };
    let centre = view.iter().flatten().sum::<DVec3>() / (3 * view.len()) as f64;
    if !attempt(centre, &mut best, &mut at) {
        attempt((start + centre) / 2.0, &mut best, &mut at);
    }
    let mut step = step;
    let mut last = DVec3::ZERO;
    for _ in 0..5 {
        let x = random.cube().normalize_or(DVec3::X);
        let y = x.any_orthonormal_vector();
        let z = x.cross(y);
        let mut moved = last != DVec3::ZERO && attempt(at + last, &mut best, &mut at);
        for d in [x, -x, y, -y, z, -z] {
            if attempt(at + d * step, &mut best, &mut at) {
                (last, moved) = (d * step, true);
                break;
            }
        }
        if !moved {
            step *= 0.5;
            last = DVec3::ZERO;
        }
    }
    (best > first + 1e-6).then_some(at)
}

/// Splits vertices into groups whose stars don't overlap, greedily in the given order.
pub fn colours(mesh: &Complex, vertices: &[u32]) -> Vec<Vec<u32>> {
    let mut colour = vec![u8::MAX; mesh.points.len()];
    let mut groups: Vec<Vec<u32>> = Vec::new();
    for &v in vertices {
        let mut taken = [false; 256];
        for &t in mesh.star(v) {
            for w in mesh.tets[t as usize] {
                taken[colour[w as usize] as usize] = true;
            }
        }
        let c = (0..255).find(|&c| !taken[c]).unwrap_or(254);
        colour[v as usize] = c as u8;
        if groups.len() <= c {
            groups.resize(c + 1, Vec::new());
        }
        groups[c].push(v);
    }
    groups
}

/// Moves the given vertices once each; `place(v, p)` as in [`better_place`]. Returns how many moved.
pub fn smooth(
    mesh: &mut Complex,
    vertices: &[u32],
    step: f64,
    seed: u64,
    place: impl Fn(u32, DVec3) -> Option<DVec3> + Sync,
) -> usize {
    let mut moved = 0;
    for group in colours(mesh, vertices) {
        let shared = &*mesh;
        let found: Vec<Option<DVec3>> = group
            .par_iter()
            .with_min_len(16)
            .map(|&v| better_place(shared, v, step, &mut Random::of(seed, u64::from(v)), |p| place(v, p)))
            .collect();
        for (v, p) in group.into_iter().zip(found) {
            if let Some(p) = p {
                mesh.points[v as usize] = p;
                moved += 1;
            }
        }
    }
    moved
}
