//! What a run measures at each frame: `series.csv` in its folder, a row per frame under a line of names.
//!
//! | column | is |
//! |---|---|
//! | `frame`, `step`, `time` | number of the frame, steps done, simulated time \[s\] |
//! | `kinetic`, `elastic`, `gravity` | energies \[J\]; `elastic` of the laws that have one |
//! | `particles`, `bonds`, `broken` | particles, or nodes of lattices; bonds, and how many of them are broken |
//! | `fragments` | connected pieces of all bodies |
//! | `s_respond`, `s_contact`, … | wall time since the row before in each phase of the step, then in surfaces, files and checkpoints \[s\] |
//!
//! All but the wall times are the same bits in every run of a scene, interrupted or not. Readers look columns up by name.

mod figure;

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::Path;

use crate::atomic::write_atomically;

/// One row, as names and numbers; every row of a run has the same names.
pub type Row = [(&'static str, f64)];

/// Puts `row` at the end of the file at `path`, which is made with a line of names if it is not there.
///
/// # Errors
/// A file that cannot be written.
pub fn append(path: &Path, row: &Row) -> io::Result<()> {
    let mut file = OpenOptions::new().create(true).append(true).open(path)?;
    let joined = |cells: &mut dyn Iterator<Item = String>| cells.collect::<Vec<_>>().join(",") + "\n";
    let mut text = String::new();
    if file.metadata()?.len() == 0 {
        text += &joined(&mut row.iter().map(|(name, _)| name.to_string()));
    }
    text += &joined(&mut row.iter().map(|(_, x)| cell(*x)));
    file.write_all(text.as_bytes()) // one call: another reader sees whole rows
}

/// A number as it stands in the table: the shortest that is read as the same bits.
fn cell(x: f64) -> String {
    match x {
        x if !x.is_finite() => String::new(),
        x if x.fract() == 0.0 && x.abs() < 1e15 => format!("{x}"),
        x => format!("{x:?}"),
    }
}

/// Drops the rows after `step` from the file at `path`, and what a kill left of the last: the run goes on from there.
///
/// # Errors
/// A file that cannot be read or written; one that is not there is none.
pub fn rewind(path: &Path, step: u64) -> io::Result<()> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(e) => return Err(e),
    };
    let mut lines = text.split_inclusive('\n').filter(|line| line.ends_with('\n'));
    let mut kept = lines.next().unwrap_or_default().to_string();
    let place = kept.trim_end().split(',').position(|name| name == "step");
    let early = |line: &&str| {
        let of = place.and_then(|k| line.trim_end().split(',').nth(k)?.parse::<u64>().ok());
        of.is_some_and(|of| of <= step)
    };
    kept.extend(lines.take_while(early));
    if kept == text { Ok(()) } else { write_atomically(path, kept.as_bytes()) }
}

/// A table that was read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Names of the columns.
    pub names: Vec<String>,
    /// The numbers of each column, as many in each; NaN where a cell is empty or no number.
    pub columns: Vec<Vec<f64>>,
}

impl Series {
    /// Reads the file at `path`. A last row that is not whole is left out: the run may be writing it.
    ///
    /// # Errors
    /// A file that cannot be read, or whose rows have other numbers of cells than its names.
    pub fn read(path: &Path) -> io::Result<Self> {
        let text = std::fs::read_to_string(path)?;
        let whole = &text[..text.rfind('\n').map_or(0, |k| k + 1)];
        let mut reader = csv::Reader::from_reader(whole.as_bytes());
        let names: Vec<String> = reader.headers()?.iter().map(str::to_string).collect();
        let mut columns = vec![Vec::new(); names.len()];
        for record in reader.records() {
            let record = record?;
            let cells = record.iter().map(|cell| cell.trim().parse().unwrap_or(f64::NAN));
            columns.iter_mut().zip(cells).for_each(|(column, cell): (&mut Vec<f64>, f64)| column.push(cell));
        }
        Ok(Self { names, columns })
    }

    /// The table as CSV.
    pub fn to_csv(&self) -> String {
        let rows = self.columns.first().map_or(0, Vec::len);
        let row = |k: usize| self.columns.iter().map(|c| cell(c[k])).collect::<Vec<_>>().join(",") + "\n";
        self.names.join(",") + "\n" + &(0..rows).map(row).collect::<String>()
    }

    /// The column called `name`.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.names.iter().position(|n| n == name).map(|k| &self.columns[k][..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(step: u64) -> [(&'static str, f64); 3] {
        let elastic = if step == 20 { f64::NAN } else { 0.1 + step as f64 };
        [("frame", (step / 10) as f64), ("step", step as f64), ("elastic", elastic)]
    }

    #[test]
    fn rows_after_a_step_and_broken_ones_are_dropped_and_written_again_as_they_were() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("series.csv");
        rewind(&path, 3).unwrap();
        assert!(!path.exists(), "there was nothing to drop");
        for step in [0, 10, 20, 30] {
            append(&path, &row(step)).unwrap();
        }
        let whole = std::fs::read_to_string(&path).unwrap();
        assert_eq!(whole, "frame,step,elastic\n0,0,0.1\n1,10,10.1\n2,20,\n3,30,30.1\n");
        for kill in 0..whole.len() {
            // killed somewhere while it wrote, with a checkpoint of step 14
            std::fs::write(&path, &whole[..kill]).unwrap();
            rewind(&path, 14).unwrap();
            let kept = std::fs::read_to_string(&path).unwrap();
            assert!(whole.starts_with(&kept) && !kept.contains("20"), "{kill}: {kept}");
            let rows = kept.lines().count().saturating_sub(1);
            (rows as u64..4).for_each(|k| append(&path, &row(10 * k)).unwrap());
            assert_eq!(std::fs::read_to_string(&path).unwrap(), whole, "killed at byte {kill}");
        }
        let series = Series::read(&path).unwrap();
        assert_eq!(series.column("step").unwrap(), [0.0, 10.0, 20.0, 30.0]);
        assert!(series.column("elastic").unwrap()[2].is_nan() && series.column("broken").is_none());
        assert_eq!(series.to_csv(), whole);
        std::fs::write(&path, &whole[..whole.len() - 2]).unwrap();
        assert_eq!(Series::read(&path).unwrap().column("frame").unwrap(), [0.0, 1.0, 2.0]);
        std::fs::write(&path, "a,b\n1\n").unwrap();
        assert!(Series::read(&path).is_err());
    }
}
