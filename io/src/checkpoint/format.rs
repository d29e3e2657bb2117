//! The bytes of a checkpoint: preamble, header archive, codes, and the check that a table fits its file.

use std::path::Path;

use fissure_engine::column::{DType, Life, Of};
use xxhash_rust::xxh3::xxh3_64;

use super::{CheckpointError, label};

/// The format version written, and the newest one read.
pub const VERSION: u32 = 1;
pub(crate) const MAGIC: [u8; 8] = *b"\x89FIS\r\n\x1a\n";
/// Sections and header start at multiples of this: a cache line, enough for any SIMD load.
pub(crate) const ALIGN: u64 = 64;
pub(crate) const PREAMBLE: u64 = 64;
/// Largest header: far above any real one, small enough to read without a thought.
pub(crate) const HEADER_LIMIT: u64 = 64 << 20;

/// What a checkpoint says about itself, beside its columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct About {
    /// Steps done.
    pub step: u64,
    /// Simulated time in seconds.
    pub time: f64,
    /// The scene file's text.
    pub scene: String,
    /// The program and its version.
    pub program: String,
    /// Anything else worth keeping, as key and value, in order.
    pub notes: Vec<(String, String)>,
}

/// One column in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Path such as `vase/bonds`.
    pub scope: String,
    /// Column name, unique in its scope.
    pub name: String,
    /// SI unit, `1` for pure numbers.
    pub unit: String,
    /// What an element belongs to.
    pub of: Of,
    /// Whether it changes during a run.
    pub life: Life,
    /// Number type.
    pub dtype: DType,
    /// Numbers per element.
    pub width: usize,
    /// Number of elements.
    pub count: usize,
    /// XXH3-64 of the numbers' bytes.
    pub checksum: u64,
    pub(crate) offset: usize,
    pub(crate) length: usize,
}

impl Section {
    /// Scope and name, as messages show them.
    pub fn label(&self) -> String {
        label(&self.scope, &self.name)
    }

    /// Length of the numbers in bytes.
    pub fn len(&self) -> usize {
        self.length
    }

    /// Whether it has no elements.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }
}

/// The first 64 bytes.
pub(crate) struct Preamble {
    pub version: u32,
    pub kind: u32,
    pub file_length: u64,
    pub header_offset: u64,
    pub header_length: u64,
    pub header_checksum: u64,
}

impl Preamble {
    pub fn to_bytes(&self) -> [u8; PREAMBLE as usize] {
        let mut bytes = [0; PREAMBLE as usize];
        bytes[..8].copy_from_slice(&MAGIC);
        bytes[8..12].copy_from_slice(&self.version.to_le_bytes());
        bytes[12..16].copy_from_slice(&self.kind.to_le_bytes());
        for (at, value) in
            [(16, self.file_length), (24, self.header_offset), (32, self.header_length), (40, self.header_checksum)]
        {
            bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
        }
        let checksum = xxh3_64(&bytes[..56]);
        bytes[56..].copy_from_slice(&checksum.to_le_bytes());
        bytes
    }

    /// Reads and checks the start of a file that is `file_length` bytes long.
    pub fn read(path: &Path, start: &[u8], file_length: u64) -> Result<Self, CheckpointError> {
        let seen = start.len().min(MAGIC.len());
        if start[..seen] != MAGIC[..seen] {
            return Err(CheckpointError::Foreign { path: path.to_owned() });
        }
        let Some(bytes) = start.first_chunk::<{ PREAMBLE as usize }>() else {
            return Err(CheckpointError::Truncated { path: path.to_owned(), found: file_length, expected: PREAMBLE });
        };
        let half = |at: usize| u32::from_le_bytes(std::array::from_fn(|i| bytes[at + i]));
        let word = |at: usize| u64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]));
        if word(56) != xxh3_64(&bytes[..56]) {
            return Err(CheckpointError::damaged(path, "the checksum of its first 64 bytes does not match"));
        }
        let preamble = Self {
            version: half(8),
            kind: half(12),
            file_length: word(16),
            header_offset: word(24),
            header_length: word(32),
            header_checksum: word(40),
        };
        if preamble.version > VERSION {
            return Err(CheckpointError::FutureVersion {
                path: path.to_owned(),
                found: preamble.version,
                known: VERSION,
            });
        }
        preamble.check(path, file_length)?;
        Ok(preamble)
    }

    fn check(&self, path: &Path, file_length: u64) -> Result<(), CheckpointError> {
        if file_length < self.file_length {
            let path = path.to_owned();
            return Err(CheckpointError::Truncated { path, found: file_length, expected: self.file_length });
        }
        let what = if file_length > self.file_length {
            format!("{} bytes follow its end", file_length - self.file_length)
        } else if self.version == 0 {
            "it says format version 0, which never was".to_owned()
        } else if life_of(self.kind).is_none() {
            format!("it says kind {}, and there are only 1 (frozen) and 2 (live)", self.kind)
        } else if self.header_length > HEADER_LIMIT {
            format!("it says its header has {} bytes, more than any header has", self.header_length)
        } else if self.header_offset < PREAMBLE
            || !self.header_offset.is_multiple_of(ALIGN)
            || self.header_offset.checked_add(self.header_length) != Some(file_length)
        {
            format!("it says its header lies at byte {}, which does not fit its length", self.header_offset)
        } else {
            return Ok(());
        };
        Err(CheckpointError::damaged(path, what))
    }
}

/// The root of the archive. Field order is file order.
#[derive(rkyv::Archive, rkyv::Serialize, rkyv::Deserialize)]
pub(crate) struct Header {
    pub step: u64,
    pub time: f64,
    pub frozen: u64,
    pub scene: String,
    pub program: String,
    pub notes: Vec<Note>,
    pub sections: Vec<Row>,
}

