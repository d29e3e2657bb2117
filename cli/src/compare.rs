//! What a run says about references: the table of errors and the plot.

use fissure_io::compare::{Comparison, Row};
use serde_json::{Value, json};

use crate::{Error, RunFolder};

/// Writes the plot, and gives the table for people and the event for programs; nothing if there is nothing to compare.
pub(crate) fn compare(comparison: &Comparison, folder: &RunFolder) -> Result<Option<(String, Value)>, Error> {
    if let Some(figure) = comparison.figure() {
        figure.draw().write_png(&folder.comparison())?;
    }
    let rows = comparison.table();
    let event = json!({ "event": "compare", "rows": rows.iter().map(told).collect::<Vec<_>>() });
    Ok((!rows.is_empty()).then(|| (table(&rows), event)))
}

/// The rows under headings, in columns.
fn table(rows: &[Row]) -> String {
    let width = rows.iter().map(|r| r.what.chars().count()).max().unwrap_or(0);
    let number = |x: Option<f64>| x.map_or_else(String::new, |x| format!("{x:.5e}"));
    let mut lines = vec![format!("{:width$}  {:>12}  {:>12}  {:>9}", "compared", "ours", "reference", "error")];
    for Row { what, ours, reference, error } in rows {
        let percent = 100.0 * error;
        // a difference has a sign, a distance has none
        let percent = match ours {
            Some(_) => format!("{percent:+.2} %"),
            None if percent < 0.01 => format!("{percent:.0e} %"),
            None => format!("{percent:.2} %"),
        };
        lines.push(format!("{what:width$}  {:>12}  {:>12}  {percent:>9}", number(*ours), number(*reference)));
    }
    lines.join("\n")
}

fn told(row: &Row) -> Value {
    json!({ "what": row.what, "ours": row.ours, "reference": row.reference, "error": row.error })
}
