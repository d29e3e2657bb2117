//! Bad parameters of laws and criteria, each through the program: one sentence with file, line, key, unit and range.

use fissure_engine::{Kind, Parameter, Range};

use crate::refusing::at_line;
use crate::workshop::{BOX, Workshop};

/// Every registered law with parameters that it takes.
const LAWS: &[(&str, &str)] = &[
    ("isotropic", "bulk_modulus = 5e5\nshear_modulus = 3e5"),
    ("plastic", "bulk_modulus = 5e5\nshear_modulus = 3e5\nyield_stress = 1e4"),
    ("anisotropic", "bulk_modulus = 5e5\nshear_modulus = 3e5\nmatrix = [1, 1, 2]"),
    ("anisotropic_plastic", "bulk_modulus = 5e5\nshear_modulus = 3e5\nyield_stretch = 0.01\nmatrix = [1, 1, 2]"),
    ("viscoelastic", "young_modulus = 5e5\npoisson_ratio = 0.3\nrelaxing_share = 0.5\nrelaxation_time = 0.01"),
    ("lps", "young_modulus = 5e5\npoisson_ratio = 0.3"),
    ("mitchell", "young_modulus = 5e5\npoisson_ratio = 0.3\nyield_stress = 1e4"),
    ("pmb", "bulk_modulus = 5e5"),
    ("lattice", "half_width = 2"),
];

/// Where it is said that something is missing.
const MATERIAL: &str = "[body.box.material]";

/// The box of this material, and this fracture.
fn scene(material: &str, fracture: &str) -> String {
    let (start, rest) = BOX.split_once("[body.box.material]\n").expect("a material");
    let (_, end) = rest.split_once("[ground]").expect("a ground");
    format!("{start}[body.box.material]\n{material}\n\n[body.box.fracture]\n{fracture}\n\n[ground]{end}")
}

/// `lines` with `key` set to `value`.
fn with(lines: &str, key: &str, value: &str) -> String {
    let others = lines.lines().filter(|l| !l.starts_with(&format!("{key} ")));
    others.map(|l| format!("{l}\n")).collect::<String>() + &format!("{key} = {value}")
}

/// Values outside what is declared, and what the sentence must say.
fn outside(p: &Parameter) -> Vec<(String, Vec<String>)> {
    let unit = format!("[{}]", p.unit);
    let numbers = |r: Range| {
        let below = |end: (f64, bool)| if end.1 { end.0 - 0.5 } else { end.0 };
        let mut bad = vec!["nan".to_string()];
        bad.extend([r.low.0, -r.high.0].iter().filter(|x| x.is_infinite()).map(|_| "-inf".into()));
        bad.extend(r.low.0.is_finite().then(|| format!("{:?}", below(r.low))));
        bad.extend(r.high.0.is_finite().then(|| format!("{:?}", -below((-r.high.0, r.high.1)))));
        let mut all: Vec<_> = bad.into_iter().map(|b| (b, vec![r.to_string(), unit.clone()])).collect();
        all.push(("\"stiff\"".into(), vec!["a number".into(), unit.clone()]));
        all
    };
    match p.kind {
        Kind::Number(r) | Kind::NumberOr(r, _) | Kind::OptionalNumber(r) => numbers(r),
        Kind::Word(words) => {
            ["\"none_such\"", "3"].map(|bad| (bad.to_string(), words.iter().map(|w| w.to_string()).collect())).into()
        }
        Kind::Vector(_) => {
            ["[1, 2]", "3", "\"up\""].map(|bad| (bad.to_string(), vec!["a list of 3 numbers".into()])).into()
        }
        Kind::Matrix => {
            ["[1, 2]", "3", "\"identity\""].map(|bad| (bad.to_string(), vec!["3 (diagonal) or 9".into()])).into()
        }
    }
}

/// Tries everything that `parameters` exclude, one at a time, in `lines`.
fn refuse(shop: &Workshop, parameters: &[Parameter], lines: &str, scene: &dyn Fn(&str) -> String) -> usize {
    let mut tried = 0;
    for p in parameters {
        for (bad, words) in outside(p) {
            let name = format!("`{}`", p.name);
            let words: Vec<&str> = words.iter().map(String::as_str).chain([name.as_str()]).collect();
            let text = scene(&with(lines, p.name, &bad));
            at_line(shop, &text, &format!("{} = {bad}", p.name), &words);
            tried += 1;
        }
    }
    tried
}

