//! Cutting: faces join the crack set, and vertices split by the groups of their tetrahedra.

use super::{CRACKED, CrackMesh, GLUED, NONE, SEPARATED};
use crate::tetmesh::FACES;

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

/// Working memory, kept between cuts; no state.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    touched: Vec<u32>,
    star: Vec<u32>,
    group: Vec<u32>,
    stack: Vec<u32>,
    pub(super) splits: Vec<Split>,
}

impl CrackMesh {
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
    pub(super) fn separate(&mut self, v: u32) {
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
}
