//! Writing `.vtu`: little endian, appended raw, 64-bit lengths, no compression; what ParaView itself writes fastest.

use crate::mesh::LabelledTets;
use std::io::{self, Write};

pub(in crate::mesh) fn write(mesh: &LabelledTets, out: &mut dyn Write) -> io::Result<()> {
    let [points, cells] = [mesh.mesh.vertices.len(), mesh.mesh.tets.len()];
    let mut offset = 0;
    // One line per array, and its place behind those before it: each has 8 bytes of length first.
    let mut array = |kind: &str, name: &str, rest: &str, bytes: usize| {
        let line =
            format!("<DataArray type=\"{kind}\" Name=\"{name}\"{rest} format=\"appended\" offset=\"{offset}\"/>");
        offset += 8 + bytes;
        line
    };
    writeln!(
        out,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">"
    )?;
    writeln!(out, "<Points>{}</Points>", array("Float64", "Points", " NumberOfComponents=\"3\"", 24 * points))?;
    writeln!(out, "<Cells>\n{}", array("Int64", "connectivity", "", 32 * cells))?;
    writeln!(out, "{}", array("Int64", "offsets", "", 8 * cells))?;
    writeln!(out, "{}\n</Cells>", array("UInt8", "types", "", cells))?;
    if !mesh.labels.is_empty() {
        writeln!(out, "<CellData>{}</CellData>", array("Int64", "label", "", 8 * cells))?;
    }
    write!(out, "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_")?;

    let length = |out: &mut dyn Write, bytes: usize| out.write_all(&(bytes as u64).to_le_bytes());
    length(out, 24 * points)?;
    for x in mesh.mesh.vertices.iter().flat_map(|p| p.to_array()) {
        out.write_all(&x.to_le_bytes())?;
    }
    length(out, 32 * cells)?;
    for &v in mesh.mesh.tets.iter().flatten() {
        out.write_all(&i64::from(v).to_le_bytes())?;
    }
    length(out, 8 * cells)?;
    for c in 1..=cells as i64 {
        out.write_all(&(4 * c).to_le_bytes())?;
    }
    length(out, cells)?;
    for _ in 0..cells {
        out.write_all(&[10])?;
    }
    if !mesh.labels.is_empty() {
        length(out, 8 * cells)?;
        for label in &mesh.labels {
            out.write_all(&label.to_le_bytes())?;
        }
    }
    write!(out, "\n</AppendedData>\n</VTKFile>\n")
}
