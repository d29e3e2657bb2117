//! With which weights each vertex follows the points of nodes.

use glam::{DQuat, DVec3};
use rayon::prelude::*;
use wide::f64x4;

use fissure_engine::lattice::LatticePose;

use super::NONE;
use super::nodes::{Nodes, Since};
use crate::lattice::{Facets, Patchwork};
use crate::skin::fit::{Moments, Spread};
use crate::skin::rotation::nearest_rotation;

/// Width of the splines over that of cells. Narrower ones find too few nodes where these lie irregularly.
const WIDTH: f64 = 1.5;
/// What a vertex's own node weighs more, for one that lies far from all.
const LEAST: f64 = 1e-9;
/// Vertices whose weights are kept together.
const BLOCK: usize = 512;

/// The weights of all copies of a patchwork.
#[derive(Debug, Default)]
pub(super) struct Rows {
    origin: DVec3,
    /// The patchwork: vertex and cells of each copy.
    vertex: Vec<u32>,
    offsets: Vec<u32>,
    cells: Vec<u32>,
    /// Of each cell its number among those at the surface, or [`NONE`].
    number: Vec<u32>,
    near: Vec<Near>,
    blocks: Vec<Block>,
}

/// The nodes that count for a cell at the surface: those that reach the box around its vertices.
#[derive(Debug, Default)]
struct Near {
    cell: u32,
    low: DVec3,
    high: DVec3,
    nodes: Vec<u32>,
    /// Whether they were found in this call.
    fresh: bool,
}

/// The weights of some copies.
#[derive(Debug, Default)]
struct Block {
    rows: Vec<Row>,
    point: Vec<u32>,
    weight: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
struct Row {
    /// Where it ends.
    end: u32,
    /// The node of its cell.
    own: u32,
    /// Whether positions are sums with these weights; else they weigh points in a fit.
    linear: bool,
}

impl Block {
    fn row(&self, k: usize) -> (Row, &[u32], &[f64]) {
        let range = if k == 0 { 0 } else { self.rows[k - 1].end as usize }..self.rows[k].end as usize;
        (self.rows[k], &self.point[range.clone()], &self.weight[range])
    }

    fn end_row(&mut self, own: u32, linear: bool) {
        self.rows.push(Row { end: self.point.len() as u32, own, linear });
    }
}

impl Rows {
    /// Finds the weights of `patchwork`; those that were known stay where neither the copy nor the nodes near it have changed. `since`
    /// is nothing where all nodes are as they were.
    pub fn renew(
        &mut self,
        facets: &Facets,
        patchwork: &Patchwork,
        origin: DVec3,
        nodes: &Nodes,
        since: Option<&Since>,
    ) {
        let Patchwork { origin: vertex, offsets, cells, .. } = patchwork;
        let copies_stay = self.vertex == *vertex && self.offsets == *offsets && self.cells == *cells;
        let stay = self.origin == origin;
        if stay && copies_stay && since.is_none() {
            return;
        }
        let old = std::mem::take(self);
        let before = if !stay {
            vec![NONE; vertex.len()]
        } else if copies_stay {
            (0..vertex.len() as u32).collect()
        } else {
            old.copies(patchwork)
        };
        (self.vertex, self.offsets, self.cells) = (vertex.clone(), offsets.clone(), cells.clone());
        self.origin = origin;
        self.find_near(facets, patchwork, nodes, if stay { Some((&old, since)) } else { None });
        let this = &*self;
        let starts: Vec<usize> = (0..vertex.len()).step_by(BLOCK).collect();
        let block = |found: &mut Vec<(u32, f64)>, start: usize| {
            let mut block = Block::default();
            for v in start..(start + BLOCK).min(vertex.len()) {
                let around = patchwork.cells_of(v);
                let known = before[v] != NONE && around.iter().all(|&c| !this.near_cell(c).fresh);
                if known {
                    old.keep(before[v], since, &mut block);
                } else {
                    this.weigh(facets.rest_position(vertex[v]) - origin, around, nodes, found, &mut block);
                }
            }
            block
        };
        self.blocks = starts.into_par_iter().map_init(Vec::new, block).collect();
    }

    fn near_cell(&self, cell: u32) -> &Near {
        &self.near[self.number[cell as usize] as usize]
    }

    fn cells_of(&self, v: usize) -> &[u32] {
        &self.cells[self.offsets[v] as usize..self.offsets[v + 1] as usize]
    }

