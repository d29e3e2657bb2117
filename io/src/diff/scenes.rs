//! Two scenes, key by key.

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use super::DiffError;
use crate::scene::flat_keys;

/// A key that two scenes do not give alike.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyDiff {
    /// The key, with the numbers of lists from 1, such as `anchor.1.box`.
    pub key: String,
    /// What either scene says; nothing where it has no such key.
    pub values: [Option<String>; 2],
}

impl fmt::Display for KeyDiff {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.values {
            [Some(a), Some(b)] => write!(f, "{}: {a} became {b}", self.key),
            [Some(a), None] => write!(f, "{} = {a}: only in the first", self.key),
            [_, b] => write!(f, "{} = {}: only in the second", self.key, b.as_deref().unwrap_or("")),
        }
    }
}

/// The keys that differ between two texts of scenes, in the order of the first. Numbers are compared as numbers: 1 is 1.0.
/// `names` are for messages.
///
/// # Errors
/// A text that is no TOML.
pub fn scenes(texts: [&str; 2], names: [&Path; 2]) -> Result<Vec<KeyDiff>, DiffError> {
    let keys = |k: usize| flat_keys(texts[k], &Arc::from(names[k].display().to_string()));
    let (a, b) = (keys(0)?, keys(1)?);
    let find = |keys: &[(String, String)], key: &str| keys.iter().find(|(k, _)| k == key).map(|(_, v)| v.clone());
    let mut out = Vec::new();
    for (key, value) in &a {
        let other = find(&b, key);
        if other.as_ref() != Some(value) {
            out.push(KeyDiff { key: key.clone(), values: [Some(value.clone()), other] });
        }
    }
    for (key, value) in b.iter().filter(|(key, _)| find(&a, key).is_none()) {
        out.push(KeyDiff { key: key.clone(), values: [None, Some(value.clone())] });
    }
    Ok(out)
}
