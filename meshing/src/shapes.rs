//! Generated solids, as closed triangle meshes wound outwards, and regular grids for tests and benches.
//!
//! Lengths are in metres and y is up. The same parameters give the same bits. Every surface passes
//! [`surface::check`](crate::surface::check).

mod boxes;
mod lattice;
mod revolution;
mod round;
mod tets;
mod vase;

pub use boxes::{beam, cuboid, sheet, wall};
pub use lattice::cubic_lattice;
pub use revolution::revolution;
pub use round::{ball, cylinder};
pub use tets::tet_box;
pub use vase::{vase, vase_profile};

use thiserror::Error;

/// A parameter of a shape that makes no solid.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ShapeError {
    /// A number outside its range.
    #[error("{shape}: {name} = {value} is outside its range; give {wanted}")]
    OutOfRange {
        /// The shape asked for.
        shape: &'static str,
        /// The parameter.
        name: &'static str,
        /// What was given.
        value: f64,
        /// The valid range in words.
        wanted: &'static str,
    },
    /// A profile point has a negative or unusable coordinate.
    #[error(
        "revolution: profile point {point} = ({r}, {y}) is not in the half plane r ≥ 0; mirror or move the profile so \
         that it stays on one side of the axis"
    )]
    AcrossAxis {
        /// Index of the point, from 0.
        point: usize,
        /// Its distance from the axis [m].
        r: f64,
        /// Its height [m].
        y: f64,
    },
    /// The profile meets the axis in a single point, where the solid would be pinched.
    #[error(
        "revolution: profile point {point} touches the axis alone, which pinches the solid there; let the profile run \
         along the axis for a while, or keep it off"
    )]
    Pinched {
        /// Index of the point, from 0.
        point: usize,
    },
    /// Two sides of the profile meet.
    #[error(
        "revolution: side {first} of the profile (from its point {first} to the next) meets side {second}; list the \
         points once around the outline, without crossings or repeated points"
    )]
    Crossed {
        /// Index of the first point of one side.
        first: usize,
        /// Index of the first point of the other.
        second: usize,
    },
    /// The profile encloses no area.
    #[error("revolution: the profile encloses no area; give at least three points that are not on one line")]
    Flat,
    /// The wall of a vase does not fit into its neck or foot.
    #[error("vase: a wall of {wall} m does not fit a height of {height} m; give 0.01 to 0.06 of the height")]
    WallDoesNotFit {
        /// Wall thickness [m].
        wall: f64,
        /// Height [m].
        height: f64,
    },
}

/// A length that must be positive, finite and between 1e-9 and 1e9 m.
fn length(shape: &'static str, name: &'static str, value: f64) -> Result<f64, ShapeError> {
    let wanted = "a length between 1e-9 and 1e9 m";
    if (1e-9..=1e9).contains(&value) { Ok(value) } else { Err(ShapeError::OutOfRange { shape, name, value, wanted }) }
}

#[cfg(test)]
mod tests;
