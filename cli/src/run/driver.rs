//! The loop around the step.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use fissure_engine::{Energies, NodeCounts, Phase, StepError};
use fissure_io::checkpoint::{About, Store};
use fissure_io::compare::Comparison;
use fissure_io::export::Shot;
use fissure_io::frames::Frame;
use fissure_io::scene::{OnFailure, Scene};
use fissure_io::series;
use fissure_io::simulation::Simulation;
use serde_json::json;

use super::saver::Saver;
use super::streams::{self, Streams};
use super::words::in_words;
use super::{INTERRUPTED, Outcome, until};
use crate::args::RunArgs;
use crate::compare::compare;
use crate::log::Log;
use crate::progress::Progress;
use crate::render::{picture, preview, view, whole_frame};
use crate::say::counted;
use crate::{Error, RunFolder};

/// A run in progress.
pub(super) struct Driver {
    pub folder: RunFolder,
    pub scene: Scene,
    pub simulation: Simulation,
    comparison: Comparison,
    saver: Saver,
    streams: Streams,
    pub log: Log,
    /// What checkpoints say of themselves beside the scene.
    notes: Vec<(String, String)>,
    /// The last checkpoint: its step, and when it was made.
    saved: (Option<u64>, Instant),
    options: RunArgs,
    /// Steps of the whole scene, of this call, between frames and between checkpoints.
    pub last: u64,
    pub stop: u64,
    frame_steps: u64,
    checkpoint_steps: u64,
    pub spent: Spent,
    /// The same and the phases of the world, as of the last frame.
    told: Vec<(&'static str, Duration)>,
}

/// Where the time went outside the world's phases.
#[derive(Default)]
pub(super) struct Spent {
    pub surface: Duration,
    pub frames: Duration,
    pub checkpoints: Duration,
    pub picture: Duration,
}

impl Driver {
    pub fn new(
        folder: RunFolder,
        log: Log,
        scene: Scene,
        mut simulation: Simulation,
        comparison: Comparison,
        store: Store,
        options: &RunArgs,
    ) -> Result<Self, Error> {
        simulation.world.interrupt = Some(&INTERRUPTED);
        let dt = simulation.world.dt;
        let steps = |time: f64| ((time / dt).round() as u64).max(1);
        Ok(Self {
            last: steps(scene.duration),
            stop: steps(until(&scene, options)?),
            frame_steps: steps(scene.output.frame_every),
            checkpoint_steps: scene.output.checkpoint_steps.unwrap_or_else(|| steps(scene.output.checkpoint_every)),
            folder,
            scene,
            simulation,
            comparison,
            saver: Saver::new(store).map_err(|e| Error::Usage(format!("threads cannot be started: {e}")))?,
            streams: Streams::default(),
            notes: Vec::new(),
            saved: (None, Instant::now()),
            log,
            options: options.clone(),
            spent: Spent::default(),
            told: Vec::new(),
        })
    }

    /// The first frame and the first checkpoint of a new run.
    pub fn begin(&mut self) -> Result<(), Error> {
        self.stream(0)?;
        self.comparison.sample(&mut self.simulation);
        self.frame()?;
        self.checkpoint()?;
        self.settle().map(|_| ())
    }

    /// The state is that of a checkpoint, which had these notes.
    ///
    /// # Errors
    /// A series or an export that cannot be taken back to it.
    pub fn go_on_from(&mut self, notes: Vec<(String, String)>) -> Result<(), Error> {
        let series = self.folder.series();
        series::rewind(&series, self.simulation.world.step).map_err(Error::write(series))?;
        self.notes = notes;
        self.notes.retain(|(key, _)| !key.starts_with(ENERGY));
        self.saved.0 = Some(self.simulation.world.step);
        self.stream((self.simulation.world.step / self.frame_steps) as u32 + 1)
    }

    /// Opens the exports for frames from `from` on.
    fn stream(&mut self, from: u32) -> Result<(), Error> {
        let about = crate::export::about(&self.scene, self.frame_steps as f64 * self.simulation.world.dt);
        self.streams = Streams::open(&self.scene.output.export, &self.folder, &about, from)?;
        Ok(())
    }

