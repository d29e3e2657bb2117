//! The embedded mesh that splits along cracks (Chen et al., Sec. 5.2).
//!
//! When the bond between face neighbours breaks, their face joins the crack set. Each vertex of a new crack face is
//! looked at: its tetrahedra fall into groups that are joined by glued faces around it, and if there is more than one
//! group, the vertex splits into as many copies. Faces whose two sides then differ in a vertex have led to a split and
//! leave the set; the others stay in it, closed, until cracks around them are complete.
//!
//! The faces of all tetrahedra together are a closed surface, and a face that is glued or only in the set has the
//! same three vertices on both sides, so the outside faces and the separated ones are closed at every moment. Two
//! groups around a vertex never share it (vertices pinched in the input are split at the start), so fragments share
//! no vertex either.

mod split;
mod stars;
mod surface;

use split::Scratch;
pub use split::Split;
pub use stars::Stars;
pub(crate) use surface::shaded;
pub use surface::{Smoothing, Surface};

use fissure_engine::buffer::Buffer;
use fissure_engine::column::{Column, Of, Visitor};
use glam::DVec3;
use thiserror::Error;

use crate::TetMesh;

/// The face is whole, or an outside face of the input.
pub const GLUED: u8 = 0;
/// The bond through the face is broken, but no vertex of it has split: it is in the crack set.
pub const CRACKED: u8 = 1;
/// The two sides differ in a vertex: both are part of the surface.
pub const SEPARATED: u8 = 2;

const NONE: u32 = u32::MAX;

/// Why a mesh cannot be followed.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum CrackError {
    /// A face of more than two tetrahedra.
    #[error(
        "more than two tetrahedra share the face of vertices {0:?}; mend the mesh so that every face has at most two"
    )]
    CrowdedFace([u32; 3]),
    /// A tetrahedron names a vertex that does not exist.
    #[error("tetrahedron {tet} names vertex {vertex}, but there are only {vertices} vertices; mend the mesh")]
    NoVertex {
        /// The tetrahedron.
        tet: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
}

/// A tetrahedral mesh whose vertices split where its faces crack. Tetrahedron numbers never change; vertex numbers
/// only grow.
#[derive(Clone, Debug, Default)]
pub struct CrackMesh {
    rest_vertices: Buffer<DVec3>,
    rest_tets: Buffer<[u32; 4]>,
    neighbours: Buffer<[u32; 4]>,
    /// CSR from rest vertices to their tetrahedra, ascending.
    around_offsets: Buffer<u32>,
    around: Buffer<u32>,
    tets: Buffer<[u32; 4]>,
    origin: Buffer<u32>,
    /// Four numbers per tetrahedron; both sides of a face are kept equal.
    status: Buffer<u8>,
    scratch: Scratch,
}

