//! What can go wrong between a scene and a running simulation: one sentence each.

use thiserror::Error;

use crate::checkpoint::CheckpointError;
use crate::mesh;
use crate::scene::SceneError;

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
    #[error("body `{body}`{source_file}: {message}")]
    Body {
        /// Its name in the scene.
        body: String,
        /// ` (file)` if it has one.
        source_file: String,
        /// What is wrong.
        message: String,
    },
    /// Anything else about the scene as a whole.
    #[error("{file}: {message}")]
    Whole {
        /// The scene file.
        file: String,
        /// What is wrong.
        message: String,
    },
}
