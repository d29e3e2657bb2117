//! Overrides from the command line, `key.path=value`, written into the text of the scene.
//!
//! The text stays the one truth: it is edited with its comments kept and read again, so what a run stores is what it did.
//! Values that an override wrote are remembered, and messages about them name it instead of a line.

use std::sync::Arc;

use fissure_engine::params::hint;
use toml_edit::{DocumentMut, Item as TomlItem, Key as TomlKey, Table as TomlTable, TableLike, Value as TomlValue};

use super::error::{Place, SceneError};
use super::keys::{self, FREE, KeyKind, RIVALS};
use super::reader;
use super::tree::{self, Item, Node};

/// The text and the tree with `overrides` in them.
pub(super) fn apply(
    text: &str,
    old: &Item,
    file: &Arc<str>,
    overrides: &[String],
) -> Result<(String, Item), SceneError> {
    let top = Place::Line { file: file.clone(), line: 1 };
    let syntax = |error: toml_edit::TomlError| SceneError::wrong(&top, error.message().to_owned());
    let mut document: DocumentMut = text.parse().map_err(syntax)?;
    let mut sets: Vec<(Vec<String>, Place)> = Vec::new();
    for given in overrides {
        let place = Place::Set(given.as_str().into());
        let wrong = |message: String| SceneError::wrong(&place, message);
        let (path, raw) = given
            .split_once('=')
            .ok_or_else(|| wrong("an override is key.path=value, for instance duration=0.5".into()))?;
        let path: Vec<String> = TomlKey::parse(path.trim())
            .map_err(|_| wrong(format!("`{}` is no path of keys, such as body.vase.tets", path.trim())))?
            .iter()
            .map(|key| key.get().to_owned())
            .collect();
        let path = numbered(path, old);
        let is_text = resolve(&path, old).map_err(wrong)?;
        let value = match raw.trim().parse::<TomlValue>() {
            Ok(value) if value.is_str() || !is_text => value,
            _ => TomlValue::from(raw.trim()),
        };
        let mut earlier: Vec<&[String]> = sets.iter().map(|(path, _)| path.as_slice()).collect();
        earlier.push(&path);
        put(document.as_table_mut(), &path, 0, value, &earlier).map_err(wrong)?;
        sets.push((path, place));
    }
    let text = document.to_string();
    let mut tree = tree::parse(&text, file)?;
    tree.settle(Some(old), &mut Vec::new(), &sets);
    Ok((text, tree))
}

/// `path` with numbers, counted from 1, for the names of listed tables: `collider.ball.density` is `collider.1.density`.
fn numbered(mut path: Vec<String>, old: &Item) -> Vec<String> {
    let mut item = Some(old);
    for part in &mut path {
        if part.parse::<usize>().is_err()
            && let Some(Node::List(list)) = item.map(|item| &item.node)
        {
            let called = |item: &Item| matches!(item.child("name").map(|name| &name.node), Some(Node::Text(name)) if name == part);
            if let Some(n) = list.iter().position(called) {
                *part = (n + 1).to_string();
            }
        }
        item = item.and_then(|item| item.child(part));
    }
    path
}

/// The path of a table in the documentation: `NAME` for bodies, `N` for listed tables.
fn documented(path: &[String]) -> String {
    path.iter().fold(String::new(), |above, part| below(&above, part))
}

/// The documented path of `part` in the table at the documented path `above`.
fn below(above: &str, part: &str) -> String {
    let child = match above {
        "" => return part.to_owned(),
        "body" => "NAME",
        _ if keys::keys().iter().any(|key| key.path == above && key.kind == KeyKind::Tables) => "N",
        _ => part,
    };
    format!("{above}.{child}")
}

