//! A table of a scene file, read by key: checks, defaults and messages come from the documentation of the keys.
//!
//! Unknown keys are refused when a table is opened, before anything is missed, so that `densty` is answered with
//! `density` and not with "density is missing".

use fissure_engine::params::hint;
use glam::DVec3;

use super::error::{Place, SceneError};
use super::keys::{self, Fallback, Key, KeyKind};
use super::tree::{self, Item, Node, Table};

/// One table of the scene, known to hold documented keys only.
pub(super) struct Reader<'a> {
    /// Where the table begins.
    pub place: &'a Place,
    /// How messages call it: `[body.vase]`.
    pub title: String,
    /// Its place in the documentation: `body.NAME`.
    pub path: String,
    table: &'a Table,
}

/// What can be read from a value, given the documentation of its key. `None` where the value does not fit.
pub(super) trait Read: Sized {
    fn read(item: &Item, key: &Key) -> Option<Self>;
}

impl<'a> Reader<'a> {
    /// The whole scene.
    pub fn top(root: &'a Item) -> Result<Self, SceneError> {
        Self::open(root, "", "the top of the scene".into())
    }

    /// A table at `path` of the documentation.
    pub fn open(item: &'a Item, path: &str, title: String) -> Result<Self, SceneError> {
        let Some(table) = item.as_table() else {
            return Err(SceneError::wrong(&item.place, format!("{title} must be a table, not {item}")));
        };
        let reader = Self { place: &item.place, title, path: path.into(), table };
        let known = keys::names(path);
        if !keys::FREE.contains(&path) {
            for (name, item) in &table.0 {
                if !known.contains(&name.as_str()) {
                    return Err(SceneError::wrong(&item.place, unknown(name, &reader.title, path)));
                }
            }
        }
        Ok(reader)
    }

    /// The names and values of the table, in the order of the file.
    pub fn entries(&self) -> impl Iterator<Item = (&'a str, &'a Item)> + use<'a> {
        self.table.0.iter().map(|(name, item)| (name.as_str(), item))
    }

    /// Where `name` stands, or the table if it is not there.
    pub fn place_of(&self, name: &str) -> &'a Place {
        self.table.get(name).map_or(self.place, |item| &item.place)
    }

    /// An error at `name`.
    pub fn fail(&self, name: &str, message: String) -> SceneError {
        SceneError::wrong(self.place_of(name), message)
    }

    /// The value of `name`, its default, or an error if it has none.
    pub fn get<T: Read>(&self, name: &str) -> Result<T, SceneError> {
        let key = self.key(name);
        match (self.table.get(name), key.default) {
            (Some(item), _) => self.value(item, key),
            (None, Fallback::Toml(text)) => {
                let item = tree::value_at(text, self.place);
                self.value(&item.unwrap_or_else(|| panic!("the default of {} is no TOML", key.path)), key)
            }
            (None, _) => Err(self.missing(key)),
        }
    }

    /// The value of `name` if it is given.
    pub fn get_if<T: Read>(&self, name: &str) -> Result<Option<T>, SceneError> {
        let key = self.key(name);
        self.table.get(name).map(|item| self.value(item, key)).transpose()
    }

    /// The table `name` if it is given.
    pub fn table_if(&self, name: &str) -> Result<Option<Self>, SceneError> {
        let open = |item: &'a Item| Self::open(item, self.key(name).path, format!("[{}]", self.inner_title(name)));
        self.table.get(name).map(open).transpose()
    }

    /// The table `name`.
    pub fn table(&self, name: &str) -> Result<Self, SceneError> {
        self.table_if(name)?.ok_or_else(|| self.missing(self.key(name)))
    }

    /// The tables of the list `name`, none if it is not given.
    pub fn tables(&self, name: &str) -> Result<Vec<Self>, SceneError> {
        let key = self.key(name);
        let Some(item) = self.table.get(name) else { return Ok(Vec::new()) };
        let Node::List(list) = &item.node else { return Err(self.unfit(item, key)) };
        let outer = self.inner_title(name);
        let open = |(k, item)| Self::open(item, &format!("{}.N", key.path), format!("[[{outer}]] {}", k + 1));
        list.iter().enumerate().map(open).collect()
    }

    /// Which one of `names` is given; none is `None`. The later one of two is to blame.
    pub fn one_of(&self, names: &[&str]) -> Result<Option<&'a str>, SceneError> {
        let mut given = self.entries().map(|(name, _)| name).filter(|name| names.contains(name));
        match (given.next(), given.next()) {
            (Some(first), Some(second)) => {
                let message = format!("both `{first}` and `{second}` are given in {}; keep one of them", self.title);
                Err(self.fail(second, message))
            }
            (one, _) => Ok(one),
        }
    }

    /// Exactly one of `names`.
    pub fn exactly_one_of(&self, names: &[&str]) -> Result<&'a str, SceneError> {
        self.one_of(names)?.ok_or_else(|| {
            let message = format!("{} needs exactly one of `{}`", self.title, names.join("`, `"));
            SceneError::wrong(self.place, message)
        })
    }

    /// The dotted name of a table below this one.
    fn inner_title(&self, name: &str) -> String {
        if self.path.is_empty() { name.into() } else { format!("{}.{name}", self.title.replace(['[', ']'], "")) }
    }

    fn key(&self, name: &str) -> &'static Key {
        keys::key(&self.path, name).unwrap_or_else(|| panic!("`{name}` in `{}` is not documented", self.path))
    }

    fn value<T: Read>(&self, item: &Item, key: &Key) -> Result<T, SceneError> {
        T::read(item, key).ok_or_else(|| self.unfit(item, key))
    }

    fn unfit(&self, item: &Item, key: &Key) -> SceneError {
        let near = match (&item.node, key.kind) {
            (Node::Text(word), KeyKind::Word(words)) => match hint(word, words) {
                near if near.starts_with("; did") => near,
                _ => String::new(),
            },
            _ => String::new(),
        };
        let message = format!("`{}` = {item} in {} must be {}{near}", key.name(), self.title, key.wants());
        SceneError::wrong(&item.place, message)
    }

    /// The error for a key that has to be given.
    pub fn missing(&self, key: &Key) -> SceneError {
        let message = format!("`{}`{} is missing in {}: {}", key.name(), key.unit_suffix(), self.title, key.about);
        SceneError::wrong(self.place, message)
    }
}

