//! Every registered law keeps its promises; and the kit is worth asking: deliberately wrong laws are caught, each by the
//! check that should.
//!
//! Two faults of the usual list cannot be written down as a law: a pair force that is not antisymmetric (the engine adds
//! both sides; an influence that changes with the sign of ξ comes nearest), and a broken bond that carries force.

mod elastic;
mod family;
mod plastic;

use fissure_engine::fracture::{CriticalStretch, Unbreakable};
use fissure_engine::{BondLaw, Kind, Parameter, Registry, Value};
use fissure_materials::conformance::{self, Case, Outcome, Report, matrix};

use elastic::*;
use family::*;
use plastic::*;

#[test]
fn every_registered_law_keeps_its_promises() {
    conformance::check_all(&fissure_materials::registry());
}

#[test]
fn the_paper_as_written_is_not_objective_and_the_kit_says_so() {
    let registry = fissure_materials::registry();
    let written = || {
        Case::new("isotropic")
            .number("bulk_modulus", 1e6)
            .number("shear_modulus", 4e5)
            .word("formulation", "as_written")
    };
    // measured: .19 of the force, 4.5e-4 of it in f32
    let frame = "a law that asks for Λ has no frame that turns with the body";
    let written = || written().expect("precision", frame);
    let report = written().expect("objectivity", "Λ of Eqs. 4 and 6 is not objective").check(&registry);
    assert_eq!(report.outcome("objectivity"), Some(Outcome::Expected));
    // what is expected must be true
    let wrong = written().expect("objectivity", "Λ").expect("rest", "no").run(&registry);
    assert_eq!(wrong.outcome("rest"), Some(Outcome::Failed));
}

#[test]
fn whatever_follows_the_paper_to_the_letter_fails_where_the_paper_does() {
    let registry = fissure_materials::registry();
    let literal = |p: &&Parameter| matches!(p.kind, Kind::Word(words) if words.contains(&"as_written"));
    let laws = registry.bond_laws().filter_map(|e| Some((e, e.parameters.iter().find(literal)?)));
    for (entry, word) in laws {
        let report = Case::new(entry.name).word(word.name, "as_written").run(&registry);
        println!("{report}");
        let failed: Vec<&str> = report.failures().collect();
        // Λ; and with memory Eq. 15, whose return overshoots: measured 1.7 of the largest force
        let memory = report.outcome("return") != Some(Outcome::Skipped);
        assert!(failed.contains(&"objectivity") && failed.contains(&"return") == memory, "{failed:?}");
        let known = ["objectivity", "precision", "return"];
        assert!(failed.iter().all(|check| known.contains(check)), "{failed:?}");
    }
}

#[test]
fn the_laws_that_the_mutants_are_made_of_pass() {
    let registry = Registry::default().bonds::<Elastic<Right>, _>().bonds::<Plastic<Sound>, _>();
    conformance::check_all(&registry);
}

/// Name of the mutant, the checks that must catch it.
const CAUGHT: &[(&str, &[&str])] = &[
    (Lambda::NAME, &["objectivity"]),
    (Prestress::NAME, &["rest"]),
    (Direction::NAME, &["rest"]),
    (Cancelling::NAME, &["precision"]),
    (Double::NAME, &["gradient", "work"]),
    (Lopsided::NAME, &["momentum", "twins"]),
    (Compression::NAME, &["step"]),
    (Kinked::NAME, &["step"]),
    (Tiring::NAME, &["repeat"]),
    (Random::NAME, &["repeat", "momentum"]),
    (Threaded::NAME, &["threads"]),
    (Unranged::NAME, &["parameters"]),
    (Panicking::NAME, &["parameters"]),
    (Undocumented::NAME, &["parameters"]),
    (Defaulting::NAME, &["parameters"]),
    (Eq15::NAME, &["return"]),
    (Creeping::NAME, &["return"]),
    (Driving::NAME, &["work"]),
    (Hidden::NAME, &["restart"]),
    (Dice::NAME, &["twins"]),
    (Rigid::NAME, &["return"]),
    (Unsummed::NAME, &["return"]),
    (Trial::NAME, &["return"]),
    ("half_broken", &["fracture"]),
];

