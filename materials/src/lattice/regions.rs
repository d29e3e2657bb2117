//! Regions as lists: who is matched together, and with which share.
//!
//! The region of a node is all cells that can be reached from its own over no more than w links, as in FastLSM; the region of
//! a coarse node is then the union of those of its cells (Ohta et al., Sec. "Preprocessing"). Links are those that hold, so a
//! region ends at a crack. A node that lies partly in a region enters with the mass m_iR of its cells inside (Eq. 6).
//!
//! A node lies in many regions, and goes to the mean of their goals with weights m_iR/Σ_R' m_iR'. If it also enters each match
//! with that share of its mass, the goals of a region neither push nor turn its nodes as a whole, and the update keeps linear
//! and angular momentum.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::cells::{Finest, NONE};
use super::nodes::Nodes;
use super::params::{Method, Settings};
use super::rotation::eigen;

/// Regions that one task finds.
const BLOCK: usize = 256;
/// Axes along which a region is thinner than this share of its longest say nothing about stretch.
const THIN: f64 = 1e-4;

/// What of a region does not change while it has the same nodes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Still {
    /// Mass [kg] and centre of mass at rest [m], with the shares of nodes.
    pub mass: f64,
    pub centre: DVec3,
    /// (Σ m q qᵀ)⁻¹ of Eq. 6 [1/(kg m²)], along the axes in which the region has an extent.
    pub inverse: DMat3,
    /// Onto the axes in which it has none.
    pub lost: DMat3,
    /// Whether there are such axes.
    pub flat: bool,
    /// β of Eq. 10.
    pub beta: f64,
}

impl Still {
    /// Of a region with this mass [kg], centre [m] and Σ m q qᵀ [kg m²].
    pub fn new(mass: f64, centre: DVec3, spread: DMat3, beta: f64) -> Self {
        let (inverse, lost) = inverse(spread);
        Self { mass, centre, inverse, lost, flat: lost != DMat3::ZERO, beta }
    }
}

/// Rows of nodes, and the same seen from nodes.
#[derive(Debug, Default)]
pub struct Regions {
    /// The node around whose cells a region is, or its first.
    pub home: Vec<u32>,
    pub offsets: Vec<u32>,
    pub node: Vec<u32>,
    /// m_iR [kg].
    inside: Vec<f64>,
    /// m_iR/Σ_R' m_iR' [1].
    pub share: Vec<f64>,
    pub still: Vec<Still>,
    /// Which cluster, for methods with regions that belong to no node; else empty.
    pub key: Vec<u64>,
    /// The region before that each is, of the same nodes, or [`NONE`]; empty where none is known.
    from: Vec<u32>,
    /// Σ_R m_iR of each node [kg].
    total: Vec<f64>,
    /// Regions of each node.
    pub node_offsets: Vec<u32>,
    pub region: Vec<u32>,
    pub node_share: Vec<f64>,
}

impl Regions {
    /// Number of regions.
    pub fn len(&self) -> usize {
        self.home.len()
    }

    /// Entries of a region.
    #[inline(always)]
    pub fn row(&self, region: usize) -> std::ops::Range<usize> {
        self.offsets[region] as usize..self.offsets[region + 1] as usize
    }

    /// Nodes of a region with the share of each.
    #[inline(always)]
    pub fn members(&self, region: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let row = self.row(region);
        self.node[row.clone()].iter().zip(&self.share[row]).map(|(&node, &share)| (node as usize, share))
    }

    /// Entries of a node.
    #[inline(always)]
    pub fn row_of(&self, node: usize) -> std::ops::Range<usize> {
        self.node_offsets[node] as usize..self.node_offsets[node + 1] as usize
    }

    /// Regions of a node with its share in each.
    #[inline(always)]
    pub fn of(&self, node: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let row = self.row_of(node);
        self.region[row.clone()].iter().zip(&self.node_share[row]).map(|(&region, &share)| (region as usize, share))
    }

    /// Where what a region remembers is kept: with its node, or by its own number.
    #[inline(always)]
    pub fn slot(&self, region: usize) -> usize {
        if self.key.is_empty() { self.home[region] as usize } else { region }
    }

    fn clear(&mut self) {
        self.home.clear();
        self.offsets.clear();
        self.offsets.push(0);
        self.node.clear();
        self.inside.clear();
        self.key.clear();
        self.from.clear();
    }

    fn push(&mut self, home: u32, row: impl Iterator<Item = (u32, f64)>) {
        self.home.push(home);
        for (node, inside) in row {
            self.node.push(node);
            self.inside.push(inside);
        }
        self.offsets.push(self.node.len() as u32);
    }

