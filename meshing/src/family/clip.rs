//! Clipping of families by the mesh: no bond crosses a gap, a slit or a pre-cut.
//!
//! Particles are the barycentres of tetrahedra. A bond is walked: from tetrahedron to tetrahedron along the straight
//! segment. If the walk stays inside, the bond is kept. If it leaves through a boundary face with normal n₁, it is
//! walked from the other end too, up to a face with normal n₂. Walls of a gap face each other, n₁ · n₂ < 0. Where the
//! segment only skims a dent of a bumpy surface the two normals agree, and the bond is kept, for otherwise every
//! curved surface would lose bonds and soften. Right angles count as dents: with a limit of 0.3, or of 0, a bear of
//! stair-stepped cubes lost 14 % of its bonds, most of them across its steps. Bonds of face neighbours are always
//! kept, whatever the surface.
//!
//! Deep inside, nothing is walked: a ball around each barycentre that no boundary face enters (`clearance`) covers its
//! half of the bond. Pre-cuts are tested as triangles, each only against bonds of the particles near it.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use glam::DVec3;
use rayon::prelude::*;

use super::FamilyError;
use super::near::{Near, Tree, build_tree, visit_near};
use crate::tetmesh::FACES;
use crate::{TetMesh, TriMesh};

/// Normals of the two boundary faces a bond meets whose product is above this belong to a dent, not to a gap: to a
/// notch that opens by more than 84°.
const DENT: f64 = -0.1;
/// A walk longer than this has lost its way; the bond is kept.
const STEPS: usize = 1000;
const NONE: u32 = u32::MAX;

/// What bonds are clipped by: the connectivity of a tetrahedral mesh, and triangles that cut it from the start.
#[derive(Clone, Debug)]
pub struct Clip<'m> {
    mesh: &'m TetMesh,
    neighbours: Vec<[u32; 4]>,
    /// Face-connected part of each tetrahedron.
    part: Vec<u32>,
    parts: usize,
    /// Boundary faces as tetrahedron and local face.
    boundary: Vec<(u32, u8)>,
    cuts: Vec<[DVec3; 3]>,
    cut_links: Vec<(u32, u32)>,
}

impl<'m> Clip<'m> {
    /// The clip of a mesh, with the triangles of `cuts`, if any, as pre-cuts.
    ///
    /// # Errors
    /// Faces of more than two tetrahedra, vertex numbers out of range, non-finite coordinates.
    pub fn new(mesh: &'m TetMesh, cuts: Option<&TriMesh>) -> Result<Self, FamilyError> {
        check_numbers("tetrahedron", mesh.tets.iter().map(|t| &t[..]), mesh.vertices.len())?;
        let neighbours = mesh.neighbours().map_err(FamilyError::CrowdedFace)?;
        let (part, parts) = parts(&neighbours);
        let mut boundary = Vec::new();
        for (t, row) in neighbours.iter().enumerate() {
            boundary.extend((0..4).filter(|&k| row[k] == NONE).map(|k| (t as u32, k as u8)));
        }
        let mut clip = Self { mesh, neighbours, part, parts, boundary, cuts: Vec::new(), cut_links: Vec::new() };
        if let Some(cuts) = cuts {
            check_numbers("cut triangle", cuts.triangles.iter().map(|t| &t[..]), cuts.vertices.len())?;
            if let Some(index) = cuts.vertices.iter().position(|v| !v.is_finite()) {
                return Err(FamilyError::CutNotFinite { index, position: cuts.vertices[index] });
            }
            clip.cuts = (0..cuts.triangles.len()).map(|t| cuts.corners(t)).collect();
            clip.cut_links = clip.find_cut_links()?;
        }
        Ok(clip)
    }

    /// Pairs of face neighbours whose bond a pre-cut clips: cut the crack mesh along these at the start
    /// ([`CrackMesh::cut`](crate::crack::CrackMesh::cut)). Each pair once, the smaller number first, ascending.
    pub fn cut_links(&self) -> &[(u32, u32)] {
        &self.cut_links
    }

