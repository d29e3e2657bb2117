//! `fissure export`: a checkpoint for other programs.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use fissure_io::checkpoint::{ExportFormat, export};

use crate::Error;
use crate::say::{counted, say};

pub(crate) fn command(checkpoint: &Path, to: &str, out: Option<PathBuf>) -> Result<ExitCode, Error> {
    if checkpoint.is_dir() {
        let message = format!("{} is a folder; give one of its checkpoints (.fis)", checkpoint.display());
        return Err(Error::Usage(message));
    }
    let format = ExportFormat::ALL.iter().find(|(_, name)| *name == to).expect("checked by the command line").0;
    let beside = match format {
        ExportFormat::Npy => checkpoint.with_extension(""),
        ExportFormat::Csv | ExportFormat::Vtu => checkpoint.with_extension(to),
    };
    let out = out.unwrap_or(beside);
    let files = export(checkpoint, format, &out)?;
    match format {
        ExportFormat::Npy => say!("{}: {}", out.display(), counted(files.len(), "column")),
        ExportFormat::Csv | ExportFormat::Vtu => say!("{}", out.display()),
    }
    Ok(ExitCode::SUCCESS)
}
