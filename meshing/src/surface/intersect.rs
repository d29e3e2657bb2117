//! All pairs of triangles of one mesh that meet where they should not.

use glam::DVec3;
use rayon::prelude::*;

use super::{bvh::Bvh, overlap::meeting_point, tidy::is_sliver};
use crate::TriMesh;

/// What [`crossings`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossings {
    /// Number of pairs of triangles that cross or touch beyond common vertices.
    pub pairs: usize,
    /// The first pair in index order.
    pub first: [u32; 2],
    /// A point where the first pair meets.
    pub at: DVec3,
}

/// Tests all pairs whose boxes overlap; `None` if no two triangles meet beyond their common vertices. Triangles flatter
/// than `flat` [m] are left out: they have no inside to cross.
pub(super) fn crossings(mesh: &TriMesh, flat: f64) -> Option<Crossings> {
    let n = mesh.triangles.len();
    let real: Vec<u32> = (0..n as u32).filter(|&t| !is_sliver(mesh.corners(t as usize), flat)).collect();
    if real.is_empty() {
        return None;
    }
    let bvh = Bvh::new(mesh, real.clone());
    let of_triangle = |&s: &u32| {
        let (mut count, mut first) = (0, None::<(u32, DVec3)>);
        bvh.for_each_near(s as usize, |t| {
            if t <= s {
                return;
            }
            let (a, b) = (mesh.triangles[s as usize], mesh.triangles[t as usize]);
            if let Some(at) = meeting_point(&mesh.vertices, a, b) {
                count += 1;
                if first.is_none_or(|(other, _)| t < other) {
                    first = Some((t, at));
                }
            }
        });
        first.map(|(t, at)| Crossings { pairs: count, first: [s, t], at })
    };
    let each: Vec<Option<Crossings>> = real.par_iter().with_min_len(256).map(of_triangle).collect();
    each.into_iter().flatten().reduce(|a, b| Crossings { pairs: a.pairs + b.pairs, ..a })
}
