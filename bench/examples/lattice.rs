//! Time per step of shape matching on lattices: a uniform one of a million nodes for several w, and a small body uniform
//! and adaptive.
//!
//!     cargo run --release -p fissure-bench --example lattice [EDGE [PART OF A NAME]]

use std::time::Instant;

use fissure_bench::cells::{Cube, ball};
use fissure_engine::World;

fn main() {
    let mut args = std::env::args().skip(1);
    let edge: u32 = args.next().and_then(|n| n.parse().ok()).unwrap_or(100);
    let only = args.next().unwrap_or_default();
    println!("threads {}", rayon::current_num_threads());
    // small ones long enough to be timed
    let steps = (2_000_000 / edge.pow(3)).max(5);
    for w in [1.0, 2.0, 4.0] {
        report(&only, &format!("cube of {edge}, lsm, w = {w}"), steps, || {
            Cube { edge, method: "lsm", half_width: w, ..Cube::default() }.world()
        });
    }
    for (method, levels) in [("lsm", 0.0), ("ohta", 2.0), ("steinemann", 2.0)] {
        report(&only, &format!("ball, {method}"), 200, || ball(method, levels));
    }
}

fn report(only: &str, name: &str, steps: u32, world: impl Fn() -> World) {
    if !name.contains(only) {
        return;
    }
    let mut world = world();
    world.step().expect("shape matching always steps");
    let mut least = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        (0..steps).for_each(|_| world.step().expect("as before"));
        least = least.min(start.elapsed().as_secs_f64() / f64::from(steps));
    }
    let n = world.particles.len();
    println!(
        "{name}: {n} nodes, {:.3} ms a step, {:.1} ns a node, {:.2e} nodes/s",
        least * 1e3,
        least * 1e9 / n as f64,
        n as f64 / least
    );
}
