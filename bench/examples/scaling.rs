//! Time against particles and threads, as a table and a picture: `cargo run --release -p fissure-bench --example scaling --
//! 1e6` goes up to so many particles (3e6 by default, which wants 10 GB) and leaves `bench/results/scaling.csv` and `.png`.
//!
//! Wall times are those of the machine as it was: the load before the run stands in the file. Processor time, which
//! other programs do not take part in, is beside it and is what the picture shows.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use fissure_bench::machine::{Machine, processor_time};
use fissure_bench::{Lattice, SPACING, on_threads};
use fissure_io::plot::{Curve, Figure, Panel};
use fissure_meshing::family::families;
use fissure_meshing::order::morton_order;
use fissure_meshing::shapes::cubic_lattice;
use glam::DVec3;

/// Each time is the least of so many.
const RUNS: usize = 3;
/// Edges of the lattices: 1e4 to 3e6 particles.
const EDGES: [i32; 6] = [22, 32, 46, 67, 100, 144];

/// A line of the table.
struct Row {
    what: &'static str,
    particles: u64,
    bonds: u64,
    threads: usize,
    wall: f64,
    processor: f64,
}

/// Least wall and processor time of [`RUNS`] [s].
fn least(mut work: impl FnMut()) -> (f64, f64) {
    let mut best = (f64::INFINITY, f64::INFINITY);
    for _ in 0..RUNS {
        let (start, before) = (Instant::now(), processor_time());
        work();
        best = (best.0.min(start.elapsed().as_secs_f64()), best.1.min(processor_time() - before));
    }
    best
}

fn measure(edge: i32, all: usize) -> Vec<Row> {
    let lattice = Lattice { edge, ..Lattice::default() };
    let (particles, bonds) = (lattice.particles(), lattice.directed());
    let row = |what, threads, (wall, processor)| Row { what, particles, bonds, threads, wall, processor };
    let points = cubic_lattice([edge as usize; 3], SPACING);
    let points: Vec<DVec3> = morton_order(&points).into_iter().map(|i| points[i as usize]).collect();
    let find = || drop(families(&points, lattice.horizon * SPACING, None).expect("families"));
    let mut rows = vec![row("families", all, on_threads(all, || least(find)))];
    drop(points);
    let mut world = lattice.world(&fissure_materials::registry());
    let mut threads = 1;
    while threads <= all {
        let time = on_threads(threads, || {
            world.step().expect("stable");
            least(|| world.step().expect("stable"))
        });
        rows.push(row("step", threads, time));
        threads = if threads < all { all.min(2 * threads) } else { all + 1 };
    }
    rows
}

fn curve(name: String, colour: usize, rows: &[&Row], point: impl Fn(&Row) -> [f64; 2]) -> Curve {
    Curve { name, colour, dots: false, points: rows.iter().map(|r| point(r)).collect() }
}

fn in_words(threads: usize) -> String {
    format!("{threads} thread{}", if threads == 1 { "" } else { "s" })
}

fn figure(rows: &[Row], machine: &Machine) -> Figure {
    let of = |what: &str, threads: usize| -> Vec<&Row> {
        rows.iter().filter(|r| r.what == what && r.threads == threads).collect()
    };
    let mut counts: Vec<usize> = rows.iter().filter(|r| r.what == "step").map(|r| r.threads).collect();
    counts.sort_unstable();
    counts.dedup();
    let each = |r: &Row| [(r.particles as f64).log10(), 1e9 * r.processor / r.bonds as f64];
    let steps = counts.iter().enumerate().map(|(k, &n)| curve(in_words(n), k + 1, &of("step", n), each));
    let speed_up = |edge: i32, colour: usize| {
        let of: Vec<&Row> = rows.iter().filter(|r| r.what == "step" && r.particles == (edge as u64).pow(3)).collect();
        let one = of.first().map_or(1.0, |r| r.wall);
        curve(format!("{edge}^3 particles"), colour, &of, |r| [r.threads as f64, one / r.wall])
    };
    let most = *counts.last().unwrap_or(&1) as f64;
    let ideal = Curve { name: "ideal".into(), points: vec![[1.0, 1.0], [most, most]], ..Curve::default() };
    let known: Vec<i32> =
        EDGES.into_iter().filter(|&e| rows.iter().any(|r| r.particles == (e as u64).pow(3))).collect();
    let ups = known.iter().enumerate().map(|(k, &edge)| speed_up(edge, k + 1));
    let all = *counts.last().unwrap_or(&1);
    let found = curve(in_words(all), 1, &of("families", all), |r| {
        [(r.bonds as f64).log10(), 1e9 * r.processor / r.bonds as f64]
    });
    let panel = |title: &str, x: &str, y: &str, curves: Vec<Curve>| Panel {
        title: title.into(),
        x: x.into(),
        y: y.into(),
        equal: false,
        curves,
    };
    // nothing to see, but axes start at 0
    let zero = |x: f64| Curve { points: vec![[x, 0.0]], ..Curve::default() };
    let first = rows.first().map_or([1.0; 2], |r| [r.particles, r.bonds].map(|n| (n as f64).log10()));
    Figure {
        title: machine.sentence(),
        panels: vec![
            panel(
                "step",
                "log10 of particles",
                "processor time per directed bond [ns]",
                steps.chain([zero(first[0])]).collect(),
            ),
            panel("step", "threads", "times as fast as one (wall)", std::iter::once(ideal).chain(ups).collect()),
            panel(
                "families",
                "log10 of directed bonds",
                "processor time per directed bond [ns]",
                vec![found, zero(first[1])],
            ),
        ],
    }
}

fn main() {
    let most: f64 = std::env::args().nth(1).map_or(3.1e6, |word| word.parse().expect("a number of particles"));
    let machine = Machine::here();
    println!("{}", machine.sentence());
    let mut rows = Vec::new();
    for edge in EDGES.into_iter().filter(|&e| f64::from(e).powi(3) <= most * 1.1) {
        for row in measure(edge, machine.threads) {
            let ns = 1e9 / row.bonds as f64;
            println!(
                "{:<8} {:>8} particles, {:>9} directed bonds, {} threads: {:.3} s, {:.2} ns of wall and {:.2} ns of processor each",
                row.what,
                row.particles,
                row.bonds,
                row.threads,
                row.wall,
                row.wall * ns,
                row.processor * ns
            );
            rows.push(row);
        }
    }
    let mut text = format!(
        "# {}; least of {RUNS}\nwhat,particles,directed_bonds,threads,wall_s,processor_s\n",
        machine.sentence()
    );
    for r in &rows {
        let (wall, processor) = (r.wall, r.processor);
        let _ = writeln!(text, "{},{},{},{},{wall:.5},{processor:.5}", r.what, r.particles, r.bonds, r.threads);
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    std::fs::create_dir_all(&folder).expect("the folder of results");
    std::fs::write(folder.join("scaling.csv"), text).expect("room for the table");
    figure(&rows, &machine).draw().write_png(&folder.join("scaling.png")).expect("room for the picture");
}
