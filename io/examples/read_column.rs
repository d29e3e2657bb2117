//! Reads a column of a checkpoint: `cargo run -p fissure-io --example read_column -- runs/vase/checkpoint_00001911.fis`.
//! Nothing is copied: the slice lies in the mapped file, and only the pages that are touched are read.

use fissure_io::checkpoint::{CheckpointError, Opened};

fn main() -> Result<(), CheckpointError> {
    let path = std::env::args().nth(1).expect("a checkpoint, such as runs/vase/checkpoint_00001911.fis");
    let file = Opened::open(path)?;
    let velocity = file.column::<glam::DVec3>("particles", "velocity")?;
    let fastest = velocity.iter().map(|v| v.length()).fold(0.0, f64::max);
    println!("step {}: {} particles, the fastest at {fastest:.3} m/s", file.about().step, velocity.len());
    Ok(())
}
