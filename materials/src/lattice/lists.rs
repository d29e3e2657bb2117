//! Goals by plain sums over listed regions: adaptive lattices, clusters, and regions of a uniform lattice that a crack cuts.

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use wide::f64x4;

use super::matching::{EMPTY, Found, Rows, Turn, Wanted, general, goal, lever, moment, sum_of};
use super::nodes::Nodes;
use super::regions::{Regions, Still};
use super::shapes::Shapes;

/// Regions of a block; a multiple of four.
const BLOCK: usize = 128;
/// Nodes or regions that one task does at least: waking another thread takes as long.
const TASK: usize = 1024;

/// What matching listed regions needs and finds; nothing of it must survive a step.
#[derive(Debug, Default)]
pub struct Lists {
    levers: Vec<f64x4>,
    moments: Vec<Rows>,
    goals: Vec<Rows>,
    pub found: Vec<Found>,
    /// Mean goal of each node.
    pub means: Vec<Rows>,
}

impl Lists {
    /// Levers of nodes, which only change with them.
    pub fn settle(&mut self, nodes: &Nodes) {
        self.levers.clear();
        self.levers.extend(nodes.rest.iter().map(|&r| lever(r)));
    }

    /// Matches all regions with nodes at `x` [m], as seen from the first.
    pub fn gather(
        &mut self,
        x: &[DVec3],
        nodes: &Nodes,
        regions: &Regions,
        turns: &[Turn],
        shapes: &Shapes,
        wanted: Wanted<'_>,
    ) {
        let (levers, origin) = (&self.levers, x[0]);
        self.moments.resize(nodes.len(), EMPTY);
        self.moments.par_iter_mut().enumerate().with_min_len(TASK).for_each(|(i, rows)| {
            *rows = moment(nodes.mass[i], x[i] - origin, levers[i]);
        });
        let moments = &self.moments;
        self.goals.resize(regions.len(), EMPTY);
        self.found.resize(regions.len(), Found::default());
        let blocks = self
            .goals
            .par_chunks_mut(BLOCK)
            .zip(self.found.par_chunks_mut(BLOCK))
            .enumerate()
            .with_min_len(TASK / BLOCK);
        blocks.for_each(|(block, (goals, found))| {
            for k in (0..goals.len()).step_by(4) {
                // a last quad that is not full repeats its last region
                let at: [usize; 4] = std::array::from_fn(|l| block * BLOCK + (k + l).min(goals.len() - 1));
                let sums = at.map(|region| {
                    let row = regions.row(region);
                    sum_of(moments, &regions.node[row.clone()], &regions.share[row])
                });
                let still: [&Still; 4] = at.map(|region| &regions.still[region]);
                let slot = at.map(|region| regions.slot(region));
                let (turns, shapes) = (slot.map(|slot| turns[slot]), slot.map(|slot| shapes.get(slot)));
                let quad = k..(k + 4).min(goals.len());
                general(sums, still, turns, shapes, wanted, &mut goals[quad.clone()], &mut found[quad]);
            }
        });
    }

    /// Adds to `means` of each node the goals of its regions.
    pub fn scatter(&mut self, regions: &Regions, nodes: usize) {
        let goals = &self.goals;
        self.means.resize(nodes, EMPTY);
        self.means.par_iter_mut().enumerate().with_min_len(TASK).for_each(|(i, mean)| {
            let row = regions.row_of(i);
            *mean = sum_of(goals, &regions.region[row.clone()], &regions.node_share[row]);
        });
    }

    /// From `x`, seen from `origin` [m], to the mean goal of node `i`.
    #[inline(always)]
    pub fn way(&self, i: usize, x: DVec3, origin: DVec3) -> DVec3 {
        goal(&self.means[i], self.levers[i]) - (x - origin)
    }

    /// What rest vectors about a node have become: the mean over its regions, after all was gathered.
    pub fn gradient(&self, node: usize, regions: &Regions) -> DMat3 {
        regions.of(node).fold(DMat3::ZERO, |sum, (region, share)| sum + self.found[region].gradient * share)
    }
}
