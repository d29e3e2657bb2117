//! Our side of `peers/compare.py`: `peer LAW EDGE HORIZON STEPS THREADS` prints directed bonds, and wall and processor time
//! of a step [s]. The first step, which allocates, is not counted.

use std::time::Instant;

use fissure_bench::machine::processor_time;
use fissure_bench::{Lattice, on_threads};

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [law, edge, horizon, steps, threads] = &args[..] else {
        panic!("peer LAW EDGE HORIZON STEPS THREADS");
    };
    let number = |text: &str| text.parse::<f64>().expect("a number");
    let (edge, steps, threads) = (number(edge) as i32, number(steps) as u32, number(threads) as usize);
    let lattice = Lattice { law, edge, horizon: number(horizon), ..Lattice::default() };
    let mut world = lattice.world(&fissure_materials::registry());
    world.contact.between = false; // as in LAMMPS's script: bonds only
    let (wall, processor) = on_threads(threads, || {
        world.step().expect("stable");
        let (start, before) = (Instant::now(), processor_time());
        (0..steps).for_each(|_| world.step().expect("stable"));
        (start.elapsed().as_secs_f64(), processor_time() - before)
    });
    let (bonds, each) = (world.bond_counts().0, f64::from(steps));
    assert_eq!(world.bond_counts().1, 0, "nothing is to break");
    println!("{bonds} {:.6} {:.6}", wall / each, processor / each);
}
