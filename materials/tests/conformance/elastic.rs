//! An elastic law that is right, and what can be done wrong in it, one mistake each.

use std::sync::atomic::{AtomicU32, Ordering};

use fissure_engine::fracture::{Bulk, Criterion, Opening};
use fissure_engine::{Bond, BondLaw, Column, Kind, Lane, ParamError, Parameter, Params, Range, Surroundings};
use fissure_materials::moduli;
use glam::DVec3;

/// κ and μ and whatever a mutant counts.
#[derive(Default)]
pub struct State {
    pub kappa: f64,
    pub mu: f64,
    pub calls: AtomicU32,
}

impl State {
    /// How often this was asked before.
    pub fn count(&self) -> u32 {
        self.calls.fetch_add(1, Ordering::Relaxed)
    }
}

const MODULI: &[Parameter] = &[moduli::BULK, moduli::SHEAR, moduli::YOUNG, moduli::POISSON];

/// A change of the right law; every method defaults to it.
pub trait Fault: Send + Sync + 'static {
    const NAME: &'static str;
    const PARAMETERS: &'static [Parameter] = MODULI;
    const COS: bool = false;
    fn read(p: &Params) -> Result<(f64, f64), ParamError> {
        moduli::bulk_and_shear(p)
    }
    fn influence(xi: DVec3, horizon: f64) -> f64 {
        horizon / xi.length()
    }
    fn dilatation<L: Lane>(b: &Bond<L>) -> L {
        L::of(3.0) * b.inv_m * b.weight * b.rest * b.ext
    }
    fn force<L: Lane>(s: &State, b: &Bond<L>) -> L {
        right(s, b)
    }
    fn bond_energy<L: Lane>(s: &State, b: &Bond<L>) -> L {
        L::of(7.5 * s.mu) * b.inv_m * b.weight * b.ext * b.ext
    }
}

fn right<L: Lane>(s: &State, b: &Bond<L>) -> L {
    let (bulk, shear) = (L::of(s.kappa - 5.0 / 3.0 * s.mu), L::of(15.0 * s.mu));
    b.inv_m * b.weight * (L::of(3.0) * bulk * b.theta * b.rest + shear * b.ext)
}

pub struct Elastic<F>(State, std::marker::PhantomData<F>);

impl<F: Fault> BondLaw<0> for Elastic<F> {
    const NAME: &'static str = F::NAME;
    const SUMMARY: &'static str = "an elastic law with one fault";
    const PARAMETERS: &'static [Parameter] = F::PARAMETERS;
    const MEMORY: [Column; 0] = [];

    fn from_params(p: &Params, _: &Surroundings) -> Result<Self, ParamError> {
        let (kappa, mu) = F::read(p)?;
        Ok(Self(State { kappa, mu, ..State::default() }, std::marker::PhantomData))
    }
    fn needs_cos(&self) -> bool {
        F::COS
    }
    fn has_energy(&self) -> bool {
        true
    }
    fn influence(&self, xi: DVec3, horizon: f64) -> f64 {
        F::influence(xi, horizon)
    }
    fn dilatation<L: Lane>(&self, b: &Bond<L>) -> L {
        F::dilatation(b)
    }
    fn force<L: Lane>(&self, b: &Bond<L>, _: [L; 0]) -> L {
        F::force(&self.0, b)
    }
    fn bond_energy<L: Lane>(&self, b: &Bond<L>, _: [L; 0]) -> L {
        F::bond_energy(&self.0, b)
    }
    fn theta_energy(&self, theta: f64) -> f64 {
        0.5 * (self.0.kappa - 5.0 / 3.0 * self.0.mu) * theta * theta
    }
}

/// No fault.
pub struct Right;
impl Fault for Right {
    const NAME: &'static str = "right";
}

