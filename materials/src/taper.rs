//! Volume taper at the horizon, as LAMMPS does it: the last shell of a lattice counts only as far as it lies inside.
//!
//! A neighbour's volume and the influence of its bond enter every sum as a product, so the taper is written as another
//! influence.

use fissure_engine::{Kind, Parameter, Params, Range};

/// The lattice constant lc that volumes are tapered with.
pub const TAPER: Parameter = Parameter {
    name: "taper",
    unit: "m",
    kind: Kind::OptionalNumber(Range::POSITIVE),
    about: "lattice constant of the particles; bonds within half of it of the horizon count less, as in LAMMPS",
};

/// Share of a neighbour's volume that counts: (δ + lc/2 − r)/lc where |r − δ| ≤ lc/2, else 1.
#[derive(Clone, Copy)]
pub(crate) struct Taper(Option<f64>);

impl Taper {
    pub fn from_params(p: &Params) -> Self {
        Self(p.optional(TAPER.name))
    }

    /// The share at distance `r` [m] with horizon `delta` [m].
    pub fn share(self, r: f64, delta: f64) -> f64 {
        match self.0 {
            Some(lattice) if (r - delta).abs() <= lattice / 2.0 => (delta + lattice / 2.0 - r) / lattice,
            _ => 1.0,
        }
    }
}
