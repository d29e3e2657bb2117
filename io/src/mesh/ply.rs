//! Stanford PLY: ascii and both binaries, read and written by `ply-rs-bw`. Of the vertices x, y, z are read, of the
//! faces the list `vertex_indices` (or `vertex_index`); everything else is passed over.
//!
//! Rows are asked for one by one, so that errors know their line or byte, and a damaged count is held against the size
//! of the file first. Own is what `ply-rs-bw` 4.0 does not do: numbers such as `.5`, `5.` and `nan` in text
//! ([`spelled_out`]), comments that are not UTF-8, blank lines, and a word about names given twice, of which it would
//! drop one and then read the wrong columns ([`header`]).

use super::build::TriBuilder;
use super::cursor::{Cursor, find, number, shorten};
use super::error::{MeshError, Place, Problem};
use super::scalar::Endian;
use fissure_meshing::TriMesh;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    Addable, ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyDef, PropertyType,
    ScalarType,
};
use ply_rs_bw::writer::Writer;
use std::io::{self, ErrorKind, Write};
use std::path::Path;

const AXES: [&str; 3] = ["x", "y", "z"];

fn is_corners(name: &str) -> bool {
    matches!(name, "vertex_indices" | "vertex_index")
}

/// A row of any element, as far as we read it.
struct Row {
    position: [f64; 3],
    corners: Vec<i64>,
}

impl PropertyAccess for Row {
    fn new() -> Self {
        Row { position: [0.0; 3], corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if is_corners(name) {
            self.corners = match value {
                Property::ListChar(v) => v.into_iter().map(i64::from).collect(),
                Property::ListUChar(v) => v.into_iter().map(i64::from).collect(),
                Property::ListShort(v) => v.into_iter().map(i64::from).collect(),
                Property::ListUShort(v) => v.into_iter().map(i64::from).collect(),
                Property::ListInt(v) => v.into_iter().map(i64::from).collect(),
                Property::ListUInt(v) => v.into_iter().map(i64::from).collect(),
                _ => return PropertyAccessResult::UnsupportedType,
            };
        } else if let Some(axis) = AXES.iter().position(|a| *a == name) {
            self.position[axis] = match value {
                Property::Char(v) => v.into(),
                Property::UChar(v) => v.into(),
                Property::Short(v) => v.into(),
                Property::UShort(v) => v.into(),
                Property::Int(v) => v.into(),
                Property::UInt(v) => v.into(),
                Property::Float(v) => v.into(),
                Property::Double(v) => v,
                _ => return PropertyAccessResult::Ignored,
            };
        }
        PropertyAccessResult::Set
    }
}

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriMesh, MeshError> {
    let mut at = Cursor::new(path, bytes);
    let header = header(&mut at)?;
    let text = header.encoding == Encoding::Ascii;
    if !text {
        at.endian = Some(Endian::Little); // from here on bytes are counted, not lines
    }
    let mut out = TriBuilder::default();
    // Faces may come first in the file: they wait for the vertices.
    let (mut faces, mut corners) = (Vec::new(), Vec::new());
    for element in header.elements.values().filter(|e| !e.properties.is_empty()) {
        let kind = |name: &str| element.properties.get(name).map(|p| &p.data_type);
        let is_vertex = element.name == "vertex";
        if is_vertex && !AXES.iter().all(|a| matches!(kind(a), Some(PropertyType::Scalar(_)))) {
            return Err(at.unexpected("vertex properties x, y and z", b"a header without them"));
        }
        at.count(
            element.count as u64,
            least(element, text),
            &format!("elements '{}'", shorten(element.name.as_bytes())),
        )?;
        let is_face = element.name == "face" && element.properties.keys().any(|name| is_corners(name));
        for n in 0..element.count {
            let row = row(&mut at, header.encoding, element)?;
            if is_vertex {
                out.vertex(&at, n as i64, row.position)?;
            } else if is_face {
                faces.push((at.mark(), row.corners.len()));
                corners.extend(row.corners);
            }
        }
    }
    let mut rest = &corners[..];
    for (f, &(mark, n)) in faces.iter().enumerate() {
        let (face, later) = rest.split_at(n);
        rest = later;
        out.polygon(&at.marked(mark), face, 0, || format!("face {f}"))?;
    }
    out.finish(&at)
}

fn header(at: &mut Cursor) -> Result<Header, MeshError> {
    let bytes = at.left();
    let Some(end) = find(bytes, b"\nend_header") else {
        return Err(match bytes.trim_ascii_start().starts_with(b"ply") {
            true => at.truncated("the header"),
            false => at.unexpected("'ply' as the first line and 'end_header' later", b"something else"),
        });
    };
    let end = end + 1 + bytes[end + 1..].iter().position(|&c| c == b'\n').map_or(bytes.len() - end - 1, |n| n + 1);
    let head: String = bytes[..end].iter().map(|&c| if c.is_ascii() { char::from(c) } else { '?' }).collect();
    let header = Parser::<Row>::new().read_header(&mut Reader::new(head.as_bytes())).map_err(|e| {
        let (place, expected, found) = match e.line().and_then(|n| Some((n, head.lines().nth(n.checked_sub(1)?)?))) {
            Some((1, line)) => (Place::Line(1), "'ply' as the first line", line),
            Some((n, line)) => (Place::Line(n as u64), "a line of a PLY header", line),
            None => {
                (Place::Whole, "a line 'format ascii 1.0' or 'format binary_little_endian 1.0' in the header", "none")
            }
        };
        let problem = Problem::Unexpected { expected: expected.into(), found: shorten(found.as_bytes()) };
        MeshError::content(at.path(), place, problem)
    })?;
    let lines = head.lines().filter(|l| l.starts_with("element") || l.starts_with("property")).count();
    let named: usize = header.elements.values().map(|e| 1 + e.properties.len()).sum();
    if lines != named {
        let problem = Problem::Unexpected {
            expected: "a header that names each element and property once".into(),
            found: "one name twice".into(),
        };
        return Err(MeshError::content(at.path(), Place::Whole, problem));
    }
    at.skip(end);
    Ok(header)
}

/// Fewest bytes of one row.
fn least(element: &ElementDef, text: bool) -> usize {
    let size = |p: &PropertyDef| match p.data_type {
        PropertyType::Scalar(ref kind) | PropertyType::List(ref kind, _) => match kind {
            _ if text => 2,
            ScalarType::Char | ScalarType::UChar => 1,
            ScalarType::Short | ScalarType::UShort => 2,
            ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
            ScalarType::Double => 8,
        },
    };
    element.properties.values().map(size).sum()
}

/// The next row; errors about it then name its place.
fn row(at: &mut Cursor, encoding: Encoding, element: &ElementDef) -> Result<Row, MeshError> {
    let parser = Parser::<Row>::new();
    let what = |all| format!("{all} '{}'", shorten(element.name.as_bytes()));
    if encoding == Encoding::Ascii {
        let Some(line) = at.full_line() else { return Err(at.truncated(&what("the elements"))) };
        let text = String::from_utf8_lossy(line);
        let row = parser.read_ascii_element(&text, element);
        return row
            .or_else(|_| parser.read_ascii_element(&spelled_out(&text), element))
            .map_err(|_| at.unexpected(&what("the numbers that the header declares for an element"), line));
    }
    let (mut rest, all) = (at.left(), at.left().len());
    let row = match encoding {
        Encoding::BinaryBigEndian => parser.read_big_endian_element(&mut rest, element),
        _ => parser.read_little_endian_element(&mut rest, element),
    };
    let used = if row.is_ok() { all - rest.len() } else { 0 };
    at.take(used, "the elements")?;
    row.map_err(|e| match e.kind() {
        ErrorKind::UnexpectedEof => at.truncated(&what("the elements")),
        _ => at.unexpected(&what("the numbers that the header declares for an element"), e.to_string().as_bytes()),
    })
}

/// The line with the numbers that are no integers written such that `ply-rs-bw` accepts them. Not-a-numbers become
/// infinite: it knows no word for either, but reads more than a double can hold.
fn spelled_out(line: &str) -> String {
    let mut out = String::with_capacity(line.len() + 8);
    for word in line.split_whitespace() {
        match (number::<i64>(word.as_bytes()), number::<f64>(word.as_bytes())) {
            (None, Some(x)) if x.is_finite() => out += &format!("{x:e} "),
            (None, Some(x)) => out += if x < 0.0 { "-1e999 " } else { "1e999 " },
            _ => out.extend([word, " "]),
        }
    }
    out
}

/// A row to be written: a vertex or a triangle.
struct Out {
    position: [f64; 3],
    triangle: [u32; 3],
}

impl PropertyAccess for Out {
    fn new() -> Self {
        Out { position: [0.0; 3], triangle: [0; 3] }
    }

