//! Parameters of laws and criteria: declared once with unit and range, read by name.
//!
//! A law declares a table of [`Parameter`]s. From it follow the checks, the messages, `fissure materials` and the
//! scene schema; the law itself only asks for values.

use std::fmt;

use thiserror::Error;

/// What values a number may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Lower end and whether it belongs to the range.
    pub low: (f64, bool),
    /// Upper end and whether it belongs to the range.
    pub high: (f64, bool),
}

impl Range {
    /// (0, ∞)
    pub const POSITIVE: Self = Self { low: (0.0, false), high: (f64::INFINITY, false) };
    /// [0, ∞)
    pub const NOT_NEGATIVE: Self = Self { low: (0.0, true), high: (f64::INFINITY, false) };
    /// (low, high)
    pub const fn open(low: f64, high: f64) -> Self {
        Self { low: (low, false), high: (high, false) }
    }
    /// [low, high]
    pub const fn closed(low: f64, high: f64) -> Self {
        Self { low: (low, true), high: (high, true) }
    }

    /// Whether `x` lies in the range; NaN never does.
    pub fn contains(&self, x: f64) -> bool {
        let above = x > self.low.0 || (self.low.1 && x == self.low.0);
        let below = x < self.high.0 || (self.high.1 && x == self.high.0);
        above && below
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (*self, self.low.0, self.high.0) {
            (Self::POSITIVE, ..) => f.write_str("above 0"),
            (Self::NOT_NEGATIVE, ..) => f.write_str("0 or more"),
            (_, low, high) => {
                let (open, close) = (if self.low.1 { '[' } else { '(' }, if self.high.1 { ']' } else { ')' });
                write!(f, "in {open}{low}, {high}{close}")
            }
        }
    }
}

/// The kind of a parameter and its default.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A number that must be given.
    Number(Range),
    /// A number with a default.
    NumberOr(Range, f64),
    /// A number that may be left out, where another parameter takes its place.
    OptionalNumber(Range),
    /// One of a few words; the first is the default.
    Word(&'static [&'static str]),
    /// A matrix of 3×3 numbers, by rows, or 3 for a diagonal one; identity by default.
    Matrix,
    /// A list of 3 numbers with a default.
    Vector([f64; 3]),
}

/// The declaration of a parameter.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Key in scene files.
    pub name: &'static str,
    /// SI unit, `1` for pure numbers.
    pub unit: &'static str,
    /// Kind, range and default.
    pub kind: Kind,
    /// One line of help with the source.
    pub about: &'static str,
}

/// A value as a scene gives it.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A word.
    Word(String),
    /// A list of numbers.
    List(Vec<f64>),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(x) => write!(f, "{x}"),
            Self::Word(w) => write!(f, "\"{w}\""),
            Self::List(l) => write!(f, "{l:?}"),
        }
    }
}

/// What is wrong with a parameter, in one sentence; `key` lets the scene reader add file and line.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{message}")]
pub struct ParamError {
    /// The key concerned.
    pub key: String,
    /// The sentence.
    pub message: String,
}

impl ParamError {
    /// An error about `key`.
    pub fn new(key: &str, message: String) -> Self {
        Self { key: key.into(), message }
    }
}

/// The parameters given for one law or criterion, checked against its declarations.
#[derive(Clone, Debug)]
pub struct Params {
    declared: Vec<Parameter>,
    given: Vec<(String, Value)>,
}

impl Params {
    /// Checks `given` against `declared`.
    ///
    /// # Errors
    /// The first unknown key (with the nearest known one), missing number, value out of range or of the wrong kind.
    pub fn new(declared: Vec<Parameter>, given: Vec<(String, Value)>) -> Result<Self, ParamError> {
        for (key, value) in &given {
            let Some(parameter) = declared.iter().find(|p| p.name == key) else {
                let names: Vec<&str> = declared.iter().map(|p| p.name).collect();
                return Err(ParamError::new(key, format!("unknown key `{key}`{}", hint(key, &names))));
            };
            check(parameter, value)?;
        }
        for p in &declared {
            if matches!(p.kind, Kind::Number(_)) && !given.iter().any(|(key, _)| key == p.name) {
                let message = format!("`{}` [{}] is missing: {}", p.name, p.unit, p.about);
                return Err(ParamError::new(p.name, message));
            }
        }
        Ok(Self { declared, given })
    }

    /// Whether the scene gives `key`.
    pub fn has(&self, key: &str) -> bool {
        self.value(key).is_some()
    }

