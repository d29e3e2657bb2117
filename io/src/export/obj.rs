//! Wavefront OBJ: a group `pieceN` for each fragment and `colliderN` for each rigid thing, materials `outside`, `inside` and
//! `collider` in `fissure.mtl`.

use std::io::{self, Write};
use std::path::PathBuf;

use super::{About, ExportError, Shot, Stream, colours, inside, name, write};
use crate::frames::Frame;

pub(super) struct Obj {
    pub dir: PathBuf,
    pub about: About,
}

const MATERIALS: [&str; 3] = ["outside", "inside", "collider"];

impl Stream for Obj {
    fn frame(&mut self, shot: &Shot<'_>) -> Result<(), ExportError> {
        let frame = shot.surface;
        write(&self.dir.join(name(frame.number, "obj")), |out| {
            writeln!(out, "# frame {} at {:?} s\nmtllib fissure.mtl", frame.number, frame.time)?;
            group(out, frame, "piece", 0, |t| usize::from(inside(frame, t)))?;
            let before = frame.positions.len() as u32;
            shot.colliders.map_or(Ok(()), |frame| group(out, frame, "collider", before, |_| 2))
        })
    }

    fn index(&mut self) -> Result<(), ExportError> {
        write(&self.dir.join("fissure.mtl"), |out| {
            for (name, [r, g, b]) in MATERIALS.iter().zip(colours(&self.about)) {
                writeln!(out, "newmtl {name}\nKd {r} {g} {b}\nKs 0.1 0.1 0.1\nNs 50\nillum 2\n")?;
            }
            Ok(())
        })
    }
}

/// The vertices of `frame` behind `before` others, and its triangles by piece and material.
fn group(
    out: &mut dyn Write,
    frame: &Frame,
    called: &str,
    before: u32,
    material: impl Fn(&[u32; 3]) -> usize,
) -> io::Result<()> {
    for [x, y, z] in &frame.positions {
        writeln!(out, "v {x:?} {y:?} {z:?}")?;
    }
    for [x, y, z] in &frame.normals {
        writeln!(out, "vn {x:?} {y:?} {z:?}")?;
    }
    let key = |t: &&[u32; 3]| (frame.piece[t[0] as usize], material(t));
    let mut triangles: Vec<&[u32; 3]> = frame.triangles.iter().collect();
    triangles.sort_by_key(key); // stable: within a group in the order of the frame
    let mut last = None;
    for t in triangles {
        let (piece, material) = key(&t);
        if last.is_none_or(|(p, _)| p != piece) {
            writeln!(out, "g {called}{piece}")?;
        }
        if last != Some((piece, material)) {
            writeln!(out, "usemtl {}", MATERIALS[material])?;
        }
        last = Some((piece, material));
        let [a, b, c] = t.map(|v| v + before + 1);
        writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?;
    }
    Ok(())
}
