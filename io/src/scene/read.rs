//! From the tree of a scene file to the typed scene.

use std::path::Path;
use std::sync::Arc;

use fissure_engine::params::{Value, hint};
use fissure_engine::{Integrator, Relax};
use glam::DVec3;

use super::error::SceneError;
use super::keys::{REFERENCES, SHAPES};
use super::model::*;
use super::parts;
use super::reader::{Reader, Unless};
use super::tree::{self, Item, Node};
use super::{Scene, cells, colliders};
use crate::export::Format;

pub(super) fn scene(file: Arc<str>, text: String, tree: tree::Item, folder: &Path) -> Result<Scene, SceneError> {
    let top = Reader::top(&tree)?;
    let bodies = bodies(&top, folder)?;
    let duration = top.get("duration")?;
    let anchors = anchors(&top, &bodies)?;
    Ok(Scene {
        title: top.get("title")?,
        duration,
        gravity: top.get("gravity")?,
        dt: top.get::<Unless>("dt")?.0,
        safety: top.get("safety")?,
        integrator: integrator(&top)?,
        seed: top.get("seed")?,
        compares: compares(&top, &bodies, &anchors, duration, folder)?,
        anchors,
        ground: top.table_if("ground")?.map(|t| ground(&t)).transpose()?,
        colliders: colliders::colliders(&top, folder)?,
        contact: colliders::contact(&top)?,
        output: output(&top, duration)?,
        bodies,
        file,
        text,
        tree,
    })
}

/// Names become parts of file names and column names.
pub(super) fn check_name(name: &str, what: &str) -> Result<(), String> {
    if name.trim().is_empty() || name.contains(['/', '\\']) || name.chars().any(char::is_control) {
        return Err(format!("{what} cannot be called {name:?}; use letters, digits, spaces, `-` and `_`"));
    }
    Ok(())
}

fn bodies(top: &Reader<'_>, folder: &Path) -> Result<Vec<Body>, SceneError> {
    const CURE: &str =
        "write at least one table [body.NAME] with `mesh` or `shape`, `density` and [body.NAME.material]";
    let Some(item) = top.entries().find(|(name, _)| *name == "body").map(|(_, item)| item) else {
        return Err(SceneError::wrong(top.place, format!("the scene has no body; {CURE}")));
    };
    let Some(table) = item.as_table() else {
        return Err(SceneError::wrong(&item.place, format!("`body` must be a table of bodies; {CURE}")));
    };
    if table.0.is_empty() {
        return Err(SceneError::wrong(&item.place, format!("the scene has no body; {CURE}")));
    }
    table.0.iter().map(|(name, item)| body(name, item, folder)).collect()
}

fn body(name: &str, item: &Item, folder: &Path) -> Result<Body, SceneError> {
    check_name(name, "a body").map_err(|message| SceneError::wrong(&item.place, message))?;
    if item.as_table().is_none() {
        let message = format!("`{name}` = {item} in [body] must be a table [body.NAME]; [body] holds bodies only");
        return Err(SceneError::wrong(&item.place, message));
    }
    let r = Reader::open(item, "body.NAME", format!("[body.{name}]"))?;
    let source = match r.exactly_one_of(&["mesh", "shape"])? {
        "mesh" => mesh(&r, folder)?,
        _ => Source::Shape(shape(&r.table("shape")?)?),
    };
    let resolution = match r.one_of(&["size", "tets"])? {
        Some("size") => Resolution::Size(r.get("size")?),
        _ => Resolution::Tets(r.get("tets")?),
    };
    let horizon = match r.one_of(&["horizon", "horizon_factor"])? {
        Some("horizon") => Horizon::Length(r.get("horizon")?),
        _ => Horizon::Factor(r.get("horizon_factor")?),
    };
    let (axis, degrees) = match r.table_if("rotate")? {
        Some(turn) => (turn.get("axis")?, turn.get("degrees")?),
        None => (DVec3::Y, 0.0),
    };
    let material = r.table("material")?;
    let criterion = match r.table_if("fracture")? {
        Some(table) => chosen(&table, "criterion")?,
        None => Chosen { name: "none".into(), given: Vec::new() },
    };
    let own = (r.get("density")?, chosen(&material, "law")?, criterion);
    let parts = parts::parts(&r, name, folder, &own)?;
    let interface = parts::interface(&r, name, &parts)?;
    let (density, law, criterion) = own;
    Ok(Body {
        name: name.into(),
        source,
        resolution,
        lattice: cells::lattice(&r)?,
        shell: r.get_if("shell")?,
        placement: Placement { scale: r.get("scale")?, axis, degrees, translate: r.get("translate")? },
        density,
        velocity: r.get("velocity")?,
        spin: r.get("spin")?,
        horizon,
        surface: match r.get::<String>("surface")?.as_str() {
            "as_written" => SurfaceMode::AsWritten,
            _ => SurfaceMode::Smooth,
        },
        law,
        criterion,
        parts,
        interface,
        cuts: r.tables("cut")?.iter().map(cut).collect::<Result<_, _>>()?,
    })
}

