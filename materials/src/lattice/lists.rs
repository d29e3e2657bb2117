//! Goals by plain sums over listed regions: adaptive lattices, clusters, and regions of a uniform lattice that a crack cuts.

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use wide::f64x4;

use super::matching::{EMPTY, Found, Rows, Turn, add_scaled, general, goal, lever, moment};
use super::nodes::Nodes;
use super::params::Settings;
use super::regions::{Regions, Still};
use super::shapes::Shapes;

/// Regions, or nodes, that one task does; a multiple of four.
const BLOCK: usize = 128;

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

    /// Matches all regions with nodes at `x`, as seen from `origin` [m].
    pub fn gather(
        &mut self,
        x: &[DVec3],
        origin: DVec3,
        nodes: &Nodes,
        regions: &Regions,
        turns: &[Turn],
        shapes: &Shapes,
        settings: &Settings,
    ) {
        let levers = &self.levers;
        self.moments.resize(nodes.len(), EMPTY);
        self.moments.par_iter_mut().enumerate().with_min_len(4 * BLOCK).for_each(|(i, rows)| {
            *rows = moment(nodes.mass[i], x[i] - origin, levers[i]);
        });
        let moments = &self.moments;
        self.goals.resize(regions.len(), EMPTY);
        self.found.resize(regions.len(), Found::default());
        let blocks = self.goals.par_chunks_mut(BLOCK).zip(self.found.par_chunks_mut(BLOCK)).enumerate();
        blocks.for_each(|(block, (goals, found))| {
            for k in (0..goals.len()).step_by(4) {
                // a last quad that is not full repeats its last region
                let at: [usize; 4] = std::array::from_fn(|l| block * BLOCK + (k + l).min(goals.len() - 1));
                let sums = at.map(|region| {
                    let mut sum = EMPTY;
                    for e in regions.row(region) {
                        add_scaled(&mut sum, &moments[regions.node[e] as usize], regions.share[e]);
                    }
                    sum
                });
                let still: [&Still; 4] = at.map(|region| &regions.still[region]);
                let slot = at.map(|region| regions.slot(region));
                let (turns, shapes) = (slot.map(|slot| turns[slot]), slot.map(|slot| shapes.get(slot)));
                let (g, f) = general(sums, still, turns, shapes, settings);
                let count = (goals.len() - k).min(4);
                goals[k..k + count].copy_from_slice(&g[..count]);
                found[k..k + count].copy_from_slice(&f[..count]);
            }
        });
    }

    /// Adds to `means` of each node the goals of its regions.
    pub fn scatter(&mut self, regions: &Regions, nodes: usize) {
        let goals = &self.goals;
        self.means.resize(nodes, EMPTY);
        self.means.par_iter_mut().enumerate().with_min_len(BLOCK).for_each(|(i, mean)| {
            *mean = EMPTY;
            for (region, share) in regions.of(i) {
                add_scaled(mean, &goals[region], share);
            }
        });
    }

    /// From `x`, seen from `origin` [m], to the mean goal of node `i`.
    #[inline(always)]
    pub fn way(&self, i: usize, x: DVec3, origin: DVec3) -> DVec3 {
        goal(&self.means[i], self.levers[i]) - (x - origin)
    }

    /// The mean of `of` over a region, and its gradient over rest positions, by least squares; 0 along axes in which the
    /// region has no extent.
    pub fn fit(&self, region: usize, of: &[DVec3], nodes: &Nodes, regions: &Regions) -> (DVec3, DMat3) {
        let still = &regions.still[region];
        let first = of[regions.node[regions.row(region).start] as usize];
        let (mut sum, mut mixed) = (DVec3::ZERO, DMat3::ZERO);
        for e in regions.row(region) {
            let i = regions.node[e] as usize;
            let m = regions.share[e] * nodes.mass[i];
            let (v, q) = ((of[i] - first) * m, nodes.rest[i] - still.centre);
            sum += v;
            mixed += DMat3::from_cols(v * q.x, v * q.y, v * q.z);
        }
        (first + sum / still.mass, mixed * still.inverse)
    }
}
