//! The elastic and perfectly plastic solid of Mitchell (2011, Sandia report SAND2011-3166), as Peridigm computes it.
//!
//! The linear peridynamic solid of [`Lps`](crate::Lps) with influence 1, whose family yields as one, like a solid of von
//! Mises: t = 15μ/m (e − θ|ξ|/3 − e^p) is held at ‖t‖² = Σ t² V ≤ 2ψ0. The return is radial: every bond is scaled back by
//! the same factor, Δe^p = tΔλ with Δλ = (‖t‖/√(2ψ0) − 1) m/(15μ) and t on the surface. [`Bond::norm`] is ‖t‖/√(2ψ0).
//!
//! Mitchell's ψ0 = 25σ_y²/(8πδ⁵) takes every family for a full ball, m = 4πδ⁵/5. With its own m it is 5σ_y²/(2m_i), and
//! then the norm is the von Mises stress over σ_y at surfaces and on any mesh.

use std::f64::consts::PI;

use fissure_engine::{Bond, BondLaw, Column, Kind, Lane, Of, ParamError, Parameter, Params, Range, Surroundings};
use glam::DVec3;

use crate::moduli;

/// Elastoplastic solid that yields on the norm of the deviatoric force state.
pub struct Mitchell {
    kappa: f64,
    mu: f64,
    /// 15μ/√(2ψ0 m): from extension over √m to the norm [1].
    reach: f64,
    /// m [m⁵] of the ball, where ψ0 is that of the ball.
    ball: Option<f64>,
}

impl BondLaw<1> for Mitchell {
    const NAME: &'static str = "mitchell";
    const SUMMARY: &'static str = "elastic-plastic solid that yields like one of von Mises (Mitchell 2011)";
    const PARAMETERS: &'static [Parameter] = &[
        moduli::BULK,
        moduli::SHEAR,
        moduli::YOUNG,
        moduli::POISSON,
        Parameter {
            name: "yield_stress",
            unit: "Pa",
            kind: Kind::Number(Range::POSITIVE),
            about: "stress σ_y at which a bar in tension yields",
        },
        Parameter {
            name: "yield_surface",
            unit: "1",
            kind: Kind::Word(&["family", "ball"]),
            about: "ψ0 from each particle's own family, or from a full ball as printed: then surfaces yield early",
        },
    ];
    const MEMORY: [Column; 1] = [Column::live("plastic_extension", "m", Of::Bond)];
    const NEEDS_NORM: bool = true;
    /// λ, so that e^p = Σ tΔλ. The equivalent plastic strain is 5σ_y λ/m.
    const TALLY: Option<Column> = Some(Column::live("plastic_multiplier", "m^7/N", Of::Particle));

    fn from_params(p: &Params, at: &Surroundings) -> Result<Self, ParamError> {
        let (kappa, mu) = moduli::bulk_and_shear(p)?;
        // 2ψ0 m = 5σ_y²
        let reach = 15.0 * mu / (5.0f64.sqrt() * p.number("yield_stress"));
        let ball = 0.8 * PI * at.horizon.powi(5);
        Ok(Self { kappa, mu, reach, ball: (p.word("yield_surface") == "ball").then_some(ball) })
    }

    fn has_energy(&self) -> bool {
        true
    }

    fn influence(&self, _: DVec3, _: f64) -> f64 {
        1.0
    }

    #[inline(always)]
    fn dilatation<L: Lane>(&self, b: &Bond<L>) -> L {
        L::of(3.0) * b.inv_m * (b.weight * b.rest * b.ext)
    }

    /// (t/√(2ψ0))² V; its sum is 1 at yield.
    #[inline(always)]
    fn norm_share<L: Lane>(&self, b: &Bond<L>, memory: [L; 1]) -> L {
        let elastic = L::of(self.reach) * self.elastic_deviator(b, memory);
        let shared = b.weight * elastic * elastic * b.inv_m;
        match self.ball {
            Some(m) => shared * (L::of(m) * b.inv_m),
            None => shared,
        }
    }

    fn tally(&self, norm: f64, inv_m: f64) -> f64 {
        (norm - 1.0).max(0.0) / (15.0 * self.mu * inv_m)
    }

    /// As [`Lps`](crate::Lps), of the extension less e^p after the return.
    #[inline(always)]
    fn force<L: Lane>(&self, b: &Bond<L>, memory: [L; 1]) -> L {
        let bulk = L::of(3.0 * self.kappa - 5.0 * self.mu) * b.theta;
        b.inv_m * b.weight * (bulk * b.rest + L::of(15.0 * self.mu) * self.elastic_extension(b, memory))
    }

    #[inline(always)]
    fn flow<L: Lane>(&self, b: &Bond<L>, memory: [L; 1], _: f64) -> [L; 1] {
        [self.flowed(b, memory)]
    }

    #[inline(always)]
    fn flows<L: Lane>(&self, b: &Bond<L>, _: [L; 1]) -> L::Mask {
        b.norm.above(L::of(1.0))
    }

    /// e − e^p, after the return.
    #[inline(always)]
    fn elastic_extension<L: Lane>(&self, b: &Bond<L>, memory: [L; 1]) -> L {
        b.ext - self.flowed(b, memory)
    }

    /// What elastic unloading gives back; see [`Lps`](crate::Lps).
    #[inline(always)]
    fn bond_energy<L: Lane>(&self, b: &Bond<L>, memory: [L; 1]) -> L {
        let elastic = self.elastic_extension(b, memory);
        L::of(7.5 * self.mu) * b.inv_m * b.weight * elastic * elastic
    }

    fn theta_energy(&self, theta: f64) -> f64 {
        0.5 * (self.kappa - 5.0 / 3.0 * self.mu) * theta * theta
    }
}

impl Mitchell {
    /// e − θ|ξ|/3 − e^p, before the return.
    #[inline(always)]
    fn elastic_deviator<L: Lane>(&self, b: &Bond<L>, [plastic]: [L; 1]) -> L {
        b.ext - L::of(1.0 / 3.0) * b.theta * b.rest - plastic
    }

    /// e^p after the return: Δe^p = tΔλ is the trial deviator less itself over the norm.
    #[inline(always)]
    fn flowed<L: Lane>(&self, b: &Bond<L>, memory: [L; 1]) -> L {
        let kept = L::of(1.0) / b.norm.max(L::of(1.0));
        memory[0] + (L::of(1.0) - kept) * self.elastic_deviator(b, memory)
    }
}
