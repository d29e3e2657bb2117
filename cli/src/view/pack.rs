//! Frames as the page takes them: a header in JSON, then arrays that a browser can use as they lie.
//!
//! ```text
//! u32 little-endian        length of the header
//! header                   {"number", "time", "columns": {name: {"type", "per", "at", "count", …}}}, filled up with blanks
//! columns                  each from `at` on, counted from the end of the header, a multiple of 8
//! ```
//! A column is `count` elements of `per` numbers of a type: `u8`, `u16`, `u32`, `f32`, little-endian. Where it says `step`
//! and `from`, the numbers that are meant are `from + step · n`. Triangles are sorted: the outer surface first, `outer` of
//! them, then crack faces, so that those can be left out of a drawing.

use fissure_io::frames::{Frame, FrameError, ParticleFrame};
use serde_json::{Map, Value, json};

/// In how many bits positions and velocities go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Precision {
    /// f32, as in the files.
    Full,
    /// 16 bits between the least and the largest of the frame: half the bytes, and far better to compress.
    Sixteen,
}

/// A frame in the making.
pub(super) struct Pack {
    precision: Precision,
    head: Map<String, Value>,
    columns: Map<String, Value>,
    body: Vec<u8>,
}

impl Pack {
    /// Without columns yet; `time` in seconds.
    pub fn new(number: u32, time: f64, precision: Precision) -> Self {
        let mut head = Map::new();
        head.insert("number".into(), number.into());
        head.insert("time".into(), time.into());
        Self { precision, head, columns: Map::new(), body: Vec::new() }
    }

    /// Adds the surface of the bodies.
    pub fn surface(&mut self, frame: &Frame) -> Result<(), FrameError> {
        frame.check()?;
        let (outer, crack): (Vec<_>, Vec<_>) =
            frame.triangles.iter().partition(|corners| corners.iter().any(|&v| frame.inside[v as usize] == 0));
        self.head.insert("outer".into(), outer.len().into());
        self.vectors("position", &frame.positions);
        self.normals("normal", &frame.normals);
        self.vectors("velocity", &frame.velocity);
        self.share("damage", &frame.damage);
        self.integers("id", 1, &frame.id);
        self.integers("piece", 1, &frame.piece);
        self.column("inside", "u8", 1, &frame.inside, []);
        self.integers("triangle", 3, &[outer.as_flattened(), crack.as_flattened()].concat());
        Ok(())
    }

    /// Adds the surfaces of the colliders.
    pub fn colliders(&mut self, frame: &Frame) -> Result<(), FrameError> {
        frame.check()?;
        self.vectors("collider.position", &frame.positions);
        self.normals("collider.normal", &frame.normals);
        self.integers("collider.triangle", 3, frame.triangles.as_flattened());
        Ok(())
    }

    /// Adds particles.
    pub fn particles(&mut self, particles: &ParticleFrame) -> Result<(), FrameError> {
        particles.check()?;
        let width: Vec<f32> = (0..particles.positions.len()).map(|k| particles.width(k)).collect();
        self.vectors("position", &particles.positions);
        self.vectors("velocity", &particles.velocity);
        self.share("damage", &particles.damage);
        self.integers("id", 1, &particles.id);
        self.integers("piece", 1, &particles.piece);
        self.integers("body", 1, &particles.body);
        self.column("width", "f32", 1, &bytes_of(&width), []);
        self.column("mass", "f32", 1, &bytes_of(&particles.mass), []);
        Ok(())
    }

    /// The bytes.
    pub fn into_bytes(mut self) -> Vec<u8> {
        self.head.insert("columns".into(), self.columns.into());
        let mut head = Value::from(self.head).to_string();
        head.extend(std::iter::repeat_n(' ', (8 - (4 + head.len()) % 8) % 8));
        let mut bytes = Vec::with_capacity(4 + head.len() + self.body.len());
        bytes.extend((head.len() as u32).to_le_bytes());
        bytes.extend(head.as_bytes());
        bytes.extend(self.body);
        bytes
    }