    /// Number of face-connected parts of the mesh, pre-cuts not counted.
    pub fn parts(&self) -> usize {
        self.parts
    }

    fn find_cut_links(&self) -> Result<Vec<(u32, u32)>, FamilyError> {
        let centers: Vec<DVec3> = (0..self.mesh.tets.len()).into_par_iter().map(|t| self.mesh.barycentre(t)).collect();
        if centers.is_empty() {
            return Ok(Vec::new());
        }
        let links: Vec<(u32, u32)> = (0..centers.len() as u32)
            .flat_map(|s| {
                self.neighbours[s as usize].into_iter().filter(move |&t| t != NONE && s < t).map(move |t| (s, t))
            })
            .collect();
        let longest = links.iter().map(|&(s, t)| centers[s as usize].distance(centers[t as usize])).fold(0.0, f64::max);
        let near = Near::new(&self.cuts, &build_tree(&centers)?, &centers, longest);
        let mut cut: Vec<(u32, u32)> =
            links.into_par_iter().filter(|&(s, t)| near.cut(&self.cuts, &centers, s as usize, t as usize)).collect();
        cut.sort_unstable();
        Ok(cut)
    }

    /// Everything about these points and this horizon that the bonds share.
    pub(super) fn prepare<'a>(
        &'a self,
        tree: &Tree,
        points: &'a [DVec3],
        horizon: f64,
    ) -> Result<Prepared<'a, 'm>, FamilyError> {
        if points.len() != self.mesh.tets.len() {
            return Err(FamilyError::OtherMesh { points: points.len(), tets: self.mesh.tets.len() });
        }
        let clearance = self.clearance(tree, points, horizon);
        Ok(Prepared { clip: self, points, clearance, near: Near::new(&self.cuts, tree, points, horizon) })
    }

    /// Distance of each point to the nearest boundary face [m], at most `horizon`.
    fn clearance(&self, tree: &Tree, points: &[DVec3], horizon: f64) -> Vec<f64> {
        // Distances are not negative, so their bits are ordered as they are, and a minimum does not depend on the
        // order in which threads come.
        let nearest: Vec<AtomicU64> = points.iter().map(|_| AtomicU64::new(horizon.to_bits())).collect();
        self.boundary.par_iter().for_each(|&(t, k)| {
            let face = self.face(t as usize, k as usize);
            visit_near(&face, tree, points, horizon, |p, d| {
                nearest[p as usize].fetch_min(d.to_bits(), Relaxed);
            });
        });
        nearest.into_iter().map(|bits| f64::from_bits(bits.into_inner())).collect()
    }

    /// Corners of face `k` of tetrahedron `t`, wound outwards.
    fn face(&self, t: usize, k: usize) -> [DVec3; 3] {
        FACES[k].map(|v| self.mesh.vertices[self.mesh.tets[t][v] as usize])
    }

    /// Walks from point `p` in tetrahedron `from` straight to `q` in tetrahedron `to`.
    fn walk(&self, from: usize, p: DVec3, to: usize, q: DVec3) -> Walk {
        let d = q - p;
        let (mut t, mut entry) = (from, usize::MAX);
        for _ in 0..STEPS {
            let (mut exit, mut first, mut normal) = (usize::MAX, 1.0, DVec3::ZERO);
            let corners = self.mesh.corners(t);
            for k in (0..4).filter(|&k| k != entry) {
                let [a, b, c] = FACES[k];
                let outward = (corners[b] - corners[a]).cross(corners[c] - corners[a]);
                let speed = outward.dot(d);
                if speed > 0.0 {
                    let at = outward.dot(corners[a] - p) / speed;
                    if at < first {
                        (exit, first, normal) = (k, at, outward);
                    }
                }
            }
            if exit == usize::MAX {
                return if t == to { Walk::Arrives } else { Walk::Lost };
            }
            let next = self.neighbours[t][exit];
            if next == NONE {
                return Walk::Leaves(normal.normalize_or_zero());
            }
            entry = self.neighbours[next as usize].iter().position(|&n| n as usize == t).unwrap_or(usize::MAX);
            t = next as usize;
        }
        Walk::Lost
    }

    /// Whether the straight bond between tetrahedra `i` and `j` stays inside or only skims a dent. A walk that goes
    /// exactly through an edge or a vertex may lose its way; the ends are then moved a little, each towards one of
    /// its own vertices, and if that fails four times the bond is kept.
    fn joined(&self, i: usize, p: DVec3, j: usize, q: DVec3) -> bool {
        for attempt in 0..=4 {
            let nudge = |t: usize, x: DVec3, vertex: usize| {
                if attempt == 0 { x } else { x.lerp(self.mesh.corners(t)[vertex % 4], 1e-3) }
            };
            let (p, q) = (nudge(i, p, attempt), nudge(j, q, 2 * attempt + 1));
            let going = self.walk(i, p, j, q);
            if matches!(going, Walk::Arrives) {
                return true;
            }
            match (going, self.walk(j, q, i, p)) {
                (_, Walk::Arrives) => return true,
                (Walk::Leaves(going), Walk::Leaves(coming)) => return going.dot(coming) > DENT,
                _ => {}
            }
        }
        true
    }
}

