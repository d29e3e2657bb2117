//! Laws and criteria behind a dynamic call, so that one body can hold several.
//!
//! The passes are compiled for [`AnyLaw<M>`] as for a law of its own; a call then costs one jump for eight bonds. A law is
//! generic over its [`Lane`] and a dynamic call is not, so the lane picks the side of the law that speaks it.

use glam::DVec3;

use crate::column::{Column, Of};
use crate::fracture::{Bulk, Criterion, Opening};
use crate::lane::Lane;
use crate::law::{Bond, BondLaw, Surroundings};
use crate::params::{ParamError, Parameter, Params};

/// The most numbers that a law in a body of several may remember.
pub const MOST_MEMORY: usize = 4;

/// What a law answers in one lane; the memory has as many numbers as the law remembers.
#[allow(missing_docs)] // as in `BondLaw`
pub trait LawIn<L: Lane>: Send + Sync {
    fn dilatation(&self, b: &Bond<L>) -> L;
    fn force(&self, b: &Bond<L>, memory: &[L]) -> L;
    fn flow(&self, b: &Bond<L>, memory: &mut [L], dt: f64);
    fn flows(&self, b: &Bond<L>, memory: &[L]) -> L::Mask;
    fn elastic_extension(&self, b: &Bond<L>, memory: &[L]) -> L;
    fn gauge(&self, b: &Bond<L>) -> L;
    fn bond_energy(&self, b: &Bond<L>, memory: &[L]) -> L;
    fn norm_share(&self, b: &Bond<L>, memory: &[L]) -> L;
}

/// A law in every lane.
#[allow(missing_docs)] // as in `BondLaw`
pub trait DynLaw: LawIn<f32> + LawIn<f64> + LawIn<wide::f32x8> {
    fn memory(&self) -> usize;
    fn counts_as_a_family(&self) -> bool;
    fn compensates_surface(&self) -> bool;
    fn needs_cos(&self) -> bool;
    fn needs_influence(&self) -> bool;
    fn has_energy(&self) -> bool;
    fn influence(&self, middle: DVec3, xi: DVec3, horizon: f64) -> f64;
    fn theta_energy(&self, theta: f64) -> f64;
    fn tally(&self, norm: f64, inv_m: f64) -> f64;
}

/// What a criterion answers in one lane.
#[allow(missing_docs)] // as in `Criterion`
pub trait CriterionIn<L: Lane>: Send + Sync {
    fn severity(&self, b: &Opening<L>, damage: L) -> L;
    fn suspects(&self, b: &Opening<L>) -> L::Mask;
}

/// A criterion in every lane.
pub trait DynCriterion: CriterionIn<f32> + CriterionIn<f64> + CriterionIn<wide::f32x8> {}

/// A law with the number of its memory, which a type behind a pointer no longer shows.
struct Kept<T, const M: usize>(T);

impl<L: Lane, T: BondLaw<M>, const M: usize> LawIn<L> for Kept<T, M> {
    fn dilatation(&self, b: &Bond<L>) -> L {
        self.0.dilatation(b)
    }
    fn force(&self, b: &Bond<L>, memory: &[L]) -> L {
        self.0.force(b, first(memory))
    }
    fn flow(&self, b: &Bond<L>, memory: &mut [L], dt: f64) {
        let new = self.0.flow(b, first(memory), dt);
        memory[..M].copy_from_slice(&new);
    }
    fn flows(&self, b: &Bond<L>, memory: &[L]) -> L::Mask {
        self.0.flows(b, first(memory))
    }
    fn elastic_extension(&self, b: &Bond<L>, memory: &[L]) -> L {
        self.0.elastic_extension(b, first(memory))
    }
    fn gauge(&self, b: &Bond<L>) -> L {
        self.0.gauge(b)
    }
    fn bond_energy(&self, b: &Bond<L>, memory: &[L]) -> L {
        self.0.bond_energy(b, first(memory))
    }
    fn norm_share(&self, b: &Bond<L>, memory: &[L]) -> L {
        self.0.norm_share(b, first(memory))
    }
}

fn first<L: Copy, const M: usize>(memory: &[L]) -> [L; M] {
    std::array::from_fn(|k| memory[k])
}

impl<T: BondLaw<M>, const M: usize> DynLaw for Kept<T, M> {
    fn memory(&self) -> usize {
        M
    }
    fn counts_as_a_family(&self) -> bool {
        T::NEEDS_NORM || T::TALLY.is_some()
    }
    fn compensates_surface(&self) -> bool {
        self.0.compensates_surface()
    }
    fn needs_cos(&self) -> bool {
        self.0.needs_cos()
    }
    fn needs_influence(&self) -> bool {
        self.0.needs_influence()
    }
    fn has_energy(&self) -> bool {
        self.0.has_energy()
    }
    fn influence(&self, middle: DVec3, xi: DVec3, horizon: f64) -> f64 {
        self.0.influence_at(middle, xi, horizon)
    }
    fn theta_energy(&self, theta: f64) -> f64 {
        self.0.theta_energy(theta)
    }
    fn tally(&self, norm: f64, inv_m: f64) -> f64 {
        self.0.tally(norm, inv_m)
    }
}

