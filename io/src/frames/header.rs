//! The header of a frame's PLY file, and the records it describes.
//!
//! Columns are looked up by name, so files that passed through another program still open: properties may be in any
//! order and of any scalar type, unknown ones are passed over, missing ones are zero (`id`: the vertex number).
//! Counts are believed only as far as the file is long: a damaged header takes no memory.

use super::Frame;

/// A scalar type of PLY.
#[derive(Clone, Copy)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number at the front of `b`; f64 holds every value of all eight types. `b` is long enough.
    fn get(self, b: &[u8]) -> f64 {
        match self {
            Self::I8 => f64::from(b[0] as i8),
            Self::U8 => f64::from(b[0]),
            Self::I16 => f64::from(i16::from_le_bytes([b[0], b[1]])),
            Self::U16 => f64::from(u16::from_le_bytes([b[0], b[1]])),
            Self::I32 => f64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Self::U32 => f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Self::F32 => f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Self::F64 => f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]),
        }
    }
}

struct Column {
    kind: Kind,
    name: String,
}

/// The numbers of one property, one for each vertex.
pub(super) struct Values<'a> {
    kind: Kind,
    offset: usize,
    stride: usize,
    records: &'a [u8],
}

impl<'a> Values<'a> {
    pub fn iter(&self) -> impl Iterator<Item = f64> + use<'a> {
        let (kind, offset) = (self.kind, self.offset);
        self.records.chunks_exact(self.stride).map(move |record| kind.get(&record[offset..]))
    }
}

/// The properties of vertices by name.
type Columns<'a> = Vec<(&'a str, Values<'a>)>;

#[derive(Default)]
pub(super) struct Header {
    /// How many bytes the header takes.
    pub length: usize,
    /// Frame number and time (s), if the comment line of ours is there.
    pub number: Option<u32>,
    pub time: f64,
    pub vertices: usize,
    columns: Vec<Column>,
    faces: usize,
    list: Option<(Kind, Kind)>,
}

