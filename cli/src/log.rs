//! What a run says: to the terminal, as JSON, and into its log.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::Write;
use std::path::Path;

use serde_json::{Value, json};

use crate::Error;
use crate::args::RunArgs;
use crate::say::say;

/// Where sentences go.
pub(crate) struct Log {
    file: File,
    quiet: bool,
    json: bool,
}

impl Log {
    /// Appends to the log at `path`, and holds it: two programs in one run folder would overwrite each other's files.
    pub fn open(path: &Path, options: &RunArgs) -> Result<Self, Error> {
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(Error::write(path))?;
        if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
            return Err(Error::Running(path.parent().unwrap_or(path).into()));
        }
        Ok(Self { file, quiet: options.quiet, json: options.json })
    }

    /// Says a sentence, as a person reads it.
    pub fn say(&mut self, sentence: &str) {
        self.keep(sentence);
        if self.json {
            say!("{}", json!({ "event": "note", "text": sentence }));
        } else if !self.quiet {
            say!("{sentence}");
        }
    }

    /// Tells an event: the sentence for the log, the object for programs.
    pub fn tell(&mut self, sentence: &str, event: &Value) {
        self.keep(sentence);
        if self.json {
            say!("{event}");
        }
    }

    /// Says a sentence to people and tells the event to programs.
    pub fn close(&mut self, sentence: &str, event: &Value) {
        self.tell(sentence, event);
        if !self.json && !self.quiet {
            say!("{sentence}");
        }
    }

    /// Into the log only. A full disk must not end a run that could go on: what cannot be kept is lost.
    fn keep(&mut self, sentence: &str) {
        let _ = writeln!(self.file, "{sentence}");
    }
}
