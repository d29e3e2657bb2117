//! Every key of a scene file in one table: kind, unit, range, default and what it does.
//!
//! The reader takes checks, defaults and the words of its messages from here, so a key cannot be read without being
//! documented. Help texts and a JSON schema can be made from the same table. In a path, `NAME` stands for a name that
//! the scene chooses and `N` for a place in a list of tables, counted from 1 (overrides take its name as well).

mod body;
mod contact;
mod output;
mod scene;

use fissure_engine::params::Range;

/// Any finite number.
const ANY: Range = Range::open(f64::NEG_INFINITY, f64::INFINITY);
/// (0, 1]
const SHARE: Range = Range { low: (0.0, false), high: (1.0, true) };
const LENGTH: KeyKind = KeyKind::Number(Range::POSITIVE);

/// What a key takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyKind {
    /// Any text.
    Text,
    /// One of a few words.
    Word(&'static [&'static str]),
    /// A list of some of a few words, none twice.
    Words(&'static [&'static str]),
    /// A finite number.
    Number(Range),
    /// A finite number, or one word.
    NumberOr(Range, &'static str),
    /// A whole number, both ends included.
    Whole(u64, u64),
    /// `true` and nothing else.
    Yes,
    /// A list of 3 numbers, each in the range.
    Three(Range),
    /// A list of 3 numbers that are not all 0.
    Direction,
    /// A list of so many points of 3 numbers.
    Points(usize),
    /// A list of 2 or more pairs `[r, y]` with r ≥ 0.
    Profile,
    /// A table of its own.
    Table,
    /// A list of tables.
    Tables,
}

/// What happens where a key is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fallback {
    /// The scene is refused.
    Required,
    /// This value, in TOML.
    Toml(&'static str),
    /// Something that is no single value, in words.
    Said(&'static str),
}

/// The documentation of one key.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Where it stands, e.g. `body.NAME.density`.
    pub path: &'static str,
    /// What it takes.
    pub kind: KeyKind,
    /// SI unit; empty for what has none, `1` for pure numbers.
    pub unit: &'static str,
    /// What holds where it is left out.
    pub default: Fallback,
    /// One line of help.
    pub about: &'static str,
}

impl Key {
    /// The last part of the path: the key as it is written.
    pub fn name(&self) -> &'static str {
        self.path.rsplit('.').next().unwrap_or(self.path)
    }

    /// The table that it stands in: the path without its last part, empty for the top.
    pub fn table(&self) -> &'static str {
        self.path.rsplit_once('.').map_or("", |(table, _)| table)
    }

    /// The unit in brackets with a space before it, or nothing.
    pub fn unit_suffix(&self) -> String {
        if matches!(self.unit, "" | "1") { String::new() } else { format!(" [{}]", self.unit) }
    }

    /// What it takes, in words with unit and range: `a number above 0 [kg/m³]`.
    pub fn wants(&self) -> String {
        let of = |r: Range| if r == ANY { String::new() } else { format!(" {r}") };
        let words = match self.kind {
            KeyKind::Text => "a text in quotes".into(),
            KeyKind::Word(words) => format!("one of \"{}\"", words.join("\", \"")),
            KeyKind::Words(words) => format!("a list of any of \"{}\"", words.join("\", \"")),
            KeyKind::Number(r) => format!("a finite number{}", of(r)),
            KeyKind::NumberOr(r, word) => format!("\"{word}\" or a finite number{}", of(r)),
            KeyKind::Whole(low, high) => format!("a whole number from {low} to {high}"),
            KeyKind::Yes => "true (or left out)".into(),
            KeyKind::Three(r) if r == ANY => "a list of 3 finite numbers".into(),
            KeyKind::Three(r) => format!("a list of 3 numbers{}", of(r)),
            KeyKind::Direction => "a list of 3 finite numbers that are not all 0".into(),
            KeyKind::Points(n) => format!("a list of {n} points of 3 finite numbers each"),
            KeyKind::Profile => "a list of 2 or more points [r, y] with r of 0 or more".into(),
            KeyKind::Table => "a table".into(),
            KeyKind::Tables => "a list of tables".into(),
        };
        words + &self.unit_suffix()
    }
}