/// A key with its value.
#[derive(rkyv::Archive, rkyv::Serialize, rkyv::Deserialize)]
pub(crate) struct Note {
    pub key: String,
    pub value: String,
}

/// One row of the table of sections.
#[derive(Clone, rkyv::Archive, rkyv::Serialize, rkyv::Deserialize)]
pub(crate) struct Row {
    pub scope: String,
    pub name: String,
    pub unit: String,
    pub count: u64,
    pub offset: u64,
    pub length: u64,
    pub checksum: u64,
    pub width: u32,
    pub dtype: u8,
    pub of: u8,
    pub life: u8,
    pub zero: u8,
}

/// Turns the table into sections, if it fits a file whose header starts at `header_offset`: every section right
/// behind the one before it, so none overlap and none lie outside.
pub(crate) fn sections(
    path: &Path,
    rows: Vec<Row>,
    kind: u32,
    header_offset: u64,
) -> Result<Vec<Section>, CheckpointError> {
    let mut next = PREAMBLE;
    let mut sections = Vec::with_capacity(rows.len());
    for (i, row) in rows.into_iter().enumerate() {
        let bad = |what: String| CheckpointError::damaged(path, format!("row {i} of its table {what}"));
        if row.name.is_empty() || [&row.scope, &row.name, &row.unit].iter().any(|s| s.contains(char::is_control)) {
            return Err(bad("has no readable name".into()));
        }
        let name = label(&row.scope, &row.name);
        let (Some(dtype), Some(of), Some(life)) = (dtype_of(row.dtype), of_of(row.of), life_of(row.life.into())) else {
            return Err(bad(format!("(`{name}`) has unknown codes {}, {}, {}", row.dtype, row.of, row.life)));
        };
        if u32::from(row.life) != kind || row.width == 0 || row.zero != 0 {
            return Err(bad(format!("(`{name}`) does not fit the kind of the file or has width 0")));
        }
        let length = row.count.checked_mul(u64::from(row.width)).and_then(|n| n.checked_mul(dtype.size() as u64));
        if length != Some(row.length) {
            return Err(bad(format!("(`{name}`) says {} bytes for {} × {} {dtype}", row.length, row.count, row.width)));
        }
        let end = row.offset.checked_add(row.length).and_then(|end| end.checked_next_multiple_of(ALIGN));
        match end {
            Some(end) if row.offset == next && end <= header_offset => next = end,
            _ => return Err(bad(format!("(`{name}`) says byte {} where {next} is its place", row.offset))),
        }
        let too_large = |_| bad(format!("(`{name}`) is too large for this machine"));
        sections.push(Section {
            of,
            life,
            dtype,
            width: row.width as usize,
            count: usize::try_from(row.count).map_err(too_large)?,
            checksum: row.checksum,
            offset: usize::try_from(row.offset).map_err(too_large)?,
            length: usize::try_from(row.length).map_err(too_large)?,
            scope: row.scope,
            name: row.name,
            unit: row.unit,
        });
    }
    if next != header_offset {
        return Err(CheckpointError::damaged(path, format!("bytes {next} to {header_offset} belong to no column")));
    }
    Ok(sections)
}

const DTYPES: [DType; 5] = [DType::U8, DType::U32, DType::U64, DType::F32, DType::F64];
const OFS: [Of; 7] = [Of::Particle, Of::Row, Of::Bond, Of::Chunk, Of::Vertex, Of::Tet, Of::Thing];
const LIVES: [Life; 2] = [Life::Frozen, Life::Live];

fn decode<T: Copy>(table: &[T], code: u32) -> Option<T> {
    table.get(usize::try_from(code).ok()?.checked_sub(1)?).copied()
}

fn dtype_of(code: u8) -> Option<DType> {
    decode(&DTYPES, code.into())
}

fn of_of(code: u8) -> Option<Of> {
    decode(&OFS, code.into())
}

pub(crate) fn life_of(code: u32) -> Option<Life> {
    decode(&LIVES, code)
}

pub(crate) fn dtype_code(dtype: DType) -> u8 {
    match dtype {
        DType::U8 => 1,
        DType::U32 => 2,
        DType::U64 => 3,
        DType::F32 => 4,
        DType::F64 => 5,
    }
}

pub(crate) fn of_code(of: Of) -> u8 {
    match of {
        Of::Particle => 1,
        Of::Row => 2,
        Of::Bond => 3,
        Of::Chunk => 4,
        Of::Vertex => 5,
        Of::Tet => 6,
        Of::Thing => 7,
    }
}

pub(crate) fn life_code(life: Life) -> u8 {
    match life {
        Life::Frozen => 1,
        Life::Live => 2,
    }
}

/// How messages call a file's kind.
pub(crate) fn life_name(life: Life) -> &'static str {
    match life {
        Life::Frozen => "frozen",
        Life::Live => "live",
    }
}

/// How messages show a column's type: `f64 × 3 [m/s]`.
pub(crate) fn type_name(dtype: DType, width: usize, unit: &str) -> String {
    if width == 1 { format!("{dtype} [{unit}]") } else { format!("{dtype} × {width} [{unit}]") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_read_back() {
        assert_eq!(DTYPES.map(|d| dtype_of(dtype_code(d)).unwrap()), DTYPES);
        assert_eq!(OFS.map(|o| of_of(of_code(o)).unwrap()), OFS);
        assert_eq!(LIVES.map(|l| life_of(life_code(l).into()).unwrap()), LIVES);
        assert!(dtype_of(0).is_none() && dtype_of(6).is_none() && life_of(u32::MAX).is_none());
    }
}
