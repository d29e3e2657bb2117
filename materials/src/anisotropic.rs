//! Anisotropy by direction (Chen et al., Sec. 4.3): ω = δ/|Gξ| (Eq. 17) around another law.
//!
//! The default formulation normalises by m_i = Σ ω|ξ|²V, so G and any multiple of it are the same solid and a pure
//! dilatation is answered with κ; G only moves stiffness from one direction to another. As written, G = gI divides all
//! stiffness by g. Which bonds break moves with it: s^ω = s^e/ω (Eq. 19) grows with |Gξ|.

use fissure_engine::{Bond, BondLaw, Column, Kind, Lane, ParamError, Parameter, Params, Surroundings};
use glam::{DMat3, DVec3};

use crate::{Isotropic, Plastic};

/// What the law adds to the table of the one that it is around.
const OWN: [Parameter; 4] = [
    Parameter {
        name: "matrix",
        unit: "1",
        kind: Kind::Matrix,
        about: "anisotropy matrix G of Eq. 17: bonds along its long directions are weak",
    },
    Parameter {
        name: "field",
        unit: "1",
        kind: Kind::Word(&["uniform", "cylindrical", "spherical"]),
        about: "directions of G: x, y, z; or outwards, around and along `axis`; or outwards, around and towards the pole",
    },
    Parameter {
        name: "axis",
        unit: "1",
        kind: Kind::Vector([0.0, 1.0, 0.0]),
        about: "direction of the axis of the field; its length does not matter",
    },
    Parameter {
        name: "centre",
        unit: "m",
        kind: Kind::Vector([0.0; 3]),
        about: "a point of the axis, or the centre, from the middle of the body's bounding box at rest",
    },
];

/// The table of `base` with [`OWN`] at its end.
const fn and_own<const N: usize>(base: &[Parameter]) -> [Parameter; N] {
    let mut table = [OWN[0]; N];
    let mut k = 0;
    while k < N {
        table[k] = if k < base.len() { base[k] } else { OWN[k - base.len()] };
        k += 1;
    }
    table
}

/// A law that can stand an influence that depends on direction, and what it is called then.
pub trait Base<const M: usize>: BondLaw<M> {
    /// The word used in scene files.
    const NAME: &'static str;
    /// One line of help.
    const SUMMARY: &'static str;
    /// The parameters of the law, and [`OWN`].
    const PARAMETERS: &'static [Parameter];
}

impl Base<0> for Isotropic {
    const NAME: &'static str = "anisotropic";
    const SUMMARY: &'static str = "elastic solid that is stiffer in some directions (Chen et al., Sec. 4.3)";
    const PARAMETERS: &'static [Parameter] =
        &and_own::<{ <Self as BondLaw<0>>::PARAMETERS.len() + OWN.len() }>(<Self as BondLaw<0>>::PARAMETERS);
}

impl Base<1> for Plastic<true> {
    const NAME: &'static str = "anisotropic_plastic";
    const SUMMARY: &'static str = "elastoplastic solid that is stiffer in some directions (Chen et al., Sec. 4.3)";
    const PARAMETERS: &'static [Parameter] =
        &and_own::<{ <Self as BondLaw<1>>::PARAMETERS.len() + OWN.len() }>(<Self as BondLaw<1>>::PARAMETERS);
}

/// Law `T` with direction-dependent influence.
pub struct Anisotropic<T> {
    base: T,
    g: DMat3,
    field: Field,
}

/// How the directions of G turn from place to place.
enum Field {
    Uniform,
    /// About the axis through the point: the rings of a tree.
    Cylindrical(DVec3, DVec3),
    /// About the point, with the poles along the axis: the layers of an onion.
    Spherical(DVec3, DVec3),
}

impl Field {
    /// The directions at `x`, by columns. On the axis and at the centre, where there are none, some that are right angled.
    fn at(&self, x: DVec3) -> DMat3 {
        let (axis, outwards) = match *self {
            Self::Uniform => return DMat3::IDENTITY,
            Self::Cylindrical(axis, centre) => (axis, (x - centre).reject_from_normalized(axis)),
            Self::Spherical(axis, centre) => (axis, x - centre),
        };
        let outwards = outwards.try_normalize().unwrap_or_else(|| axis.any_orthonormal_vector());
        let around = axis.cross(outwards).try_normalize().unwrap_or_else(|| outwards.any_orthonormal_vector());
        DMat3::from_cols(outwards, around, outwards.cross(around))
    }
}