    /// The copy that each copy of `patchwork` was, or [`NONE`].
    fn copies(&self, patchwork: &Patchwork) -> Vec<u32> {
        let most = self.vertex.iter().chain(&patchwork.origin).max().map_or(0, |&v| v as usize + 1);
        let (mut first, mut next) = (vec![NONE; most], vec![NONE; self.vertex.len()]);
        for (copy, &v) in self.vertex.iter().enumerate() {
            next[copy] = std::mem::replace(&mut first[v as usize], copy as u32);
        }
        let find = |copy: usize| {
            let mut at = first[patchwork.origin[copy] as usize];
            while at != NONE && self.cells_of(at as usize) != patchwork.cells_of(copy) {
                at = next[at as usize];
            }
            at
        };
        (0..patchwork.origin.len()).into_par_iter().with_min_len(4096).map(find).collect()
    }

    /// Finds the nodes near each cell at the surface, where they are not those of `old`.
    fn find_near(
        &mut self,
        facets: &Facets,
        patchwork: &Patchwork,
        nodes: &Nodes,
        old: Option<(&Self, Option<&Since>)>,
    ) {
        self.number = vec![NONE; nodes.carrier.len()];
        for v in 0..patchwork.origin.len() {
            let x = facets.rest_position(patchwork.origin[v]) - self.origin;
            for &cell in patchwork.cells_of(v) {
                let number = &mut self.number[cell as usize];
                if *number == NONE {
                    *number = self.near.len() as u32;
                    self.near.push(Near { cell, low: x, high: x, ..Near::default() });
                }
                let near = &mut self.near[*number as usize];
                (near.low, near.high) = (near.low.min(x), near.high.max(x));
            }
        }
        self.near.par_iter_mut().with_min_len(64).for_each_init(
            || vec![NONE; nodes.rest.len()],
            |seen, near| {
                if let Some((old, since)) = old
                    && near.stays(old, since)
                {
                    return;
                }
                near.find(nodes, seen);
            },
        );
    }

    /// Adds the row of copy `v` to `block`, which has the points of now.
    fn keep(&self, v: u32, since: Option<&Since>, block: &mut Block) {
        let (row, point, weight) = self.blocks[v as usize / BLOCK].row(v as usize % BLOCK);
        match since {
            None => block.point.extend(point),
            Some(since) => block.point.extend(point.iter().map(|&p| since.point[p as usize])),
        }
        block.weight.extend(weight);
        block.end_row(since.map_or(row.own, |since| since.node[row.own as usize]), row.linear);
    }

    /// Adds the row of a copy that rests at `x` among `cells`.
    fn weigh(&self, x: DVec3, cells: &[u32], nodes: &Nodes, found: &mut Vec<(u32, f64)>, block: &mut Block) {
        let own = nodes.carrier[cells[0] as usize];
        found.clear();
        for &k in cells.iter().flat_map(|&c| &self.near_cell(c).nodes) {
            let (points, apart) = (nodes.points(k), nodes.apart[k as usize]);
            // all points of a node that is far away are
            let spread = if points.len() > 1 { 0.5 * apart } else { 0.0 };
            let least = if k == own { LEAST } else { 0.0 };
            let near = (x - nodes.rest[k as usize]).abs().max_element() < 1.5 * WIDTH * apart + spread;
            if !near && least == 0.0 {
                continue;
            }
            let over = 1.0 / (WIDTH * apart);
            for point in points {
                let along = ((x - nodes.point[point as usize]) * over).abs();
                let weight = spline(along.x) * spline(along.y) * spline(along.z) + least;
                if weight > 0.0 {
                    found.push((point, weight));
                }
            }
        }
        if cells.len() > 1 {
            found.sort_unstable_by_key(|c| c.0);
            found.dedup_by_key(|c| c.0);
        }
        let weighted = || found.iter().map(|&(point, weight)| (weight, nodes.point[point as usize]));
        let spread = Spread::of(weighted(), x);
        let share = spread.shares(own_size(nodes, own), x);
        block.point.extend(found.iter().map(|&(point, _)| point));
        match &share {
            Some(share) => block.weight.extend(weighted().map(|(w, at)| share(w, at))),
            None => block.weight.extend(weighted().map(|(w, _)| w)),
        }
        block.end_row(own, share.is_some());
    }

