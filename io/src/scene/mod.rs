//! Scene files: TOML 1.0 in SI units to a checked [`Scene`].
//!
//! [`Scene::load`] reads a file, applies overrides (`--set key.path=value`) and checks everything that can be known
//! without a mesh: keys, kinds, units and ranges, contradictions, names of bodies. Whoever builds the world from it calls
//! [`Scene::check`] first, which asks a registry about laws, criteria and their own keys, and uses [`Scene::blame`] and
//! [`Scene::error`] to say file and line of what goes wrong later. All keys are documented in [`keys()`].
//!
//! ```text
//! Scene ── title, duration, gravity, dt, safety, integrator, seed, ground, contact
//!   ├── bodies: Vec<Body> ── name, source, resolution, shell, placement, density, velocity, spin, horizon, surface
//!   │                         ├── law: Chosen, criterion: Chosen (name and given keys, unchecked)
//!   │                         ├── parts: Vec<Part> (regions with density, law and criterion of their own), interface
//!   │                         └── cuts: Vec<Cut>
//!   ├── anchors: Vec<Anchor> ── name, body (index), region, velocity, spin, centre, from, until
//!   ├── colliders: Vec<Collider> ── name, shape, start, motion, friction, restitution
//!   ├── compares: Vec<Compare> ── label, reference: field, track or number
//!   └── output: Output ── frame_every, checkpoint_every, keep, picture
//! ```

mod cells;
mod colliders;
mod error;
mod fingerprint;
mod keys;
mod model;
mod overrides;
mod parts;
mod read;
mod reader;
mod tree;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use fissure_engine::params::{ParamError, Params, hint};
use fissure_engine::registry::Wants;
use fissure_engine::{Integrator, Registry};
use glam::DVec3;

pub use cells::{Fineness, Lattice};
pub use error::{Place, SceneError};
pub use keys::{COLLIDERS, FREE, Fallback, Key, KeyKind, REFERENCES, RIVALS, SHAPES, keys};
pub use model::{
    Anchor, Body, Chosen, Collider, ColliderMotion, ColliderShape, Colouring, Compare, Contact, Cut, Given, Ground,
    Horizon, OnFailure, Output, Picture, Placement, Quantity, Reference, Region, Resolution, Shape, Source, Stance,
    SurfaceMode, Table, Weight,
};
pub use parts::{Part, Where};
pub(crate) use tree::flat_keys;

/// A scene, read and checked. SI units throughout.
#[derive(Clone, Debug)]
pub struct Scene {
    /// One line that says what is shown; may be empty.
    pub title: String,
    /// Simulated time [s], above 0.
    pub duration: f64,
    /// Acceleration of everything that is not held [m/s²].
    pub gravity: DVec3,
    /// Time step [s]; none for "auto": the largest stable one times `safety`.
    pub dt: Option<f64>,
    /// Share of the largest stable step that an automatic step takes, (0, 1].
    pub safety: f64,
    /// How forces become motion.
    pub integrator: Integrator,
    /// Seed of every random number of the run.
    pub seed: u64,
    /// One or more, in the order of the file; names differ.
    pub bodies: Vec<Body>,
    /// In the order of the file; names differ.
    pub anchors: Vec<Anchor>,
    /// The ground, normal of length 1; none where the scene has no `[ground]`.
    pub ground: Option<Ground>,
    /// In the order of the file; names differ.
    pub colliders: Vec<Collider>,
    /// How particles meet.
    pub contact: Contact,
    /// What the run is compared with, in the order of the file.
    pub compares: Vec<Compare>,
    /// What a run writes.
    pub output: Output,
    file: Arc<str>,
    text: String,
    tree: tree::Item,
}

