//! What differs between two checkpoints, runs or scenes.
//!
//! [`checkpoints`] compares column by column, number by number: how many differ, by how much, and where. [`runs`] does so
//! for every checkpoint that both folders hold, and for their frames, so it knows the first step that differs.
//! [`scenes`] compares keys. Nothing is taken on trust: every byte of both is read, in pieces of 1 MiB, so two files of
//! any size are compared in bounded memory; a column whose bytes do not fit their checksum is an error.
//!
//! Two runs whose particles lie in another order are matched by body and particle id, their bonds by the ids of both ends.
//! Columns of the surface mesh cannot be matched then, and are said to be [left out](Verdict::Order).

mod columns;
mod order;
mod picture;
mod runs;
mod scenes;
mod side;
#[cfg(test)]
mod tests;

use std::fmt;

use fissure_engine::column::Of;
use glam::DVec3;

use crate::checkpoint::CheckpointError;
use crate::frames::FrameError;
use crate::scene::SceneError;

pub use columns::checkpoints;
pub use picture::frame;
pub use runs::{FrameDiff, RunDiff, runs};
pub use scenes::{KeyDiff, scenes};
pub use side::Side;

/// Why two things could not be compared.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the sentences say it
pub enum DiffError {
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Frame(#[from] FrameError),
    #[error("no column is called {part:?}; there are {}", known.join(", "))]
    NoColumn { part: String, known: Vec<String> },
    #[error("cannot read {}: {source}; check the path", path.display())]
    Read { path: std::path::PathBuf, source: std::io::Error },
    #[error("the picture needs particles with positions, and {} has none; give a checkpoint_<step>.fis", .0.display())]
    NoParticles(std::path::PathBuf),
}

/// What counts as a difference.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Numbers that are no farther apart than this count as the same, in the unit of their column; 0 asks for the same bits.
    pub tolerance: f64,
    /// Only columns with this in their name; empty takes all.
    pub columns: String,
}

/// Two checkpoints compared.
#[derive(Clone, Debug)]
pub struct FileDiff {
    /// Steps done, in either.
    pub step: [u64; 2],
    /// Whether particles were matched by id because their order differs.
    pub matched: bool,
    /// Every column that either has.
    pub columns: Vec<ColumnDiff>,
}

/// One column compared.
#[derive(Clone, Debug)]
pub struct ColumnDiff {
    /// Scope and name, such as `particles/position`.
    pub label: String,
    /// SI unit, `1` for pure numbers.
    pub unit: String,
    /// What came out.
    pub verdict: Verdict,
}

/// What comparing a column gave.
#[derive(Clone, Debug)]
pub enum Verdict {
    /// The same.
    Same,
    /// Some numbers differ.
    Numbers(Numbers),
    /// Only the first (0) or the second (1) has it.
    Only(usize),
    /// Type or count differ.
    Shape([String; 2]),
    /// Particles lie in another order, and these elements cannot be matched.
    Order,
}

/// How numbers differ.
#[derive(Clone, Debug)]
pub struct Numbers {
    /// Numbers compared.
    pub of: u64,
    /// Numbers that differ by more than the tolerance.
    pub differing: u64,
    /// Largest difference, infinite if one of two is NaN; of columns of bits the number of bits.
    pub largest: f64,
    /// Root of the mean square difference over all numbers.
    pub rms: f64,
    /// Where the largest is.
    pub place: Place,
}

/// Where in a body an element of a column is.
#[derive(Clone, Debug)]
pub struct Place {
    /// What the element is.
    pub of: Of,
    /// Its number in the column of the first file.
    pub element: u64,
    /// The body, if it belongs to one.
    pub body: Option<String>,
    /// Id of the particle that it belongs to, if it does.
    pub particle: Option<u32>,
    /// Position of that particle in the first file [m].
    pub position: Option<DVec3>,
}

impl Verdict {
    /// Whether this is a difference; columns that could not be matched are none.
    pub fn differs(&self) -> bool {
        !matches!(self, Self::Same | Self::Order)
    }
}

impl FileDiff {
    /// Whether anything differs.
    pub fn differs(&self) -> bool {
        self.columns.iter().any(|c| c.verdict.differs())
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.particle, &self.of) {
            (Some(id), Of::Bond | Of::Chunk) => write!(f, "a bond of particle {id}")?,
            (Some(id), _) => write!(f, "particle {id}")?,
            (None, Of::Vertex) => write!(f, "vertex {}", self.element)?,
            (None, Of::Tet) => write!(f, "tetrahedron {}", self.element)?,
            (None, _) => write!(f, "element {}", self.element)?,
        }
        if let Some(body) = &self.body {
            write!(f, " of {body}")?;
        }
        if let Some(p) = self.position {
            write!(f, " at ({:.4e}, {:.4e}, {:.4e}) m", p.x, p.y, p.z)?;
        }
        Ok(())
    }
}

impl fmt::Display for ColumnDiff {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { label, unit, verdict } = self;
        match verdict {
            Verdict::Same => write!(f, "{label}: same"),
            Verdict::Only(side) => write!(f, "{label}: only in the {} file", ["first", "second"][*side]),
            Verdict::Shape([a, b]) => write!(f, "{label}: {a} against {b}"),
            Verdict::Order => write!(f, "{label}: not compared, the order of particles differs"),
            Verdict::Numbers(Numbers { of, differing, largest, rms, place }) => write!(
                f,
                "{label}: {differing} of {of} numbers differ, largest {largest:.3e} {unit}, rms {rms:.3e}; the largest at {place}"
            ),
        }
    }
}

impl fmt::Display for FileDiff {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = self.step;
        if a != b {
            writeln!(f, "step {a} against step {b}")?;
        }
        if self.matched {
            writeln!(f, "particles are in another order; matched by id")?;
        }
        for column in self.columns.iter().filter(|c| !matches!(c.verdict, Verdict::Same)) {
            writeln!(f, "{column}")?;
        }
        let same = self.columns.iter().filter(|c| matches!(c.verdict, Verdict::Same)).count();
        write!(f, "{same} of {} columns are the same", self.columns.len())
    }
}
