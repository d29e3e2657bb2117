//! What can go wrong between a scene and a running simulation: one sentence each.

use thiserror::Error;

use crate::checkpoint::CheckpointError;
use crate::mesh;
use crate::scene::{Place, SceneError};

/// Why a simulation cannot be built or restored.
#[derive(Debug, Error)]
pub enum SimulationError {
    /// The scene file is wrong.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A mesh file is wrong.
    #[error(transparent)]
    Mesh(#[from] mesh::MeshError),
    /// A checkpoint is wrong.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// Something about one body; the message says what and what helps.
    #[error("{place}: body `{body}`{source_file}: {message}")]
    Body {
        /// Where the scene gives what is at fault.
        place: Place,
        /// Its name in the scene.
        body: String,
        /// ` (file)` if it has one that the message does not name.
        source_file: String,
        /// What is wrong.
        message: String,
    },
    /// Anything else about a scene or a checkpoint as a whole.
    #[error("{file}: {message}")]
    Whole {
        /// The file.
        file: String,
        /// What is wrong.
        message: String,
    },
}
