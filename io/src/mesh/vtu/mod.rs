//! VTK's XML unstructured grid (`.vtu`).
//!
//! Numbers stand in the XML as text or base64, or after `<AppendedData` raw or in base64. Raw bytes are no XML, so the
//! file is cut before that tag and what is left is closed by hand. Several pieces become one mesh; points that pieces
//! share stay apart, because a cut in the mesh looks the same.

mod data;
mod write;

pub(super) use write::write;

use super::LabelledTets;
use super::build::TetBuilder;
use super::cursor::{Cursor, find, shorten};
use super::error::{MeshError, Place, Problem};
use super::scalar::{Endian, Scalar};
use super::vtk::{Cells, is_label};
use data::{Encoding, Numbers};
use roxmltree::{Document, Node};
use std::path::Path;

/// The file around an array: what decoding one needs.
struct File<'a> {
    path: &'a Path,
    size: usize,
    endian: Endian,
    /// Type of the lengths before binary data.
    header: Scalar,
    zlib: bool,
    /// What stands after the `_` of the appended data, and how it is encoded.
    appended: Option<(&'a [u8], Encoding)>,
}

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<LabelledTets, MeshError> {
    let (xml, appended) = split(path, bytes)?;
    let fail = |line: u32, expected: &str, found: &str| {
        let problem = Problem::Unexpected { expected: expected.into(), found: shorten(found.as_bytes()) };
        MeshError::content(path, Place::Line(u64::from(line)), problem)
    };
    let document = Document::parse(&xml).map_err(|e| fail(e.pos().row, "XML of a .vtu file", &e.to_string()))?;
    let root = document.root_element();
    let grid = root.children().find(|n| n.has_tag_name("UnstructuredGrid"));
    let Some(grid) = grid.filter(|_| root.has_tag_name("VTKFile")) else {
        return Err(fail(1, "<VTKFile type=\"UnstructuredGrid\">", root.tag_name().name()));
    };
    let attribute = |name: &str, default| root.attribute(name).unwrap_or(default);
    let zlib = match attribute("compressor", "") {
        "" => false,
        "vtkZLibDataCompressor" => true,
        other => {
            let what = format!("data compressed by '{}'", shorten(other.as_bytes()));
            let cure = "save it with ZLib or without compression";
            return Err(MeshError::content(path, Place::Whole, Problem::Unsupported { what, cure }));
        }
    };
    let file = File {
        path,
        size: bytes.len(),
        endian: match attribute("byte_order", "LittleEndian") {
            "LittleEndian" => Endian::Little,
            "BigEndian" => Endian::Big,
            other => return Err(fail(1, "byte_order LittleEndian or BigEndian", other)),
        },
        header: match attribute("header_type", "UInt32") {
            "UInt32" => Scalar::U32,
            "UInt64" => Scalar::U64,
            other => return Err(fail(1, "header_type UInt32 or UInt64", other)),
        },
        zlib,
        appended,
    };

    let mut out = TetBuilder::default();
    let mut labels = Vec::new();
    for (p, piece) in grid.children().filter(|n| n.has_tag_name("Piece")).enumerate() {
        file.piece(p, piece, &mut out, &mut labels)?;
    }
    let whole = Cursor::decoded(path, &[], None, Place::Whole);
    out.finish(&whole, labels)
}

/// XML without appended data, and that data with its encoding.
type Parts<'a> = (String, Option<(&'a [u8], Encoding)>);

fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<Parts<'a>, MeshError> {
    let text = |bytes: &[u8]| {
        std::str::from_utf8(bytes).map(str::to_owned).map_err(|e| {
            let found = shorten(&bytes[e.valid_up_to()..]);
            let expected = "UTF-8 text before the appended data".into();
            MeshError::content(path, Place::Byte(e.valid_up_to() as u64), Problem::Unexpected { expected, found })
        })
    };
    let Some(tag) = find(bytes, b"<AppendedData") else { return Ok((text(bytes)?, None)) };
    let truncated =
        || MeshError::content(path, Place::Byte(tag as u64), Problem::Truncated { what: "AppendedData".into() });
    let close = tag + find(&bytes[tag..], b">").ok_or_else(truncated)?;
    let start = close + find(&bytes[close..], b"_").ok_or_else(truncated)? + 1;
    let encoding = if find(&bytes[tag..close], b"base64").is_some() { Encoding::Base64 } else { Encoding::Raw };
    let data = match encoding {
        Encoding::Raw => &bytes[start..],
        Encoding::Base64 => {
            let end = find(&bytes[start..], b"<").unwrap_or(bytes.len() - start);
            &bytes[start..start + end]
        }
    };
    Ok((text(&bytes[..tag])? + "</VTKFile>", Some((data, encoding))))
}

impl<'a> File<'a> {
    fn fail(&self, node: Node, problem: Problem) -> MeshError {
        MeshError::content(self.path, line(node), problem)
    }

    fn unexpected(&self, node: Node, expected: &str, found: &str) -> MeshError {
        self.fail(node, Problem::Unexpected { expected: expected.into(), found: shorten(found.as_bytes()) })
    }

