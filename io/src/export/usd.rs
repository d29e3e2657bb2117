//! USD as value clips in plain text: a stage that never holds data, a manifest that says which attributes vary, and a file of
//! time samples for each frame.
//!
//! Clips are listed one by one, for a template path makes every reader guess files that are not there. The metadata of an
//! attribute (`interpolation`) is not taken from clips, so the stage declares every attribute that they hold.
//!
//! Outside and crack faces are meshes of their own, each with its material: Blender reads the faces of a `GeomSubset` at the first
//! frame only, and shows cracks in the colour of the skin.

use std::fmt::Write as _;
use std::path::PathBuf;

use super::{About, ExportError, Shot, Stream, colours, inside, kept, make, name, write};
use crate::frames::{Frame, ParticleFrame};

pub(super) struct Usd {
    dir: PathBuf,
    about: About,
    /// Frames with a clip, ascending.
    frames: Vec<u32>,
    has_colliders: bool,
    has_particles: bool,
}

const HEAD: &str = "#usda 1.0\n";
const MESHES: [&str; 3] = ["outside", "inside", "colliders"];

/// What varies on every surface: type, name, and whether it is one value a vertex.
const SURFACE: [(&str, &str, bool); 11] = [
    ("float3[]", "extent", false),
    ("int[]", "faceVertexCounts", false),
    ("int[]", "faceVertexIndices", false),
    ("normal3f[]", "normals", true),
    ("point3f[]", "points", false),
    ("vector3f[]", "velocities", false),
    ("float[]", "primvars:damage", true),
    ("float[]", "primvars:stretch", true),
    ("int[]", "primvars:id", true),
    ("int[]", "primvars:inside", true),
    ("int[]", "primvars:piece", true),
];
const PARTICLES: [(&str, &str, bool); 9] = [
    ("float3[]", "extent", false),
    ("int64[]", "ids", false),
    ("point3f[]", "points", false),
    ("vector3f[]", "velocities", false),
    ("float[]", "widths", true),
    ("float[]", "primvars:damage", true),
    ("int[]", "primvars:piece", true),
    ("int[]", "primvars:body", true),
    ("float[]", "primvars:mass", true),
];

impl Usd {
    pub fn open(dir: PathBuf, about: About, from: u32) -> Result<Self, ExportError> {
        make(&dir.join("clips"))?;
        let frames = kept(&dir.join("clips"), "usda", from)?;
        Ok(Self { dir, about, frames, has_colliders: false, has_particles: false })
    }

    /// The prims and their attributes; with `whole` everything that does not vary too, for the stage.
    fn prims(&self, whole: bool) -> String {
        let only = |part: &str| if whole { part.to_owned() } else { String::new() };
        let api = only(" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )");
        let mut text = String::new();
        for mesh in self.meshes() {
            text += &format!("    def Mesh \"{mesh}\"{api}\n    {{\n");
            text += &only(&format!("        rel material:binding = </run/materials/{mesh}>\n"));
            text += &only("        uniform token subdivisionScheme = \"none\"\n");
            declare(&mut text, "        ", &SURFACE);
            text += "    }\n\n";
        }
        if self.has_particles {
            // guides are there when asked for, and do not stick out of the surface otherwise
            text += "    def Points \"particles\"\n    {\n";
            text += &only("        uniform token purpose = \"guide\"\n");
            declare(&mut text, "        ", &PARTICLES);
            text += "    }\n\n";
        }
        text
    }

