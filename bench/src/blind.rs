//! A law without its θ pass, so that the pass over forces can be timed alone.

use fissure_engine::{Bond, BondLaw, Column, Lane, ParamError, Parameter, Params, Surroundings};
use glam::DVec3;

/// `T` that is told θ = 0: the same force pass, and no pass before it.
pub struct Blind<T>(T);

impl<T: BondLaw<M>, const M: usize> BondLaw<M> for Blind<T> {
    const NAME: &'static str = T::NAME;
    const SUMMARY: &'static str = T::SUMMARY;
    const PARAMETERS: &'static [Parameter] = T::PARAMETERS;
    const MEMORY: [Column; M] = T::MEMORY;
    const NEEDS_THETA: bool = false;

    fn from_params(p: &Params, at: &Surroundings) -> Result<Self, ParamError> {
        T::from_params(p, at).map(Self)
    }
    fn needs_cos(&self) -> bool {
        self.0.needs_cos()
    }
    fn needs_influence(&self) -> bool {
        self.0.needs_influence()
    }
    fn influence(&self, xi: DVec3, horizon: f64) -> f64 {
        self.0.influence(xi, horizon)
    }
    #[inline(always)]
    fn dilatation<L: Lane>(&self, b: &Bond<L>) -> L {
        self.0.dilatation(b)
    }
    #[inline(always)]
    fn force<L: Lane>(&self, b: &Bond<L>, memory: [L; M]) -> L {
        self.0.force(b, memory)
    }
    #[inline(always)]
    fn flow<L: Lane>(&self, b: &Bond<L>, memory: [L; M], dt: f64) -> [L; M] {
        self.0.flow(b, memory, dt)
    }
    #[inline(always)]
    fn flows<L: Lane>(&self, b: &Bond<L>, memory: [L; M]) -> L::Mask {
        self.0.flows(b, memory)
    }
    #[inline(always)]
    fn elastic_extension<L: Lane>(&self, b: &Bond<L>, memory: [L; M]) -> L {
        self.0.elastic_extension(b, memory)
    }
    #[inline(always)]
    fn gauge<L: Lane>(&self, b: &Bond<L>) -> L {
        self.0.gauge(b)
    }
}
