//! The surface follows the nodes.
//!
//! A vertex moves with the affine motion that fits its nodes best (moving least squares, as the skin of tetrahedra fits
//! its own). A node at X_k counts with a quadratic B-spline of (X − X_k) over the node's size along each axis: smooth from cell
//! to cell and over changes of level, exact for every affine motion, rigid for a node that is alone, which turns as its
//! regions do. Blending motions fitted around each node instead shows the cells at a bent surface, where nodes lie
//! irregularly: normals were off by 0.03 rad at a radius of 10 cells, as much as facets would be.
//!
//! Nodes count if links lead to them from the vertex's own cell through others near by: so the two sides of a crack go
//! each with their own, and around its end both do.
//!
//! A coarse node counts as eight points, half as far apart, which move with the motion fitted to it and its linked
//! neighbours: with one point its surroundings would be smoothed over twice the distance, and the surface would jump by as
//! much when nodes merge or split.

use std::ops::Range;

use fissure_engine::buffer::Buffer;
use fissure_engine::column::{Column, Of, Visitor};
use fissure_engine::lattice::{Cells, LatticePose, morton};
use glam::{DQuat, DVec3};
use rayon::prelude::*;

use super::{Facets, Patchwork};
use crate::skin::fit::Moments;
use crate::skin::rotation::nearest_rotation;

const NONE: u32 = u32::MAX;
/// Width of the splines over that of cells. Narrower ones find too few nodes where these lie irregularly.
const WIDTH: f64 = 1.5;
/// What a vertex's own node weighs more, for one that lies far from all.
const LEAST: f64 = 1e-9;

/// What is to be known of the cells to make a surface follow them.
#[derive(Clone, Debug, Default)]
pub struct Follower {
    /// Index of every cell.
    index: Buffer<[u32; 3]>,
    /// Edge of the cells [m].
    size: Buffer<f64>,
    /// The cells across the first 13 neighbour bits, or [`NONE`]; made when first needed.
    back: Vec<[u32; 13]>,
    positions: Vec<DVec3>,
    velocities: Vec<DVec3>,
}

impl Follower {
    pub(super) fn new(cells: &Cells) -> Self {
        Self { index: cells.index.clone().into(), size: vec![cells.size].into(), ..Self::default() }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.index.len()
    }

