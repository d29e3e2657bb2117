//! One sentence with the file, the place and the cure.

use super::*;
use crate::mesh::{read, write};

fn message(extension: &str, bytes: impl AsRef<[u8]>) -> String {
    parse(extension, bytes.as_ref()).expect_err("an error").to_string()
}

const NODES: &str = "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";

#[test]
fn each_error_names_file_place_element_and_cure() {
    let ele = |tets: &str| format!("{NODES}\0{tets}");
    let node = |nodes: &str| format!("{nodes}\0001 4 0\n1 1 2 3 4\n");
    assert_eq!(
        message("node", ele("2 4 0\n1 1 2 3 4\n8 1 2 3 9\n")),
        "test.ele, line 3: tetrahedron 8 uses vertex 9, which the file does not have; correct the number or add the vertex"
    );
    assert_eq!(
        message("node", ele("1 4 0\n5 1 2 3 3\n")),
        "test.ele, line 2: tetrahedron 5 has no volume: its corners lie in one plane; remove it or mesh again"
    );
    assert_eq!(
        message("node", node(&NODES.replace("2 1 0 0", "2 1 nan 0"))),
        "test.node, line 3: vertex 2 has the coordinate NaN, which is no place in space; correct the vertex or mesh again"
    );
    assert_eq!(
        message("node", node(&NODES.replace("2 1 0 0", "2 1 0 1e200"))),
        "test.node, line 3: vertex 2 has the coordinate 1e200, which is no place in space; correct the vertex or mesh again"
    );
    assert_eq!(
        message("node", node(&NODES.replace("3 0 1 0", "2 0 1 0"))),
        "test.node, line 4: the vertex number 2 is given twice; number each vertex once"
    );
    assert_eq!(
        message("node", ele("900000 4 0\n1 1 2 3 4\n")),
        "test.ele, line 1: 900000 tetrahedra are announced, more than the rest of the file holds; copy it again or \
         correct the count"
    );
    assert_eq!(
        message("node", ele("2 4 0\n1 1 2 3 4\n")),
        "test.ele, line 2: the file ends inside the tetrahedra; copy it again or have its program write it again"
    );
    assert_eq!(
        message("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2\n"),
        "test.obj, line 5: face 2 has 2 corners; a face needs at least 3, remove it or correct it"
    );
    assert_eq!(
        message("obj", "v 0 0 0\nv 1 0 x\n"),
        "test.obj, line 2: expected a coordinate, found 'x'; correct it or write the file again"
    );
    assert_eq!(
        message("obj", "v 0 0 0\nv 1 0 0\nf -1 -2 -3\n"),
        "test.obj, line 3: face 1 uses vertex -3, which the file does not have; correct the number or add the vertex"
    );
    assert_eq!(message("obj", ""), "test.obj: there are no triangles in it; export the mesh with them");
    assert_eq!(
        message("msh", "$MeshFormat\n4 0 8\n$EndMeshFormat\n"),
        "test.msh, line 2: the .msh version '4' cannot be read; convert it with 'gmsh IN.msh -save -format msh41 -o OUT.msh'"
    );
    let lz4 = "<VTKFile compressor=\"vtkLZ4DataCompressor\"><UnstructuredGrid/></VTKFile>";
    assert_eq!(
        message("vtu", lz4),
        "test.vtu: data compressed by 'vtkLZ4DataCompressor' cannot be read; save it with ZLib or without compression"
    );
}

#[test]
fn in_binary_files_the_byte_is_named() {
    let mut mesh = wedge();
    mesh.mesh.tets[2][1] = 1000;
    let file = written(|o| gmsh::write(&mesh, MshFormat::V4Binary, o));
    let message = message("msh", &file);
    let byte: usize = message.split("byte ").nth(1).unwrap().split(':').next().unwrap().parse().unwrap();
    assert!(message.contains("tetrahedron 3 uses vertex 1001"), "{message}");
    // It is the last number of the element.
    assert!(byte < file.len() && byte > file.len() - 150, "{message}");
}

#[test]
fn unknown_extensions_are_answered_with_the_nearest() {
    let message = read("mesh.objj").unwrap_err().to_string();
    assert!(message.contains("'objj'") && message.contains("did you mean 'obj'"), "{message}");
    assert!(message.contains(".node, .ele, .msh, .vtu, .vtk"), "{message}");
    let message = read("folder.x/mesh").unwrap_err().to_string();
    assert!(
        message.starts_with("folder.x/mesh: the name has no extension to tell the mesh format; known"),
        "{message}"
    );
    let message = write("mesh.vtk", &Mesh::Solid(wedge())).unwrap_err().to_string();
    assert!(message.contains("did you mean 'vtu'"), "{message}");
    let message = write("mesh.ply", &Mesh::Solid(wedge())).unwrap_err().to_string();
    assert_eq!(
        message,
        "mesh.ply: .ply files hold triangles, but the mesh has tetrahedra; write it as .vtu, .msh or .node"
    );
}

#[test]
fn nothing_half_written_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let message = write(folder.path().join("none/a.vtu"), &Mesh::Solid(wedge())).unwrap_err().to_string();
    assert!(message.contains("cannot be written"), "{message}");
    // A label that .msh cannot hold fails in the middle of writing; the old file stays.
    let path = folder.path().join("a.msh");
    write(&path, &Mesh::Solid(wedge())).unwrap();
    let before = std::fs::read(&path).unwrap();
    let wide = LabelledTets { labels: vec![1, 1 << 40, 1, 1], ..wedge() };
    let message = write(&path, &Mesh::Solid(wide)).unwrap_err().to_string();
    assert!(message.contains("32 bits"), "{message}");
    assert_eq!(std::fs::read(&path).unwrap(), before);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    let message = read(folder.path().join("b.ply")).unwrap_err().to_string();
    assert!(message.contains("b.ply: cannot be read"), "{message}");
}
