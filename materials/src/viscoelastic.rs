//! Viscoelastic in shear: the standard linear solid, on the deviatoric extension of each directed bond.
//!
//! A share g of the shear stiffness sits behind a dashpot whose extension e^v follows the deviatoric extension with
//! relaxation time τ: A_dev = 15μω/m (e^d − g e^v), ė^v = (e^d − e^v)/τ. So μ is the modulus of fast loading, (1 − g)μ of
//! slow loading, and a held shape relaxes as 1 − g + g e^(−t/τ). Volume changes stay elastic. (Mitchell 2011, LAMMPS's
//! `peri/ves`, do the same.)
//!
//! e^v is kept as a pair of f32: with one, steps below 1e-6 τ would add less than its rounding and relaxation would stop.

use fissure_engine::{Bond, BondLaw, Column, Kind, Lane, Of, ParamError, Parameter, Params, Range, Surroundings};

use crate::{Isotropic, moduli};

/// Standard linear solid.
pub struct Viscoelastic {
    elastic: Isotropic,
    /// g [1].
    share: f64,
    /// τ [s].
    time: f64,
}

impl BondLaw<2> for Viscoelastic {
    const NAME: &'static str = "viscoelastic";
    const SUMMARY: &'static str = "isotropic solid whose shear stress relaxes with time (standard linear solid)";
    const PARAMETERS: &'static [Parameter] = &[
        moduli::BULK,
        Parameter { about: "shear modulus μ of fast loading; with `bulk_modulus`", ..moduli::SHEAR },
        moduli::YOUNG,
        moduli::POISSON,
        Parameter {
            name: "relaxing_share",
            unit: "1",
            kind: Kind::Number(Range { low: (0.0, true), high: (1.0, false) }),
            about: "share g of the shear stress that relaxes when a shape is held",
        },
        Parameter {
            name: "relaxation_time",
            unit: "s",
            kind: Kind::Number(Range::POSITIVE),
            about: "time τ in which the relaxing stress falls to 1/e",
        },
    ];
    const MEMORY: [Column; 2] =
        [Column::live("viscous_extension", "m", Of::Bond), Column::live("viscous_extension_rest", "m", Of::Bond)];

    fn from_params(p: &Params, at: &Surroundings) -> Result<Self, ParamError> {
        let (kappa, mu) = moduli::bulk_and_shear(p)?;
        let elastic = Isotropic::new(kappa, mu, at.horizon);
        Ok(Self { elastic, share: p.number("relaxing_share"), time: p.number("relaxation_time") })
    }

    fn compensates_surface(&self) -> bool {
        true
    }

    fn has_energy(&self) -> bool {
        true
    }

    #[inline(always)]
    fn dilatation<L: Lane>(&self, b: &Bond<L>) -> L {
        self.elastic.dilatation(b)
    }

    #[inline(always)]
    fn force<L: Lane>(&self, b: &Bond<L>, [high, low]: [L; 2]) -> L {
        self.elastic.force(&Bond { ext: b.ext - L::of(self.share) * (high + low), ..*b }, [])
    }

    /// e^v ← e^d + (e^v − e^d) e^(−dt/τ): exact for an extension that is held over the step.
    #[inline(always)]
    fn flow<L: Lane>(&self, b: &Bond<L>, [high, low]: [L; 2], dt: f64) -> [L; 2] {
        let followed = L::of(-(-dt / self.time).exp_m1());
        let deviator = b.ext - L::of(1.0 / 3.0) * b.theta * b.rest;
        let change = ((deviator - high) - low) * followed + low;
        // Knuth's two-sum: high + change, and what rounding dropped
        let sum = high + change;
        let added = sum - high;
        [sum, (high - (sum - added)) + (change - added)]
    }

    #[inline(always)]
    fn gauge<L: Lane>(&self, b: &Bond<L>) -> L {
        self.elastic.gauge(b)
    }

    /// The two springs: 1 − g along e, g along e − e^v.
    #[inline(always)]
    fn bond_energy<L: Lane>(&self, b: &Bond<L>, [high, low]: [L; 2]) -> L {
        let branch = Bond { ext: b.ext - (high + low), ..*b };
        let (lasting, relaxing) = (self.elastic.bond_energy(b, []), self.elastic.bond_energy(&branch, []));
        L::of(1.0 - self.share) * lasting + L::of(self.share) * relaxing
    }

    fn theta_energy(&self, theta: f64) -> f64 {
        self.elastic.theta_energy(theta)
    }
}
