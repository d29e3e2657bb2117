//! `fissure diff`: what differs between two runs, checkpoints or scenes.

use std::path::Path;
use std::process::ExitCode;

use fissure_io::checkpoint::checkpoint_name;
use fissure_io::diff::{
    ColumnDiff, FileDiff, KeyDiff, Options, RunDiff, Side, Verdict, checkpoints, frame, runs, scenes,
};
use fissure_io::picture::{ColourMode, View};
use serde_json::{Value, json};

use crate::args::DiffArgs;
use crate::render::picture;
use crate::say::say;
use crate::{Error, RunFolder};

/// What can be compared with its like.
#[derive(PartialEq)]
enum Kind {
    Run,
    Checkpoint,
    Scene,
}

fn kind(path: &Path) -> Result<Kind, Error> {
    if path.is_dir() {
        RunFolder::open(path)?;
        return Ok(Kind::Run);
    }
    // a file that is not there is named by whoever reads it
    Ok(if path.extension().is_some_and(|e| e == "toml") { Kind::Scene } else { Kind::Checkpoint })
}

pub(crate) fn command(args: &DiffArgs) -> Result<ExitCode, Error> {
    let (a, b) = (args.a.as_path(), args.b.as_path());
    let of = kind(a)?;
    if of != kind(b)? {
        return Err(Error::Usage(format!(
            "{} and {} are not of one kind; give two run folders, two checkpoints (.fis) or two scenes (.toml)",
            a.display(),
            b.display()
        )));
    }
    if args.tolerance.is_nan() || args.tolerance < 0.0 {
        return Err(Error::Usage(format!("--tolerance is {}; give a number that is not negative", args.tolerance)));
    }
    let options = Options { tolerance: args.tolerance, columns: args.columns.clone() };
    let differs = match of {
        Kind::Scene => {
            if args.png.is_some() {
                return Err(Error::Usage("--png draws particles, which scenes have not; leave it out".into()));
            }
            let text = |path: &Path| {
                let read = std::fs::read_to_string(path);
                read.map_err(|e| Error::Usage(format!("{} cannot be read ({e}); check the path", path.display())))
            };
            let keys = scenes([&text(a)?, &text(b)?], [a, b])?;
            if args.json {
                say!("{}", json!({ "same": keys.is_empty(), "keys": keys.iter().map(key_value).collect::<Vec<_>>() }));
            } else {
                keys.iter().for_each(|key| say!("{key}"));
            }
            !keys.is_empty()
        }
        Kind::Checkpoint => {
            let (first, second) = (Side::open(a)?, Side::open(b)?);
            let diff = checkpoints(&first, &second, &options)?;
            if args.json {
                say!("{}", file_value(&diff));
            } else {
                say!("{diff}");
            }
            draw(args, &first, &second, &diff)?;
            diff.differs()
        }
        Kind::Run => {
            let diff = runs(a, b, &options)?;
            if args.json {
                say!("{}", run_value(&diff));
            } else {
                say!("{diff}");
            }
            if args.png.is_some() {
                draw_run(args, &diff)?;
            }
            diff.differs()
        }
    };
    Ok(ExitCode::from(u8::from(differs)))
}

/// Draws the first step that differs.
fn draw_run(args: &DiffArgs, diff: &RunDiff) -> Result<(), Error> {
    let Some(step) = diff.steps.iter().find(|d| d.differs()) else {
        return nothing_to_draw(args);
    };
    let open = |dir: &Path| Side::open(dir.join(checkpoint_name(step.step[0])));
    draw(args, &open(&args.a)?, &open(&args.b)?, step)
}

fn draw(args: &DiffArgs, a: &Side, b: &Side, diff: &FileDiff) -> Result<(), Error> {
    let Some(path) = &args.png else { return Ok(()) };
    let Some((frame, column, largest)) = frame(a, b, diff)? else {
        return nothing_to_draw(args);
    };
    picture(&frame, &View { mode: ColourMode::Damage, ..View::default() }, path)?;
    if !args.json {
        say!("{}: where {column} differs, deep red is {largest:.3e}", path.display());
    }
    Ok(())
}

fn nothing_to_draw(args: &DiffArgs) -> Result<(), Error> {
    if !args.json {
        say!("no picture: no column of particles differs in both");
    }
    Ok(())
}

fn key_value(key: &KeyDiff) -> Value {
    json!({ "key": key.key, "first": key.values[0], "second": key.values[1] })
}

fn column_value(column: &ColumnDiff) -> Value {
    let mut value = json!({ "column": column.label, "unit": column.unit, "differs": column.verdict.differs() });
    match &column.verdict {
        Verdict::Same => {}
        Verdict::Only(side) => value["only_in"] = json!(["first", "second"][*side]),
        Verdict::Shape(shapes) => value["shapes"] = json!(shapes),
        Verdict::Order => value["compared"] = json!(false),
        Verdict::Numbers(n) => {
            value["numbers"] = json!(n.of);
            value["differing"] = json!(n.differing);
            // JSON has no infinity
            value["largest"] = if n.largest.is_finite() { json!(n.largest) } else { json!("inf") };
            value["rms"] = if n.rms.is_finite() { json!(n.rms) } else { json!("inf") };
            value["at"] = json!({
                "element": n.place.element,
                "body": n.place.body,
                "particle": n.place.particle,
                "position": n.place.position.map(|p| p.to_array()),
            });
        }
    }
    value
}

fn file_value(diff: &FileDiff) -> Value {
    json!({
        "same": !diff.differs(),
        "steps": diff.step,
        "matched_by_id": diff.matched,
        "columns": diff.columns.iter().map(column_value).collect::<Vec<_>>(),
    })
}

fn run_value(diff: &RunDiff) -> Value {
    let frames = &diff.frames;
    json!({
        "same": !diff.differs(),
        "scene": diff.scene.iter().map(key_value).collect::<Vec<_>>(),
        "frozen": file_value(&diff.frozen),
        "first_differing_step": diff.first_step(),
        "checkpoints": diff.steps.iter().map(file_value).collect::<Vec<_>>(),
        "steps_only_in": diff.only,
        "frames": {
            "both": frames.both,
            "differing": frames.differing,
            "first_differing": frames.first.map(|(number, _)| number),
            "only_in": frames.only,
        },
    })
}