impl<L: Lane, C: Criterion> CriterionIn<L> for C {
    fn severity(&self, b: &Opening<L>, damage: L) -> L {
        Criterion::severity(self, b, damage)
    }
    fn suspects(&self, b: &Opening<L>) -> L::Mask {
        Criterion::suspects(self, b)
    }
}

impl<C: Criterion> DynCriterion for C {}

/// Law and criterion of one region.
pub struct Part {
    pub(crate) law: Box<dyn DynLaw>,
    pub(crate) criterion: Box<dyn DynCriterion>,
}

impl Part {
    /// Hides the types of `law` and `criterion`.
    pub fn new<T: BondLaw<M>, C: Criterion, const M: usize>(law: T, criterion: C) -> Self {
        Self { law: Box::new(Kept(law)), criterion: Box::new(criterion) }
    }
}

/// A law of any type as one that remembers `M` numbers, of which it uses the first; `FAMILY` if one of the body's laws sums over
/// its family.
pub struct AnyLaw<const M: usize, const FAMILY: bool>(pub(crate) Box<dyn DynLaw>);

/// The names of memory that belongs to another law in every region.
const SLOTS: [&str; MOST_MEMORY] = ["first", "second", "third", "fourth"];

impl<const M: usize, const FAMILY: bool> BondLaw<M> for AnyLaw<M, FAMILY> {
    const NAME: &'static str = "several";
    const SUMMARY: &'static str = "the laws of several regions";
    const PARAMETERS: &'static [Parameter] = &[];
    const MEMORY: [Column; M] = {
        let mut columns = [Column::live("", "of its law", Of::Bond); M];
        let mut k = 0;
        while k < M {
            columns[k].name = SLOTS[k];
            k += 1;
        }
        columns
    };
    const NEEDS_NORM: bool = FAMILY;
    const TALLY: Option<Column> = if FAMILY { Some(Column::live("tally", "of its law", Of::Particle)) } else { None };
    const SEVERAL: bool = true;

    fn from_params(_: &Params, _: &Surroundings) -> Result<Self, ParamError> {
        Err(ParamError::new("law", "this law is made of those of its regions".into()))
    }
    fn needs_cos(&self) -> bool {
        self.0.needs_cos()
    }
    fn needs_influence(&self) -> bool {
        self.0.needs_influence()
    }
    fn has_energy(&self) -> bool {
        self.0.has_energy()
    }
    fn influence_at(&self, middle: DVec3, xi: DVec3, horizon: f64) -> f64 {
        self.0.influence(middle, xi, horizon)
    }
    fn compensates_surface(&self) -> bool {
        self.0.compensates_surface()
    }
    fn dilatation<L: Lane>(&self, b: &Bond<L>) -> L {
        L::law(&*self.0).dilatation(b)
    }
    fn force<L: Lane>(&self, b: &Bond<L>, memory: [L; M]) -> L {
        L::law(&*self.0).force(b, &memory)
    }
    fn flow<L: Lane>(&self, b: &Bond<L>, mut memory: [L; M], dt: f64) -> [L; M] {
        L::law(&*self.0).flow(b, &mut memory, dt);
        memory
    }
    fn flows<L: Lane>(&self, b: &Bond<L>, memory: [L; M]) -> L::Mask {
        L::law(&*self.0).flows(b, &memory)
    }
    fn elastic_extension<L: Lane>(&self, b: &Bond<L>, memory: [L; M]) -> L {
        L::law(&*self.0).elastic_extension(b, &memory)
    }
    fn gauge<L: Lane>(&self, b: &Bond<L>) -> L {
        L::law(&*self.0).gauge(b)
    }
    fn bond_energy<L: Lane>(&self, b: &Bond<L>, memory: [L; M]) -> L {
        L::law(&*self.0).bond_energy(b, &memory)
    }
    fn norm_share<L: Lane>(&self, b: &Bond<L>, memory: [L; M]) -> L {
        L::law(&*self.0).norm_share(b, &memory)
    }
    fn tally(&self, norm: f64, inv_m: f64) -> f64 {
        self.0.tally(norm, inv_m)
    }
    fn theta_energy(&self, theta: f64) -> f64 {
        self.0.theta_energy(theta)
    }
}

/// A criterion of any type.
pub struct AnyCriterion(pub(crate) Box<dyn DynCriterion>);

impl Criterion for AnyCriterion {
    const NAME: &'static str = "several";
    const SUMMARY: &'static str = "the criteria of several regions";
    const PARAMETERS: &'static [Parameter] = &[];
    const NEEDS_THETA: bool = true;

    fn from_params(_: &Params, _: &Surroundings, _: &Bulk) -> Result<Self, ParamError> {
        Err(ParamError::new("criterion", "this criterion is made of those of its regions".into()))
    }
    fn severity<L: Lane>(&self, b: &Opening<L>, damage: L) -> L {
        L::criterion(&*self.0).severity(b, damage)
    }
    fn suspects<L: Lane>(&self, b: &Opening<L>) -> L::Mask {
        L::criterion(&*self.0).suspects(b)
    }
}
