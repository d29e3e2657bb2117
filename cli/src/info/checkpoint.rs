//! What is in a checkpoint.

use std::path::Path;
use std::process::ExitCode;

use fissure_engine::column::Life;
use fissure_io::checkpoint::{ColumnSummary, Opened, Range, summary};
use fissure_io::scene::Scene;
use serde_json::{Map, Value, json};

use super::{Told, called};
use crate::Error;
use crate::say::say;

/// What it holds, and whether every checksum matches.
pub(super) fn told(path: &Path) -> Result<(Told, bool), Error> {
    let file = summary(path)?;
    let about = &file.about;
    let title = Scene::parse(&about.scene, Path::new("scene.toml"), &[]).map(|scene| called(&scene).to_owned()).ok();
    let mut words: Vec<String> = file.to_string().lines().map(str::to_owned).collect();
    words.push(match &title {
        Some(title) => format!("  scene: {title}; --scene prints it"),
        None => format!(
            "  scene: {} lines that this program does not read; --scene prints them",
            about.scene.lines().count()
        ),
    });
    let notes: Map<String, Value> = about.notes.iter().map(|(k, v)| (k.clone(), json!(v))).collect();
    let value = json!({
        "kind": "checkpoint",
        "file": file.path.display().to_string(),
        "columns_are": if file.life == Life::Live { "live" } else { "frozen" },
        "bytes": file.bytes,
        "fingerprint": format!("{:016x}", file.fingerprint),
        "belongs_to": format!("{:016x}", file.frozen),
        "step": about.step, "time": about.time, "program": about.program,
        "title": title, "scene": about.scene, "notes": notes,
        "intact": file.intact(),
        "columns": file.columns.iter().map(column).collect::<Vec<_>>(),
    });
    Ok((Told { words, value }, file.intact()))
}

fn column(column: &ColumnSummary) -> Value {
    let section = &column.section;
    // JSON has no infinity
    let number = |x: f64| if x.is_finite() { json!(x) } else { json!(x.to_string()) };
    let (min, max) = match column.range {
        Range::None => (Value::Null, Value::Null),
        Range::Whole(low, high) => (json!(low), json!(high)),
        Range::Float(low, high) => (number(low), number(high)),
    };
    json!({
        "column": section.label(), "unit": section.unit, "type": section.dtype.name(), "width": section.width,
        "count": section.count, "min": min, "max": max, "nans": column.nans, "intact": column.intact,
    })
}

/// Prints the scene that made it, as it was.
pub(super) fn scene(path: &Path) -> Result<ExitCode, Error> {
    let file = Opened::open(path)?;
    say!("{}", file.about().scene.trim_end());
    Ok(ExitCode::SUCCESS)
}
