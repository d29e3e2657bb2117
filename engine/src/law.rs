//! The physics of one bond: what a new constitutive law implements.
//!
//! A law sees one directed bond i→j from the side of i. It has no loops, threads or indices; the passes in
//! [`peridynamic`](crate::peridynamic) inline it and evaluate it twice per bond, once from each side, so that the pair
//! force (T_ij + T_ji) V_j is antisymmetric whatever the law does (Chen et al., Eqs. 2–3).

use glam::DVec3;

use crate::column::Column;
use crate::lane::Lane;
use crate::params::{ParamError, Parameter, Params};

/// One directed bond i→j, seen from i.
#[derive(Clone, Copy, Debug)]
pub struct Bond<L> {
    /// Rest length |ξ| [m], ξ = x_j − x_i; positive.
    pub rest: L,
    /// Extension e = |y| − |ξ| [m], y = y_j − y_i; at least −|ξ|.
    pub ext: L,
    /// Λ = ŷ·ξ̂, the cosine between deformed and rest bond; 1 unless the law says [`BondLaw::needs_cos`].
    pub cos: L,
    /// Influence ω (Eq. 5) times the volume V_j [m³] of the neighbour; times a factor near surfaces for a law with
    /// [`BondLaw::compensates_surface`]. What the law returns per V_j is proportional to it, and nothing else depends on it.
    pub weight: L,
    /// Influence ω [1] by itself, the same from both ends; not a number unless the law says [`BondLaw::needs_influence`].
    pub influence: L,
    /// Dilatation θ_i [1] of the particle whose side this is (Eq. 6); 0 while θ itself is being summed.
    pub theta: L,
    /// One over the weighted volume m_i = Σ ω |ξ|² V [m⁵].
    pub inv_m: L,
    /// √(Σ_j norm_share) of the particle whose side this is, for a law with [`BondLaw::NEEDS_NORM`]; 0 for all others
    /// and while it is itself being summed.
    pub norm: L,
}

impl Bond<f64> {
    /// A bond of rest length `rest` [m] that nothing has moved, with influence ω and 1/m [1/m⁵]. Its weight is ω alone, so
    /// that the law answers per volume.
    pub fn at_rest(rest: f64, influence: f64, inv_m: f64) -> Self {
        Self { rest, ext: 0.0, cos: 1.0, weight: influence, influence, theta: 0.0, inv_m, norm: 0.0 }
    }
}

/// What a law knows about its body when it is built.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings {
    /// Horizon δ [m].
    pub horizon: f64,
    /// Mean spacing of the particles [m] (mean edge length of the mesh).
    pub spacing: f64,
}

