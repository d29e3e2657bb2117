//! `fissure materials`: what is registered, from its own declarations.

use std::process::ExitCode;

use fissure_engine::registry::{CriterionEntry, Entry, Wants};
use fissure_engine::{Kind, Parameter, Registry};

use crate::Error;
use crate::say::say;

pub(crate) fn command(name: Option<&str>, registry: &Registry) -> Result<ExitCode, Error> {
    let criteria = criteria(registry);
    match name {
        None => {
            for entry in registry.entries() {
                say!("{:<20} {}", entry.name, entry.summary);
            }
            say!("\nfracture:");
            for criterion in &criteria {
                say!("{:<20} {}", criterion.name, criterion.summary);
            }
            say!("\n`fissure materials NAME` explains one and lists its parameters.");
        }
        Some(name) => {
            let named: Vec<_> = criteria.iter().filter(|criterion| criterion.name == name).collect();
            if named.is_empty() {
                material(registry.entry(name).map_err(|e| Error::Usage(e.to_string()))?);
            }
            for criterion in named {
                explain(criterion);
                let has = |entry: &&Entry| entry.criteria.iter().any(|c| same(c, criterion));
                let laws: Vec<&str> = registry.entries().iter().filter(has).map(|entry| entry.name).collect();
                say!("For {}.\n", laws.join(", "));
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Bonds and lattices have criteria of one name that are not the same.
fn same(a: &CriterionEntry, b: &CriterionEntry) -> bool {
    (a.name, a.summary) == (b.name, b.summary)
}

/// Each criterion once, in the order in which materials have them.
fn criteria(registry: &Registry) -> Vec<&CriterionEntry> {
    let mut each: Vec<&CriterionEntry> = Vec::new();
    for criterion in registry.entries().iter().flat_map(|entry| &entry.criteria) {
        if !criterion.parameters.is_empty() && !each.iter().any(|known| same(known, criterion)) {
            each.push(criterion);
        }
    }
    each
}

fn material(entry: &Entry) {
    say!("{}: {}\n\n[body.NAME.material]\nlaw = \"{}\"", entry.name, entry.summary, entry.name);
    list(entry.parameters);
    if entry.wants == Wants::Cells {
        say!(
            "\nIt makes a lattice: see `fissure keys cell` for how fine, `fissure keys crack_faces` for how cracks look."
        );
    }
    for criterion in entry.criteria.iter().filter(|c| !c.parameters.is_empty()) {
        say!();
        explain(criterion);
    }
}

fn explain(criterion: &CriterionEntry) {
    say!("{}\n[body.NAME.fracture]\ncriterion = \"{}\"", criterion.summary, criterion.name);
    list(criterion.parameters);
}

fn list(parameters: &[Parameter]) {
    for p in parameters {
        let unit = if p.unit == "1" { String::new() } else { format!(" [{}]", p.unit) };
        let kind = match p.kind {
            Kind::Number(range) => format!("number{unit}, {range}, required"),
            Kind::NumberOr(range, default) => format!("number{unit}, {range}, default {default}"),
            Kind::OptionalNumber(range) => format!("number{unit}, {range}, optional"),
            Kind::Word(words) => format!("one of {}; default {}", words.join(", "), words[0]),
            Kind::Vector(default) => format!("3 numbers{unit}, default {default:?}"),
            Kind::Matrix => "3 or 9 numbers, default identity".into(),
        };
        say!("  {:<18} {kind}\n  {:<18} {}", p.name, "", p.about);
    }
}
