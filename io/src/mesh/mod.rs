//! Meshes in and out: one file per format, chosen by the extension.
//!
//! | extension | holds | read | written |
//! |---|---|---|---|
//! | `.obj` | surface | polygons | triangles |
//! | `.ply` | surface | ascii, both binaries | binary, doubles |
//! | `.stl` | surface | ascii, binary | binary (single precision: the format has no more) |
//! | `.node` + `.ele` | tetrahedra | TetGen | TetGen, numbered from 0 |
//! | `.msh` | tetrahedra | Gmsh 2 and 4.1, ascii and binary | 4.1 binary; `.v22.msh` gives 2.2 binary |
//! | `.vtu` | tetrahedra | ascii, base64, appended; zlib or plain | appended raw |
//! | `.vtk` | tetrahedra | legacy, ascii and binary | no |
//!
//! OBJ is read by `tobj`, PLY and STL are read and written by `ply-rs-bw` and `stl_io`; around them are the errors that
//! name line and element, and what each does not do (see its file). The tetrahedral formats are our own: `mshio` lacks
//! version 2.2, `vtkio` raw-appended data.
//!
//! Quads and larger polygons become fans. Tetrahedra come out with positive volume and without unused vertices.

mod build;
mod cursor;
mod error;
mod gmsh;
mod obj;
mod ply;
mod scalar;
mod stl;
mod tetgen;
mod vtk;
mod vtu;

#[cfg(test)]
mod tests;

pub use error::{MeshError, Place, Problem};
pub use gmsh::MshFormat;

use fissure_meshing::{TetMesh, TriMesh};
use std::io::{self, Write};
use std::path::Path;

use crate::atomic::write_atomically_with;

/// A mesh as files hold it.
#[derive(Clone, Debug, PartialEq)]
pub enum Mesh {
    /// Triangles.
    Surface(TriMesh),
    /// Tetrahedra.
    Solid(LabelledTets),
}

/// Tetrahedra with the region each belongs to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LabelledTets {
    /// The tetrahedra, all of positive volume.
    pub mesh: TetMesh,
    /// One number per tetrahedron (physical group, region attribute, material id), or empty if the file has none.
    pub labels: Vec<i64>,
}

/// Extensions that [`read`] knows.
pub const READABLE: [&str; 8] = ["obj", "ply", "stl", "node", "ele", "msh", "vtu", "vtk"];
/// Extensions that [`write`] knows.
pub const WRITABLE: [&str; 7] = ["obj", "ply", "stl", "node", "ele", "msh", "vtu"];

/// Reads the mesh in `path`; the extension, in any case, tells the format. Of a `.node`/`.ele` pair either is enough.
///
/// # Errors
/// One sentence each: see [`MeshError`] and [`Problem`].
pub fn read(path: impl AsRef<Path>) -> Result<Mesh, MeshError> {
    let path = path.as_ref();
    let extension = known(path, "read", &READABLE)?;
    if matches!(extension, "node" | "ele") {
        let [node, ele] = tetgen::pair(path);
        return tetgen::read((&node, &load(&node)?), (&ele, &load(&ele)?)).map(Mesh::Solid);
    }
    let bytes = load(path)?;
    match extension {
        "obj" => obj::read(path, &bytes).map(Mesh::Surface),
        "ply" => ply::read(path, &bytes).map(Mesh::Surface),
        "stl" => stl::read(path, &bytes).map(Mesh::Surface),
        "msh" => gmsh::read(path, &bytes).map(Mesh::Solid),
        "vtu" => vtu::read(path, &bytes).map(Mesh::Solid),
        _ => vtk::read(path, &bytes).map(Mesh::Solid),
    }
}

/// Writes `mesh` to `path` in the format that the extension tells. The file is complete or not there: it is written
/// beside its place and then renamed (of a `.node`/`.ele` pair, one after the other).
///
/// # Errors
/// An unknown extension, a format for the other kind of mesh, or what the system says.
pub fn write(path: impl AsRef<Path>, mesh: &Mesh) -> Result<(), MeshError> {
    let path = path.as_ref();
    let extension = known(path, "write", &WRITABLE)?;
    match (extension, mesh) {
        ("obj", Mesh::Surface(m)) => store(path, |out| obj::write(m, out)),
        ("ply", Mesh::Surface(m)) => store(path, |out| ply::write(m, out)),
        ("stl", Mesh::Surface(m)) => store(path, |out| stl::write(m, out)),
        ("node" | "ele", Mesh::Solid(m)) => {
            let [node, ele] = tetgen::pair(path);
            store(&node, |out| tetgen::write_node(m, out))?;
            store(&ele, |out| tetgen::write_ele(m, out))
        }
        ("msh", Mesh::Solid(m)) => {
            let old = path.file_stem().is_some_and(|s| s.to_string_lossy().to_lowercase().ends_with(".v22"));
            write_msh(path, m, if old { MshFormat::V2Binary } else { MshFormat::V4Binary })
        }
        ("vtu", Mesh::Solid(m)) => store(path, |out| vtu::write(m, out)),
        (_, Mesh::Surface(_)) => Err(MeshError::WrongKind {
            path: path.to_owned(),
            extension,
            holds: "tetrahedra",
            has: "triangles",
            instead: ".ply, .obj or .stl",
        }),
        (_, Mesh::Solid(_)) => Err(MeshError::WrongKind {
            path: path.to_owned(),
            extension,
            holds: "triangles",
            has: "tetrahedra",
            instead: ".vtu, .msh or .node",
        }),
    }
}

/// Writes tetrahedra to `path` as Gmsh file of the version and encoding asked for, complete or not at all.
///
/// # Errors
/// What the system says.
pub fn write_msh(path: impl AsRef<Path>, mesh: &LabelledTets, format: MshFormat) -> Result<(), MeshError> {
    store(path.as_ref(), |out| gmsh::write(mesh, format, out))
}

/// The extension of `path`, if it is one of `among`.
fn known(path: &Path, verb: &'static str, among: &[&'static str]) -> Result<&'static str, MeshError> {
    let found = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if let Some(known) = among.iter().find(|e| **e == found) {
        return Ok(known);
    }
    let like = |candidate: &str| strsim::jaro_winkler(candidate, &found);
    let nearest = among.iter().copied().filter(|c| like(c) > 0.6).max_by(|a, b| like(a).total_cmp(&like(b)));
    let known = among.iter().map(|e| format!(".{e}")).collect::<Vec<_>>().join(", ");
    Err(MeshError::UnknownExtension { path: path.to_owned(), found, verb, nearest, known })
}

fn load(path: &Path) -> Result<Vec<u8>, MeshError> {
    std::fs::read(path).map_err(|source| MeshError::Read { path: path.to_owned(), source })
}

fn store(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), MeshError> {
    write_atomically_with(path, content).map_err(|source| MeshError::Write { path: path.to_owned(), source })
}
