//! A rubber that stiffens as it is stretched: T = 6E ω/m · (e + β e³/|ξ|²), the gradient of a quartic energy.
//!
//! With β = 0 this is the bond-based solid with Young's modulus E and ν = ¼: the isotropic law, in which θ drops out.

use fissure_engine::{Bond, BondLaw, Column, Kind, Lane, ParamError, Parameter, Params, Range, Surroundings};

/// The law with its parameters.
pub struct Stiffening {
    /// E [Pa] and β [1].
    young: f64,
    beta: f64,
}

impl BondLaw<0> for Stiffening {
    const NAME: &'static str = "stiffening";
    const SUMMARY: &'static str = "bond-based rubber whose stiffness grows with the square of its stretch";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter {
            name: "young_modulus",
            unit: "Pa",
            kind: Kind::Number(Range::POSITIVE),
            about: "Young's modulus E of the body at rest; ν is ¼",
        },
        Parameter {
            name: "stiffening",
            unit: "1",
            kind: Kind::NumberOr(Range::NOT_NEGATIVE, 1.0),
            about: "β: at stretch s a bond is 1 + 3βs² times as stiff as at rest",
        },
    ];
    const MEMORY: [Column; 0] = [];
    const NEEDS_THETA: bool = false;

    fn from_params(p: &Params, _: &Surroundings) -> Result<Self, ParamError> {
        Ok(Self { young: p.number("young_modulus"), beta: p.number("stiffening") })
    }

    fn has_energy(&self) -> bool {
        true
    }

    fn force<L: Lane>(&self, b: &Bond<L>, _: [L; 0]) -> L {
        let stretch = b.ext / b.rest;
        L::of(6.0 * self.young) * b.inv_m * b.weight * b.ext * (L::of(1.0) + L::of(self.beta) * stretch * stretch)
    }

    fn bond_energy<L: Lane>(&self, b: &Bond<L>, _: [L; 0]) -> L {
        let stretch = b.ext / b.rest;
        let quartic = L::of(1.0) + L::of(0.5 * self.beta) * stretch * stretch;
        L::of(3.0 * self.young) * b.inv_m * b.weight * b.ext * b.ext * quartic
    }
}