impl Scene {
    /// Reads the scene file `path` and applies `overrides` (see [`Self::parse`]).
    ///
    /// # Errors
    /// As [`Self::parse`], and if the file cannot be read.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, SceneError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| SceneError::NotReadable { file: path.display().to_string().into(), source })?;
        Self::parse(&text, path, overrides)
    }

    /// Reads a scene from `text`; `path` serves messages and relative paths of meshes.
    ///
    /// Each override is `key.path=value`, e.g. `body.vase.tets=300000` or `anchor.1.until=0.2` (lists count from 1). A
    /// value that is not TOML is taken as text. A key that excludes another ([`RIVALS`]) replaces it.
    ///
    /// # Errors
    /// The first thing that is wrong, with its place and the cure.
    pub fn parse(text: &str, path: &Path, overrides: &[String]) -> Result<Self, SceneError> {
        let file: Arc<str> = path.display().to_string().into();
        let mut tree = tree::parse(text, &file)?;
        let mut text = text.to_owned();
        if !overrides.is_empty() {
            (text, tree) = overrides::apply(&text, &tree, &file, overrides)?;
        }
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        read::scene(file, text, tree, &folder)
    }

    /// The path of the file as it was given.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The TOML text with the overrides in it, comments kept. Parsed again it gives the same scene.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Hash of what the scene means: the same for other comments, spaces, order of keys, `1` for `1.0`, and for defaults
    /// written out; another one for any other value. Paths of meshes count as written, not what is in the files.
    pub fn fingerprint(&self) -> u64 {
        fingerprint::of(self)
    }

    /// Where `key` stands in `table` of a body: `""` for `[body.NAME]` itself, `"material"`, `"fracture"`, `"shape"`, …
    /// What is not in the file is looked for one level up: the table, then the body, then the first line.
    pub fn locate(&self, body: &str, table: &str, key: &str) -> Place {
        self.find(&["body", body, table, key])
    }

    /// The same in region `k` of a body, counted from 0.
    pub fn locate_part(&self, body: &str, k: usize, table: &str, key: &str) -> Place {
        self.find(&["body", body, "region", &(k + 1).to_string(), table, key])
    }

    fn find(&self, path: &[&str]) -> Place {
        let mut item = &self.tree;
        for part in path {
            match item.child(part) {
                Some(inner) => item = inner,
                None if part.is_empty() => {}
                None => break,
            }
        }
        item.place.clone()
    }

    /// Where the table of anchor `k` stands, counted from 0.
    pub fn locate_anchor(&self, k: usize) -> Place {
        self.locate_in("anchor", k)
    }

    /// Where the table of comparison `k` stands, counted from 0.
    pub fn locate_compare(&self, k: usize) -> Place {
        self.locate_in("compare", k)
    }

    fn locate_in(&self, list: &str, k: usize) -> Place {
        let table = self.tree.child(list).and_then(|list| list.child(&(k + 1).to_string()));
        table.unwrap_or(&self.tree).place.clone()
    }

    /// Where the table of collider `k` stands, counted from 0.
    pub fn locate_collider(&self, k: usize) -> Place {
        let table = self.tree.child("collider").and_then(|list| list.child(&(k + 1).to_string()));
        table.unwrap_or(&self.tree).place.clone()
    }

    /// Whether the scene gives `key` in `table` of a body, rather than leaving it to its default.
    pub fn gives(&self, body: &str, table: &str, key: &str) -> bool {
        let path = ["body", body, table, key];
        path.iter().filter(|part| !part.is_empty()).try_fold(&self.tree, |item, part| item.child(part)).is_some()
    }

    /// An error about `key` in `table` of a body (see [`Self::locate`]).
    pub fn error(&self, body: &str, table: &str, key: &str, message: String) -> SceneError {
        SceneError::wrong(&self.locate(body, table, key), message)
    }

    /// Adds file and line to what the registry or a law says about the material or fracture table of a body. The table is
    /// the one that has the key; `material` if both or neither have it.
    pub fn blame(&self, body: &str, error: &ParamError) -> SceneError {
        let in_fracture = !self.gives(body, "material", &error.key)
            && (self.gives(body, "fracture", &error.key) || error.key == "criterion");
        self.blame_in(body, if in_fracture { "fracture" } else { "material" }, error)
    }

    /// The same for region `k` of a body, counted from 0.
    pub fn blame_part(&self, body: &str, k: usize, error: &ParamError) -> SceneError {
        let Some(part) = self.bodies.iter().find(|b| b.name == body).and_then(|b| b.parts.get(k)) else {
            return self.blame(body, error);
        };
        let has = |c: &Chosen| c.given.iter().any(|g| g.key == error.key);
        let in_fracture = !has(&part.law) && (has(&part.criterion) || error.key == "criterion");
        self.blame_part_in(body, (k, &part.name), if in_fracture { "fracture" } else { "material" }, error)
    }

    /// Asks `registry` about the law and the criterion of every body and region: names, keys, ranges.
    ///
    /// # Errors
    /// The first that is unknown, missing or out of range.
    pub fn check(&self, registry: &Registry) -> Result<(), SceneError> {
        for body in &self.bodies {
            let name = &body.name;
            check(registry, &body.law, &body.criterion).map_err(|(table, e)| self.blame_in(name, table, &e))?;
            let wants = registry.entry(&body.law.name).map_err(|e| self.blame(name, &e))?.wants;
            self.check_fit(body, wants)?;
            for (k, part) in body.parts.iter().enumerate() {
                let blame = |(table, e)| self.blame_part_in(name, (k, &part.name), table, &e);
                check(registry, &part.law, &part.criterion).map_err(blame)?;
                if registry.entry(&part.law.name).is_ok_and(|entry| entry.wants == Wants::Cells) {
                    let message =
                        format!("`{}` is a law of whole bodies, not of regions; make a body of its own", part.law.name);
                    return Err(self.blame_part_in(
                        name,
                        (k, &part.name),
                        "material",
                        &ParamError::new("law", message),
                    ));
                }
            }
        }
        Ok(())
    }

    fn blame_in(&self, body: &str, table: &str, error: &ParamError) -> SceneError {
        self.error(body, table, &error.key, format!("[body.{body}.{table}]: {}", error.message))
    }

    fn blame_part_in(&self, body: &str, (k, name): (usize, &str), table: &str, error: &ParamError) -> SceneError {
        let message = format!("[body.{body}.region.{table}] of `{name}`: {}", error.message);
        SceneError::wrong(&self.locate_part(body, k, table, &error.key), message)
    }
}

/// Whether there are such a law and criterion and they have these keys; if not, the table at fault.
fn check(registry: &Registry, law: &Chosen, criterion: &Chosen) -> Result<(), (&'static str, ParamError)> {
    let (material, fracture) = (|e| ("material", e), |e| ("fracture", e));
    let entry = registry.entry(&law.name).map_err(material)?;
    Params::new(entry.parameters.to_vec(), law.values()).map_err(material)?;
    let Some(known) = entry.criteria.iter().find(|c| c.name == criterion.name) else {
        let names: Vec<&str> = entry.criteria.iter().map(|c| c.name).collect();
        let message = format!("no criterion is called `{}`{}", criterion.name, hint(&criterion.name, &names));
        return Err(fracture(ParamError::new("criterion", message)));
    };
    Params::new(known.parameters.to_vec(), criterion.values()).map_err(fracture)?;
    Ok(())
}
