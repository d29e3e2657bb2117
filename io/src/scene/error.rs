//! What is wrong with a scene, and where it stands.

use std::fmt;
use std::sync::Arc;

use thiserror::Error;

/// Where a key or table of a scene comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of the scene file, counted from 1.
    Line {
        /// The path as it was given.
        file: Arc<str>,
        /// The line.
        line: usize,
    },
    /// An override from the command line, as it was given: `key.path=value`.
    Set(Arc<str>),
}

impl Place {
    /// The line in the scene file, unless it comes from an override.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::Line { line, .. } => Some(*line),
            Self::Set(_) => None,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line { file, line } => write!(f, "{file}:{line}"),
            Self::Set(given) => write!(f, "--set {}", one_line(given)),
        }
    }
}

/// What is wrong with a scene, in one sentence with its place and the cure.
#[derive(Debug, Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("{file}: the scene cannot be read ({source}); check the path and that it is a text file")]
    NotReadable {
        /// The path as it was given.
        file: Arc<str>,
        /// What the system says.
        source: std::io::Error,
    },
    /// The text is not TOML.
    #[error("{place}: {message}")]
    Syntax {
        /// Where.
        place: Place,
        /// What the parser says.
        message: String,
    },
    /// The text is TOML but not a scene: unknown, missing, contradicting or impossible keys.
    #[error("{place}: {message}")]
    Wrong {
        /// Where.
        place: Place,
        /// The sentence.
        message: String,
    },
}

impl SceneError {
    pub(super) fn wrong(place: &Place, message: String) -> Self {
        Self::Wrong { place: place.clone(), message: one_line(&message) }
    }
}

/// Keys and values may hold line breaks; messages do not.
pub(super) fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
