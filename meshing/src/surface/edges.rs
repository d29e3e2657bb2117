//! The edges of a triangle mesh with the triangles on them.

use glam::DVec3;

use super::SurfaceError;
use crate::TriMesh;

/// One side of a triangle: its edge with the smaller vertex first, the triangle, and whether the triangle runs along
/// the edge from the smaller to the larger vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    pub edge: [u32; 2],
    pub triangle: u32,
    pub forward: bool,
}

/// All sides, sorted by edge, then by triangle.
pub(super) struct Edges(Vec<Side>);

impl Edges {
    pub(super) fn of(mesh: &TriMesh) -> Self {
        let mut sides = Vec::with_capacity(3 * mesh.triangles.len());
        for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
            for [u, v] in [[a, b], [b, c], [c, a]] {
                sides.push(Side { edge: [u.min(v), u.max(v)], triangle: t as u32, forward: u < v });
            }
        }
        sides.sort_unstable();
        Self(sides)
    }

    /// The sides of each edge, edge by edge.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[Side]> {
        self.0.chunk_by(|a, b| a.edge == b.edge)
    }

    /// The sides on the edge between `u` and `v`; none if there is no such edge.
    pub(super) fn on(&self, u: u32, v: u32) -> &[Side] {
        let edge = [u.min(v), u.max(v)];
        let start = self.0.partition_point(|s| s.edge < edge);
        let len = self.0[start..].iter().take_while(|s| s.edge == edge).count();
        &self.0[start..start + len]
    }

    /// Refuses edges with more than two triangles.
    pub(super) fn manifold(&self, mesh: &TriMesh) -> Result<(), SurfaceError> {
        let mut crowded = self.iter().filter(|sides| sides.len() > 2).peekable();
        let Some(&first) = crowded.peek() else { return Ok(()) };
        let [u, v] = first[0].edge;
        let at: DVec3 = (mesh.vertices[u as usize] + mesh.vertices[v as usize]) / 2.0;
        let triangles = first.len();
        Err(SurfaceError::NonManifold { edges: crowded.count(), triangles, at })
    }
}
