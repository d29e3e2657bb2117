//! Numbered frames in one folder: `frame_0000.ply`, `frame_0001.ply`, …
//!
//! A run that resumes asks [`FrameFolder::numbers`] what is there and writes over frames later than its checkpoint;
//! the same step gives the same bytes, so nothing has to be deleted first.

use std::path::{Path, PathBuf};

use super::{Frame, FrameError, ParticleFrame, ply};

/// A folder that holds the frames of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameFolder {
    folder: PathBuf,
}

impl FrameFolder {
    /// The frames in `folder`, which need not exist yet.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// The folder itself.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Where frame `number` is or would be: four digits, more from frame 10 000 on.
    pub fn path(&self, number: u32) -> PathBuf {
        self.folder.join(format!("frame_{number:04}.ply"))
    }

    /// Numbers of the frames that are there, ascending; none if the folder does not exist. Other files and half-written
    /// ones are passed over.
    ///
    /// # Errors
    /// [`FrameError::Io`] if the folder cannot be listed.
    pub fn numbers(&self) -> Result<Vec<u32>, FrameError> {
        let failed = |source| FrameError::Io { action: "list", path: self.folder.clone(), source };
        let entries = match std::fs::read_dir(&self.folder) {
            Ok(entries) => entries,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(e) => return Err(failed(e)),
        };
        let mut numbers = Vec::new();
        for entry in entries {
            let name = entry.map_err(failed)?.file_name();
            numbers.extend(name.to_str().and_then(number_of));
        }
        numbers.sort_unstable();
        Ok(numbers)
    }

    /// The number after the last frame that is there, 0 for an empty folder.
    ///
    /// # Errors
    /// As [`FrameFolder::numbers`].
    pub fn next(&self) -> Result<u32, FrameError> {
        Ok(self.numbers()?.last().map_or(0, |&n| n + 1))
    }

    /// Writes `frame` under its number, making the folder if needed and replacing an earlier frame; gives its path.
    ///
    /// # Errors
    /// [`FrameError::Io`], [`FrameError::Length`], [`FrameError::Index`].
    pub fn write(&self, frame: &Frame) -> Result<PathBuf, FrameError> {
        self.make()?;
        let path = self.path(frame.number);
        ply::write(frame, &path)?;
        Ok(path)
    }

    /// The time of frame `number` [s], from the head of its file alone; 0 if it does not say.
    ///
    /// # Errors
    /// [`FrameError::Io`], [`FrameError::Format`].
    pub fn time(&self, number: u32) -> Result<f64, FrameError> {
        ply::time(&self.path(number))
    }

    /// As [`write`](Self::write), for particles.
    ///
    /// # Errors
    /// [`FrameError::Io`], [`FrameError::Length`].
    pub fn write_particles(&self, frame: &ParticleFrame) -> Result<PathBuf, FrameError> {
        self.make()?;
        let path = self.path(frame.number);
        frame.write(&path)?;
        Ok(path)
    }

    fn make(&self) -> Result<(), FrameError> {
        let failed = |source| FrameError::Io { action: "create", path: self.folder.clone(), source };
        std::fs::create_dir_all(&self.folder).map_err(failed)
    }

    /// Reads frame `number`.
    ///
    /// # Errors
    /// [`FrameError::Io`], [`FrameError::Format`], [`FrameError::Index`].
    pub fn read(&self, number: u32) -> Result<Frame, FrameError> {
        ply::read(&self.path(number))
    }

    /// Reads frame `number` of particles.
    ///
    /// # Errors
    /// [`FrameError::Io`], [`FrameError::Format`].
    pub fn read_particles(&self, number: u32) -> Result<ParticleFrame, FrameError> {
        ParticleFrame::read(&self.path(number))
    }
}

/// The number in a file name that this module gave; `None` for any other name.
pub(super) fn number_of(name: &str) -> Option<u32> {
    let digits = name.strip_prefix("frame_")?.strip_suffix(".ply")?;
    let plain = digits.len() >= 4 && digits.bytes().all(|b| b.is_ascii_digit());
    let canonical = digits.len() == 4 || !digits.starts_with('0');
    if plain && canonical { digits.parse().ok() } else { None }
}
