//! Numbers that look random and depend on nothing but their argument: the same on every machine and thread.

use glam::DVec3;

/// A number in [−1, 1) for each `k` (splitmix).
pub fn noise(k: u64) -> f64 {
    let mut z = k.wrapping_add(0x9E37_79B9_7F4A_7C15).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// A vector in [−1, 1)³ for each `i`, of numbers 3i to 3i + 2.
pub fn vector(i: u64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|axis| noise(3 * i + axis as u64)))
}