fn mesh(r: &Reader<'_>, folder: &Path) -> Result<Source, SceneError> {
    let written: String = r.get("mesh")?;
    if written.trim().is_empty() {
        return Err(r.fail("mesh", format!("`mesh` in {} is empty; give the path of a mesh", r.title)));
    }
    Ok(Source::Mesh { path: folder.join(&written), written })
}

fn shape(r: &Reader<'_>) -> Result<Shape, SceneError> {
    let kind: String = r.get("kind")?;
    let (_, known) = SHAPES.iter().find(|(name, _)| *name == kind).expect("the kinds of the table of keys");
    if let Some((key, _)) = r.entries().find(|(key, _)| *key != "kind" && !known.contains(key)) {
        let message = format!("`{key}` in {} is no key of a {kind}, which has {}", r.title, known.join(", "));
        return Err(r.fail(key, message));
    }
    Ok(match kind.as_str() {
        "box" => Shape::Box { size: r.get("size")? },
        "beam" => Shape::Beam { length: r.get("length")?, width: r.get("width")? },
        "wall" => Shape::Wall { width: r.get("width")?, height: r.get("height")?, thickness: r.get("thickness")? },
        "sheet" => Shape::Sheet { width: r.get("width")?, height: r.get("height")?, thickness: r.get("thickness")? },
        "ball" => Shape::Ball { radius: r.get("radius")? },
        "cylinder" => Shape::Cylinder { radius: r.get("radius")?, height: r.get("height")? },
        "revolution" => Shape::Revolution { profile: r.get("profile")?, segments: whole(r, "segments")? },
        _ => Shape::Vase { height: r.get("height")?, wall: r.get("wall")? },
    })
}

/// A law or criterion: its name under `word`, everything else as given.
pub(super) fn chosen(r: &Reader<'_>, word: &str) -> Result<Chosen, SceneError> {
    let name = r.get(word)?;
    let mut given = Vec::new();
    for (key, item) in r.entries().filter(|(key, _)| *key != word) {
        let mut numbers = Vec::new();
        let value = match &item.node {
            Node::Text(text) => Value::Word(text.clone()),
            Node::List(_) if flatten(item, &mut numbers) => Value::List(numbers),
            _ => match item.as_number() {
                // not finite: refused with unit and range by the table of the law
                Some(x) => Value::Number(x),
                None => {
                    let title = &r.title;
                    let message =
                        format!("`{key}` = {item} in {title} must be a finite number, a word, or a list of numbers");
                    return Err(SceneError::wrong(&item.place, message));
                }
            },
        };
        given.push(Given { key: key.into(), value, place: item.place.clone() });
    }
    Ok(Chosen { name, given })
}

/// Collects the numbers of a list, and of lists in it, row after row; false if anything else is in it.
fn flatten(item: &Item, numbers: &mut Vec<f64>) -> bool {
    match (&item.node, item.as_number()) {
        (Node::List(list), _) => list.iter().all(|inner| flatten(inner, numbers)),
        (_, Some(x)) if x.is_finite() => {
            numbers.push(x);
            true
        }
        _ => false,
    }
}

fn cut(r: &Reader<'_>) -> Result<Cut, SceneError> {
    let cut = match r.exactly_one_of(&["triangle", "rectangle"])? {
        "triangle" => Cut::Triangle(r.get("triangle")?),
        _ => {
            let t = r.table("rectangle")?;
            Cut::Rectangle { corner: t.get("corner")?, u: t.get("u")?, v: t.get("v")? }
        }
    };
    let [a, b, c] = cut.triangles()[0];
    if (b - a).cross(c - a).try_normalize().is_none() {
        let message = format!("{} has no area: its corners lie in one line; move one of them", r.title);
        return Err(SceneError::wrong(r.place, message));
    }
    Ok(cut)
}

