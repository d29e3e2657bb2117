//! The engine (being written).
pub mod buffer;
pub mod column;