    /// Computes positions and velocities of all copies of `patchwork`. `origin` [m] is the origin of the rest positions of
    /// `pose`. The same bits on any number of threads.
    pub fn follow(&mut self, facets: &Facets, patchwork: &Patchwork, pose: &LatticePose, origin: DVec3) {
        self.know_neighbours();
        let nodes = self.sizes(pose);
        let finest = self.size[0];
        let (offsets, adjacent) = self.adjacent(pose, nodes.len());
        let next = |k: u32| &adjacent[offsets[k as usize] as usize..offsets[k as usize + 1] as usize];

        // the nodes that count for each cell at the surface: those that reach the box around its vertices
        let mut row = vec![NONE; self.cells()];
        let (mut surface, mut boxes) = (Vec::new(), Vec::new());
        for v in 0..patchwork.origin.len() {
            let x = facets.rest_position(patchwork.origin[v]) - origin;
            for &c in patchwork.cells_of(v) {
                if row[c as usize] == NONE {
                    row[c as usize] = surface.len() as u32;
                    surface.push(c);
                    boxes.push((x, x));
                }
                let around = &mut boxes[row[c as usize] as usize];
                *around = (around.0.min(x), around.1.max(x));
            }
        }
        let near: Vec<(Vec<u32>, DQuat)> = surface
            .par_iter()
            .zip(&boxes)
            .map_init(
                || vec![NONE; nodes.len()],
                |seen, (&c, &(low, high))| {
                    let counts = |k: u32| {
                        let (x, reach) = (pose.rest[k as usize], 1.5 * WIDTH * nodes[k as usize]);
                        (low - x).max(x - high).max_element() < reach
                    };
                    let own = pose.carrier[c as usize];
                    seen[own as usize] = c;
                    let mut found = vec![own];
                    let mut at = 0;
                    while at < found.len() {
                        for &k in next(found[at]) {
                            if seen[k as usize] != c && counts(k) {
                                seen[k as usize] = c;
                                found.push(k);
                            }
                        }
                        at += 1;
                    }
                    found.sort_unstable();
                    (found, nearest_rotation(pose.deformation[own as usize], DQuat::IDENTITY))
                },
            )
            .collect();

        let points = points(pose, &nodes, finest, &next);
        let follow = |counted: &mut Vec<(u32, f64)>, v: usize| {
            let rest = facets.rest_position(patchwork.origin[v]) - origin;
            let cells = patchwork.cells_of(v);
            let own = pose.carrier[cells[0] as usize];
            let of_cell = |c: u32| &near[row[c as usize] as usize];
            counted.clear();
            for &k in cells.iter().flat_map(|&c| &of_cell(c).0) {
                for point in points.of(k) {
                    let along = ((rest - points.at[point as usize][0]) / (WIDTH * points.apart[k as usize])).to_array();
                    let along = along.map(spline);
                    let weight = along[0] * along[1] * along[2] + if k == own { LEAST } else { 0.0 };
                    if weight > 0.0 {
                        counted.push((point, weight));
                    }
                }
            }
            if cells.len() > 1 {
                counted.sort_unstable_by_key(|c| c.0);
                counted.dedup_by_key(|c| c.0);
            }
            let state = |point: u32| points.at[point as usize];
            let about = state(points.of(own).start);
            let moments = Moments::of(counted.iter().map(|&(point, weight)| (weight, state(point))), about);
            let fit = moments.fit((points.apart[own as usize] / 4.0).powi(2), of_cell(cells[0]).1);
            moments.moved(&fit, rest)
        };
        (0..patchwork.origin.len())
            .into_par_iter()
            .map_init(Vec::new, follow)
            .unzip_into_vecs(&mut self.positions, &mut self.velocities);
    }

    /// Positions of the copies at the last call of [`follow`](Self::follow) [m].
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Velocities of the copies likewise [m/s].
    pub fn velocities(&self) -> &[DVec3] {
        &self.velocities
    }

    fn know_neighbours(&mut self) {
        if self.back.len() == self.index.len() {
            return;
        }
        let keys: Vec<u64> = self.index.iter().map(|&i| morton(i)).collect();
        let across = |index: [u32; 3], bit: usize| {
            let to = Cells::across(index, bit)?;
            keys.binary_search(&morton(to)).ok().map(|k| k as u32)
        };
        self.back =
            self.index.par_iter().map(|&index| std::array::from_fn(|bit| across(index, bit).unwrap_or(NONE))).collect();
    }

    /// Edge of the cube of cells that each node carries [m].
    fn sizes(&self, pose: &LatticePose) -> Vec<f64> {
        let mut boxes = vec![([u32::MAX; 3], [0u32; 3]); pose.rest.len()];
        for (cell, &k) in pose.carrier.iter().enumerate() {
            let (index, known) = (self.index[cell], &mut boxes[k as usize]);
            for axis in 0..3 {
                known.0[axis] = known.0[axis].min(index[axis]);
                known.1[axis] = known.1[axis].max(index[axis]);
            }
        }
        let longest =
            |(low, high): ([u32; 3], [u32; 3])| (0..3).map(|i| high[i].saturating_sub(low[i]) + 1).max().unwrap_or(1);
        boxes.into_iter().map(|b| f64::from(longest(b)) * self.size[0]).collect()
    }