fn anchors(top: &Reader<'_>, bodies: &[Body]) -> Result<Vec<Anchor>, SceneError> {
    let mut anchors: Vec<Anchor> = Vec::new();
    for (k, r) in top.tables("anchor")?.iter().enumerate() {
        let anchor = anchor(r, k, bodies)?;
        if anchors.iter().any(|other| other.name == anchor.name) {
            let message = format!("a second anchor is called `{}`; give each its own `name`", anchor.name);
            return Err(r.fail("name", message));
        }
        anchors.push(anchor);
    }
    Ok(anchors)
}

fn anchor(r: &Reader<'_>, k: usize, bodies: &[Body]) -> Result<Anchor, SceneError> {
    let name = r.get_if("name")?.unwrap_or_else(|| format!("anchor {}", k + 1));
    check_name(&name, "an anchor").map_err(|message| r.fail("name", message))?;
    let body = index(r, "body", bodies.iter().map(|b| b.name.as_str()))?;
    let region = space(r, r.exactly_one_of(&["box", "ball", "all"])?)?;
    let (from, until): (f64, Option<f64>) = (r.get("from")?, r.get_if("until")?);
    if let Some(until) = until.filter(|until| *until <= from) {
        let message = format!("`until` = {until} in {} must be later than `from` = {from} [s]", r.title);
        return Err(r.fail("until", message));
    }
    Ok(Anchor {
        name,
        body,
        region,
        velocity: r.get("velocity")?,
        spin: r.get("spin")?,
        centre: r.get("centre")?,
        from,
        until: until.unwrap_or(f64::INFINITY),
    })
}

/// The part of space that the key `word` gives: `box`, `ball` or `all`.
pub(super) fn space(r: &Reader<'_>, word: &str) -> Result<Region, SceneError> {
    Ok(match word {
        "box" => {
            let [min, max]: [DVec3; 2] = r.get("box")?;
            if !min.cmple(max).all() {
                let message = format!("`box` in {} must be [lowest corner, highest corner]", r.title);
                return Err(r.fail("box", message));
            }
            Region::Box { min, max }
        }
        "ball" => {
            let t = r.table("ball")?;
            Region::Ball { centre: t.get("centre")?, radius: t.get("radius")? }
        }
        _ => {
            let _: bool = r.get("all")?;
            Region::All
        }
    })
}

/// The place among `names` of the one that the scene gives for the key `what`.
fn index<'a>(r: &Reader<'_>, what: &str, names: impl Iterator<Item = &'a str>) -> Result<usize, SceneError> {
    let word: String = r.get(what)?;
    let names: Vec<&str> = names.collect();
    names.iter().position(|name| *name == word).ok_or_else(|| {
        let message = format!("no {what} is called `{word}` in {}{}", r.title, hint(&word, &names));
        r.fail(what, message)
    })
}

fn compares(
    top: &Reader<'_>,
    bodies: &[Body],
    anchors: &[Anchor],
    duration: f64,
    folder: &Path,
) -> Result<Vec<Compare>, SceneError> {
    let read = |(k, r): (usize, &Reader<'_>)| {
        let label = r.get_if("label")?.unwrap_or_else(|| format!("compare {}", k + 1));
        Ok(Compare { label, reference: reference(r, bodies, anchors, duration, folder)? })
    };
    top.tables("compare")?.iter().enumerate().map(read).collect()
}

fn reference(
    r: &Reader<'_>,
    bodies: &[Body],
    anchors: &[Anchor],
    duration: f64,
    folder: &Path,
) -> Result<Reference, SceneError> {
    let kinds: Vec<&str> = REFERENCES.iter().map(|(kind, _)| *kind).collect();
    let kind = r.exactly_one_of(&kinds)?;
    let (_, known) = REFERENCES.iter().find(|(name, _)| *name == kind).expect("one of the kinds");
    if let Some((key, _)) = r.entries().find(|(key, _)| *key != kind && !known.contains(key)) {
        let message = format!("`{key}` in {} does not go with `{kind}`, which has {}", r.title, known.join(", "));
        return Err(r.fail(key, message));
    }
    let body = match r.get_if::<String>("body")? {
        Some(_) => index(r, "body", bodies.iter().map(|b| b.name.as_str()))?,
        None => 0,
    };
    let at = r.get_if("at")?.unwrap_or(duration);
    if at > duration {
        let message = format!("`at` = {at} in {} is after the end: `duration` is {duration} s", r.title);
        return Err(r.fail("at", message));
    }
    let table = |key: &str| r.get(key).map(|written: String| Table { path: folder.join(&written), written });
    let anchor = || index(r, "anchor", anchors.iter().map(|a| a.name.as_str()));
    let of = match kind {
        "field" => return Ok(Reference::Field { body, table: table(kind)?, translate: r.get("translate")?, at }),
        "track" => return Ok(Reference::Track { body, table: table(kind)?, point: r.get("point")? }),
        "displacement" => Quantity::Displacement { body, point: r.get("point")? },
        "force" => Quantity::Force(anchor()?),
        _ => Quantity::Torque(anchor()?),
    };
    Ok(Reference::Number { of, along: r.get::<DVec3>("along")?.normalize(), value: r.get(kind)?, at })
}

