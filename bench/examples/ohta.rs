//! Ohta et al.'s Figs. 5 b and 6 c, ours: what a step costs with merging and without, and how far adaptive lattices are from the
//! uniform one. Writes `docs/ohta.png` and `docs/ohta.csv`.
//!
//!     cargo run --release -p fissure-bench --example ohta
//!
//! Times are the least of several runs of the same steps: the steps are the same to the bit, their times are not.

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use fissure_bench::machine::Machine;
use fissure_io::plot::{Curve, Figure, Panel};
use fissure_io::scene::Scene;
use fissure_io::simulation::Simulation;
use glam::{DVec3, Vec3};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Runs of which the least time of each step is taken.
const RUNS: usize = 3;
/// Steps in which the figure hangs whole: after the first, which builds, and before it is stretched.
const CALM: std::ops::Range<usize> = 2..12;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn simulation(name: &str, sets: &[&str]) -> Outcome<Simulation> {
    let path = root().join(format!("scenes/lattice/{name}.toml"));
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    let scene = Scene::load(&path, &sets)?;
    Ok(Simulation::build(&scene, &fissure_materials::registry(), &mut |_| ())?)
}

/// Milliseconds and nodes of each step of the figure that hangs by its head, for each of some settings in turn.
fn hung<const N: usize>(settings: [&[&str]; N], steps: usize) -> Outcome<[Vec<[f64; 2]>; N]> {
    let mut least: [_; N] = std::array::from_fn(|_| vec![[f64::INFINITY, 0.0]; steps]);
    for _ in 0..RUNS {
        for (sets, least) in settings.iter().zip(&mut least) {
            let mut simulation = simulation("hung", sets)?;
            for [time, nodes] in least {
                let start = Instant::now();
                simulation.step()?;
                *time = time.min(start.elapsed().as_secs_f64() * 1e3);
                *nodes = simulation.world.particles.len() as f64;
            }
        }
    }
    Ok(least)
}

/// Where the finest cells of the only body are, by the motion of their nodes [m].
fn cells(simulation: &mut Simulation) -> Vec<DVec3> {
    let body = &mut simulation.world.bodies[0];
    let mut rest: Vec<Vec3> = Vec::new();
    body.material.visit("", &mut |_, column, data| {
        if column.name == "cell_rest" {
            let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
            rest = data.bytes().chunks(12).map(|x| Vec3::new(number(x), number(&x[4..]), number(&x[8..]))).collect();
        }
    });
    let pose = body.material.lattice(&simulation.world.particles.of(&body.range)).expect("it is a lattice");
    let at = |(rest, &k): (&Vec3, &u32)| {
        let k = k as usize;
        pose.position[k] + pose.deformation[k] * (rest.as_dvec3() - pose.rest[k])
    };
    rest.iter().zip(pose.carrier).map(at).collect()
}

/// Mean and standard deviation after each step of how far cells are from where the uniform lattice has them, as shares of the
/// diagonal of the body's box, for each method.
fn dropped(methods: &[&str], steps: usize) -> Outcome<Vec<Vec<[f64; 2]>>> {
    let with = |method: &str| simulation("dropped", &[&format!("body.glob.material.method={method}")]);
    let mut uniform = with("lsm")?;
    let mut others = methods.iter().map(|m| with(m)).collect::<Outcome<Vec<_>>>()?;
    let at = cells(&mut uniform);
    let (low, high) = at.iter().fold((at[0], at[0]), |(low, high), &x| (low.min(x), high.max(x)));
    let diagonal = low.distance(high);
    let mut apart = vec![Vec::new(); methods.len()];
    for _ in 0..steps {
        uniform.step()?;
        let wanted = cells(&mut uniform);
        for (other, apart) in others.iter_mut().zip(&mut apart) {
            other.step()?;
            let off: Vec<f64> = cells(other).iter().zip(&wanted).map(|(a, b)| a.distance(*b) / diagonal).collect();
            let mean = off.iter().sum::<f64>() / off.len() as f64;
            let square = off.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / off.len() as f64;
            apart.push([mean, square.sqrt()]);
        }
    }
    Ok(apart)
}