/// How a walk ends.
enum Walk {
    /// In the tetrahedron it was to reach.
    Arrives,
    /// Through a boundary face with this outward unit normal.
    Leaves(DVec3),
    /// Anywhere else.
    Lost,
}

/// A clip with what depends on the points and the horizon.
pub(super) struct Prepared<'a, 'm> {
    clip: &'a Clip<'m>,
    points: &'a [DVec3],
    clearance: Vec<f64>,
    near: Near,
}

impl Prepared<'_, '_> {
    /// Whether the bond between two points within the horizon stays. The same answer from both ends.
    pub(super) fn keeps(&self, i: usize, j: usize) -> bool {
        let (i, j) = (i.min(j), i.max(j));
        let (clip, p, q) = (self.clip, self.points[i], self.points[j]);
        if clip.part[i] != clip.part[j] || self.near.cut(&clip.cuts, self.points, i, j) {
            return false;
        }
        // Strictly more, for a bond straight through a slit of no width is just covered.
        let clear = self.clearance[i] + self.clearance[j];
        clear * clear > p.distance_squared(q) * (1.0 + 1e-9)
            || clip.neighbours[i].contains(&(j as u32))
            || clip.joined(i, p, j, q)
    }
}

/// Numbers the face-connected parts: the part of each tetrahedron, in order of their first ones, and how many.
fn parts(neighbours: &[[u32; 4]]) -> (Vec<u32>, usize) {
    let (mut part, mut parts, mut stack) = (vec![NONE; neighbours.len()], 0, Vec::new());
    for first in 0..neighbours.len() {
        if part[first] != NONE {
            continue;
        }
        part[first] = parts;
        stack.push(first as u32);
        while let Some(t) = stack.pop() {
            for &n in neighbours[t as usize].iter().filter(|&&n| n != NONE) {
                if part[n as usize] == NONE {
                    part[n as usize] = parts;
                    stack.push(n);
                }
            }
        }
        parts += 1;
    }
    (part, parts as usize)
}

fn check_numbers<'a>(
    what: &'static str,
    cells: impl Iterator<Item = &'a [u32]>,
    vertices: usize,
) -> Result<(), FamilyError> {
    for (index, cell) in cells.enumerate() {
        if let Some(&vertex) = cell.iter().find(|&&v| v as usize >= vertices) {
            return Err(FamilyError::NoVertex { what, index, vertex, vertices });
        }
    }
    Ok(())
}
