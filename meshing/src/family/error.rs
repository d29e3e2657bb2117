//! What can be wrong with points, horizons and meshes.

use glam::DVec3;
use thiserror::Error;

/// Why families, or the clip for them, could not be built.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FamilyError {
    /// A coordinate is infinite or not a number.
    #[error("particle {index} has the position {position}; mend the mesh so that every coordinate is a finite number")]
    NotFinite {
        /// The particle.
        index: usize,
        /// Where it is said to be [m].
        position: DVec3,
    },
    /// The horizon is zero, negative or not a number.
    #[error("the horizon is {0} m; give a positive, finite length, for example 1.4 times the mean edge length")]
    BadHorizon(f64),
    /// Some particles have no other within the horizon.
    #[error(
        "{count} of {particles} particles have no neighbour within the horizon of {horizon:.4e} m, the first is particle \
         {first}; the nearest particle is up to {spacing:.4e} m away, so use a horizon well above that"
    )]
    Isolated {
        /// How many.
        count: usize,
        /// Of how many.
        particles: usize,
        /// The first of them.
        first: usize,
        /// The horizon [m].
        horizon: f64,
        /// Largest distance of an isolated particle to its nearest neighbour [m]; infinite for a single particle.
        spacing: f64,
    },
    /// Row offsets are 32-bit numbers.
    #[error(
        "{0} directed bonds or more are too many, the limit is 4294967295; use a smaller horizon or fewer particles"
    )]
    TooMany(usize),
    /// Points and tetrahedra differ in number.
    #[error(
        "{points} particles but {tets} tetrahedra to clip by; give one particle per tetrahedron, at its barycentre"
    )]
    OtherMesh {
        /// Number of particles.
        points: usize,
        /// Number of tetrahedra.
        tets: usize,
    },
    /// A face of more than two tetrahedra.
    #[error(
        "more than two tetrahedra share the face of vertices {0:?}; mend the mesh so that every face has at most two"
    )]
    CrowdedFace([u32; 3]),
    /// A tetrahedron or cut names a vertex that does not exist.
    #[error("{what} {index} names vertex {vertex}, but there are only {vertices} vertices; mend the mesh")]
    NoVertex {
        /// "tetrahedron" or "cut triangle".
        what: &'static str,
        /// Which one.
        index: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// A corner of a pre-cut is infinite or not a number.
    #[error("vertex {index} of the pre-cut has the position {position}; every coordinate must be a finite number")]
    CutNotFinite {
        /// The vertex of the cut mesh.
        index: usize,
        /// Where it is said to be [m].
        position: DVec3,
    },
    /// The k-d tree refused the points.
    #[error("the k-d tree over the particles could not be built: {0}")]
    Tree(String),
}
