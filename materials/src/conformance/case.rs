//! One law with parameters of the caller's choice, and with the promises that it is known to break.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use fissure_engine::{Registry, Value};

use super::body::{Given, Subject, shown};
use super::report::{Line, Outcome, Report, Trouble};
use super::{CHECKS, checks};

/// A law to check. What is not given is found: see [`conformance`](super).
///
/// ```no_run
/// use fissure_materials::conformance::Case;
/// Case::new("isotropic")
///     .number("bulk_modulus", 1e6)
///     .number("shear_modulus", 4e5)
///     .word("formulation", "as_written")
///     .expect("objectivity", "Λ is not objective (Chen et al., Eq. 4)")
///     .expect("precision", "a law that asks for Λ has no frame that turns with the body")
///     .expect("step", "surfaces are softer than the bound takes them to be")
///     .check(&fissure_materials::registry());
/// ```
#[derive(Clone, Debug)]
pub struct Case {
    law: String,
    given: Given,
    criteria: Vec<(String, Given)>,
    expected: Vec<(String, String)>,
}

impl Case {
    /// The registered material `law`.
    pub fn new(law: &str) -> Self {
        Self { law: law.into(), given: vec![], criteria: vec![], expected: vec![] }
    }

    /// Gives the law a number.
    pub fn number(self, key: &str, value: f64) -> Self {
        self.value(key, Value::Number(value))
    }

    /// Gives the law a word.
    pub fn word(self, key: &str, value: &str) -> Self {
        self.value(key, Value::Word(value.into()))
    }

    /// Gives the law a value of any kind.
    pub fn value(mut self, key: &str, value: Value) -> Self {
        self.given.push((key.into(), value));
        self
    }

    /// Gives the fracture criterion `name` its parameters; they are found for the others.
    pub fn criterion(mut self, name: &str, values: &[(&str, Value)]) -> Self {
        self.criteria.push((name.into(), values.iter().map(|(k, v)| (k.to_string(), v.clone())).collect()));
        self
    }

    /// Says that the law is known to fail `check`, and why. A check that passes nevertheless is a failure: the list of
    /// known faults must stay true.
    pub fn expect(mut self, check: &str, why: &str) -> Self {
        self.expected.push((check.into(), why.into()));
        self
    }

    /// Checks the law and prints the table.
    ///
    /// # Panics
    /// If a check fails.
    pub fn check(&self, registry: &Registry) -> Report {
        let report = self.run(registry);
        println!("{report}");
        assert!(report.passed(), "{}\n{report}", report.complaint());
        report
    }

    /// Checks the law. Does not panic: a check that does has failed.
    ///
    /// # Panics
    /// If [`expect`](Self::expect) was given the name of no check.
    pub fn run(&self, registry: &Registry) -> Report {
        for (check, _) in &self.expected {
            assert!(
                checks().any(|c| c == check),
                "no check is called `{check}`; there are {:?}",
                checks().collect::<Vec<_>>()
            );
        }
        let mut report = Report { law: self.law.clone(), parameters: String::new(), lines: Vec::new() };
        let found = catch_unwind(|| Subject::new(registry, &self.law, &self.given, &self.criteria));
        let subject = match found.unwrap_or_else(|panic| Err(said(&*panic))) {
            Ok(subject) => subject,
            Err(why) => {
                report.lines.push(Line { check: "parameters", outcome: Outcome::Failed, note: why });
                return report;
            }
        };
        report.parameters = shown(&subject.given);
        for check in CHECKS {
            let finding = catch_unwind(AssertUnwindSafe(|| (check.run)(&subject)));
            let finding = finding.unwrap_or_else(|panic| Err(Trouble::Fail(said(&*panic))));
            let expected = self.expected.iter().find(|(name, _)| name == check.name).map(|(_, why)| why);
            let (outcome, note) = match (finding, expected) {
                (Err(Trouble::Fail(note)), None) => (Outcome::Failed, note),
                (Err(Trouble::Fail(note)), Some(why)) => (Outcome::Expected, format!("{why}: {note}")),
                (Ok(note) | Err(Trouble::Skip(note)), Some(_)) => {
                    (Outcome::Failed, format!("no longer fails, take it off the list of what is expected: {note}"))
                }
                (Ok(note), None) => (Outcome::Passed, note),
                (Err(Trouble::Skip(note)), None) => (Outcome::Skipped, note),
            };
            report.lines.push(Line { check: check.name, outcome, note });
        }
        report
    }
}

/// What a panic said.
pub(super) fn said(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
    format!("panics: {}", text.unwrap_or("without a message"))
}
