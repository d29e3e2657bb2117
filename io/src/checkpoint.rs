//! Checkpoints: a run's columns in files that map straight into memory.
//!
//! The frozen columns (rest positions, CSR, mesh) go once per run into `frozen.fis`; each `checkpoint_<step>.fis`
//! holds the live ones. Both have one format. Opening costs the same for any file size, a column is a slice of the
//! map, and a restart maps the frozen part shared and the live part copy-on-write. A file is complete or absent: it
//! is written under a temporary name, synced, renamed, and the folder is synced.
//!
//! What is here: [`write()`], [`Opened`] (open, verify, read, restore), [`Store`] (the files of a run folder),
//! [`Snapshot`] (for writing in the background), and [`summary`] for people.
//!
//! ```no_run
//! # fn main() -> Result<(), fissure_io::checkpoint::CheckpointError> {
//! let file = fissure_io::checkpoint::Opened::open("run/checkpoint_00000100.fis")?;
//! let positions = file.column::<glam::DVec3>("vase", "position")?;
//! println!("step {}: {} particles", file.about().step, positions.len());
//! # Ok(())
//! # }
//! ```
//!
//! # Format, version 1
//! Numbers are little-endian. Offsets count bytes from the start of the file. The parts follow each other without
//! gaps, in this order; every part but the last is filled up with zero bytes to a multiple of 64.
//!
//! ```text
//! preamble                64 bytes
//! section 0               its column's numbers, raw
//! section 1 …             in the order of the table
//! header                  rkyv archive; ends where the file ends
//! ```
//!
//! **Preamble.** Its form and checksum stay the same in all versions, so that every version can tell the others.
//!
//! ```text
//!  0   8  magic: 89 46 49 53 0D 0A 1A 0A ("\x89FIS\r\n\x1a\n": text-mode copies show at once)
//!  8   4  u32 format version: 1
//! 12   4  u32 kind: 1 frozen, 2 live
//! 16   8  u64 length of the whole file
//! 24   8  u64 offset of the header
//! 32   8  u64 length of the header, at most 64 MiB
//! 40   8  u64 XXH3-64 (seed 0) of the header's bytes: the fingerprint of the file
//! 48   8  zero
//! 56   8  u64 XXH3-64 of bytes 0 to 55
//! ```
//!
//! **Header.** An archive of rkyv 0.8 with 64-bit pointers. Strings and tables come first, the root is its last 88
//! bytes:
//!
//! ```text
//!  0   8  u64 step
//!  8   8  f64 time [s]
//! 16   8  u64 live files: fingerprint of the frozen file that belongs to it; frozen files: 0
//! 24  16  string: the scene's text
//! 40  16  string: the program and its version
//! 56  16  table of notes, 32 bytes each: key string, value string
//! 72  16  table of sections, 88 bytes each
//! ```
//!
//! **Section**, one row of the table:
//!
//! ```text
//!  0  16  string: scope, such as vase/bonds
//! 16  16  string: column name
//! 32  16  string: SI unit, 1 for pure numbers
//! 48   8  u64 count of elements
//! 56   8  u64 offset, a multiple of 64
//! 64   8  u64 length in bytes = count × width × size of the type, without the filling zeros
//! 72   8  u64 XXH3-64 of these bytes
//! 80   4  u32 width: numbers per element, at least 1
//! 84   1  type: 1 u8, 2 u32, 3 u64, 4 f32, 5 f64
//! 85   1  one element per: 1 particle, 2 row, 3 bond, 4 chunk, 5 vertex, 6 tet, 7 thing
//! 86   1  life: 1 frozen, 2 live; the same as the file's kind
//! 87   1  zero
//! ```
//!
//! A *table* is an i64 offset from its own position to its first row, then a u64 number of rows. A *string* of up
//! to 16 bytes lies in place, ended by FF if shorter. A longer one is a u64 and an i64 offset from the string's own
//! position to its UTF-8 bytes; the u64 is the length with the bits `10` put in as bits 7 and 6, so that its first
//! byte is no UTF-8.
//!
//! Every byte is under a checksum or must be zero, so [`Opened::verify`] finds any flipped bit. rkyv's own check
//! only makes the archive safe to read; it does not notice changed data.
//!
//! Same data gives the same bytes: nothing of the clock or of the machine is in a file.
//!
//! # What was tried
//! Arrays inside the archive are aligned for their element only and double the memory while writing, so columns are
//! raw sections. The header lies behind the sections and not before them: one pass over the columns then writes and
//! hashes each, with the sizes not known ahead.
//!
//! # Caution
//! A mapped file must not be cut short by others while it is open: the system ends a program that reads beyond the
//! end. Fissure itself never writes into a finished file, it only replaces or removes it, which a map survives.

mod error;
mod export;
mod format;
mod open;
mod restore;
mod snapshot;
mod store;
mod summary;
#[cfg(test)]
mod tests;
mod write;

pub use error::CheckpointError;
pub use export::{ExportFormat, export};
pub(crate) use format::type_name;
pub use format::{About, Section, VERSION};
pub use open::Opened;
pub use snapshot::Snapshot;
pub use store::{FROZEN, Latest, Store, checkpoint_name};
pub use summary::{ColumnSummary, Range, Summary, summary};
pub use write::{Written, write};

use fissure_engine::column::Visitor;

#[cfg(target_endian = "big")]
compile_error!("checkpoints map little-endian files as they are; this target is big-endian");

/// Something whose columns can be saved and restored.
pub trait Columns {
    /// Shows every column, always in the same order.
    fn visit(&mut self, v: &mut Visitor<'_>);
}

/// How messages name a column: its scope, if any, and its name.
pub(crate) fn label(scope: &str, name: &str) -> String {
    if scope.is_empty() { name.to_owned() } else { format!("{scope}/{name}") }
}
