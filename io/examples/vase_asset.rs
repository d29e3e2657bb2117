//! Writes the project's vase: `cargo run --release -p fissure-io --example vase_asset -- scenes/assets/vase.ply`.

use fissure_io::mesh::{Mesh, write};
use fissure_meshing::shapes::vase;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("give the file to write")?;
    // 0.3 m high with walls of 12 mm
    write(path, &Mesh::Surface(vase(0.3, 0.012, 50)?))?;
    Ok(())
}
