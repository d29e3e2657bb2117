//! Frames as the page takes them: a header in JSON, then arrays that a browser can use as they lie.
//!
//! ```text
//! u32 little-endian        length of the header
//! header                   {"number", "time", "columns": {name: {"type", "per", "at", "count", …}}}, filled up with blanks
//! columns                  each from `at` on, counted from the end of the header, a multiple of 8
//! ```
//! A column is `count` elements of `per` numbers of a type: `u8`, `u16`, `u32`, `f32`, little-endian. Where it says `step`
//! and `from` (one for each of `per`), the numbers that are meant are `from + step · n`. Triangles are sorted: the outer surface first, `outer` of
//! them, then crack faces, so that those can be left out of a drawing.

use fissure_io::frames::{Frame, FrameError, ParticleFrame};
use serde_json::{Map, Value, json};

/// In how many bits numbers with a fraction go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Precision {
    /// f32, as in the files.
    Full,
    /// 16 bits between the least and the largest of the frame: half the bytes, and far better to compress. (Differences between
    /// neighbours, low bytes and high bytes apart, deflate to 15 % less still, which their code isn't worth.)
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
        self.numbers("position", &frame.positions);
        self.normals("normal", &frame.normals);
        self.numbers("velocity", &frame.velocity);
        self.numbers("damage", frame.damage.as_chunks::<1>().0);
        self.numbers("stretch", frame.stretch.as_chunks::<1>().0);
        self.integers("id", 1, &frame.id);
        self.integers("piece", 1, &frame.piece);
        self.column("inside", "u8", 1, &frame.inside, []);
        self.integers("triangle", 3, &[outer.as_flattened(), crack.as_flattened()].concat());
        Ok(())
    }

    /// Adds the surfaces of the colliders.
    pub fn colliders(&mut self, frame: &Frame) -> Result<(), FrameError> {
        frame.check()?;
        self.numbers("collider.position", &frame.positions);
        self.normals("collider.normal", &frame.normals);
        self.integers("collider.triangle", 3, frame.triangles.as_flattened());
        Ok(())
    }

    /// Adds particles.
    pub fn particles(&mut self, particles: &ParticleFrame) -> Result<(), FrameError> {
        particles.check()?;
        let width: Vec<f32> = (0..particles.positions.len()).map(|k| particles.width(k)).collect();
        self.numbers("position", &particles.positions);
        self.numbers("velocity", &particles.velocity);
        self.numbers("damage", particles.damage.as_chunks::<1>().0);
        self.integers("id", 1, &particles.id);
        self.integers("piece", 1, &particles.piece);
        self.integers("body", 1, &particles.body);
        self.numbers("width", width.as_chunks::<1>().0);
        self.numbers("mass", particles.mass.as_chunks::<1>().0);
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

    /// Numbers, `N` at a time.
    fn numbers<const N: usize>(&mut self, name: &str, numbers: &[[f32; N]]) {
        if self.precision == Precision::Full {
            return self.column(name, "f32", N, &bytes_of(numbers.as_flattened()), []);
        }
        let finite = || numbers.iter().filter(|v| v.iter().all(|x| x.is_finite()));
        let axes = || std::array::from_fn::<usize, N, _>(|k| k);
        let fold = |start: f32, f: fn(f32, f32) -> f32| finite().fold([start; N], |a, v| axes().map(|k| f(a[k], v[k])));
        let (low, high) = (fold(f32::INFINITY, f32::min), fold(f32::NEG_INFINITY, f32::max));
        let low = low.map(|x| if x.is_finite() { f64::from(x) } else { 0.0 });
        let step = axes().map(|k| ((f64::from(high[k]) - low[k]) / f64::from(u16::MAX)).max(1e-30));
        // what is not a number goes to an end
        let place = |v: &[f32; N], k: usize| ((f64::from(v[k]) - low[k]) / step[k]).round() as u16;
        let bytes: Vec<u8> = numbers.iter().flat_map(|v| axes().map(|k| place(v, k).to_le_bytes())).flatten().collect();
        self.column(name, "u16", N, &bytes, [("step", json!(step.as_slice())), ("from", json!(low.as_slice()))]);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The column `name` of `bytes`: what is said of it, and its bytes.
    fn column(bytes: &[u8], name: &str) -> (Value, Vec<u8>) {
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        let head: Value = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
        let about = head["columns"][name].clone();
        let number = |key: &str| about[key].as_u64().unwrap() as usize;
        let size = if about["type"] == "f32" { 4 } else { 2 };
        let start = 4 + length + number("at");
        assert_eq!(start % 8, 0);
        let bytes = bytes[start..start + size * number("count") * number("per")].to_vec();
        (about, bytes)
    }

    #[test]
    fn sixteen_bits_are_right_to_half_a_step_and_bad_numbers_harm_no_others() {
        let numbers = [[1.5_f32, -2.0], [2.5, 7.0], [1.7, 0.1], [f32::NAN, f32::INFINITY]];
        let mut pack = Pack::new(3, 0.5, Precision::Sixteen);
        pack.numbers("x", &numbers);
        let (about, bytes) = column(&pack.into_bytes(), "x");
        let raw: Vec<u16> = bytes.chunks(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
        for (row, wanted) in numbers[..3].iter().enumerate() {
            for k in 0..2 {
                let (from, step) = (about["from"][k].as_f64().unwrap(), about["step"][k].as_f64().unwrap());
                let got = from + step * f64::from(raw[2 * row + k]);
                assert!((got - f64::from(wanted[k])).abs() <= 0.51 * step, "{got} for {}", wanted[k]);
            }
        }
        assert!((about["step"][1].as_f64().unwrap() - 9.0 / 65535.0).abs() < 1e-12);
        let mut pack = Pack::new(3, 0.5, Precision::Sixteen);
        pack.numbers::<3>("none", &[]);
        assert!(column(&pack.into_bytes(), "none").1.is_empty());
    }

    #[test]
    fn normals_come_back_within_a_degree_in_bytes_and_a_hundredth_in_words() {
        let unfold = |u: f32, v: f32| {
            let z = 1.0 - u.abs() - v.abs();
            let under = (-z).max(0.0);
            glam::Vec3::new(u - under.copysign(u), v - under.copysign(v), z).normalize()
        };
        let mut worst = [0_f32; 2];
        for k in 0..1000 {
            let (up, turn) = (1.0 - 2.0 * (k as f32 + 0.5) / 1000.0, 2.4 * k as f32);
            let flat = (1.0 - up * up).sqrt();
            let normal = glam::Vec3::new(flat * turn.cos(), flat * turn.sin(), up);
            let [u, v] = octahedral(normal.to_array());
            for (which, half) in [127.0_f32, 32767.0].into_iter().enumerate() {
                let sent = |c: f32| (half + half * c).round() / half - 1.0;
                worst[which] = worst[which].max(unfold(sent(u), sent(v)).angle_between(normal).to_degrees());
            }
        }
        // 0.64° and 0.03°, of which the last is what f32 leaves of an arc cosine
        assert!(worst[0] < 1.0 && worst[1] < 0.05, "{worst:?}");
    }
}
