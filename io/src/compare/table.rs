//! Numbers in CSV files with a line of headings.

use std::path::Path;

use glam::DVec3;

/// Columns of finite numbers.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbers {
    /// The path, for messages.
    pub file: String,
    headings: Vec<String>,
    /// All as long as there are headings.
    pub rows: Vec<Vec<f64>>,
}

impl Numbers {
    /// Reads the file at `path`. Headings are in lower case afterwards.
    pub(super) fn read(path: &Path) -> Result<Self, String> {
        let file = path.display().to_string();
        let fail = |error: csv::Error| format!("{file} cannot be read ({error}); give a CSV file with headings");
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(path).map_err(fail)?;
        let headings = reader.headers().map_err(fail)?.iter().map(str::to_lowercase).collect();
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(fail)?;
            let number = |text: &str| {
                text.parse::<f64>().map_err(|_| {
                    let line = record.position().map_or(0, csv::Position::line);
                    format!("{file}:{line}: {text:?} is no number; remove it or the column")
                })
            };
            rows.push(record.iter().map(number).collect::<Result<Vec<f64>, String>>()?);
        }
        Ok(Self { file, headings, rows })
    }

    /// Refuses a table without rows or without one of the columns.
    pub(super) fn need(&self, columns: &[&str]) -> Result<(), String> {
        if let Some(column) = columns.iter().find(|c| !self.headings.iter().any(|h| h == *c)) {
            let there = self.headings.join(", ");
            return Err(format!("{} has no column `{column}`, only {there}; rename one of them", self.file));
        }
        if self.rows.is_empty() {
            return Err(format!("{} has no rows below its headings", self.file));
        }
        Ok(())
    }

    /// Three columns of a row; NaN for those that are not there.
    pub(super) fn vector(&self, row: usize, columns: [&str; 3]) -> DVec3 {
        let at = |column| self.headings.iter().position(|h| h == column);
        DVec3::from_array(columns.map(|column| at(column).map_or(f64::NAN, |k| self.rows[row][k])))
    }
}

/// Headings and rows as text.
pub(super) fn write<R: AsRef<[f64]>>(headings: &[&str], rows: impl Iterator<Item = R>) -> String {
    let mut text = headings.join(",") + "\n";
    for row in rows {
        let numbers: Vec<String> = row.as_ref().iter().map(|x| format!("{x:.8e}")).collect();
        text += &(numbers.join(",") + "\n");
    }
    text
}
