//! Elastic and perfectly plastic (Chen et al., Eqs. 11–16): each directed bond remembers its plastic extension e^p.
//!
//! A bond yields where its elastic deviatoric extension ε = e^d − e^p exceeds s_y δ/ω, which is s_y|ξ| for isotropic ω:
//! the constant force of Eq. 14 is one stretch, s_y = πδ⁴√(2Ψ0)/(30μ). The default returns exactly onto the yield surface;
//! the stiffness there is 4ωb, so Δe^p is the excess of ε. `as_written` divides by 2b (Eq. 15) and lands at
//! A_c + (1 − 2ω)(A − A_c), and takes δΛθ/4 for the dilatational part (Eq. 9), which yields under pure dilatation.
//!
//! Bonds yield one by one, those along the principal axes first: in shear at τ = 2μs_y, in tension at σ = 3μs_y. When
//! all have yielded, it is (10/π) μs_y and 5.77 μs_y. `yield_stress` means the first in tension.

use fissure_engine::{Bond, BondLaw, Column, Kind, Lane, Of, ParamError, Parameter, Params, Surroundings};

use crate::{Isotropic, moduli, yielding};

/// Elastoplastic solid; `DIRECTIONAL` if ω depends on direction too, and the yield stretch with it.
pub struct Plastic<const DIRECTIONAL: bool = false> {
    elastic: Isotropic,
    delta: f64,
    /// s_y, the elastic deviatoric stretch at yield [1].
    yield_stretch: f64,
    /// γ/|ξ| of Eq. 16 [1].
    cap: f64,
}

impl<const DIRECTIONAL: bool> BondLaw<1> for Plastic<DIRECTIONAL> {
    const NAME: &'static str = "plastic";
    const SUMMARY: &'static str = "elastic and perfectly plastic solid (Chen et al., Sec. 4.2)";
    const PARAMETERS: &'static [Parameter] = &[
        moduli::BULK,
        moduli::SHEAR,
        moduli::YOUNG,
        moduli::POISSON,
        Parameter {
            name: "formulation",
            unit: "1",
            kind: Kind::Word(&["default", "as_written"]),
            about: "objective with a consistent return, or Eqs. 3-16 as the paper prints them",
        },
        yielding::STRESS,
        yielding::STRETCH,
        yielding::PSI0,
        yielding::CAP,
    ];
    const MEMORY: [Column; 1] = [Column::live("plastic_extension", "m", Of::Bond)];

    fn from_params(p: &Params, at: &Surroundings) -> Result<Self, ParamError> {
        let elastic = Isotropic::from_params(p, at)?;
        let (_, mu) = moduli::bulk_and_shear(p)?;
        let yield_stretch = yielding::stretch(p, mu, at.horizon, elastic.as_written())?;
        let cap = p.optional(yielding::CAP.name).unwrap_or(f64::INFINITY);
        Ok(Self { elastic, delta: at.horizon, yield_stretch, cap })
    }

    fn needs_cos(&self) -> bool {
        self.elastic.needs_cos()
    }

    fn needs_influence(&self) -> bool {
        self.elastic.as_written() || DIRECTIONAL
    }

    fn compensates_surface(&self) -> bool {
        self.elastic.compensates_surface()
    }

    fn has_energy(&self) -> bool {
        self.elastic.has_energy()
    }

    #[inline(always)]
    fn dilatation<L: Lane>(&self, b: &Bond<L>) -> L {
        self.elastic.dilatation(b)
    }

    /// Eq. 12 with the e^p after the flow: taking e^p off the extension takes it off its deviatoric part.
    #[inline(always)]
    fn force<L: Lane>(&self, b: &Bond<L>, memory: [L; 1]) -> L {
        self.elastic.force(&Bond { ext: b.ext - self.flowed(b, memory), ..*b }, [])
    }

    #[inline(always)]
    fn flow<L: Lane>(&self, b: &Bond<L>, memory: [L; 1], _: f64) -> [L; 1] {
        [self.flowed(b, memory)]
    }

    #[inline(always)]
    fn flows<L: Lane>(&self, b: &Bond<L>, memory: [L; 1]) -> L::Mask {
        let flowed = self.flowed(b, memory);
        flowed.above(memory[0]) | flowed.below(memory[0])
    }

    /// e − e^p (Eq. 18). By default e^p after the flow, so that it is the same before and after remembering.
    #[inline(always)]
    fn elastic_extension<L: Lane>(&self, b: &Bond<L>, memory: [L; 1]) -> L {
        b.ext - if self.elastic.as_written() { memory[0] } else { self.flowed(b, memory) }
    }

    #[inline(always)]
    fn gauge<L: Lane>(&self, b: &Bond<L>) -> L {
        self.elastic.gauge(b)
    }

    /// What elastic unloading gives back; its gradient at given e^p is the force.
    #[inline(always)]
    fn bond_energy<L: Lane>(&self, b: &Bond<L>, memory: [L; 1]) -> L {
        self.elastic.bond_energy(&Bond { ext: b.ext - self.flowed(b, memory), ..*b }, [])
    }

    fn theta_energy(&self, theta: f64) -> f64 {
        self.elastic.theta_energy(theta)
    }
}

impl<const DIRECTIONAL: bool> Plastic<DIRECTIONAL> {
    /// e^p after the return (Eqs. 13–16).
    #[inline(always)]
    fn flowed<L: Lane>(&self, b: &Bond<L>, [plastic]: [L; 1]) -> L {
        let dilatation = if self.elastic.as_written() {
            L::of(self.delta / 4.0) * b.cos * b.theta // Eq. 9
        } else {
            L::of(1.0 / 3.0) * b.theta * b.rest
        };
        let elastic = b.ext - dilatation - plastic;
        // s_y δ/ω; for ω = δ/|ξ| without a division, and without the surface factor in `weight`
        let limit = if DIRECTIONAL {
            L::of(self.yield_stretch * self.delta) / b.influence
        } else {
            L::of(self.yield_stretch) * b.rest
        };
        let excess = elastic - elastic.clamp(-limit, limit);
        // (A − A_c)/(4ωb), or /(2b) as Eq. 15 is printed
        let step = if self.elastic.as_written() { L::of(2.0) * b.influence * excess } else { excess };
        let cap = L::of(self.cap) * b.rest;
        (plastic + step).clamp(-cap, cap)
    }
}
