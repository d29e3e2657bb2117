//! Tests of all formats together: round trips, other people's files, errors, and damaged files.

mod damage;
mod errors;
mod foreign;
mod round_trips;

use super::{LabelledTets, gmsh, obj, ply, stl, tetgen, vtk, vtu};
use super::{Mesh, MeshError, MshFormat};
use fissure_meshing::{TetMesh, TriMesh};
use glam::DVec3;
use std::path::Path;

/// An octahedron whose coordinates single precision holds exactly.
fn octahedron() -> TriMesh {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    let vertices = vec![x, -x, y, -y, z * 0.5, z * -1.25];
    let triangles = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    TriMesh { vertices, triangles }
}

/// Four tetrahedra around an edge, with coordinates that need all digits, and two regions.
fn wedge() -> LabelledTets {
    let third = 1.0 / 3.0;
    let vertices = vec![
        DVec3::new(0.0, 0.0, -third),
        DVec3::new(0.0, 0.0, 1e-7),
        DVec3::new(1.0, 0.0, 0.1),
        DVec3::new(third, 0.9, -0.2),
        DVec3::new(-0.8, 0.7, 0.0),
        DVec3::new(-0.9, -2.0 * third, 0.0),
        DVec3::new(0.2, -1.0, 0.3),
    ];
    let tets = vec![[0, 1, 2, 3], [0, 1, 3, 4], [0, 1, 4, 5], [0, 1, 5, 6]];
    let mut mesh = TetMesh { vertices, tets };
    for t in 0..mesh.tets.len() {
        if mesh.volume(t) < 0.0 {
            mesh.tets[t].swap(2, 3);
        }
    }
    LabelledTets { mesh, labels: vec![7, 7, 3, 7] }
}

/// Reads `bytes` as a file with this extension; a `.node` file comes with its `.ele` behind a NUL.
fn parse(extension: &str, bytes: &[u8]) -> Result<Mesh, MeshError> {
    let name = format!("test.{extension}");
    let path = Path::new(&name);
    match extension {
        "obj" => obj::read(path, bytes).map(Mesh::Surface),
        "ply" => ply::read(path, bytes).map(Mesh::Surface),
        "stl" => stl::read(path, bytes).map(Mesh::Surface),
        "msh" => gmsh::read(path, bytes).map(Mesh::Solid),
        "vtu" => vtu::read(path, bytes).map(Mesh::Solid),
        "vtk" => vtk::read(path, bytes).map(Mesh::Solid),
        _ => {
            let cut = bytes.iter().position(|&c| c == 0).unwrap_or(bytes.len());
            let ele = bytes.get(cut + 1..).unwrap_or_default();
            tetgen::read((Path::new("test.node"), &bytes[..cut]), (Path::new("test.ele"), ele)).map(Mesh::Solid)
        }
    }
}

fn solid(extension: &str, bytes: impl AsRef<[u8]>) -> LabelledTets {
    match parse(extension, bytes.as_ref()) {
        Ok(Mesh::Solid(m)) => m,
        other => panic!("{other:?}"),
    }
}

fn surface(extension: &str, bytes: impl AsRef<[u8]>) -> TriMesh {
    match parse(extension, bytes.as_ref()) {
        Ok(Mesh::Surface(m)) => m,
        other => panic!("{other:?}"),
    }
}

fn written(write: impl FnOnce(&mut dyn std::io::Write) -> std::io::Result<()>) -> Vec<u8> {
    let mut out = Vec::new();
    write(&mut out).unwrap();
    out
}

/// All files that our writers make of the test meshes, and hand-written variants.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let (s, t) = (octahedron(), wedge());
    let mut all = vec![
        ("obj", written(|o| obj::write(&s, o))),
        ("ply", written(|o| ply::write(&s, o))),
        ("ply", foreign::ASCII_PLY.as_bytes().to_vec()),
        ("stl", written(|o| stl::write(&s, o))),
        ("stl", foreign::ASCII_STL.as_bytes().to_vec()),
        (
            "node",
            written(|o| {
                tetgen::write_node(&t, o)?;
                o.write_all(&[0])?;
                tetgen::write_ele(&t, o)
            }),
        ),
        ("vtu", written(|o| vtu::write(&t, o))),
    ];
    for format in [MshFormat::V2Ascii, MshFormat::V2Binary, MshFormat::V4Ascii, MshFormat::V4Binary] {
        all.push(("msh", written(|o| gmsh::write(&t, format, o))));
    }
    all.extend(foreign::vtu_variants(&t).into_iter().map(|bytes| ("vtu", bytes)));
    all.extend(foreign::vtk_variants(&t).into_iter().map(|bytes| ("vtk", bytes)));
    all
}
