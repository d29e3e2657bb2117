//! What a run says: to the terminal, as JSON, and into its log.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::Path;

use serde_json::{Value, json};

use crate::Error;
use crate::args::RunArgs;

/// Where sentences go.
pub(crate) struct Log {
    file: File,
    quiet: bool,
    json: bool,
}

impl Log {
    /// Appends to the log at `path`.
    pub fn open(path: &Path, options: &RunArgs) -> Result<Self, Error> {
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(Error::write(path))?;
        Ok(Self { file, quiet: options.quiet, json: options.json })
    }

    /// Says a sentence, as a person reads it.
    pub fn say(&mut self, sentence: &str) {
        self.keep(sentence);
        if self.json {
            println!("{}", json!({ "event": "note", "text": sentence }));
        } else if !self.quiet {
            println!("{sentence}");
        }
    }

    /// Tells an event: the sentence for the log, the object for programs.
    pub fn tell(&mut self, sentence: &str, event: &Value) {
        self.keep(sentence);
        if self.json {
            println!("{event}");
        }
    }

    /// Says a sentence to people and tells the event to programs.
    pub fn close(&mut self, sentence: &str, event: &Value) {
        self.tell(sentence, event);
        if !self.json && !self.quiet {
            println!("{sentence}");
        }
    }

    /// Into the log only. A full disk must not end a run that could go on: what cannot be kept is lost.
    fn keep(&mut self, sentence: &str) {
        let _ = writeln!(self.file, "{sentence}");
    }
}