fn curve(name: &str, colour: usize, rows: &[[f64; 2]], which: usize) -> Curve {
    let points = rows.iter().enumerate().map(|(k, row)| [k as f64 + 1.0, row[which]]).collect();
    Curve { name: name.into(), colour, points, ..Curve::default() }
}

fn main() -> Outcome<()> {
    let [uniform, keeping, merging] = hung(
        [&["body.figure.material.method=lsm"], &["body.figure.material.merge=no"], &["body.figure.material.merge=yes"]],
        240,
    )?;
    let fine = "body.figure.cells=18000";
    let large = hung([&[fine, "body.figure.material.method=lsm"], &[fine, "body.figure.material.levels=3"]], CALM.end)?;
    let apart = dropped(&["steinemann", "ohta"], 500)?;
    let panel = |title: &str, y: &str, curves| Panel {
        title: title.into(),
        x: "step".into(),
        y: y.into(),
        curves,
        ..Panel::default()
    };
    let hung = |which: usize| {
        vec![
            curve("uniform (LSM)", 0, &uniform, which),
            curve("without merging", 1, &keeping, which),
            curve("with merging", 2, &merging, which),
        ]
    };
    let off =
        |which| vec![curve("without beta (Steinemann)", 1, &apart[0], which), curve("with beta", 2, &apart[1], which)];
    let machine = Machine::here();
    let figure = Figure {
        title: machine.sentence(),
        panels: vec![
            panel("a figure is torn by its weight", "time of a step [ms]", hung(0)),
            panel("its nodes", "nodes", hung(1)),
            panel("a dropped glob, against LSM", "mean deviation over the diagonal", off(0)),
            panel("the same", "its standard deviation", off(1)),
        ],
    };
    let mut text = format!(
        "# {}\nstep,uniform_ms,keeping_ms,merging_ms,uniform_nodes,keeping_nodes,merging_nodes,",
        machine.sentence()
    );
    text += "without_beta,without_beta_deviation,with_beta,with_beta_deviation\n";
    for k in 0..apart[0].len() {
        let _ = write!(text, "{}", k + 1);
        for which in [0, 1] {
            for rows in [&uniform, &keeping, &merging] {
                text.push(',');
                if let Some(row) = rows.get(k) {
                    let _ = write!(text, "{:.4}", row[which]);
                }
            }
        }
        let _ =
            writeln!(text, ",{:.5},{:.5},{:.5},{:.5}", apart[0][k][0], apart[0][k][1], apart[1][k][0], apart[1][k][1]);
    }
    let mean = |rows: &[[f64; 2]], which: usize, from: usize| {
        rows[from..].iter().map(|row| row[which]).sum::<f64>() / (rows.len() - from) as f64
    };
    let calm = |rows: &[[f64; 2]]| mean(&rows[..CALM.end], 0, CALM.start);
    for (uniform, adaptive) in [(&uniform, &merging), (&large[0], &large[1])] {
        println!(
            "before the tear: uniform {:.0} nodes, {:.4} ms a step; adaptive {:.0} nodes, {:.4} ms; {:.1} times",
            uniform[CALM.start][1],
            calm(uniform),
            adaptive[CALM.start][1],
            calm(adaptive),
            calm(uniform) / calm(adaptive)
        );
    }
    for (name, rows) in [("uniform", &uniform), ("without merging", &keeping), ("with merging", &merging)] {
        println!(
            "{name}: {:.3} ms a step, {:.3} in the last quarter with {:.0} nodes",
            mean(rows, 0, 1),
            mean(rows, 0, 180),
            mean(rows, 1, 180)
        );
    }
    for (name, rows) in [("without β", &apart[0]), ("with β", &apart[1])] {
        let last = rows[rows.len() - 1];
        println!(
            "{name}: deviation {:.4} ± {:.4} after 500 steps, {:.4} ± {:.4} in the mean over them",
            last[0],
            last[1],
            mean(rows, 0, 0),
            mean(rows, 1, 0)
        );
    }
    std::fs::write(root().join("docs/ohta.csv"), text)?;
    figure.draw().write_png(&root().join("docs/ohta.png"))?;
    Ok(())
}
