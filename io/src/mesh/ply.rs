//! Stanford PLY: ascii and both binaries. Of the vertices x, y, z are read, of the faces the list `vertex_indices` (or
//! `vertex_index`); everything else is stepped over by its declared size.

use super::build::TriBuilder;
use super::cursor::{Cursor, number, shorten};
use super::error::{MeshError, Problem};
use super::scalar::{Endian, Scalar};
use fissure_meshing::TriMesh;
use std::io::{self, Write};
use std::path::Path;

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

struct Property {
    name: String,
    /// Type of the length, if it is a list.
    list: Option<Scalar>,
    item: Scalar,
}

impl Element {
    /// Fewest bytes of one such element.
    fn least(&self, text: bool) -> usize {
        if text {
            2 * self.properties.len()
        } else {
            self.properties.iter().map(|p| p.list.unwrap_or(p.item).size()).sum()
        }
    }
}

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriMesh, MeshError> {
    let mut at = Cursor::new(path, bytes);
    let (endian, elements) = header(&mut at)?;
    at.endian = endian;
    let mut out = TriBuilder::default();
    // Faces may come first in the file: they wait for the vertices.
    let (mut faces, mut corners) = (Vec::new(), Vec::new());
    for element in &elements {
        let what = format!("elements '{}'", element.name);
        let count = at.count(element.count, element.least(endian.is_none()), &what)?;
        match element.name.as_str() {
            "vertex" => vertices(&mut at, element, count, &mut out)?,
            _ if element.properties.is_empty() => {}
            name => {
                for _ in 0..count {
                    for p in &element.properties {
                        let wanted = name == "face" && matches!(p.name.as_str(), "vertex_indices" | "vertex_index");
                        let n = match p.list {
                            Some(length) => at.counted(length, [2, p.item.size()], "list items")?,
                            None => 1,
                        };
                        if wanted {
                            faces.push((at.mark(), n));
                        }
                        for _ in 0..n {
                            if wanted {
                                corners.push(at.int(p.item, "the faces")?);
                            } else {
                                at.real(p.item, "the properties")?;
                            }
                        }
                    }
                }
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

fn vertices(at: &mut Cursor, element: &Element, count: usize, out: &mut TriBuilder) -> Result<(), MeshError> {
    let axis = |p: &Property| ["x", "y", "z"].iter().position(|a| *a == p.name).filter(|_| p.list.is_none());
    let axes: Vec<Option<usize>> = element.properties.iter().map(axis).collect();
    if (0..3).any(|k| !axes.contains(&Some(k))) {
        return Err(at.unexpected("vertex properties x, y and z", b"a header without them"));
    }
    for v in 0..count {
        let mut position = [0.0; 3];
        for (p, axis) in element.properties.iter().zip(&axes) {
            let n = match p.list {
                Some(length) => at.counted(length, [2, p.item.size()], "list items")?,
                None => 1,
            };
            for _ in 0..n {
                let value = at.real(p.item, "the vertices")?;
                if let Some(k) = axis {
                    position[*k] = value;
                }
            }
        }
        out.vertex(at, v as i64, position)?;
    }
    Ok(())
}

fn header(at: &mut Cursor) -> Result<(Option<Endian>, Vec<Element>), MeshError> {
    if at.line().map(<[u8]>::trim_ascii) != Some(b"ply") {
        return Err(at.unexpected("'ply' as the first line", b"something else"));
    }
    let mut endian = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        let Some(line) = at.line() else { return Err(at.truncated("the header")) };
        let words: Vec<&[u8]> = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).collect();
        let scalar = |word: &[u8]| {
            std::str::from_utf8(word).ok().and_then(Scalar::named).ok_or_else(|| at.unexpected("a type of PLY", word))
        };
        match words[..] {
            [b"end_header", ..] => break,
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"format", b"ascii", _] => endian = Some(None),
            [b"format", b"binary_little_endian", _] => endian = Some(Some(Endian::Little)),
            [b"format", b"binary_big_endian", _] => endian = Some(Some(Endian::Big)),
            [b"element", name, count] => {
                let count = number(count).ok_or_else(|| at.unexpected("a count", count))?;
                elements.push(Element { name: shorten(name), count, properties: Vec::new() });
            }
            [b"property", ref kind @ .., name] if !elements.is_empty() && !kind.is_empty() => {
                let (list, item) = match *kind {
                    [item] => (None, scalar(item)?),
                    [b"list", length, item] => (Some(scalar(length)?), scalar(item)?),
                    _ => return Err(at.unexpected("'property TYPE NAME'", line)),
                };
                let name = shorten(name);
                if list.is_some_and(Scalar::is_float)
                    || list.is_some() && name.starts_with("vertex_ind") && item.is_float()
                {
                    return Err(at.unexpected("an integer type", line));
                }
                if let Some(last) = elements.last_mut() {
                    last.properties.push(Property { name, list, item });
                }
            }
            _ => return Err(at.unexpected("a line of a PLY header", line)),
        }
    }
    match endian {
        Some(endian) => Ok((endian, elements)),
        None => Err(at.fail(Problem::Unexpected {
            expected: "a line 'format ascii 1.0' or 'format binary_little_endian 1.0' in the header".into(),
            found: "none".into(),
        })),
    }
}

/// Binary, little endian, coordinates in double precision.
pub(super) fn write(mesh: &TriMesh, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment metres")?;
    writeln!(out, "element vertex {}", mesh.vertices.len())?;
    writeln!(out, "property double x\nproperty double y\nproperty double z")?;
    writeln!(out, "element face {}\nproperty list uchar uint vertex_indices\nend_header", mesh.triangles.len())?;
    for p in &mesh.vertices {
        for x in p.to_array() {
            out.write_all(&x.to_le_bytes())?;
        }
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        for v in triangle {
            out.write_all(&v.to_le_bytes())?;
        }
    }
    Ok(())
}