    fn piece(&self, p: usize, piece: Node, out: &mut TetBuilder, labels: &mut Vec<i64>) -> Result<(), MeshError> {
        let [points, cells] = [self.count(piece, "NumberOfPoints")?, self.count(piece, "NumberOfCells")?];
        if points == 0 || cells == 0 {
            return Ok(());
        }
        let section = |name: &str| piece.children().find(|n| n.has_tag_name(name));
        let arrays =
            |name| section(name).into_iter().flat_map(|s| s.children()).filter(|n| n.has_tag_name("DataArray"));
        let missing = |what: &str| self.unexpected(piece, &format!("a DataArray {what} in the piece"), "none");

        let base = out.vertices() as i64;
        let node = arrays("Points").next().ok_or_else(|| missing("of Points"))?;
        if node.attribute("NumberOfComponents").is_some_and(|n| n.trim() != "3") {
            return Err(self.unexpected(
                node,
                "3 components per point",
                node.attribute("NumberOfComponents").unwrap_or(""),
            ));
        }
        let coordinates = self.numbers(node)?.reals(points * 3)?;
        let at = self.at(node);
        for (i, xyz) in coordinates.chunks_exact(3).enumerate() {
            out.vertex(&at, base + i as i64, [xyz[0], xyz[1], xyz[2]])?;
        }

        let of_cells = |name: &str| {
            arrays("Cells")
                .find(|a| a.attribute("Name").is_some_and(|n| n.eq_ignore_ascii_case(name)))
                .ok_or_else(|| missing(&format!("'{name}'")))
        };
        let types = self.numbers(of_cells("types")?)?.ints(cells)?;
        let node = of_cells("offsets")?;
        let mut offsets = vec![0];
        offsets.extend(self.numbers(node)?.ints(cells)?);
        let length = *offsets.last().unwrap_or(&0);
        let length = usize::try_from(length).ok().filter(|&n| n <= self.most());
        let length = length.ok_or_else(|| self.unexpected(node, "offsets into the connectivity", "another number"))?;
        let node = of_cells("connectivity")?;
        let connectivity = self.numbers(node)?.ints(length)?;

        let given = arrays("CellData").find(|a| a.attribute("Name").is_some_and(is_label));
        let given = given.filter(|a| a.attribute("NumberOfComponents").is_none_or(|n| n.trim() == "1"));
        let given = given.map(|a| self.numbers(a)?.ints(cells)).transpose()?.unwrap_or_default();
        let at = self.at(node);
        let cells = Cells { offsets, connectivity, types };
        let name = |c| if p == 0 { format!("cell {c}") } else { format!("cell {c} of piece {p}") };
        cells.add(&at, out, [base, points as i64], &given, labels, name)
    }

    /// A cursor that only names the place of `node` in errors.
    fn at(&self, node: Node) -> Cursor<'a> {
        Cursor::decoded(self.path, &[], None, line(node))
    }

    /// More values than the file can hold: zlib packs at most 1032 : 1.
    fn most(&self) -> usize {
        if self.zlib { self.size.saturating_mul(1032) } else { self.size }
    }

    fn count(&self, piece: Node, name: &str) -> Result<usize, MeshError> {
        let text = piece.attribute(name).unwrap_or("none");
        let n: u64 = text.trim().parse().map_err(|_| self.unexpected(piece, name, text))?;
        match usize::try_from(n).ok().filter(|&n| n <= self.most()) {
            Some(n) => Ok(n),
            None => Err(self.fail(piece, Problem::TooMany { count: n, what: name["NumberOf".len()..].to_lowercase() })),
        }
    }

    /// The numbers of an array, wherever they are.
    fn numbers<'n>(&'n self, node: Node<'n, 'n>) -> Result<Numbers<'n>, MeshError> {
        let kind = node.attribute("type").unwrap_or("none");
        let scalar = Scalar::named(kind).ok_or_else(|| self.unexpected(node, "a type like Float64 or Int32", kind))?;
        let what = shorten(node.attribute("Name").unwrap_or("Points").as_bytes());
        let inline = node.text().unwrap_or_default().as_bytes();
        let (source, encoding) = match node.attribute("format").unwrap_or("ascii") {
            "ascii" => return Ok(Numbers::Text { file: self, what, scalar, text: inline, place: line(node) }),
            "binary" => (inline, Encoding::Base64),
            "appended" => {
                let Some((all, encoding)) = self.appended else {
                    return Err(self.unexpected(node, "<AppendedData> with this array", "no such tag"));
                };
                let offset = node.attribute("offset").unwrap_or("none");
                let from = offset.trim().parse().ok().and_then(|o: usize| all.get(o..));
                (from.ok_or_else(|| self.unexpected(node, "an offset into the appended data", offset))?, encoding)
            }
            other => return Err(self.unexpected(node, "the format ascii, binary or appended", other)),
        };
        Ok(Numbers::Binary { file: self, what, scalar, source, encoding, place: line(node) })
    }
}

fn line(node: Node) -> Place {
    Place::Line(u64::from(node.document().text_pos_at(node.range().start).row))
}
