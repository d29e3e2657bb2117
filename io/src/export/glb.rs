//! A run as one binary glTF for game engines: a node for each fragment with its rigid motion.
//!
//! Fragments only ever split, so those of the last frame are all there are. Each is a node whose mesh is the fragment as it
//! is at last, about its centre of mass; its motion is that of its own particles from the first frame on, fitted by least
//! squares. Before it breaks off, it moves with the rest and closes its gap, crack faces to crack faces: nothing has to be
//! shown or hidden, the file is as large as one surface, and an engine may take a piece over as a rigid body at any time,
//! from `extras.born` on at best. What bends or flows is not in it; USD has that.
//!
//! `extras` of a node: `piece`, `parent`, `born` [s], `body`, `mass` [kg], `volume` [m³], and `inertia` [kg m²], rows of the
//! matrix about the origin of the node along its axes.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

use glam::{DMat3, DQuat, DVec3};
use serde_json::{Value, json};

use super::{About, ExportError, colours, inside, usd::linear, write as put};
use crate::fragments::{Fragment, Lineage, outer};
use crate::frames::{Frame, ParticleFrame};

/// Writes the frames `numbers`, ascending, of a run to the file `path`. `last` is the surface of the last of them; `particles` and
/// `colliders` read the others.
///
/// # Errors
/// Frames that cannot be read, no frame at all, or what the system says.
pub fn write(
    path: &Path,
    about: &About,
    numbers: &[u32],
    last: &Frame,
    particles: &dyn Fn(u32) -> Result<ParticleFrame, ExportError>,
    colliders: &dyn Fn(u32) -> Result<Option<Frame>, ExportError>,
) -> Result<(), ExportError> {
    let Some((&end, before)) = numbers.split_last() else {
        return Err(ExportError::Missing("there is no frame to export; let the run reach its first frame".into()));
    };
    let mut lineage = Lineage::default();
    let mut times = Vec::new();
    for &number in before {
        let frame = particles(number)?;
        times.push(frame.time);
        lineage.frame(&frame);
    }
    let reference = particles(end)?;
    times.push(reference.time);
    let fragments = lineage.frame(&reference);

    let mut pieces = Fit::new(points(&reference), fragments.iter().map(|f| (f.id, f.centre)));
    let standing = colliders(end)?;
    let mut things = standing.as_ref().map(|frame| {
        let seen = seen(frame);
        let mut centres: BTreeMap<u32, (DVec3, f64)> = BTreeMap::new();
        for p in &seen {
            let (sum, n) = centres.entry(p.piece).or_default();
            (*sum, *n) = (*sum + p.place, *n + 1.0);
        }
        Fit::new(seen, centres.into_iter().map(|(id, (sum, n))| (id, sum / n)))
    });
    // backwards: what has no direction of its own keeps the turn of the frame after
    for &number in before.iter().rev() {
        pieces.frame(&points(&particles(number)?));
        if let (Some(things), Some(frame)) = (&mut things, colliders(number)?) {
            things.frame(&seen(&frame));
        }
    }

    let mut file = File::new(&times);
    let last = &held(last, &reference);
    for (fragment, motion) in fragments.iter().zip(&pieces.parts) {
        file.node(&format!("piece_{}", fragment.id), last, motion, false, Some(extras(fragment, about)));
    }
    if let (Some(frame), Some(things)) = (&standing, &things) {
        for motion in &things.parts {
            file.node(&format!("collider_{}", motion.id), frame, motion, true, None);
        }
    }
    let bytes = file.finish(about);
    put(path, |out| out.write_all(&bytes))
}

/// The surface with a particle in every piece: a node of a lattice may carry cells that the surface tells apart, and their piece
/// goes with that of the nearest particle then.
fn held(surface: &Frame, particles: &ParticleFrame) -> Frame {
    let known: BTreeSet<u32> = particles.piece.iter().copied().collect();
    let mut nearest: BTreeMap<u32, u32> = BTreeMap::new();
    let mut surface = surface.clone();
    for (piece, at) in surface.piece.iter_mut().zip(&surface.positions) {
        if !known.contains(piece) {
            let distance = |k: &usize| (0..3).map(|a| (particles.positions[*k][a] - at[a]).powi(2)).sum::<f32>();
            *piece = *nearest.entry(*piece).or_insert_with(|| {
                let all = 0..particles.positions.len();
                all.min_by(|a, b| distance(a).total_cmp(&distance(b))).map_or(0, |k| particles.piece[k])
            });
        }
    }
    surface
}

