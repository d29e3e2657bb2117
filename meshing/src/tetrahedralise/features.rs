//! Sharp edges and corners of a surface, which the mesh must keep.

use crate::TriMesh;
use crate::distance::Distance;
use glam::DVec3;
use std::f64::consts::TAU;

/// Triangles that meet at more than this angle between their normals make a sharp edge.
const SHARP: f64 = 35.0;
/// Chains of sharp edges shorter than this many element sizes are noise of a scan, not a feature.
const CHAIN: f64 = 2.0;
/// A crease that turns by more than this at a vertex has a corner there.
const TURN: f64 = 45.0;
/// A vertex whose triangles fill less than this part of a full turn is a tip.
const TIP: f64 = 0.8;

/// Sharp edges and corners.
#[derive(Default)]
pub struct Features {
    /// Sharp edges as segments [m].
    pub creases: Vec<[DVec3; 2]>,
    /// Corners [m].
    pub corners: Vec<DVec3>,
    tree: Option<Distance>,
}

/// Edges of a surface: end vertices ascending, the triangle, and whether it runs from the smaller to the larger vertex.
pub fn edges(surface: &TriMesh) -> Vec<([u32; 2], u32, bool)> {
    let mut all: Vec<([u32; 2], u32, bool)> = Vec::with_capacity(3 * surface.triangles.len());
    for (t, tri) in surface.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (tri[k], tri[(k + 1) % 3]);
            all.push(([a.min(b), a.max(b)], t as u32, a < b));
        }
    }
    all.sort_unstable();
    all
}

impl Features {
    /// The features of `surface` that matter for elements of `size` [m].
    pub fn of(surface: &TriMesh, size: f64) -> Self {
        let normal = |t: u32| {
            let [a, b, c] = surface.corners(t as usize);
            (b - a).cross(c - a).normalize_or_zero()
        };
        let limit = SHARP.to_radians().cos();
        let mut sharp: Vec<[u32; 2]> = Vec::new();
        for same in edges(surface).chunk_by(|a, b| a.0 == b.0) {
            if let [(e, s, _), (_, t, _)] = same
                && normal(*s).dot(normal(*t)) < limit
            {
                sharp.push(*e);
            }
        }
        let sharp = long_chains(surface, sharp, CHAIN * size);
        let mut around: Vec<Vec<u32>> = vec![Vec::new(); surface.vertices.len()];
        for &[a, b] in &sharp {
            around[a as usize].push(b);
            around[b as usize].push(a);
        }
        let mut filled = vec![0.0; surface.vertices.len()];
        for tri in &surface.triangles {
            for k in 0..3 {
                let [p, q, r] = [0, 1, 2].map(|i| surface.vertices[tri[(k + i) % 3] as usize]);
                filled[tri[k] as usize] += (q - p).angle_between(r - p);
            }
        }
        let place = |v: u32| surface.vertices[v as usize];
        let corners = (0..surface.vertices.len() as u32)
            .filter(|&v| match around[v as usize][..] {
                [] => filled[v as usize] > 0.0 && filled[v as usize] < TIP * TAU && !around_is_noise(surface, size),
                [_] => false,
                [a, b] => (place(a) - place(v)).angle_between(place(v) - place(b)) > TURN.to_radians(),
                _ => true,
            })
            .map(place)
            .collect();
        let creases: Vec<[DVec3; 2]> = sharp.iter().map(|e| e.map(place)).collect();
        let tree =
            (!creases.is_empty()).then(|| Distance::of_triangles(creases.iter().map(|&[a, b]| [a, b, b]).collect()));
        Self { creases, corners, tree }
    }

    /// The nearest point of a sharp edge within `reach` [m].
    pub fn on_crease(&self, p: DVec3, reach: f64) -> Option<DVec3> {
        self.tree.as_ref()?.closest_within(p, reach).map(|c| c.point)
    }
}

/// Whether the triangles are much finer than the elements, so that single sharp vertices can't matter.
fn around_is_noise(surface: &TriMesh, size: f64) -> bool {
    surface.area() < 0.02 * size * size * surface.triangles.len() as f64
}

/// Drops connected groups of edges whose lengths add up to less than `least`.
fn long_chains(surface: &TriMesh, edges: Vec<[u32; 2]>, least: f64) -> Vec<[u32; 2]> {
    let mut root: Vec<u32> = (0..surface.vertices.len() as u32).collect();
    fn find(root: &mut [u32], mut v: u32) -> u32 {
        while root[v as usize] != v {
            root[v as usize] = root[root[v as usize] as usize];
            v = root[v as usize];
        }
        v
    }
    for &[a, b] in &edges {
        let (a, b) = (find(&mut root, a), find(&mut root, b));
        root[a.max(b) as usize] = a.min(b);
    }
    let mut length = vec![0.0; surface.vertices.len()];
    for &[a, b] in &edges {
        length[find(&mut root, a) as usize] += surface.vertices[a as usize].distance(surface.vertices[b as usize]);
    }
    edges.into_iter().filter(|e| length[find(&mut root, e[0]) as usize] >= least).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tetrahedralise::bodies;

    #[test]
    fn a_box_has_its_edges_and_corners() {
        let found = Features::of(&bodies::cuboid(DVec3::ZERO, DVec3::ONE), 0.1);
        assert_eq!((found.creases.len(), found.corners.len()), (12, 8));
        let near = found.on_crease(DVec3::new(0.4, 0.02, 0.03), 0.1).unwrap();
        assert!(near.distance(DVec3::new(0.4, 0.0, 0.0)) < 1e-15);
        assert!(found.on_crease(DVec3::splat(0.5), 0.1).is_none());
    }

    #[test]
    fn a_round_body_has_none() {
        let found = Features::of(&bodies::ball(3), 0.2);
        assert!(found.creases.is_empty() && found.corners.is_empty());
    }
}
