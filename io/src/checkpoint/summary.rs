//! What is in a checkpoint, for people: `fissure info`.

use std::fmt;
use std::path::{Path, PathBuf};

use bytemuck::Pod;
use fissure_engine::column::{DType, Life};
use xxhash_rust::xxh3::Xxh3;

use super::format::{About, Section, life_name, type_name};
use super::{CheckpointError, Opened};

/// Smallest and largest number of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// No numbers, or only NaN.
    None,
    /// Of a column of whole numbers.
    Whole(u64, u64),
    /// Of a column of floats, NaN left out.
    Float(f64, f64),
}

/// One column in a summary.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnSummary {
    /// Name, unit, type and count.
    pub section: Section,
    /// Smallest and largest number, over all components.
    pub range: Range,
    /// Numbers that are NaN.
    pub nans: usize,
    /// Whether the checksum matches.
    pub intact: bool,
}

/// A checkpoint file at a glance.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// The file.
    pub path: PathBuf,
    /// Its length in bytes.
    pub bytes: usize,
    /// Which columns it holds.
    pub life: Life,
    /// Its fingerprint.
    pub fingerprint: u64,
    /// The fingerprint of its frozen file, 0 in a frozen file.
    pub frozen: u64,
    /// Step, time, scene, program.
    pub about: About,
    /// Its columns, in file order.
    pub columns: Vec<ColumnSummary>,
}

/// Reads a checkpoint file once and sums it up. A column whose checksum does not match is reported in the summary.
///
/// # Errors
/// If the file does not open (see [`Opened::open`]) or cannot be read.
pub fn summary(path: impl AsRef<Path>) -> Result<Summary, CheckpointError> {
    let file = Opened::open(path)?;
    let mut chunk = Vec::new();
    let mut columns = Vec::with_capacity(file.sections().len());
    for section in file.sections() {
        let mut hash = Xxh3::new();
        let (mut range, mut nans) = (Range::None, 0);
        file.stream(section, &mut chunk, &mut |bytes| {
            hash.update(bytes);
            widen(&mut range, &mut nans, section.dtype, bytes);
        })?;
        let intact = file.check_sum(section, hash.digest()).is_ok();
        columns.push(ColumnSummary { section: section.clone(), range, nans, intact });
    }
    Ok(Summary {
        path: file.path().to_owned(),
        bytes: file.file_length(),
        life: file.life(),
        fingerprint: file.fingerprint(),
        frozen: file.frozen(),
        about: file.about().clone(),
        columns,
    })
}

/// Takes more numbers into a range.
fn widen(range: &mut Range, nans: &mut usize, dtype: DType, bytes: &[u8]) {
    match dtype {
        DType::U8 => whole::<u8>(range, bytes),
        DType::U32 => whole::<u32>(range, bytes),
        DType::U64 => whole::<u64>(range, bytes),
        DType::F32 => float::<f32>(range, nans, bytes),
        DType::F64 => float::<f64>(range, nans, bytes),
    }
}

fn whole<T: Pod + Into<u64>>(range: &mut Range, bytes: &[u8]) {
    for &value in bytemuck::cast_slice::<u8, T>(bytes) {
        let value = value.into();
        *range = match *range {
            Range::Whole(low, high) => Range::Whole(low.min(value), high.max(value)),
            _ => Range::Whole(value, value),
        };
    }
}

fn float<T: Pod + Into<f64>>(range: &mut Range, nans: &mut usize, bytes: &[u8]) {
    for &value in bytemuck::cast_slice::<u8, T>(bytes) {
        let value: f64 = value.into();
        if value.is_nan() {
            *nans += 1;
            continue;
        }
        *range = match *range {
            Range::Float(low, high) => Range::Float(low.min(value), high.max(value)),
            _ => Range::Float(value, value),
        };
    }
}

impl Summary {
    /// Whether every checksum matches.
    pub fn intact(&self) -> bool {
        self.columns.iter().all(|column| column.intact)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("-"),
            Self::Whole(low, high) => write!(f, "{low} … {high}"),
            Self::Float(low, high) => write!(f, "{low:.6e} … {high:.6e}"),
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (about, columns) = (&self.about, self.columns.len());
        writeln!(f, "{}", self.path.display())?;
        writeln!(
            f,
            "  {} columns: {columns}, {} bytes, fingerprint {:016x}",
            life_name(self.life),
            self.bytes,
            self.fingerprint
        )?;
        if self.life == Life::Live {
            writeln!(f, "  belongs to frozen columns {:016x}", self.frozen)?;
        }
        writeln!(f, "  step {}, time {} s, written by {:?}", about.step, about.time, about.program)?;
        for (key, value) in &about.notes {
            writeln!(f, "  {}: {}", key.escape_debug(), value.escape_debug())?;
        }
        let labels: Vec<String> = self.columns.iter().map(|column| column.section.label()).collect();
        let widest = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0);
        for (label, column) in labels.iter().zip(&self.columns) {
            let section = &column.section;
            let kind = type_name(section.dtype, section.width, &section.unit);
            write!(f, "  {label:<widest$}  {kind:<16}  {:>10}  {}", section.count, column.range)?;
            if column.nans > 0 {
                write!(f, ", {} NaN", column.nans)?;
            }
            f.write_str(if column.intact { "\n" } else { "  DAMAGED\n" })?;
        }
        match self.columns.iter().filter(|column| !column.intact).count() {
            0 => writeln!(f, "  the checksums of all columns match"),
            damaged => writeln!(f, "  {damaged} of {columns} columns do not match their checksums"),
        }
    }
}