/// Checks that `path` is one that scenes have and that its body or list element exists; tells whether it takes text.
fn resolve(path: &[String], old: &Item) -> Result<bool, String> {
    let mut documented = String::new();
    let mut title = String::from("the top of the scene");
    let mut item = Some(old);
    for (k, part) in path.iter().enumerate() {
        let inner = item.and_then(|item| item.child(part));
        let kind = keys::keys().iter().find(|key| key.path == documented).map(|key| key.kind);
        if documented == "body" {
            if inner.is_none() {
                let table = item.and_then(Item::as_table);
                let bodies: Vec<&str> = table.iter().flat_map(|t| &t.0).map(|(name, _)| name.as_str()).collect();
                return Err(format!("no body is called `{part}`{}", hint(part, &bodies)));
            }
        } else if kind == Some(KeyKind::Tables) {
            if inner.is_none() || part.parse::<usize>().is_err() {
                let count = match item.map(|item| &item.node) {
                    Some(Node::List(list)) => list.len(),
                    _ => 0,
                };
                return Err(format!(
                    "`{part}` is neither a name nor a number of one of the {count} tables [[{title}]], counted from 1"
                ));
            }
        } else if FREE.contains(&documented.as_str()) && k + 1 == path.len() {
            let key = keys::key(&documented, part);
            return Ok(key.is_some_and(|key| key.kind == KeyKind::Text));
        } else if keys::key(&documented, part).is_none() {
            let title = if k == 0 { title } else { format!("[{title}]") };
            return Err(reader::unknown(part, &title, &documented));
        }
        documented = below(&documented, part);
        title = if k == 0 { part.clone() } else { format!("{title}.{part}") };
        item = inner;
    }
    let kind = keys::keys().iter().find(|key| key.path == documented).map(|key| key.kind);
    Ok(matches!(kind, Some(KeyKind::Text | KeyKind::Word(_))))
}

/// Writes `value` at `path[at..]` of `table`, which itself stands at `path[..at]`. What excludes it goes, unless an
/// earlier override wrote it; then the reader will complain about both.
fn put(
    table: &mut dyn TableLike,
    path: &[String],
    at: usize,
    value: TomlValue,
    sets: &[&[String]],
) -> Result<(), String> {
    let key = &path[at];
    for rival in rivals(&path[..at], key) {
        let wrote = |set: &&[String]| set.len() > at && set[..at] == path[..at] && set[at] == rival;
        if !sets.iter().any(wrote) {
            table.remove(rival);
        }
    }
    if at + 1 == path.len() {
        match table.get_mut(key) {
            Some(slot) => {
                let mut value = value;
                if let Some(old) = slot.as_value() {
                    *value.decor_mut() = old.decor().clone();
                }
                *slot = TomlItem::Value(value);
            }
            None => {
                table.insert(key, TomlItem::Value(value));
            }
        }
        return Ok(());
    }
    if !table.contains_key(key) {
        table.insert(key, TomlItem::Table(TomlTable::new()));
    }
    let number = path[at + 1].parse::<usize>().ok().and_then(|n| n.checked_sub(1));
    let (inner, next) = match (table.get_mut(key), number) {
        (Some(TomlItem::ArrayOfTables(list)), Some(n)) => (list.get_mut(n).map(|t| t as &mut dyn TableLike), at + 2),
        (Some(TomlItem::Value(TomlValue::Array(list))), Some(n)) => {
            let table = list.get_mut(n).and_then(TomlValue::as_inline_table_mut);
            (table.map(|t| t as &mut dyn TableLike), at + 2)
        }
        (item, _) => (item.and_then(TomlItem::as_table_like_mut), at + 1),
    };
    match inner {
        Some(inner) if next < path.len() => put(inner, path, next, value, sets),
        Some(_) => Err(format!("`{}` is a whole table; set one of its keys", path.join("."))),
        None => Err(format!("`{}` is not a table in the scene, so nothing can be set in it", path[..=at].join("."))),
    }
}

/// The keys that `key` excludes in the table at `path`.
fn rivals(path: &[String], key: &str) -> impl Iterator<Item = &'static str> {
    let documented = documented(path);
    let groups = RIVALS.iter().filter(move |(table, _)| *table == documented);
    let key = key.to_owned();
    let mine = key.clone();
    groups
        .filter(move |(_, group)| group.contains(&mine.as_str()))
        .flat_map(|(_, group)| group.iter().copied())
        .filter(move |rival| *rival != key)
}