impl Header {
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        let mut header = Header::default();
        let mut element = "";
        let mut rest = bytes;
        for line in 1.. {
            let end = rest.iter().position(|&b| b == b'\n').ok_or("no end_header line before the end of the file")?;
            let text = std::str::from_utf8(&rest[..end]).map_err(|_| format!("line {line} is not text"))?;
            rest = &rest[end + 1..];
            let words: Vec<&str> = text.split_whitespace().collect();
            let bad = || format!("line {line} \"{}\" is not understood", text.trim_end());
            match words[..] {
                ["ply"] if line == 1 => {}
                _ if line == 1 => return Err("the first line is not \"ply\"".into()),
                ["format", "binary_little_endian", "1.0"] => {}
                ["comment", "fissure", "frame", number, "time", time, ..] => {
                    header.number = Some(number.parse().map_err(|_| bad())?);
                    header.time = time.parse().map_err(|_| bad())?;
                }
                ["comment" | "obj_info", ..] => {}
                ["element", "vertex", count] if header.columns.is_empty() && element.is_empty() => {
                    element = "vertex";
                    header.vertices = count.parse().map_err(|_| bad())?;
                }
                ["element", "face", count] if element == "vertex" => {
                    element = "face";
                    header.faces = count.parse().map_err(|_| bad())?;
                }
                ["property", kind, name] if element == "vertex" => {
                    header.columns.push(Column { kind: Kind::named(kind).ok_or_else(bad)?, name: name.into() });
                }
                ["property", "list", count, index, "vertex_indices" | "vertex_index"]
                    if element == "face" && header.list.is_none() =>
                {
                    header.list = Kind::named(count).zip(Kind::named(index));
                    header.list.ok_or_else(bad)?;
                }
                ["end_header"] => break,
                _ => return Err(bad()),
            }
        }
        for axis in ["x", "y", "z"] {
            if !header.columns.iter().any(|c| c.name == axis) {
                return Err(format!("vertices have no property {axis}"));
            }
        }
        header.length = bytes.len() - rest.len();
        Ok(header)
    }

    /// The properties of the vertices in `body`, which begins where the header ends, and what is left of it.
    pub fn columns<'a>(&'a self, body: &'a [u8]) -> Result<(Columns<'a>, &'a [u8]), String> {
        let stride = self.columns.iter().map(|c| c.kind.bytes()).sum::<usize>();
        let (body, rest) = (self.vertices.checked_mul(stride))
            .and_then(|length| body.split_at_checked(length))
            .ok_or_else(|| format!("the file ends inside its {} vertices", self.vertices))?;
        let mut offset = 0;
        let column = |c: &'a Column| {
            let values = Values { kind: c.kind, offset, stride, records: body };
            offset += c.kind.bytes();
            (c.name.as_str(), values)
        };
        Ok((self.columns.iter().map(column).collect(), rest))
    }

    /// Fills the vertex columns of `frame` from `body`, which begins where the header ends; gives what is left.
    pub fn read_vertices<'a>(&'a self, body: &'a [u8], frame: &mut Frame) -> Result<&'a [u8], String> {
        let (columns, rest) = self.columns(body)?;
        let n = self.vertices;
        frame.positions = vec![[0.0; 3]; n];
        frame.normals = vec![[0.0; 3]; n];
        frame.velocity = vec![[0.0; 3]; n];
        frame.damage = vec![0.0; n];
        frame.stretch = vec![0.0; n];
        frame.id = (0..n as u32).collect();
        frame.inside = vec![0; n];
        frame.piece = vec![0; n];
        for (name, values) in columns {
            let values = values.iter().enumerate();
            match name {
                "x" => values.for_each(|(k, v)| frame.positions[k][0] = v as f32),
                "y" => values.for_each(|(k, v)| frame.positions[k][1] = v as f32),
                "z" => values.for_each(|(k, v)| frame.positions[k][2] = v as f32),
                "nx" => values.for_each(|(k, v)| frame.normals[k][0] = v as f32),
                "ny" => values.for_each(|(k, v)| frame.normals[k][1] = v as f32),
                "nz" => values.for_each(|(k, v)| frame.normals[k][2] = v as f32),
                "velocity_x" => values.for_each(|(k, v)| frame.velocity[k][0] = v as f32),
                "velocity_y" => values.for_each(|(k, v)| frame.velocity[k][1] = v as f32),
                "velocity_z" => values.for_each(|(k, v)| frame.velocity[k][2] = v as f32),
                "damage" => values.for_each(|(k, v)| frame.damage[k] = v as f32),
                "stretch" => values.for_each(|(k, v)| frame.stretch[k] = v as f32),
                "id" => values.for_each(|(k, v)| frame.id[k] = v as u32),
                "inside" => values.for_each(|(k, v)| frame.inside[k] = v as u8),
                "piece" => values.for_each(|(k, v)| frame.piece[k] = v as u32),
                _ => {}
            }
        }
        Ok(rest)
    }

    /// The triangles in `body`, which begins where the vertices end.
    pub fn read_faces(&self, mut body: &[u8]) -> Result<Vec<[u32; 3]>, String> {
        let Some((count, index)) = self.list else {
            return if self.faces == 0 { Ok(Vec::new()) } else { Err("faces have no list vertex_indices".into()) };
        };
        let record = count.bytes() + 3 * index.bytes();
        // A header may claim any number of faces; take memory only for what the file can hold.
        let mut triangles = Vec::with_capacity(self.faces.min(body.len() / record));
        for face in 0..self.faces {
            let corners = body.get(..count.bytes()).map(|b| count.get(b));
            if corners.is_some_and(|n| n != 3.0) {
                return Err(format!("face {face} is not a triangle"));
            }
            let (this, rest) =
                body.split_at_checked(record).ok_or_else(|| format!("the file ends inside face {face}"))?;
            let corner = |k: usize| index.get(&this[count.bytes() + k * index.bytes()..]);
            let corners = [corner(0), corner(1), corner(2)];
            if let Some(bad) = corners.iter().find(|&&c| !(0.0..=f64::from(u32::MAX)).contains(&c)) {
                return Err(format!("face {face} names vertex {bad}"));
            }
            triangles.push(corners.map(|c| c as u32));
            body = rest;
        }
        Ok(triangles)
    }
}
