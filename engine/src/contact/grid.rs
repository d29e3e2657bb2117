//! A sparse grid of cells in levels: finds balls that touch the balls of a cell, whatever their sizes.
//!
//! A ball lies in the cell of its middle at the level whose cells are at least its diameter wide, so a search looks at few
//! cells of each level, and one large ball does not make the cells of all others large. Keys are Morton codes: balls in
//! order of their keys are near each other in memory where they are in space, and those of a cell are one range.

use std::ops::Range;

use glam::{DVec3, I64Vec3};

/// Width of the smallest cells in diameters of the mean ball: most balls are in those, where 27 cells are near each.
const WIDTH: f64 = 2.0;
/// Number of levels; the last one takes everything larger.
const LEVELS: u32 = 24;
/// Bits of a cell's number along each axis. Cells 2¹⁹ apart share a key; that costs time and no result.
const BITS: u32 = 19;

/// A cell with something in it.
#[derive(Clone, Copy, Debug)]
struct Cell {
    key: u64,
    level: u32,
    place: I64Vec3,
    start: u32,
}

/// Cells of balls that are sorted by [`Grid::key`].
#[derive(Debug, Default)]
pub struct Grid {
    width: f64,
    /// Cells in order of their keys; one more ends them.
    cells: Vec<Cell>,
    /// First cell of each level, and the end.
    first: Vec<usize>,
    /// Cell by hash of its key, plus one; 0 for none. Probed one after the other.
    table: Vec<u32>,
}

impl Grid {
    /// Makes room for `n` balls.
    pub fn reserve(&mut self, n: usize) {
        self.cells.reserve(n + 1);
        self.first.reserve(LEVELS as usize + 1);
        self.table.reserve(2 * n.next_power_of_two());
    }

    /// Chooses the width of cells for balls of this mean radius [m].
    pub fn fit(&mut self, mean: f64) {
        self.width = (2.0 * WIDTH * mean).max(f64::MIN_POSITIVE);
    }

    /// What balls are to be sorted by: the cell of a ball of radius `reach` [m] about `x`.
    pub fn key(&self, x: DVec3, reach: f64) -> u64 {
        let (level, place) = self.cell(x, reach);
        key(level, place)
    }

    fn cell(&self, x: DVec3, reach: f64) -> (u32, I64Vec3) {
        let wide = 2.0 * reach / self.width;
        let level = if wide <= 1.0 { 0 } else { (wide.log2().ceil() as u32).min(LEVELS - 1) };
        (level, (x / self.width_of(level)).floor().as_i64vec3())
    }

    /// Takes balls in order of their `keys`, of which `ball` gives middle and radius [m].
    pub fn build(&mut self, keys: impl Iterator<Item = u64>, ball: impl Fn(usize) -> (DVec3, f64)) {
        self.cells.clear();
        let mut n = 0;
        for key in keys {
            if self.cells.last().is_none_or(|c| c.key != key) {
                let (x, reach) = ball(n);
                let (level, place) = self.cell(x, reach);
                self.cells.push(Cell { key, level, place, start: n as u32 });
            }
            n += 1;
        }
        let cells = self.cells.len();
        self.first.clear();
        self.first.extend((0..=LEVELS).map(|level| self.cells.partition_point(|c| c.level < level)));
        self.table.clear();
        self.table.resize(2 * cells.next_power_of_two(), 0);
        let mask = self.table.len() - 1;
        for c in 0..cells {
            let mut slot = hash(self.cells[c].key) & mask;
            while self.table[slot] != 0 {
                slot = (slot + 1) & mask;
            }
            self.table[slot] = c as u32 + 1;
        }
        self.cells.push(Cell { key: u64::MAX, level: LEVELS, place: I64Vec3::ZERO, start: n as u32 });
    }

    /// The cell that ball `k` is in.
    pub fn cell_of(&self, k: usize) -> usize {
        self.cells.partition_point(|c| c.start as usize <= k) - 1
    }

    /// The balls of a cell.
    pub fn balls(&self, cell: usize) -> Range<usize> {
        self.cells[cell].start as usize..self.cells[cell + 1].start as usize
    }

    /// Calls `found` with ranges of balls that hold all which may touch one of `cell`, its own among them.
    pub fn near(&self, cell: usize, mut found: impl FnMut(Range<usize>)) {
        let home = self.cells[cell];
        for level in 0..LEVELS {
            let there = self.first[level as usize]..self.first[level as usize + 1];
            if there.is_empty() {
                continue;
            }
            // two balls touch within half the sum of the widths; in cells of `level`, the far end left out
            let (low, high) = if level <= home.level {
                let s = home.level - level;
                let margin = (1 + (1_i64 << s) + 1) / 2;
                ((home.place << s) - margin, ((home.place + 1) << s) - 1 + margin)
            } else {
                let s = level - home.level;
                let (wide, twice) = (1_i64 << s, home.place * 2);
                ((twice - (1 + wide)) >> (s + 1), (twice + (2 + wide)) >> (s + 1))
            };
            self.inside(level, there, low, high, &mut found);
        }
    }

