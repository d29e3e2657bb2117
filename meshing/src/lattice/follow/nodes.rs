//! The nodes that a surface follows: how large they are, which are linked, and the points that they count as.

use std::ops::Range;

use fissure_engine::lattice::LatticePose;
use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;
use wide::f64x4;

use super::NONE;
use crate::skin::fit::{Moments, Spread};
use crate::skin::rotation::nearest_rotation;

/// Nodes that one task does at least.
const TASK: usize = 256;

/// The nodes of a pose. All but what [`pose`](Self::pose) finds follows from who carries which cell, and from links.
#[derive(Debug, Default)]
pub(super) struct Nodes {
    pub carrier: Vec<u32>,
    links: Vec<u32>,
    /// Rest position of each node [m].
    pub rest: Vec<DVec3>,
    /// Edge of the cube of cells that each carries [m].
    pub size: Vec<f64>,
    /// Cells that each carries.
    cells: Rows,
    /// Nodes that links lead to from each, ascending.
    adjacent: Rows,
    /// For each coarse node, with which vectors the motion around it follows from its own and that of the nodes linked to it; empty
    /// where these do not fill space.
    levers: Vec<Vec<(u32, DVec3)>>,
    /// Where the points of each node begin, and where the last ones end.
    points: Vec<u32>,
    /// Rest positions of points [m], and how far those of each node are apart [m].
    pub point: Vec<DVec3>,
    pub apart: Vec<f64>,
    /// (position [m], 1) and (velocity [m/s], 0) of points.
    pub state: Vec<[f64x4; 2]>,
}

/// Rows of numbers.
#[derive(Debug, Default)]
struct Rows {
    offsets: Vec<u32>,
    of: Vec<u32>,
}

impl Rows {
    fn of(&self, k: usize) -> &[u32] {
        &self.of[self.offsets[k] as usize..self.offsets[k + 1] as usize]
    }

    fn new(rows: &[Vec<u32>]) -> Self {
        let mut all = Self { offsets: vec![0], of: Vec::with_capacity(rows.iter().map(Vec::len).sum()) };
        for row in rows {
            all.of.extend(row);
            all.offsets.push(all.of.len() as u32);
        }
        all
    }
}

/// What has become of the nodes and points before; [`NONE`] of nodes that are not the same any more, or linked to others.
#[derive(Debug)]
pub(super) struct Since {
    pub node: Vec<u32>,
    pub point: Vec<u32>,
}

impl Nodes {
    /// The nodes of `pose` over cells of `size` [m] with these indices; `beside` are the cells across neighbour bits.
    pub fn new(pose: &LatticePose, index: &[[u32; 3]], beside: &[[u32; 26]], size: f64) -> Self {
        let n = pose.rest.len();
        let carrier = pose.carrier.to_vec();
        let cells = members(&carrier, n);
        let edge = |k: usize| {
            let own = || cells.of(k).iter().map(|&c| index[c as usize]);
            let longest = (0..3).map(|a| {
                let (low, high) = own().fold((u32::MAX, 0), |(low, high), i| (low.min(i[a]), high.max(i[a])));
                high.saturating_sub(low) + 1
            });
            f64::from(longest.max().unwrap_or(1)) * size
        };
        let sizes: Vec<f64> = (0..n).map(edge).collect();
        let linked = |seen: &mut Vec<u32>, k: usize| {
            let mut found = Vec::new();
            seen[k] = k as u32;
            for &c in cells.of(k) {
                let c = c as usize;
                for bit in (0..26).filter(|bit| pose.links[c] >> bit & 1 == 1) {
                    let Some(&to) = carrier.get(beside[c][bit] as usize) else { continue };
                    if seen[to as usize] != k as u32 {
                        seen[to as usize] = k as u32;
                        found.push(to);
                    }
                }
            }
            found.sort_unstable();
            found
        };
        let rows: Vec<Vec<u32>> =
            (0..n).into_par_iter().with_min_len(TASK).map_init(|| vec![NONE; n], linked).collect();
        let (mut points, mut point, mut apart) = (vec![0], Vec::with_capacity(n), Vec::with_capacity(n));
        for k in 0..n {
            if sizes[k] < 1.5 * size {
                point.push(pose.rest[k]);
                apart.push(sizes[k]);
            } else {
                point.extend(arms(sizes[k]).map(|arm| pose.rest[k] + arm));
                apart.push(sizes[k] / 2.0);
            }
            points.push(point.len() as u32);
        }
        let (rest, links, adjacent) = (pose.rest.to_vec(), pose.links.to_vec(), Rows::new(&rows));
        let (levers, state) = (Vec::new(), Vec::new());
        let mut nodes =
            Self { carrier, links, rest, size: sizes, cells, adjacent, levers, points, point, apart, state };
        nodes.levers = (0..n).into_par_iter().with_min_len(TASK).map(|k| nodes.find_levers(k)).collect();
        nodes
    }

    fn find_levers(&self, k: usize) -> Vec<(u32, DVec3)> {
        if self.points(k as u32).len() == 1 {
            return Vec::new();
        }
        let spread = Spread::of(self.around(k).map(|j| (self.size[j].powi(3), self.rest[j])), self.rest[k]);
        let Some(lever) = spread.levers(self.own_size(k)) else { return Vec::new() };
        let around = self.around(k).map(|j| (j as u32, lever(self.size[j].powi(3), self.rest[j])));
        around.collect()
    }