    /// Positions and velocities of all copies.
    pub fn sum(
        &self,
        facets: &Facets,
        patchwork: &Patchwork,
        origin: DVec3,
        nodes: &Nodes,
        pose: &LatticePose,
        [positions, velocities]: [&mut Vec<DVec3>; 2],
    ) {
        positions.resize(patchwork.origin.len(), DVec3::ZERO);
        velocities.resize(patchwork.origin.len(), DVec3::ZERO);
        let out = positions.par_chunks_mut(BLOCK).zip(velocities.par_chunks_mut(BLOCK));
        self.blocks.par_iter().zip(out).enumerate().for_each(|(b, (block, (positions, velocities)))| {
            for (k, (x, v)) in positions.iter_mut().zip(velocities).enumerate() {
                let (row, point, weight) = block.row(k);
                (*x, *v) = if row.linear {
                    summed(point, weight, &nodes.state, nodes.points(row.own).start)
                } else {
                    let rest = facets.rest_position(patchwork.origin[b * BLOCK + k]) - origin;
                    fitted(point, weight, nodes, row.own, pose, rest)
                };
            }
        });
    }
}

impl Near {
    /// Takes the nodes from `old`, if they are the same still.
    fn stays(&mut self, old: &Rows, since: Option<&Since>) -> bool {
        let Some(old) = old.number.get(self.cell as usize).and_then(|&k| old.near.get(k as usize)) else {
            return false;
        };
        let now = |&k: &u32| since.map_or(k, |since| since.node[k as usize]);
        if (old.low, old.high) != (self.low, self.high) || old.nodes.iter().any(|k| now(k) == NONE) {
            return false;
        }
        self.nodes = old.nodes.iter().map(now).collect();
        true
    }

    /// Walks to them over links.
    fn find(&mut self, nodes: &Nodes, seen: &mut [u32]) {
        let counts = |k: u32| {
            let (x, reach) = (nodes.rest[k as usize], 1.5 * WIDTH * nodes.size[k as usize]);
            (self.low - x).max(x - self.high).max_element() < reach
        };
        let own = nodes.carrier[self.cell as usize];
        seen[own as usize] = self.cell;
        let (mut found, mut at) = (vec![own], 0);
        while at < found.len() {
            for &k in nodes.linked(found[at]) {
                if seen[k as usize] != self.cell && counts(k) {
                    seen[k as usize] = self.cell;
                    found.push(k);
                }
            }
            at += 1;
        }
        found.sort_unstable();
        (self.nodes, self.fresh) = (found, true);
    }
}

/// The squared size of what a vertex of node `own` lies in [m²].
fn own_size(nodes: &Nodes, own: u32) -> f64 {
    (nodes.apart[own as usize] / 4.0).powi(2)
}

fn vector(x: f64x4) -> DVec3 {
    let [x, y, z, _] = x.to_array();
    DVec3::new(x, y, z)
}

/// Position and velocity as sums over points, as seen from the point `own`, lest rounding errors of weights be multiplied by places.
#[inline]
fn summed(point: &[u32], weight: &[f64], state: &[[f64x4; 2]], own: u32) -> (DVec3, DVec3) {
    let mut sum = [f64x4::ZERO; 2];
    for (&p, &w) in point.iter().zip(weight) {
        let ([x, v], w) = (state[p as usize], f64x4::splat(w));
        sum[0] += x * w;
        sum[1] += v * w;
    }
    let left = f64x4::splat(1.0 - sum[0].to_array()[3]);
    let [x, v] = state[own as usize];
    (vector(sum[0] + x * left), vector(sum[1] + v * left))
}

/// Position and velocity at `rest` by the motion that fits the weighted points.
#[cold]
fn fitted(point: &[u32], weight: &[f64], nodes: &Nodes, own: u32, pose: &LatticePose, rest: DVec3) -> (DVec3, DVec3) {
    let at = |p: u32| {
        let [x, v] = nodes.state[p as usize];
        [nodes.point[p as usize], vector(x), vector(v)]
    };
    let weighted = point.iter().zip(weight).map(|(&p, &w)| (w, at(p)));
    let moments = Moments::of(weighted, at(nodes.points(own).start));
    let turned = nearest_rotation(pose.deformation[own as usize], DQuat::IDENTITY);
    let fit = moments.fit(own_size(nodes, own), turned);
    moments.moved(&fit, rest)
}

/// The quadratic B-spline for t ≥ 0: those at whole numbers add up to 1 everywhere.
fn spline(t: f64) -> f64 {
    if t < 0.5 {
        0.75 - t * t
    } else {
        let left = (1.5 - t).max(0.0);
        0.5 * left * left
    }
}
