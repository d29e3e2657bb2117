//! Times the step outside criterion: `cargo run --release -p fissure-bench --example kernel -- 67 3.4 10 plastic none`, the
//! last two being the law and the fracture criterion.

use std::time::Instant;

use fissure_bench::machine::resident;
use fissure_bench::{Lattice, bytes_per_bond};

fn main() {
    let arg = |k: usize, default: f64| std::env::args().nth(k).and_then(|a| a.parse().ok()).unwrap_or(default);
    let (edge, horizon, steps) = (arg(1, 67.0) as i32, arg(2, 3.4), arg(3, 10.0) as usize);
    let word = |k: usize, default: &str| std::env::args().nth(k).unwrap_or(default.into());
    let (law, criterion) = (word(4, "isotropic"), word(5, "critical_stretch"));
    let lattice = Lattice { law: &law, criterion: &criterion, edge, horizon, ..Lattice::default() };
    let start = Instant::now();
    let mut world = lattice.world(&fissure_materials::registry());
    let bonds = world.bond_counts().0;
    println!(
        "{} particles, {bonds} directed bonds, built in {:.2} s",
        world.particles.len(),
        start.elapsed().as_secs_f64()
    );
    let start = Instant::now();
    println!("stable step {:.3e} s, found in {:.2} s", world.stable_dt(), start.elapsed().as_secs_f64());
    for threads in [1, 2] {
        let best = fissure_bench::on_threads(threads, || {
            world.step().expect("stable");
            (0..steps)
                .map(|_| {
                    let start = Instant::now();
                    world.step().expect("stable");
                    start.elapsed().as_secs_f64()
                })
                .fold(f64::INFINITY, f64::min)
        });
        println!(
            "{threads} threads: {:.2} ms a step, {:.0} million directed bonds/s",
            best * 1e3,
            bonds as f64 / best / 1e6
        );
    }
    let (columns, (now, most)) = (bytes_per_bond(&mut world), resident());
    println!(
        "bytes per directed bond: {:.2} in columns of bonds, {:.2} in all; resident {:.2} now, {:.2} at most",
        columns.0,
        columns.1,
        now as f64 / bonds as f64,
        most as f64 / bonds as f64
    );
}
