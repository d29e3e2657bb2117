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

use std::ops::Range;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::cells::{Finest, NONE};
use super::matching::{EMPTY, Rows, STRAIGHT, Turn, add, general, goal, lever, matrix, moment, rigid, subtract};
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

/// A box of cells of its own, with what lies around it.
#[derive(Debug, Default)]
struct Block {
    /// Cells along x of the body's box.
    nx: usize,
    /// Rows along y in the plane of this block, and which of them are its own.
    ny: usize,
    own_rows: Range<usize>,
    /// First of the cells of each plane, and one more; which planes are its own.
    planes: Vec<u32>,
    own_planes: Range<usize>,
    /// Cells plane after plane and row after row, and their place in the plane.
    cells: Vec<u32>,
    at: Vec<u32>,
    /// Number among its own of each, else [`NONE`].
    own: Vec<u32>,
    /// For each of its own: the sum of the goals of its cubes, and the same as rows; the rotation of the cube around it, and its
    /// stretch where rest shapes flow.
    goals: Vec<DVec3>,
    means: Vec<Rows>,
    turns: Vec<Turn>,
    stretch: Vec<DMat3>,
    scratch: Scratch,
}

/// Sums of a block.
#[derive(Debug, Default)]
struct Scratch {
    /// Σ over planes of moments, and of goals.
    moments: Vec<Rows>,
    goals: Vec<Rows>,
    /// Goals of the last 2w + 1 planes.
    ring: Vec<Rows>,
    /// Sums along x of the last 2w + 1 rows, and their sum.
    lines: Vec<Rows>,
    sum: Vec<Rows>,
}