    /// The meshes, each of the material with its name.
    fn meshes(&self) -> &'static [&'static str] {
        if self.has_colliders { &MESHES } else { &MESHES[..2] }
    }

    fn stage(&self) -> String {
        let rate = self.about.rate();
        let (first, last) = (self.frames.first().copied().unwrap_or(0), self.frames.last().copied().unwrap_or(0));
        let list = |each: &dyn Fn(u32) -> String| self.frames.iter().map(|&n| each(n)).collect::<Vec<_>>().join(", ");
        let title = self.about.title.replace(['\\', '"', '\n'], " ");
        let mut text = format!(
            "{HEAD}(\n    defaultPrim = \"run\"\n    doc = \"{title}\"\n    endTimeCode = {last}\n    \
             framesPerSecond = {rate}\n    metersPerUnit = 1\n    startTimeCode = {first}\n    \
             timeCodesPerSecond = {rate}\n    upAxis = \"Y\"\n)\n\ndef Xform \"run\" (\n    kind = \"component\"\n    \
             clips = {{\n        dictionary default = {{\n            double2[] active = [{}]\n            \
             asset[] assetPaths = [{}]\n            asset manifestAssetPath = @./manifest.usda@\n            \
             string primPath = \"/run\"\n            double2[] times = [{}]\n        }}\n    }}\n)\n{{\n",
            self.frames.iter().enumerate().map(|(k, n)| format!("({n}, {k})")).collect::<Vec<_>>().join(", "),
            list(&|n| format!("@./clips/{}@", name(n, "usda"))),
            list(&|n| format!("({n}, {n})")),
        );
        text += &self.prims(true);
        text += "    def Scope \"materials\"\n    {\n";
        for ((name, colour), roughness) in self.meshes().iter().zip(colours(&self.about)).zip([0.3, 0.9, 0.5]) {
            let [r, g, b] = colour.map(linear);
            text += &format!(
                "        def Material \"{name}\"\n        {{\n            \
                 token outputs:surface.connect = </run/materials/{name}/shader.outputs:surface>\n\n            \
                 def Shader \"shader\"\n            {{\n                uniform token info:id = \"UsdPreviewSurface\"\n                \
                 color3f inputs:diffuseColor = ({r}, {g}, {b})\n                float inputs:roughness = {roughness}\n                \
                 token outputs:surface\n            }}\n        }}\n"
            );
        }
        text + "    }\n}\n"
    }

    fn manifest(&self) -> String {
        format!("{HEAD}(\n    defaultPrim = \"run\"\n)\n\ndef \"run\"\n{{\n{}}}\n", self.prims(false))
    }
}

impl Stream for Usd {
    fn frame(&mut self, shot: &Shot<'_>) -> Result<(), ExportError> {
        let frame = shot.surface;
        let mut clip = Clip { text: format!("{HEAD}\nover \"run\"\n{{\n"), number: frame.number };
        clip.surface("outside", &side(frame, false));
        clip.surface("inside", &side(frame, true));
        if let Some(colliders) = shot.colliders {
            self.has_colliders = true;
            clip.surface("colliders", colliders);
        }
        if let Some(particles) = shot.particles {
            self.has_particles = true;
            clip.particles(particles);
        }
        clip.text += "}\n";
        write(&self.dir.join("clips").join(name(frame.number, "usda")), |out| out.write_all(clip.text.as_bytes()))?;
        self.frames.push(frame.number);
        Ok(())
    }

    fn index(&mut self) -> Result<(), ExportError> {
        // the manifest first: a stage never points at what is not there
        for (file, text) in [("manifest.usda", self.manifest()), ("stage.usda", self.stage())] {
            write(&self.dir.join(file), |out| out.write_all(text.as_bytes()))?;
        }
        Ok(())
    }
}

fn declare(text: &mut String, indent: &str, attributes: &[(&str, &str, bool)]) {
    for (kind, name, vertex) in attributes {
        let meta =
            if *vertex { format!(" (\n{indent}    interpolation = \"vertex\"\n{indent})") } else { String::new() };
        *text += &format!("{indent}{kind} {name}{meta}\n");
    }
}

/// The time samples of one frame.
struct Clip {
    text: String,
    number: u32,
}

impl Clip {
    fn surface(&mut self, prim: &str, frame: &Frame) {
        self.text += &format!("    over \"{prim}\"\n    {{\n");
        self.extent(&frame.positions, |_| 0.0);
        self.sample("int[]", "faceVertexCounts", frame.triangles.iter().map(|_| 3));
        self.sample("int[]", "faceVertexIndices", frame.triangles.iter().flatten());
        self.vectors("normal3f[]", "normals", &frame.normals);
        self.vectors("point3f[]", "points", &frame.positions);
        self.vectors("vector3f[]", "velocities", &frame.velocity);
        self.sample("float[]", "primvars:damage", &frame.damage);
        self.sample("float[]", "primvars:stretch", &frame.stretch);
        self.sample("int[]", "primvars:id", &frame.id);
        self.sample("int[]", "primvars:inside", &frame.inside);
        self.sample("int[]", "primvars:piece", &frame.piece);
        self.text += "    }\n";
    }