    fn column<const N: usize>(&mut self, name: &str, kind: &str, per: usize, bytes: &[u8], more: [(&str, Value); N]) {
        let size = match kind {
            "u8" => 1,
            "u16" => 2,
            _ => 4,
        };
        let mut column = Map::new();
        column.insert("type".into(), kind.into());
        column.insert("per".into(), per.into());
        column.insert("at".into(), self.body.len().into());
        column.insert("count".into(), (bytes.len() / (size * per)).into());
        column.extend(more.map(|(key, value)| (key.to_owned(), value)));
        self.columns.insert(name.into(), column.into());
        self.body.extend(bytes);
        self.body.resize(self.body.len().next_multiple_of(8), 0);
    }

    /// Numbers of the smallest type that holds all.
    fn integers(&mut self, name: &str, per: usize, numbers: &[u32]) {
        if numbers.iter().all(|&n| n <= u32::from(u16::MAX)) {
            let bytes: Vec<u8> = numbers.iter().flat_map(|&n| (n as u16).to_le_bytes()).collect();
            self.column(name, "u16", per, &bytes, []);
        } else {
            let bytes: Vec<u8> = numbers.iter().flat_map(|&n| n.to_le_bytes()).collect();
            self.column(name, "u32", per, &bytes, []);
        }
    }

    /// Numbers from 0 to 1.
    fn share(&mut self, name: &str, numbers: &[f32]) {
        let most = f32::from(u16::MAX);
        // what is not a number becomes 0
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| ((x * most).round() as u16).to_le_bytes()).collect();
        self.column(name, "u16", 1, &bytes, [("step", json!([1.0 / most])), ("from", json!([0.0]))]);
    }

    fn vectors(&mut self, name: &str, vectors: &[[f32; 3]]) {
        if self.precision == Precision::Full {
            return self.column(name, "f32", 3, &bytes_of(vectors.as_flattened()), []);
        }
        let finite = || vectors.iter().filter(|v| v.iter().all(|x| x.is_finite()));
        let fold =
            |start: f32, f: fn(f32, f32) -> f32| finite().fold([start; 3], |a, v| [0, 1, 2].map(|k| f(a[k], v[k])));
        let (low, high) = (fold(f32::INFINITY, f32::min), fold(f32::NEG_INFINITY, f32::max));
        let low = low.map(|x| if x.is_finite() { f64::from(x) } else { 0.0 });
        let step = [0, 1, 2].map(|k| ((f64::from(high[k]) - low[k]) / f64::from(u16::MAX)).max(1e-30));
        let place = |v: &[f32; 3], k: usize| ((f64::from(v[k]) - low[k]) / step[k]).round() as u16;
        let bytes: Vec<u8> =
            vectors.iter().flat_map(|v| [0, 1, 2].map(|k| place(v, k).to_le_bytes())).flatten().collect();
        self.column(name, "u16", 3, &bytes, [("step", json!(step)), ("from", json!(low))]);
    }

    /// Unit vectors on an octahedron unfolded into a square (Cigolle et al., A Survey of Efficient Representations for
    /// Independent Unit Vectors, JCGT 2014), of two bytes a side or, in few bits, one: 1° off at most.
    fn normals(&mut self, name: &str, normals: &[[f32; 3]]) {
        if self.precision == Precision::Full {
            let side = |c: f32| (32767.0 + 32767.0 * c).round() as u16;
            let bytes: Vec<u8> =
                normals.iter().flat_map(|&n| octahedral(n).map(|c| side(c).to_le_bytes())).flatten().collect();
            self.column(name, "u16", 2, &bytes, []);
        } else {
            let side = |c: f32| (127.0 + 127.0 * c).round() as u8;
            let bytes: Vec<u8> = normals.iter().flat_map(|&n| octahedral(n).map(side)).collect();
            self.column(name, "u8", 2, &bytes, []);
        }
    }
}

fn bytes_of(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Where on the unfolded octahedron a vector points, each from -1 to 1; one without length to the middle.
fn octahedral([x, y, z]: [f32; 3]) -> [f32; 2] {
    let sum = x.abs() + y.abs() + z.abs();
    let (u, v) = if sum > 0.0 { (x / sum, y / sum) } else { (0.0, 0.0) };
    let fold = |a: f32, b: f32| (1.0 - b.abs()) * 1f32.copysign(a);
    if z < 0.0 { [fold(u, v), fold(v, u)] } else { [u, v] }
}
