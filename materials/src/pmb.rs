//! The bond-based prototype microelastic brittle solid (Silling and Askari 2005), which Levine et al. animate with.
//!
//! Every bond is a spring of its own: pair force c e/|ξ| with c = 18κ/(πδ⁴), so Poisson's ratio is always ¼ and one
//! modulus says all. One pass over the bonds instead of two. Bonds break by the plain stretch e/|ξ|.

use std::f64::consts::PI;

use fissure_engine::{Bond, BondLaw, Column, Lane, ParamError, Parameter, Params, Surroundings};
use glam::DVec3;

use crate::moduli;
use crate::taper::{TAPER, Taper};

/// Prototype microelastic brittle solid.
pub struct Pmb {
    /// Micromodulus c [N/m⁶].
    c: f64,
    taper: Taper,
}

impl BondLaw<0> for Pmb {
    const NAME: &'static str = "pmb";
    const SUMMARY: &'static str = "bond-based microelastic solid, Poisson's ratio 1/4 (Silling and Askari 2005)";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter { about: "bulk modulus κ; or give `young_modulus`, 3/2 of it", ..moduli::BULK },
        Parameter { about: "Young's modulus E; or give `bulk_modulus`, 2/3 of it", ..moduli::YOUNG },
        TAPER,
    ];
    const MEMORY: [Column; 0] = [];
    const NEEDS_THETA: bool = false;

    fn from_params(p: &Params, at: &Surroundings) -> Result<Self, ParamError> {
        let kappa = match (p.optional(moduli::BULK.name), p.optional(moduli::YOUNG.name)) {
            (Some(kappa), None) => kappa,
            (None, Some(young)) => young / 1.5, // E = 3κ(1 − 2ν)
            _ => {
                let message = "give either `bulk_modulus` or `young_modulus` [Pa]; Poisson's ratio is 1/4";
                return Err(ParamError::new(p.given_of(&[moduli::BULK.name, moduli::YOUNG.name]), message.into()));
            }
        };
        Ok(Self { c: 18.0 * kappa / (PI * at.horizon.powi(4)), taper: Taper::from_params(p) })
    }

    fn has_energy(&self) -> bool {
        true
    }

    fn influence(&self, xi: DVec3, horizon: f64) -> f64 {
        self.taper.share(xi.length(), horizon)
    }

    /// Half of the pair force: the other half comes from the other side.
    #[inline(always)]
    fn force<L: Lane>(&self, b: &Bond<L>, _: [L; 0]) -> L {
        L::of(0.5 * self.c) * b.weight * b.ext / b.rest
    }

    /// Half of the pair's ½ c e²/|ξ|.
    #[inline(always)]
    fn bond_energy<L: Lane>(&self, b: &Bond<L>, _: [L; 0]) -> L {
        L::of(0.25 * self.c) * b.weight * b.ext * b.ext / b.rest
    }
}
