//! The standard linear peridynamic solid (Silling et al. 2007), as other programs compute it.
//!
//! T = ω/m (3κθ|ξ| + 15μ(e − θ|ξ|/3)), θ = 3/m Σ ω|ξ|e V, m = Σ ω|ξ|²V, no surface correction. With influence 1 it is
//! Peridigm's, with δ/|ξ| and `taper` it is LAMMPS's `peri/lps`: their numbers check ours. Bonds break by the plain
//! stretch e/|ξ| of those programs, whatever the influence.

use fissure_engine::{Bond, BondLaw, Column, Kind, Lane, ParamError, Parameter, Params, Surroundings};
use glam::DVec3;

use crate::moduli;
use crate::taper::{TAPER, Taper};

/// Linear peridynamic solid.
pub struct Lps {
    kappa: f64,
    mu: f64,
    inverse: bool,
    taper: Taper,
}

impl BondLaw<0> for Lps {
    const NAME: &'static str = "lps";
    const SUMMARY: &'static str = "standard linear peridynamic solid (Silling et al. 2007), without surface correction";
    const PARAMETERS: &'static [Parameter] = &[
        moduli::BULK,
        moduli::SHEAR,
        moduli::YOUNG,
        moduli::POISSON,
        Parameter {
            name: "influence",
            unit: "1",
            kind: Kind::Word(&["one", "inverse"]),
            about: "influence ω of a bond: 1 (Peridigm) or δ/|ξ| (LAMMPS, and Chen et al., Eq. 5)",
        },
        TAPER,
    ];
    const MEMORY: [Column; 0] = [];

    fn from_params(p: &Params, _: &Surroundings) -> Result<Self, ParamError> {
        let (kappa, mu) = moduli::bulk_and_shear(p)?;
        Ok(Self { kappa, mu, inverse: p.word("influence") == "inverse", taper: Taper::from_params(p) })
    }

    fn has_energy(&self) -> bool {
        true
    }

    fn influence(&self, xi: DVec3, horizon: f64) -> f64 {
        let r = xi.length();
        self.taper.share(r, horizon) * if self.inverse { horizon / r } else { 1.0 }
    }

    #[inline(always)]
    fn force<L: Lane>(&self, b: &Bond<L>, _: [L; 0]) -> L {
        let bulk = L::of(3.0 * self.kappa - 5.0 * self.mu) * b.theta;
        b.inv_m * b.weight * (bulk * b.rest + L::of(15.0 * self.mu) * b.ext)
    }

    /// The deviatoric energy multiplied out, less 5μ/3 of κ in the dilatation; see [`Isotropic`](crate::Isotropic).
    #[inline(always)]
    fn bond_energy<L: Lane>(&self, b: &Bond<L>, _: [L; 0]) -> L {
        L::of(7.5 * self.mu) * b.inv_m * b.weight * b.ext * b.ext
    }

    fn theta_energy(&self, theta: f64) -> f64 {
        0.5 * (self.kappa - 5.0 / 3.0 * self.mu) * theta * theta
    }
}