/// What the sums need of each cell.
#[derive(Debug, Default)]
struct Columns {
    /// Mass over the number of its regions [kg].
    weight: Vec<f64>,
    /// Mass [kg] and centre at rest [m] of the cube around it.
    light: Vec<[f64; 4]>,
    /// The same with all that a flowing rest shape needs; else empty.
    still: Vec<Still>,
    /// Whether its cube is its region.
    whole: Vec<bool>,
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
    /// Whether mean goals are wanted as rows.
    pub full: bool,
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
        let (w, columns) = (self.half_width, &self.columns);
        self.blocks.par_iter_mut().for_each(|b| {
            let mut means = std::mem::take(&mut b.means);
            b.cubes(w, finest, columns, &x, |own, rows| {
                if own != NONE {
                    means[own as usize] = *rows;
                }
            });
            b.means = means;
        });
    }

    /// Sums the goals of all cubes over every cell.
    pub fn gather(&mut self, step: &Step<'_>) {
        let (w, columns) = (self.half_width, &self.columns);
        self.blocks.par_iter_mut().for_each(|b| b.gather(w, columns, step));
    }

    /// The sum of the goals of the cubes over a cell.
    #[inline(always)]
    pub fn goal(&self, cell: usize) -> DVec3 {
        let [block, k] = self.rank[cell];
        self.blocks[block as usize].goals[k as usize]
    }

    /// The same as rows, after a [full](Step::full) step.
    pub fn mean(&self, cell: usize) -> &Rows {
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

impl Block {
    fn new<'a>(
        size: [usize; 3],
        rows: Range<usize>,
        planes: Range<usize>,
        w: usize,
        place: impl Fn(u32) -> [usize; 3],
        plane: impl Fn(usize) -> &'a [u32],
    ) -> Self {
        let around = |own: &Range<usize>, all: usize| own.start.saturating_sub(2 * w)..(own.end + 2 * w).min(all);
        let (all_rows, all_planes) = (around(&rows, size[1]), around(&planes, size[2]));
        let (nx, ny) = (size[0], all_rows.len());
        let mut b = Self {
            nx,
            ny,
            own_rows: rows.start - all_rows.start..rows.end - all_rows.start,
            planes: vec![0],
            own_planes: planes.start - all_planes.start..planes.end - all_planes.start,
            ..Self::default()
        };
        let mut count = 0;
        for z in all_planes {
            for &c in plane(z).iter().filter(|&&c| all_rows.contains(&place(c)[1])) {
                let [x, y, _] = place(c);
                b.cells.push(c);
                b.at.push(((y - all_rows.start) * nx + x) as u32);
                let own = rows.contains(&y) && planes.contains(&z);
                b.own.push(if own { count } else { NONE });
                count += u32::from(own);
            }
            b.planes.push(b.cells.len() as u32);
        }
        let own = count as usize;
        (b.goals, b.means) = (vec![DVec3::ZERO; own], vec![EMPTY; own]);
        (b.turns, b.stretch) = (vec![STRAIGHT; own], vec![DMat3::IDENTITY; own]);
        let room = |planes: usize| vec![EMPTY; planes * nx * ny];
        let line = |rows: usize| vec![EMPTY; rows * nx];
        b.scratch =
            Scratch { moments: room(1), goals: room(1), ring: room(2 * w + 1), lines: line(2 * w + 1), sum: line(1) };
        b
    }

    /// Entries of plane `z`, which may lie outside.
    #[inline(always)]
    fn plane(&self, z: isize) -> Range<usize> {
        match usize::try_from(z) {
            Ok(z) if z + 1 < self.planes.len() => self.planes[z] as usize..self.planes[z + 1] as usize,
            _ => 0..0,
        }
    }

    /// The sums over the cube around each cell, with nodes at `x`; `each` gets the number among the own and the sums.
    fn cubes(
        &mut self,
        w: usize,
        finest: &Finest,
        columns: &Columns,
        x: impl Fn(usize) -> DVec3,
        mut each: impl FnMut(u32, &Rows),
    ) {
        let mut s = std::mem::take(&mut self.scratch);
        s.moments.fill(EMPTY);
        let w = w as isize;
        for z in self.own_planes.start as isize - 2 * w..self.own_planes.end as isize + w {
            self.turn_over(w, z, finest, columns, &x, &mut s.moments);
            self.regions(w as usize, z - w, &mut s, |entry, rows| each(self.own[entry], rows));
        }
        self.scratch = s;
    }

    /// Lets plane `z` enter the sum over 2w + 1 planes, and the last one leave.
    #[inline(always)]
    fn turn_over(
        &self,
        w: isize,
        z: isize,
        finest: &Finest,
        columns: &Columns,
        x: &impl Fn(usize) -> DVec3,
        sum: &mut [Rows],
    ) {
        let of = |k: usize| {
            let c = self.cells[k] as usize;
            moment(columns.weight[c], x(c), lever(finest.place(c)))
        };
        self.plane(z).for_each(|k| add(&mut sum[self.at[k] as usize], &of(k)));
        self.plane(z - 2 * w - 1).for_each(|k| subtract(&mut sum[self.at[k] as usize], &of(k)));
    }

    /// Gives the sums over the cube around each entry of plane `z` that a cell of this block may need.
    #[inline(always)]
    fn regions(&self, w: usize, z: isize, s: &mut Scratch, mut each: impl FnMut(usize, &Rows)) {
        let mut entries = self.plane(z).peekable();
        if entries.peek().is_none() {
            return;
        }
        let rows = self.own_rows.start.saturating_sub(w)..(self.own_rows.end + w).min(self.ny);
        let Scratch { moments, lines, sum, .. } = s;
        along(moments, self.nx, self.ny, w, rows, lines, sum, |y, sums| {
            let (start, end) = ((y * self.nx) as u32, ((y + 1) * self.nx) as u32);
            while entries.next_if(|&k| self.at[k] < start).is_some() {}
            while let Some(k) = entries.next_if(|&k| self.at[k] < end) {
                each(k, &sums[(self.at[k] - start) as usize]);
            }
        });
    }

    fn gather(&mut self, w: usize, columns: &Columns, step: &Step<'_>) {
        let mut s = std::mem::take(&mut self.scratch);
        let (mut goals, mut means) = (std::mem::take(&mut self.goals), std::mem::take(&mut self.means));
        let (mut turns, mut stretch) = (std::mem::take(&mut self.turns), std::mem::take(&mut self.stretch));
        s.moments.fill(EMPTY);
        s.goals.fill(EMPTY);
        s.ring.fill(EMPTY);
        let (plane, i) = (self.nx * self.ny, w as isize);
        let x = |c: usize| step.x[c] - step.origin;
        for z in self.own_planes.start as isize - 2 * i..self.own_planes.end as isize + 2 * i {
            self.turn_over(i, z, step.finest, columns, &x, &mut s.moments);
            let middle = z - i;
            if middle < self.own_planes.start as isize - i {
                continue;
            }
            let slot = (middle.rem_euclid(2 * i + 1)) as usize * plane;
            let mut ring = std::mem::take(&mut s.ring);
            let mut sum = std::mem::take(&mut s.goals);
            let kept = &mut ring[slot..slot + plane];
            for k in self.plane(middle - 2 * i - 1) {
                let at = self.at[k] as usize;
                subtract(&mut sum[at], &kept[at]);
                kept[at] = EMPTY;
            }
            self.match_plane(w, middle, columns, step, &mut s, kept, (&mut turns, &mut stretch));
            self.plane(middle).for_each(|k| add(&mut sum[self.at[k] as usize], &kept[self.at[k] as usize]));
            (s.ring, s.goals) = (ring, sum);
            let out = middle - i;
            if out >= self.own_planes.start as isize {
                let mut entries = self.plane(out).peekable();
                let Scratch { goals: sum, lines, sum: line, .. } = &mut s;
                along(sum, self.nx, self.ny, w, self.own_rows.clone(), lines, line, |y, sums| {
                    let (start, end) = ((y * self.nx) as u32, ((y + 1) * self.nx) as u32);
                    while entries.next_if(|&k| self.at[k] < start).is_some() {}
                    while let Some(k) = entries.next_if(|&k| self.at[k] < end) {
                        let (own, rows) = (self.own[k] as usize, &sums[(self.at[k] - start) as usize]);
                        goals[own] = goal(rows, lever(step.finest.place(self.cells[k] as usize)));
                        if step.full {
                            means[own] = *rows;
                        }
                    }
                });
            }
        }
        (self.goals, self.means, self.turns, self.stretch, self.scratch) = (goals, means, turns, stretch, s);
    }

    /// Matches the cubes around the cells of plane `z`, four at a time, and keeps their goals.
    #[inline(always)]
    fn match_plane(
        &self,
        w: usize,
        z: isize,
        columns: &Columns,
        step: &Step<'_>,
        s: &mut Scratch,
        kept: &mut [Rows],
        (turned, stretched): (&mut [Turn], &mut [DMat3]),
    ) {
        let (mut entry, mut sums, mut waiting) = ([0; 4], [EMPTY; 4], 0);
        let mut solve = |entry: [usize; 4], sums: [Rows; 4], count: usize| {
            let cell = entry.map(|k| self.cells[k] as usize);
            let turns = cell.map(|c| step.turns[c]);
            let own = entry.map(|k| self.own[k]);
            let goals = if columns.still.is_empty() {
                let (goals, turns) = rigid(sums, cell.map(|c| columns.light[c]), turns);
                let mine = own.iter().zip(turns).take(count).filter(|(own, _)| **own != NONE);
                mine.for_each(|(&own, turn)| turned[own as usize] = turn);
                goals
            } else {
                let (still, shapes) = (cell.map(|c| &columns.still[c]), cell.map(|c| step.shapes.get(c)));
                let (goals, found) = general(sums, still, turns, shapes, step.settings);
                for (&own, found) in own.iter().zip(found).take(count).filter(|(own, _)| **own != NONE) {
                    (turned[own as usize], stretched[own as usize]) = (found.turn, found.stretch);
                }
                goals
            };
            (0..count).for_each(|l| kept[self.at[entry[l]] as usize] = goals[l]);
        };
        self.regions(w, z, s, |k, rows| {
            if !columns.whole[self.cells[k] as usize] {
                return;
            }
            (entry[waiting], sums[waiting]) = (k, *rows);
            waiting += 1;
            if waiting == 4 {
                solve(entry, sums, 4);
                waiting = 0;
            }
        });
        if waiting > 0 {
            for l in waiting..4 {
                (entry[l], sums[l]) = (entry[0], sums[0]);
            }
            solve(entry, sums, waiting);
        }
    }
}

