//! Goals on a uniform lattice by running sums (Rivers and James 2007): a few additions per node, whatever w is.
//!
//! ```text
//! a block of planes, along z:          moments of nodes enter and leave a sum over 2w + 1 planes
//! for each plane of that sum:          sums over 2w + 1 along x, then along y, are the sums of cubes; four at a time are matched
//! the same three sums over the goals:  the sum of the goals of all cubes over a node
//! ```
//! So the particles are read twice and written once, and all sums stay in the cache. Blocks overlap by 2w cells and find the
//! goals there twice, rather than wait for each other. How the body is divided follows from its shape alone, so the bits do
//! not depend on threads.
//!
//! A cube is right where it is the region: where all of its cells can be reached in w links. The regions near a crack or in the
//! crook of an L are not; those are *torn*, and [listed](super::lists).

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::block::Block;
use super::cells::{Finest, NONE};
use super::matching::{Rows, Turn, matrix};
use super::params::Settings;
use super::presence::{Presence, inner};
use super::regions::{Still, Walker};
use super::shapes::Shapes;

/// A box may have so many cells for each that is solid; else all regions are listed.
const SPARSE: usize = 64;
/// What the sums of a block may take [bytes]: most of a cache of the second level.
const CACHE: usize = 1 << 20;
/// Bodies of fewer cells are one block.
const SMALL: usize = 8192;
/// Blocks that a larger body is divided into, at least.
const BLOCKS: usize = 4;

/// What the sums need of each cell.
#[derive(Debug, Default)]
pub struct Columns {
    /// Mass over the number of its regions [kg].
    pub weight: Vec<f64>,
    /// Mass [kg] and centre at rest [m] of the cube around it.
    pub light: Vec<[f64; 4]>,
    /// The same with all that a flowing rest shape needs; else empty.
    pub still: Vec<Still>,
    /// Whether its cube is its region.
    pub whole: Vec<bool>,
}

/// What a step gives.
#[derive(Clone, Copy)]
pub struct Step<'a> {
    /// Positions [m], and the point that they are seen from.
    pub x: &'a [DVec3],
    pub origin: DVec3,
    pub finest: &'a Finest,
    pub turns: &'a [Turn],
    pub shapes: &'a Shapes,
    pub settings: &'a Settings,
}

/// The uniform lattice of a body.
#[derive(Debug, Default)]
pub struct Uniform {
    half_width: usize,
    blocks: Vec<Block>,
    /// Block of each cell, and its number there.
    rank: Vec<[u32; 2]>,
    columns: Columns,
    /// In how many regions each cell is.
    count: Vec<f64>,
    /// Cells whose region is not their cube, in order.
    pub torn: Vec<u32>,
}

impl Uniform {
    /// The uniform lattice of `finest`; `None` where its cells are too few in their box.
    pub fn new(finest: &Finest, half_width: u32) -> Option<Self> {
        let (low, size) = finest.extent();
        let volume = size[0].checked_mul(size[1]).and_then(|a| a.checked_mul(size[2]))?;
        if volume > SPARSE * finest.len() {
            return None;
        }
        let w = half_width as usize;
        let place = |c: u32| std::array::from_fn::<usize, 3, _>(|a| (finest.index[c as usize][a] - low[a]) as usize);
        let mut order: Vec<u32> = (0..finest.len() as u32).collect();
        order.par_sort_unstable_by_key(|&c| {
            let [x, y, z] = place(c);
            (z, y, x)
        });
        let ends: Vec<usize> = (0..=size[2]).map(|z| order.partition_point(|&c| place(c)[2] < z)).collect();
        let plane = |z: usize| &order[ends[z]..ends[z + 1]];
        let [rows, planes] = division(finest.len(), size, w);
        let corners = (0..size[2]).step_by(planes).flat_map(|z| (0..size[1]).step_by(rows).map(move |y| (y, z)));
        let corners: Vec<(usize, usize)> = corners.collect();
        let blocks: Vec<Block> = corners
            .par_iter()
            .map(|&(y, z)| Block::new(size, y..(y + rows).min(size[1]), z..(z + planes).min(size[2]), w, place, plane))
            .collect();
        let mut rank = vec![[NONE; 2]; finest.len()];
        for (number, b) in blocks.iter().enumerate() {
            b.cells.iter().zip(&b.own).filter(|(_, own)| **own != NONE).for_each(|(&c, &own)| {
                rank[c as usize] = [number as u32, own];
            });
        }
        Some(Self { half_width: w, blocks, rank, ..Self::default() })
    }

