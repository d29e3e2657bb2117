//! The checkpoints of one run folder: writing them, keeping the newest few, finding the one to resume from.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use fissure_engine::column::Life;

use super::format::About;
use super::write::{TEMPORARY, Written, stage};
use super::{CheckpointError, Columns, Opened, write};

/// Name of the file of a run that holds the frozen columns.
pub const FROZEN: &str = "frozen.fis";

/// Name of the checkpoint of step `step`.
pub fn checkpoint_name(step: u64) -> String {
    format!("checkpoint_{step:08}.fis")
}

/// A run folder with `frozen.fis` and `checkpoint_<step>.fis` in it.
#[derive(Debug)]
pub struct Store {
    dir: PathBuf,
    keep: usize,
    frozen: Option<u64>,
}

/// What to resume from.
#[derive(Debug)]
pub struct Latest {
    /// The newest complete checkpoint.
    pub live: Opened,
    /// The frozen columns of the run.
    pub frozen: Opened,
    /// Why newer ones were passed over, newest first: worth a line each to the user.
    pub skipped: Vec<CheckpointError>,
}

impl Store {
    /// Makes or enters the run folder `dir`, and removes temporary files that a killed writer left there. Keeps 5
    /// checkpoints unless told otherwise.
    ///
    /// # Errors
    /// If the folder cannot be made, read or cleaned.
    pub fn create(dir: impl AsRef<Path>) -> Result<Self, CheckpointError> {
        let dir = dir.as_ref().to_owned();
        fs::create_dir_all(&dir).map_err(CheckpointError::io("create", &dir))?;
        for name in names(&dir)? {
            let ours = name.starts_with(".frozen.fis.") || name.starts_with(".checkpoint_");
            if ours && name.ends_with(TEMPORARY) {
                remove_stale(&dir.join(name))?;
            }
        }
        // A frozen file that does not open counts as none here; resuming says what is wrong with it.
        let frozen = Opened::open(dir.join(FROZEN)).ok().filter(|file| file.life() == Life::Frozen);
        Ok(Self { frozen: frozen.map(|file| file.fingerprint()), dir, keep: 5 })
    }

    /// How many of the newest checkpoints stay; 0 keeps all.
    pub fn keep(mut self, count: usize) -> Self {
        self.keep = count;
        self
    }

    /// The run folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Writes `frozen.fis`, once per run.
    ///
    /// # Errors
    /// If the folder holds checkpoints already, or the file cannot be written.
    pub fn write_frozen(&mut self, columns: &mut dyn Columns, about: &About) -> Result<Written, CheckpointError> {
        if !self.checkpoints()?.is_empty() {
            return Err(CheckpointError::Occupied { dir: self.dir.clone() });
        }
        let written = write(self.dir.join(FROZEN), Life::Frozen, 0, about, columns)?;
        self.frozen = Some(written.fingerprint);
        Ok(written)
    }

    /// Writes the checkpoint of `about.step`, then removes the oldest beyond those to keep. Checkpoints of later
    /// steps, left from before a resume at an earlier one, go too: a run folder tells one story.
    ///
    /// # Errors
    /// If the frozen columns were not written yet or the system refuses. The checkpoints that were there stay.
    pub fn write_live(&mut self, columns: &mut dyn Columns, about: &About) -> Result<Written, CheckpointError> {
        let frozen = self.frozen.ok_or_else(|| CheckpointError::NoFrozen { dir: self.dir.clone() })?;
        let path = self.dir.join(checkpoint_name(about.step));
        let staged = stage(&path, Life::Live, frozen, about, columns)?;
        // Later ones go before the new name appears: killed in between, the run resumes where it did before.
        for (_, later) in self.checkpoints()?.iter().filter(|(step, _)| *step > about.step) {
            remove(later)?;
        }
        let written = staged.commit()?;
        if self.keep > 0 {
            let all = self.checkpoints()?;
            for (_, oldest) in &all[..all.len().saturating_sub(self.keep)] {
                remove(oldest)?;
            }
        }
        Ok(written)
    }

    /// The checkpoint files with their steps, oldest first.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn checkpoints(&self) -> Result<Vec<(u64, PathBuf)>, CheckpointError> {
        Self::listing(&self.dir)
    }

    /// The same of a folder that is only looked at, which may be a run's that is going on.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn listing(dir: &Path) -> Result<Vec<(u64, PathBuf)>, CheckpointError> {
        let mut found = Vec::new();
        for name in names(dir)? {
            let step = name.strip_prefix("checkpoint_").and_then(|rest| rest.strip_suffix(".fis"));
            if let Some(step) = step.filter(|s| s.bytes().all(|b| b.is_ascii_digit())).and_then(|s| s.parse().ok()) {
                found.push((step, dir.join(name)));
            }
        }
        found.sort();
        Ok(found)
    }

    /// Opens the frozen columns of the run.
    ///
    /// # Errors
    /// If `frozen.fis` is missing, damaged, or no frozen file.
    pub fn open_frozen(&self) -> Result<Opened, CheckpointError> {
        let frozen = Opened::open(self.dir.join(FROZEN))?;
        frozen.expect_life(Life::Frozen)?;
        Ok(frozen)
    }

    /// The newest checkpoint that opens, verifies and belongs to this run's frozen columns.
    ///
    /// # Errors
    /// If there is none, or the frozen columns are missing or damaged.
    pub fn latest_complete(&self) -> Result<Latest, CheckpointError> {
        self.latest(&|file| {
            file.verify()?;
            Ok(file)
        })
    }

    /// As [`latest_complete`](Self::latest_complete) without reading the columns to check their sums, for files
    /// that are known to be good.
    ///
    /// # Errors
    /// As there.
    pub fn latest_trusted(&self) -> Result<Latest, CheckpointError> {
        self.latest(&|file| Ok(file.trust()))
    }

    fn latest(&self, accept: &dyn Fn(Opened) -> Result<Opened, CheckpointError>) -> Result<Latest, CheckpointError> {
        let mut skipped = Vec::new();
        let checkpoints = self.checkpoints()?;
        if checkpoints.is_empty() {
            return Err(CheckpointError::NoneComplete { dir: self.dir.clone(), skipped });
        }
        let frozen = accept(self.open_frozen()?)?;
        for (_, path) in checkpoints.iter().rev() {
            let live = Opened::open(path).and_then(|live| {
                live.belongs_to(&frozen)?;
                accept(live)
            });
            match live {
                Ok(live) => return Ok(Latest { live, frozen, skipped }),
                Err(e) => skipped.push(e),
            }
        }
        Err(CheckpointError::NoneComplete { dir: self.dir.clone(), skipped })
    }
}

/// The names in a folder, sorted; names that are no UTF-8 are none of ours.
fn names(dir: &Path) -> Result<Vec<String>, CheckpointError> {
    let mut names = Vec::new();
    for entry in fs::read_dir(dir).map_err(CheckpointError::io("read", dir))? {
        let entry = entry.map_err(CheckpointError::io("read", dir))?;
        names.extend(entry.file_name().into_string());
    }
    names.sort();
    Ok(names)
}

/// Removes a temporary file unless its writer is alive, which holds a lock on it.
fn remove_stale(path: &Path) -> Result<(), CheckpointError> {
    match File::open(path).map(|file| file.try_lock()) {
        Ok(Err(TryLockError::WouldBlock)) => Ok(()),
        _ => remove(path),
    }
}

/// Removes a file; one that is gone already is fine.
fn remove(path: &Path) -> Result<(), CheckpointError> {
    match fs::remove_file(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(CheckpointError::io("remove", path)(e)),
        _ => Ok(()),
    }
}
