//! Wavefront OBJ: `v` and `f` lines, read by `tobj` (which does not write). Normals, texture coordinates, groups,
//! materials and colours are passed over.
//!
//! Own are three small things that `tobj` 4.0 does not do. [`Plain`] leaves it only what makes the mesh: it cuts a mesh
//! apart at `o` and `g`, gives up at continued lines, at comments behind a face, at colours that only some vertices
//! have, and at names that are not UTF-8; with overflow checks it panics on damaged texture numbers. A first face of
//! all vertices keeps them in the order of the file, because it renumbers by first use. And it says that some face
//! leaves the vertices; [`Plain::lost`] says which.

use super::build::TriBuilder;
use super::cursor::{Cursor, number};
use super::error::{MeshError, Problem};
use fissure_meshing::TriMesh;
use std::fmt::Write as _;
use std::io::{self, Read, Write};
use std::path::Path;
use tobj::{LoadError, LoadOptions};

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriMesh, MeshError> {
    let plain = Plain::new(&String::from_utf8_lossy(bytes));
    let at = Cursor::new(path, plain.text.as_bytes());
    if plain.vertices.len() >= u32::MAX as usize {
        return Err(at.fail(Problem::TooLarge));
    }
    let mut all = "f".to_owned();
    (1..=plain.vertices.len()).for_each(|v| _ = write!(all, " {v}"));
    all.push('\n');

    let mut reader = all.as_bytes().chain(plain.text.as_bytes());
    let mesh = match tobj::load_obj_buf(&mut reader, &LoadOptions::default(), |_| Ok(Default::default())) {
        Ok((models, _)) => models.into_iter().next().map(|m| m.mesh).unwrap_or_default(),
        Err(LoadError::FaceVertexOutOfBounds) => return Err(plain.lost(&at)),
        Err(error) => {
            let expected = match error {
                LoadError::PositionParseError => "a vertex with three coordinates",
                _ => "a face of vertex numbers",
            };
            // The line at fault is the last one that tobj has taken.
            let taken = &plain.text[..plain.text.len() - reader.into_inner().1.len()];
            let start = taken.trim_end_matches('\n').rfind('\n').map_or(0, |n| n + 1);
            return Err(at.marked(start).unexpected(expected, taken.as_bytes()[start..].trim_ascii_end()));
        }
    };

    let mut out = TriBuilder::default();
    for (v, (p, &mark)) in mesh.positions.chunks_exact(3).zip(&plain.vertices).enumerate() {
        out.vertex(&at.marked(mark), v as i64 + 1, [p[0], p[1], p[2]])?;
    }
    let mut rest = &mesh.indices[plain.vertices.len()..];
    for (f, &mark) in plain.faces.iter().enumerate() {
        // There are no arities if all faces are triangles, the first one of all vertices too.
        let (face, later) = rest.split_at(mesh.face_arities.get(f + 1).map_or(3, |&n| n as usize));
        rest = later;
        let face: Vec<i64> = face.iter().map(|&v| i64::from(v)).collect();
        out.polygon(&at.marked(mark), &face, 0, || format!("face {}", f + 1))?;
    }
    out.finish(&at)
}

/// The vertices and faces of a file, each on its line, the other lines blank.
#[derive(Default)]
struct Plain {
    text: String,
    /// Where the lines of the vertices start.
    vertices: Vec<usize>,
    /// Where the lines of the faces start.
    faces: Vec<usize>,
}

impl Plain {
    fn new(file: &str) -> Self {
        let mut plain = Plain { text: String::with_capacity(file.len()), ..Plain::default() };
        let mut lines = file.lines();
        while let Some(line) = lines.next() {
            // Of a vertex the coordinates, of a face all.
            let (starts, words) = match line.split_whitespace().next() {
                Some("v") => (&mut plain.vertices, 4),
                Some("f") => (&mut plain.faces, usize::MAX),
                _ => {
                    plain.text.push('\n');
                    continue;
                }
            };
            starts.push(plain.text.len());
            let (mut part, mut taken, mut continued) = (line, 0, 0);
            loop {
                let bare = part.split('#').next().unwrap_or_default().trim_end();
                let open = bare.strip_suffix('\\');
                for word in open.unwrap_or(bare).split_whitespace().take(words - taken) {
                    plain.text.extend([word, " "]);
                    taken += 1;
                }
                match open.and_then(|_| lines.next()) {
                    Some(next) => (part, continued) = (next, continued + 1),
                    None => break,
                }
            }
            plain.text.extend(std::iter::repeat_n('\n', 1 + continued));
        }
        plain
    }

    /// The error for the first face with a vertex that is not there.
    fn lost(&self, at: &Cursor) -> MeshError {
        for (f, &mark) in self.faces.iter().enumerate() {
            let newest = self.vertices.partition_point(|&v| v < mark) as i64;
            for word in self.text[mark..].lines().next().unwrap_or_default().split_whitespace().skip(1) {
                let index = word.split('/').next().unwrap_or_default();
                let Some(vertex) = number::<i64>(index.as_bytes()) else {
                    return at.marked(mark).unexpected("a vertex number", word.as_bytes());
                };
                let corner = if vertex < 0 { vertex.saturating_add(newest + 1) } else { vertex };
                if corner < 1 || corner > self.vertices.len() as i64 {
                    let element = format!("face {}", f + 1);
                    return at.marked(mark).fail(Problem::NoSuchVertex { element, vertex });
                }
            }
        }
        at.unexpected("faces of vertices in the file", b"others")
    }
}

pub(super) fn write(mesh: &TriMesh, out: &mut dyn Write) -> io::Result<()> {
    for p in &mesh.vertices {
        writeln!(out, "v {:?} {:?} {:?}", p.x, p.y, p.z)?;
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(out, "f {} {} {}", u64::from(*a) + 1, u64::from(*b) + 1, u64::from(*c) + 1)?;
    }
    Ok(())
}