/// The sentence about a key that the table at `path` does not have: the nearest one, or where it belongs.
pub(super) fn unknown(name: &str, title: &str, path: &str) -> String {
    let near = hint(name, &keys::names(path));
    let elsewhere = keys::keys().iter().find(|k| k.name() == name && !matches!(name, "N" | "NAME"));
    match elsewhere {
        Some(key) if !near.starts_with("; did") => {
            let home =
                if key.table().is_empty() { "the top of the scene".into() } else { format!("[{}]", key.table()) };
            format!("unknown key `{name}` in {title}; it belongs in {home}")
        }
        _ => format!("unknown key `{name}` in {title}{near}"),
    }
}

impl Read for f64 {
    fn read(item: &Item, key: &Key) -> Option<Self> {
        let KeyKind::Number(range) = key.kind else { return None };
        item.as_number().filter(|x| range.contains(*x))
    }
}

/// A number, or the word that stands for none.
pub(super) struct Unless(pub Option<f64>);

impl Read for Unless {
    fn read(item: &Item, key: &Key) -> Option<Self> {
        let KeyKind::NumberOr(range, word) = key.kind else { return None };
        match &item.node {
            Node::Text(text) => (text == word).then_some(Self(None)),
            _ => item.as_number().filter(|x| range.contains(*x)).map(|x| Self(Some(x))),
        }
    }
}

impl Read for u64 {
    fn read(item: &Item, key: &Key) -> Option<Self> {
        let KeyKind::Whole(low, high) = key.kind else { return None };
        let n = match item.node {
            Node::Whole(n) => Self::try_from(n).ok()?,
            // 3e5 is how one writes a large count; above 2^53 a float is no count any more
            Node::Number(x) if x.fract() == 0.0 && (0.0..=9.0e15).contains(&x) => x as Self,
            _ => return None,
        };
        (low..=high).contains(&n).then_some(n)
    }
}

impl Read for bool {
    fn read(item: &Item, _: &Key) -> Option<Self> {
        matches!(item.node, Node::Flag(true)).then_some(true)
    }
}

impl Read for String {
    fn read(item: &Item, key: &Key) -> Option<Self> {
        let Node::Text(text) = &item.node else { return None };
        match key.kind {
            KeyKind::Word(words) => words.contains(&text.as_str()).then(|| text.clone()),
            _ => Some(text.clone()),
        }
    }
}

impl Read for Vec<String> {
    fn read(item: &Item, key: &Key) -> Option<Self> {
        let (Node::List(list), KeyKind::Words(words)) = (&item.node, key.kind) else { return None };
        let mut all = Self::new();
        for item in list {
            match &item.node {
                Node::Text(word) if words.contains(&word.as_str()) && !all.contains(word) => all.push(word.clone()),
                _ => return None,
            }
        }
        Some(all)
    }
}

impl Read for DVec3 {
    fn read(item: &Item, key: &Key) -> Option<Self> {
        let x = Self::from_array(numbers(item)?);
        match key.kind {
            KeyKind::Three(range) => x.to_array().iter().all(|c| range.contains(*c)).then_some(x),
            KeyKind::Direction => x.try_normalize().map(|_| x),
            _ => None,
        }
    }
}

impl<const N: usize> Read for [DVec3; N] {
    fn read(item: &Item, _: &Key) -> Option<Self> {
        let Node::List(list) = &item.node else { return None };
        let points: Vec<DVec3> = list.iter().map(|p| numbers(p).map(DVec3::from_array)).collect::<Option<_>>()?;
        points.try_into().ok()
    }
}

impl Read for Vec<[f64; 2]> {
    fn read(item: &Item, _: &Key) -> Option<Self> {
        let Node::List(list) = &item.node else { return None };
        let points: Self = list.iter().map(|p| numbers(p).filter(|[r, _]| *r >= 0.0)).collect::<Option<_>>()?;
        (points.len() >= 2).then_some(points)
    }
}

/// A list of exactly `N` finite numbers.
fn numbers<const N: usize>(item: &Item) -> Option<[f64; N]> {
    let Node::List(list) = &item.node else { return None };
    let numbers: Vec<f64> = list.iter().map(|c| c.as_number().filter(|x| x.is_finite())).collect::<Option<_>>()?;
    numbers.try_into().ok()
}
