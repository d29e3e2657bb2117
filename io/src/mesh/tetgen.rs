//! TetGen's pair of text files: `.node` has the vertices, `.ele` the tetrahedra.
//!
//! Numbers start at 0 or 1 (or anywhere: they are looked up), `#` starts a comment, attributes and boundary markers of
//! vertices are passed over. The first attribute of the tetrahedra is their label, if it is a whole number for all of
//! them. Of 10-node tetrahedra the corners are read.

use super::LabelledTets;
use super::build::TetBuilder;
use super::cursor::{Cursor, number};
use super::error::{MeshError, Problem};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The `.node` and the `.ele` file, given either.
pub(super) fn pair(path: &Path) -> [PathBuf; 2] {
    let upper = path.extension().is_some_and(|e| e.to_string_lossy().chars().all(char::is_uppercase));
    let other = |extension: &str| {
        let same = path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension));
        match (same, upper) {
            (true, _) => path.to_owned(),
            (_, true) => path.with_extension(extension.to_uppercase()),
            _ => path.with_extension(extension),
        }
    };
    [other("node"), other("ele")]
}

/// The words of the next line that has any, comments left out.
fn record<'a>(at: &mut Cursor<'a>, what: &str) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, MeshError> {
    loop {
        let Some(line) = at.line() else { return Err(at.truncated(what)) };
        let line = line.split(|&c| c == b'#').next().unwrap_or_default();
        let mut words = line.split(|c: &u8| c.is_ascii_whitespace() || *c == b',').filter(|w| !w.is_empty()).peekable();
        if words.peek().is_some() {
            return Ok(words);
        }
    }
}

fn field<'a, T: std::str::FromStr>(
    at: &Cursor,
    words: &mut impl Iterator<Item = &'a [u8]>,
    what: &str,
) -> Result<T, MeshError> {
    let word = words.next().unwrap_or(b"the end of the line");
    number(word).ok_or_else(|| at.unexpected(what, word))
}

/// Reads the two contents, each with the path that errors name.
pub(super) fn read(node: (&Path, &[u8]), ele: (&Path, &[u8])) -> Result<LabelledTets, MeshError> {
    let mut out = TetBuilder::default();
    let mut at = Cursor::new(node.0, node.1);
    let mut words = record(&mut at, "the first line of a .node file")?;
    let count: u64 = field(&at, &mut words, "the number of vertices")?;
    let dimension: u32 = field(&at, &mut words, "the dimension")?;
    if dimension != 3 {
        return Err(at.unexpected("the dimension 3", dimension.to_string().as_bytes()));
    }
    for _ in 0..at.count(count, 8, "vertices")? {
        let mut words = record(&mut at, "the vertices")?;
        let number = field(&at, &mut words, "a vertex number")?;
        let [x, y, z] = [(); 3].map(|()| field(&at, &mut words, "a coordinate"));
        out.vertex(&at, number, [x?, y?, z?])?;
    }

    let mut at = Cursor::new(ele.0, ele.1);
    let mut words = record(&mut at, "the first line of an .ele file")?;
    let count: u64 = field(&at, &mut words, "the number of tetrahedra")?;
    let corners: u32 = field(&at, &mut words, "the number of nodes of a tetrahedron")?;
    if !matches!(corners, 4 | 10) {
        return Err(at.unexpected("4 or 10 nodes per tetrahedron", corners.to_string().as_bytes()));
    }
    let attributes: u32 = words.next().and_then(number).unwrap_or(0);
    let mut labels = Vec::new();
    let mut whole = attributes > 0;
    for _ in 0..at.count(count, 10, "tetrahedra")? {
        let mut words = record(&mut at, "the tetrahedra")?;
        let number: i64 = field(&at, &mut words, "the number of a tetrahedron")?;
        let mut tet = [0; 4];
        for corner in &mut tet {
            *corner = field(&at, &mut words, "a vertex number")?;
        }
        for _ in 4..corners {
            field::<i64>(&at, &mut words, "a vertex number")?;
        }
        out.tet(&at, tet, || format!("tetrahedron {number}"))?;
        if whole {
            let label: f64 = field(&at, &mut words, "an attribute")?;
            whole = label == label.trunc() && label.abs() < 9e15;
            labels.push(label as i64);
        }
    }
    if !whole {
        labels.clear();
    }
    if out.vertices() == 0 {
        return Err(at.fail(Problem::Empty { what: "vertices" }));
    }
    out.finish(&at, labels)
}

pub(super) fn write_node(mesh: &LabelledTets, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{} 3 0 0", mesh.mesh.vertices.len())?;
    for (i, p) in mesh.mesh.vertices.iter().enumerate() {
        writeln!(out, "{i} {:?} {:?} {:?}", p.x, p.y, p.z)?;
    }
    Ok(())
}

pub(super) fn write_ele(mesh: &LabelledTets, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{} 4 {}", mesh.mesh.tets.len(), u8::from(!mesh.labels.is_empty()))?;
    for (i, [a, b, c, d]) in mesh.mesh.tets.iter().enumerate() {
        write!(out, "{i} {a} {b} {c} {d}")?;
        match mesh.labels.get(i) {
            Some(label) => writeln!(out, " {label}")?,
            None => writeln!(out)?,
        }
    }
    Ok(())
}