impl CrackMesh {
    /// The whole mesh, nothing cut. Vertices that the input pinches are split at once: if boxes touch in an edge, each
    /// gets its own.
    ///
    /// # Errors
    /// A face of more than two tetrahedra, a vertex number out of range.
    pub fn new(mesh: &TetMesh) -> Result<Self, CrackError> {
        let vertices = mesh.vertices.len();
        for (tet, corners) in mesh.tets.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
                return Err(CrackError::NoVertex { tet, vertex, vertices });
            }
        }
        let neighbours = mesh.neighbours().map_err(CrackError::CrowdedFace)?;
        let (offsets, around) = Stars::of(vertices, &mesh.tets).into_rows();
        let mut crack = Self {
            rest_vertices: mesh.vertices.clone().into(),
            rest_tets: mesh.tets.clone().into(),
            neighbours: neighbours.into(),
            around_offsets: offsets.into(),
            around: around.into(),
            tets: mesh.tets.clone().into(),
            origin: (0..vertices as u32).collect::<Vec<_>>().into(),
            status: vec![GLUED; 4 * mesh.tets.len()].into(),
            scratch: Scratch::default(),
        };
        for v in 0..vertices as u32 {
            crack.separate(v);
        }
        crack.scratch.splits.clear();
        Ok(crack)
    }

    /// The current vertices of each tetrahedron.
    pub fn tets(&self) -> &[[u32; 4]] {
        &self.tets
    }

    /// For each current vertex the vertex of the input mesh that it is, or is a copy of.
    pub fn origin(&self) -> &[u32] {
        &self.origin
    }

    /// Rest position of current vertex `v` [m].
    pub fn rest_position(&self, v: u32) -> DVec3 {
        self.rest_vertices[self.origin[v as usize] as usize]
    }

    /// Rest volume of tetrahedron `t` [m³].
    pub fn rest_volume(&self, t: usize) -> f64 {
        let [a, b, c, d] = self.rest_tets[t].map(|v| self.rest_vertices[v as usize]);
        (b - a).dot((c - a).cross(d - a)) / 6.0
    }

    /// The tetrahedra of current vertex `v`, ascending; [`Stars`] give those of all vertices in less time.
    pub fn tets_around(&self, v: u32) -> impl Iterator<Item = u32> + Clone {
        let origin = self.origin[v as usize] as usize;
        let star = &self.around[self.around_offsets[origin] as usize..self.around_offsets[origin + 1] as usize];
        star.iter().copied().filter(move |&t| self.tets[t as usize].contains(&v))
    }

    /// For each tetrahedron and face the tetrahedron on the other side in the uncut mesh, or `u32::MAX`.
    pub fn neighbours(&self) -> &[[u32; 4]] {
        &self.neighbours
    }

    /// [`GLUED`], [`CRACKED`] or [`SEPARATED`] for face `k` of tetrahedron `t`.
    pub fn status(&self, t: usize, k: usize) -> u8 {
        self.status[4 * t + k]
    }

    /// Number of faces in the crack set, each counted once.
    pub fn crack_set(&self) -> usize {
        self.status.iter().filter(|&&s| s == CRACKED).count() / 2
    }

    /// The fragment of each tetrahedron, numbered by their first tetrahedra, and how many there are. Glued faces join.
    pub fn fragments(&self) -> (Vec<u32>, usize) {
        let (mut fragment, mut count, mut stack) = (vec![NONE; self.tets.len()], 0, Vec::new());
        for first in 0..self.tets.len() {
            if fragment[first] != NONE {
                continue;
            }
            fragment[first] = count;
            stack.push(first as u32);
            while let Some(t) = stack.pop() {
                for k in 0..4 {
                    let n = self.neighbours[t as usize][k];
                    if n != NONE && self.status(t as usize, k) == GLUED && fragment[n as usize] == NONE {
                        fragment[n as usize] = count;
                        stack.push(n);
                    }
                }
            }
            count += 1;
        }
        (fragment, count as usize)
    }

    /// Whether the columns fit each other: lengths, numbers of vertices, tetrahedra and faces. A file with right checksums may lie.
    pub fn consistent(&self) -> bool {
        let (tets, vertices) = (self.tets.len(), self.origin.len());
        let lengths = self.rest_tets.len() == tets
            && self.neighbours.len() == tets
            && self.status.len() == 4 * tets
            && self.around.len() == 4 * tets
            && self.around_offsets.len() == self.rest_vertices.len() + 1
            && self.around_offsets.first() == Some(&0)
            && self.around_offsets.last() == Some(&(self.around.len() as u32))
            && self.around_offsets.is_sorted();
        if !lengths || self.origin.iter().any(|&v| v as usize >= self.rest_vertices.len()) {
            return false;
        }
        let copy_of = |now: u32, rest: u32| (now as usize) < vertices && self.origin[now as usize] == rest;
        let corners = |t: usize| (0..4).all(|k| copy_of(self.tets[t][k], self.rest_tets[t][k]));
        let known =
            |t: usize, n: u32| n == NONE || self.neighbours.get(n as usize).is_some_and(|f| f.contains(&(t as u32)));
        let faces = |t: usize| (0..4).all(|k| known(t, self.neighbours[t][k]) && self.status(t, k) <= SEPARATED);
        let star = |v: usize| {
            let stars = &self.around[self.around_offsets[v] as usize..self.around_offsets[v + 1] as usize];
            stars.is_sorted()
                && stars
                    .iter()
                    .all(|&t| self.rest_tets.get(t as usize).is_some_and(|corners| corners.contains(&(v as u32))))
        };
        (0..tets).all(|t| corners(t) && faces(t)) && (0..self.rest_vertices.len()).all(star)
    }

    /// Shows every column to `v`, under `scope`.
    pub fn visit(&mut self, scope: &str, v: &mut Visitor) {
        v(scope, &Column::frozen("rest_vertex", "m", Of::Thing), &mut self.rest_vertices);
        v(scope, &Column::frozen("rest_tet", "1", Of::Tet), &mut self.rest_tets);
        v(scope, &Column::frozen("tet_neighbour", "1", Of::Tet), &mut self.neighbours);
        v(scope, &Column::frozen("around_offset", "1", Of::Thing), &mut self.around_offsets);
        v(scope, &Column::frozen("around", "1", Of::Thing), &mut self.around);
        v(scope, &Column::live("tet", "1", Of::Tet), &mut self.tets);
        v(scope, &Column::live("origin", "1", Of::Vertex), &mut self.origin);
        v(scope, &Column::live("face_status", "1", Of::Thing), &mut self.status);
    }
}

#[cfg(test)]
mod tests;