    /// Finds anew which regions are torn and in how many each cell is: near the cells of `changed`, or everywhere.
    pub fn find_torn(&mut self, finest: &Finest, changed: Option<&[u32]>) {
        let w = self.half_width as u32;
        let near: Vec<u32> = match changed {
            Some(cells) => Walker::new(finest.len(), 0).once_reached(finest, cells, w).to_vec(),
            None => {
                self.count = vec![0.0; finest.len()];
                self.columns.whole = vec![true; finest.len()];
                (0..finest.len() as u32).collect()
            }
        };
        let (inner, present) = (inner(finest, w), Presence::new(finest));
        let judge = |walker: &mut Walker, c: u32| {
            if inner[c as usize] {
                return (true, (2 * w as usize + 1).pow(3));
            }
            let reached = walker.reach(finest, &[c], w).len();
            (reached == present.around(finest.index[c as usize], w), reached)
        };
        let judged =
            near.par_iter().with_min_len(1024).map_init(|| Walker::new(finest.len(), 0), |walker, &c| judge(walker, c));
        let judged: Vec<(bool, usize)> = judged.collect();
        for (&c, (whole, count)) in near.iter().zip(judged) {
            // links work both ways: a cell is in as many regions as its own has cells
            (self.columns.whole[c as usize], self.count[c as usize]) = (whole, count as f64);
        }
        self.torn.clear();
        self.torn.extend((0..finest.len() as u32).filter(|&c| !self.columns.whole[c as usize]));
        self.columns.weight.clear();
        self.columns.weight.extend(finest.mass.iter().zip(&self.count).map(|(m, n)| m / n));
    }

    /// In how many regions a cell is.
    #[inline(always)]
    pub fn count(&self, cell: usize) -> f64 {
        self.count[cell]
    }

    /// Finds mass, centre and spread of all cubes.
    pub fn settle(&mut self, finest: &Finest, settings: &Settings) {
        let n = finest.len();
        self.sum_cubes(finest, |_| DVec3::ONE);
        let light = (0..n).map(|c| {
            let [mass, x, y, z] = self.mean(c)[0].to_array();
            if mass > 0.0 { [mass, x / mass, y / mass, z / mass] } else { [1.0, 0.0, 0.0, 0.0] }
        });
        self.columns.light = light.collect();
        if settings.plastic.is_none() {
            return;
        }
        self.sum_cubes(finest, |c| finest.place(c));
        let still = (0..n).map(|c| {
            let [mass, x, y, z] = self.columns.light[c];
            let centre = DVec3::new(x, y, z);
            let spread = matrix(self.mean(c)) - DMat3::from_cols(centre * x, centre * y, centre * z) * mass;
            Still::new(mass, centre, spread, 0.0)
        });
        self.columns.still = still.collect();
    }

    /// Sums over the cube around every cell with nodes at `x`, into the means.
    fn sum_cubes(&mut self, finest: &Finest, x: impl Fn(usize) -> DVec3 + Sync) {
        let columns = &self.columns;
        self.blocks.par_iter_mut().for_each(|b| {
            let mut means = std::mem::take(&mut b.means);
            b.cubes(finest, columns, &x, |own, rows| {
                if own != NONE {
                    means[own as usize] = *rows;
                }
            });
            b.means = means;
        });
    }

    /// Sums the goals of all cubes over every cell.
    pub fn gather(&mut self, step: &Step<'_>) {
        let columns = &self.columns;
        self.blocks.par_iter_mut().for_each(|b| b.gather(columns, step));
    }

    /// The sum of the goals of the cubes over a cell.
    #[inline(always)]
    pub fn goal(&self, cell: usize) -> DVec3 {
        let [block, k] = self.rank[cell];
        self.blocks[block as usize].goals[k as usize]
    }

    /// What [`sum_cubes`](Self::sum_cubes) has found around a cell.
    fn mean(&self, cell: usize) -> &Rows {
        let [block, k] = self.rank[cell];
        &self.blocks[block as usize].means[k as usize]
    }

    /// Whether the region of a cell is its cube.
    pub fn is_whole(&self, cell: usize) -> bool {
        self.columns.whole[cell]
    }

    /// The rotation of the cube around a cell.
    #[inline(always)]
    pub fn turn(&self, cell: usize) -> Turn {
        let [block, k] = self.rank[cell];
        self.blocks[block as usize].turns[k as usize]
    }

    /// The stretch of the cube around a cell, where rest shapes flow.
    pub fn stretch(&self, cell: usize) -> DMat3 {
        let [block, k] = self.rank[cell];
        self.blocks[block as usize].stretch[k as usize]
    }
}

/// Rows and planes of a block.
fn division(cells: usize, [nx, ny, nz]: [usize; 3], w: usize) -> [usize; 2] {
    if cells < SMALL {
        return [ny, nz];
    }
    let row = nx * size_of::<Rows>() * (2 * w + 3);
    let rows = (CACHE / row).saturating_sub(4 * w).max(8 * w).min(ny);
    let rows = ny.div_ceil(ny.div_ceil(rows));
    let strips = ny.div_ceil(rows);
    let planes = nz.div_ceil(BLOCKS.div_ceil(strips)).max(8 * w).min(nz);
    [rows, planes]
}