fn extras(f: &Fragment, about: &About) -> Value {
    let rows: Vec<f64> = f.inertia.transpose().to_cols_array().into();
    json!({
        "piece": f.id, "parent": f.parent, "born": f.born, "mass": f.mass, "volume": f.volume, "inertia": rows,
        "body": about.bodies.get(f.body as usize),
    })
}

/// Something that is followed from frame to frame.
#[derive(Clone, Copy)]
struct Point {
    /// The same in every frame.
    key: (u32, u32),
    piece: u32,
    place: DVec3,
    mass: f64,
}

fn points(p: &ParticleFrame) -> Vec<Point> {
    let point = |k: usize| Point {
        key: (p.body[k], p.id[k]),
        piece: p.piece[k],
        place: DVec3::from(p.positions[k].map(f64::from)),
        mass: p.mass[k].into(),
    };
    (0..p.positions.len()).map(point).collect()
}

/// The vertices of rigid things.
fn seen(frame: &Frame) -> Vec<Point> {
    let point = |k: usize| Point {
        key: (frame.piece[k], frame.id[k]),
        piece: frame.piece[k],
        place: DVec3::from(frame.positions[k].map(f64::from)),
        mass: 1.0,
    };
    (0..frame.positions.len()).map(point).collect()
}

/// The rigid motion of parts, found frame by frame from the last to the first.
struct Fit {
    last: Vec<Point>,
    at: HashMap<(u32, u32), usize>,
    parts: Vec<Part>,
    of_piece: HashMap<u32, usize>,
}

/// A part and where it is at each frame, the last first.
struct Part {
    id: u32,
    poses: Vec<(DVec3, DQuat)>,
    /// Its centre at last.
    centre: DVec3,
}

/// Sums over the points of a part: mass, places now and at last, and their products about the centre at last.
#[derive(Clone, Copy, Default)]
struct Sums {
    mass: f64,
    now: DVec3,
    last: DVec3,
    product: DMat3,
    spread: f64,
}

impl Fit {
    fn new(last: Vec<Point>, parts: impl Iterator<Item = (u32, DVec3)>) -> Self {
        let part = |(id, centre)| Part { id, centre, poses: vec![(centre, DQuat::IDENTITY)] };
        let parts: Vec<Part> = parts.map(part).collect();
        let of_piece = parts.iter().enumerate().map(|(k, part)| (part.id, k)).collect();
        let at = last.iter().enumerate().map(|(k, p)| (p.key, k)).collect();
        Self { last, at, parts, of_piece }
    }

    /// Finds where the parts are in the frame before those that came until now.
    fn frame(&mut self, now: &[Point]) {
        let none = Sums { product: DMat3::ZERO, ..Sums::default() }; // the default of a matrix is the identity
        let mut sums = vec![none; self.parts.len()];
        for p in now {
            // a node of a lattice that was coarser then is another one with the same number
            let Some(then) = self.at.get(&p.key).map(|&k| &self.last[k]) else { continue };
            let Some(&part) = self.of_piece.get(&then.piece) else { continue };
            let (m, s, arm) = (p.mass.min(then.mass), &mut sums[part], then.place - self.parts[part].centre);
            s.mass += m;
            s.now += m * p.place;
            s.last += m * arm;
            s.product += m * outer(p.place, arm);
            s.spread += m * arm.length_squared();
        }
        for (part, s) in self.parts.iter_mut().zip(sums) {
            let (before, turn) = *part.poses.last().expect("it begins with one");
            if s.mass == 0.0 {
                part.poses.push((before, turn));
                continue;
            }
            let (now, arm) = (s.now / s.mass, s.last / s.mass);
            let product = s.product - s.mass * outer(now, arm);
            // a millionth of the turn of the frame after decides where the points alone do not
            let product = product + DMat3::from_quat(turn) * (1e-6 * s.spread / 3.0);
            let turn = nearest_rotation(product, turn);
            part.poses.push((now - turn * arm, turn));
        }
    }
}

