//! A run as one binary glTF for game engines: a node for each fragment with its rigid motion.
//!
//! Fragments only ever split, so those of the last frame are all there are, and each is a node. Its mesh has the cracks of the
//! last frame in the shape at rest, about its centre of mass; its motion is fitted to its particles by least squares. Before it
//! breaks off, its particles move with the rest and its faces close the gap: nothing has to be shown or hidden, the file is as
//! large as one surface, and an engine may take a piece over as a rigid body at any time, from `extras.born` on at best. What
//! bends or flows is not in it; USD has that.
//!
//! Lattices have no nodes that last, so the shape of their pieces is that of the last frame.
//!
//! `extras` of a node: `piece`, `parent`, `born` [s], `body`, `mass` [kg], `volume` [m³], and `inertia` [kg m²], rows of the
//! matrix about the origin of the node along its axes.

mod file;
mod fit;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use glam::{DMat3, DVec3};
use serde_json::{Value, json};

use self::file::File;
use self::fit::{Fit, Part, Point};
use super::{About, ExportError, write as put};
use crate::fragments::{Fragment, Lineage};
use crate::frames::{Frame, ParticleFrame};

/// The frames of a run.
pub struct Run<'a> {
    /// Their numbers, ascending.
    pub numbers: &'a [u32],
    /// The surface of the last of them.
    pub last: &'a Frame,
    /// Rest positions of the mesh vertices of each body [m], which a frame's `id` counts; none of a lattice.
    pub rest: &'a [Option<Vec<DVec3>>],
    /// Reads the particles of a frame.
    pub particles: &'a dyn Fn(u32) -> Result<ParticleFrame, ExportError>,
    /// Reads the rigid things of a frame.
    pub colliders: &'a dyn Fn(u32) -> Result<Option<Frame>, ExportError>,
}

/// Writes a run to the file `path`.
///
/// # Errors
/// Frames that cannot be read, no frame at all, or what the system says.
pub fn write(path: &Path, about: &About, run: &Run<'_>) -> Result<(), ExportError> {
    let (Some(&start), Some(&end)) = (run.numbers.first(), run.numbers.last()) else {
        return Err(ExportError::Missing("there is no frame to export; let the run reach its first frame".into()));
    };
    let (first, last) = ((run.particles)(start)?, (run.particles)(end)?);
    // the shape at rest is that of frame 0 only
    let rest = |body: u32| run.rest.get(body as usize).and_then(Option::as_deref).filter(|_| start == 0);
    let mut pieces = Fit::new(reference(&first, &last, &|body| rest(body).is_some()));
    let shape = shape(run.last, &last, &rest);
    let standing = (run.colliders)(end)?;
    let mut things = standing.as_ref().map(|frame| Fit::new(fit::vertices(frame)));

    let (mut lineage, mut fragments, mut times) = (Lineage::default(), Vec::new(), Vec::new());
    for &number in run.numbers {
        let frame = (run.particles)(number)?;
        times.push(frame.time);
        fragments = lineage.frame(&frame);
        pieces.frame(&fit::particles(&frame));
        if let Some(things) = &mut things {
            things.frame(&(run.colliders)(number)?.as_ref().map_or_else(Vec::new, fit::vertices));
        }
    }

    let mut file = File::new(&times);
    for part in &pieces.parts {
        let extras = fragments.iter().find(|f| f.id == part.id).map(|f| extras(f, part, about));
        file.node(&format!("piece_{}", part.id), &shape, part, false, extras);
    }
    if let (Some(frame), Some(things)) = (&standing, &things) {
        for part in &things.parts {
            file.node(&format!("collider_{}", part.id), frame, part, true, None);
        }
    }
    let bytes = file.finish(about);
    put(path, |out| out.write_all(&bytes))
}

/// What the motion is fitted to: of bodies that have a shape at rest the particles of the first frame, of others those of the
/// last, in the pieces of the last.
fn reference(first: &ParticleFrame, last: &ParticleFrame, at_rest: &dyn Fn(u32) -> bool) -> Vec<Point> {
    let last = fit::particles(last);
    let piece: BTreeMap<(u32, u32), u32> = last.iter().map(|p| (p.key, p.piece)).collect();
    let begun = fit::particles(first).into_iter().filter(|p| at_rest(p.key.0));
    let begun = begun.filter_map(|p| piece.get(&p.key).map(|&piece| Point { piece, ..p }));
    begun.chain(last.iter().copied().filter(|p| !at_rest(p.key.0))).collect()
}

/// The surface with the cracks of `last` where the bodies are at rest, and with a particle in every piece: a node of a lattice may
/// carry cells that the surface tells apart, and their piece goes with that of the nearest particle then.
fn shape<'r>(surface: &Frame, last: &ParticleFrame, rest: &dyn Fn(u32) -> Option<&'r [DVec3]>) -> Frame {
    let body: BTreeMap<u32, u32> = last.piece.iter().copied().zip(last.body.iter().copied()).collect();
    let mut nearest: BTreeMap<u32, u32> = BTreeMap::new();
    let mut shape = surface.clone();
    let mut moved = BTreeSet::new();
    for (v, piece) in shape.piece.iter_mut().enumerate() {
        let at = surface.positions[v];
        if !body.contains_key(piece) {
            let distance = |k: &usize| (0..3).map(|a| (last.positions[*k][a] - at[a]).powi(2)).sum::<f32>();
            *piece = *nearest.entry(*piece).or_insert_with(|| {
                let all = 0..last.positions.len();
                all.min_by(|a, b| distance(a).total_cmp(&distance(b))).map_or(0, |k| last.piece[k])
            });
        }
        let rest = body.get(piece).and_then(|&body| rest(body)?.get(surface.id[v] as usize));
        if let Some(rest) = rest {
            shape.positions[v] = rest.as_vec3().into();
            moved.insert(v as u32);
        }
    }
    // normals follow the shape, as those of frames do: the mean of the faces around, by their areas
    moved.iter().for_each(|&v| shape.normals[v as usize] = [0.0; 3]);
    for t in &surface.triangles {
        let [a, b, c] = t.map(|v| DVec3::from(shape.positions[v as usize].map(f64::from)));
        let normal = (b - a).cross(c - a);
        for v in t.iter().filter(|v| moved.contains(v)) {
            let sum = &mut shape.normals[*v as usize];
            (0..3).for_each(|k| sum[k] += normal[k] as f32);
        }
    }
    shape
}

fn extras(f: &Fragment, part: &Part, about: &About) -> Value {
    // from the axes of the world at last to those of the node
    let turn = part.poses.last().map_or(DMat3::IDENTITY, |pose| DMat3::from_quat(pose.1));
    let rows = (turn.transpose() * f.inertia * turn).transpose().to_cols_array();
    json!({
        "piece": f.id, "parent": f.parent, "born": f.born, "mass": f.mass, "volume": f.volume, "inertia": rows,
        "body": about.bodies.get(f.body as usize),
    })
}