/// Λ in θ and in the force (Chen et al., Eqs. 4 and 6).
pub struct Lambda;
impl Fault for Lambda {
    const NAME: &'static str = "lambda";
    const COS: bool = true;
    fn dilatation<L: Lane>(b: &Bond<L>) -> L {
        Right::dilatation(b) * b.cos
    }
    fn force<L: Lane>(s: &State, b: &Bond<L>) -> L {
        right(s, &Bond { theta: b.theta * b.cos, ..*b })
    }
}

/// A force at rest: bonds want to be longer than they are.
pub struct Prestress;
impl Fault for Prestress {
    const NAME: &'static str = "prestress";
    fn force<L: Lane>(s: &State, b: &Bond<L>) -> L {
        right(s, &Bond { ext: b.ext - L::of(1e-4) * b.rest, ..*b })
    }
}

/// Divides by the extension: 0/0 at rest.
pub struct Direction;
impl Fault for Direction {
    const NAME: &'static str = "direction";
    fn force<L: Lane>(s: &State, b: &Bond<L>) -> L {
        right(s, b) * (b.ext.abs() / b.ext.abs())
    }
}

/// Computes the extension from lengths, in f32.
pub struct Cancelling;
impl Fault for Cancelling {
    const NAME: &'static str = "cancelling";
    fn force<L: Lane>(s: &State, b: &Bond<L>) -> L {
        let length = b.rest + b.ext;
        right(s, &Bond { ext: length - b.rest, ..*b })
    }
}

/// Forgets the ½ of the energy.
pub struct Double;
impl Fault for Double {
    const NAME: &'static str = "double_energy";
    fn bond_energy<L: Lane>(s: &State, b: &Bond<L>) -> L {
        Right::bond_energy(s, b) * L::of(2.0)
    }
}

/// An influence that changes with the sign of ξ, as (Gξ)·e would in place of |Gξ|.
pub struct Lopsided;
impl Fault for Lopsided {
    const NAME: &'static str = "lopsided";
    fn influence(xi: DVec3, horizon: f64) -> f64 {
        horizon / xi.length() * (1.0 + 0.2 * xi.x / xi.length())
    }
}

/// Counts compression as positive: the same forces, but the step that is derived misses the bulk stiffness.
pub struct Compression;
impl Fault for Compression {
    const NAME: &'static str = "compression";
    fn read(p: &Params) -> Result<(f64, f64), ParamError> {
        moduli::bulk_and_shear(p).map(|(k, g)| (20.0 * k, g))
    }
    fn dilatation<L: Lane>(b: &Bond<L>) -> L {
        -Right::dilatation(b)
    }
    fn force<L: Lane>(s: &State, b: &Bond<L>) -> L {
        right(s, &Bond { theta: -b.theta, ..*b })
    }
}

/// Stiff within a strain of 1e-9: the differences over 1e-6 that the step is derived from miss it.
pub struct Kinked;
impl Fault for Kinked {
    const NAME: &'static str = "kinked";
    fn force<L: Lane>(s: &State, b: &Bond<L>) -> L {
        let small = L::of(1e-9) * b.rest;
        right(s, &Bond { ext: b.ext + L::of(5e3) * b.ext.clamp(-small, small), ..*b })
    }
}

/// Remembers in the force pass: each evaluation finds the bonds a little softer.
pub struct Tiring;
impl Fault for Tiring {
    const NAME: &'static str = "tiring";
    fn force<L: Lane>(s: &State, b: &Bond<L>) -> L {
        right(s, b) * L::of(1.0 - 1e-9 * f64::from(s.count()))
    }
}

/// Thermal noise without a seed.
pub struct Random;
impl Fault for Random {
    const NAME: &'static str = "random";
    fn force<L: Lane>(s: &State, b: &Bond<L>) -> L {
        let dice = s.count().wrapping_mul(0x9E37_79B9) >> 16;
        right(s, b) * L::of(1.0 + 1e-3 * f64::from(dice) / 65536.0)
    }
}

/// Depends on the thread that happens to work.
pub struct Threaded;
impl Fault for Threaded {
    const NAME: &'static str = "threaded";
    fn force<L: Lane>(s: &State, b: &Bond<L>) -> L {
        let threads = rayon::current_num_threads() as f64;
        right(s, b) * L::of(1.0 + 1e-4 * threads)
    }
}