/// The rotation R with the largest tr(Rᵀ M), which is the least-squares one between points with Σ m y xᵀ = M (Horn 1987): the
/// eigenvector of the largest eigenvalue of a symmetric 4 × 4 matrix, by Jacobi's rotations. Of the two quaternions that nearer to
/// `near`, and `near` itself where M is nothing.
fn nearest_rotation(m: DMat3, near: DQuat) -> DQuat {
    let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = m.to_cols_array_2d();
    let mut a = [
        [xx - yy - zz, yx + xy, zx + xz, zy - yz],
        [yx + xy, yy - xx - zz, zy + yz, xz - zx],
        [zx + xz, zy + yz, zz - xx - yy, yx - xy],
        [zy - yz, xz - zx, yx - xy, xx + yy + zz],
    ];
    let mut v = [[0.0; 4]; 4];
    (0..4).for_each(|k| v[k][k] = 1.0);
    let scale: f64 = a.iter().flatten().map(|x| x * x).sum();
    for _ in 0..32 {
        for (p, q) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
            let (c, s) = (1.0 / t.hypot(1.0), t / t.hypot(1.0));
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            for k in 0..4 {
                (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
                (v[k][p], v[k][q]) = (c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]);
            }
        }
        let rest: f64 = (0..4).flat_map(|p| (0..p).map(move |q| (p, q))).map(|(p, q)| a[p][q] * a[p][q]).sum();
        if rest <= 1e-28 * scale {
            break;
        }
    }
    let largest = (0..4).max_by(|&p, &q| a[p][p].total_cmp(&a[q][q])).expect("four of them");
    let found = DQuat::from_array(v.map(|row| row[largest])).normalize();
    match found {
        _ if scale == 0.0 || !found.is_finite() => near,
        found if found.dot(near) < 0.0 => -found,
        found => found,
    }
}

/// A file in the making.
struct File {
    json: Json,
    binary: Vec<u8>,
    frames: usize,
    /// Whether there are rigid things.
    rigid: bool,
}

#[derive(Default)]
struct Json {
    nodes: Vec<Value>,
    meshes: Vec<Value>,
    accessors: Vec<Value>,
    views: Vec<Value>,
    samplers: Vec<Value>,
    channels: Vec<Value>,
}

const FLOAT: u32 = 5126;
const UNSIGNED: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

impl File {
    /// A file whose first accessor is the times, from 0 on.
    fn new(times: &[f64]) -> Self {
        let mut file = Self { json: Json::default(), binary: Vec::new(), frames: times.len(), rigid: false };
        let times: Vec<f32> = times.iter().map(|t| (t - times[0]) as f32).collect();
        let (low, high) = (times[0], times[times.len() - 1]);
        file.accessor(
            bytemuck::cast_slice(&times),
            FLOAT,
            "SCALAR",
            times.len(),
            None,
            Some((json!([low]), json!([high]))),
        );
        file
    }

