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

/// Checks that `path` is one that scenes have and that its body or list element exists; tells whether it takes text.
fn resolve(path: &[String], old: &Item) -> Result<bool, String> {
    let mut documented = String::new();
    let mut title = String::from("the top of the scene");
    let mut item = Some(old);
    for (k, part) in path.iter().enumerate() {
        let inner = item.and_then(|item| item.child(part));
        let kind = keys::keys().iter().find(|key| key.path == documented).map(|key| key.kind);
        let child = if documented == "body" {
            if inner.is_none() {
                let table = item.and_then(Item::as_table);
                let bodies: Vec<&str> = table.iter().flat_map(|t| &t.0).map(|(name, _)| name.as_str()).collect();
                return Err(format!("no body is called `{part}`{}", hint(part, &bodies)));
            }
            "NAME"
        } else if kind == Some(KeyKind::Tables) {
            if inner.is_none() || part.parse::<usize>().is_err() {
                let count = match item.map(|item| &item.node) {
                    Some(Node::List(list)) => list.len(),
                    _ => 0,
                };
                return Err(format!("`{part}` is no number of one of the {count} tables [[{title}]], counted from 1"));
            }
            "N"
        } else if FREE.contains(&documented.as_str()) && k + 1 == path.len() {
            let key = keys::key(&documented, part);
            return Ok(key.is_some_and(|key| key.kind == KeyKind::Text));
        } else if keys::key(&documented, part).is_some() {
            part
        } else {
            let title = if k == 0 { title } else { format!("[{title}]") };
            return Err(reader::unknown(part, &title, &documented));
        };
        let joined = |left: &str, right: &str| if k == 0 { right.to_owned() } else { format!("{left}.{right}") };
        (documented, title) = (joined(&documented, child), joined(&title, part));
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
    let documented: Vec<&str> = path
        .iter()
        .enumerate()
        .map(|(k, part)| match k {
            1 if path[0] == "body" => "NAME",
            _ if k > 0 && matches!(path[k - 1].as_str(), "anchor" | "cut" | "region" | "pair" | "compare") => "N",
            _ => part,
        })
        .collect();
    let documented = documented.join(".");
    let groups = RIVALS.iter().filter(move |(table, _)| *table == documented);
    let key = key.to_owned();
    let mine = key.clone();
    groups
        .filter(move |(_, group)| group.contains(&mine.as_str()))
        .flat_map(|(_, group)| group.iter().copied())
        .filter(move |rival| *rival != key)
}
