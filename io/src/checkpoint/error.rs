//! What can go wrong with a checkpoint, one sentence each with the cure.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A checkpoint that cannot be written, opened or restored. Each names the file and what would help.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The system refused.
    #[error("cannot {action} `{}`: {source}; {}", path.display(), cure(source.kind()))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried, a verb.
        action: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A folder, a pipe or a device.
    #[error("`{}` is no regular file; name a checkpoint_<step>.fis or frozen.fis of a run folder", path.display())]
    NotAFile {
        /// What was given.
        path: PathBuf,
    },
    /// Some other kind of file.
    #[error("`{}` is no Fissure checkpoint; name a checkpoint_<step>.fis or frozen.fis of a run folder", path.display())]
    Foreign {
        /// What was given.
        path: PathBuf,
    },
    /// Shorter than it says, or too short to say anything.
    #[error("`{}` is cut short: {found} bytes of {expected}; copy it again or use the checkpoint before it", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// Its length in bytes.
        found: u64,
        /// The length it should have, at least.
        expected: u64,
    },
    /// Written by a newer program.
    #[error("`{}` has format version {found} and this program reads up to {known}; update fissure", path.display())]
    FutureVersion {
        /// The file.
        path: PathBuf,
        /// Its format version.
        found: u32,
        /// The newest version that this program reads.
        known: u32,
    },
    /// Not what was written.
    #[error("`{}` is damaged: {what}; copy it again or use the checkpoint before it", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        what: String,
    },
    /// A frozen file where a live one is needed, or the other way round.
    #[error("`{}` holds {found} columns where {expected} ones are needed; name {}", path.display(), usual(expected))]
    WrongKind {
        /// The file.
        path: PathBuf,
        /// The kind needed, `frozen` or `live`.
        expected: &'static str,
        /// The kind it is.
        found: &'static str,
    },
    /// Live and frozen file of different runs.
    #[error("`{}` belongs to frozen columns {expected:016x}, and `{}` is {found:016x}; use the frozen.fis of its own run",
        live.display(), frozen.display())]
    OtherRun {
        /// The live file.
        live: PathBuf,
        /// The frozen file.
        frozen: PathBuf,
        /// Fingerprint that the live file asks for.
        expected: u64,
        /// Fingerprint of the frozen file.
        found: u64,
    },
    /// A column that the file lacks.
    #[error("`{}` has no column `{column}`; resume with the scene and program version that wrote it", path.display())]
    NoColumn {
        /// The file.
        path: PathBuf,
        /// Scope and name.
        column: String,
    },
    /// A column of the file that nothing asks for.
    #[error("`{}` has a column `{column}` that this run does not know; resume with the scene and program version that wrote it",
        path.display())]
    Unused {
        /// The file.
        path: PathBuf,
        /// Scope and name.
        column: String,
    },
    /// A column of another type or unit.
    #[error("`{}` has column `{column}` as {found} where {expected} is needed; resume with the program version that wrote it",
        path.display())]
    WrongType {
        /// The file.
        path: PathBuf,
        /// Scope and name.
        column: String,
        /// Type, width and unit needed.
        expected: String,
        /// Type, width and unit in the file.
        found: String,
    },
    /// Two columns of one name.
    #[error("two columns are called `{column}` on the way to or from `{}`; give each its own scope or name", path.display())]
    Duplicate {
        /// The file.
        path: PathBuf,
        /// Scope and name.
        column: String,
    },
    /// A declaration that the format has no room for.
    #[error("cannot save to `{}`: {what}", path.display())]
    Unfit {
        /// The file.
        path: PathBuf,
        /// What does not fit, with the cure.
        what: String,
    },
    /// Live columns before the frozen ones.
    #[error("`{}` has no usable frozen.fis yet; write the frozen columns before the first checkpoint", dir.display())]
    NoFrozen {
        /// The run folder.
        dir: PathBuf,
    },
    /// New frozen columns for a folder that has checkpoints.
    #[error("`{}` holds the checkpoints of another run; resume that run or choose another folder", dir.display())]
    Occupied {
        /// The run folder.
        dir: PathBuf,
    },
    /// Nothing to resume from.
    #[error("`{}` has no complete checkpoint{}; run the scene again", dir.display(), tried(skipped))]
    NoneComplete {
        /// The run folder.
        dir: PathBuf,
        /// Why each that is there was refused, newest first.
        skipped: Vec<CheckpointError>,
    },
}

impl CheckpointError {
    /// An error of the system for `path`, as a function for `map_err`.
    pub(crate) fn io(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::Io { path: path.to_owned(), action, source }
    }

    pub(crate) fn damaged(path: &Path, what: impl Into<String>) -> Self {
        Self::Damaged { path: path.to_owned(), what: what.into() }
    }
}

fn cure(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::NotFound => "check the name and that the folder is still there",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => "check its permissions or choose another folder",
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "make room there or choose a folder on another disk",
        ErrorKind::AlreadyExists | ErrorKind::NotADirectory => "a file is in its way; choose another folder",
        ErrorKind::OutOfMemory => "free memory or raise the limit on address space",
        _ => "check the disk and try again",
    }
}

fn usual(kind: &str) -> &'static str {
    if kind == "frozen" { "the run's frozen.fis" } else { "one of the run's checkpoint_<step>.fis" }
}

fn tried(skipped: &[CheckpointError]) -> String {
    match skipped {
        [] => String::new(),
        [newest, ..] => format!(" ({} refused, the newest because {newest})", skipped.len()),
    }
}
