//! Writing 2.2 and 4.1. Nodes and elements are numbered from 1. Each label is one volume entity whose physical group is
//! the label (0: none); the elements keep their order, in one block per run of equal labels.

use super::MshFormat;
use crate::mesh::LabelledTets;
use std::io::{self, Write};

/// Writes one field of an `int`, `size_t` or `double` as text or little-endian bytes.
struct Fields<'a> {
    out: &'a mut dyn Write,
    binary: bool,
}

impl Fields<'_> {
    fn ints(&mut self, values: &[i64]) -> io::Result<()> {
        for &v in values {
            let int = i32::try_from(v)
                .map_err(|_| io::Error::other(format!("a .msh tag has 32 bits, {v} needs more; write .vtu instead")))?;
            if self.binary {
                self.out.write_all(&int.to_le_bytes())?;
            } else {
                write!(self.out, "{int} ")?;
            }
        }
        Ok(())
    }

    fn sizes(&mut self, values: &[usize]) -> io::Result<()> {
        for &v in values {
            if self.binary {
                self.out.write_all(&(v as u64).to_le_bytes())?;
            } else {
                write!(self.out, "{v} ")?;
            }
        }
        Ok(())
    }

    fn reals(&mut self, values: [f64; 3]) -> io::Result<()> {
        for v in values {
            if self.binary {
                self.out.write_all(&v.to_le_bytes())?;
            } else {
                write!(self.out, "{v:?} ")?;
            }
        }
        Ok(())
    }

    /// End of a record: a line end in text.
    fn end(&mut self) -> io::Result<()> {
        if self.binary { Ok(()) } else { writeln!(self.out) }
    }

    fn text(&mut self, line: &str) -> io::Result<()> {
        writeln!(self.out, "{line}")
    }

    /// End of a section. Binary data has no line end of its own.
    fn close(&mut self, name: &str) -> io::Result<()> {
        if self.binary {
            writeln!(self.out)?;
        }
        self.text(name)
    }
}

pub(in crate::mesh) fn write(mesh: &LabelledTets, format: MshFormat, out: &mut dyn Write) -> io::Result<()> {
    let binary = matches!(format, MshFormat::V2Binary | MshFormat::V4Binary);
    let mut f = Fields { out, binary };
    let mut entities = mesh.labels.clone();
    entities.sort_unstable();
    entities.dedup();
    if entities.is_empty() {
        entities.push(0);
    }
    let label = |t: usize| mesh.labels.get(t).copied().unwrap_or(0);
    let entity = |label: i64| entities.partition_point(|&e| e < label) as i64 + 1;

    f.text("$MeshFormat")?;
    let version = if matches!(format, MshFormat::V2Ascii | MshFormat::V2Binary) { "2.2" } else { "4.1" };
    f.text(&format!("{version} {} 8", u8::from(binary)))?;
    if binary {
        f.ints(&[1])?;
    }
    f.close("$EndMeshFormat")?;
    if version == "2.2" {
        return version_2(mesh, &mut f, label, entity);
    }

    f.text("$Entities")?;
    f.sizes(&[0, 0, 0, entities.len()])?;
    f.end()?;
    let (low, high) = mesh.mesh.bounds().unwrap_or_default();
    for &group in &entities {
        f.ints(&[entity(group)])?;
        f.reals(low.to_array())?;
        f.reals(high.to_array())?;
        f.sizes(&[usize::from(group != 0)])?;
        if group != 0 {
            f.ints(&[group])?;
        }
        f.sizes(&[0])?;
        f.end()?;
    }
    f.close("$EndEntities")?;

    let nodes = mesh.mesh.vertices.len();
    f.text("$Nodes")?;
    f.sizes(&[1, nodes, nodes.min(1), nodes])?;
    f.end()?;
    f.ints(&[3, 1, 0])?;
    f.sizes(&[nodes])?;
    f.end()?;
    for i in 1..=nodes {
        f.sizes(&[i])?;
        f.end()?;
    }
    for p in &mesh.mesh.vertices {
        f.reals(p.to_array())?;
        f.end()?;
    }
    f.close("$EndNodes")?;

    let tets = &mesh.mesh.tets;
    let order: Vec<usize> = (0..tets.len()).collect();
    let runs = || order.chunk_by(|&a, &b| label(a) == label(b));
    f.text("$Elements")?;
    f.sizes(&[runs().count(), tets.len(), tets.len().min(1), tets.len()])?;
    f.end()?;
    for run in runs() {
        f.ints(&[3, entity(label(run[0])), 4])?;
        f.sizes(&[run.len()])?;
        f.end()?;
        for &t in run {
            f.sizes(&[t + 1])?;
            f.sizes(&tets[t].map(|v| v as usize + 1))?;
            f.end()?;
        }
    }
    f.close("$EndElements")
}

fn version_2(
    mesh: &LabelledTets,
    f: &mut Fields,
    label: impl Fn(usize) -> i64,
    entity: impl Fn(i64) -> i64,
) -> io::Result<()> {
    f.text("$Nodes")?;
    f.text(&mesh.mesh.vertices.len().to_string())?;
    for (i, p) in mesh.mesh.vertices.iter().enumerate() {
        f.ints(&[i as i64 + 1])?;
        f.reals(p.to_array())?;
        f.end()?;
    }
    f.close("$EndNodes")?;
    f.text("$Elements")?;
    f.text(&mesh.mesh.tets.len().to_string())?;
    if f.binary && !mesh.mesh.tets.is_empty() {
        f.ints(&[4, mesh.mesh.tets.len() as i64, 2])?;
    }
    for (t, tet) in mesh.mesh.tets.iter().enumerate() {
        f.ints(&[t as i64 + 1])?;
        if !f.binary {
            f.ints(&[4, 2])?;
        }
        f.ints(&[label(t), entity(label(t))])?;
        f.ints(&tet.map(|v| i64::from(v) + 1))?;
        f.end()?;
    }
    f.close("$EndElements")
}