/// A constitutive law: the physics of one bond with `M` remembered numbers.
///
/// Units: `force` returns T V_j [N/m³], the force density that the neighbour causes. Chen et al. write T = A/2 (Eq. 3). V_j is
/// in [`Bond::weight`], which T is proportional to, and so are `dilatation`, `norm_share` and `bond_energy`: a pass then
/// gathers no volumes. (A law that is given ω for the weight returns T itself.)
pub trait BondLaw<const M: usize>: Sized + Send + Sync + 'static {
    /// The word used in scene files.
    const NAME: &'static str;
    /// One line for `fissure materials`.
    const SUMMARY: &'static str;
    /// Every parameter of the law; anything else in a scene is refused.
    const PARAMETERS: &'static [Parameter];
    /// The remembered numbers of a directed bond; they start at 0 and survive restarts.
    const MEMORY: [Column; M];
    /// Whether the law reads [`Bond::theta`]. A bond-based law says no and saves a pass; its `dilatation` then only serves
    /// criteria.
    const NEEDS_THETA: bool = true;
    /// Whether the law reads [`Bond::norm`], as one does that yields on the norm of a whole family. It costs a pass more.
    const NEEDS_NORM: bool = false;
    /// A number that every particle adds up and no force reads, a multiplier or a work; it survives restarts.
    const TALLY: Option<Column> = None;

    /// Whether a body has one of these per region; only [`AnyLaw`](crate::erased::AnyLaw) says so.
    #[doc(hidden)]
    const SEVERAL: bool = false;

    /// Reads the parameters.
    ///
    /// # Errors
    /// What is missing, out of range, or contradicts itself.
    fn from_params(p: &Params, at: &Surroundings) -> Result<Self, ParamError>;

    /// Whether the law reads [`Bond::cos`]. Such a law loses the co-rotating frame and with it some precision.
    fn needs_cos(&self) -> bool {
        false
    }

    /// Whether the law reads [`Bond::influence`], as one does whose yield or whose [`gauge`](Self::gauge) depends on ω. It costs
    /// 4 bytes per directed bond. An ω that depends on |ξ| alone is better computed from [`Bond::rest`].
    fn needs_influence(&self) -> bool {
        false
    }

    /// Whether [`bond_energy`](Self::bond_energy) and [`theta_energy`](Self::theta_energy) are meaningful, that is
    /// whether the force is minus the gradient of their sum.
    fn has_energy(&self) -> bool {
        false
    }

    /// Influence ω of rest bond ξ [m]; default δ/|ξ| (Eq. 5). Anisotropy is only another ω (Eq. 17).
    fn influence(&self, xi: DVec3, horizon: f64) -> f64 {
        horizon / xi.length()
    }

    /// The same for a bond whose middle is at `middle` [m], relative to the middle of the body's bounding box at rest; this
    /// is what bodies are built with. Default: the same everywhere.
    fn influence_at(&self, _middle: DVec3, xi: DVec3, horizon: f64) -> f64 {
        self.influence(xi, horizon)
    }

    /// Whether the frozen weights get pair factors that give cut-off families near surfaces back the stiffness of full
    /// ones. Then [`Bond::weight`] has that factor in it (0.5 to 1.9, 1 inside), and a law that wants ω itself computes it from
    /// [`Bond::rest`]. An ω that depends on the direction too must say [`needs_influence`](Self::needs_influence), and be a
    /// function of |ξ| times one of the direction: then a full family of that very ω is what others are compared with.
    fn compensates_surface(&self) -> bool {
        false
    }

    /// This bond's share of the dilatation: θ_i = Σ_j dilatation [1]. Default 3/m · ω|ξ|e V_j, that of the linear peridynamic
    /// solid.
    #[inline(always)]
    fn dilatation<L: Lane>(&self, b: &Bond<L>) -> L {
        L::of(3.0) * b.inv_m * (b.weight * b.rest * b.ext)
    }

    /// This bond's share of the squared norm of its family: norm_i = √(Σ_j norm_share). Of the memory before the flow, and
    /// of θ; the unit is the law's own, best such that the norm is a pure number.
    fn norm_share<L: Lane>(&self, _b: &Bond<L>, _memory: [L; M]) -> L {
        L::of(0.0)
    }

    /// What a particle adds to its [`TALLY`](Self::TALLY) in a step, from its norm before the flow and its 1/m [1/m⁵].
    fn tally(&self, _norm: f64, _inv_m: f64) -> f64 {
        0.0
    }

    /// T_ij V_j [N/m³], positive in tension. `memory` is that before the flow of this step: a plastic law returns the force
    /// on its yield surface and leaves remembering to [`flow`](Self::flow). Must not depend on anything else: evaluating
    /// twice gives the same bits.
    fn force<L: Lane>(&self, b: &Bond<L>, memory: [L; M]) -> L;

    /// The memory after this step of `dt` [s]; called once per step, at the positions that the force was evaluated at.
    /// Default: unchanged.
    fn flow<L: Lane>(&self, _b: &Bond<L>, memory: [L; M], _dt: f64) -> [L; M] {
        memory
    }

    /// Bonds whose memory [`flow`](Self::flow) may change, asked beside every `force`: a row without one is not visited for the
    /// flow. Default: all.
    #[inline(always)]
    fn flows<L: Lane>(&self, _b: &Bond<L>, _memory: [L; M]) -> L::Mask {
        L::of(1.0).above(L::of(0.0))
    }

    /// The extension that counts towards fracture [m] (e − e^p of Eq. 18); default all of it.
    fn elastic_extension<L: Lane>(&self, b: &Bond<L>, _memory: [L; M]) -> L {
        b.ext
    }

    /// The length [m] that the elastic extension is measured by: over it, it is the fracture stretch (s^ω of Eq. 19
    /// before damage). Default |ξ|, the plain stretch. Must be the same from both ends and positive.
    fn gauge<L: Lane>(&self, b: &Bond<L>) -> L {
        b.rest
    }

    /// The energy this directed bond stores, per V_i [J/m³]: w V_j.
    fn bond_energy<L: Lane>(&self, _b: &Bond<L>, _memory: [L; M]) -> L {
        L::of(0.0)
    }

    /// The energy density that dilatation stores beside the bonds [J/m³].
    fn theta_energy(&self, _theta: f64) -> f64 {
        0.0
    }
}
