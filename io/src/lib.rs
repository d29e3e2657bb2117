//! Files: meshes in, scenes, frames and pictures out, checkpoints.

pub mod atomic;
pub mod checkpoint;
pub mod frames;
pub mod mesh;
pub mod picture;
pub mod scene;
pub mod simulation;
