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

mod surface;

pub use surface::{Smoothing, Surface};

use fissure_engine::buffer::Buffer;
use fissure_engine::column::{Column, Of, Visitor};
use glam::DVec3;
use thiserror::Error;

use crate::TetMesh;
use crate::tetmesh::FACES;

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

/// A vertex that the last [`CrackMesh::cut`] split: it kept one group of its tetrahedra, and `count` copies, numbered
/// from `first`, took the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Split {
    /// The vertex.
    pub vertex: u32,
    /// Its first copy.
    pub first: u32,
    /// How many copies.
    pub count: u32,
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

/// Working memory, kept between cuts; no state.
#[derive(Clone, Debug, Default)]
struct Scratch {
    touched: Vec<u32>,
    star: Vec<u32>,
    group: Vec<u32>,
    stack: Vec<u32>,
    splits: Vec<Split>,
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
        let (offsets, around) = around(mesh);
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

    /// Puts the faces between the linked tetrahedra into the crack set and splits the vertices that they separate;
    /// links between others than face neighbours are passed over. Returns how many vertices are new; which ones,
    /// [`CrackMesh::splits`] tells. The order of the links does not matter. Allocates nothing unless something splits.
    pub fn cut(&mut self, links: &[(u32, u32)]) -> usize {
        self.scratch.splits.clear();
        let mut touched = std::mem::take(&mut self.scratch.touched);
        touched.clear();
        for &(s, t) in links {
            let Some((k, l)) = self.shared_face(s, t) else { continue };
            let (near, far) = (4 * s as usize + k, 4 * t as usize + l);
            if self.status[near] == GLUED {
                self.status[near] = CRACKED;
                self.status[far] = CRACKED;
                touched.extend(FACES[k].map(|c| self.tets[s as usize][c]));
            }
        }
        touched.sort_unstable();
        touched.dedup();
        let before = self.origin.len();
        for &v in &touched {
            self.separate(v);
        }
        self.scratch.touched = touched;
        self.origin.len() - before
    }

    /// The local numbers of the face that two tetrahedra share, seen from each.
    fn shared_face(&self, s: u32, t: u32) -> Option<(usize, usize)> {
        let side = |a: u32, b: u32| self.neighbours.get(a as usize)?.iter().position(|&n| n == b);
        Some((side(s, t)?, side(t, s)?))
    }

    /// Splits vertex `v` if glued faces do not join all its tetrahedra. The group of the first tetrahedron keeps the
    /// number, the others get new ones in the order of their first tetrahedra.
    fn separate(&mut self, v: u32) {
        let Scratch { mut star, mut group, mut stack, mut splits, touched } = std::mem::take(&mut self.scratch);
        star.clear();
        star.extend(self.tets_around(v));
        group.clear();
        group.resize(star.len(), NONE);
        let mut groups = 0;
        for first in 0..star.len() {
            if group[first] != NONE {
                continue;
            }
            group[first] = groups;
            stack.push(first as u32);
            while let Some(m) = stack.pop() {
                for n in (0..4).filter_map(|k| self.side(v, &star, m as usize, k, GLUED)) {
                    if group[n] == NONE {
                        group[n] = groups;
                        stack.push(n as u32);
                    }
                }
            }
            groups += 1;
        }
        if groups > 1 {
            let first = self.origin.len() as u32;
            for m in 0..star.len() {
                let t = star[m] as usize;
                for k in 0..4 {
                    if self.side(v, &star, m, k, CRACKED).is_some_and(|n| group[n] != group[m]) {
                        self.status[4 * t + k] = SEPARATED; // the other side is set on its own turn
                    }
                }
            }
            for m in 0..star.len() {
                if group[m] > 0 {
                    let corners = &mut self.tets[star[m] as usize];
                    corners.iter_mut().filter(|u| **u == v).for_each(|u| *u = first + group[m] - 1);
                }
            }
            let origin = self.origin[v as usize];
            self.origin.to_mut().extend((1..groups).map(|_| origin));
            splits.push(Split { vertex: v, first, count: groups - 1 });
        }
        self.scratch = Scratch { star, group, stack, splits, touched };
    }

    /// Which of the star of `v` lies across face `k` of `star[m]`, if that face contains `v` and has this status.
    fn side(&self, v: u32, star: &[u32], m: usize, k: usize, status: u8) -> Option<usize> {
        let t = star[m] as usize;
        let wanted = self.tets[t][k] != v && self.status[4 * t + k] == status;
        if wanted { star.binary_search(&self.neighbours[t][k]).ok() } else { None }
    }

    /// Splits of the last cut, in the order of the vertices. Not state: empty after a restart.
    pub fn splits(&self) -> &[Split] {
        &self.scratch.splits
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

    /// The tetrahedra of current vertex `v`, ascending.
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

/// CSR from vertices to tetrahedra, ascending.
fn around(mesh: &TetMesh) -> (Vec<u32>, Vec<u32>) {
    let mut offsets = vec![0u32; mesh.vertices.len() + 1];
    for &v in mesh.tets.iter().flatten() {
        offsets[v as usize + 1] += 1;
    }
    for v in 0..mesh.vertices.len() {
        offsets[v + 1] += offsets[v];
    }
    let (mut next, mut around) = (offsets.clone(), vec![0; 4 * mesh.tets.len()]);
    for (t, tet) in mesh.tets.iter().enumerate() {
        for &v in tet {
            around[next[v as usize] as usize] = t as u32;
            next[v as usize] += 1;
        }
    }
    (offsets, around)
}

#[cfg(test)]
mod tests;
