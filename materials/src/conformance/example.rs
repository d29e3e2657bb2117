//! Parameters that a law accepts, found from its declarations.
//!
//! Required numbers get a value well inside their range, chosen by unit; what has a default keeps it. Which optional
//! numbers belong together (κ with μ, or E with ν) is nowhere declared, so the smallest set that the law accepts is
//! searched for, and then every further one is added that it also accepts, and matrices other than the identity.

use fissure_engine::{Kind, Parameter, Range, Value};

use super::body::Given;

/// Optional numbers beyond these are not combined.
const MOST: usize = 10;

/// Symmetric, regular, and nothing like the identity that a matrix defaults to.
const MATRIX: [f64; 9] = [1.2, 0.1, 0.0, 0.1, 0.9, 0.2, 0.0, 0.2, 1.6];

/// A set of values that `accepts` says yes to, containing `given`.
///
/// # Errors
/// What it said to the last try.
pub(super) fn find(
    parameters: &[Parameter],
    given: &Given,
    accepts: impl Fn(&Given) -> Result<(), String>,
) -> Result<Given, String> {
    let start = required(parameters, given);
    let mut optional = Vec::new();
    for p in parameters.iter().filter(|p| !given.iter().any(|(key, _)| key == p.name)) {
        if let Kind::OptionalNumber(range) = p.kind {
            optional.push((p.name.to_string(), Value::Number(inside(p, &range))));
        }
    }
    optional.truncate(MOST);
    let mut sets: Vec<u32> = (0..1 << optional.len()).collect();
    sets.sort_by_key(|s| s.count_ones()); // stable: earlier declared first
    let with = |set: u32| {
        let chosen = optional.iter().enumerate().filter(|(k, _)| set >> k & 1 == 1).map(|(_, o)| o.clone());
        start.iter().cloned().chain(chosen).collect::<Given>()
    };
    let mut why = String::new();
    let accepted = sets.into_iter().find(|&set| accepts(&with(set)).map_err(|e| why = e).is_ok());
    let Some(mut set) = accepted else {
        return Err(format!(
            "no parameters were found that it accepts, give some with `Case`; the last try said: {why}"
        ));
    };
    for k in 0..optional.len() {
        if accepts(&with(set | 1 << k)).is_ok() {
            set |= 1 << k;
        }
    }
    let mut found = with(set);
    for p in parameters.iter().filter(|p| matches!(p.kind, Kind::Matrix) && !given.iter().any(|(key, _)| key == p.name))
    {
        let more: Given = found.iter().cloned().chain([(p.name.to_string(), Value::List(MATRIX.into()))]).collect();
        if accepts(&more).is_ok() {
            found = more;
        }
    }
    Ok(found)
}

/// `given`, and a value for every number that is required beside it.
pub(super) fn required(parameters: &[Parameter], given: &Given) -> Given {
    let mut out = given.clone();
    for p in parameters {
        match p.kind {
            Kind::Number(range) if !given.iter().any(|(key, _)| key == p.name) => {
                out.push((p.name.into(), Value::Number(inside(p, &range))));
            }
            _ => {}
        }
    }
    out
}

/// A value well inside the range: a brittle rubber that yields at about one per cent, and breaks at less, since a bond
/// that has yielded is stretched elastically no further than that.
pub(super) fn inside(p: &Parameter, range: &Range) -> f64 {
    let has = |part: &str| p.name.contains(part);
    let guess = match p.unit {
        "Pa" if has("yield") => 1e4,
        "Pa" if has("shear") => 4e5,
        "Pa" => 1e6,
        "J/m^2" | "J/m²" | "N/m" => 5.0,
        "s" => 0.02,
        "m" => 0.01,
        _ if has("yield") => 0.01,
        _ if has("critical") => 0.001,
        _ if has("poisson") => 0.3,
        _ => 0.25,
    };
    let (low, high) = (range.low.0, range.high.0);
    if range.contains(guess) {
        guess
    } else if low.is_finite() && high.is_finite() {
        0.5 * (low + high)
    } else if low.is_finite() {
        low + low.abs().max(1.0)
    } else {
        high - high.abs().max(1.0)
    }
}