    /// The first of `keys` that the scene gives, else the first: where a sentence about all of them points to.
    pub fn given_of<'k>(&self, keys: &[&'k str]) -> &'k str {
        keys.iter().find(|key| self.has(key)).unwrap_or(&keys[0])
    }

    /// A number: the one given, or its default.
    ///
    /// # Panics
    /// If the law did not declare `key` as a number with a value: a mistake in the law, not in the scene.
    pub fn number(&self, key: &str) -> f64 {
        self.optional(key).unwrap_or_else(|| panic!("`{key}` has no value and no default"))
    }

    /// A number, its default, or none.
    ///
    /// # Panics
    /// If the law did not declare `key` as a number.
    pub fn optional(&self, key: &str) -> Option<f64> {
        match (self.value(key), self.declaration(key).kind) {
            (Some(Value::Number(x)), _) => Some(*x),
            (_, Kind::NumberOr(_, default)) => Some(default),
            (_, Kind::OptionalNumber(_) | Kind::Number(_)) => None,
            _ => panic!("`{key}` is not declared as a number"),
        }
    }

    /// A word: the one given, or the first allowed.
    ///
    /// # Panics
    /// If the law did not declare `key` as a word.
    pub fn word(&self, key: &str) -> &str {
        match (self.value(key), self.declaration(key).kind) {
            (Some(Value::Word(w)), _) => w,
            (_, Kind::Word(words)) => words[0],
            _ => panic!("`{key}` is not declared as a word"),
        }
    }

    /// A 3×3 matrix by rows.
    ///
    /// # Panics
    /// If the law did not declare `key` as a matrix.
    pub fn matrix(&self, key: &str) -> [[f64; 3]; 3] {
        match (self.value(key), self.declaration(key).kind) {
            (Some(Value::List(l)), Kind::Matrix) if l.len() == 9 => {
                [[l[0], l[1], l[2]], [l[3], l[4], l[5]], [l[6], l[7], l[8]]]
            }
            (Some(Value::List(l)), Kind::Matrix) => [[l[0], 0.0, 0.0], [0.0, l[1], 0.0], [0.0, 0.0, l[2]]],
            (_, Kind::Matrix) => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            _ => panic!("`{key}` is not declared as a matrix"),
        }
    }

    /// A list of 3 numbers, the one given or its default.
    ///
    /// # Panics
    /// If the law did not declare `key` as a vector.
    pub fn vector(&self, key: &str) -> [f64; 3] {
        match (self.value(key), self.declaration(key).kind) {
            (Some(Value::List(l)), Kind::Vector(_)) => [l[0], l[1], l[2]],
            (_, Kind::Vector(default)) => default,
            _ => panic!("`{key}` is not declared as a vector"),
        }
    }

    fn value(&self, key: &str) -> Option<&Value> {
        self.given.iter().find(|(k, _)| k == key).map(|(_, v)| v)
    }

    fn declaration(&self, key: &str) -> &Parameter {
        self.declared.iter().find(|p| p.name == key).unwrap_or_else(|| panic!("`{key}` is not declared"))
    }
}

fn check(p: &Parameter, value: &Value) -> Result<(), ParamError> {
    let fail =
        |want: String| Err(ParamError::new(p.name, format!("`{}` = {value} must be {want}: {}", p.name, p.about)));
    match (p.kind, value) {
        (Kind::Number(r) | Kind::NumberOr(r, _) | Kind::OptionalNumber(r), Value::Number(x)) => {
            if r.contains(*x) {
                Ok(())
            } else {
                fail(format!("{r} [{}]", p.unit))
            }
        }
        (Kind::Number(_) | Kind::NumberOr(..) | Kind::OptionalNumber(_), _) => fail(format!("a number [{}]", p.unit)),
        (Kind::Word(words), Value::Word(w)) if words.contains(&w.as_str()) => Ok(()),
        (Kind::Word(words), _) => fail(format!("one of {}", words.join(", "))),
        (Kind::Matrix, Value::List(l)) if matches!(l.len(), 3 | 9) && l.iter().all(|x| x.is_finite()) => Ok(()),
        (Kind::Vector(_), Value::List(l)) if l.len() == 3 && l.iter().all(|x| x.is_finite()) => Ok(()),
        (Kind::Vector(_), _) => fail("a list of 3 numbers".into()),
        (Kind::Matrix, _) => fail("a list of 3 (diagonal) or 9 (by rows) numbers".into()),
    }
}

/// The end of a message about an unknown word: the nearest known one if there is one, else all of them.
pub fn hint(word: &str, known: &[&str]) -> String {
    let near = known.iter().map(|k| (strsim::jaro_winkler(word, k), k)).max_by(|a, b| a.0.total_cmp(&b.0));
    match near {
        Some((score, name)) if score > 0.8 => format!("; did you mean `{name}`?"),
        _ if known.is_empty() => "; none is known here".into(),
        _ => format!("; known are {}", known.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: [Parameter; 3] = [
        Parameter { name: "bulk_modulus", unit: "Pa", kind: Kind::Number(Range::POSITIVE), about: "κ" },
        Parameter { name: "alpha", unit: "1", kind: Kind::NumberOr(Range::NOT_NEGATIVE, 0.0), about: "α" },
        Parameter { name: "formulation", unit: "1", kind: Kind::Word(&["default", "as_written"]), about: "mode" },
    ];

    fn given(pairs: &[(&str, Value)]) -> Result<Params, ParamError> {
        Params::new(TABLE.to_vec(), pairs.iter().map(|(k, v)| (k.to_string(), v.clone())).collect())
    }

    #[test]
    fn good_values_are_read_and_defaults_filled_in() {
        let p = given(&[("bulk_modulus", Value::Number(2.0))]).unwrap();
        assert_eq!((p.number("bulk_modulus"), p.number("alpha"), p.word("formulation")), (2.0, 0.0, "default"));
    }

    #[test]
    fn bad_values_name_key_unit_range_and_the_nearest_key() {
        let message = |pairs: &[(&str, Value)]| given(pairs).unwrap_err().message;
        assert_eq!(message(&[]), "`bulk_modulus` [Pa] is missing: κ");
        assert_eq!(message(&[("bulk_modulus", Value::Number(-1.0))]), "`bulk_modulus` = -1 must be above 0 [Pa]: κ");
        assert!(message(&[("bulk_modulus", Value::Number(f64::NAN))]).contains("must be above 0"));
        assert_eq!(
            message(&[("bulk_modulos", Value::Number(1.0))]),
            "unknown key `bulk_modulos`; did you mean `bulk_modulus`?"
        );
        assert!(message(&[("formulation", Value::Word("x".into()))]).contains("one of default, as_written"));
    }
}
