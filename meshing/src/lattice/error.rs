//! Why a surface does not become a lattice.

use glam::DVec3;
use thiserror::Error;

use crate::surface::{counted, place, short};

/// What keeps a surface from being filled with cells.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LatticeError {
    /// No triangles.
    #[error("the surface has no triangles: nothing can be filled")]
    Empty,
    /// Edges with one triangle, or triangles wound against each other.
    #[error(
        "the surface is not closed: {} without a partner on the other side, the first near {}; a lattice fills closed surfaces",
        counted(*edges, "edge"), place(*at)
    )]
    Open {
        /// How many edges.
        edges: usize,
        /// Middle of the first [m].
        at: DVec3,
    },
    /// The surface encloses less than nothing.
    #[error(
        "the surface encloses a volume of {volume:.3e} m³: its triangles are wound inwards or it is flat; turn them round"
    )]
    InsideOut {
        /// Its signed volume [m³].
        volume: f64,
    },
    /// One cell would hold all of it.
    #[error(
        "a lattice of {} m cells is coarser than the body, which is {} m long: it would have {}; try {} m",
        short(*size), short(*extent), counted(*cells, "cell"), short(*advice)
    )]
    Coarse {
        /// Edge of the cells [m].
        size: f64,
        /// Longest side of the body [m].
        extent: f64,
        /// How many there would be.
        cells: usize,
        /// An edge that gives about a thousand cells [m].
        advice: f64,
    },
    /// More than fits.
    #[error(
        "a lattice of {} m cells would have about {cells:.1e} of them and need about {needed:.0} MiB, more than the {given} MiB \
         given; try {} m, or give more `memory`",
        short(*size), short(*advice)
    )]
    Memory {
        /// Edge of the cells [m].
        size: f64,
        /// Estimated number.
        cells: f64,
        /// Estimated memory [MiB].
        needed: f64,
        /// What may be used [MiB].
        given: u64,
        /// An edge that fits [m].
        advice: f64,
    },
    /// Noise that would fold cells.
    #[error(
        "noise of {amplitude} cells at a scale of {scale} cells folds the faces between them; give an amplitude of at most {} or \
         a larger scale",
        short(*most)
    )]
    Folded {
        /// Amplitude in cells.
        amplitude: f64,
        /// Scale in cells.
        scale: f64,
        /// The largest amplitude for this scale.
        most: f64,
    },
    /// A number out of its range.
    #[error("{what} = {value} is out of its range; it must be above 0")]
    Number {
        /// Which.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// Inside and outside cannot be told.
    #[error("the surface meets itself near {}, so that inside and outside cannot be told there; part or unite the pieces", place(*at))]
    Tangled {
        /// Where [m].
        at: DVec3,
    },
}