    /// Steps until the end, an interrupt or an error.
    pub fn go(&mut self) -> Result<Outcome, Error> {
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
                self.checkpoint()?;
                let checkpoint = self.settle()?.unwrap_or_else(|| self.folder.dir().into());
                return Err(Error::Step { error, checkpoint });
            }
            let phases = self.simulation.world.profile.total() - before.1;
            self.spent.surface += before.0.elapsed().saturating_sub(phases);
            self.comparison.sample(&mut self.simulation);
            let step = self.simulation.world.step;
            progress.step(step, self.simulation.world.time);
            if step.is_multiple_of(self.frame_steps) {
                let written = self.frame();
                self.tolerate(written)?;
            }
            let waited = self.saved.1.elapsed().as_secs_f64() / 60.0;
            let long = self.scene.output.checkpoint_minutes.is_some_and(|minutes| waited >= minutes);
            if long || step.is_multiple_of(self.checkpoint_steps) {
                let written = self.checkpoint();
                self.tolerate(written)?;
            }
        }
        progress.finish();
        let step = self.simulation.world.step;
        if self.saved.0 != Some(step) {
            let before = self.checkpoint();
            self.tolerate(before)?;
        }
        self.settle()?; // without the last one the run could not be gone on with
        let outcome = if step >= self.last { Outcome::Finished } else { Outcome::Stopped };
        if outcome == Outcome::Finished {
            self.finish()?;
        }
        self.conclude(outcome, start.elapsed(), step - first);
        Ok(outcome)
    }

    /// What follows the last checkpoint: comparisons, and last of all the picture, by which a run is known to be whole.
    pub fn finish(&mut self) -> Result<(), Error> {
        if let Some((table, event)) = compare(&self.comparison, &self.folder)? {
            self.log.close(&table, &event);
        }
        streams::whole(&self.scene, &self.folder)?;
        self.draw()
    }

    fn frame(&mut self) -> Result<(), Error> {
        let start = Instant::now();
        let number = (self.simulation.world.step / self.frame_steps) as u32;
        let frame = self.simulation.frame(number);
        let particles = self.scene.output.particles.then(|| self.simulation.particle_frame(number));
        self.spent.surface += start.elapsed();
        let start = Instant::now();
        self.folder.frames().write(&frame)?;
        if let Some(particles) = &particles {
            self.folder.particles().write_particles(particles)?;
        }
        let colliders = self.simulation.collider_frame(number);
        if !colliders.positions.is_empty() {
            self.folder.colliders().write(&colliders)?;
        }
        let tets = self.streams.tets.then(|| self.simulation.tet_frame(number));
        self.streams.frame(&Shot {
            surface: &frame,
            colliders: Some(&colliders).filter(|c| !c.positions.is_empty()),
            particles: particles.as_ref(),
            tets: tets.as_ref().filter(|t| !t.tets.is_empty()),
        })?;
        self.spent.frames += start.elapsed();
        if self.options.preview {
            let start = Instant::now();
            preview(&self.folder, &self.scene, number)?;
            self.spent.picture += start.elapsed();
        }
        self.report(&frame)?;
        self.comparison.sample_energies(&mut self.simulation);
        Ok(())
    }

    fn report(&mut self, frame: &Frame) -> Result<(), Error> {
        let world = &mut self.simulation.world;
        let energies = world.energies();
        let (bonds, broken) = world.bond_counts();
        let pieces = frame.pieces();
        let mut sentence = format!(
            "frame {}: step {}, t = {:.6} s, kinetic {:.4e} J, elastic {:.4e} J, gravity {:.4e} J, ",
            frame.number, world.step, world.time, energies.kinetic, energies.elastic, energies.gravity,
        );
        if bonds > 0 {
            sentence += &format!("{} of {} bonds broken, ", broken / 2, bonds / 2);
        }
        sentence += &counted(pieces, "fragment");
        let nodes: Vec<(&str, NodeCounts)> =
            world.bodies.iter().filter_map(|b| Some((b.name.as_str(), b.material.nodes()?))).collect();
        for (name, nodes) in &nodes {
            sentence += &format!(", body {name} {}", in_words(nodes));
        }
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
            "nodes": nodes.iter().map(|(name, n)| (name.to_string(), n.levels.clone().into())).collect::<serde_json::Map<_, _>>(),
        });
        self.log.tell(&sentence, &event);
        let mut row = vec![
            ("frame", f64::from(frame.number)),
            ("step", world.step as f64),
            ("time", world.time),
            ("kinetic", energies.kinetic),
            ("elastic", energies.elastic),
            ("gravity", energies.gravity),
            ("particles", world.particles.len() as f64),
            ("bonds", (bonds / 2) as f64),
            ("broken", (broken / 2) as f64),
            ("fragments", pieces as f64),
        ];
        let now = self.spent_until_now();
        let before = self.told.iter().map(|(_, spent)| *spent).chain(std::iter::repeat(Duration::ZERO));
        row.extend(now.iter().zip(before).map(|((name, now), before)| (*name, (*now - before).as_secs_f64())));
        self.told = now;
        let path = self.folder.series();
        series::append(&path, &row).map_err(Error::write(path))
    }

    /// Wall time in each phase of the step, and outside.
    fn spent_until_now(&self) -> Vec<(&'static str, Duration)> {
        let (profile, spent) = (&self.simulation.world.profile, &self.spent);
        let phases = Phase::ALL.map(|phase| (SECONDS[phase as usize], profile.spent(phase)));
        let outside = [("s_surface", spent.surface), ("s_frames", spent.frames), ("s_checkpoints", spent.checkpoints)];
        phases.into_iter().chain(outside).collect()
    }

    /// Starts a checkpoint; an error may be that of the one before.
    fn checkpoint(&mut self) -> Result<(), Error> {
        let start = Instant::now();
        self.saved = (Some(self.simulation.world.step), start);
        let mut about = about(&self.scene, &self.simulation, &self.notes);
        let Energies { kinetic, elastic, gravity } = self.simulation.world.energies();
        let energies = [("kinetic", kinetic), ("elastic", elastic), ("gravity", gravity)];
        about.notes.extend(energies.map(|(name, joule)| (format!("{ENERGY}{name}"), format!("{joule:.6e} J"))));
        let before = self.saver.save(&mut self.simulation, about);
        let compared = self.comparison.save(self.folder.dir()).map_err(Error::write(self.folder.dir()));
        self.spent.checkpoints += start.elapsed();
        before?;
        compared
    }

    /// Waits until the last checkpoint is on the disk; where it is.
    fn settle(&mut self) -> Result<Option<PathBuf>, Error> {
        let start = Instant::now();
        let path = self.saver.wait()?;
        self.spent.checkpoints += start.elapsed();
        Ok(path)
    }

    /// What could not be written ends the run, or is told, as the scene wants it.
    fn tolerate(&mut self, written: Result<(), Error>) -> Result<(), Error> {
        match (written, self.scene.output.on_write_error) {
            (Err(error), OnFailure::GoOn) => {
                self.log.say(&format!("warning: {error}; the run goes on"));
                Ok(())
            }
            (written, _) => written,
        }
    }

    /// The picture of the last frame.
    fn draw(&mut self) -> Result<(), Error> {
        let start = Instant::now();
        let frames = self.folder.frames();
        if let Some(&number) = frames.numbers()?.last() {
            picture(&whole_frame(&self.folder, number)?, &view(&self.scene), &self.folder.picture())?;
        }
        self.spent.picture += start.elapsed();
        Ok(())
    }
}

/// Columns of the series for each phase of a step.
const SECONDS: [&str; Phase::ALL.len()] = ["s_respond", "s_contact", "s_flow", "s_fracture", "s_integrate", "s_adapt"];

/// How the keys of notes begin that hold for one checkpoint only.
const ENERGY: &str = "energy, ";

/// What a file of a run says of itself.
pub(super) fn about(scene: &Scene, simulation: &Simulation, notes: &[(String, String)]) -> About {
    About {
        step: simulation.world.step,
        time: simulation.world.time,
        scene: scene.text().into(),
        program: format!("fissure {}", env!("CARGO_PKG_VERSION")),
        notes: notes.into(),
    }
}
