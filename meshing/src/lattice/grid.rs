//! Where cells are: a regular grid whose faces may be bent by noise.
//!
//! Everything that is cut is cut in *cell coordinates* u, in which cell (i, j, k) is the unit cube above (i, j, k) and
//! faces are planes. A point of the body has u = p + a N(p / s) with p = (x − origin) / size and N three independent
//! Perlin noises (Perlin 2002): bent faces, but planes for whoever cuts, and cells that still fill space without overlap, for
//! the map is one to one as long as a is small beside s.

use glam::DVec3;

use super::Noise;

/// A grid of cubic cells over a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    /// Lowest corner of cell (0, 0, 0), before it is bent [m].
    pub origin: DVec3,
    /// Edge of a cell [m].
    pub size: f64,
    pub noise: Noise,
}

impl Grid {
    /// Cell coordinates of a point [m].
    pub fn to_cells(self, x: DVec3) -> DVec3 {
        let p = (x - self.origin) / self.size;
        p + self.bend(p)
    }

    /// The point [m] with these cell coordinates, to 1e-13 of a cell.
    pub fn place(self, u: DVec3) -> DVec3 {
        let mut p = u;
        // The map shrinks distances by at least a tenth each time: see [`Noise::bends_too_far`].
        for _ in 0..300 {
            let next = u - self.bend(p);
            let moved = (next - p).abs().max_element();
            p = next;
            if moved < 1e-14 * (1.0 + p.abs().max_element()) {
                break;
            }
        }
        self.origin + p * self.size
    }

    fn bend(self, p: DVec3) -> DVec3 {
        let Noise { amplitude, scale, seed } = self.noise;
        if amplitude == 0.0 {
            return DVec3::ZERO;
        }
        let at = p / scale;
        let along = |axis: u64| perlin(seed.wrapping_mul(3).wrapping_add(axis), at);
        DVec3::new(along(0), along(1), along(2)) * amplitude
    }
}

/// Perlin's noise of 2002 with hashed gradients: between −1 and 1, 0 at integer points, twice differentiable.
pub(super) fn perlin(seed: u64, p: DVec3) -> f64 {
    let cell = p.floor();
    let t = p - cell;
    let fade = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let corner = |k: usize| {
        let offset = DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
        let c = cell + offset;
        gradient(seed, [c.x as i64, c.y as i64, c.z as i64]).dot(t - offset)
    };
    let mix = |a: f64, b: f64, s: f64| a + (b - a) * s;
    let along_x = |k: usize| mix(corner(k), corner(k + 1), fade.x);
    mix(mix(along_x(0), along_x(2), fade.y), mix(along_x(4), along_x(6), fade.y), fade.z)
}

/// One of the twelve directions from the middle of a cube to its edges.
fn gradient(seed: u64, at: [i64; 3]) -> DVec3 {
    let mut h = seed ^ 0x9e37_79b9_7f4a_7c15;
    for c in at {
        // the finaliser of splitmix64
        h = h.wrapping_add(c as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        h = (h ^ (h >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        h ^= h >> 31;
    }
    let (one, two) = (1.0 - (h & 1) as f64 * 2.0, 1.0 - (h >> 1 & 1) as f64 * 2.0);
    match (h >> 2) % 3 {
        0 => DVec3::new(0.0, one, two),
        1 => DVec3::new(one, 0.0, two),
        _ => DVec3::new(one, two, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scatter(n: usize) -> impl Iterator<Item = DVec3> {
        (0..n).map(|i| {
            let u = |k: f64| (i as f64 * k + 0.5).fract() * 40.0 - 20.0;
            DVec3::new(u(0.8191725134), u(0.6710436067), u(0.5497004779))
        })
    }

    #[test]
    fn bent_cells_are_one_to_one() {
        let noise = Noise { amplitude: 1.0, scale: Noise::LEAST_SCALE, seed: 5 };
        assert!(!noise.bends_too_far());
        let grid = Grid { origin: DVec3::new(0.3, -2.0, 1.0), size: 0.1, noise };
        let (mut far, mut steepest) = (0.0f64, 0.0f64);
        for x in scatter(20_000) {
            let u = grid.to_cells(x);
            far = far.max((grid.place(u) - x).length() / grid.size);
            let h = 1e-6;
            let slope = |d: DVec3| (grid.to_cells(x + d * h * grid.size) - u) / h - d;
            let (a, b, c) = (slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
            steepest = steepest.max((a.length_squared() + b.length_squared() + c.length_squared()).sqrt());
        }
        assert!(far < 1e-11, "{far}"); // measured 6e-12, up to 200 cells from the origin
        // the Frobenius norm of the gradient of the bend: below 1, it cannot fold
        assert!(steepest < 1.0, "{steepest}"); // measured 0.964
    }

    #[test]
    fn noise_is_smooth_within_bounds_and_of_its_seed() {
        let values: Vec<f64> = scatter(5000).map(|p| perlin(1, p)).collect();
        let (low, high) = values.iter().fold((0.0f64, 0.0f64), |(l, h), &v| (l.min(v), h.max(v)));
        assert!((-1.0..-0.5).contains(&low) && (0.5..1.0).contains(&high), "{low} {high}");
        assert!(values.iter().sum::<f64>().abs() / 5000.0 < 0.02);
        assert!(scatter(100).zip(&values).any(|(p, v)| (perlin(2, p) - v).abs() > 0.1));
        assert_eq!(perlin(7, DVec3::new(3.0, -2.0, 5.0)), 0.0);
    }
}
