//! Wavefront OBJ: `v` and `f` lines. Normals, texture coordinates, groups and materials are passed over, and so are
//! colours after a vertex.

use super::build::TriBuilder;
use super::cursor::{Cursor, number};
use super::error::{MeshError, Problem};
use fissure_meshing::TriMesh;
use std::io::{self, Write};
use std::path::Path;

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriMesh, MeshError> {
    let mut at = Cursor::new(path, bytes);
    let mut out = TriBuilder::default();
    // Faces may come before the vertices they use, so they wait: their place, and how many corners.
    let (mut faces, mut corners) = (Vec::new(), Vec::new());
    while let Some(mut line) = at.line() {
        let start = at.clone();
        let joined: Vec<u8>;
        if line.ends_with(b"\\") {
            let mut whole = line.to_vec();
            while whole.last() == Some(&b'\\') {
                whole.pop();
                whole.push(b' ');
                whole.extend_from_slice(at.line().unwrap_or_default());
            }
            joined = whole;
            line = &joined;
        }
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        match words.next() {
            Some(b"v") => {
                let mut p = [0.0; 3];
                for c in &mut p {
                    let word = words.next().unwrap_or_default();
                    *c = number(word).ok_or_else(|| start.unexpected("a coordinate", word))?;
                }
                out.vertex(&start, out.mesh.vertices.len() as i64 + 1, p)?;
            }
            Some(b"f") => {
                let before = corners.len();
                for word in words.take_while(|w| w[0] != b'#') {
                    let index = word.split(|&c| c == b'/').next().unwrap_or_default();
                    let given: i64 = number(index).ok_or_else(|| start.unexpected("a vertex number", word))?;
                    // Negative numbers count back from the newest vertex.
                    let newest = out.mesh.vertices.len() as i64;
                    let corner = if given < 0 { given.saturating_add(newest + 1) } else { given };
                    if corner < 1 {
                        let element = format!("face {}", faces.len() + 1);
                        return Err(start.fail(Problem::NoSuchVertex { element, vertex: given }));
                    }
                    corners.push(corner);
                }
                faces.push((start.mark(), corners.len() - before));
            }
            _ => {}
        }
    }
    let mut rest = &corners[..];
    for (f, &(mark, n)) in faces.iter().enumerate() {
        let (face, later) = rest.split_at(n);
        rest = later;
        out.polygon(&at.marked(mark), face, 1, || format!("face {}", f + 1))?;
    }
    out.finish(&at)
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
