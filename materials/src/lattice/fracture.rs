//! Fracture between the 26 neighbours at the finest level, by distance (Ohta et al., Sec. "Fracturing").
//!
//! Only links between two finest nodes are judged; where a body is coarse, it is subdivided before it can break. The stretch is
//! that of the distance against the one at rest, in the rest shape that has flowed there. Cells at a border hold little, and
//! their centres may lie close together; a link that is shorter than a cell is measured by the cell.

use fissure_engine::{BodyParticles, Link};
use rayon::prelude::*;

use super::Lattice;

/// Bits of the links that a cell judges: the other cell judges the rest.
const FORWARD: u32 = !0 << 13;

impl Lattice {
    /// Notes which links are too long.
    pub(super) fn judge(&mut self, p: &BodyParticles<'_>) {
        self.breaks = false;
        if !self.settings.breaks() {
            return;
        }
        let (finest, nodes, shapes) = (&self.finest, &self.nodes, &self.shapes);
        let (limit, size) = (self.settings.critical_stretch, finest.size());
        let flows = self.settings.per_node() && shapes.len() > 0;
        let (level, carrier, least) = (&nodes.level[..], &finest.carrier[..], (limit * size).powi(2));
        let (rest, links) = (&finest.rest[..], &finest.links[..]);
        self.breaking.resize(nodes.len(), 0);
        let judge = |(own, marks): (usize, &mut u32)| {
            *marks = 0;
            if level[own] > 0 {
                return false;
            }
            let cell = nodes.cells(own)[0] as usize;
            for (bit, other) in finest.by_bits(cell, links[cell] & FORWARD) {
                let to = carrier[other] as usize;
                if level[to] > 0 {
                    continue;
                }
                let mut xi = rest[other].as_dvec3() - rest[cell].as_dvec3();
                if flows {
                    xi = (shapes.get(own) * xi + shapes.get(to) * xi) * 0.5;
                }
                let (rest, long) = (xi.length_squared(), (p.position[to] - p.position[own]).length_squared());
                // (a + b)² > a² + b²: what is shorter needs no root
                if long > rest + least {
                    let (rest, long) = (rest.sqrt(), long.sqrt());
                    *marks |= u32::from(long - rest > limit * rest.max(size)) << bit;
                }
            }
            *marks != 0
        };
        let any = self.breaking.par_iter_mut().enumerate().with_min_len(1024).map(judge).reduce(|| false, |a, b| a | b);
        self.breaks = any;
    }

    /// Breaks the links noted.
    pub(super) fn part(&mut self, damage: &mut [f32], cuts: &mut Vec<Link>) {
        if !std::mem::take(&mut self.breaks) {
            return;
        }
        let first = cuts.len();
        let mut ends = Vec::new();
        for node in 0..self.nodes.len() {
            let mut marks = std::mem::take(&mut self.breaking[node]);
            let cell = self.nodes.cells(node)[0] as usize;
            if marks != 0 {
                ends.push(cell as u32);
            }
            while marks != 0 {
                let bit = marks.trailing_zeros() as usize;
                marks &= marks - 1;
                let other = self.finest.across(cell, bit);
                self.finest.part(cell, bit);
                ends.push(other as u32);
                cuts.push(Link { i: cell.min(other) as u32, j: cell.max(other) as u32 });
            }
        }
        cuts[first..].sort_unstable_by_key(|l| (l.i, l.j));
        ends.sort_unstable();
        ends.dedup();
        self.nodes.derive_links(&self.finest);
        let apart = |cut: &Link| !self.meet(cut.i as usize, cut.j as usize);
        match cuts[first..].iter().any(apart) {
            true => self.find_pieces(),
            false => self.derived.version += 1,
        }
        self.search.forget();
        let before = std::mem::take(&mut self.derived.regions);
        if self.settings.per_node() {
            let mut known: Vec<u32> =
                if self.derived.uniform.is_some() { Vec::new() } else { (0..before.len() as u32).collect() };
            if !known.is_empty() {
                for &end in &ends {
                    before
                        .of(self.finest.carrier[end as usize] as usize)
                        .for_each(|(r, _)| known[r] = super::cells::NONE);
                }
            }
            let now: Vec<u32> = (0..self.nodes.len() as u32).collect();
            self.connect(Some((&before, &known, &now)), Some(&ends));
        } else {
            self.inherit(before);
        }
        damage.copy_from_slice(&self.nodes.damage);
    }

    /// Whether a third cell is linked to both of two neighbours, so that they are of one piece for certain.
    fn meet(&self, a: usize, b: usize) -> bool {
        self.finest.linked(a).any(|(_, c)| self.finest.linked(b).any(|(_, d)| c == d))
    }

    /// Clusters anew: each remembers what the one of the same place did that its first node was in.
    fn inherit(&mut self, before: super::Regions) {
        let (turn, shapes) = (std::mem::take(&mut self.turn), std::mem::take(&mut self.shapes));
        self.connect(None, None);
        let regions = &self.derived.regions;
        let from: Vec<usize> = (0..regions.len())
            .map(|r| {
                let same = |old: &usize| before.key[*old] == regions.key[r];
                before.of(regions.home[r] as usize).map(|(old, _)| old).find(same).expect("a cluster only falls apart")
            })
            .collect();
        self.turn.set(from.iter().map(|&old| turn[old]).collect());
        if shapes.len() > 0 {
            self.shapes.set(from.iter().map(|&old| shapes.get(old)));
        }
        self.lists.found.clear();
    }
}
