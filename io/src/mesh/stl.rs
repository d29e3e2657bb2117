//! STL, binary and ascii: a soup of triangles. Corners at exactly the same place become one vertex; the stored normals
//! are passed over, the order of the corners tells the outside.

use super::build::{TriBuilder, vertex};
use super::cursor::Cursor;
use super::error::MeshError;
use super::scalar::{Endian, Scalar};
use fissure_meshing::TriMesh;
use glam::DVec3;
use std::collections::HashMap;
use std::io::{self, Write};
use std::path::Path;

const HEADER: usize = 84;
const FACET: usize = 50;

/// Joins equal corners while it takes triangles.
#[derive(Default)]
struct Soup {
    out: TriBuilder,
    seen: HashMap<[u64; 3], i64>,
    facets: u64,
    corner: Vec<i64>,
}

impl Soup {
    fn corner(&mut self, at: &Cursor, p: [f64; 3]) -> Result<(), MeshError> {
        let p = vertex(at, 3 * self.facets as i64 + self.corner.len() as i64, p)? + DVec3::ZERO; // −0 becomes 0
        let next = self.out.mesh.vertices.len() as i64;
        let index = *self.seen.entry(p.to_array().map(f64::to_bits)).or_insert(next);
        if index == next {
            self.out.mesh.vertices.push(p);
        }
        self.corner.push(index);
        Ok(())
    }

    fn facet(&mut self, at: &Cursor) -> Result<(), MeshError> {
        let n = self.facets;
        self.out.polygon(at, &self.corner, 0, || format!("facet {n}"))?;
        self.facets += 1;
        self.corner.clear();
        Ok(())
    }
}

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriMesh, MeshError> {
    let mut at = Cursor::new(path, bytes);
    if is_text(bytes) { ascii(&mut at) } else { binary(&mut at) }
}

/// Many binary files start with "solid" too: if the size fits the count, or zero bytes follow, it is binary.
fn is_text(bytes: &[u8]) -> bool {
    let exact = bytes.get(80..HEADER).is_some_and(|n| {
        let n = Scalar::U32.int(n, Endian::Little) as usize;
        n.checked_mul(FACET).is_some_and(|size| size + HEADER == bytes.len())
    });
    let start = &bytes[..bytes.len().min(512)];
    !exact && start.trim_ascii_start().starts_with(b"solid") && !start.contains(&0)
}

fn binary(at: &mut Cursor) -> Result<TriMesh, MeshError> {
    at.endian = Some(Endian::Little);
    at.take(80, "the header")?;
    let facets = at.counted(Scalar::U32, [FACET, FACET], "facets")?;
    let mut soup = Soup::default();
    for _ in 0..facets {
        at.take(12, "the facets")?;
        for _ in 0..3 {
            let p = [(); 3].map(|()| at.real(Scalar::F32, "the facets"));
            let [x, y, z] = p;
            soup.corner(at, [x?, y?, z?])?;
        }
        soup.facet(at)?;
        at.take(2, "the facets")?;
    }
    soup.out.finish(at)
}

fn ascii(at: &mut Cursor) -> Result<TriMesh, MeshError> {
    let mut soup = Soup::default();
    let mut open = true;
    while let Some(line) = at.full_line() {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        match words.next().unwrap_or_default().to_ascii_lowercase().as_slice() {
            b"vertex" => {
                let mut p = [0.0; 3];
                for c in &mut p {
                    let word = words.next().unwrap_or_default();
                    *c = super::cursor::number(word).ok_or_else(|| at.unexpected("a coordinate", word))?;
                }
                soup.corner(at, p)?;
            }
            b"endfacet" => soup.facet(at)?,
            b"endsolid" => open = false,
            b"solid" => open = true,
            b"facet" | b"outer" if !soup.corner.is_empty() => return Err(at.unexpected("'endfacet'", line)),
            b"facet" | b"outer" | b"endloop" => {}
            _ => return Err(at.unexpected("'facet', 'vertex' or 'endsolid'", line)),
        }
    }
    if open {
        return Err(at.truncated("'solid'"));
    }
    soup.out.finish(at)
}

/// Binary, with coordinates rounded to single precision.
pub(super) fn write(mesh: &TriMesh, out: &mut dyn Write) -> io::Result<()> {
    let mut header = [0; 80];
    header[..12].copy_from_slice(b"fissure mesh");
    out.write_all(&header)?;
    let count = u32::try_from(mesh.triangles.len())
        .map_err(|_| io::Error::other("STL counts facets with 32 bits, write .ply instead"))?;
    out.write_all(&count.to_le_bytes())?;
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        for p in [(b - a).cross(c - a).normalize_or_zero(), a, b, c] {
            for x in p.to_array() {
                out.write_all(&(x as f32).to_le_bytes())?;
            }
        }
        out.write_all(&[0; 2])?;
    }
    Ok(())
}