fn integrator(top: &Reader<'_>) -> Result<Integrator, SceneError> {
    let word: String = top.get("integrator")?;
    let (residual, iterations) = (top.get("residual")?, top.get("iterations")?);
    if word == "relax" {
        return Ok(Integrator::Relax(Relax { residual, iterations }));
    }
    if let Some((key, _)) = top.entries().find(|(key, _)| matches!(*key, "residual" | "iterations")) {
        let message = format!("`{key}` belongs to integrator = \"relax\", but this is \"{word}\"; remove one of them");
        return Err(top.fail(key, message));
    }
    Ok(if word == "velocity_verlet" { Integrator::VelocityVerlet } else { Integrator::SymplecticEuler })
}

fn ground(r: &Reader<'_>) -> Result<Ground, SceneError> {
    Ok(Ground {
        height: r.get("height")?,
        normal: r.get::<DVec3>("normal")?.normalize(),
        restitution: r.get("restitution")?,
        friction: r.get("friction")?,
    })
}

fn output(top: &Reader<'_>, duration: f64) -> Result<Output, SceneError> {
    let empty = Item { place: top.place.clone(), node: Node::Table(tree::Table::default()) };
    let r = match top.table_if("output")? {
        Some(r) => r,
        None => Reader::open(&empty, "output", "[output]".into())?,
    };
    let p = match r.table_if("picture")? {
        Some(p) => p,
        None => Reader::open(&empty, "output.picture", "[output.picture]".into())?,
    };
    let frame_every = match r.one_of(&["frames_per_second", "frame_every"])? {
        Some("frame_every") => r.get("frame_every")?,
        _ => 1.0 / r.get::<f64>("frames_per_second")?,
    };
    if !frame_every.is_finite() {
        let message = "`frames_per_second` in [output] is too small; leave a longer `duration` or ask for more frames";
        return Err(r.fail("frames_per_second", message.into()));
    }
    r.one_of(&["checkpoint_every", "checkpoint_steps"])?;
    let color = |name| Ok(p.get_if::<DVec3>(name)?.map(|c| c.to_array()));
    Ok(Output {
        frame_every,
        checkpoint_every: r.get_if("checkpoint_every")?.unwrap_or(duration / 10.0),
        checkpoint_steps: r.get_if("checkpoint_steps")?,
        checkpoint_minutes: r.get_if("checkpoint_minutes")?,
        keep: whole(&r, "keep")?,
        on_write_error: match r.get::<String>("on_write_error")?.as_str() {
            "go_on" => OnFailure::GoOn,
            _ => OnFailure::Stop,
        },
        export: r.get::<Vec<String>>("export")?.iter().filter_map(|name| Format::named(name)).collect(),
        particles: r.get::<String>("particles")? == "on",
        picture: Picture {
            width: whole(&p, "width")?,
            height: whole(&p, "height")?,
            camera: p.get_if("camera")?,
            target: p.get_if("target")?,
            colouring: match p.get::<String>("color")?.as_str() {
                "damage" => Colouring::Damage,
                "stretch" => Colouring::Stretch,
                "speed" => Colouring::Speed,
                "piece" => Colouring::Piece,
                _ => Colouring::Material,
            },
            outside: color("outside")?,
            inside: color("inside")?,
        },
    })
}

/// A whole number whose range, by its documentation, fits 32 bits.
fn whole(r: &Reader<'_>, name: &str) -> Result<u32, SceneError> {
    Ok(u32::try_from(r.get::<u64>(name)?).unwrap_or(u32::MAX))
}
