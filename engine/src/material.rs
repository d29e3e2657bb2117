//! What the step asks of a body: given the particles, how do velocities change, what broke, what must be remembered?
//!
//! One dynamic call per body and phase. A bond law gets all of this from [`Peridynamic`](crate::Peridynamic); the
//! shape-matching lattice answers for itself, with α(g − x)/h as its velocity change (Ohta et al., Eqs. 3–4).

use glam::DVec3;
use thiserror::Error;

use crate::adapt::{Present, Renewal};
use crate::bonds::{Bonds, Families};
use crate::column::Visitor;
use crate::lattice::{CellError, Cells, LatticePose, NodeCounts};
use crate::particles::BodyParticles;

/// A broken neighbour link between two particles of a body, counted from its first, or between two finest cells of a
/// lattice; `i < j`. Meshing cuts here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // the two ends
pub struct Link {
    pub i: u32,
    pub j: u32,
}

/// What a fresh body is built from.
#[derive(Debug)]
pub struct Geometry<'a> {
    /// The particles, already in place.
    pub particles: BodyParticles<'a>,
    /// What lies about each of them.
    pub neighbourhood: Neighbourhood,
}

/// How the particles of a body without bonds meet.
#[derive(Clone, Copy, Debug)]
pub struct Touching<'a> {
    /// Connected piece of each particle; those of one piece do not meet. Empty while the body is whole.
    pub piece: &'a [u32],
    /// Whether each is at a surface.
    pub exposed: &'a [bool],
    /// Changes whenever pieces do.
    pub version: u64,
}

/// What lies about each particle of a fresh body: what its material [wants](crate::registry::Wants).
#[derive(Clone, Debug, PartialEq)]
pub enum Neighbourhood {
    /// Who is in whose horizon, for bonds.
    Families(Families),
    /// The cell of each, for a lattice.
    Cells(Cells),
}

impl From<Families> for Neighbourhood {
    fn from(families: Families) -> Self {
        Self::Families(families)
    }
}

impl From<Cells> for Neighbourhood {
    fn from(cells: Cells) -> Self {
        Self::Cells(cells)
    }
}

/// Why a body cannot be built.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BuildError {
    /// A volume or mass that is not positive.
    #[error("particle {particle} has {what} = {value}; it must be above 0")]
    NotPositive {
        /// Its index.
        particle: usize,
        /// Volume or mass.
        what: &'static str,
        /// The value.
        value: f64,
    },
    /// Families where cells are needed, or the other way round.
    #[error("this material is built from {wanted}, which the body was not given")]
    Unfit {
        /// What it wants.
        wanted: &'static str,
    },
    /// Cells that are no lattice.
    #[error(transparent)]
    Cells(#[from] CellError),
    /// More particles than a body of bonds can have.
    #[error("{particles} particles are more than the {most} that one body can have; make several bodies of it")]
    TooMany {
        /// How many.
        particles: usize,
        /// At most.
        most: usize,
    },
}

/// A body's material: the outer plug-in interface, one dynamic call per body and phase.
pub trait Material: Send + Sync {
    /// Prepares a fresh body. A restored one is not built: its columns are filled in by [`visit`](Self::visit).
    ///
    /// # Errors
    /// Geometry that the material cannot work with.
    fn build(&mut self, geometry: Geometry<'_>) -> Result<(), BuildError>;

    /// Largest stable time step [s]; infinite for position-based bodies.
    fn stable_dt(&self, p: &BodyParticles<'_>) -> f64;

    /// What resists the displacement of each particle in its rest shape [N/m], or more; a step of dt is stable where
    /// 2 m/dt² is above it. Empty for position-based bodies, which cannot be [relaxed](crate::Relax).
    fn stiffness(&self, _p: &BodyParticles<'_>) -> Vec<f64> {
        Vec::new()
    }

    /// Makes what follows from restored columns, before a step; nothing in a body that runs.
    fn wake(&mut self) {}

    /// Adds to `dv` [m/s] what deformation does in `dt` [s]: h·f/ρ for forces. Changes no state: evaluating twice gives
    /// the same bits.
    fn respond(&mut self, p: &BodyParticles<'_>, dt: f64, dv: &mut [DVec3]);

    /// Lets the memory flow over `dt` [s] (plasticity); once per step, after [`respond`](Self::respond) at the same positions.
    fn flow(&mut self, _dt: f64) {}

    /// Breaks what [`respond`](Self::respond) found to be over the limit: updates `damage` [1] and appends every broken
    /// link to `cuts`, in order of `i`.
    fn fracture(&mut self, _damage: &mut [f32], _cuts: &mut Vec<Link>) {}

    /// Whether [`adapt`](Self::adapt) may ever replace particles.
    fn adapts(&self) -> bool {
        false
    }

    /// May replace the body's particles at the end of a step, keeping mass and momentum: fills `next` and returns true, or
    /// leaves all as it is.
    fn adapt(&mut self, _now: &Present<'_>, _next: &mut Renewal) -> bool {
        false
    }

    /// Whether velocity changes lead to goal positions and are stable in any step, rather than come from forces. They are
    /// then not proportional to the step.
    fn position_based(&self) -> bool {
        false
    }

    /// Elastic energy [J], if the law has one.
    fn energy(&mut self, _p: &BodyParticles<'_>) -> Option<f64> {
        None
    }

    /// Force densities [N/m³] in all-f64 arithmetic, to judge the fast path by.
    fn reference_forces(&self, _p: &BodyParticles<'_>) -> Option<Vec<DVec3>> {
        None
    }

    /// Bulk modulus [Pa] of the undamaged material at each particle, from which contact takes its stiffness. Empty for
    /// position-based bodies: their contacts are as stiff as the time step allows.
    fn bulk_moduli(&self) -> Vec<f64> {
        Vec::new()
    }

    /// The bonds, if the material has any. Particles without an intact bond meet as strangers; those of one body without bonds
    /// meet as [`touching`](Self::touching) says.
    fn bonds(&self) -> Option<&Bonds> {
        None
    }

    /// Of a body without bonds: which of its particles can touch anything. Without it all can, but not each other.
    fn touching(&self) -> Option<Touching<'_>> {
        None
    }

    /// What carries the surface of a lattice, at the positions of `p`; `None` for a material without cells. Changes no state.
    fn lattice<'a>(&'a mut self, _p: &BodyParticles<'a>) -> Option<LatticePose<'a>> {
        None
    }

    /// Of each finest cell of a lattice the particle that carries it, counted from the body's first; empty for a material without
    /// cells.
    fn carrier(&self) -> &[u32] {
        &[]
    }

    /// How far a lattice is resolved now; `None` for a material without cells.
    fn nodes(&self) -> Option<NodeCounts> {
        None
    }

    /// Whether restored columns fit each other and so many particles; a file with right checksums may still lie.
    fn consistent(&self, particles: usize) -> bool {
        self.bonds().is_none_or(|b| b.consistent(particles))
    }

    /// Shows every array that must survive a restart, always in the same order.
    fn visit(&mut self, scope: &str, v: &mut Visitor<'_>);
}
