//! When a bond breaks: a plug-in of its own beside the law. One criterion per file; each works beside every law.
//!
//! The law says what of a bond's extension is elastic and by which length that is measured; the pass takes the mean of
//! both sides. A criterion sees nothing else, in particular no influence: so both directions of a bond always agree, and
//! a law may correct its influence at surfaces without moving the cracks.

mod bulk;
mod release;
mod stretch;
mod tension_shear;
mod toughening;

pub use bulk::Bulk;
pub use release::EnergyRelease;
pub use stretch::CriticalStretch;
pub use tension_shear::TensionShear;

use crate::lane::Lane;
use crate::law::Surroundings;
use crate::params::{ParamError, Parameter, Params};

/// A bond as a criterion sees it: the same from both ends.
#[derive(Clone, Copy, Debug)]
pub struct Opening<L> {
    /// Rest length |ξ| [m]; positive.
    pub rest: L,
    /// Elastic extension e − e^p [m] (Eq. 18), the mean over both sides.
    pub elastic: L,
    /// The length [m] that the law measures it by; positive.
    pub gauge: L,
    /// Dilatation θ [1], the mean of both particles; 0 if neither the law nor the criterion needs it.
    pub theta: L,
}

impl<L: Lane> Opening<L> {
    /// The fracture stretch [1]: Eq. 19 before damage.
    #[inline(always)]
    pub fn stretch(&self) -> L {
        self.elastic / self.gauge
    }
}

/// When a bond breaks.
pub trait Criterion: Sized + Send + Sync + 'static {
    /// The word used in scene files.
    const NAME: &'static str;
    /// One line for `fissure materials`.
    const SUMMARY: &'static str;
    /// Every parameter of the criterion.
    const PARAMETERS: &'static [Parameter];
    /// False only for [`Unbreakable`]: the passes then skip the test.
    const BREAKS: bool = true;
    /// Whether it reads [`Opening::theta`]; then θ is summed even if the law does without.
    const NEEDS_THETA: bool = false;

    /// Reads the parameters; `bulk` is what the law beside it amounts to.
    ///
    /// # Errors
    /// What is missing or out of range.
    fn from_params(p: &Params, at: &Surroundings, bulk: &Bulk) -> Result<Self, ParamError>;

    /// How close the bond is to breaking: it breaks where this is above 1. `damage` is the larger φ of the two particles
    /// (0 intact, 1 all bonds broken). Must be monotonic in `damage`.
    fn severity<L: Lane>(&self, b: &Opening<L>, damage: L) -> L;

    /// Bonds whose severity may be above 1 at some damage, to within rounding. Asked of every bond in every step, where
    /// [`severity`](Self::severity) is asked of suspects only: a comparison without a division is worth writing.
    #[inline(always)]
    fn suspects<L: Lane>(&self, b: &Opening<L>) -> L::Mask {
        let one = L::of(1.0);
        self.severity(b, L::of(0.0)).max(self.severity(b, one)).above(one)
    }
}

/// No fracture.
pub struct Unbreakable;

impl Criterion for Unbreakable {
    const NAME: &'static str = "none";
    const SUMMARY: &'static str = "no fracture: bonds never break";
    const PARAMETERS: &'static [Parameter] = &[];
    const BREAKS: bool = false;

    fn from_params(_: &Params, _: &Surroundings, _: &Bulk) -> Result<Self, ParamError> {
        Ok(Self)
    }

    fn severity<L: Lane>(&self, _: &Opening<L>, _: L) -> L {
        L::of(0.0)
    }
}
