//! Critical stretch from the energy that a crack costs.
//!
//! A crack opens where all bonds that cross it are stretched to the limit s_c and break; the energy that these hold per
//! area is G₀. With c(ζ) the share of Σ ω|ξ|²V that a particle at depth ζδ below the plane has above it, K₊ = κ − 5μ/3, and
//! bonds that don't cross unstretched, a linear solid T = ω/m (3K₊θ|ξ| + 15μe) holds
//!
//! ```text
//! bonds:  2 · 15μ/2m ∫dz ∫_cap ω e² dV          dilatation:  2 · ½K₊ ∫dz θ(z)²,  θ(z) = 3/m ∫_cap ω|ξ|e dV
//! ```
//! on both sides of it together. In closed form G₀/(δ s_c²) is
//!
//! | ω, stretch | law | G₀/(δ s_c²) |
//! |---|---|---|
//! | δ/|ξ|, e/δ | Chen et al. | 5μ + (33/35) K₊ |
//! | δ/|ξ|, e/|ξ| | `lps`, inverse | 3μ + (26/45) K₊ |
//! | δ/|ξ|, e/δ, as written | Eq. 6 as printed | 5μ + (81/80) K₊ |
//! | 1, e/|ξ| | `lps`, one | (25/8)μ + (375/616) K₊ |
//! | 1, e/|ξ| | `pmb` | (9/5)κ (Silling and Askari 2005) |
//!
//! The textbook form 3μ + (3/4)⁴K₊ (Madenci and Oterkus 2014) is that of `lps` inverse with the square of the mean of θ for the
//! mean of its square, and θ weighted by stretch. At κ = 5μ/3 all forms of a row agree and the work of pulling a block apart
//! is G₀ whatever the path; elsewhere θ falls as bonds break one after the other, and the work depends on their order
//! (`tests/tests/fracture.rs` has numbers).
//!
//! No closed form is coded: [`Bulk::release`] integrates the law's own force, influence and stretch, so every law, also
//! one from another crate, gets its own. Plastic work comes on top of G₀.

use super::toughening::{ALPHA, READING, Toughening};
use super::{Bulk, Criterion, Opening};
use crate::lane::Lane;
use crate::law::Surroundings;
use crate::params::{Kind, ParamError, Parameter, Params, Range};

/// A bond breaks at the stretch at which the bonds that cross a unit area hold the energy G₀.
pub struct EnergyRelease(Toughening);

impl Criterion for EnergyRelease {
    const NAME: &'static str = "energy_release";
    const SUMMARY: &'static str = "a bond breaks at the stretch that a crack of a given energy per area takes";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter {
            name: "energy_release_rate",
            unit: "J/m^2",
            kind: Kind::Number(Range::POSITIVE),
            about: "energy release rate G₀ of the material: what a crack costs per area; the critical stretch follows from it",
        },
        ALPHA,
        READING,
    ];

    fn from_params(p: &Params, _: &Surroundings, bulk: &Bulk) -> Result<Self, ParamError> {
        let limit = (p.number("energy_release_rate") / bulk.release).sqrt();
        Ok(Self(Toughening::new(limit, p)))
    }

    #[inline(always)]
    fn severity<L: Lane>(&self, b: &Opening<L>, damage: L) -> L {
        self.0.severity(b.stretch(), damage)
    }

    #[inline(always)]
    fn suspects<L: Lane>(&self, b: &Opening<L>) -> L::Mask {
        b.elastic.above(L::of(self.0.least()) * b.gauge)
    }
}
