//! The bytes of a binary glTF.

use std::collections::BTreeMap;

use glam::DVec3;
use serde_json::{Value, json};

use super::fit::Part;
use crate::export::{About, colours, inside, usd::linear};
use crate::frames::Frame;

/// A file in the making.
pub(super) struct File {
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
    pub fn new(times: &[f64]) -> Self {
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
    pub fn node(&mut self, name: &str, frame: &Frame, part: &Part, rigid: bool, extras: Option<Value>) {
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
        let places: Vec<[f32; 3]> = part.poses.iter().map(|p| single(p.0)).collect();
        let turns: Vec<[f32; 4]> = part.poses.iter().map(|p| p.1.as_quat().normalize().to_array()).collect();
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

    pub fn finish(self, about: &About) -> Vec<u8> {
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
