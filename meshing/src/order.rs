//! Order of points along a space-filling curve, so that particles near in space lie near in memory.
//!
//! Morton's curve on cubes of one size in all three directions: 2²¹ cells along the longest side of the bounding box,
//! 63 bits in all. Hilbert's curve has no jumps, but costs more code; the bond pass reads whole families, which span
//! many cells either way.

use glam::DVec3;
use rayon::prelude::*;

/// Cells along the longest side of the bounding box.
const CELLS: f64 = (1u64 << 21) as f64;

/// The numbers of `points` in the order of Morton's curve: `points[order[0]]` comes first. Ties keep the order of
/// their numbers, so the result is the same on any number of threads. Non-finite points are put somewhere, without
/// panic. At most `u32::MAX` points.
pub fn morton_order(points: &[DVec3]) -> Vec<u32> {
    let Some((low, high)) = crate::trimesh::bounds(points) else { return Vec::new() };
    let scale = CELLS / (high - low).max_element().max(f64::MIN_POSITIVE);
    let mut keys: Vec<(u64, u32)> = points
        .par_iter()
        .enumerate()
        .map(|(i, &p)| {
            let cell = ((p - low) * scale).to_array().map(|c| spread(c.min(CELLS - 1.0) as u64));
            (cell[0] | cell[1] << 1 | cell[2] << 2, i as u32)
        })
        .collect();
    keys.par_sort_unstable();
    keys.into_par_iter().map(|(_, i)| i).collect()
}

/// Moves bit `b` of a 21-bit number to bit `3 b`.
fn spread(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_puts_two_zeros_between_bits() {
        for b in 0..21 {
            assert_eq!(spread(1 << b), 1 << (3 * b), "bit {b}");
        }
        assert_eq!(spread(0x1f_ffff).count_ones(), 21);
    }

    #[test]
    fn the_eight_corners_of_a_cube_come_in_z_order_and_ties_by_number() {
        let corners: Vec<DVec3> =
            (0..8).rev().map(|c| DVec3::new((c & 1) as f64, (c >> 1 & 1) as f64, (c >> 2 & 1) as f64)).collect();
        let doubled: Vec<DVec3> = corners.iter().chain(&corners).copied().collect();
        let expected: Vec<u32> = (0..8).rev().flat_map(|c| [c, c + 8]).collect();
        assert_eq!(morton_order(&doubled), expected);
    }

    #[test]
    fn neighbours_on_the_curve_are_near_in_space() {
        // A shuffled 16³ lattice: on the curve the mean step is 1.57 spacings (measured), in random order about 10.
        let n = 4096usize;
        let point = |i: usize| {
            let i = i * 1597 % n; // 1597 is odd: a permutation
            DVec3::new((i % 16) as f64, (i / 16 % 16) as f64, (i / 256) as f64)
        };
        let points: Vec<DVec3> = (0..n).map(point).collect();
        let order = morton_order(&points);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &o)| i == o as usize), "a permutation");
        let step: f64 = order.windows(2).map(|w| points[w[0] as usize].distance(points[w[1] as usize])).sum();
        assert!(step / ((n - 1) as f64) < 2.0, "mean step {}", step / (n - 1) as f64);
    }

    #[test]
    fn odd_inputs_do_not_panic() {
        assert!(morton_order(&[]).is_empty());
        assert_eq!(morton_order(&[DVec3::ONE; 3]), [0, 1, 2]);
        assert_eq!(morton_order(&[DVec3::NAN, DVec3::INFINITY, DVec3::ZERO]).len(), 3);
    }
}
