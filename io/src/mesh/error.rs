//! What can be wrong with a mesh file: one sentence each, with the file, the place in it, and the cure.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Why a mesh could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The system refused to read the file.
    #[error("{}: cannot be read ({source}); check the path and its permissions", path.display())]
    Read {
        /// The file asked for.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The system refused to write the file. Nothing half-written is left.
    #[error("{}: cannot be written ({source}); check the folder, its permissions and the space left", path.display())]
    Write {
        /// The file asked for.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file name ends in no extension that is known for this use.
    #[error("{}: {}; known are {known}", path.display(), unknown(found, verb, *nearest))]
    UnknownExtension {
        /// The file asked for.
        path: PathBuf,
        /// Its extension, without the dot.
        found: String,
        /// "read" or "write".
        verb: &'static str,
        /// The known extension that resembles it most, if any does.
        nearest: Option<&'static str>,
        /// All known extensions, for the eye.
        known: String,
    },
    /// The format holds the other kind of mesh.
    #[error("{}: .{extension} files hold {holds}, but the mesh has {has}; write it as {instead}", path.display())]
    WrongKind {
        /// The file asked for.
        path: PathBuf,
        /// Its extension.
        extension: &'static str,
        /// What the format holds.
        holds: &'static str,
        /// What the mesh is made of.
        has: &'static str,
        /// Extensions that would do.
        instead: &'static str,
    },
    /// The content of the file is at fault.
    #[error("{}{place}: {problem}", path.display())]
    Content {
        /// The file at fault (of a `.node`/`.ele` pair the one that is).
        path: PathBuf,
        /// Where in the file.
        place: Place,
        /// What is wrong and what helps.
        problem: Problem,
    },
}

fn unknown(found: &str, verb: &str, nearest: Option<&str>) -> String {
    match (found, nearest) {
        ("", _) => "the name has no extension to tell the mesh format".to_owned(),
        (_, None) => format!("the extension '{found}' is not a mesh format to {verb}"),
        (_, Some(near)) => format!("the extension '{found}' is not a mesh format to {verb}, did you mean '{near}'"),
    }
}

impl MeshError {
    pub(super) fn content(path: &Path, place: Place, problem: Problem) -> Self {
        Self::Content { path: path.to_owned(), place, problem }
    }
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    Whole,
    /// A line of a text file, counted from 1.
    Line(u64),
    /// A byte of a binary file, counted from 0.
    Byte(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Whole => Ok(()),
            Place::Line(n) => write!(f, ", line {n}"),
            Place::Byte(n) => write!(f, ", byte {n}"),
        }
    }
}

/// What is wrong at that place. Vertices and elements carry the numbers that the file gives them.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// The file stops too early.
    #[error("the file ends inside {what}; copy it again or have its program write it again")]
    Truncated {
        /// What was being read.
        what: String,
    },
    /// A header promises more than the rest of the file can hold.
    #[error("{count} {what} are announced, more than the rest of the file holds; copy it again or correct the count")]
    TooMany {
        /// The number in the header.
        count: u64,
        /// What is counted.
        what: String,
    },
    /// Something else stands where a word or a number should.
    #[error("expected {expected}, found '{found}'; correct it or write the file again")]
    Unexpected {
        /// What should stand there.
        expected: String,
        /// What stands there, shortened.
        found: String,
    },
    /// A variant of the format that is not read.
    #[error("{what} cannot be read; {cure}")]
    Unsupported {
        /// The variant.
        what: String,
        /// What to do.
        cure: &'static str,
    },
    /// An array has the wrong length.
    #[error("{what} has {found} values where {expected} are needed; write the file again")]
    Length {
        /// The array.
        what: String,
        /// Values needed.
        expected: u64,
        /// Values found.
        found: u64,
    },
    /// A coordinate is NaN, infinite, or beyond 1e100 (volumes would overflow).
    #[error("vertex {vertex} has the coordinate {value}, which is no place in space; correct the vertex or mesh again")]
    NotFinite {
        /// Number of the vertex.
        vertex: i64,
        /// The coordinate as text.
        value: String,
    },
    /// An element names a vertex that is not there.
    #[error("{element} uses vertex {vertex}, which the file does not have; correct the number or add the vertex")]
    NoSuchVertex {
        /// The element.
        element: String,
        /// The number it uses.
        vertex: i64,
    },
    /// Two vertices have one number.
    #[error("the vertex number {vertex} is given twice; number each vertex once")]
    RepeatedVertex {
        /// The number.
        vertex: i64,
    },
    /// The corners of a tetrahedron lie in a plane.
    #[error("{element} has no volume: its corners lie in one plane; remove it or mesh again")]
    NoVolume {
        /// The element.
        element: String,
    },
    /// A polygon with fewer than three corners.
    #[error("{element} has {corners} corners; a face needs at least 3, remove it or correct it")]
    FewCorners {
        /// The element.
        element: String,
        /// Corners found.
        corners: usize,
    },
    /// More vertices than 32-bit indices can tell apart.
    #[error("there are 4294967295 vertices or more; split the mesh")]
    TooLarge,
    /// Nothing to simulate in it.
    #[error("there are no {what} in it; export the mesh with them")]
    Empty {
        /// What is missing.
        what: &'static str,
    },
}
