//! `fissure bench`: the step of the default law on this machine, beside the speed of its memory.

use std::process::ExitCode;
use std::time::Instant;

use fissure_bench::machine::{Bandwidth, Machine};
use fissure_bench::{Lattice, bytes_per_bond, on_threads};
use fissure_engine::Registry;
use serde_json::json;

use crate::Error;
use crate::args::BenchArgs;
use crate::say::say;

/// Every figure is the best of so many: other work on the machine only ever adds to a time.
const RUNS: usize = 7;

pub(crate) fn command(options: &BenchArgs, registry: &Registry) -> Result<ExitCode, Error> {
    let machine = Machine::here();
    let lattice = Lattice { edge: options.edge, ..Lattice::default() };
    let mut world = lattice.world(registry);
    let (particles, bonds) = (lattice.particles(), lattice.directed());
    let each = bonds as f64 / particles as f64;
    let (_, bytes) = bytes_per_bond(&mut world);
    if !options.json {
        say!("machine  {}", machine.sentence());
        say!("problem  {}, fracture {}: a lattice of", lattice.law, lattice.criterion);
        say!("         {particles} particles, {bonds} directed bonds ({each:.1} each, {bytes:.2} bytes in columns)\n");
        say!("threads   read GB/s   triad GB/s   ms a step   million directed bonds/s   of the floor");
    }
    let mut measured = Vec::new();
    for threads in if machine.threads > 1 { vec![1, machine.threads] } else { vec![1] } {
        let memory = on_threads(threads, || Bandwidth::measure(RUNS, 8 * bonds as usize));
        // the first step allocates
        let steps = on_threads(threads, || {
            let mut step = || {
                let start = Instant::now();
                world.step().map(|()| start.elapsed().as_secs_f64())
            };
            (0..=RUNS).map(|_| step()).collect::<Result<Vec<f64>, _>>()
        });
        let steps = steps.map_err(|e| Error::Usage(e.to_string()))?;
        let seconds = steps[1..].iter().copied().fold(f64::INFINITY, f64::min);
        let (rate, floor) = (bonds as f64 / seconds, memory.floor());
        if !options.json {
            say!(
                "{threads:>7}   {:>9.1}   {:>10.1}   {:>9.2}   {:>24.0}   {:>10.0} %",
                memory.read / 1e9,
                memory.triad / 1e9,
                1e3 * seconds,
                rate / 1e6,
                100.0 * rate / floor
            );
        }
        measured.push(json!({
            "threads": threads, "read": memory.read, "triad": memory.triad, "seconds_per_step": seconds,
            "directed_bonds_per_second": rate, "floor": floor, "share_of_floor": rate / floor,
        }));
    }
    if options.json {
        let all = json!({
            "processor": machine.processor, "threads": machine.threads, "features": machine.features,
            "load": machine.load, "law": lattice.law, "criterion": lattice.criterion, "particles": particles,
            "directed_bonds": bonds, "bytes_per_bond": bytes, "measured": measured,
        });
        say!("{all}");
    } else {
        say!("\nThe floor is reading eight bytes of every directed bond twice a step, at the bandwidth beside it.");
    }
    Ok(ExitCode::SUCCESS)
}