    fn get_double(&self, name: &str) -> Option<f64> {
        AXES.iter().position(|a| *a == name).map(|axis| self.position[axis])
    }

    fn get_list_uint(&self, _: &str) -> Option<&[u32]> {
        Some(&self.triangle)
    }
}

/// Binary, little endian, coordinates in double precision.
pub(super) fn write(mesh: &TriMesh, mut out: &mut dyn Write) -> io::Result<()> {
    let mut vertex = ElementDef { count: mesh.vertices.len(), ..ElementDef::new("vertex".into()) };
    for axis in AXES {
        vertex.properties.add(PropertyDef::new(axis.into(), PropertyType::Scalar(ScalarType::Double)));
    }
    let mut face = ElementDef { count: mesh.triangles.len(), ..ElementDef::new("face".into()) };
    let list = PropertyType::List(ScalarType::UChar, ScalarType::UInt);
    face.properties.add(PropertyDef::new("vertex_indices".into(), list));
    let mut header =
        Header { encoding: Encoding::BinaryLittleEndian, comments: vec!["metres".into()], ..Header::new() };
    header.elements.add(vertex.clone());
    header.elements.add(face.clone());

    let writer = Writer::<Out>::new();
    writer.write_header(&mut out, &header)?;
    for p in &mesh.vertices {
        let row = Out { position: p.to_array(), ..Out::new() };
        writer.write_little_endian_element(&mut out, &row, &vertex)?;
    }
    for &triangle in &mesh.triangles {
        writer.write_little_endian_element(&mut out, &Out { triangle, ..Out::new() }, &face)?;
    }
    Ok(())
}