    fn particles(&mut self, p: &ParticleFrame) {
        self.text += "    over \"particles\"\n    {\n";
        self.extent(&p.positions, |k| p.width(k) / 2.0);
        // numbers of particles begin anew in every body
        self.sample(
            "int64[]",
            "ids",
            p.id.iter().zip(&p.body).map(|(&id, &body)| u64::from(body) << 32 | u64::from(id)),
        );
        self.vectors("point3f[]", "points", &p.positions);
        self.vectors("vector3f[]", "velocities", &p.velocity);
        self.sample("float[]", "widths", (0..p.positions.len()).map(|k| p.width(k)));
        self.sample("float[]", "primvars:damage", &p.damage);
        self.sample("int[]", "primvars:piece", &p.piece);
        self.sample("int[]", "primvars:body", &p.body);
        self.sample("float[]", "primvars:mass", &p.mass);
        self.text += "    }\n";
    }

    fn extent(&mut self, points: &[[f32; 3]], radius: impl Fn(usize) -> f32) {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for (k, p) in points.iter().enumerate() {
            for a in 0..3 {
                low[a] = low[a].min(p[a] - radius(k));
                high[a] = high[a].max(p[a] + radius(k));
            }
        }
        if !points.is_empty() {
            self.vectors("float3[]", "extent", &[low, high]);
        }
    }

    fn begin(&mut self, kind: &str, name: &str) {
        write!(self.text, "        {kind} {name}.timeSamples = {{ {}: [", self.number).expect("a string grows");
    }

    /// One value each, in the shortest text that reads back as the same.
    fn sample<T: std::fmt::Debug>(&mut self, kind: &str, name: &str, values: impl IntoIterator<Item = T>) {
        self.begin(kind, name);
        for (k, value) in values.into_iter().enumerate() {
            let comma = if k == 0 { "" } else { ", " };
            write!(self.text, "{comma}{value:?}").expect("a string grows");
        }
        self.text += "] }\n";
    }

    fn vectors(&mut self, kind: &str, name: &str, values: &[[f32; 3]]) {
        self.begin(kind, name);
        for (k, [x, y, z]) in values.iter().enumerate() {
            let comma = if k == 0 { "" } else { ", " };
            write!(self.text, "{comma}({x:?}, {y:?}, {z:?})").expect("a string grows");
        }
        self.text += "] }\n";
    }
}

/// The triangles of one side with their vertices. A mesh without points is an error to many readers, so what has no triangles
/// has one vertex.
fn side(frame: &Frame, is_inside: bool) -> Frame {
    let mut vertices = Vec::new();
    let mut new = vec![u32::MAX; frame.positions.len()];
    let mut triangles = Vec::new();
    for t in frame.triangles.iter().filter(|t| inside(frame, t) == is_inside) {
        triangles.push(t.map(|v| {
            if new[v as usize] == u32::MAX {
                new[v as usize] = vertices.len() as u32;
                vertices.push(v as usize);
            }
            new[v as usize]
        }));
    }
    if vertices.is_empty() && !frame.positions.is_empty() {
        vertices.push(0);
    }
    fn of<T: Copy>(column: &[T], vertices: &[usize]) -> Vec<T> {
        vertices.iter().map(|&v| column[v]).collect()
    }
    Frame {
        positions: of(&frame.positions, &vertices),
        normals: of(&frame.normals, &vertices),
        velocity: of(&frame.velocity, &vertices),
        damage: of(&frame.damage, &vertices),
        stretch: of(&frame.stretch, &vertices),
        id: of(&frame.id, &vertices),
        inside: of(&frame.inside, &vertices),
        piece: of(&frame.piece, &vertices),
        triangles,
        time: frame.time,
        number: frame.number,
    }
}

/// A colour as light: sRGB without its curve.
pub(super) fn linear(x: f32) -> f32 {
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}
