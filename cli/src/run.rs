//! `fissure run` and `fissure resume`: the loop around the step.

mod driver;
mod saver;
mod streams;
mod words;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use fissure_engine::Registry;
use fissure_io::atomic::sweep;
use fissure_io::compare::Comparison;
use fissure_io::diff::scenes;
use fissure_io::scene::Scene;
use fissure_io::simulation::Simulation;

use self::driver::{Driver, about};
use crate::args::RunArgs;
use crate::info::called;
use crate::log::Log;
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
    /// Resume although the scene was changed since the checkpoint.
    pub force: bool,
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
        RunArgs { until: self.until, threads: self.threads, set: self.set.clone(), quiet: true, ..RunArgs::default() }
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
    in_threads(options.threads, || go_on(dir, options.force, &options.quiet(), registry))
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

pub(crate) fn resume_command(
    dir: &Path,
    force: bool,
    options: &RunArgs,
    registry: &Registry,
) -> Result<ExitCode, Error> {
    catch_interrupt();
    let outcome = in_threads(options.threads, || go_on(dir, force, options, registry))?;
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

pub(crate) fn in_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, Error> + Send,
) -> Result<T, Error> {
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
        let meshing = making.meshing.as_secs_f64();
        notes.push(match making.families {
            Some(took) => {
                format!("body {}: tetrahedra in {meshing:.2} s, families in {:.2} s", making.body, took.as_secs_f64())
            }
            None => format!("body {}: cells in {meshing:.2} s", making.body),
        });
    });
    let compared = built.map_err(Error::from).and_then(|mut simulation| {
        let comparison = Comparison::new(&scene, folder.dir(), &mut simulation)?;
        Ok((simulation, comparison))
    });
    let (mut simulation, comparison) = match compared {
        Ok(both) => both,
        Err(error) => {
            folder.give_up();
            return Err(error);
        }
    };
    let log = Log::open(&folder.log(), options)?;
    folder.keep_scene(&scene)?;
    comparison.keep_references(folder.dir()).map_err(Error::write(folder.dir()))?;
    let mut store = folder.store(scene.output.keep)?;
    let about = about(&scene, &simulation, &[]);
    store.write_frozen(&mut simulation, &about)?;
    let mut driver = Driver::new(folder, log, scene, simulation, comparison, store, options)?;
    driver.introduce(&notes, registry)?;
    driver.begin()?;
    driver.go()
}

fn go_on(dir: &Path, force: bool, options: &RunArgs, registry: &Registry) -> Result<Outcome, Error> {
    if !options.set.is_empty() {
        return Err(Error::Usage(
            "--set cannot change a run that was begun; start a new one with `fissure run`".into(),
        ));
    }
    let folder = RunFolder::open(dir)?;
    let scene = Scene::load(&folder.scene(), &[])?;
    let until = until(&scene, options)?;
    let mut log = Log::open(&folder.log(), options)?;
    // the log is held, so nobody writes here
    [folder.dir(), folder.frames().folder(), folder.particles().folder(), folder.colliders().folder()]
        .into_iter()
        .for_each(sweep);
    let store = folder.store(scene.output.keep)?;
    let latest = store.latest_complete()?;
    let kept = latest.live.about();
    let mut notes = kept.notes.clone();
    if let Some(changed) = changed(&scene, &kept.scene)? {
        if !force {
            return Err(Error::Changed { dir: dir.into(), keys: changed });
        }
        log.say(&format!("the scene was changed after the checkpoint, and goes on changed on the old mesh: {changed}"));
        notes.push((format!("scene changed at step {}", kept.step), changed));
    }
    let mut simulation = Simulation::restore(&scene, registry, &latest)?;
    let mut comparison = Comparison::new(&scene, folder.dir(), &mut simulation)?;
    comparison.restore(folder.dir(), &simulation);
    latest.skipped.iter().for_each(|e| log.say(&format!("passed over: {e}")));
    let mut driver = Driver::new(folder, log, scene, simulation, comparison, store, options)?;
    driver.go_on_from(notes)?;
    let (step, time) = (driver.simulation.world.step, driver.simulation.world.time);
    let what = format!("{} ({})", called(&driver.scene), dir.display());
    if step >= driver.last {
        if !driver.folder.picture().exists() {
            driver.finish()?; // it was killed between its last checkpoint and its end
        }
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

/// How the scene differs from the text that a checkpoint keeps, key by key; nothing if both mean the same.
fn changed(scene: &Scene, kept: &str) -> Result<Option<String>, Error> {
    let path = Path::new(scene.file());
    if Scene::parse(kept, path, &[]).is_ok_and(|kept| kept.fingerprint() == scene.fingerprint()) {
        return Ok(None);
    }
    let keys = scenes([kept, scene.text()], [Path::new("the checkpoint's scene"), path])?;
    Ok(Some(match &keys[..] {
        [] => "files that it names".into(),
        keys => keys.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "),
    }))
}

fn until(scene: &Scene, options: &RunArgs) -> Result<f64, Error> {
    match options.until {
        Some(t) if !(t > 0.0 && t.is_finite()) => Err(Error::Usage(format!("--until {t} must be above 0 [s]"))),
        Some(t) => Ok(t.min(scene.duration)),
        None => Ok(scene.duration),
    }
}
