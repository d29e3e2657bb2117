//! TOML text as a plain tree in which every value knows where it stands.
//!
//! `toml_edit` rather than `toml`: its tables keep the order of the file, and the same crate writes overrides into the
//! text.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use toml_edit::{Document, Item as TomlItem, TableLike, Value as TomlValue};

use super::error::{Place, SceneError, one_line};

/// A value and where it stands.
#[derive(Clone, Debug)]
pub(super) struct Item {
    pub place: Place,
    pub node: Node,
}

/// The kinds of value.
#[derive(Clone, Debug)]
pub(super) enum Node {
    Number(f64),
    Whole(i64),
    Text(String),
    /// Booleans, and dates as text: what a scene has little use for.
    Flag(bool),
    Date(String),
    List(Vec<Item>),
    Table(Table),
}

/// Keys with their values, in the order of the file.
#[derive(Clone, Debug, Default)]
pub(super) struct Table(pub Vec<(String, Item)>);

impl Table {
    pub fn get(&self, key: &str) -> Option<&Item> {
        self.0.iter().find(|(k, _)| k == key).map(|(_, item)| item)
    }
}

impl Item {
    pub fn as_table(&self) -> Option<&Table> {
        match &self.node {
            Node::Table(table) => Some(table),
            _ => None,
        }
    }

    /// A number, whole or not.
    pub fn as_number(&self) -> Option<f64> {
        match self.node {
            Node::Number(x) => Some(x),
            Node::Whole(n) => Some(n as f64),
            _ => None,
        }
    }

    /// What stands under `key`: in a table the key, in a list the place counted from 1.
    pub fn child(&self, key: &str) -> Option<&Self> {
        match &self.node {
            Node::Table(table) => table.get(key),
            Node::List(list) => list.get(key.parse::<usize>().ok()?.checked_sub(1)?),
            _ => None,
        }
    }

    /// Everything directly below, with the names that [`Self::child`] takes.
    fn children_mut(&mut self) -> Vec<(String, &mut Self)> {
        match &mut self.node {
            Node::Table(table) => table.0.iter_mut().map(|(k, item)| (k.clone(), item)).collect(),
            Node::List(list) => list.iter_mut().enumerate().map(|(k, item)| ((k + 1).to_string(), item)).collect(),
            _ => Vec::new(),
        }
    }

    /// Gives every value of an edited tree its place: the override that wrote it, else where it stood in `old`, else the
    /// override for whose sake it was made.
    pub fn settle(&mut self, old: Option<&Self>, path: &mut Vec<String>, sets: &[(Vec<String>, Place)]) {
        let wrote = sets.iter().rfind(|(set, _)| path.starts_with(set));
        let made = sets.iter().rfind(|(set, _)| set.starts_with(path));
        match (wrote, old, made) {
            (Some((_, place)), ..) | (None, None, Some((_, place))) => self.place = place.clone(),
            (None, Some(old), _) => self.place = old.place.clone(),
            (None, None, None) => {}
        }
        for (name, child) in self.children_mut() {
            let old = old.and_then(|o| o.child(&name));
            path.push(name);
            child.settle(old, path, sets);
            path.pop();
        }
    }
}

impl fmt::Display for Item {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.node {
            Node::Number(x) => write!(f, "{x}"),
            Node::Whole(n) => write!(f, "{n}"),
            Node::Text(text) => write!(f, "{text:?}"),
            Node::Flag(flag) => write!(f, "{flag}"),
            Node::Date(date) => f.write_str(date),
            Node::Table(_) => f.write_str("{..}"),
            Node::List(list) => {
                f.write_str("[")?;
                for (k, item) in list.iter().take(4).enumerate() {
                    write!(f, "{}{item}", if k > 0 { ", " } else { "" })?;
                }
                f.write_str(if list.len() > 4 { ", ..]" } else { "]" })
            }
        }
    }
}

/// The lines of a text.
struct Lines {
    file: Arc<str>,
    ends: Vec<usize>,
}

impl Lines {
    fn new(text: &str, file: &Arc<str>) -> Self {
        Self { file: file.clone(), ends: text.match_indices('\n').map(|(at, _)| at).collect() }
    }

    fn place(&self, span: Option<Range<usize>>) -> Option<Place> {
        let start = span?.start;
        Some(Place::Line { file: self.file.clone(), line: 1 + self.ends.partition_point(|&end| end < start) })
    }
}

