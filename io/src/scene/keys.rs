//! Every key of a scene file in one table: kind, unit, range, default and what it does.
//!
//! The reader takes checks, defaults and the words of its messages from here, so a key cannot be read without being
//! documented. Help texts and a JSON schema can be made from the same table. In a path, `NAME` stands for a name that
//! the scene chooses and `N` for a place in a list of tables, counted from 1.

use fissure_engine::params::Range;

/// Any finite number.
const ANY: Range = Range::open(f64::NEG_INFINITY, f64::INFINITY);
/// (0, 1]
const SHARE: Range = Range { low: (0.0, false), high: (1.0, true) };
/// [0, 1]
const SHARE_OR_0: Range = Range { low: (0.0, true), high: (1.0, true) };
const LENGTH: KeyKind = KeyKind::Number(Range::POSITIVE);

/// What a key takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyKind {
    /// Any text.
    Text,
    /// One of a few words.
    Word(&'static [&'static str]),
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
    KEYS
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

use Fallback::{Required, Said, Toml};
use KeyKind::{Direction, Number, NumberOr, Points, Profile, Table, Tables, Text, Three, Whole, Word, Yes};

const KEYS: &[Key] = &[
    of("title", Text, "", Toml("''"), "one line that says what is shown"),
    of("duration", Number(Range::POSITIVE), "s", Required, "simulated time"),
    of("gravity", Three(ANY), "m/s²", Toml("[0, -9.81, 0]"), "acceleration of everything that is not held"),
    of(
        "dt",
        NumberOr(Range::POSITIVE, "auto"),
        "s",
        Toml("'auto'"),
        "time step; \"auto\" takes the largest stable one times `safety`",
    ),
    of("safety", Number(SHARE), "1", Toml("0.8"), "share of the largest stable step that dt = \"auto\" takes"),
    of(
        "integrator",
        Word(&["symplectic_euler", "velocity_verlet", "relax"]),
        "",
        Toml("'symplectic_euler'"),
        "how forces become motion; \"relax\" makes every step an equilibrium, in which particles meet colliders but not each other, and dt = \"auto\" one step a frame",
    ),
    of(
        "residual",
        Number(Range::open(0.0, 1.0)),
        "1",
        Toml("1e-5"),
        "of \"relax\": unbalanced force that is small enough, as a share of the forces on held particles or the weight",
    ),
    of(
        "iterations",
        Whole(1, 1_000_000_000_000),
        "",
        Toml("100_000"),
        "of \"relax\": force evaluations of one step after which it is given up",
    ),
    of("seed", Whole(0, i64::MAX as u64), "", Toml("1"), "seed of every random number of the run"),
    of("body", Table, "", Required, "the bodies, one table [body.NAME] each, in the order of the file"),
    of("body.NAME", Table, "", Said("none"), "one body; NAME is used in messages, anchors and output"),
    of(
        "body.NAME.mesh",
        Text,
        "",
        Said("`shape` is given"),
        "path of a surface or of tetrahedra, relative to the scene file",
    ),
    of("body.NAME.shape", Table, "", Said("`mesh` is given"), "a generated shape"),
    of(
        "body.NAME.shape.kind",
        Word(&["box", "beam", "wall", "sheet", "ball", "cylinder", "revolution", "vase"]),
        "",
        Required,
        "which shape",
    ),
    of("body.NAME.shape.size", Three(Range::POSITIVE), "m", Said("required by box"), "edges of a box along x, y, z"),
    of("body.NAME.shape.length", LENGTH, "m", Said("required by beam"), "length of a beam"),
    of(
        "body.NAME.shape.width",
        LENGTH,
        "m",
        Said("required by beam, wall, sheet"),
        "width of a wall or sheet; both edges of a beam's cross-section",
    ),
    of("body.NAME.shape.height", LENGTH, "m", Said("required by wall, sheet, cylinder, vase"), "height"),
    of("body.NAME.shape.thickness", LENGTH, "m", Said("required by wall, sheet"), "thickness of a wall or sheet"),
    of("body.NAME.shape.radius", LENGTH, "m", Said("required by ball, cylinder"), "radius"),
    of(
        "body.NAME.shape.profile",
        Profile,
        "m",
        Said("required by revolution"),
        "points [r, y] of the outline that turns about the y axis",
    ),
    of(
        "body.NAME.shape.segments",
        Whole(3, 100_000),
        "",
        Toml("64"),
        "how many segments a revolution has around the axis",
    ),
    of("body.NAME.shape.wall", LENGTH, "m", Said("required by vase"), "wall thickness of a vase"),
    of(
        "body.NAME.size",
        LENGTH,
        "m",
        Said("`tets` decides"),
        "edge length wanted of the tetrahedra that fill a surface",
    ),
    of(
        "body.NAME.tets",
        Whole(1, 1_000_000_000),
        "",
        Toml("20000"),
        "how many tetrahedra are wanted to fill a surface",
    ),
    of("body.NAME.cells", Whole(8, 1_000_000_000), "", Toml("2000"), "of a lattice: how many cells are wanted, about"),
    of("body.NAME.cell", LENGTH, "m", Said("`cells` decides"), "of a lattice: edge of a cell"),
    of("body.NAME.memory", Whole(1, 1 << 30), "MiB", Toml("4096"), "of a lattice: memory that making it may take"),
    of(
        "body.NAME.crack_faces",
        Table,
        "",
        Said("noisy"),
        "of a lattice: how faces between cells look where they open (Ohta et al., Fig. 4)",
    ),
    of(
        "body.NAME.crack_faces.kind",
        Word(&["noisy", "fitted", "raw"]),
        "",
        Toml("'noisy'"),
        "bent, plane and ending at the surface, or whole cubes outside as within",
    ),
    of("body.NAME.crack_faces.noise", Number(SHARE_OR_0), "1", Toml("0.7"), "how far faces are bent, in cells"),
    of(
        "body.NAME.crack_faces.scale",
        Number(Range::POSITIVE),
        "1",
        Toml("2.8"),
        "size of the bends in cells; at least 4 times `noise`",
    ),
    of("body.NAME.crack_faces.seed", Whole(0, i64::MAX as u64), "", Toml("1"), "which of many noises"),
    of("body.NAME.shell", LENGTH, "m", Said("solid"), "makes the surface a solid wall of this thickness"),
    of(
        "body.NAME.scale",
        Number(Range::POSITIVE),
        "1",
        Toml("1"),
        "enlarges the mesh about the origin, before `rotate`",
    ),
    of(
        "body.NAME.rotate",
        Table,
        "",
        Said("not turned"),
        "turns the mesh about an axis through the origin, after `scale`",
    ),
    of("body.NAME.rotate.axis", Direction, "1", Required, "axis of the turn; its length does not matter"),
    of("body.NAME.rotate.degrees", Number(ANY), "°", Required, "angle of the turn, by the right hand"),
    of("body.NAME.translate", Three(ANY), "m", Toml("[0, 0, 0]"), "shifts the mesh, after `rotate`"),
    of("body.NAME.density", Number(Range::POSITIVE), "kg/m³", Required, "mass per volume"),
    of("body.NAME.velocity", Three(ANY), "m/s", Toml("[0, 0, 0]"), "velocity at the start"),
    of(
        "body.NAME.spin",
        Three(ANY),
        "rad/s",
        Toml("[0, 0, 0]"),
        "angular velocity at the start, about the centre of mass",
    ),
    of("body.NAME.horizon", LENGTH, "m", Said("`horizon_factor` decides"), "radius within which particles are bonded"),
    of(
        "body.NAME.horizon_factor",
        Number(Range::POSITIVE),
        "1",
        Toml("1.4"),
        "the same as a multiple of the mean edge length of the tetrahedra",
    ),
    of(
        "body.NAME.surface",
        Word(&["smooth", "as_written"]),
        "",
        Toml("'smooth'"),
        "how the embedded surface follows the particles (Chen et al., Eqs. 20-22)",
    ),
    of("body.NAME.material", Table, "", Required, "the constitutive law; its own keys stand beside `law`"),
    of("body.NAME.material.law", Text, "", Required, "name of a law; `fissure materials` lists them"),
    of(
        "body.NAME.fracture",
        Table,
        "",
        Said("unbreakable"),
        "the fracture criterion; its own keys stand beside `criterion`",
    ),
    of(
        "body.NAME.fracture.criterion",
        Text,
        "",
        Toml("'critical_stretch'"),
        "name of a criterion; `fissure materials` lists them",
    ),
    of(
        "body.NAME.region",
        Tables,
        "",
        Said("none"),
        "parts of the body made of something else; where several hold a particle, the last one has it",
    ),
    of("body.NAME.region.N.name", Text, "", Said("\"region N\", N from 1"), "name for messages and interfaces"),
    of(
        "body.NAME.region.N.box",
        Points(2),
        "m",
        Said("another place is given"),
        "lowest and highest corner, where the body stands at the start",
    ),
    of(
        "body.NAME.region.N.ball",
        Table,
        "",
        Said("another place is given"),
        "a ball, where the body stands at the start",
    ),
    of("body.NAME.region.N.ball.centre", Three(ANY), "m", Required, "centre of the ball"),
    of("body.NAME.region.N.ball.radius", LENGTH, "m", Required, "radius of the ball"),
    of(
        "body.NAME.region.N.label",
        Whole(0, i64::MAX as u64),
        "",
        Said("another place is given"),
        "label of its tetrahedra in the mesh file (physical group, region attribute, material id)",
    ),
    of(
        "body.NAME.region.N.nearest",
        Text,
        "",
        Said("another place is given"),
        "path of a closed surface; what lies nearer to it than to `than` is in the region",
    ),
    of(
        "body.NAME.region.N.than",
        Text,
        "",
        Said("required by nearest"),
        "path of the other surface; both stand as the mesh of the body does",
    ),
    of("body.NAME.region.N.density", Number(Range::POSITIVE), "kg/m³", Said("that of the body"), "mass per volume"),
    of(
        "body.NAME.region.N.material",
        Table,
        "",
        Said("that of the body"),
        "the constitutive law of the region, with all of its keys",
    ),
    of("body.NAME.region.N.material.law", Text, "", Required, "name of a law; `fissure materials` lists them"),
    of(
        "body.NAME.region.N.fracture",
        Table,
        "",
        Said("that of the body"),
        "the fracture criterion of the region, with all of its keys",
    ),
    of(
        "body.NAME.region.N.fracture.criterion",
        Text,
        "",
        Toml("'critical_stretch'"),
        "name of a criterion; `fissure materials` lists them",
    ),
    of("body.NAME.interface", Table, "", Said("as strong as the weaker side"), "the bonds between regions"),
    of(
        "body.NAME.interface.strength",
        Number(Range::POSITIVE),
        "1",
        Toml("1"),
        "share of the severity at which they break: 1 as the weaker of the two materials, 0.2 at a fifth",
    ),
    of("body.NAME.interface.pair", Tables, "", Said("none"), "interfaces with a strength of their own"),
    of("body.NAME.interface.pair.N.of", Text, "", Required, "name of a region, or of the body for what is in none"),
    of("body.NAME.interface.pair.N.and", Text, "", Required, "name of the other region"),
    of("body.NAME.interface.pair.N.strength", Number(Range::POSITIVE), "1", Required, "strength between these two"),
    of("body.NAME.cut", Tables, "", Said("none"), "cuts that the body starts with: bonds that cross one are not made"),
    of(
        "body.NAME.cut.N.triangle",
        Points(3),
        "m",
        Said("`rectangle` is given"),
        "corners of a triangle, where the body stands at the start",
    ),
    of(
        "body.NAME.cut.N.rectangle",
        Table,
        "",
        Said("`triangle` is given"),
        "a parallelogram, where the body stands at the start",
    ),
    of("body.NAME.cut.N.rectangle.corner", Three(ANY), "m", Required, "one corner"),
    of("body.NAME.cut.N.rectangle.u", Direction, "m", Required, "edge from the corner"),
    of("body.NAME.cut.N.rectangle.v", Direction, "m", Required, "other edge from the corner"),
    of("anchor", Tables, "", Said("none"), "particles that are held or moved, one table [[anchor]] each"),
    of("anchor.N.name", Text, "", Said("\"anchor N\", N from 1"), "name for messages and output"),
    of("anchor.N.body", Text, "", Required, "name of the body whose particles are held"),
    of(
        "anchor.N.box",
        Points(2),
        "m",
        Said("another region is given"),
        "lowest and highest corner of the region, where the body stands at the start",
    ),
    of(
        "anchor.N.ball",
        Table,
        "",
        Said("another region is given"),
        "the region as a ball, where the body stands at the start",
    ),
    of("anchor.N.ball.centre", Three(ANY), "m", Required, "centre of the ball"),
    of("anchor.N.ball.radius", LENGTH, "m", Required, "radius of the ball"),
    of("anchor.N.all", Yes, "", Said("another region is given"), "the whole body"),
    of("anchor.N.velocity", Three(ANY), "m/s", Toml("[0, 0, 0]"), "velocity of the motion"),
    of("anchor.N.spin", Three(ANY), "rad/s", Toml("[0, 0, 0]"), "angular velocity of the motion"),
    of("anchor.N.centre", Three(ANY), "m", Toml("[0, 0, 0]"), "point about which it turns"),
    of("anchor.N.from", Number(Range::NOT_NEGATIVE), "s", Toml("0"), "holds from this time"),
    of("anchor.N.until", Number(Range::POSITIVE), "s", Said("never"), "lets go at this time, later than `from`"),
    of("ground", Table, "", Said("no ground"), "a plane that nothing passes"),
    of("ground.height", Number(ANY), "m", Toml("0"), "distance of the plane from the origin along its normal"),
    of("ground.normal", Direction, "1", Toml("[0, 1, 0]"), "normal towards the free side; its length does not matter"),
    of(
        "ground.restitution",
        Number(Range::closed(0.0, 1.0)),
        "1",
        Toml("0.1"),
        "share of the normal speed that a rebound keeps",
    ),
    of("ground.friction", Number(Range::NOT_NEGATIVE), "1", Toml("0.5"), "Coulomb friction coefficient"),
    of("collider", Tables, "", Said("none"), "rigid things that nothing enters, one table [[collider]] each"),
    of("collider.N.name", Text, "", Said("\"collider N\", N from 1"), "name for messages and output"),
    of("collider.N.shape", Table, "", Required, "its shape about its origin, y along the axis of what has one"),
    of(
        "collider.N.shape.kind",
        Word(&["plane", "ball", "box", "capsule", "cylinder", "hull", "mesh"]),
        "",
        Required,
        "which shape; a hull is the convex hull of a mesh's vertices",
    ),
    of(
        "collider.N.shape.normal",
        Direction,
        "1",
        Said("required by plane"),
        "normal towards the free side; its length does not matter",
    ),
    of("collider.N.shape.radius", LENGTH, "m", Said("required by ball, capsule, cylinder"), "radius"),
    of("collider.N.shape.size", Three(Range::POSITIVE), "m", Said("required by box"), "edges along x, y, z"),
    of(
        "collider.N.shape.height",
        LENGTH,
        "m",
        Said("required by capsule, cylinder"),
        "whole height; of a capsule more than twice the radius",
    ),
    of(
        "collider.N.shape.mesh",
        Text,
        "",
        Said("required by hull, mesh"),
        "path of a surface, relative to the scene file; as a mesh it must be closed",
    ),
    of("collider.N.shape.scale", Number(Range::POSITIVE), "1", Toml("1"), "enlarges the mesh about its origin"),
    of("collider.N.position", Three(ANY), "m", Toml("[0, 0, 0]"), "where its origin is at the start"),
    of("collider.N.rotate", Table, "", Said("not turned"), "turns it about its origin"),
    of("collider.N.rotate.axis", Direction, "1", Required, "axis of the turn; its length does not matter"),
    of("collider.N.rotate.degrees", Number(ANY), "°", Required, "angle of the turn, by the right hand"),
    of(
        "collider.N.motion",
        Word(&["fixed", "keyframes", "free"]),
        "",
        Toml("'fixed'"),
        "whether it stands, is moved along `keyframe`, or moves as it is pushed",
    ),
    of("collider.N.density", Number(Range::POSITIVE), "kg/m³", Said("`mass` is given"), "of a free collider"),
    of("collider.N.mass", Number(Range::POSITIVE), "kg", Said("`density` is given"), "of a free collider"),
    of(
        "collider.N.inertia",
        Three(Range::POSITIVE),
        "kg m²",
        Said("that of its shape, evenly filled"),
        "moments of inertia of a free collider about its own axes through its centre of mass",
    ),
    of("collider.N.velocity", Three(ANY), "m/s", Toml("[0, 0, 0]"), "velocity of a free collider at the start"),
    of("collider.N.spin", Three(ANY), "rad/s", Toml("[0, 0, 0]"), "its angular velocity at the start"),
    of(
        "collider.N.keyframe",
        Tables,
        "",
        Said("none"),
        "places of a moved collider, in order of time; between them it moves evenly, outside it stands",
    ),
    of("collider.N.keyframe.N.time", Number(Range::NOT_NEGATIVE), "s", Required, "when"),
    of("collider.N.keyframe.N.position", Three(ANY), "m", Required, "where its origin is then"),
    of("collider.N.keyframe.N.rotate", Table, "", Said("not turned"), "how it is turned then"),
    of("collider.N.keyframe.N.rotate.axis", Direction, "1", Required, "axis of the turn; its length does not matter"),
    of(
        "collider.N.keyframe.N.rotate.degrees",
        Number(ANY),
        "°",
        Required,
        "angle of the turn, below 180 from the last",
    ),
    of(
        "collider.N.friction",
        Number(Range::NOT_NEGATIVE),
        "1",
        Toml("0.5"),
        "Coulomb friction coefficient with particles; with another collider the geometric mean",
    ),
    of(
        "collider.N.restitution",
        Number(Range::closed(0.0, 1.0)),
        "1",
        Toml("0.1"),
        "share of the normal speed that a rebound keeps; with another collider the larger",
    ),
    of(
        "contact",
        Table,
        "",
        Said("all defaults"),
        "how particles meet: other bodies, fragments, the other side of a crack",
    ),
    of("contact.particles", Word(&["on", "off"]), "", Toml("'on'"), "whether particles meet each other at all"),
    of(
        "contact.friction",
        Number(Range::NOT_NEGATIVE),
        "1",
        Toml("0.5"),
        "Coulomb friction coefficient between particles",
    ),
    of(
        "contact.restitution",
        Number(Range::closed(0.0, 1.0)),
        "1",
        Toml("0"),
        "share of the normal speed that two particles part with, beside what the material gives back",
    ),
    of(
        "contact.stiffness",
        Number(Range::POSITIVE),
        "1",
        Toml("1"),
        "stiffness of a contact over bulk modulus times distance; less where the time step asks for it",
    ),
    of("compare", Tables, "", Said("none"), "references that the run is compared with, one table [[compare]] each"),
    of("compare.N.label", Text, "", Said("\"compare N\", N from 1"), "what is compared, for the table and the plot"),
    of("compare.N.body", Text, "", Said("the first body"), "name of the body, for `field`, `track` and `displacement`"),
    of(
        "compare.N.field",
        Text,
        "",
        Said("another reference is given"),
        "path of a CSV with columns x, y, z: places at rest [m], and any of ux, uy, uz: displacements [m]",
    ),
    of(
        "compare.N.track",
        Text,
        "",
        Said("another reference is given"),
        "path of a CSV with a column t: times [s], and any of ux, uy, uz: displacements [m] of `point`",
    ),
    of(
        "compare.N.displacement",
        Number(ANY),
        "m",
        Said("another reference is given"),
        "displacement of `point` in the direction `along`",
    ),
    of(
        "compare.N.force",
        Number(ANY),
        "N",
        Said("another reference is given"),
        "force of `anchor` on the body, in the direction `along`",
    ),
    of(
        "compare.N.torque",
        Number(ANY),
        "N m",
        Said("another reference is given"),
        "torque of `anchor` on the body about the anchor's centre, in the direction `along`",
    ),
    of("compare.N.point", Three(ANY), "m", Said("required by track, displacement"), "place of the point at the start"),
    of("compare.N.anchor", Text, "", Said("required by force, torque"), "name of the anchor"),
    of(
        "compare.N.along",
        Direction,
        "1",
        Said("required by displacement, force, torque"),
        "direction of what is compared; its length does not matter",
    ),
    of("compare.N.at", Number(Range::NOT_NEGATIVE), "s", Said("the end"), "when it is compared"),
    of(
        "compare.N.translate",
        Three(ANY),
        "m",
        Toml("[0, 0, 0]"),
        "shifts the places of a field, as the body is shifted",
    ),
    of("output", Table, "", Said("all defaults"), "what a run writes"),
    of(
        "output.frames_per_second",
        Number(Range { low: (0.0, false), high: (1e9, true) }),
        "1/s",
        Toml("60"),
        "frames per second of simulated time",
    ),
    of(
        "output.frame_every",
        Number(Range::POSITIVE),
        "s",
        Said("`frames_per_second` decides"),
        "simulated time from frame to frame",
    ),
    of(
        "output.checkpoint_every",
        Number(Range::POSITIVE),
        "s",
        Said("duration / 10"),
        "simulated time from checkpoint to checkpoint",
    ),
    of(
        "output.checkpoint_steps",
        Whole(1, 1 << 53),
        "",
        Said("`checkpoint_every` decides"),
        "steps from checkpoint to checkpoint",
    ),
    of(
        "output.checkpoint_minutes",
        Number(Range::POSITIVE),
        "min",
        Said("never"),
        "time on the clock after which there is a checkpoint whatever else; changes nothing in the result",
    ),
    of("output.keep", Whole(0, 1_000_000), "", Toml("5"), "how many of the newest checkpoints stay; 0 for all"),
    of(
        "output.on_write_error",
        Word(&["stop", "go_on"]),
        "",
        Toml("'stop'"),
        "what a frame or checkpoint that cannot be written does to the run; the last checkpoint stays",
    ),
    of("output.picture", Table, "", Said("all defaults"), "the picture of the last frame"),
    of("output.picture.width", Whole(16, 8192), "px", Toml("1280"), "width of the picture"),
    of("output.picture.height", Whole(16, 8192), "px", Toml("720"), "height of the picture"),
    of("output.picture.camera", Three(ANY), "m", Said("chosen to show everything"), "where the camera stands"),
    of("output.picture.target", Three(ANY), "m", Said("the middle of what is shown"), "where the camera looks"),
    of(
        "output.picture.color",
        Word(&["material", "damage", "speed", "piece"]),
        "",
        Toml("'material'"),
        "what the colours show",
    ),
    of(
        "output.picture.outside",
        Three(Range::closed(0.0, 1.0)),
        "1",
        Said("the picture's own"),
        "red, green, blue of the outer surface",
    ),
    of(
        "output.picture.inside",
        Three(Range::closed(0.0, 1.0)),
        "1",
        Said("the picture's own"),
        "red, green, blue of crack faces",
    ),
];
