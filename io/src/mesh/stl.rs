//! STL, binary and ascii, read and written by `stl_io`: a soup of triangles in single precision. Corners at exactly the
//! same place become one vertex; the stored normals are passed over, the order of the corners tells the outside.
//!
//! Own is what `stl_io` 0.11 does not do. It takes every binary file that starts with "solid" for text ([`is_text`]). It
//! stops at the first `endsolid` of several, and refuses capitals, a `solid` without a name and normals that are no
//! numbers ([`plain`]). It holds −0 and 0 for two places ([`Facets`]) and wraps counts beyond 32 bits.

use super::build::TriBuilder;
use super::cursor::Cursor;
use super::error::MeshError;
use super::scalar::{Endian, Scalar};
use fissure_meshing::TriMesh;
use std::io::{self, ErrorKind, Write};
use std::path::Path;
use stl_io::{Normal, Triangle, TriangleIterator, Vertex};

const HEADER: usize = 84;
const FACET: usize = 50;

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriMesh, MeshError> {
    let mut at = Cursor::new(path, bytes);
    let text = is_text(bytes);
    let file = if text {
        plain(&String::from_utf8_lossy(bytes)).into_bytes()
    } else {
        at.endian = Some(Endian::Little);
        at.take(HEADER - 4, "the header")?;
        at.counted(Scalar::U32, [FACET, FACET], "facets")?;
        // Without its name the header cannot be taken for text.
        [&[0; HEADER - 4], &bytes[HEADER - 4..]].concat()
    };
    // Where facet `f` starts. The lines of `plain` are one more than those of the file.
    let place = |f: usize| match text {
        false => at.marked((HEADER + FACET * f).min(bytes.len())),
        true => {
            let mut lines = file.split_inclusive(|&c| c == b'\n').enumerate();
            let line = lines.by_ref().filter(|(_, l)| l.starts_with(b"facet")).nth(f).map_or(usize::MAX, |(n, _)| n);
            let before = bytes.split_inclusive(|&c| c == b'\n').take(line.saturating_sub(1));
            at.marked(before.map(<[u8]>::len).sum())
        }
    };

    let mut reader = io::Cursor::new(&file);
    let facets = stl_io::create_stl_reader(&mut reader).map_err(|e| failed(&place(0), 0, &e))?;
    let mut facets = Facets { facets, taken: 0 };
    let soup = facets.as_indexed_triangles();
    let soup = soup.map_err(|e| failed(&place(facets.taken - 1), facets.taken - 1, &e))?;

    let mut out = TriBuilder::default();
    for (v, p) in soup.vertices.iter().enumerate() {
        let p = p.0.map(f64::from);
        if out.vertex(&at, v as i64, p).is_err() {
            // A vertex of the file is a corner of a facet.
            let mut corners = soup.faces.iter().flat_map(|f| f.vertices);
            let corner = corners.position(|c| c == v).unwrap_or_default();
            out.vertex(&place(corner / 3), corner as i64, p)?;
        }
    }
    for (f, facet) in soup.faces.iter().enumerate() {
        out.polygon(&at, &facet.vertices.map(|v| v as i64), 0, || format!("facet {f}"))?;
    }
    out.finish(&at)
}

/// What `stl_io` says, in our words.
fn failed(at: &Cursor, facet: usize, error: &io::Error) -> MeshError {
    match error.kind() {
        ErrorKind::UnexpectedEof => at.truncated(&format!("facet {facet}")),
        _ => at.unexpected(
            &format!("facet {facet} as 'facet', 'outer loop', three times 'vertex X Y Z', 'endloop', 'endfacet'"),
            error.to_string().as_bytes(),
        ),
    }
}

/// Counts the facets and makes −0 to 0, so that such corners are joined.
struct Facets<I> {
    facets: I,
    taken: usize,
}

impl<I: Iterator<Item = io::Result<Triangle>>> Iterator for Facets<I> {
    type Item = io::Result<Triangle>;

    fn next(&mut self) -> Option<Self::Item> {
        self.taken += 1;
        let mut facet = self.facets.next()?;
        if let Ok(facet) = &mut facet {
            facet.vertices = facet.vertices.map(|p| Vertex::new(p.0.map(|c| c + 0.0)));
        }
        Some(facet)
    }
}

impl<I: Iterator<Item = io::Result<Triangle>>> TriangleIterator for Facets<I> {}

/// Many binary files start with "solid" too: if the size fits the count, or zero bytes follow, it is binary.
fn is_text(bytes: &[u8]) -> bool {
    let exact = bytes.get(HEADER - 4..HEADER).is_some_and(|n| {
        let n = Scalar::U32.int(n, Endian::Little) as usize;
        n.checked_mul(FACET).is_some_and(|size| size + HEADER == bytes.len())
    });
    let start = &bytes[..bytes.len().min(512)];
    let solid = start.trim_ascii_start().get(..5).is_some_and(|w| w.eq_ignore_ascii_case(b"solid"));
    !exact && solid && !start.contains(&0)
}

/// All solids of a text as one, behind a line of its own; the other lines stay where they are. If the last solid stays
/// open, so does the one.
fn plain(file: &str) -> String {
    let mut text = String::with_capacity(file.len() + 20);
    text.push_str("solid \n");
    let mut open = true;
    for line in file.lines() {
        match line.split_whitespace().next().unwrap_or_default().to_ascii_lowercase().as_str() {
            "solid" => open = true,
            "endsolid" => open = false,
            "facet" => text.push_str("facet normal 0 0 0"),
            _ => text.extend(line.trim().chars().map(|c| c.to_ascii_lowercase())),
        }
        text.push('\n');
    }
    if !open {
        text.push_str("endsolid\n");
    }
    text
}

/// Binary, with coordinates rounded to single precision.
pub(super) fn write(mesh: &TriMesh, mut out: &mut dyn Write) -> io::Result<()> {
    u32::try_from(mesh.triangles.len())
        .map_err(|_| io::Error::other("STL counts facets with 32 bits, write .ply instead"))?;
    let facets = (0..mesh.triangles.len()).map(|t| {
        let [a, b, c] = mesh.corners(t);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        Triangle {
            normal: Normal::new(normal.as_vec3().to_array()),
            vertices: [a, b, c].map(|p| Vertex::new(p.as_vec3().to_array())),
        }
    });
    stl_io::write_stl(&mut out, facets)
}
