//! What the kit found: one line per check, printed as a table.

use std::fmt;

use fissure_engine::{BuildError, ParamError, StepError};

/// How a check ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The promise holds.
    Passed,
    /// It does not.
    Failed,
    /// It does not, and the caller said so.
    Expected,
    /// There is nothing to check: no energy, no memory, no limit.
    Skipped,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Passed => "ok",
            Self::Failed => "FAILED",
            Self::Expected => "expected",
            Self::Skipped => "-",
        })
    }
}

/// One check of one law.
#[derive(Clone, Debug)]
pub struct Line {
    /// Name of the check.
    pub check: &'static str,
    /// How it ended.
    pub outcome: Outcome,
    /// What was measured, with the limit.
    pub note: String,
}

/// All checks of one law.
#[derive(Clone, Debug)]
pub struct Report {
    /// The law.
    pub law: String,
    /// The parameters it was checked with, as in a scene.
    pub parameters: String,
    /// One line per check.
    pub lines: Vec<Line>,
}

impl Report {
    /// Whether nothing failed that was not expected to.
    pub fn passed(&self) -> bool {
        self.failures().next().is_none()
    }

    /// The names of the checks that failed.
    pub fn failures(&self) -> impl Iterator<Item = &'static str> {
        self.lines.iter().filter(|l| l.outcome == Outcome::Failed).map(|l| l.check)
    }

    /// How the check called `check` ended.
    pub fn outcome(&self, check: &str) -> Option<Outcome> {
        self.lines.iter().find(|l| l.check == check).map(|l| l.outcome)
    }

    /// One sentence on what failed.
    pub(super) fn complaint(&self) -> String {
        let lines = self.lines.iter().filter(|l| l.outcome == Outcome::Failed);
        let what: Vec<String> = lines.map(|l| format!("{}: {}", l.check, l.note)).collect();
        format!("`{}` breaks {} of its promises: {}", self.law, what.len(), what.join("; "))
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}  {}", self.law, self.parameters)?;
        for line in &self.lines {
            writeln!(f, "  {:<12} {:<9} {}", line.check, line.outcome, line.note)?;
        }
        Ok(())
    }
}

/// The table law × check of several reports.
pub fn matrix(reports: &[Report]) -> String {
    let width = reports.iter().map(|r| r.law.chars().count()).max().unwrap_or(0);
    let mut out = format!("{:<width$}", "");
    super::checks().for_each(|c| out += &format!(" {c:<11}"));
    for report in reports {
        out += &format!("\n{:<width$}", report.law);
        for check in super::checks() {
            let outcome = report.outcome(check).map_or(String::new(), |o| o.to_string());
            out += &format!(" {outcome:<11}");
        }
    }
    out.lines().map(|l| format!("{}\n", l.trim_end())).collect()
}

/// Why a check did not pass.
pub(super) enum Trouble {
    /// The promise is broken.
    Fail(String),
    /// There is nothing to check.
    Skip(String),
}

/// What a check says: what it measured, or why it did not pass.
pub(super) type Finding = Result<String, Trouble>;

impl From<ParamError> for Trouble {
    fn from(e: ParamError) -> Self {
        Self::Fail(e.to_string())
    }
}

impl From<BuildError> for Trouble {
    fn from(e: BuildError) -> Self {
        Self::Fail(e.to_string())
    }
}

impl From<StepError> for Trouble {
    fn from(e: StepError) -> Self {
        Self::Fail(e.to_string())
    }
}

/// A broken promise.
pub(super) fn fail<T>(why: impl Into<String>) -> Result<T, Trouble> {
    Err(Trouble::Fail(why.into()))
}

/// Nothing to check.
pub(super) fn skip<T>(why: impl Into<String>) -> Result<T, Trouble> {
    Err(Trouble::Skip(why.into()))
}

/// Passes if `measured` is at most `limit`; a NaN never is.
pub(super) fn at_most(measured: f64, limit: f64, what: &str) -> Finding {
    let note = format!("{what} {measured:.1e}, at most {limit:.0e}");
    if measured <= limit { Ok(note) } else { fail(note) }
}
