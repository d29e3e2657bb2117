//! What can go wrong: one sentence each.

use std::path::PathBuf;

use fissure_engine::StepError;
use fissure_io::checkpoint::CheckpointError;
use fissure_io::diff::DiffError;
use fissure_io::export::ExportError;
use fissure_io::frames::FrameError;
use fissure_io::mesh::MeshError;
use fissure_io::picture::PictureError;
use fissure_io::scene::SceneError;
use fissure_io::simulation::SimulationError;
use thiserror::Error;

/// Why a command failed.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the sentences say it
pub enum Error {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    #[error(transparent)]
    Diff(#[from] DiffError),
    #[error(transparent)]
    Export(#[from] ExportError),
    #[error(transparent)]
    Frame(#[from] FrameError),
    #[error(transparent)]
    Picture(#[from] PictureError),
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error("{error}; the last good state is in {}", checkpoint.display())]
    Step { error: StepError, checkpoint: PathBuf },
    #[error(
        "{} holds another run; give another folder with --out, go on with `fissure resume {}`, or remove it",
        .0.display(), .0.display()
    )]
    Occupied(PathBuf),
    #[error("{} cannot be written: {source}; check that the folder exists, is yours to write and has room", path.display())]
    Write { path: PathBuf, source: std::io::Error },
    #[error("{} is being run by another fissure; wait for it or stop it first", .0.display())]
    Running(PathBuf),
    #[error("{} is no run folder: it has no scene.toml; give the folder that `fissure run` made", .0.display())]
    NoRun(PathBuf),
    #[error(
        "scene.toml of {} was changed since the checkpoint: {keys}; undo that, or accept it with `fissure resume {} --force`",
        dir.display(), dir.display()
    )]
    Changed { dir: PathBuf, keys: String },
    #[error("{0}")]
    Usage(String),
}

impl Error {
    pub(crate) fn write(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| Self::Write { path, source }
    }
}
