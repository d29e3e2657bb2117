//! How far a run is: a bar on a terminal, a plain line now and then elsewhere.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::args::RunArgs;
use crate::say::say;

/// Plain lines come no more often than this.
const INTERVAL: Duration = Duration::from_secs(10);

/// Shows the steps done of a run.
pub(crate) struct Progress {
    bar: Option<ProgressBar>,
    plain: bool,
    start: Instant,
    last: Instant,
    first_step: u64,
    steps: u64,
    bonds: u64,
}

impl Progress {
    /// A run from step `first` to `steps` over `bonds` directed bonds.
    pub fn new(options: &RunArgs, first: u64, steps: u64, bonds: u64) -> Self {
        let speak = !options.quiet && !options.json;
        let terminal = std::io::stderr().is_terminal();
        let bar = (speak && terminal).then(|| {
            let style = ProgressStyle::with_template("{bar:30} step {pos}/{len}  {msg}  {eta} left");
            let bar = ProgressBar::new(steps).with_style(style.expect("a valid template"));
            bar.set_position(first);
            bar.reset_eta();
            bar
        });
        let now = Instant::now();
        Self { bar, plain: speak && !terminal, start: now, last: now, first_step: first, steps, bonds }
    }

    /// After each step. Plain lines appear at intervals; the bar limits itself.
    pub fn step(&mut self, step: u64, time: f64) {
        let now = Instant::now();
        let due = if self.bar.is_some() { Duration::from_millis(100) } else { INTERVAL };
        if now - self.last < due {
            return;
        }
        self.last = now;
        let seconds = (now - self.start).as_secs_f64();
        let rate = (step - self.first_step) as f64 / seconds;
        let left = (self.steps - step) as f64 / rate;
        let speed = format!("{rate:.0} steps/s, {:.0} million bonds/s", rate * self.bonds as f64 / 1e6);
        match &self.bar {
            Some(bar) => {
                bar.set_position(step);
                bar.set_message(format!("t = {time:.4} s  {speed}"));
            }
            None if self.plain => {
                say!("step {step} of {}, t = {time:.4} s, {speed}, {left:.0} s left", self.steps);
            }
            None => {}
        }
    }

    /// The end: the bar goes away.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