impl<T: Base<M>, const M: usize> BondLaw<M> for Anisotropic<T> {
    const NAME: &'static str = <T as Base<M>>::NAME;
    const SUMMARY: &'static str = <T as Base<M>>::SUMMARY;
    const PARAMETERS: &'static [Parameter] = <T as Base<M>>::PARAMETERS;
    const MEMORY: [Column; M] = T::MEMORY;
    const NEEDS_THETA: bool = T::NEEDS_THETA;
    const NEEDS_NORM: bool = T::NEEDS_NORM;
    const TALLY: Option<Column> = T::TALLY;

    fn from_params(p: &Params, at: &Surroundings) -> Result<Self, ParamError> {
        let g = DMat3::from_cols_array_2d(&p.matrix("matrix")).transpose();
        let size = g.to_cols_array().iter().fold(0.0f64, |m, x| m.max(x.abs()));
        // scaled before the determinant, which could overflow
        if size == 0.0 || (g * (1.0 / size)).determinant().abs() < 1e-9 {
            let message =
                "`matrix` is singular: bonds along one direction would have infinite influence; give an invertible G";
            return Err(ParamError::new("matrix", message.into()));
        }
        let (axis, centre) = (DVec3::from_array(p.vector("axis")), DVec3::from_array(p.vector("centre")));
        let Some(axis) = axis.try_normalize() else {
            return Err(ParamError::new("axis", "`axis` has no direction; give one that is not 0".into()));
        };
        let field = match p.word("field") {
            "cylindrical" => Field::Cylindrical(axis, centre),
            "spherical" => Field::Spherical(axis, centre),
            _ => Field::Uniform,
        };
        Ok(Self { base: T::from_params(p, at)?, g, field })
    }

    fn needs_cos(&self) -> bool {
        self.base.needs_cos()
    }

    fn needs_influence(&self) -> bool {
        true
    }

    fn has_energy(&self) -> bool {
        self.base.has_energy()
    }

    fn compensates_surface(&self) -> bool {
        self.base.compensates_surface()
    }

    fn influence(&self, xi: DVec3, horizon: f64) -> f64 {
        horizon / (self.g * xi).length()
    }

    fn influence_at(&self, middle: DVec3, xi: DVec3, horizon: f64) -> f64 {
        self.influence(self.field.at(middle).transpose() * xi, horizon)
    }

    #[inline(always)]
    fn dilatation<L: Lane>(&self, b: &Bond<L>) -> L {
        self.base.dilatation(b)
    }

    #[inline(always)]
    fn norm_share<L: Lane>(&self, b: &Bond<L>, memory: [L; M]) -> L {
        self.base.norm_share(b, memory)
    }

    fn tally(&self, norm: f64, inv_m: f64) -> f64 {
        self.base.tally(norm, inv_m)
    }

    #[inline(always)]
    fn force<L: Lane>(&self, b: &Bond<L>, memory: [L; M]) -> L {
        self.base.force(b, memory)
    }

    #[inline(always)]
    fn flow<L: Lane>(&self, b: &Bond<L>, memory: [L; M], dt: f64) -> [L; M] {
        self.base.flow(b, memory, dt)
    }

    #[inline(always)]
    fn flows<L: Lane>(&self, b: &Bond<L>, memory: [L; M]) -> L::Mask {
        self.base.flows(b, memory)
    }

    #[inline(always)]
    fn elastic_extension<L: Lane>(&self, b: &Bond<L>, memory: [L; M]) -> L {
        self.base.elastic_extension(b, memory)
    }

    /// ω|ξ| with the ω of Eq. 17.
    #[inline(always)]
    fn gauge<L: Lane>(&self, b: &Bond<L>) -> L {
        b.influence * b.rest
    }

    #[inline(always)]
    fn bond_energy<L: Lane>(&self, b: &Bond<L>, memory: [L; M]) -> L {
        self.base.bond_energy(b, memory)
    }

    fn theta_energy(&self, theta: f64) -> f64 {
        self.base.theta_energy(theta)
    }
}
