//! `fissure run` and `fissure resume`: the loop around the step.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use fissure_engine::{Collider, Kind, Motion, Parameter, Phase, Reaction, Registry, StepError};
use fissure_io::checkpoint::{About, Store};
use fissure_io::compare::Comparison;
use fissure_io::frames::Frame;
use fissure_io::scene::{Chosen, Scene};
use fissure_io::simulation::Simulation;
use serde_json::json;

use crate::args::RunArgs;
use crate::compare::compare;
use crate::info::called;
use crate::log::Log;
use crate::progress::Progress;
use crate::render::{picture, view, whole_frame};
use crate::say::counted;
use crate::{Error, RunFolder};

/// Set by Ctrl-C.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// How to run, for callers from code.
#[derive(Clone, Debug, Default)]
pub struct RunOptions {
    /// Stop at this simulated time [s].
    pub until: Option<f64>,
    /// Number of threads; all by default.
    pub threads: Option<usize>,
    /// Keys of the scene to change, `key=value`.
    pub set: Vec<String>,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The scene's duration is done.
    Finished,
    /// Stopped on the way, with a checkpoint to go on from.
    Stopped,
}

impl RunOptions {
    fn quiet(&self) -> RunArgs {
        RunArgs { until: self.until, threads: self.threads, set: self.set.clone(), quiet: true, json: false }
    }
}

/// Runs the scene file `scene` into the folder `out`, without a word.
///
/// # Errors
/// See [`Error`]. If the scene cannot be built, no folder is left.
pub fn run(scene: &Path, out: &Path, options: &RunOptions, registry: &Registry) -> Result<Outcome, Error> {
    in_threads(options.threads, || start(scene, out, &options.quiet(), registry))
}

/// Goes on with the run in the folder `dir`, without a word.
///
/// # Errors
/// See [`Error`].
pub fn resume(dir: &Path, options: &RunOptions, registry: &Registry) -> Result<Outcome, Error> {
    in_threads(options.threads, || go_on(dir, &options.quiet(), registry))
}

pub(crate) fn command(
    scene: &Path,
    out: Option<PathBuf>,
    options: &RunArgs,
    registry: &Registry,
) -> Result<ExitCode, Error> {
    let out = out.unwrap_or_else(|| RunFolder::default_for(scene));
    catch_interrupt();
    let outcome = in_threads(options.threads, || start(scene, &out, options, registry))?;
    Ok(exit_code(outcome))
}

pub(crate) fn resume_command(dir: &Path, options: &RunArgs, registry: &Registry) -> Result<ExitCode, Error> {
    catch_interrupt();
    let outcome = in_threads(options.threads, || go_on(dir, options, registry))?;
    Ok(exit_code(outcome))
}

fn exit_code(outcome: Outcome) -> ExitCode {
    match outcome {
        Outcome::Stopped if INTERRUPTED.load(Ordering::Relaxed) => ExitCode::from(130),
        _ => ExitCode::SUCCESS,
    }
}

fn catch_interrupt() {
    // a second handler in one process is refused; the first does the same
    let _ = ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::Relaxed));
}

