//! Files: meshes in, scenes, frames, pictures and plots out, checkpoints.

pub mod atomic;
pub mod checkpoint;
pub mod compare;
pub mod diff;
pub mod export;
pub mod fragments;
pub mod frames;
pub mod mesh;
pub mod picture;
pub mod plot;
pub mod scene;
pub mod series;
pub mod simulation;
