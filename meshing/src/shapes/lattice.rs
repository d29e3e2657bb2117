//! Points of a cubic lattice.

use glam::DVec3;

/// `n[0] × n[1] × n[2]` points at distance `spacing` [m] along each axis, the first at the origin, x fastest, z slowest.
/// For benchmarks of neighbour search; any finite spacing, none if one of `n` is 0.
pub fn cubic_lattice(n: [usize; 3], spacing: f64) -> Vec<DVec3> {
    let mut points = Vec::with_capacity(n.iter().product());
    for k in 0..n[2] {
        for j in 0..n[1] {
            points.extend((0..n[0]).map(|i| DVec3::new(i as f64, j as f64, k as f64) * spacing));
        }
    }
    points
}
