//! A triangle mesh in memory: what surface readers return and the tetrahedraliser takes.

use glam::DVec3;

/// Triangles over shared vertices, counter-clockwise seen from outside. Lengths in metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertex positions [m].
    pub vertices: Vec<DVec3>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// The three corners of triangle `t`.
    pub fn corners(&self, t: usize) -> [DVec3; 3] {
        self.triangles[t].map(|v| self.vertices[v as usize])
    }

    /// Smallest and largest corner of the axis-aligned bounding box; `None` without vertices.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        bounds(&self.vertices)
    }

    /// Signed volume [m³]: positive if closed and wound outwards.
    pub fn volume(&self) -> f64 {
        (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    /// Surface area [m²].
    pub fn area(&self) -> f64 {
        (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t);
                (b - a).cross(c - a).length() / 2.0
            })
            .sum()
    }
}

/// Smallest and largest corner of the axis-aligned box around `points`; `None` if there are none.
pub(crate) fn bounds(points: &[DVec3]) -> Option<(DVec3, DVec3)> {
    let first = *points.first()?;
    Some(points.iter().fold((first, first), |(lo, hi), &p| (lo.min(p), hi.max(p))))
}
