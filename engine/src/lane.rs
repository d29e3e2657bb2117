//! The number a law computes with: `f32` to read and debug, [`f32x8`] for speed, `f64` for reference.
//!
//! A law is written once over [`Lane`], without branches: decisions are [`Lane::pick`] on a mask. Every operation here
//! is correctly rounded by IEEE 754 and nothing is fused, so eight lanes, one lane, and every machine give the same bits.
//! For the same reason there is no `mul_add` and no approximate reciprocal.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use wide::f32x8;

use crate::erased::{CriterionIn, DynCriterion, DynLaw, LawIn};

/// A number, or eight of them side by side.
pub trait Lane:
    Copy
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The answer of a comparison, one per number.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask> + Not<Output = Self::Mask>;

    /// The same constant in every number.
    fn of(x: f64) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The smaller of two.
    fn min(self, other: Self) -> Self;
    /// The larger of two.
    fn max(self, other: Self) -> Self;
    /// Exponential function e^x.
    fn exp(self) -> Self;
    /// Where `self > other`.
    fn above(self, other: Self) -> Self::Mask;
    /// Where `self < other`.
    fn below(self, other: Self) -> Self::Mask;
    /// `yes` where the mask holds, `no` elsewhere.
    fn pick(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// The side of a law of unknown type that speaks this lane.
    #[doc(hidden)]
    fn law(law: &dyn DynLaw) -> &dyn LawIn<Self>;
    /// The side of a criterion of unknown type that speaks this lane.
    #[doc(hidden)]
    fn criterion(criterion: &dyn DynCriterion) -> &dyn CriterionIn<Self>;

    /// `self` limited to `low ..= high`.
    #[inline(always)]
    fn clamp(self, low: Self, high: Self) -> Self {
        self.max(low).min(high)
    }
}

macro_rules! scalar_lane {
    ($float:ty) => {
        impl Lane for $float {
            type Mask = bool;
            #[inline(always)]
            fn of(x: f64) -> Self {
                x as $float
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn exp(self) -> Self {
                self.exp()
            }
            #[inline(always)]
            fn above(self, other: Self) -> bool {
                self > other
            }
            #[inline(always)]
            fn below(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn pick(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
            fn law(law: &dyn DynLaw) -> &dyn LawIn<Self> {
                law
            }
            fn criterion(criterion: &dyn DynCriterion) -> &dyn CriterionIn<Self> {
                criterion
            }
        }
    };
}
scalar_lane!(f32);
scalar_lane!(f64);

/// A comparison of eight numbers: all bits set where it holds.
#[derive(Clone, Copy)]
pub struct Mask8(pub(crate) f32x8);

impl BitAnd for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}
impl BitOr for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}
impl Not for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl Lane for f32x8 {
    type Mask = Mask8;
    #[inline(always)]
    fn of(x: f64) -> Self {
        f32x8::splat(x as f32)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.fast_min(other) // `self < other ? self : other`, one instruction
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.fast_max(other)
    }
    /// Number by number, so that eight lanes give the bits of one.
    fn exp(self) -> Self {
        f32x8::from(self.to_array().map(f32::exp))
    }
    #[inline(always)]
    fn above(self, other: Self) -> Mask8 {
        Mask8(self.simd_gt(other))
    }
    #[inline(always)]
    fn below(self, other: Self) -> Mask8 {
        Mask8(self.simd_lt(other))
    }
    #[inline(always)]
    fn pick(mask: Mask8, yes: Self, no: Self) -> Self {
        mask.0.select(yes, no)
    }
    #[inline(always)]
    fn law(law: &dyn DynLaw) -> &dyn LawIn<Self> {
        law
    }
    #[inline(always)]
    fn criterion(criterion: &dyn DynCriterion) -> &dyn CriterionIn<Self> {
        criterion
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_lanes_are_eight_times_one() {
        let a = [0.5f32, -1.0, 3.0, 1e-8, -0.0, 7.5, 2.0, -9.0];
        let b = [0.25f32, 2.0, -3.0, 1e8, 0.0, 7.5, 1.5, -8.0];
        let (wa, wb) = (f32x8::from(a), f32x8::from(b));
        let same = |wide: f32x8, one: fn(f32, f32) -> f32| {
            for (k, w) in wide.to_array().into_iter().enumerate() {
                assert_eq!(w.to_bits(), one(a[k], b[k]).to_bits(), "lane {k}");
            }
        };
        same(Lane::min(wa, wb), Lane::min);
        same(Lane::max(wa, wb), Lane::max);
        same(wa / wb, |x, y| x / y);
        same(Lane::abs(wa).sqrt(), |x, _| x.abs().sqrt());
        same(Lane::exp(wa), |x, _| Lane::exp(x));
        same(f32x8::pick(wa.above(wb), wa, -wb), |x, y| f32::pick(x.above(y), x, -y));
        same(f32x8::pick(wa.below(wb) & !wa.above(wb), wa, wb), |x, y| if x < y { x } else { y });
    }
}
