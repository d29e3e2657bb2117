//! The conformance kit: what every material promises, as checks that anybody can run on a law of their own.
//!
//! ```no_run
//! # let registry = fissure_materials::registry();
//! fissure_materials::conformance::check(&registry, "isotropic"); // prints a table, panics if a check fails
//! ```
//! The kit knows no law. It makes the material through the [`Registry`], as a scene would, finds parameters that it
//! accepts from its declarations, and judges what it sees from outside: forces, energies, columns, steps. A law whose
//! parameters cannot be guessed, or one that is known to break a promise, is checked with a [`Case`].
//!
//! | check | promise |
//! |---|---|
//! | `parameters` | declarations are complete; what they exclude is refused by name, unit and range; what they admit works |
//! | `rest` | no force on a body at rest, also turned and moved |
//! | `momentum` | the body exerts no force and no torque on itself |
//! | `objectivity` | strained, then turned by 90°: forces turn with the body |
//! | `gradient` | force = −∂E/∂x where the law has an energy |
//! | `work` | a closed cycle of strain never yields work, and no part of it makes energy |
//! | `return` | the force before the flow of a step is that after it: the return lands on the yield surface |
//! | `precision` | eight f32 lanes agree with f64 |
//! | `repeat` | evaluating twice gives the same bits and changes no column |
//! | `twins` | both directions of a bond have the same influence and remember the same |
//! | `restart` | saved, restored into a fresh world and continued: the same bits |
//! | `threads` | the same bits on any number of threads |
//! | `step` | the time step that is offered is stable, one 1.3 times as long is not |
//! | `fracture` | both directions break together, cuts and damage agree, broken bonds carry no force |
//!
//! Allocations are counted by a test of the engine: a counting allocator must be alone in its program.
//! What the kit itself can see is proved by mutants, deliberately wrong laws, in `tests/conformance.rs`.

mod body;
mod case;
mod example;
mod flow;
mod force;
mod fracture;
mod parameters;
mod report;
mod state;
mod step;

pub use case::Case;
pub use report::{Line, Outcome, Report, matrix};

use fissure_engine::Registry;

use self::body::Subject;
use self::report::Finding;

/// A promise and how it is checked.
struct Check {
    name: &'static str,
    run: fn(&Subject<'_>) -> Finding,
}

/// Every check, in the order of the table.
const CHECKS: &[Check] = &[
    Check { name: "parameters", run: parameters::refused_or_working },
    Check { name: "rest", run: force::nothing_at_rest },
    Check { name: "momentum", run: force::momentum },
    Check { name: "objectivity", run: force::objectivity },
    Check { name: "gradient", run: force::gradient },
    Check { name: "work", run: flow::work },
    Check { name: "return", run: flow::consistent_return },
    Check { name: "precision", run: force::precision },
    Check { name: "repeat", run: state::repeat },
    Check { name: "twins", run: state::twins },
    Check { name: "restart", run: state::restart },
    Check { name: "threads", run: state::threads },
    Check { name: "step", run: step::stable },
    Check { name: "fracture", run: fracture::together },
];

/// The names of all checks, in the order of the table.
pub fn checks() -> impl Iterator<Item = &'static str> {
    CHECKS.iter().map(|c| c.name)
}

/// Checks the registered material `law` and prints the table.
///
/// # Panics
/// If a check fails, with the table; or if no parameters are found that the law accepts.
pub fn check(registry: &Registry, law: &str) -> Report {
    Case::new(law).check(registry)
}

/// Checks every registered bond law with its defaults and prints the tables.
///
/// # Panics
/// As [`check`], after all of them have been checked.
pub fn check_all(registry: &Registry) -> Vec<Report> {
    let reports: Vec<Report> = registry.bond_laws().map(|e| Case::new(e.name).run(registry)).collect();
    reports.iter().for_each(|r| println!("{r}"));
    println!("{}", matrix(&reports));
    let bad: Vec<String> = reports.iter().filter(|r| !r.passed()).map(Report::complaint).collect();
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    reports
}
