//! What a column means: its name, unit, owner and life. Declared once, beside the array.
//!
//! Saving, restoring, diffing, hashing, exporting and plotting all walk [`visit`](crate::World::visit) and follow
//! from these declarations; nothing lists columns a second time.

use std::fmt;

use crate::buffer::AnyBuffer;

/// Number type of a column's elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // the names say it
pub enum DType {
    U8,
    U32,
    U64,
    F32,
    F64,
}

impl DType {
    /// All types with their names in files.
    pub const ALL: [(DType, &'static str); 5] =
        [(Self::U8, "u8"), (Self::U32, "u32"), (Self::U64, "u64"), (Self::F32, "f32"), (Self::F64, "f64")];

    /// The name in files and messages.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(d, _)| *d == self).expect("ALL is complete").1
    }

    /// Bytes per number.
    pub fn size(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U32 | Self::F32 => 4,
            Self::U64 | Self::F64 => 8,
        }
    }
}

impl fmt::Display for DType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What one element of a column belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// One element per particle.
    Particle,
    /// One element per row of bonds plus one: the CSR offsets.
    Row,
    /// One element per directed bond slot.
    Bond,
    /// One element per chunk of eight bond slots.
    Chunk,
    /// One element per vertex of the embedded mesh.
    Vertex,
    /// One element per tetrahedron of the embedded mesh.
    Tet,
    /// Anything else: single values, tables.
    Thing,
}

/// Whether a column changes during a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Life {
    /// Written once when the run is built; saved once per run and mapped shared on restart.
    Frozen,
    /// Changes as the run goes on; in every checkpoint.
    Live,
}

/// The declaration of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name, `snake_case`, unique within its scope.
    pub name: &'static str,
    /// SI unit, `1` for pure numbers.
    pub unit: &'static str,
    /// What an element belongs to.
    pub of: Of,
    /// Whether it changes.
    pub life: Life,
    /// Whether checkpoints of earlier versions lack it, and are restored as if it were empty.
    pub late: bool,
}

impl Column {
    /// A column that changes during the run.
    pub const fn live(name: &'static str, unit: &'static str, of: Of) -> Self {
        Self { name, unit, of, life: Life::Live, late: false }
    }

    /// A column that never changes after the run is built.
    pub const fn frozen(name: &'static str, unit: &'static str, of: Of) -> Self {
        Self { name, unit, of, life: Life::Frozen, late: false }
    }

    /// The same for a column that came to a thing later: where a checkpoint has none, the thing keeps what it has, which
    /// must be a state that is right without it.
    pub const fn late(self) -> Self {
        Self { late: true, ..self }
    }
}

/// Sees every column of a thing, always in the same order. The first argument is the scope, a path such as
/// `vase/bonds`; together with the column's name it is unique in a world.
pub type Visitor<'v> = dyn FnMut(&str, &Column, &mut dyn AnyBuffer) + 'v;
