//! How damage φ changes the stretch at which a bond breaks: α of Eq. 19, in both readings.
//!
//! Printed, Eq. 19 multiplies s^e/ω by (1 + αφ), which breaks *more* bonds as damage grows, against the paper's own words
//! (measured: 6970 broken at α = 0, 11 300 at α = 2). Dividing does what the text says (5600 to 6400), and is the default.

use crate::lane::Lane;
use crate::params::{Kind, Parameter, Params, Range};

pub(super) const ALPHA: Parameter = Parameter {
    name: "alpha",
    unit: "1",
    kind: Kind::NumberOr(Range::NOT_NEGATIVE, 0.0),
    about: "α of Eq. 19: how much damage toughens what is left, against dust",
};
pub(super) const READING: Parameter = Parameter {
    name: "alpha_reading",
    unit: "1",
    kind: Kind::Word(&["divide", "as_written"]),
    about: "s/(1 + αφ), which does what the paper says, or s(1 + αφ) as Eq. 19 is printed",
};

/// A critical stretch that depends on damage.
#[derive(Clone, Copy)]
pub(super) struct Toughening {
    limit: f64,
    alpha: f64,
    divide: bool,
}

impl Toughening {
    /// Critical stretch `limit` [1] of undamaged material, with [`ALPHA`] and [`READING`] from `p`.
    pub fn new(limit: f64, p: &Params) -> Self {
        Self { limit, alpha: p.number(ALPHA.name), divide: p.word(READING.name) == "divide" }
    }

    /// `stretch` over what a bond bears at `damage`.
    #[inline(always)]
    pub fn severity<L: Lane>(&self, stretch: L, damage: L) -> L {
        let share = stretch * L::of(1.0 / self.limit);
        let factor = L::of(1.0) + L::of(self.alpha) * damage;
        if self.divide { share / factor } else { share * factor }
    }

    /// The least stretch that may break a bond, at any damage.
    #[inline(always)]
    pub fn least(&self) -> f64 {
        if self.divide { self.limit } else { self.limit / (1.0 + self.alpha) }
    }
}
