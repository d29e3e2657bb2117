//! What can be done wrong in a law that yields as a family, one mistake each, around Mitchell's.

use std::marker::PhantomData;

use fissure_engine::{Bond, BondLaw, Column, Lane, ParamError, Parameter, Params, Surroundings};
use fissure_materials::Mitchell;
use glam::DVec3;

/// A slip in the right law.
pub trait Slip: Send + Sync + 'static {
    const NAME: &'static str;
    const NEEDS_NORM: bool = true;
    fn force<L: Lane>(law: &Mitchell, b: &Bond<L>, past: [L; 1]) -> L {
        law.force(b, past)
    }
}

pub struct Family<S>(Mitchell, PhantomData<S>);

impl<S: Slip> BondLaw<1> for Family<S> {
    const NAME: &'static str = S::NAME;
    const SUMMARY: &'static str = "a law that yields as a family, with one slip";
    const PARAMETERS: &'static [Parameter] = Mitchell::PARAMETERS;
    const MEMORY: [Column; 1] = Mitchell::MEMORY;
    const NEEDS_NORM: bool = S::NEEDS_NORM;

    fn from_params(p: &Params, at: &Surroundings) -> Result<Self, ParamError> {
        Ok(Self(Mitchell::from_params(p, at)?, PhantomData))
    }
    fn influence(&self, xi: DVec3, horizon: f64) -> f64 {
        self.0.influence(xi, horizon)
    }
    fn dilatation<L: Lane>(&self, b: &Bond<L>) -> L {
        self.0.dilatation(b)
    }
    fn norm_share<L: Lane>(&self, b: &Bond<L>, past: [L; 1]) -> L {
        self.0.norm_share(b, past)
    }
    fn force<L: Lane>(&self, b: &Bond<L>, past: [L; 1]) -> L {
        S::force(&self.0, b, past)
    }
    fn flow<L: Lane>(&self, b: &Bond<L>, past: [L; 1], dt: f64) -> [L; 1] {
        self.0.flow(b, past, dt)
    }
}

/// Reads the norm and does not ask for it: never yields.
pub struct Unsummed;
impl Slip for Unsummed {
    const NAME: &'static str = "unsummed";
    const NEEDS_NORM: bool = false;
}

/// Answers with the trial force, as if the family had not yielded.
pub struct Trial;
impl Slip for Trial {
    const NAME: &'static str = "trial";
    fn force<L: Lane>(law: &Mitchell, b: &Bond<L>, past: [L; 1]) -> L {
        law.force(&Bond { norm: L::of(0.0), ..*b }, past)
    }
}
