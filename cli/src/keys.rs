//! `fissure keys`: every key of a scene file, from the table that the reader itself uses.

use std::process::ExitCode;

use fissure_io::scene::{Fallback, keys};

use crate::Error;
use crate::say::say;

/// Prints the keys whose path contains `part`, or all.
pub(crate) fn command(part: Option<&str>) -> Result<ExitCode, Error> {
    let wanted: Vec<_> = keys().iter().filter(|key| part.is_none_or(|part| key.path.contains(part))).collect();
    if wanted.is_empty() {
        let part = part.unwrap_or_default();
        return Err(Error::Usage(format!("no key of a scene has `{part}` in it; `fissure keys` lists all")));
    }
    for key in wanted {
        let fallback = match key.default {
            Fallback::Required => "required".into(),
            Fallback::Toml(value) => format!("default {value}"),
            Fallback::Said(words) => words.to_string(),
        };
        say!("{}\n    {}; {fallback}\n    {}", key.path, key.wants(), key.about);
    }
    say!("\nMaterials and criteria have keys of their own: `fissure materials NAME` lists them.");
    Ok(ExitCode::SUCCESS)
}