    /// Finds the regions around `homes`. `known` tells of a home the region of `before` that it had, if that is the same but
    /// for the numbers of nodes, which `now` gives.
    pub fn around(
        &mut self,
        homes: &[u32],
        finest: &Finest,
        nodes: &Nodes,
        half_width: u32,
        before: Option<(&Self, &[u32], &[u32])>,
    ) {
        let same = |home: u32| before.map_or(NONE, |(_, known, _)| known[home as usize]);
        let wanted: Vec<u32> = homes.iter().copied().filter(|&h| same(h) == NONE).collect();
        let found: Vec<Vec<(u32, f64)>> = wanted
            .par_chunks(BLOCK)
            .map_init(
                || Walker::new(finest.len(), nodes.len()),
                |walker, homes| {
                    homes
                        .iter()
                        .map(|&h| walker.region(finest, nodes.cells(h as usize), half_width))
                        .collect::<Vec<_>>()
                },
            )
            .flatten()
            .collect();
        let mut found = found.into_iter();
        self.clear();
        for &home in homes {
            match (same(home), before) {
                (region, Some((old, _, now))) if region != NONE => {
                    let row = old.row(region as usize);
                    self.push(home, row.map(|k| (now[old.node[k] as usize], old.inside[k])));
                    self.from.push(region);
                }
                _ => {
                    self.push(home, found.next().expect("one for each").into_iter());
                    self.from.push(NONE);
                }
            }
        }
    }

    /// Finds clusters, and nothing of finest cells: one region for each piece, or for each part of overlapping cubes.
    pub fn clusters(&mut self, finest: &Finest, nodes: &Nodes, settings: &Settings) {
        self.clear();
        let (piece, pieces) = nodes.pieces(finest);
        if settings.method == Method::Single {
            let mut rows = vec![Vec::new(); pieces];
            (0..nodes.len()).for_each(|k| rows[piece[k] as usize].push((k as u32, nodes.mass[k])));
            for row in rows {
                self.key.push(0);
                self.push(row[0].0, row.into_iter());
            }
            return;
        }
        // every cell is in two cubes along each axis: those that begin at its own stride and the one before
        let stride = settings.half_width + 1;
        let mut places: Vec<(u64, u32)> = Vec::with_capacity(8 * finest.len());
        for (cell, index) in finest.index.iter().enumerate() {
            for corner in 0..8u32 {
                let at: [u64; 3] = std::array::from_fn(|a| u64::from(index[a] / stride + (corner >> a & 1)));
                places.push((at[0] | at[1] << 21 | at[2] << 42, cell as u32));
            }
        }
        places.par_sort_unstable();
        let (mut of, mut stack) = (vec![NONE; finest.len()], Vec::new());
        for cube in places.chunk_by(|a, b| a.0 == b.0) {
            cube.iter().for_each(|&(_, cell)| of[cell as usize] = 0);
            for &(key, start) in cube {
                if of[start as usize] != 0 {
                    continue;
                }
                let mut row = vec![start];
                of[start as usize] = 1;
                stack.push(start);
                while let Some(cell) = stack.pop() {
                    for (_, other) in finest.linked(cell as usize) {
                        if of[other] == 0 {
                            of[other] = 1;
                            row.push(other as u32);
                            stack.push(other as u32);
                        }
                    }
                }
                row.sort_unstable();
                self.key.push(key);
                self.push(row[0], row.into_iter().map(|cell| (cell, finest.mass[cell as usize])));
            }
            cube.iter().for_each(|&(_, cell)| of[cell as usize] = NONE);
        }
    }

    /// The mass [kg] that each node has in all regions together.
    pub fn totals(&self, nodes: usize) -> Vec<f64> {
        let mut total = vec![0.0; nodes];
        self.node.iter().zip(&self.inside).for_each(|(&node, inside)| total[node as usize] += inside);
        total
    }

    /// Shares, and rows seen from nodes; `total` is the mass [kg] of each in all regions, also those that are not listed.
    pub fn divide(&mut self, total: &[f64]) {
        let nodes = total.len();
        self.node_offsets.clear();
        self.node_offsets.resize(nodes + 1, 0);
        self.node.iter().for_each(|&node| self.node_offsets[node as usize + 1] += 1);
        (0..nodes).for_each(|k| self.node_offsets[k + 1] += self.node_offsets[k]);
        self.share.clear();
        self.share.extend(self.node.iter().zip(&self.inside).map(|(&node, inside)| inside / total[node as usize]));
        let mut cursor = self.node_offsets.clone();
        self.region.resize(self.node.len(), 0);
        self.node_share.resize(self.node.len(), 0.0);
        for region in 0..self.len() {
            for k in self.row(region) {
                let to = &mut cursor[self.node[k] as usize];
                self.region[*to as usize] = region as u32;
                self.node_share[*to as usize] = self.share[k];
                *to += 1;
            }
        }
        self.total.clear();
        self.total.extend(total);
    }

