//! A hashed grid of cells in levels: finds balls that touch a ball, whatever their sizes.
//!
//! A ball lies in the cell of its middle at the level whose cells are at least its diameter wide, so a search looks at few
//! cells of each level, and one large ball does not make the cells of all others large. Building reuses its buffers.

use glam::{DVec3, I64Vec3};

/// Width of the smallest cells in diameters of the mean ball.
const WIDTH: f64 = 1.2;
/// Number of levels; the last one takes everything larger.
const LEVELS: u32 = 24;

/// Middles and reaches of balls, sorted into cells.
#[derive(Debug, Default)]
pub struct Grid {
    width: f64,
    levels: u32,
    /// Key of each ball's cell, by ball.
    cell: Vec<u64>,
    /// First place of each bucket, one more than there are buckets.
    starts: Vec<u32>,
    /// Balls and their keys, bucket after bucket.
    items: Vec<(u64, u32)>,
}

impl Grid {
    /// Makes room for `n` balls.
    pub fn reserve(&mut self, n: usize) {
        self.cell.reserve(n);
        self.items.reserve(n);
        self.starts.reserve(n.next_power_of_two() + 1);
    }

    /// Sorts `n` balls, of which `ball` gives middle and reach [m].
    pub fn build(&mut self, n: usize, ball: impl Fn(usize) -> (DVec3, f64)) {
        let mean = (0..n).map(|k| ball(k).1).sum::<f64>() / n.max(1) as f64;
        self.width = (2.0 * WIDTH * mean).max(f64::MIN_POSITIVE);
        self.levels = 0;
        let buckets = n.next_power_of_two();
        self.cell.clear();
        self.starts.clear();
        self.starts.resize(buckets + 1, 0);
        for k in 0..n {
            let (x, reach) = ball(k);
            let level = ((2.0 * reach / self.width).log2().ceil().max(0.0) as u32).min(LEVELS - 1);
            self.levels |= 1 << level;
            let key = key(level, cell(x, self.width_of(level)));
            self.cell.push(key);
            self.starts[bucket(key, buckets) + 1] += 1;
        }
        for b in 0..buckets {
            self.starts[b + 1] += self.starts[b];
        }
        self.items.clear();
        self.items.resize(n, (0, 0));
        // from the back, so that a bucket's balls stay in order and its start ends where it began
        for k in (0..n).rev() {
            let b = bucket(self.cell[k], buckets) + 1;
            self.starts[b] -= 1;
            self.items[self.starts[b] as usize] = (self.cell[k], k as u32);
        }
        // the ends have become starts: shift them back
        self.starts.remove(0);
        self.starts.push(n as u32);
    }

    /// Calls `found` with every ball whose cell may hold one that touches the ball of `reach` [m] about `x`.
    #[inline]
    pub fn near(&self, x: DVec3, reach: f64, mut found: impl FnMut(u32)) {
        let buckets = self.starts.len() - 1;
        let mut levels = self.levels;
        while levels != 0 {
            let level = levels.trailing_zeros();
            levels &= levels - 1;
            let width = self.width_of(level);
            let around = DVec3::splat(reach + 0.5 * width);
            let (low, high) = (cell(x - around, width), cell(x + around, width));
            for i in low.x..=high.x {
                for j in low.y..=high.y {
                    for k in low.z..=high.z {
                        let key = key(level, I64Vec3::new(i, j, k));
                        let b = bucket(key, buckets);
                        for &(other, item) in &self.items[self.starts[b] as usize..self.starts[b + 1] as usize] {
                            if other == key {
                                found(item);
                            }
                        }
                    }
                }
            }
        }
    }

    fn width_of(&self, level: u32) -> f64 {
        self.width * f64::from(1u32 << level)
    }
}

fn cell(x: DVec3, width: f64) -> I64Vec3 {
    (x / width).floor().as_i64vec3()
}

/// A cell as one number. Two cells in reach of one ball share it with probability 2⁻⁶⁴, and then a ball is found twice.
fn key(level: u32, c: I64Vec3) -> u64 {
    let mix = |h: u64, x: i64| (h ^ x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29);
    mix(mix(mix(mix(1, i64::from(level)), c.x), c.y), c.z)
}

fn bucket(key: u64, buckets: usize) -> usize {
    (key ^ key >> 32) as usize & (buckets - 1)
}

#[cfg(test)]
mod tests {
    use super::super::tests::unit;
    use super::*;

    #[test]
    fn everything_that_touches_is_found_once_whatever_its_size() {
        let unit = |k: usize| unit(k as u64);
        let ball = |k: usize| {
            let x = DVec3::new(unit(4 * k + 1), unit(4 * k + 2), unit(4 * k + 3)) * 4.0 - 2.0;
            (x, 0.05 + 0.6 * unit(4 * k + 4).powi(12))
        };
        let n = 800;
        let mut grid = Grid::default();
        for _ in 0..2 {
            grid.build(n, ball); // the second time into used buffers
        }
        for k in 0..n {
            let (x, reach) = ball(k);
            let touching = |j: &u32| ball(*j as usize).0.distance(x) < reach + ball(*j as usize).1;
            let mut found = Vec::new();
            grid.near(x, reach, |j| found.push(j));
            found.retain(touching);
            found.sort_unstable();
            let want: Vec<u32> = (0..n as u32).filter(touching).collect();
            assert_eq!(found, want);
        }
        assert!(grid.levels.count_ones() > 2, "one size only: {:b}", grid.levels);
    }
}