/// Keys of one table that exclude each other. In a file two of them are an error; one given with `--set` replaces the
/// other.
pub const RIVALS: &[(&str, &[&str])] = &[
    ("body.NAME", &["mesh", "shape"]),
    ("body.NAME", &["size", "tets"]),
    ("body.NAME", &["cells", "cell"]),
    ("body.NAME", &["horizon", "horizon_factor"]),
    ("body.NAME.cut.N", &["triangle", "rectangle"]),
    ("body.NAME.region.N", &["box", "ball", "label", "nearest"]),
    ("anchor.N", &["box", "ball", "all"]),
    ("collider.N", &["density", "mass"]),
    ("output", &["frames_per_second", "frame_every"]),
    ("output", &["checkpoint_every", "checkpoint_steps"]),
    ("compare.N", &["field", "track", "displacement", "force", "torque"]),
];

/// The tables whose further keys belong to a law or criterion, which declares and checks them.
pub const FREE: &[&str] =
    &["body.NAME.material", "body.NAME.fracture", "body.NAME.region.N.material", "body.NAME.region.N.fracture"];

/// The keys that each kind of shape takes; `segments` may be left out, the others not.
pub const SHAPES: &[(&str, &[&str])] = &[
    ("box", &["size"]),
    ("beam", &["length", "width"]),
    ("wall", &["width", "height", "thickness"]),
    ("sheet", &["width", "height", "thickness"]),
    ("ball", &["radius"]),
    ("cylinder", &["radius", "height"]),
    ("revolution", &["profile", "segments"]),
    ("vase", &["height", "wall"]),
];

/// The keys that each kind of collider takes; `scale` may be left out, the others not.
pub const COLLIDERS: &[(&str, &[&str])] = &[
    ("plane", &["normal"]),
    ("ball", &["radius"]),
    ("box", &["size"]),
    ("capsule", &["radius", "height"]),
    ("cylinder", &["radius", "height"]),
    ("hull", &["mesh", "scale"]),
    ("mesh", &["mesh", "scale"]),
];

/// The keys that may stand beside each kind of reference; what only one kind needs is said by its key.
pub const REFERENCES: &[(&str, &[&str])] = &[
    ("field", &["label", "body", "at", "translate"]),
    ("track", &["label", "body", "point"]),
    ("displacement", &["label", "body", "point", "along", "at"]),
    ("force", &["label", "anchor", "along", "at"]),
    ("torque", &["label", "anchor", "along", "at"]),
];

/// Every key of a scene file, in the order in which a help text shows them.
pub fn keys() -> &'static [Key] {
    &KEYS
}

/// The documentation of `name` in the table `table`.
pub(super) fn key(table: &str, name: &str) -> Option<&'static Key> {
    KEYS.iter().find(|k| k.table() == table && k.name() == name)
}

/// The names of all keys of the table `table`.
pub(super) fn names(table: &str) -> Vec<&'static str> {
    KEYS.iter().filter(|k| k.table() == table).map(Key::name).collect()
}

const fn of(path: &'static str, kind: KeyKind, unit: &'static str, default: Fallback, about: &'static str) -> Key {
    Key { path, kind, unit, default, about }
}

const PARTS: [&[Key]; 4] = [scene::KEYS, body::KEYS, contact::KEYS, output::KEYS];

const COUNT: usize = PARTS[0].len() + PARTS[1].len() + PARTS[2].len() + PARTS[3].len();

static KEYS: [Key; COUNT] = {
    let mut all = [PARTS[0][0]; COUNT];
    let (mut n, mut part) = (0, 0);
    while part < PARTS.len() {
        let mut k = 0;
        while k < PARTS[part].len() {
            all[n] = PARTS[part][k];
            (n, k) = (n + 1, k + 1);
        }
        part += 1;
    }
    all
};