    /// A node and those linked to it.
    fn around(&self, k: usize) -> impl Iterator<Item = usize> {
        std::iter::once(k).chain(self.linked(k as u32).iter().map(|&j| j as usize))
    }

    /// The squared size of a coarse node for the fit around it [m²].
    fn own_size(&self, k: usize) -> f64 {
        (self.size[k] / 4.0).powi(2)
    }

    /// Whether these are the nodes of `pose`.
    pub fn are_of(&self, pose: &LatticePose) -> bool {
        self.carrier == pose.carrier && self.links == pose.links && self.rest == pose.rest
    }

    /// The nodes linked to `k`.
    pub fn linked(&self, k: u32) -> &[u32] {
        self.adjacent.of(k as usize)
    }

    /// The points of `k`.
    pub fn points(&self, k: u32) -> Range<u32> {
        self.points[k as usize]..self.points[k as usize + 1]
    }

    /// What has become of the nodes of `before`.
    pub fn since(&self, before: &Self) -> Since {
        // both are numbered in the order of their first cells, so rows of those that stay are ascending in both
        let same = |k: usize| {
            let cells = before.cells.of(k);
            let now = self.carrier.get(cells[0] as usize).copied().unwrap_or(NONE);
            let stays =
                now != NONE && self.cells.of(now as usize) == cells && self.rest[now as usize] == before.rest[k];
            if stays { now } else { NONE }
        };
        let moved: Vec<u32> = (0..before.rest.len()).map(same).collect();
        let linked_alike = |k: usize| {
            let now = before.linked(k as u32).iter().map(|&j| moved[j as usize]);
            moved[k] != NONE && now.eq(self.linked(moved[k]).iter().copied())
        };
        let node: Vec<u32> = (0..moved.len()).map(|k| if linked_alike(k) { moved[k] } else { NONE }).collect();
        let mut point = vec![NONE; before.point.len()];
        for k in (0..node.len()).filter(|&k| node[k] != NONE) {
            let (from, to) = (before.points(k as u32), self.points(node[k]));
            from.zip(to).for_each(|(from, to)| point[from as usize] = to);
        }
        Since { node, point }
    }

    /// Finds where points are, and how they move.
    pub fn pose(&mut self, pose: &LatticePose) {
        let mut state = std::mem::take(&mut self.state);
        state.resize(self.point.len(), [f64x4::ZERO; 2]);
        let motion = |k: usize| [pose.rest[k], pose.position[k], pose.velocity[k]];
        let lanes = |x: DVec3, w: f64| f64x4::new([x.x, x.y, x.z, w]);
        let rows = rows_of(&mut state, &self.points);
        rows.into_par_iter().enumerate().with_min_len(TASK).for_each(|(k, state)| {
            let [_, x, v] = motion(k);
            if let [state] = state {
                *state = [lanes(x, 1.0), lanes(v, 0.0)];
                return;
            }
            let (gradient, rate) = if self.levers[k].is_empty() {
                let turned = nearest_rotation(pose.deformation[k], DQuat::IDENTITY);
                let moments = Moments::of(self.around(k).map(|j| (self.size[j].powi(3), motion(j))), motion(k));
                let fit = moments.fit(self.own_size(k), turned);
                (fit.gradient, fit.rate)
            } else {
                let (mut gradient, mut rate) = (DMat3::ZERO, DMat3::ZERO);
                for &(j, lever) in &self.levers[k] {
                    let [_, y, w] = motion(j as usize);
                    let (y, w) = (y - x, w - v);
                    gradient += DMat3::from_cols(y * lever.x, y * lever.y, y * lever.z);
                    rate += DMat3::from_cols(w * lever.x, w * lever.y, w * lever.z);
                }
                (gradient, rate)
            };
            for (state, arm) in state.iter_mut().zip(arms(self.size[k])) {
                *state = [lanes(x + gradient * arm, 1.0), lanes(v + rate * arm, 0.0)];
            }
        });
        self.state = state;
    }
}

/// From the middle of a node of `size` to its eight points.
fn arms(size: f64) -> impl Iterator<Item = DVec3> {
    (0..8).map(move |corner: u32| {
        let side = |bit: u32| if corner >> bit & 1 == 1 { 0.25 } else { -0.25 };
        DVec3::new(side(0), side(1), side(2)) * size
    })
}

/// The cells of each of `n` nodes, ascending.
fn members(carrier: &[u32], n: usize) -> Rows {
    let mut offsets = vec![0u32; n + 1];
    carrier.iter().for_each(|&k| offsets[k as usize + 1] += 1);
    (0..n).for_each(|k| offsets[k + 1] += offsets[k]);
    let (mut cursor, mut of) = (offsets.clone(), vec![0; carrier.len()]);
    for (cell, &k) in carrier.iter().enumerate() {
        of[cursor[k as usize] as usize] = cell as u32;
        cursor[k as usize] += 1;
    }
    Rows { offsets, of }
}

/// `all` in rows that end at `ends[1..]`.
fn rows_of<'a, T>(mut all: &'a mut [T], ends: &[u32]) -> Vec<&'a mut [T]> {
    let mut rows = Vec::with_capacity(ends.len().saturating_sub(1));
    for pair in ends.windows(2) {
        let (row, rest) = all.split_at_mut((pair[1] - pair[0]) as usize);
        rows.push(row);
        all = rest;
    }
    rows
}