    /// Which nodes links lead to from each, as offsets and numbers.
    fn adjacent(&self, pose: &LatticePose, nodes: usize) -> (Vec<u32>, Vec<u32>) {
        let of_cell = |cell: usize| {
            let from = pose.carrier[cell];
            (0..13).filter(move |&bit| pose.links[cell] >> bit & 1 == 1).filter_map(move |bit| {
                let to = self.back[cell][bit];
                (to != NONE && pose.carrier[to as usize] != from).then(|| (from, pose.carrier[to as usize]))
            })
        };
        let mut pairs: Vec<(u32, u32)> = (0..self.cells())
            .into_par_iter()
            .flat_map_iter(|cell| of_cell(cell).flat_map(|(a, b)| [(a, b), (b, a)]))
            .collect();
        pairs.par_sort_unstable();
        pairs.dedup();
        let mut offsets = vec![0u32; nodes + 1];
        pairs.iter().for_each(|&(a, _)| offsets[a as usize + 1] += 1);
        (0..nodes).for_each(|k| offsets[k + 1] += offsets[k]);
        (offsets, pairs.into_iter().map(|(_, b)| b).collect())
    }

    /// Whether this follows so many cells: what a restored file may get wrong.
    pub fn consistent(&self, cells: usize) -> bool {
        self.index.len() == cells && self.size.len() == 1 && self.size[0] > 0.0
    }

    /// Shows every column to `v`, under `scope`. Positions and velocities follow from the nodes and are none.
    pub fn visit(&mut self, scope: &str, v: &mut Visitor) {
        v(scope, &Column::frozen("cell_index", "1", Of::Thing), &mut self.index);
        v(scope, &Column::frozen("cell_size", "m", Of::Thing), &mut self.size);
    }
}

/// The points that nodes count as.
struct Points {
    /// Rest position, position and velocity of each.
    at: Vec<[DVec3; 3]>,
    /// Where those of each node begin, and where the last ones end.
    offsets: Vec<u32>,
    /// How far those of each node are apart [m].
    apart: Vec<f64>,
}

impl Points {
    fn of(&self, node: u32) -> Range<u32> {
        self.offsets[node as usize]..self.offsets[node as usize + 1]
    }
}

/// One point for each of the `finest` nodes, eight for each larger one; `next` are the nodes linked to each.
fn points<'a>(pose: &LatticePose, sizes: &[f64], finest: f64, next: &(impl Fn(u32) -> &'a [u32] + Sync)) -> Points {
    let state = |k: usize| [pose.rest[k], pose.position[k], pose.velocity[k]];
    let of_node = |k: usize| {
        if sizes[k] < 1.5 * finest {
            return vec![state(k)];
        }
        let turned = nearest_rotation(pose.deformation[k], DQuat::IDENTITY);
        let all = std::iter::once(k).chain(next(k as u32).iter().map(|&k| k as usize));
        let moments = Moments::of(all.map(|k| (sizes[k].powi(3), state(k))), state(k));
        let fit = moments.fit((sizes[k] / 4.0).powi(2), turned);
        let corner = |c: u32| {
            let side = |bit: u32| if c >> bit & 1 == 1 { 0.25 } else { -0.25 };
            let arm = DVec3::new(side(0), side(1), side(2)) * sizes[k];
            [pose.rest[k] + arm, pose.position[k] + fit.gradient * arm, pose.velocity[k] + fit.rate * arm]
        };
        (0..8).map(corner).collect()
    };
    let each: Vec<Vec<[DVec3; 3]>> = (0..sizes.len()).into_par_iter().map(of_node).collect();
    let mut offsets = vec![0];
    offsets.extend(each.iter().scan(0, |end, points| {
        *end += points.len() as u32;
        Some(*end)
    }));
    let apart =
        sizes.iter().zip(&each).map(|(size, points)| if points.len() > 1 { size / 2.0 } else { *size }).collect();
    Points { at: each.into_iter().flatten().collect(), offsets, apart }
}

/// The quadratic B-spline: those at whole numbers add up to 1 everywhere.
fn spline(t: f64) -> f64 {
    let t = t.abs();
    if t < 0.5 {
        0.75 - t * t
    } else if t < 1.5 {
        0.5 * (1.5 - t) * (1.5 - t)
    } else {
        0.0
    }
}
