//! Bringing the boundary to the surface, and finishing.

use super::AIM;
use super::complex::{angle_score, score, worst_from};
use super::improve::Body;
use crate::TetMesh;
use crate::distance::Distance;
use glam::DVec3;
use rayon::prelude::*;

/// Points of the surface farther than this from the mesh are pulled at, in element sizes.
const FAR: f64 = 0.2;
/// Boundary edges that pass farther from the surface than this get a vertex, in element sizes.
const BEND: f64 = 0.2;
/// Pulling ends early when everything is nearer than this, in element sizes.
const NEAR: f64 = 0.28;
/// Most rounds of pulling; a lost feature grows by about one element a round.
const ROUNDS: u64 = 16;

impl Body<'_> {
    /// Moves boundary vertices onto the surface, turns boundary edges that cut through it, and pulls the boundary to
    /// points of the surface that it misses.
    pub fn fit(&mut self, seed: u64) {
        let samples: Vec<DVec3> = self.solid.samples(0.25 * self.size).into_iter().map(|s| s.0).collect();
        let mut last = usize::MAX;
        for round in 0..ROUNDS {
            self.floor = if round < 4 { 11.0 } else { 5.0 };
            self.home();
            let (turned, off) = self.turn_chords(seed ^ round);
            let (pulled, missed) = self.reach_out(&samples, seed ^ round);
            let (done, worst) = (turned + pulled, off.max(missed) / self.size);
            if done == 0 || (round > 1 && worst < NEAR) || (round > 5 && done >= last) {
                break;
            }
            last = done;
            self.improve(AIM, 2, seed ^ round);
        }
        self.home();
    }

    /// Boundary edges that pass far from the surface are replaced by the other diagonal of their two triangles: by
    /// refilling the ring, by a tetrahedron on top, or by taking away the only tetrahedron at the edge. Returns how many, and
    /// the largest distance before.
    fn turn_chords(&mut self, seed: u64) -> (usize, f64) {
        let mut edges: Vec<[u32; 2]> = Vec::new();
        for f in self.boundary() {
            edges.extend((0..3).map(|k| [f[k], f[(k + 1) % 3]]).filter(|e| e[0] < e[1]));
        }
        let middle = |&[a, b]: &[u32; 2]| (self.mesh.points[a as usize] + self.mesh.points[b as usize]) / 2.0;
        let mut long: Vec<(f64, [u32; 2])> =
            edges.par_iter().map(|e| (self.off(middle(e)), *e)).filter(|e| e.0 > 0.12 * self.size).collect();
        long.sort_unstable_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
        let worst = long.first().map_or(0.0, |e| e.0);
        (long.into_iter().filter(|&(error, e)| self.turn(e, error) || self.bend(e, error, seed)).count(), worst)
    }

    /// Brings the ends of a chord home, fills the pit at one of them, or puts a vertex on the surface in its middle.
    fn bend(&mut self, [a, b]: [u32; 2], error: f64, seed: u64) -> bool {
        if error < BEND * self.size || !self.mesh.ring(a, b).is_some_and(|r| r.open) {
            return false;
        }
        for v in [a, b] {
            let p = self.mesh.points[v as usize];
            let goal = self.solid.project(p);
            if self.dim[v as usize] == 2
                && p.distance(goal) > 0.1 * self.size
                && (self.fill_pit(v) || self.drag(v, goal, 2, seed))
            {
                return true;
            }
        }
        let middle = (self.mesh.points[a as usize] + self.mesh.points[b as usize]) / 2.0;
        let goal = self.solid.project(middle);
        for part in [1.0, 0.6, 0.3] {
            if self.mesh.split(a, b, middle.lerp(goal, part), angle_score(self.floor)).is_some() {
                self.dim.push(2);
                return true;
            }
        }
        false
    }

    /// Closes a boundary vertex with three boundary faces under a tetrahedron, if it lies inside the solid.
    fn fill_pit(&mut self, v: u32) -> bool {
        let fan = self.outer_faces(v);
        let mut rim: Vec<u32> = fan.iter().flatten().copied().filter(|&w| w != v).collect();
        rim.sort_unstable();
        rim.dedup();
        let (3, &[a, b, c]) = (fan.len(), &rim[..]) else { return false };
        if self.solid.signed_distance(self.mesh.points[v as usize], self.size) > 0.0 {
            return false;
        }
        let best = [[v, a, b, c], [v, a, c, b]].into_iter().find(|&t| self.mesh.score(t) > angle_score(self.floor));
        if let Some(tet) = best {
            self.mesh.replace(&[], &[tet]);
            self.dim[v as usize] = 3;
        }
        best.is_some()
    }

    fn turn(&mut self, [a, b]: [u32; 2], error: f64) -> bool {
        let Some(ring) = self.mesh.ring(a, b).filter(|r| r.open) else { return false };
        let (c, d) = (ring.link[0], ring.link[ring.link.len() - 1]);
        let [pa, pb, pc, pd] = [a, b, c, d].map(|v| self.mesh.points[v as usize]);
        if self.off((pc + pd) / 2.0) > 0.7 * error || !self.rightly([pa, pb, pc, pd]) {
            return false;
        }
        let floor = angle_score(self.floor);
        if ring.tets.len() == 1 {
            // both triangles belong to one tetrahedron: without it the other two faces show
            // (if their common edge is on the boundary already, that would pierce the solid)
            let inside = self.mesh.across(ring.tets[0], [a, c, d]).is_some()
                && self.mesh.across(ring.tets[0], [b, c, d]).is_some()
                && self.mesh.ring(c, d).is_some_and(|r| !r.open);
            if inside {
                self.mesh.remove(ring.tets[0]);
                self.lower(&[a, b, c, d]);
            }
            return inside;
        }
        if self.mesh.around(c, d).next().is_some() {
            return false;
        }
        if score(pa, pb, pd, pc) > floor {
            self.mesh.replace(&[], &[[a, b, d, c]]);
            return true;
        }
        self.mesh.remove_edge(a, b, Some(floor), |_, _| true)
    }

    /// Vertices that came to the surface stay on it from now on.
    fn lower(&mut self, vertices: &[u32]) {
        for &v in vertices {
            self.dim[v as usize] = self.dim[v as usize].min(2);
        }
    }

    /// Moves every boundary vertex to where it belongs, as far as angles allow.
    fn home(&mut self) {
        let outer: Vec<u32> =
            (0..self.dim.len() as u32).filter(|&v| self.dim[v as usize] < 3 && !self.mesh.star(v).is_empty()).collect();
        let goals: Vec<Option<DVec3>> =
            outer.par_iter().map(|&v| self.place(v, self.mesh.points[v as usize])).collect();
        for (v, goal) in outer.into_iter().zip(goals) {
            let Some(goal) = goal else { continue };
            let from = self.mesh.points[v as usize];
            if from.distance(goal) < 1e-9 * self.size {
                continue;
            }
            let view = self.mesh.view(v);
            let floor = worst_from(from, &view, -2.0).min(angle_score(14.0));
            for part in [1.0, 0.5, 0.25] {
                let p = from.lerp(goal, part);
                if worst_from(p, &view, floor - 1e-9) >= floor {
                    self.mesh.points[v as usize] = p;
                    break;
                }
            }
        }
    }

    /// For points of the surface that the boundary misses: moves the nearest boundary vertex there, or a new vertex on
    /// the nearest edge. Farthest points first, each neighbourhood once. Returns how many were
    /// reached, and the largest distance before.
    fn reach_out(&mut self, samples: &[DVec3], seed: u64) -> (usize, f64) {
        let faces = self.boundary();
        let tree = Distance::of_triangles(faces.iter().map(|f| f.map(|v| self.mesh.points[v as usize])).collect());
        let far = FAR * self.size;
        let mut missed: Vec<(f64, usize, u32)> = samples
            .par_iter()
            .enumerate()
            .filter_map(|(i, &p)| tree.closest(p).filter(|c| c.distance > far).map(|c| (c.distance, i, c.triangle)))
            .collect();
        missed.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let worst = missed.first().map_or(0.0, |m| m.0);
        let mut touched = vec![false; self.dim.len()];
        let mut done = 0;
        for (gap, i, f) in missed {
            let face = faces[f as usize];
            if gap > 1.1 * self.size || face.iter().any(|&v| touched[v as usize]) {
                continue;
            }
            for v in face {
                touched[v as usize] = true;
            }
            done += usize::from(self.pull_to(face, samples[i], seed));
            touched.resize(self.dim.len(), true);
        }
        (done, worst)
    }

    fn pull_to(&mut self, face: [u32; 3], goal: DVec3, seed: u64) -> bool {
        let features = self.solid.features();
        let close = 0.02 * self.size;
        let dim = if features.corners.iter().any(|c| c.distance(goal) < close) {
            0
        } else if features.on_crease(goal, close).is_some() {
            1
        } else {
            2
        };
        let mut near = face;
        let gap = |v: u32| self.mesh.points[v as usize].distance(goal);
        near.sort_by(|&a, &b| gap(a).total_cmp(&gap(b)));
        for v in near {
            let d = self.dim[v as usize];
            let gap = self.mesh.points[v as usize].distance(goal) / self.size;
            let most = match (d, dim) {
                (1, 1) => 0.4,
                // a tip may be far from what the background left of it
                (_, 0) => 1.2,
                _ => 0.8,
            };
            if d < dim || d == 0 || gap > most {
                continue;
            }
            if self.drag(v, goal, dim, seed) {
                return true;
            }
        }
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            if !self.mesh.ring(a, b).is_some_and(|r| r.open) {
                continue;
            }
            let (pa, pb) = (self.mesh.points[a as usize], self.mesh.points[b as usize]);
            let t = ((goal - pa).dot(pb - pa) / pb.distance_squared(pa).max(1e-300)).clamp(0.2, 0.8);
            if pa.lerp(pb, t).distance(goal) > 0.6 * self.size {
                continue;
            }
            if self.mesh.split(a, b, goal, angle_score(self.floor)).is_some() {
                self.dim.push(dim);
                return true;
            }
        }
        self.grow(face, goal, dim)
    }

    /// Puts a tetrahedron with a new vertex at `goal` on a boundary face.
    fn grow(&mut self, face: [u32; 3], goal: DVec3, dim: u8) -> bool {
        let [a, b, c] = face.map(|v| self.mesh.points[v as usize]);
        let lost =
            self.mesh.star(face[0]).iter().all(|&t| !face.iter().all(|v| self.mesh.tets[t as usize].contains(v)));
        if lost || score(a, b, c, goal) < angle_score(self.floor) {
            return false;
        }
        let v = self.mesh.add_point(goal);
        self.dim.push(dim);
        self.mesh.replace(&[], &[[face[0], face[1], face[2], v]]);
        true
    }

    /// Moves a boundary vertex to `goal` in steps, letting its neighbours make room; back to the start if the angles
    /// don't recover.
    fn drag(&mut self, v: u32, goal: DVec3, dim: u8, seed: u64) -> bool {
        let start = self.mesh.points[v as usize];
        let floor = angle_score(self.floor);
        if worst_from(goal, &self.mesh.view(v), floor) <= floor {
            let around = self.mesh.neighbours(v);
            let old: Vec<DVec3> = around.iter().map(|&w| self.mesh.points[w as usize]).collect();
            let mut fine = true;
            for step in 1..=3 {
                let p = start.lerp(goal, f64::from(step) / 3.0);
                fine = worst_from(p, &self.mesh.view(v), -1.0) > -1.0;
                if !fine {
                    break;
                }
                self.mesh.points[v as usize] = p;
                self.smooth(&around, 0.12 * self.size, seed ^ u64::from(v));
            }
            let mut all: Vec<u32> = around.iter().flat_map(|&w| self.mesh.star(w)).copied().collect();
            all.sort_unstable();
            all.dedup();
            if !fine || self.mesh.worst(&all) <= floor {
                self.mesh.points[v as usize] = start;
                for (&w, p) in around.iter().zip(old) {
                    self.mesh.points[w as usize] = p;
                }
                return false;
            }
        }
        self.mesh.points[v as usize] = goal;
        self.dim[v as usize] = dim;
        true
    }

    /// The mesh as a result: vertices that are used, in order of first use.
    pub fn finish(&self) -> TetMesh {
        let mut new = vec![u32::MAX; self.mesh.points.len()];
        let mut out = TetMesh::default();
        for t in self.mesh.living() {
            let tet = self.mesh.tets[t as usize].map(|v| {
                let slot = &mut new[v as usize];
                if *slot == u32::MAX {
                    *slot = out.vertices.len() as u32;
                    out.vertices.push(self.mesh.points[v as usize]);
                }
                *slot
            });
            out.tets.push(tet);
        }
        out
    }
}
