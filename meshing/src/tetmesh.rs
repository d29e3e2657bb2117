//! A tetrahedral mesh in memory.

use glam::DVec3;

/// The four faces of a tetrahedron as local vertex numbers, wound outwards for positive volume; face `k` is opposite
/// vertex `k`.
pub const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// Tetrahedra over shared vertices, each with positive volume (vertex 3 on the left of triangle 0-1-2 seen from
/// outside, so that det(b−a, c−a, d−a) > 0). Lengths in metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TetMesh {
    /// Vertex positions [m].
    pub vertices: Vec<DVec3>,
    /// Vertex indices of each tetrahedron.
    pub tets: Vec<[u32; 4]>,
}

impl TetMesh {
    /// The four corners of tetrahedron `t`.
    pub fn corners(&self, t: usize) -> [DVec3; 4] {
        self.tets[t].map(|v| self.vertices[v as usize])
    }

    /// Signed volume of tetrahedron `t` [m³].
    pub fn volume(&self, t: usize) -> f64 {
        let [a, b, c, d] = self.corners(t);
        (b - a).dot((c - a).cross(d - a)) / 6.0
    }

    /// Barycentre of tetrahedron `t` [m].
    pub fn barycentre(&self, t: usize) -> DVec3 {
        let [a, b, c, d] = self.corners(t);
        (a + b + c + d) / 4.0
    }

    /// Mean length of the edges [m], each edge counted once; 0 without tetrahedra. λ of Table 1.
    pub fn mean_edge(&self) -> f64 {
        const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
        let mut edges: Vec<[u32; 2]> =
            self.tets.iter().flat_map(|t| PAIRS.map(|[i, j]| [t[i].min(t[j]), t[i].max(t[j])])).collect();
        edges.sort_unstable();
        edges.dedup();
        let length = |[i, j]: &[u32; 2]| self.vertices[*i as usize].distance(self.vertices[*j as usize]);
        if edges.is_empty() { 0.0 } else { edges.iter().map(length).sum::<f64>() / edges.len() as f64 }
    }

    /// Smallest and largest corner of the axis-aligned bounding box; `None` without vertices.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        crate::trimesh::bounds(&self.vertices)
    }

    /// For each tetrahedron and face `k` the tetrahedron on the other side, or `u32::MAX` on the boundary.
    ///
    /// # Errors
    /// The three vertices of a face that more than two tetrahedra share.
    pub fn neighbours(&self) -> Result<Vec<[u32; 4]>, [u32; 3]> {
        let mut faces: Vec<([u32; 3], u32, u8)> = Vec::with_capacity(4 * self.tets.len());
        for (t, tet) in self.tets.iter().enumerate() {
            for (k, face) in FACES.iter().enumerate() {
                let mut key = face.map(|v| tet[v]);
                key.sort_unstable();
                faces.push((key, t as u32, k as u8));
            }
        }
        faces.sort_unstable();
        let mut out = vec![[u32::MAX; 4]; self.tets.len()];
        for same in faces.chunk_by(|a, b| a.0 == b.0) {
            match same {
                [_] => {}
                [(_, s, k), (_, t, l)] => {
                    out[*s as usize][*k as usize] = *t;
                    out[*t as usize][*l as usize] = *s;
                }
                _ => return Err(same[0].0),
            }
        }
        Ok(out)
    }
}
