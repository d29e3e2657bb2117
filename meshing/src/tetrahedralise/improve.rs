//! Raising the smallest dihedral angle: flips, vertex moves, contractions, splits, and at last removal.
//!
//! Work goes where tetrahedra are below a target; everything else stays as the background made it. Vertices on the
//! surface move along it, vertices on a sharp edge along that, corners not at all (see [`Body::place`]).

use super::complex::{Complex, Ring, angle_score};
use super::smooth::smooth;
use super::solid::Solid;
use crate::tetmesh::FACES;
use glam::DVec3;
use rayon::prelude::*;

/// A boundary edge may pass this far from the surface, in element sizes.
const CHORD: f64 = 0.2;
const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// A mesh on its way to a solid.
pub struct Body<'a> {
    /// The tetrahedra.
    pub mesh: Complex,
    /// What each vertex must stay on: 0 corner, 1 sharp edge, 2 surface, 3 nothing.
    pub dim: Vec<u8>,
    /// The solid.
    pub solid: &'a dyn Solid,
    /// Element size [m].
    pub size: f64,
    /// How far surface vertices may leave the surface for the sake of angles, in element sizes.
    pub slack: f64,
    /// Changes for the sake of the surface leave angles of at least this [degrees].
    pub floor: f64,
}

impl Body<'_> {
    /// Where a vertex that wants to be at `p` may be.
    pub fn place(&self, v: u32, p: DVec3) -> Option<DVec3> {
        place(self.solid, self.dim[v as usize], self.size, self.slack, p)
    }

    /// Sets `dim` right after cutting or removing: 3 inside, at most 2 on the boundary.
    pub fn settle(&mut self) {
        let mut outer = vec![false; self.dim.len()];
        for face in self.mesh.boundary(|_| true) {
            for v in face {
                outer[v as usize] = true;
            }
        }
        for (d, outer) in self.dim.iter_mut().zip(outer) {
            *d = if outer { (*d).min(2) } else { 3 };
        }
    }

    /// Boundary triangles, wound outwards.
    pub fn boundary(&self) -> Vec<[u32; 3]> {
        self.mesh.boundary(|v| self.dim[v as usize] < 3)
    }

    /// Distance of a point from the boundary of the solid [m].
    pub fn off(&self, p: DVec3) -> f64 {
        p.distance(self.solid.project(p))
    }

    /// Whether turning boundary edge `a`-`b` into `c`-`d` adds what is inside the solid or takes what is outside.
    pub fn rightly(&self, [pa, pb, pc, pd]: [DVec3; 4]) -> bool {
        let middle = (pa + pb + pc + pd) / 4.0;
        if self.off(middle) < 0.08 * self.size {
            return true;
        }
        let adds = (pb - pa).dot((pd - pa).cross(pc - pa)) > 0.0;
        adds == (self.solid.signed_distance(middle, self.size) < 0.0)
    }

    /// Whether a boundary edge may be turned: the new one must not pass farther from the surface than the old one or
    /// the tolerance, must not cut through a sharp edge, and the surface must not fold.
    pub fn may_turn(&self, mesh: &Complex, a: u32, b: u32, ring: &Ring) -> bool {
        let (c, d) = (ring.link[0], ring.link[ring.link.len() - 1]);
        let [pa, pb, pc, pd] = [a, b, c, d].map(|v| mesh.points[v as usize]);
        let normals = [(pb - pa).cross(pc - pa), (pd - pa).cross(pb - pa)];
        let turned = [(pd - pa).cross(pc - pa), (pd - pc).cross(pb - pc)];
        if turned.iter().any(|t| normals.iter().any(|n| t.dot(*n) <= 0.3 * t.length() * n.length()))
            && normals[0].dot(normals[1]) > 0.0
        {
            return false;
        }
        let middle = (pa + pb) / 2.0;
        let on_crease = self.dim[a as usize] < 2 && self.dim[b as usize] < 2;
        let tight = 0.05 * self.size;
        if on_crease && self.solid.features().on_crease(middle, tight).is_some() {
            return false;
        }
        let error = self.off((pc + pd) / 2.0);
        (error < CHORD * self.size || error < self.off(middle)) && self.rightly([pa, pb, pc, pd])
    }

    /// Removes edges and faces of tetrahedron `t` while that helps.
    fn flip(&mut self, t: u32) -> bool {
        let tet = self.mesh.tets[t as usize];
        for [i, j] in PAIRS {
            let (a, b) = (tet[i], tet[j]);
            let mut mesh = std::mem::replace(&mut self.mesh, Complex::new(Vec::new(), Vec::new(), None));
            let done = mesh.remove_edge(a, b, None, |m, ring| self.may_turn(m, a, b, ring));
            self.mesh = mesh;
            if done {
                return true;
            }
        }
        (0..FACES.len()).any(|k| self.mesh.remove_face(t, k, None))
    }

    /// Whether moving `a` into `b` keeps the boundary a surface close to the solid's.
    fn may_contract(&self, a: u32, b: u32) -> bool {
        let (da, db) = (self.dim[a as usize], self.dim[b as usize]);
        if da == 3 {
            return true;
        }
        if db > da || da == 0 {
            return false;
        }
        let Some(ring) = self.mesh.ring(a, b) else { return false };
        if !ring.open {
            return false;
        }
        let middle = (self.mesh.points[a as usize] + self.mesh.points[b as usize]) / 2.0;
        if da == 1 && self.solid.features().on_crease(middle, 0.05 * self.size).is_none() {
            return false;
        }
        let fan = self.outer_faces(a);
        let rim = |v: u32| {
            let mut all: Vec<u32> = self.outer_faces(v).into_iter().flatten().filter(|&w| w != v).collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        let (ra, rb) = (rim(a), rim(b));
        if ra.iter().filter(|w| rb.contains(w)).count() != 2 {
            return false;
        }
        let target = self.mesh.points[b as usize];
        fan.iter().filter(|f| !f.contains(&b)).all(|f| {
            let old = f.map(|v| self.mesh.points[v as usize]);
            let new = f.map(|v| if v == a { target } else { self.mesh.points[v as usize] });
            let normal = |[x, y, z]: [DVec3; 3]| (y - x).cross(z - x).normalize_or_zero();
            let centre = (new[0] + new[1] + new[2]) / 3.0;
            let longest = (0..3).map(|k| (new[k] + new[(k + 1) % 3]) / 2.0).map(|m| self.off(m)).fold(0.0, f64::max);
            normal(old).dot(normal(new)) > 0.5 && self.off(centre).max(longest) < CHORD * self.size
        })
    }

    /// Boundary faces at a vertex, wound outwards.
    pub fn outer_faces(&self, v: u32) -> Vec<[u32; 3]> {
        let mut out = Vec::new();
        for &t in self.mesh.star(v) {
            let tet = self.mesh.tets[t as usize];
            for f in FACES {
                let f = f.map(|k| tet[k]);
                if f.contains(&v) && f.iter().all(|&w| self.dim[w as usize] < 3) && self.mesh.across(t, f).is_none() {
                    out.push(f);
                }
            }
        }
        out
    }

    /// Moves an end of an edge of `t` into the other, shortest edge first, if all that stays beats the worst around.
    fn contract(&mut self, t: u32) -> bool {
        let tet = self.mesh.tets[t as usize];
        let mut pairs = PAIRS.map(|[i, j]| (tet[i], tet[j]));
        let length = |&(a, b): &(u32, u32)| self.mesh.points[a as usize].distance_squared(self.mesh.points[b as usize]);
        pairs.sort_by(|x, y| length(x).total_cmp(&length(y)));
        for (a, b) in pairs.into_iter().flat_map(|(a, b)| [(a, b), (b, a)]) {
            let floor = self.mesh.worst(self.mesh.star(a)) + 1e-9;
            if self.may_contract(a, b) && self.mesh.contract(a, b, floor) {
                return true;
            }
        }
        false
    }

    /// Puts a vertex on the longest edge of `t`, then moves it to where the angles are best; undone by nothing, so only
    /// if that alone already helps.
    fn split(&mut self, t: u32, round: u64) -> bool {
        let tet = self.mesh.tets[t as usize];
        let length = |[i, j]: [usize; 2]| self.mesh.points[tet[i] as usize].distance(self.mesh.points[tet[j] as usize]);
        let mut pairs = PAIRS;
        pairs.sort_by(|x, y| length(*y).total_cmp(&length(*x)));
        for [i, j] in pairs.into_iter().take(2) {
            let (a, b) = (tet[i], tet[j]);
            let Some(ring) = self.mesh.ring(a, b) else { continue };
            let before = self.mesh.worst(&ring.tets);
            let middle = (self.mesh.points[a as usize] + self.mesh.points[b as usize]) / 2.0;
            let crease = self.dim[a as usize] < 2 && self.dim[b as usize] < 2 && ring.open;
            let Some(v) = self.mesh.split(a, b, middle, -1.5) else { continue };
            self.dim.push(if !ring.open {
                3
            } else if crease {
                1
            } else {
                2
            });
            let step = 0.2 * self.size;
            for k in 0..3 {
                self.smooth(&[v], step, round + k);
            }
            if self.mesh.worst(self.mesh.star(v)) > before + 1e-6 {
                return true;
            }
            // undo: put the halves together again
            self.dim.pop();
            let star = self.mesh.star(v).to_vec();
            let whole: Vec<[u32; 4]> = star
                .iter()
                .map(|&s| self.mesh.tets[s as usize])
                .filter(|s| s.contains(&a))
                .map(|s| s.map(|w| if w == v { b } else { w }))
                .collect();
            self.mesh.replace(&star, &whole);
            self.mesh.drop_last_point();
        }
        false
    }

    /// Moves vertices to better places, each where [`Body::place`] lets it be.
    pub fn smooth(&mut self, vertices: &[u32], step: f64, seed: u64) -> usize {
        let (solid, size, slack) = (self.solid, self.size, self.slack);
        let dim = &self.dim;
        smooth(&mut self.mesh, vertices, step, seed, |v, p| place(solid, dim[v as usize], size, slack, p))
    }

    /// Tetrahedra below `target`, worst first.
    pub fn bad(&self, target: f64) -> Vec<u32> {
        let mut all: Vec<(f64, u32)> = (0..self.mesh.tets.len() as u32)
            .into_par_iter()
            .with_min_len(1024)
            .filter(|&t| self.mesh.alive(t))
            .map(|t| (self.mesh.score(self.mesh.tets[t as usize]), t))
            .filter(|&(q, _)| q < target)
            .collect();
        all.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        all.into_iter().map(|b| b.1).collect()
    }

    /// Improves until every angle is above `degrees` or `rounds` are over. Returns how many tetrahedra stay below.
    pub fn improve(&mut self, degrees: f64, rounds: u64, seed: u64) -> usize {
        let target = angle_score(degrees);
        for round in 0..rounds {
            let bad = self.bad(target);
            if bad.is_empty() {
                return 0;
            }
            for &t in &bad {
                if !self.mesh.alive(t) || self.mesh.score(self.mesh.tets[t as usize]) >= target || self.flip(t) {
                    continue;
                }
                if round > 0 && self.contract(t) {
                    continue;
                }
                if round > 2 {
                    self.split(t, seed ^ round);
                }
            }
            let mut vertices: Vec<u32> = self.bad(target).iter().flat_map(|&t| self.mesh.tets[t as usize]).collect();
            if round % 3 == 2 {
                vertices = vertices.iter().flat_map(|&v| self.mesh.neighbours(v)).collect();
            }
            vertices.sort_unstable();
            vertices.dedup();
            let step = self.size * [0.15, 0.08, 0.25][round as usize % 3];
            self.smooth(&vertices, step, seed ^ (round << 32));
        }
        self.bad(target).len()
    }
}

/// Where a vertex of the given `dim` that wants to be at `p` may be.
fn place(solid: &dyn Solid, dim: u8, size: f64, slack: f64, p: DVec3) -> Option<DVec3> {
    match dim {
        3 => Some(p),
        2 => {
            let q = solid.project(p);
            let d = p.distance(q);
            Some(if d <= slack * size { p } else { q + (p - q) * (slack * size / d) })
        }
        1 => solid.features().on_crease(p, size),
        _ => None,
    }
}