    /// Calls `found` with ranges of balls that hold all which may touch the ball of `reach` [m] about `x`.
    pub fn around(&self, x: DVec3, reach: f64, mut found: impl FnMut(Range<usize>)) {
        for level in 0..LEVELS {
            let there = self.first[level as usize]..self.first[level as usize + 1];
            let width = self.width_of(level);
            let far = DVec3::splat(reach + 0.5 * width);
            let place = |x: DVec3| (x / width).floor().as_i64vec3();
            self.inside(level, there, place(x - far), place(x + far), &mut found);
        }
    }

    /// Calls `found` with the balls of the cells from `low` to `high` of a level, whose cells are `there`.
    fn inside(
        &self,
        level: u32,
        mut there: Range<usize>,
        low: I64Vec3,
        high: I64Vec3,
        found: &mut impl FnMut(Range<usize>),
    ) {
        if (high - low + 1).as_dvec3().element_product() > there.len() as f64 {
            let inside = |c: &usize| {
                let place = self.cells[*c].place;
                place.cmpge(low).all() && place.cmple(high).all()
            };
            return there.by_ref().filter(inside).for_each(|c| found(self.balls(c)));
        }
        for i in low.x..=high.x {
            for j in low.y..=high.y {
                for k in low.z..=high.z {
                    if let Some(c) = self.find(key(level, I64Vec3::new(i, j, k))) {
                        found(self.balls(c));
                    }
                }
            }
        }
    }

    fn find(&self, key: u64) -> Option<usize> {
        let mask = self.table.len() - 1;
        let mut slot = hash(key) & mask;
        loop {
            let cell = self.table[slot].checked_sub(1)? as usize;
            if self.cells[cell].key == key {
                return Some(cell);
            }
            slot = (slot + 1) & mask;
        }
    }

    fn width_of(&self, level: u32) -> f64 {
        self.width * f64::from(1u32 << level)
    }
}

/// A cell as one number: the level, then the bits of its place along the axes in turn.
fn key(level: u32, place: I64Vec3) -> u64 {
    let spread = |x: i64| {
        let mut v = x as u64 & ((1 << BITS) - 1);
        v = (v | v << 32) & 0x1F_0000_0000_FFFF;
        v = (v | v << 16) & 0x1F_0000_FF00_00FF;
        v = (v | v << 8) & 0x100F_00F0_0F00_F00F;
        v = (v | v << 4) & 0x10C3_0C30_C30C_30C3;
        (v | v << 2) & 0x1249_2492_4924_9249
    };
    u64::from(level) << (3 * BITS) | spread(place.x) << 2 | spread(place.y) << 1 | spread(place.z)
}

fn hash(key: u64) -> usize {
    (key.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as usize
}

#[cfg(test)]
mod tests {
    use super::super::tests::unit;
    use super::*;

    #[test]
    fn everything_that_touches_is_found_once_whatever_its_size() {
        let unit = |k: usize| unit(k as u64);
        let mut balls: Vec<(DVec3, f64)> = (0..800)
            .map(|k| {
                let x = DVec3::new(unit(4 * k + 1), unit(4 * k + 2), unit(4 * k + 3)) * 4.0 - 2.0;
                (x, 0.05 + 0.6 * unit(4 * k + 4).powi(12))
            })
            .collect();
        let mut grid = Grid::default();
        for _ in 0..2 {
            grid.fit(0.08); // the second time into used buffers
            balls.sort_by_key(|&(x, reach)| grid.key(x, reach));
            let keys: Vec<u64> = balls.iter().map(|&(x, reach)| grid.key(x, reach)).collect();
            grid.build(keys.into_iter(), |k| balls[k]);
        }
        for k in 0..balls.len() {
            let (x, reach) = balls[k];
            let touching = |j: &usize| balls[*j].0.distance(x) < reach + balls[*j].1;
            let (mut found, cell) = (Vec::new(), grid.cell_of(k));
            assert!(grid.balls(cell).contains(&k));
            grid.near(cell, |balls| found.extend(balls));
            found.retain(touching);
            found.sort_unstable();
            let want: Vec<usize> = (0..balls.len()).filter(touching).collect();
            assert_eq!(found, want);
            found.clear();
            grid.around(x, reach, |balls| found.extend(balls));
            found.retain(touching);
            found.sort_unstable();
            assert_eq!(found, want);
        }
        let levels = grid.first.windows(2).filter(|w| w[0] < w[1]).count();
        assert!(levels > 2, "{levels} levels only");
    }
}