/// Reads a whole TOML text.
pub(super) fn parse(text: &str, file: &Arc<str>) -> Result<Item, SceneError> {
    let lines = Lines::new(text, file);
    let top = Place::Line { file: file.clone(), line: 1 };
    let document = Document::parse(text).map_err(|error| SceneError::Syntax {
        place: lines.place(error.span()).unwrap_or_else(|| top.clone()),
        message: sentence(text, &error),
    })?;
    Ok(Item { node: Node::Table(table(document.as_table(), &top, &lines)), place: top })
}

/// Every value of a TOML text that is no table, with its key as in `--set`: `body.vase.tets`, `anchor.1.box`. Lists of
/// plain values stay whole, and whole numbers are written as the same number is with a point.
pub fn flat_keys(text: &str, file: &Arc<str>) -> Result<Vec<(String, String)>, SceneError> {
    fn plain(item: &Item) -> String {
        match &item.node {
            Node::List(list) => format!("[{}]", list.iter().map(plain).collect::<Vec<_>>().join(", ")),
            Node::Whole(n) if (*n as f64) as i64 == *n => format!("{}", *n as f64),
            _ => item.to_string(),
        }
    }
    fn walk(item: &Item, path: &str, out: &mut Vec<(String, String)>) {
        let under = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
        match &item.node {
            Node::Table(table) => table.0.iter().for_each(|(name, item)| walk(item, &under(name), out)),
            Node::List(list) if list.iter().any(|item| item.as_table().is_some()) => {
                list.iter().enumerate().for_each(|(k, item)| walk(item, &under(&(k + 1).to_string()), out));
            }
            _ => out.push((path.to_owned(), plain(item))),
        }
    }
    let mut out = Vec::new();
    walk(&parse(text, file)?, "", &mut out);
    Ok(out)
}

/// Reads a single TOML value, for defaults: everything in it stands at `place`.
pub(super) fn value_at(text: &str, place: &Place) -> Option<Item> {
    let lines = Lines { file: "".into(), ends: Vec::new() };
    let mut item = value(&text.parse().ok()?, place, &lines);
    item.settle(None, &mut Vec::new(), &[(Vec::new(), place.clone())]);
    Some(item)
}

/// What the parser says, on one line, with the text that it says it about.
fn sentence(text: &str, error: &toml_edit::TomlError) -> String {
    let start = error.span().map_or(0, |span| span.start);
    let before = text.get(..start).unwrap_or("").rfind('\n').map_or(0, |end| end + 1);
    let line = text.get(before..).and_then(|rest| rest.lines().next()).unwrap_or("").trim();
    let message = error.message().lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join("; ");
    match error.span().and_then(|span| text.get(span)) {
        Some(key) if message == "duplicate key" && !line.starts_with('[') => {
            format!("the key `{}` is given twice; keep one of them", one_line(key))
        }
        Some(_) if message == "duplicate key" => {
            format!("{} is given twice; keep one of them, or give the second its own name", one_line(line))
        }
        _ => format!("this is not TOML: {message}, in `{}`", one_line(line)),
    }
}

fn table(from: &dyn TableLike, outer: &Place, lines: &Lines) -> Table {
    let entry = |(name, item): (&str, &TomlItem)| {
        let key = from.get_key_value(name).and_then(|(key, _)| lines.place(key.span()));
        // a header stands where its own line is, not where a table below it first mentions the name
        let header = item.as_table().and_then(|t| lines.place(t.span()));
        let place = header.or(key).unwrap_or_else(|| outer.clone());
        let node = match item {
            TomlItem::None => return None,
            TomlItem::Value(v) => value(v, &place, lines).node,
            TomlItem::Table(t) => Node::Table(table(t, &place, lines)),
            TomlItem::ArrayOfTables(list) => {
                let one = |t: &toml_edit::Table| {
                    let place = lines.place(t.span()).unwrap_or_else(|| place.clone());
                    Item { node: Node::Table(table(t, &place, lines)), place }
                };
                Node::List(list.iter().map(one).collect())
            }
        };
        Some((name.to_owned(), Item { place, node }))
    };
    Table(from.iter().filter_map(entry).collect())
}

fn value(from: &TomlValue, outer: &Place, lines: &Lines) -> Item {
    let place = lines.place(from.span()).unwrap_or_else(|| outer.clone());
    let node = match from {
        TomlValue::String(s) => Node::Text(s.value().clone()),
        TomlValue::Integer(n) => Node::Whole(*n.value()),
        TomlValue::Float(x) => Node::Number(*x.value()),
        TomlValue::Boolean(b) => Node::Flag(*b.value()),
        TomlValue::Datetime(d) => Node::Date(d.value().to_string()),
        TomlValue::Array(list) => Node::List(list.iter().map(|v| value(v, &place, lines)).collect()),
        TomlValue::InlineTable(t) => Node::Table(table(t, &place, lines)),
    };
    Item { place, node }
}
