//! An elastic–plastic law of bonds that is right, and what can be done wrong in its memory, one mistake each.

use std::marker::PhantomData;

use fissure_engine::{Bond, BondLaw, Column, Kind, Lane, Of, ParamError, Parameter, Params, Range, Surroundings};

use crate::elastic::State;

/// A change of the right law: bonds of stiffness c that yield at a stretch, without dilatation.
pub trait Flaw: Send + Sync + 'static {
    const NAME: &'static str;
    /// The elastic part of the extension that the force is made of.
    fn elastic<L: Lane>(s: &State, b: &Bond<L>, past: L) -> L {
        returned(s, b, past)
    }
    /// The plastic part after the flow.
    fn flow<L: Lane>(s: &State, b: &Bond<L>, past: L, _dt: f64) -> L {
        b.ext - returned(s, b, past)
    }
}

/// Back onto the yield surface.
fn returned<L: Lane>(s: &State, b: &Bond<L>, past: L) -> L {
    let limit = L::of(s.mu) * b.rest;
    (b.ext - past).clamp(-limit, limit)
}

/// [`State::kappa`] is the modulus [Pa] and [`State::mu`] the yield stretch.
pub struct Plastic<F>(State, PhantomData<F>);

impl<F: Flaw> Plastic<F> {
    fn stiffness<L: Lane>(&self, b: &Bond<L>) -> L {
        L::of(9.0 * self.0.kappa) * b.inv_m * b.weight
    }
}

impl<F: Flaw> BondLaw<1> for Plastic<F> {
    const NAME: &'static str = F::NAME;
    const SUMMARY: &'static str = "an elastic-plastic law with one fault";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter { name: "bulk_modulus", unit: "Pa", kind: Kind::Number(Range::POSITIVE), about: "κ" },
        Parameter { name: "yield_stretch", unit: "1", kind: Kind::Number(Range::POSITIVE), about: "yield" },
    ];
    const MEMORY: [Column; 1] = [Column::live("plastic_extension", "m", Of::Bond)];
    const NEEDS_THETA: bool = false;

    fn from_params(p: &Params, _: &Surroundings) -> Result<Self, ParamError> {
        let state = State { kappa: p.number("bulk_modulus"), mu: p.number("yield_stretch"), ..State::default() };
        Ok(Self(state, PhantomData))
    }
    fn needs_influence(&self) -> bool {
        true
    }
    fn has_energy(&self) -> bool {
        true
    }
    fn dilatation<L: Lane>(&self, _: &Bond<L>) -> L {
        L::of(0.0)
    }
    fn force<L: Lane>(&self, b: &Bond<L>, [past]: [L; 1]) -> L {
        self.stiffness(b) * F::elastic(&self.0, b, past)
    }
    fn flow<L: Lane>(&self, b: &Bond<L>, [past]: [L; 1], dt: f64) -> [L; 1] {
        [F::flow(&self.0, b, past, dt)]
    }
    fn elastic_extension<L: Lane>(&self, b: &Bond<L>, [past]: [L; 1]) -> L {
        b.ext - past
    }
    fn bond_energy<L: Lane>(&self, b: &Bond<L>, [past]: [L; 1]) -> L {
        let e = returned(&self.0, b, past);
        L::of(0.5) * self.stiffness(b) * e * e
    }
}

/// No fault.
pub struct Sound;
impl Flaw for Sound {
    const NAME: &'static str = "sound";
}

/// Δe^p = (A − A_c)/2b where the stiffness is 4ωb (Chen et al., Eq. 15 as printed): the return overshoots 2ω times.
pub struct Eq15;
impl Flaw for Eq15 {
    const NAME: &'static str = "eq15";
    fn flow<L: Lane>(s: &State, b: &Bond<L>, past: L, _: f64) -> L {
        let beyond = b.ext - past - returned(s, b, past);
        past + L::of(2.0) * b.influence * beyond
    }
}

/// Flows a fixed part of the way each time it is called, however short the step.
pub struct Creeping;
impl Flaw for Creeping {
    const NAME: &'static str = "creeping";
    fn flow<L: Lane>(s: &State, b: &Bond<L>, past: L, _: f64) -> L {
        let now = b.ext - returned(s, b, past);
        now + L::of(0.1) * (b.ext - now)
    }
}

/// Negative damping: the force runs ahead of the motion.
pub struct Driving;
impl Flaw for Driving {
    const NAME: &'static str = "driving";
    fn elastic<L: Lane>(_: &State, b: &Bond<L>, past: L) -> L {
        b.ext - L::of(0.3) * (b.ext - past)
    }
    fn flow<L: Lane>(_: &State, b: &Bond<L>, _: L, _: f64) -> L {
        b.ext
    }
}

/// Hardens with a count that no column holds.
pub struct Hidden;
impl Flaw for Hidden {
    const NAME: &'static str = "hidden";
    fn flow<L: Lane>(s: &State, b: &Bond<L>, past: L, _: f64) -> L {
        let harder =
            State { kappa: s.kappa, mu: if s.count() > 50_000 { 2.0 * s.mu } else { s.mu }, ..State::default() };
        b.ext - returned(&harder, b, past)
    }
}

/// Rolls dice in the flow: each side of a bond remembers something else.
pub struct Dice;
impl Flaw for Dice {
    const NAME: &'static str = "dice";
    fn flow<L: Lane>(s: &State, b: &Bond<L>, past: L, _: f64) -> L {
        let dice = f64::from(s.count().wrapping_mul(0x9E37_79B9) >> 16) / 65536.0;
        b.ext - returned(s, b, past) * L::of(1.0 - 1e-3 * dice)
    }
}

/// Has a memory that never changes.
pub struct Rigid;
impl Flaw for Rigid {
    const NAME: &'static str = "rigid";
    fn flow<L: Lane>(_: &State, _: &Bond<L>, past: L, _: f64) -> L {
        past
    }
}