    fn accessor(
        &mut self,
        bytes: &[u8],
        component: u32,
        kind: &str,
        count: usize,
        target: Option<u32>,
        bounds: Option<(Value, Value)>,
    ) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        let mut accessor =
            json!({ "bufferView": self.json.views.len(), "componentType": component, "count": count, "type": kind });
        if let Some((low, high)) = bounds {
            (accessor["min"], accessor["max"]) = (low, high);
        }
        self.binary.extend_from_slice(bytes); // every number has four bytes, so all stays aligned
        self.json.views.push(view);
        self.json.accessors.push(accessor);
        self.json.accessors.len() - 1
    }

    /// A node with the triangles of part `part.id` of `frame`, and its motion.
    fn node(&mut self, name: &str, frame: &Frame, part: &Part, rigid: bool, extras: Option<Value>) {
        self.rigid |= rigid;
        let (place, turn) = part.poses[0];
        let mut node = json!({ "name": name, "translation": single(place), "rotation": turn.as_quat().to_array() });
        if let Some(mesh) = self.mesh(name, frame, part, rigid) {
            node["mesh"] = mesh.into();
        }
        if let Some(extras) = extras {
            node["extras"] = extras;
        }
        let number = self.json.nodes.len();
        self.json.nodes.push(node);
        // the first comes last in the fit
        let places: Vec<[f32; 3]> = part.poses.iter().rev().map(|p| single(p.0)).collect();
        let turns: Vec<[f32; 4]> = part.poses.iter().rev().map(|p| p.1.as_quat().normalize().to_array()).collect();
        assert_eq!(places.len(), self.frames, "a pose for each frame");
        let places = self.accessor(bytemuck::cast_slice(&places), FLOAT, "VEC3", self.frames, None, None);
        let turns = self.accessor(bytemuck::cast_slice(&turns), FLOAT, "VEC4", self.frames, None, None);
        for (output, path) in [(places, "translation"), (turns, "rotation")] {
            let sampler = self.json.samplers.len();
            self.json.samplers.push(json!({ "input": 0, "output": output, "interpolation": "LINEAR" }));
            self.json.channels.push(json!({ "sampler": sampler, "target": { "node": number, "path": path } }));
        }
    }

    fn mesh(&mut self, name: &str, frame: &Frame, part: &Part, rigid: bool) -> Option<usize> {
        let own = |t: &&[u32; 3]| frame.piece[t[0] as usize] == part.id;
        let mut vertex: BTreeMap<u32, u32> = BTreeMap::new();
        let (mut places, mut normals) = (Vec::<[f32; 3]>::new(), Vec::<[f32; 3]>::new());
        let mut faces = [Vec::<u32>::new(), Vec::new()];
        for t in frame.triangles.iter().filter(own) {
            let side = usize::from(!rigid && inside(frame, t));
            for &v in t {
                let k = *vertex.entry(v).or_insert_with(|| {
                    let place = DVec3::from(frame.positions[v as usize].map(f64::from)) - part.centre;
                    places.push(single(place));
                    normals.push(unit(frame.normals[v as usize]));
                    places.len() as u32 - 1
                });
                faces[side].push(k);
            }
        }
        if places.is_empty() {
            return None;
        }
        let fold = |by: fn(f32, f32) -> f32| {
            places.iter().skip(1).fold(places[0], |a, b| std::array::from_fn(|k| by(a[k], b[k])))
        };
        let bounds = (json!(fold(f32::min)), json!(fold(f32::max)));
        let n = places.len();
        let position = self.accessor(bytemuck::cast_slice(&places), FLOAT, "VEC3", n, Some(VERTICES), Some(bounds));
        let normal = self.accessor(bytemuck::cast_slice(&normals), FLOAT, "VEC3", n, Some(VERTICES), None);
        let mut primitives = Vec::new();
        for (side, faces) in faces.iter().enumerate().filter(|(_, faces)| !faces.is_empty()) {
            let indices =
                self.accessor(bytemuck::cast_slice(faces), UNSIGNED, "SCALAR", faces.len(), Some(INDICES), None);
            primitives.push(json!({
                "attributes": { "POSITION": position, "NORMAL": normal }, "indices": indices,
                "material": if rigid { 2 } else { side },
            }));
        }
        self.json.meshes.push(json!({ "name": name, "primitives": primitives }));
        Some(self.json.meshes.len() - 1)
    }

    fn finish(self, about: &About) -> Vec<u8> {
        let Self { json: j, binary, .. } = &self;
        let material = |(name, colour): (&str, [f32; 3])| {
            let [r, g, b] = colour.map(linear);
            json!({ "name": name, "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.6
            } })
        };
        let used = if self.rigid { 3 } else { 2 };
        let materials: Vec<Value> =
            ["outside", "inside", "collider"].into_iter().zip(colours(about)).take(used).map(material).collect();
        let roots: Vec<usize> = (0..j.nodes.len()).collect();
        let text = json!({
            "asset": { "version": "2.0", "generator": concat!("fissure ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "name": about.title, "nodes": roots }],
            "nodes": j.nodes,
            "meshes": j.meshes,
            "materials": materials,
            "animations": [{ "name": "run", "samplers": j.samplers, "channels": j.channels }],
            "accessors": j.accessors,
            "bufferViews": j.views,
            "buffers": [{ "byteLength": binary.len() }],
        });
        let mut text = text.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut out = Vec::with_capacity(28 + text.len() + binary.len());
        out.extend_from_slice(b"glTF");
        let words = [2, 28 + text.len() + binary.len(), text.len()];
        words.iter().for_each(|&n| out.extend_from_slice(&(n as u32).to_le_bytes()));
        out.extend_from_slice(b"JSON");
        out.extend_from_slice(&text);
        out.extend_from_slice(&(binary.len() as u32).to_le_bytes());
        out.extend_from_slice(b"BIN\0");
        out.extend_from_slice(binary);
        out
    }
}

fn single(v: DVec3) -> [f32; 3] {
    v.as_vec3().into()
}

/// Of length 1 to f32, as the format wants it; up where there is none.
fn unit(n: [f32; 3]) -> [f32; 3] {
    single(DVec3::from(n.map(f64::from)).try_normalize().unwrap_or(DVec3::Y))
}
