//! Colliders and contact of a scene file.

use std::path::Path;

use glam::DVec3;

use super::error::SceneError;
use super::keys::COLLIDERS;
use super::model::{Collider, ColliderMotion, ColliderShape, Contact, Stance, Weight};
use super::read::check_name;
use super::reader::Reader;
use super::tree::{Item, Node, Table};

pub(super) fn colliders(top: &Reader<'_>, folder: &Path) -> Result<Vec<Collider>, SceneError> {
    let mut colliders: Vec<Collider> = Vec::new();
    let ground = top.table_if("ground")?.is_some();
    for (k, r) in top.tables("collider")?.iter().enumerate() {
        let collider = collider(r, k, folder)?;
        if colliders.iter().any(|other| other.name == collider.name) || (ground && collider.name == "ground") {
            let message = format!("a second collider is called `{}`; give each its own `name`", collider.name);
            return Err(r.fail("name", message));
        }
        colliders.push(collider);
    }
    Ok(colliders)
}

pub(super) fn contact(top: &Reader<'_>) -> Result<Contact, SceneError> {
    let empty = Item { place: top.place.clone(), node: Node::Table(Table::default()) };
    let r = match top.table_if("contact")? {
        Some(r) => r,
        None => Reader::open(&empty, "contact", "[contact]".into())?,
    };
    Ok(Contact {
        particles: r.get::<String>("particles")? == "on",
        friction: r.get("friction")?,
        restitution: r.get("restitution")?,
        stiffness: r.get("stiffness")?,
    })
}

fn collider(r: &Reader<'_>, k: usize, folder: &Path) -> Result<Collider, SceneError> {
    let name = r.get_if("name")?.unwrap_or_else(|| format!("collider {}", k + 1));
    check_name(&name, "a collider").map_err(|message| r.fail("name", message))?;
    let shape = shape(&r.table("shape")?, folder)?;
    let word: String = r.get("motion")?;
    // keys that only one kind of motion reads
    let of_motion: [(&str, &[&str]); 3] =
        [("fixed", &[]), ("keyframes", &["keyframe"]), ("free", &["density", "mass", "inertia", "velocity", "spin"])];
    for (motion, keys) in of_motion.iter().filter(|(motion, _)| *motion != word) {
        if let Some((key, _)) = r.entries().find(|(key, _)| keys.contains(key)) {
            let message = format!("`{key}` in {} goes with motion = \"{motion}\", but motion is \"{word}\"", r.title);
            return Err(r.fail(key, message));
        }
    }
    let motion = match word.as_str() {
        "keyframes" => ColliderMotion::Keyframes(keyframes(r)?),
        "free" => free(r, &shape)?,
        _ => ColliderMotion::Fixed,
    };
    let start = match &motion {
        ColliderMotion::Keyframes(frames) => frames[0].1,
        _ => stance(r)?,
    };
    Ok(Collider { name, shape, start, motion, friction: r.get("friction")?, restitution: r.get("restitution")? })
}

fn shape(r: &Reader<'_>, folder: &Path) -> Result<ColliderShape, SceneError> {
    let kind: String = r.get("kind")?;
    let (_, known) = COLLIDERS.iter().find(|(name, _)| *name == kind).expect("the kinds of the table of keys");
    if let Some((key, _)) = r.entries().find(|(key, _)| *key != "kind" && !known.contains(key)) {
        let message = format!("`{key}` in {} is no key of a {kind}, which has {}", r.title, known.join(", "));
        return Err(r.fail(key, message));
    }
    Ok(match kind.as_str() {
        "plane" => ColliderShape::Plane { normal: r.get::<DVec3>("normal")?.normalize() },
        "ball" => ColliderShape::Ball { radius: r.get("radius")? },
        "box" => ColliderShape::Box { size: r.get("size")? },
        "capsule" => {
            let (radius, height): (f64, f64) = (r.get("radius")?, r.get("height")?);
            if height <= 2.0 * radius {
                let message = format!(
                    "`height` = {height} in {} must be above twice the radius of {radius} [m]; use a ball",
                    r.title
                );
                return Err(r.fail("height", message));
            }
            ColliderShape::Capsule { radius, height }
        }
        "cylinder" => ColliderShape::Cylinder { radius: r.get("radius")?, height: r.get("height")? },
        _ => {
            let written: String = r.get("mesh")?;
            if written.trim().is_empty() {
                return Err(r.fail("mesh", format!("`mesh` in {} is empty; give the path of a surface", r.title)));
            }
            let (path, scale) = (folder.join(&written), r.get("scale")?);
            ColliderShape::Mesh { path, written, scale, hull: kind == "hull" }
        }
    })
}

fn stance(r: &Reader<'_>) -> Result<Stance, SceneError> {
    let (axis, degrees) = match r.table_if("rotate")? {
        Some(turn) => (turn.get("axis")?, turn.get("degrees")?),
        None => (DVec3::Y, 0.0),
    };
    Ok(Stance { position: r.get("position")?, axis, degrees })
}

fn keyframes(r: &Reader<'_>) -> Result<Vec<(f64, Stance)>, SceneError> {
    if let Some((key, _)) = r.entries().find(|(key, _)| matches!(*key, "position" | "rotate")) {
        let message = format!("`{key}` in {} is for what does not move; the keyframes say where this is", r.title);
        return Err(r.fail(key, message));
    }
    let mut frames: Vec<(f64, Stance)> = Vec::new();
    for table in r.tables("keyframe")? {
        let time: f64 = table.get("time")?;
        if let Some((last, _)) = frames.last().filter(|(last, _)| time <= *last) {
            let message = format!(
                "`time` = {time} in {} must be later than the {last} s of the one before; sort them",
                table.title
            );
            return Err(table.fail("time", message));
        }
        frames.push((time, stance(&table)?));
    }
    if frames.is_empty() {
        let message = format!("{} has motion = \"keyframes\" but none; add [[collider.keyframe]] tables", r.title);
        return Err(r.fail("motion", message));
    }
    Ok(frames)
}

fn free(r: &Reader<'_>, shape: &ColliderShape) -> Result<ColliderMotion, SceneError> {
    if matches!(shape, ColliderShape::Plane { .. }) {
        let message = format!("{} cannot be free: a plane has no mass; use a flat box", r.title);
        return Err(r.fail("motion", message));
    }
    let weight = match r.exactly_one_of(&["density", "mass"])? {
        "mass" => Weight::Mass(r.get("mass")?),
        _ => Weight::Density(r.get("density")?),
    };
    Ok(ColliderMotion::Free {
        weight,
        inertia: r.get_if("inertia")?,
        velocity: r.get("velocity")?,
        spin: r.get("spin")?,
    })
}
