//! The unit that displacements are counted in: a power of two, so that counts are exact, chosen anew in every step.
//!
//! Counts are 32 bits and wrap around, and so do their differences. The difference of two ends of a bond is therefore
//! exact wherever the two are, as long as the bond itself has grown by less than 2³¹ quanta in each direction. So a
//! fragment that flies far from its body's frame keeps its precision, in three words instead of the six of a pair of f32.
//!
//! As long as nothing is far, the largest displacement sets the quantum, and no difference can wrap. Beyond that it stays
//! at [`RANGE`] horizons over 2³¹, and every bond that holds must be shown to be shorter than that. The bonds are measured
//! for it, but again only when some particle has moved as far as the shortest of what was left. If one is longer (in the
//! step in which it breaks, or in a body that nothing breaks) the quantum is that of the largest displacement after all.
//! Whether bonds were measured changes nothing but the time: the answer is that of the present positions.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::bonds::Bonds;

/// Growth of a bond, in horizons, up to which a far fragment keeps its precision: its quantum is a strain of
/// RANGE/2³¹ = 4e-9 of a bond as long as the horizon.
const RANGE: f64 = 8.0;

/// The smallest displacement that counts, in horizons: less is the rounding of f64 positions in any body.
const LEAST: f64 = 1e-15;

/// What is known about the growth of the bonds that hold.
#[derive(Default)]
pub(super) struct Growth {
    /// Displacements [m] when the bonds were measured.
    measured: Vec<Vec3>,
    /// How far [m] every particle may move from there before some bond may have grown too far.
    slack: f64,
}

impl Growth {
    /// Forgets the measurement, for other bonds.
    pub fn forget(&mut self) {
        self.slack = 0.0;
    }

    /// The quantum [m] for displacements `u` [m] of the particles of a body with horizon `horizon` [m].
    pub fn quantum(&mut self, bonds: &Bonds, horizon: f64, u: &(impl Fn(usize) -> DVec3 + Sync)) -> f64 {
        let n = bonds.rows();
        self.measured.resize(n, Vec3::ZERO);
        let range = above(RANGE * horizon);
        let fine = range / f64::from(1u32 << 31);
        let most = largest(n, &|i| size(u(i)));
        // no count is beyond 2³⁰, so no difference beyond 2³¹
        let whole = above(1.01 * most.max(LEAST * horizon)) / f64::from(1 << 30);
        if whole <= fine || most > FARTHEST * fine || !self.within(0.99 * range, most, bonds, u) { whole } else { fine }
    }

    /// Whether every bond that holds has grown by less than `range` [m]; `most` is the largest displacement.
    fn within(&mut self, range: f64, most: f64, bonds: &Bonds, u: &(impl Fn(usize) -> DVec3 + Sync)) -> bool {
        let n = bonds.rows();
        let moved = largest(n, &|i| size(u(i) - self.measured[i].as_dvec3()));
        if moved + 1e-6 * most < self.slack {
            return true;
        }
        let longest = largest(n, &|i| {
            let home = u(i);
            bonds.slots(i).map(|slot| size(u(bonds.neighbours[slot] as usize) - home)).fold(0.0, f64::max)
        });
        self.slack = (range - longest) / 2.0;
        self.measured.par_iter_mut().enumerate().with_min_len(1024).for_each(|(i, at)| *at = u(i).as_vec3());
        longest < range
    }
}

/// Most quanta that a count may wrap around from.
const FARTHEST: f64 = (1u64 << 50) as f64;

/// `x` in quanta, of which `per` are a metre, modulo 2³²: the low bits of a number whose last bit is a one.
#[inline(always)]
pub(super) fn count(x: f64, per: f64) -> i32 {
    const UNITS: f64 = 1.5 * (1u64 << 52) as f64;
    (x * per + UNITS).to_bits() as i32
}

/// The largest of so many numbers; those that are none do not count.
fn largest(n: usize, of: &(impl Fn(usize) -> f64 + Sync)) -> f64 {
    (0..n).into_par_iter().with_min_len(1024).map(of).reduce(|| 0.0, f64::max)
}

/// The largest component; 0 for what is not finite, which nothing can be counted by.
fn size(u: DVec3) -> f64 {
    if u.is_finite() { u.abs().max_element() } else { 0.0 }
}

/// The least power of two above `x`, which is positive.
fn above(x: f64) -> f64 {
    f64::from_bits(((x.to_bits() >> 52) + 1) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bonds::Families;

    #[test]
    fn counts_wrap_and_their_differences_do_not() {
        let per = f64::from(1 << 30);
        for far in [0.0, 3.0, -1e5, 7.7e5] {
            let (a, b) = (count(far + 0.25, per), count(far - 0.5, per));
            assert_eq!(a.wrapping_sub(b), 3 << 28, "{far}");
        }
        assert_eq!((count(0.6, 1.0), count(-0.6, 1.0), count(2.5, 1.0)), (1, -1, 2));
    }

    #[test]
    fn the_power_of_two_above() {
        assert_eq!([0.7, 1.0, 1.5, 1e-9].map(above), [1.0, 2.0, 2.0, 2f64.powi(-29)]);
    }

    /// Two pairs of horizon 1; the second is moved by `far` and its bond stretched by `growth`.
    fn quantum(growth: &mut Growth, far: f64, stretch: f64, broken: bool) -> f64 {
        let families = Families { offsets: vec![0, 1, 2, 3, 4], neighbours: vec![1, 0, 3, 2] };
        let rest = [0.0, 1.0, 2.0, 3.0].map(|x| Vec3::X * x);
        let mut bonds = Bonds::new(&families, &rest, |_, _| 1.0);
        if broken {
            bonds.intact.to_mut()[2..].fill(0);
        }
        let u = |i: usize| DVec3::Z * [0.0, 1e-6, far, far + stretch][i];
        growth.quantum(&bonds, 1.0, &u)
    }

    #[test]
    fn what_is_near_is_counted_finely_and_what_is_far_no_less_than_its_bonds_allow() {
        let mut growth = Growth::default();
        let fine = 16.0 / f64::from(1u32 << 31);
        assert_eq!(quantum(&mut growth, 0.001, 0.0, false), 2f64.powi(-9 - 30));
        assert_eq!(quantum(&mut growth, 900.0, 0.1, false), fine);
        assert_eq!(quantum(&mut growth, 900.0, 17.0, false), 1024.0 / f64::from(1 << 30));
        assert_eq!(quantum(&mut growth, 900.0, 17.0, true), fine);
        // counts further out than this would lose bits of f64
        assert!(quantum(&mut growth, 1e8, 0.1, false) > fine);
    }

    #[test]
    fn bonds_are_measured_again_before_one_may_have_grown_too_far() {
        let mut kept = Growth::default();
        for k in 0..200 {
            let (far, stretch) = (100.0 + 0.3 * f64::from(k), 0.1 * f64::from(k));
            let fresh = quantum(&mut Growth::default(), far, stretch, false);
            assert_eq!(quantum(&mut kept, far, stretch, false), fresh, "stretched by {stretch}");
        }
    }
}