    /// The region of `before` that this one is, with the same shares.
    fn kept(&self, region: usize, before: Option<&Self>) -> Option<usize> {
        let (old, from) = (before?, *self.from.get(region).filter(|&&from| from != NONE)? as usize);
        let mut nodes = old.node[old.row(from)].iter().zip(&self.node[self.row(region)]);
        nodes.all(|(&then, &now)| old.total[then as usize] == self.total[now as usize]).then_some(from)
    }

    /// What follows from shares and rest positions; `unit` is the mass [kg] of a full finest cell, `fine` the
    /// [spread](fine_spread) of the region of each cell in the uniform lattice. `before` are the regions that some of these were.
    pub fn settle(&mut self, nodes: &Nodes, settings: &Settings, unit: f64, fine: &[f64], before: Option<&Self>) {
        let mut still = std::mem::take(&mut self.still);
        still.clear();
        still.resize(self.len(), Still::default());
        still.par_iter_mut().enumerate().with_min_len(512).for_each(|(region, still)| {
            if let Some(from) = self.kept(region, before) {
                *still = before.expect("it is of these").still[from];
                return;
            }
            let first = nodes.rest[self.node[self.row(region).start] as usize];
            let (mut mass, mut moment) = (0.0, DVec3::ZERO);
            for (i, share) in self.members(region) {
                mass += share * nodes.mass[i];
                moment += (nodes.rest[i] - first) * (share * nodes.mass[i]);
            }
            let centre = first + moment / mass;
            let mut spread = DMat3::ZERO;
            for (i, share) in self.members(region) {
                let (q, m) = (nodes.rest[i] - centre, share * nodes.mass[i]);
                spread += DMat3::from_cols(q * (q.x * m), q * (q.y * m), q * (q.z * m));
            }
            *still = Still::new(mass, centre, spread, 0.0);
            let home = self.home[region] as usize;
            if settings.method == Method::Ohta && settings.as_written {
                still.beta = beta(settings.half_width, nodes.mass[home] / unit);
            } else if settings.method == Method::Ohta && !fine.is_empty() {
                still.beta = beta_of_spread(nodes.cells(home), fine, trace(spread) / mass);
            }
        });
        self.still = still;
    }
}

/// β of Eq. 10 for a node of so many full finest cells.
fn beta(half_width: u32, mass: f64) -> f64 {
    let twice = 2.0 * f64::from(half_width);
    (1.0 - ((twice + 1.0) / (twice + mass.cbrt())).powi(3)).max(0.0)
}

/// β that makes a region as stiff as those of its cells were in the uniform lattice. Goals are means over regions of means
/// over nodes, so they pull along u'' with the variance of node positions within regions; β takes its share of that away.
/// Along one axis and for w = 1 this is 2/3 for nodes of two cells and 7/8 for nodes of four, where Eq. 10 has 0.58 and 7/8;
/// for w = 2 it is 1/4 and 3/4, where Eq. 10 has 0.42 and 0.76.
fn beta_of_spread(cells: &[u32], fine: &[f64], spread: f64) -> f64 {
    let mean = cells.iter().map(|&c| fine[c as usize]).sum::<f64>() / cells.len() as f64;
    if spread > mean { 1.0 - mean / spread } else { 0.0 }
}

/// The mean squared distance [m²] of cells from the centre of the region around each cell of the fresh uniform lattice.
pub fn fine_spread(finest: &Finest, half_width: u32) -> Vec<f64> {
    let spread = |walker: &mut Walker, c: u32| {
        let home = finest.place(c as usize);
        let (mut n, mut moment, mut square) = (0.0, DVec3::ZERO, 0.0);
        for &cell in walker.once_reached(finest, &[c], half_width) {
            let r = finest.place(cell as usize) - home;
            n += 1.0;
            moment += r;
            square += r.length_squared();
        }
        square / n - (moment / n).length_squared()
    };
    let all = (0..finest.len() as u32).into_par_iter().with_min_len(1024);
    all.map_init(|| Walker::new(finest.len(), 0), |walker, c| spread(walker, c)).collect()
}

