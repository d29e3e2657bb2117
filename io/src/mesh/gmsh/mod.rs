//! Gmsh `.msh`, versions 2 (2.0 to 2.2) and 4.1, ascii and binary.
//!
//! Both encodings have the same fields, so each section is described once over a [`Cursor`] that reads either. Linear
//! tetrahedra (type 4) and the corners of quadratic ones (type 11) are kept, other elements are stepped over. The label
//! is the physical group if the file has any, else the entity tag if there is more than one entity.

mod v2;
mod v4;
mod write;

pub(super) use write::write;

use super::LabelledTets;
use super::build::TetBuilder;
use super::cursor::Cursor;
use super::error::{MeshError, Problem};
use super::scalar::{Endian, Scalar};
use std::collections::HashMap;
use std::path::Path;

/// Version and encoding of a `.msh` file to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MshFormat {
    /// 2.2, text.
    V2Ascii,
    /// 2.2, binary, little endian.
    V2Binary,
    /// 4.1, text.
    V4Ascii,
    /// 4.1, binary, little endian.
    V4Binary,
}

struct Reader<'a> {
    at: Cursor<'a>,
    /// Byte order of binary sections; `None` if all is text.
    encoding: Option<Endian>,
    out: TetBuilder,
    /// Physical group and entity tag of each tetrahedron; 0 for none.
    tags: Vec<[i64; 2]>,
    /// First physical group of each volume entity (4.1).
    groups: HashMap<i64, i64>,
}

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<LabelledTets, MeshError> {
    let mut at = Cursor::new(path, bytes);
    let (version, encoding) = mesh_format(&mut at)?;
    let mut reader = Reader { at, encoding, out: TetBuilder::default(), tags: Vec::new(), groups: HashMap::default() };
    while !reader.at.left().trim_ascii_start().is_empty() {
        let section = reader.at.word("a section")?;
        match (section, version) {
            (b"$Nodes", Version::Two) => reader.nodes_2(false)?,
            (b"$ParametricNodes", Version::Two) => reader.nodes_2(true)?,
            (b"$Nodes", Version::Four) => reader.nodes_4()?,
            (b"$Elements", _) if reader.out.vertices() == 0 => {
                return Err(reader.at.unexpected("'$Nodes' with nodes before the elements", section));
            }
            (b"$Elements", Version::Two) => reader.elements_2()?,
            (b"$Elements", Version::Four) => reader.elements_4()?,
            (b"$Entities", Version::Four) => reader.entities_4()?,
            ([b'$', name @ ..], _) => {
                if !reader.at.skip_to(&[b"$End", name].concat()) {
                    return Err(reader.at.truncated(&format!("the section {}", super::cursor::shorten(section))));
                }
            }
            _ => return Err(reader.at.unexpected("a section like '$Nodes'", section)),
        }
        reader.at.endian = None;
        let end = reader.at.word("a section")?;
        if end.strip_prefix(b"$End") != Some(&section[1..]) {
            return Err(reader.at.unexpected(&format!("'$End{}'", String::from_utf8_lossy(&section[1..])), end));
        }
    }
    reader.finish()
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    Two,
    Four,
}

/// The section `$MeshFormat`: version, and the byte order if the file is binary.
fn mesh_format(at: &mut Cursor) -> Result<(Version, Option<Endian>), MeshError> {
    let word = at.word("the first line")?;
    let unsupported = |at: &Cursor, version: &[u8]| {
        at.fail(Problem::Unsupported {
            what: format!("the .msh version '{}'", super::cursor::shorten(version)),
            cure: "convert it with 'gmsh IN.msh -save -format msh41 -o OUT.msh'",
        })
    };
    match word {
        b"$MeshFormat" => {}
        b"$NOD" => return Err(unsupported(at, b"1")),
        _ => return Err(at.unexpected("'$MeshFormat' as the first line", word)),
    }
    let number = at.word("the format")?;
    let version = match number {
        b"2" | b"2.0" | b"2.1" | b"2.2" => Version::Two,
        b"4.1" => Version::Four,
        _ => return Err(unsupported(at, number)),
    };
    let binary = match at.word("the format")? {
        b"0" => false,
        b"1" => true,
        other => return Err(at.unexpected("0 for text or 1 for binary", other)),
    };
    match at.word("the format")? {
        b"8" => {}
        other => return Err(at.unexpected("the data size 8", other)),
    }
    let mut encoding = None;
    if binary {
        at.line();
        let one = at.take(4, "the byte order")?;
        encoding = Some(match one {
            [1, 0, 0, 0] => Endian::Little,
            [0, 0, 0, 1] => Endian::Big,
            _ => return Err(at.unexpected("the number 1 in four bytes", format!("{one:?}").as_bytes())),
        });
    }
    // Text in the middle, such as comments, is allowed here by some writers.
    if !at.skip_to(b"$EndMeshFormat") {
        return Err(at.truncated("the section $MeshFormat"));
    }
    at.word("the section $MeshFormat")?;
    Ok((version, encoding))
}

/// Number of nodes of an element type, from Gmsh's manual ("MSH file format").
fn nodes_of(kind: i64) -> Option<usize> {
    const NODES: [usize; 31] =
        [2, 3, 4, 4, 8, 6, 5, 3, 6, 9, 10, 27, 18, 14, 1, 8, 20, 15, 13, 9, 10, 12, 15, 15, 21, 4, 5, 6, 20, 35, 56];
    match kind {
        1..=31 => Some(NODES[kind as usize - 1]),
        92 => Some(64),
        93 => Some(125),
        _ => None,
    }
}

impl Reader<'_> {
    fn nodes_of(&self, kind: i64) -> Result<usize, MeshError> {
        nodes_of(kind).ok_or_else(|| {
            self.at.fail(Problem::Unsupported {
                what: format!("the element type {kind}"),
                cure: "save the mesh with linear tetrahedra only",
            })
        })
    }

    fn int(&mut self, what: &str) -> Result<i64, MeshError> {
        self.at.int(Scalar::I32, what)
    }

    /// Reads the `nodes` node numbers of element `number`, and keeps them if they make a tetrahedron.
    fn element(
        &mut self,
        kind: i64,
        nodes: usize,
        number: i64,
        scalar: Scalar,
        tags: [i64; 2],
    ) -> Result<(), MeshError> {
        let mut corners = [0; 4];
        for k in 0..nodes {
            let node = self.at.int(scalar, "the elements")?;
            if k < 4 {
                corners[k] = node;
            }
        }
        if matches!(kind, 4 | 11) {
            self.out.tet(&self.at, corners, || format!("tetrahedron {number}"))?;
            self.tags.push(tags);
        }
        Ok(())
    }

    fn finish(self) -> Result<LabelledTets, MeshError> {
        let physical = self.tags.iter().any(|t| t[0] != 0);
        let entities = self.tags.iter().any(|t| t[1] != self.tags[0][1]);
        let labels = match (physical, entities) {
            (true, _) => self.tags.iter().map(|t| t[0]).collect(),
            (false, true) => self.tags.iter().map(|t| t[1]).collect(),
            (false, false) => Vec::new(),
        };
        self.out.finish(&self.at, labels)
    }
}
