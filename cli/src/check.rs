//! `fissure check`: what a run will be, before it is one.

use std::process::ExitCode;
use std::time::Instant;

use fissure_engine::{Life, Registry};
use fissure_io::checkpoint::Columns;
use fissure_io::scene::Scene;
use fissure_io::simulation::Simulation;
use serde_json::json;

use crate::Error;
use crate::args::CheckArgs;
use crate::info::called;
use crate::run::in_threads;
use crate::say::{counted, say};

/// Steps that are timed, and how long that may take at most [s]: the first is not counted, for it makes room.
const STEPS: u64 = 6;
const LONGEST: f64 = 5.0;

pub(crate) fn command(options: &CheckArgs, registry: &Registry) -> Result<ExitCode, Error> {
    in_threads(options.threads, || check(options, registry))
}

fn check(options: &CheckArgs, registry: &Registry) -> Result<ExitCode, Error> {
    let scene = Scene::load(&options.scene, &options.set)?;
    scene.check(registry)?;
    let start = Instant::now();
    let mut notes = Vec::new();
    let mut simulation = Simulation::build(&scene, registry, &mut |making| {
        notes.extend(making.notes.iter().map(|n| format!("body {}: {n}", making.body)));
    })?;
    let building = start.elapsed().as_secs_f64();
    let (mut frozen, mut live) = (0, 0);
    simulation.visit(&mut |_, column, data| {
        *(if column.life == Life::Live { &mut live } else { &mut frozen }) += data.bytes().len() as u64;
    });
    let world = &simulation.world;
    let (bodies, dt) = (world.bodies.len(), world.dt);
    let told: Vec<(String, usize, u64)> = (world.bodies.iter())
        .map(|b| (b.name.clone(), b.range.len(), b.material.bonds().map_or(0, |bonds| bonds.directed())))
        .collect();
    let relaxes = world.relaxes().is_some();
    let stable = if relaxes { f64::INFINITY } else { world.stable_dt() };
    let steps = ((scene.duration / dt).round() as u64).max(1);
    let frames = (scene.duration / scene.output.frame_every).round() as u64 + 1;
    let each = seconds_per_step(&mut simulation, steps)?;
    let expected = building + each * steps as f64;
    if options.json {
        let bodies: Vec<_> = told
            .iter()
            .map(|(name, particles, bonds)| json!({ "name": name, "particles": particles, "directed_bonds": bonds }))
            .collect();
        say!(
            "{}",
            json!({
                "scene": scene.file(), "bodies": bodies, "frozen_bytes": frozen, "live_bytes": live, "dt": dt,
                "stable_dt": stable.is_finite().then_some(stable), "steps": steps, "frames": frames, "notes": notes,
                "seconds_to_build": building, "seconds_per_step": each, "expected_seconds": expected,
            })
        );
        return Ok(ExitCode::SUCCESS);
    }
    say!("{}: {} with nothing wrong in it", called(&scene), counted(bodies, "body"));
    notes.iter().for_each(|n| say!("{n}"));
    for (name, particles, bonds) in &told {
        let per = *bonds as f64 / (*particles).max(1) as f64;
        match bonds {
            0 => say!("body {name}: {particles} nodes at the start"),
            _ => say!("body {name}: {particles} particles, {bonds} directed bonds ({per:.1} each)"),
        }
    }
    let mega = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    say!(
        "memory: {:.1} MiB of columns; on disk {:.1} MiB once, {:.1} MiB for each checkpoint",
        mega(frozen + live),
        mega(frozen),
        mega(live)
    );
    let how = if relaxes {
        "each an equilibrium".to_string()
    } else if stable.is_finite() {
        format!("{:.0} % of the stable {stable:.3e} s", 100.0 * dt / stable)
    } else {
        "which nothing limits".to_string()
    };
    say!("{steps} steps of {dt:.3e} s, {how}; {frames} frames");
    say!(
        "built in {building:.1} s, {:.2} ms a step at the start: about {} in all, more where much breaks and touches",
        1e3 * each,
        in_clock(expected)
    );
    if dt > stable {
        say!("warning: dt = {dt:.3e} s is above the stable step of {stable:.3e} s; the run will probably be stopped");
    }
    Ok(ExitCode::SUCCESS)
}

/// The least time [s] of a few steps.
fn seconds_per_step(simulation: &mut Simulation, steps: u64) -> Result<f64, Error> {
    let (start, mut least) = (Instant::now(), f64::INFINITY);
    for k in 0..STEPS.min(steps) {
        let step = Instant::now();
        simulation.step().map_err(|e| Error::Usage(e.to_string()))?;
        let took = step.elapsed().as_secs_f64();
        least = if k <= 1 { took } else { least.min(took) };
        if start.elapsed().as_secs_f64() > LONGEST {
            break;
        }
    }
    Ok(least)
}

fn in_clock(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
