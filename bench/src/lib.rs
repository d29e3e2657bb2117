//! What benchmarks share: the problem and the machine it runs on.

mod blind;
pub mod cells;
mod lattice;
pub mod machine;

pub use blind::Blind;
pub use lattice::{Cloud, Lattice, SPACING, bytes_per_bond};

use std::time::Duration;

use fissure_engine::{Phase, World};

/// One step, and the time of one of its phases.
///
/// # Panics
/// If the step fails.
pub fn phase_of_a_step(world: &mut World, phase: Phase) -> Duration {
    let before = world.profile.spent(phase);
    world.step().expect("a stable step");
    world.profile.spent(phase) - before
}

/// Runs `work` on so many threads.
///
/// # Panics
/// If the system refuses threads.
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads").install(work)
}
