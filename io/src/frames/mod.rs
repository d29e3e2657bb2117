//! Frames: the surface of all bodies at one instant, as numbered PLY files other programs open.
//!
//! A [`Frame`] is a triangle surface whose attributes all live on vertices, because that is what readers keep: Blender
//! drops face properties, meshio fails on binary PLY that has them. Crack faces have vertices of their own, so that
//! they can carry their own normals and `inside = 1`. `ply` writes the file, `header` reads it, `folder` numbers. A
//! [`ParticleFrame`] has the particles of the same instant.

mod folder;
mod header;
mod particles;
pub(crate) mod ply;
#[cfg(test)]
mod tests;
mod tets;

use std::path::PathBuf;

pub use folder::FrameFolder;
pub use particles::ParticleFrame;
pub use ply::{from_bytes, read, to_bytes, write};
pub use tets::TetFrame;

/// The surface of all bodies at one time. Every vertex column has the same length, and column `k` of each belongs to
/// vertex `k`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Where the vertices are (m).
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, outwards. Zero where unknown.
    pub normals: Vec<[f32; 3]>,
    /// Vertex numbers of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Velocities (m/s).
    pub velocity: Vec<[f32; 3]>,
    /// Damage, 0 (whole) to 1 (every bond broken).
    pub damage: Vec<f32>,
    /// How much longer the surface is than at rest, along the direction in which that is most; 0 unstretched.
    pub stretch: Vec<f32>,
    /// The rest vertex each vertex comes from; the same in every frame, while vertices split.
    pub id: Vec<u32>,
    /// 1 on crack faces, 0 on the skin the body began with.
    pub inside: Vec<u8>,
    /// Which fragment the vertex belongs to, under an id that lasts: of one that splits the heaviest part keeps it.
    pub piece: Vec<u32>,
    /// Simulated time (s).
    pub time: f64,
    /// Number of the frame in its run, from 0.
    pub number: u32,
}

/// Why a frame could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// The file system said no.
    #[error("cannot {action} {}: {source}; check that the folder exists, is writable and has room", path.display())]
    Io {
        /// What was tried: "read", "write" or "list".
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A vertex column is longer or shorter than the positions.
    #[error("frame {number} has {got} values of {column} for {want} vertices; give one value for each vertex")]
    Length {
        /// The frame.
        number: u32,
        /// Name of the column.
        column: &'static str,
        /// How many values it has.
        got: usize,
        /// How many vertices there are.
        want: usize,
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex}, but there are only {vertices}; number vertices from 0")]
    Index {
        /// The triangle, from 0.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// The bytes are not a frame.
    #[error("{}: {problem}; frames are binary little-endian PLY files of triangles", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong, with the line or the byte.
        problem: String,
    },
}

impl Frame {
    /// Checks that all columns have one length and that triangles name vertices that exist.
    ///
    /// # Errors
    /// [`FrameError::Length`] or [`FrameError::Index`] for the first fault.
    pub fn check(&self) -> Result<(), FrameError> {
        let want = self.positions.len();
        let columns = [
            ("normals", self.normals.len()),
            ("velocity", self.velocity.len()),
            ("damage", self.damage.len()),
            ("stretch", self.stretch.len()),
            ("id", self.id.len()),
            ("inside", self.inside.len()),
            ("piece", self.piece.len()),
        ];
        for (column, got) in columns {
            if got != want {
                return Err(FrameError::Length { number: self.number, column, got, want });
            }
        }
        self.check_triangles()
    }

    /// How many fragments there are.
    pub fn pieces(&self) -> usize {
        let mut ids = self.piece.clone();
        ids.sort_unstable();
        ids.dedup();
        ids.len()
    }

    fn check_triangles(&self) -> Result<(), FrameError> {
        let vertices = self.positions.len();
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
                return Err(FrameError::Index { triangle, vertex, vertices });
            }
        }
        Ok(())
    }
}