/// Declares that Poisson's ratio may be anything.
pub struct Unranged;
impl Fault for Unranged {
    const NAME: &'static str = "unranged";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter { kind: Kind::Number(Range::POSITIVE), ..moduli::YOUNG },
        Parameter { kind: Kind::Number(Range::open(f64::NEG_INFINITY, f64::INFINITY)), ..moduli::POISSON },
    ];
    fn read(p: &Params) -> Result<(f64, f64), ParamError> {
        let (e, nu) = (p.number("young_modulus"), p.number("poisson_ratio"));
        Ok((e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu))))
    }
}

/// Answers a bad combination with a panic.
pub struct Panicking;
impl Fault for Panicking {
    const NAME: &'static str = "panicking";
    const PARAMETERS: &'static [Parameter] = &[
        moduli::BULK,
        moduli::SHEAR,
        moduli::YOUNG,
        moduli::POISSON,
        Parameter { name: "hardness", unit: "1", kind: Kind::NumberOr(Range::NOT_NEGATIVE, 0.0), about: "h" },
    ];
    fn read(p: &Params) -> Result<(f64, f64), ParamError> {
        assert!(p.number("hardness") < 10.0, "too hard");
        moduli::bulk_and_shear(p)
    }
}

/// Says nothing of what a parameter is, nor its unit.
pub struct Undocumented;
impl Fault for Undocumented {
    const NAME: &'static str = "undocumented";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter { kind: Kind::Number(Range::POSITIVE), ..moduli::BULK },
        Parameter { kind: Kind::Number(Range::POSITIVE), ..moduli::SHEAR },
        Parameter { name: "c", unit: "", kind: Kind::NumberOr(Range::POSITIVE, 1.0), about: "" },
    ];
    fn read(p: &Params) -> Result<(f64, f64), ParamError> {
        Ok((p.number("bulk_modulus"), p.number("shear_modulus")))
    }
}

/// Has a default that it would refuse.
pub struct Defaulting;
impl Fault for Defaulting {
    const NAME: &'static str = "defaulting";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter { kind: Kind::NumberOr(Range::POSITIVE, 1e6), ..moduli::BULK },
        Parameter { kind: Kind::NumberOr(Range::POSITIVE, 4e5), ..moduli::SHEAR },
        Parameter { name: "hardness", unit: "1", kind: Kind::NumberOr(Range::open(0.0, 1.0), -1.0), about: "h" },
    ];
    fn read(p: &Params) -> Result<(f64, f64), ParamError> {
        Ok((p.number("bulk_modulus"), p.number("shear_modulus")))
    }
}

/// The right law, to be broken by [`Moody`].
pub struct HalfBroken;
impl Fault for HalfBroken {
    const NAME: &'static str = "half_broken";
}

/// A criterion that judges every other time more harshly, so that one direction of a bond breaks before the other.
pub struct Moody {
    limit: f64,
    calls: AtomicU32,
}
impl Criterion for Moody {
    const NAME: &'static str = "moody";
    const SUMMARY: &'static str = "breaks at a stretch that it keeps changing";
    const PARAMETERS: &'static [Parameter] = &[Parameter {
        name: "critical_stretch",
        unit: "1",
        kind: Kind::Number(Range::POSITIVE),
        about: "stretch beyond which bonds break",
    }];
    fn from_params(p: &Params, _: &Surroundings, _: &Bulk) -> Result<Self, ParamError> {
        Ok(Self { limit: p.number("critical_stretch"), calls: AtomicU32::new(0) })
    }
    fn severity<L: Lane>(&self, b: &Opening<L>, _: L) -> L {
        let harsh = f64::from(1 + self.calls.fetch_add(1, Ordering::Relaxed) % 2);
        b.stretch() * L::of(harsh / self.limit)
    }
}