/// With two criteria only: each of them is compiled for each mutant.
fn mutant<T: BondLaw<M>, const M: usize>(registry: Registry) -> Registry {
    registry.pair::<T, Unbreakable, M>().pair::<T, CriticalStretch, M>()
}

#[test]
fn every_mutant_is_caught_by_the_check_that_should() {
    let mut registry = Registry::default();
    registry = mutant::<Elastic<Lambda>, _>(registry);
    registry = mutant::<Elastic<Prestress>, _>(registry);
    registry = mutant::<Elastic<Direction>, _>(registry);
    registry = mutant::<Elastic<Cancelling>, _>(registry);
    registry = mutant::<Elastic<Double>, _>(registry);
    registry = mutant::<Elastic<Lopsided>, _>(registry);
    registry = mutant::<Elastic<Compression>, _>(registry);
    registry = mutant::<Elastic<Kinked>, _>(registry);
    registry = mutant::<Elastic<Tiring>, _>(registry);
    registry = mutant::<Elastic<Random>, _>(registry);
    registry = mutant::<Elastic<Threaded>, _>(registry);
    registry = mutant::<Elastic<Unranged>, _>(registry);
    registry = mutant::<Elastic<Panicking>, _>(registry);
    registry = mutant::<Elastic<Undocumented>, _>(registry);
    registry = mutant::<Elastic<Defaulting>, _>(registry);
    registry = mutant::<Plastic<Eq15>, _>(registry);
    registry = mutant::<Plastic<Creeping>, _>(registry);
    registry = mutant::<Plastic<Driving>, _>(registry);
    registry = mutant::<Plastic<Hidden>, _>(registry);
    registry = mutant::<Plastic<Dice>, _>(registry);
    registry = mutant::<Plastic<Rigid>, _>(registry);
    registry = mutant::<Family<Unsummed>, _>(registry);
    registry = mutant::<Family<Trial>, _>(registry);
    registry = registry.pair::<Elastic<HalfBroken>, Moody, _>();
    assert_eq!(registry.entries().len(), CAUGHT.len());
    let reports: Vec<Report> = CAUGHT.iter().map(|(name, _)| Case::new(name).run(&registry)).collect();
    reports.iter().for_each(|r| println!("{r}"));
    println!("{}", matrix(&reports));
    for (report, (name, checks)) in reports.iter().zip(CAUGHT) {
        for check in *checks {
            assert_eq!(report.outcome(check), Some(Outcome::Failed), "`{name}` gets past `{check}`");
        }
    }
}

#[test]
fn a_failed_check_is_a_panic_with_its_name() {
    let registry = Registry::default().bonds::<Elastic<Prestress>, _>();
    let panic = std::panic::catch_unwind(|| conformance::check(&registry, Prestress::NAME)).unwrap_err();
    let text = panic.downcast_ref::<String>().expect("a message");
    assert!(text.contains("rest") && text.contains("FAILED"), "{text}");
    let unknown = Case::new("isotropicc").run(&fissure_materials::registry());
    assert!(unknown.lines[0].note.contains("did you mean `isotropic`"), "{}", unknown.lines[0].note);
}

#[test]
fn a_criterion_is_checked_with_the_parameters_that_are_given() {
    let of = |limit: f64| {
        let critical = [("critical_stretch", Value::Number(limit))];
        Case::new("isotropic").criterion("critical_stretch", &critical).run(&fissure_materials::registry())
    };
    assert!(of(0.2).passed());
    // 100 horizons: nothing breaks at any strain that the kit makes
    assert_eq!(of(100.0).failures().collect::<Vec<_>>(), ["fracture"]);
}
