//! Two run folders: scenes, frozen columns, the checkpoints of the same steps, and frames.

use std::fmt;
use std::fs;
use std::path::Path;

use super::{DiffError, FileDiff, KeyDiff, Options, Side, checkpoints, scenes};
use crate::checkpoint::{FROZEN, Store};
use crate::frames::FrameFolder;

/// Two runs compared.
#[derive(Clone, Debug)]
pub struct RunDiff {
    /// Keys of the scenes that differ.
    pub scene: Vec<KeyDiff>,
    /// The frozen columns.
    pub frozen: FileDiff,
    /// Checkpoints of steps that both have, oldest first.
    pub steps: Vec<FileDiff>,
    /// Steps that only the first or only the second has a checkpoint of.
    pub only: [Vec<u64>; 2],
    /// The frames.
    pub frames: FrameDiff,
}

/// The frames of two runs, compared byte by byte.
#[derive(Clone, Debug, Default)]
pub struct FrameDiff {
    /// Frames that both have.
    pub both: usize,
    /// Those of them that differ.
    pub differing: usize,
    /// The first that differs: its number, and its time in the first run [s].
    pub first: Option<(u32, f64)>,
    /// Frames that only one has.
    pub only: [usize; 2],
}

impl RunDiff {
    /// The first step whose checkpoints differ.
    pub fn first_step(&self) -> Option<u64> {
        self.steps.iter().find(|d| d.differs()).map(|d| d.step[0])
    }

    /// Whether the runs differ: in their scenes, columns or frames, or in how far they are. Checkpoints that only one has
    /// kept are no difference.
    pub fn differs(&self) -> bool {
        !self.scene.is_empty()
            || self.frozen.differs()
            || self.first_step().is_some()
            || self.frames.first.is_some()
            || self.frames.only != [0, 0]
            || self.last_steps_differ()
    }

    fn last_steps_differ(&self) -> bool {
        let both = self.steps.last().map(|d| d.step[0]);
        self.only.iter().any(|only| only.last().is_some_and(|&s| both.is_none_or(|b| s > b)))
    }
}

/// Compares two run folders.
///
/// # Errors
/// A folder that holds no run, or a damaged file.
pub fn runs(a: &Path, b: &Path, options: &Options) -> Result<RunDiff, DiffError> {
    let text = |dir: &Path| {
        let path = dir.join("scene.toml");
        fs::read_to_string(&path).map_err(|source| DiffError::Read { path, source })
    };
    let scene = scenes([&text(a)?, &text(b)?], [a, b])?;
    let open = |dir: &Path| -> Result<_, DiffError> { Ok((Side::open(dir.join(FROZEN))?, Store::listing(dir)?)) };
    let ((frozen_a, steps_a), (frozen_b, steps_b)) = (open(a)?, open(b)?);
    let frozen = match checkpoints(&frozen_a, &frozen_b, options) {
        // the column that is asked for is a live one
        Err(DiffError::NoColumn { .. }) => FileDiff { step: [0; 2], matched: false, columns: Vec::new() },
        other => other?,
    };
    let (mut steps, mut only) = (Vec::new(), [Vec::new(), Vec::new()]);
    for (step, path) in &steps_a {
        match steps_b.iter().find(|(s, _)| s == step) {
            Some((_, other)) => steps.push(checkpoints(&Side::open(path)?, &Side::open(other)?, options)?),
            None => only[0].push(*step),
        }
    }
    only[1].extend(steps_b.iter().map(|(s, _)| *s).filter(|s| steps_a.iter().all(|(step, _)| step != s)));
    let frames = if options.columns.is_empty() { frames(a, b)? } else { FrameDiff::default() };
    Ok(RunDiff { scene, frozen, steps, only, frames })
}

fn frames(a: &Path, b: &Path) -> Result<FrameDiff, DiffError> {
    let folders = [a, b].map(|dir| FrameFolder::new(dir.join("frames")));
    let numbers = [folders[0].numbers()?, folders[1].numbers()?];
    let mut diff = FrameDiff { only: [numbers[0].len(), numbers[1].len()], ..FrameDiff::default() };
    for number in numbers[0].iter().filter(|n| numbers[1].contains(n)) {
        diff.both += 1;
        let read = |folder: &FrameFolder| {
            let path = folder.path(*number);
            fs::read(&path).map_err(|source| DiffError::Read { path, source })
        };
        if read(&folders[0])? != read(&folders[1])? {
            diff.differing += 1;
            if diff.first.is_none() {
                diff.first = Some((*number, folders[0].read(*number)?.time));
            }
        }
    }
    diff.only = diff.only.map(|n| n - diff.both);
    Ok(diff)
}

impl fmt::Display for RunDiff {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.scene.iter().try_for_each(|key| writeln!(f, "scene: {key}"))?;
        if self.frozen.differs() {
            writeln!(f, "frozen columns:\n{}", self.frozen)?;
        }
        match self.steps.iter().position(|d| d.differs()) {
            Some(k) => {
                let before = k.checked_sub(1).map_or("no step before it is in both".into(), |k| {
                    format!("step {} is the same", self.steps[k].step[0])
                });
                writeln!(f, "first differing step: {}; {before}\n{}", self.steps[k].step[0], self.steps[k])?;
                if let Some(last) = self.steps.last().filter(|_| k + 1 < self.steps.len()) {
                    writeln!(f, "last common step: {}\n{last}", last.step[0])?;
                }
            }
            None if self.steps.is_empty() => writeln!(f, "no step has a checkpoint in both")?,
            None => {
                let steps: Vec<String> = self.steps.iter().map(|d| d.step[0].to_string()).collect();
                writeln!(f, "the same at step {}", steps.join(", "))?;
            }
        }
        for (which, only) in ["first", "second"].iter().zip(&self.only).filter(|(_, only)| !only.is_empty()) {
            let steps: Vec<String> = only.iter().map(u64::to_string).collect();
            writeln!(f, "only the {which} has a checkpoint of step {}", steps.join(", "))?;
        }
        let FrameDiff { both, differing, first, only } = &self.frames;
        match first {
            Some((number, time)) => {
                write!(f, "{differing} of {both} frames differ, the first is frame {number} at {time:.6} s")?;
            }
            None => write!(f, "{both} frames are the same")?,
        }
        for (which, n) in ["first", "second"].iter().zip(only).filter(|(_, n)| **n > 0) {
            write!(f, "; {n} only in the {which}")?;
        }
        Ok(())
    }
}