/// Sums over 2w + 1 along x and along y of a plane of `nx` × `ny`: `each` gets those of the rows in `wanted`, one after the other.
#[inline(always)]
fn along(
    plane: &[Rows],
    nx: usize,
    ny: usize,
    w: usize,
    wanted: Range<usize>,
    lines: &mut [Rows],
    sum: &mut [Rows],
    mut each: impl FnMut(usize, &[Rows]),
) {
    sum.fill(EMPTY);
    let first = wanted.start.saturating_sub(w);
    for y in first..wanted.end + w {
        let slot = y % (2 * w + 1) * nx;
        let line = &mut lines[slot..slot + nx];
        if y >= first + 2 * w + 1 {
            sum.iter_mut().zip(&*line).for_each(|(sum, row)| subtract(sum, row));
        }
        if y < ny {
            let row = &plane[y * nx..(y + 1) * nx];
            let mut running = EMPTY;
            row[..w.min(nx)].iter().for_each(|r| add(&mut running, r));
            for x in 0..nx {
                if let Some(enters) = row.get(x + w) {
                    add(&mut running, enters);
                }
                line[x] = running;
                if x >= w {
                    subtract(&mut running, &row[x - w]);
                }
            }
            sum.iter_mut().zip(&*line).for_each(|(sum, row)| add(sum, row));
        } else {
            line.fill(EMPTY);
        }
        if y >= wanted.start + w {
            each(y - w, sum);
        }
    }
}