fn in_threads<T: Send>(threads: Option<usize>, work: impl FnOnce() -> Result<T, Error> + Send) -> Result<T, Error> {
    if threads == Some(0) {
        return Err(Error::Usage("--threads must be 1 or more".into()));
    }
    // rayon would take fewer without a word
    let most = rayon::max_num_threads();
    if threads.is_some_and(|n| n > most) {
        return Err(Error::Usage(format!("--threads must be {most} or less")));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build();
    pool.map_err(|e| Error::Usage(format!("threads cannot be started: {e}; try --threads 1")))?.install(work)
}

fn start(path: &Path, out: &Path, options: &RunArgs, registry: &Registry) -> Result<Outcome, Error> {
    let scene = Scene::load(path, &options.set)?;
    scene.check(registry)?;
    until(&scene, options)?;
    let folder = RunFolder::create(out)?;
    let mut notes = Vec::new();
    let built = Simulation::build(&scene, registry, &mut |making| {
        notes.extend(making.notes.iter().map(|n| format!("body {}: {n}", making.body)));
        notes.push(format!(
            "body {}: tetrahedra in {:.2} s, families in {:.2} s",
            making.body,
            making.meshing.as_secs_f64(),
            making.families.as_secs_f64()
        ));
    });
    let compared = built.map_err(Error::from).and_then(|mut simulation| {
        let comparison = Comparison::new(&scene, folder.dir(), &mut simulation)?;
        Ok((simulation, comparison))
    });
    let (simulation, comparison) = match compared {
        Ok(both) => both,
        Err(error) => {
            folder.give_up();
            return Err(error);
        }
    };
    let log = Log::open(&folder.log(), options)?;
    folder.keep_scene(&scene)?;
    comparison.keep_references(folder.dir()).map_err(Error::write(folder.dir()))?;
    let mut driver = Driver::new(folder, log, scene, simulation, comparison, options)?;
    driver.introduce(&notes, registry)?;
    driver.comparison.sample(&mut driver.simulation);
    let about = driver.about();
    driver.store.write_frozen(&mut driver.simulation, &about)?;
    driver.frame()?;
    driver.checkpoint()?;
    driver.go()
}

fn go_on(dir: &Path, options: &RunArgs, registry: &Registry) -> Result<Outcome, Error> {
    if !options.set.is_empty() {
        return Err(Error::Usage(
            "--set cannot change a run that was begun; start a new one with `fissure run`".into(),
        ));
    }
    let folder = RunFolder::open(dir)?;
    let scene = Scene::load(&folder.scene(), &[])?;
    let until = until(&scene, options)?;
    let mut log = Log::open(&folder.log(), options)?;
    let latest = folder.store(scene.output.keep)?.latest_complete()?;
    let mut simulation = Simulation::restore(&scene, registry, &latest)?;
    let mut comparison = Comparison::new(&scene, folder.dir(), &mut simulation)?;
    comparison.restore(folder.dir(), &simulation);
    latest.skipped.iter().for_each(|e| log.say(&format!("passed over: {e}")));
    if edited(&scene, &latest.live.about().scene) {
        log.say("scene.toml was edited after the checkpoint: what follows is of the edited scene, on the old mesh");
    }
    let mut driver = Driver::new(folder, log, scene, simulation, comparison, options)?;
    let (step, time) = (driver.simulation.world.step, driver.simulation.world.time);
    let what = format!("{} ({})", called(&driver.scene), dir.display());
    if step >= driver.last {
        driver.log.say(&format!("{what} is finished: step {step}, time {time:.6} s"));
        return Ok(Outcome::Finished);
    }
    if step > driver.stop {
        let sentence =
            format!("--until {until} is past: {} is at {time:.6} s already; give a later time", dir.display());
        return Err(Error::Usage(sentence));
    }
    driver.log.say(&format!("resumed {what} at step {step}, time {time:.6} s"));
    driver.go()
}

/// Whether the scene means something else than the text that a checkpoint keeps.
fn edited(scene: &Scene, kept: &str) -> bool {
    let kept = Scene::parse(kept, Path::new(scene.file()), &[]);
    kept.map_or(true, |kept| kept.fingerprint() != scene.fingerprint())
}

fn until(scene: &Scene, options: &RunArgs) -> Result<f64, Error> {
    match options.until {
        Some(t) if !(t > 0.0 && t.is_finite()) => Err(Error::Usage(format!("--until {t} must be above 0 [s]"))),
        Some(t) => Ok(t.min(scene.duration)),
        None => Ok(scene.duration),
    }
}

/// A run in progress.
struct Driver {
    folder: RunFolder,
    scene: Scene,
    simulation: Simulation,
    comparison: Comparison,
    store: Store,
    log: Log,
    options: RunArgs,
    /// Steps of the whole scene, of this call, between frames and between checkpoints.
    last: u64,
    stop: u64,
    frame_steps: u64,
    checkpoint_steps: u64,
    spent: Spent,
}

/// Where the time went outside the world's phases.
#[derive(Default)]
struct Spent {
    surface: Duration,
    frames: Duration,
    checkpoints: Duration,
    picture: Duration,
}

impl Driver {
    fn new(
        folder: RunFolder,
        log: Log,
        scene: Scene,
        mut simulation: Simulation,
        comparison: Comparison,
        options: &RunArgs,
    ) -> Result<Self, Error> {
        simulation.world.interrupt = Some(&INTERRUPTED);
        let dt = simulation.world.dt;
        let steps = |time: f64| ((time / dt).round() as u64).max(1);
        let store = folder.store(scene.output.keep)?;
        Ok(Self {
            last: steps(scene.duration),
            stop: steps(until(&scene, options)?),
            frame_steps: steps(scene.output.frame_every),
            checkpoint_steps: steps(scene.output.checkpoint_every),
            folder,
            scene,
            simulation,
            comparison,
            store,
            log,
            options: options.clone(),
            spent: Spent::default(),
        })
    }

    fn about(&self) -> About {
        About {
            step: self.simulation.world.step,
            time: self.simulation.world.time,
            scene: self.scene.text().into(),
            program: format!("fissure {}", env!("CARGO_PKG_VERSION")),
            notes: Vec::new(),
        }
    }

    fn introduce(&mut self, notes: &[String], registry: &Registry) -> Result<(), Error> {
        let scene = &self.scene;
        self.log.say(&format!("{} ({}), into {}", called(scene), scene.file(), self.folder.dir().display()));
        notes.iter().for_each(|n| self.log.say(n));
        for k in 0..self.simulation.world.bodies.len() {
            let body = &self.simulation.world.bodies[k];
            let told = &self.scene.bodies[k];
            let bonds = body.material.bonds().map_or(0, |b| b.directed());
            let described = |law: &Chosen, criterion: &Chosen| {
                let entry = registry.entry(&law.name).map_err(|e| self.scene.blame(&body.name, &e))?;
                let known = entry.criteria.iter().find(|c| c.name == criterion.name);
                let (material, limits) = (chosen(law, entry.parameters), known.map_or(&[][..], |c| c.parameters));
                Ok::<_, Error>(format!("{material}; fracture {}", chosen(criterion, limits)))
            };
            let material = described(&told.law, &told.criterion)?;
            let sentence = format!(
                "body {}: {} particles, {bonds} directed bonds ({:.1} each), spacing {:.3e} m, horizon {:.3e} m; {material}",
                body.name,
                body.range.len(),
                bonds as f64 / body.range.len().max(1) as f64,
                body.spacing,
                body.horizon
            );
            self.log.say(&sentence);
            for part in &told.parts {
                let density = part.density;
                let made = described(&part.law, &part.criterion)?;
                self.log.say(&format!("  region {}: {density} kg/m³, {made}", part.name));
            }
        }
        let world = &self.simulation.world;
        for c in world.colliders.iter() {
            self.log.say(&format!("collider {}", described(c)));
        }
        let c = &world.contact;
        let how = if world.relaxes().is_some() {
            "none while every step is an equilibrium".into()
        } else if c.between {
            format!("friction {}, restitution {}, stiffness {}", c.friction, c.restitution, c.stiffness)
        } else {
            "off".into()
        };
        self.log.say(&format!("contact between particles: {how}"));
        let dt = self.simulation.world.dt;
        let relax = self.simulation.world.relaxes();
        let how = match relax {
            _ if self.scene.dt.is_some() => "as given",
            Some(_) => "one a frame",
            None => "from the stable step",
        };
        let integrator = self.scene.integrator.name();
        self.log.say(&format!("{} steps of {dt:.3e} s ({how}), {integrator}", self.last));
        if let Some(relax) = relax {
            let sentence = format!(
                "every step is an equilibrium: unbalanced force below {:.1e} of the load, in at most {} iterations",
                relax.residual, relax.iterations
            );
            self.log.say(&sentence);
            return Ok(());
        }
        let stable = self.simulation.world.stable_dt();
        if dt > stable {
            self.log
                .say(&format!("warning: this is {:.1} times the longest stable step of {stable:.3e} s", dt / stable));
        }
        Ok(())
    }

    /// Steps until the end, an interrupt or an error.
    fn go(&mut self) -> Result<Outcome, Error> {
        let start = Instant::now();
        let first = self.simulation.world.step;
        let bonds = self.simulation.world.bond_counts().0;
        let mut progress = Progress::new(&self.options, first, self.stop, bonds);
        while self.simulation.world.step < self.stop {
            if INTERRUPTED.load(Ordering::Relaxed) {
                break;
            }
            let before = (Instant::now(), self.simulation.world.profile.total());
            if let Err(error) = self.simulation.step() {
                if matches!(error, StepError::Interrupted { .. }) {
                    break;
                }
                progress.finish();
                self.log.tell(&error.to_string(), &json!({ "event": "error", "text": error.to_string() }));
                let checkpoint = self.checkpoint()?;
                return Err(Error::Step { error, checkpoint });
            }
            let phases = self.simulation.world.profile.total() - before.1;
            self.spent.surface += before.0.elapsed().saturating_sub(phases);
            self.comparison.sample(&mut self.simulation);
            let step = self.simulation.world.step;
            progress.step(step, self.simulation.world.time);
            if step.is_multiple_of(self.frame_steps) {
                self.frame()?;
            }
            if step.is_multiple_of(self.checkpoint_steps) {
                self.checkpoint()?;
            }
        }
        progress.finish();
        let step = self.simulation.world.step;
        if !step.is_multiple_of(self.checkpoint_steps) {
            self.checkpoint()?;
        }
        let outcome = if step >= self.last { Outcome::Finished } else { Outcome::Stopped };
        if outcome == Outcome::Finished {
            self.draw()?;
            if let Some((table, event)) = compare(&self.comparison, &self.folder)? {
                self.log.close(&table, &event);
            }
        }
        self.conclude(outcome, start.elapsed(), step - first);
        Ok(outcome)
    }

    fn frame(&mut self) -> Result<(), Error> {
        let start = Instant::now();
        let number = (self.simulation.world.step / self.frame_steps) as u32;
        let frame = self.simulation.frame(number);
        self.spent.surface += start.elapsed();
        let start = Instant::now();
        self.folder.frames().write(&frame)?;
        let colliders = self.simulation.collider_frame(number);
        if !colliders.positions.is_empty() {
            self.folder.colliders().write(&colliders)?;
        }
        self.spent.frames += start.elapsed();
        self.report(&frame);
        self.comparison.sample_energies(&mut self.simulation);
        Ok(())
    }

    fn report(&mut self, frame: &Frame) {
        let world = &mut self.simulation.world;
        let energies = world.energies();
        let (bonds, broken) = world.bond_counts();
        let pieces = frame.piece.iter().max().map_or(0, |p| p + 1);
        let sentence = format!(
            "frame {}: step {}, t = {:.6} s, kinetic {:.4e} J, elastic {:.4e} J, gravity {:.4e} J, {} of {} bonds broken, {}",
            frame.number,
            world.step,
            world.time,
            energies.kinetic,
            energies.elastic,
            energies.gravity,
            broken / 2,
            bonds / 2,
            counted(pieces as usize, "fragment")
        );
        let sentence = if world.relaxes().is_some() && world.step > 0 {
            let relaxed = world.relaxed;
            let (n, residual) = (relaxed.iterations, relaxed.residual);
            let rounding = if relaxed.at_rounding { " (rounding)" } else { "" };
            format!("{sentence}, equilibrium in {n} iterations to {residual:.1e}{rounding} of the load")
        } else {
            sentence
        };
        let event = json!({
            "iterations": world.relaxed.iterations, "residual": world.relaxed.residual,
            "event": "frame", "frame": frame.number, "step": world.step, "time": world.time,
            "kinetic": energies.kinetic, "elastic": energies.elastic, "gravity": energies.gravity,
            "bonds": bonds / 2, "broken": broken / 2, "fragments": pieces,
        });
        self.log.tell(&sentence, &event);
    }

    fn checkpoint(&mut self) -> Result<PathBuf, Error> {
        let start = Instant::now();
        self.comparison.save(self.folder.dir()).map_err(Error::write(self.folder.dir()))?;
        let about = self.about();
        let written = self.store.write_live(&mut self.simulation, &about)?;
        self.spent.checkpoints += start.elapsed();
        Ok(written.path)
    }

    /// The picture of the last frame.
    fn draw(&mut self) -> Result<(), Error> {
        let start = Instant::now();
        let frames = self.folder.frames();
        if let Some(&number) = frames.numbers()?.last() {
            picture(&whole_frame(&self.folder, number)?, &view(&self.scene), &self.folder.picture())?;
        }
        self.spent.picture = start.elapsed();
        Ok(())
    }

    /// The closing lines.
    fn conclude(&mut self, outcome: Outcome, wall: Duration, steps: u64) {
        let pieces = self.simulation.fragments().1;
        let world = &mut self.simulation.world;
        let reactions = if world.anchors.is_empty() { Vec::new() } else { world.reactions() };
        let (bonds, broken) = world.bond_counts();
        let dir = self.folder.dir().display().to_string();
        let (seconds, n) = (wall.as_secs_f64(), steps.max(1) as f64);
        let per_bond = world.profile.total().as_secs_f64() / n / bonds.max(1) as f64 * 1e9;
        let how = match outcome {
            Outcome::Finished => format!("finished at step {}, time {:.6} s", world.step, world.time),
            Outcome::Stopped => {
                format!("stopped at step {}, time {:.6} s; go on with `fissure resume {dir}`", world.step, world.time)
            }
        };
        let mut parts: Vec<(String, Duration)> =
            Phase::ALL.iter().map(|&p| (p.name().to_string(), world.profile.spent(p))).collect();
        let spent = &self.spent;
        parts.push(("surface".into(), spent.surface));
        parts.push(("frames".into(), spent.frames));
        parts.push(("checkpoints".into(), spent.checkpoints));
        parts.push(("picture".into(), spent.picture));
        let share = |d: Duration| 100.0 * d.as_secs_f64() / seconds.max(1e-9);
        let shares: Vec<String> =
            parts.iter().filter(|p| share(p.1) >= 0.05).map(|p| format!("{} {:.1} %", p.0, share(p.1))).collect();
        let event = json!({
            "event": "end", "outcome": format!("{outcome:?}").to_lowercase(), "step": world.step, "time": world.time,
            "seconds": seconds, "ns_per_bond": per_bond, "bonds": bonds / 2, "broken": broken / 2, "fragments": pieces,
            "reactions": reactions.iter().map(told).collect::<Vec<_>>(),
            "spent": parts.iter().map(|p| (p.0.clone(), p.1.as_secs_f64().into())).collect::<serde_json::Map<_, _>>(),
        });
        let mut lines = vec![
            how,
            format!(
                "{steps} steps in {seconds:.1} s, {:.3} ms a step, {per_bond:.2} ns per directed bond",
                1e3 * seconds / n
            ),
            format!("time: {}", shares.join(", ")),
            format!("{} of {} bonds broken, {}", broken / 2, bonds / 2, counted(pieces, "fragment")),
        ];
        lines.extend(reactions.iter().map(sentence));
        self.log.close(&lines.join("\n"), &event);
    }
}

/// A collider in words.
fn described(c: &Collider) -> String {
    let motion = match &c.motion {
        Motion::Fixed => "fixed".into(),
        Motion::Keyframes(frames) => format!("moved along {}", counted(frames.len(), "keyframe")),
        Motion::Free { mass, .. } => format!("free, {mass:.4e} kg"),
    };
    format!("{}: {}, {motion}, friction {}, restitution {}", c.name, c.shape.name(), c.friction, c.restitution)
}

/// What holding takes, for people.
fn sentence(r: &Reaction) -> String {
    let list = |v: glam::DVec3| v.to_array().map(|x| format!("{x:.4e}")).join(", ");
    let (force, torque, centre) = (list(r.force), list(r.torque), list(r.centre));
    format!("anchor {}: holding takes a force of ({force}) N and a torque of ({torque}) N m about ({centre})", r.anchor)
}

/// What holding takes, for programs.
fn told(r: &Reaction) -> serde_json::Value {
    let (force, torque, centre) = (r.force.to_array(), r.torque.to_array(), r.centre.to_array());
    json!({ "anchor": r.anchor, "force": force, "torque": torque, "about": centre })
}

/// A law or criterion with what the scene gives and what it leaves at its default.
fn chosen(chosen: &Chosen, parameters: &[Parameter]) -> String {
    let value = |p: &Parameter| match (chosen.given.iter().find(|g| g.key == p.name), p.kind) {
        (Some(given), _) => Some(format!("{} {}", p.name, given.value)),
        (None, Kind::NumberOr(_, default)) => Some(format!("{} {default}", p.name)),
        (None, Kind::Word(words)) => Some(format!("{} {}", p.name, words[0])),
        (None, _) => None,
    };
    let values: Vec<String> = parameters.iter().filter_map(value).collect();
    if values.is_empty() { chosen.name.clone() } else { format!("{} ({})", chosen.name, values.join(", ")) }
}
