//! Bringing the boundary to the surface, and finishing.

use super::complex::{angle_score, worst_from};
use super::improve::Body;
use crate::TetMesh;
use crate::distance::Distance;
use glam::DVec3;
use rayon::prelude::*;

/// Points of the surface farther than this from the mesh are pulled at, in element sizes.
const FAR: f64 = 0.2;

impl Body<'_> {
    /// Moves boundary vertices onto the surface, then pulls the boundary to points of the surface that it misses.
    pub fn fit(&mut self, seed: u64) {
        self.home();
        let samples = self.solid.samples(0.25 * self.size);
        for round in 0..6 {
            if self.reach_out(&samples) == 0 {
                break;
            }
            self.improve(16.0, 2, seed ^ round);
            self.home();
        }
    }

    /// Moves every boundary vertex to where it belongs, as far as angles allow.
    fn home(&mut self) {
        let outer: Vec<u32> = (0..self.dim.len() as u32).filter(|&v| self.dim[v as usize] < 3 && !self.mesh.star(v).is_empty()).collect();
        let goals: Vec<Option<DVec3>> = outer.par_iter().map(|&v| self.place(v, self.mesh.points[v as usize])).collect();
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
    /// the nearest edge. Farthest points first, each neighbourhood once. Returns how many were tried with success.
    fn reach_out(&mut self, samples: &[DVec3]) -> usize {
        let faces: Vec<[u32; 3]> = self.mesh.boundary().into_iter().map(|f| f.0).collect();
        let tree = Distance::of_triangles(faces.iter().map(|f| f.map(|v| self.mesh.points[v as usize])).collect());
        let far = FAR * self.size;
        let mut missed: Vec<(f64, usize, u32)> = samples
            .par_iter()
            .enumerate()
            .filter_map(|(i, &p)| tree.closest(p).filter(|c| c.distance > far).map(|c| (c.distance, i, c.triangle)))
            .collect();
        missed.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut touched = vec![false; self.dim.len()];
        let mut done = 0;
        for (_, i, f) in missed {
            let face = faces[f as usize];
            if face.iter().any(|&v| touched[v as usize]) {
                continue;
            }
            for v in face {
                touched[v as usize] = true;
            }
            done += usize::from(self.pull_to(face, samples[i]));
            touched.resize(self.dim.len(), true);
        }
        done
    }

    fn pull_to(&mut self, face: [u32; 3], goal: DVec3) -> bool {
        let crease = self.solid.features().on_crease(goal, 0.02 * self.size).is_some();
        let dim = if crease { 1 } else { 2 };
        let floor = angle_score(8.0);
        let mut near = face;
        let gap = |v: u32| self.mesh.points[v as usize].distance(goal);
        near.sort_by(|&a, &b| gap(a).total_cmp(&gap(b)));
        for v in near {
            if self.dim[v as usize] < dim || gap(v) > 0.8 * self.size {
                continue;
            }
            if self.dim[v as usize] == 1 && self.off_crease_chain(v, goal) {
                continue;
            }
            if worst_from(goal, &self.mesh.view(v), floor) > floor {
                self.mesh.points[v as usize] = goal;
                self.dim[v as usize] = dim;
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
            if pa.lerp(pb, t).distance(goal) > 0.5 * self.size {
                continue;
            }
            if self.mesh.split(a, b, goal, floor).is_some() {
                self.dim.push(dim);
                return true;
            }
        }
        false
    }

    /// Whether moving a vertex of a sharp edge to `goal` would leave a hole in the chain it belongs to.
    fn off_crease_chain(&self, v: u32, goal: DVec3) -> bool {
        self.mesh.points[v as usize].distance(goal) > 0.4 * self.size
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