fn trace(m: DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// The inverse of a symmetric matrix along the axes where it is not next to nothing, and what projects onto the others.
pub fn inverse(spread: DMat3) -> (DMat3, DMat3) {
    if spread.determinant() > THIN * trace(spread).powi(3) {
        return (spread.inverse(), DMat3::ZERO);
    }
    let (values, vectors) = eigen(spread.to_cols_array_2d());
    let most = values.iter().fold(0.0, |a: f64, b| a.max(*b));
    let (mut inverse, mut lost) = (DMat3::ZERO, DMat3::ZERO);
    for (value, v) in values.iter().zip(vectors) {
        let v = DVec3::from_array(v);
        let onto = DMat3::from_cols(v * v.x, v * v.y, v * v.z);
        if *value > THIN * THIN * most {
            inverse += onto * (1.0 / value);
        } else {
            lost += onto;
        }
    }
    (inverse, lost)
}

/// Walks over links.
#[derive(Debug, Default)]
pub struct Walker {
    seen: Vec<u32>,
    round: u32,
    cells: Vec<u32>,
    weight: Vec<f64>,
}

impl Walker {
    /// For so many cells and nodes.
    pub fn new(cells: usize, nodes: usize) -> Self {
        Self { seen: vec![0; cells], round: 0, cells: Vec::new(), weight: vec![0.0; nodes] }
    }

    /// All cells within `half_width` links of `start`.
    pub fn reach(&mut self, finest: &Finest, start: &[u32], half_width: u32) -> &[u32] {
        self.walk(start, half_width, |cell| finest.linked(cell))
    }

    /// The same over links that may be broken by now.
    pub fn once_reached(&mut self, finest: &Finest, start: &[u32], half_width: u32) -> &[u32] {
        self.walk(start, half_width, |cell| finest.once_linked(cell))
    }

    fn walk<I: Iterator<Item = (usize, usize)>>(
        &mut self,
        start: &[u32],
        half_width: u32,
        linked: impl Fn(usize) -> I,
    ) -> &[u32] {
        self.round += 1;
        self.cells.clear();
        self.cells.extend(start);
        start.iter().for_each(|&c| self.seen[c as usize] = self.round);
        let mut from = 0;
        for _ in 0..half_width {
            let to = self.cells.len();
            for k in from..to {
                for (_, other) in linked(self.cells[k] as usize) {
                    if self.seen[other] != self.round {
                        self.seen[other] = self.round;
                        self.cells.push(other as u32);
                    }
                }
            }
            from = to;
        }
        &self.cells
    }

    /// The nodes of the region around some cells, in order, with the mass [kg] of each inside.
    fn region(&mut self, finest: &Finest, start: &[u32], half_width: u32) -> Vec<(u32, f64)> {
        self.reach(finest, start, half_width);
        let mut row: Vec<(u32, f64)> = Vec::with_capacity(32);
        for &cell in &self.cells {
            let node = finest.carrier[cell as usize];
            let weight = &mut self.weight[node as usize];
            if *weight == 0.0 {
                row.push((node, 0.0));
            }
            *weight += finest.mass[cell as usize];
        }
        row.sort_unstable_by_key(|e| e.0);
        row.iter_mut().for_each(|(node, inside)| *inside = std::mem::take(&mut self.weight[*node as usize]));
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beta_is_that_of_equation_10() {
        assert_eq!(beta(1, 1.0), 0.0);
        assert_eq!(beta(2, 0.3), 0.0); // a cell that is not full is as stiff as one that is
        assert!((beta(1, 8.0) - (1.0 - 27.0 / 64.0)).abs() < 1e-15);
        assert!((beta(2, 8.0) - (1.0 - 125.0 / 216.0)).abs() < 1e-15);
    }

    #[test]
    fn flat_and_line_like_spreads_have_an_inverse_where_they_can() {
        let (full, none) = inverse(DMat3::from_diagonal(DVec3::new(2.0, 4.0, 5.0)));
        assert!((full.y_axis.y - 0.25).abs() < 1e-15 && none == DMat3::ZERO);
        let (flat, lost) = inverse(DMat3::from_diagonal(DVec3::new(2.0, 0.0, 5.0)));
        assert_eq!((flat, lost), (DMat3::from_diagonal(DVec3::new(0.5, 0.0, 0.2)), DMat3::from_diagonal(DVec3::Y)));
        assert_eq!(inverse(DMat3::ZERO), (DMat3::ZERO, DMat3::IDENTITY));
    }
}