#[test]
fn what_tables_exclude_is_refused_for_every_law_and_criterion() {
    let (shop, registry) = (Workshop::new(), fissure_materials::registry());
    let names: Vec<&str> = registry.entries().iter().map(|e| e.name).collect();
    assert_eq!(LAWS.iter().map(|(name, _)| *name).collect::<Vec<_>>(), names, "a law is missing in the table");
    let mut tried = 0;
    for (entry, (name, lines)) in registry.entries().iter().zip(LAWS) {
        let material = |lines: &str| scene(&format!("law = \"{name}\"\n{lines}"), "criterion = \"none\"");
        tried += refuse(&shop, entry.parameters, lines, &material);
    }
    let law = format!("law = \"isotropic\"\n{}", LAWS[0].1);
    let isotropic = registry.entry("isotropic").unwrap();
    for criterion in &isotropic.criteria {
        let fracture = |lines: &str| scene(&law, &format!("criterion = \"{}\"\n{lines}", criterion.name));
        tried += refuse(&shop, criterion.parameters, &required(criterion.parameters), &fracture);
    }
    assert!(tried > 100, "{tried}");
}

/// A line for every number that is required.
fn required(parameters: &[Parameter]) -> String {
    let needed = parameters.iter().filter(|p| matches!(p.kind, Kind::Number(_)));
    needed.map(|p| format!("{} = 0.1\n", p.name)).collect()
}

#[test]
fn what_contradicts_itself_is_refused_at_its_line() {
    let shop = Workshop::new();
    for (law, lines, part, words) in [
        ("isotropic", "young_modulus = 5e5\npoisson_ratio = 0.5", "poisson_ratio", &["in (-1, 0.5)"][..]),
        ("isotropic", "young_modulus = 5e5\npoisson_ratio = -1", "poisson_ratio", &["in (-1, 0.5)"]),
        ("isotropic", "bulk_modulus = 0\nshear_modulus = 3e5", "bulk_modulus", &["above 0 [Pa]"]),
        ("isotropic", "bulk_modulus = 5e5", "bulk_modulus", &["either", "`shear_modulus` [Pa]"]),
        ("isotropic", "bulk_modulus = 5e5\npoisson_ratio = 0.3", "bulk_modulus", &["either", "`shear_modulus` [Pa]"]),
        ("isotropic", "shear_modulus = 5e5", "shear_modulus", &["either", "`bulk_modulus`"]),
        ("isotropic", "", MATERIAL, &["either", "`bulk_modulus`"]),
        ("plastic", "bulk_modulus = 5e5\nshear_modulus = 3e5", MATERIAL, &["`yield_stress` [Pa]"]),
        (
            "plastic",
            "bulk_modulus = 5e5\nshear_modulus = 3e5\nyield_stretch = 1e-7",
            "yield_stretch",
            &["stretch of 1.0e-7", "1e-5 or more"],
        ),
        (
            "plastic",
            "bulk_modulus = 5e5\nshear_modulus = 3e5\npsi0 = 1",
            "psi0",
            &["`yield_stress` [Pa]", "formulation = \"as_written\""],
        ),
        (
            "anisotropic",
            "bulk_modulus = 5e5\nshear_modulus = 3e5\nmatrix = [1, 0, 1]",
            "matrix",
            &["`matrix`", "singular", "invertible"],
        ),
        (
            "anisotropic",
            "bulk_modulus = 5e5\nshear_modulus = 3e5\nmatrix = [1, 2, 3, 2, 4, 6, 0, 0, 1]",
            "matrix",
            &["`matrix`", "singular", "invertible"],
        ),
        ("mitchell", "bulk_modulus = 5e5\nshear_modulus = 3e5", MATERIAL, &["`yield_stress` [Pa]", "missing"]),
        (
            "viscoelastic",
            "bulk_modulus = 5e5\nshear_modulus = 3e5\nrelaxing_share = 0.5",
            MATERIAL,
            &["`relaxation_time` [s]", "missing"],
        ),
        ("pmb", "bulk_modulus = 5e5\nyoung_modulus = 3e5", "bulk_modulus", &["either", "[Pa]"]),
        ("pmb", "", MATERIAL, &["either", "[Pa]"]),
    ] {
        let text = scene(&format!("law = \"{law}\"\n{lines}"), "criterion = \"none\"");
        at_line(&shop, &text, part, words);
    }
    let fracture = scene("law = \"lps\"\nyoung_modulus = 1e6\npoisson_ratio = 0.2", "criterion = \"critical_stretch\"");
    at_line(&shop, &fracture, "[body.box.fracture]", &["`critical_stretch` [1]", "missing"]);
}
