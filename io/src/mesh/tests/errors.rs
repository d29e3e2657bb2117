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
        "test.obj, line 2: expected a vertex with three coordinates, found 'v 1 0 x'; correct it or write the file again"
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

/// What `tobj`, `ply-rs-bw` and `stl_io` say in several lines or without a place.
#[test]
fn errors_of_the_crates_become_one_sentence() {
    const V: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let ply = |rows: &str| {
        let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty double z\n\
                    element face 1\nproperty list uchar int vertex_indices\nend_header\n";
        format!("{head}{rows}")
    };
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let stl = |second: &str| format!("solid a\n{facet}{second}endsolid a\n");
    let cases = [
        ("obj", format!("# é\n{V}g a\nf 1 2 3\ng b\n\nf 1/9/9 2 4\n"), "test.obj, line 9: face 2 uses vertex 4,"),
        ("obj", format!("{V}f 1 2 0\n"), "test.obj, line 4: face 1 uses vertex 0,"),
        ("obj", format!("f 1 2 -1\n{V}"), "test.obj, line 1: face 1 uses vertex -1,"),
        ("obj", format!("{V}f 1 2 -9223372036854775808\n"), "face 1 uses vertex -9223372036854775808,"),
        ("obj", format!("{V}f 1 2 9223372036854775807\n"), "face 1 uses vertex 9223372036854775807,"),
        (
            "obj",
            format!("{V}f 1 2 99999999999999999999\n"),
            "test.obj, line 4: expected a face of vertex numbers, found",
        ),
        ("obj", format!("{V}f 1 2 3/1/1/1\n"), "line 4: expected a face of vertex numbers, found 'f 1 2 3/1/1/1'"),
        ("obj", format!("{V}f 1 2 /3\n"), "line 4: expected a vertex number, found '/3'"),
        ("obj", format!("{V}v 0 nan 0\nf 1 2 3\n"), "test.obj, line 4: vertex 4 has the coordinate NaN,"),
        ("obj", "v 0 0 \\\n0\nv 1 0 0\nv 0 -inf 0\nf 1 2 3".into(), "line 4: vertex 3 has the coordinate -inf,"),
        ("obj", "v 0 0 0\nv 1 0 0\nf 1 2\n".into(), "test.obj, line 3: face 1 has 2 corners;"),
        (
            "ply",
            ply("0 0 0\n1 0 0\n0 1\n3 0 1 2\n"),
            "test.ply, line 12: expected the numbers that the header declares",
        ),
        ("ply", ply("0 0 0\n1 0 0\n0 1 x\n3 0 1 2\n"), "an element 'vertex', found '0 1 x'"),
        ("ply", ply("0 0 0\n1 0 0\n0 1 -inf\n3 0 1 2\n"), "test.ply, line 12: vertex 2 has the coordinate -inf,"),
        ("ply", ply("0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"), "test.ply, line 13: face 0 uses vertex 3,"),
        ("ply", ply("0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"), "face 0 uses vertex -1,"),
        ("ply", ply("0 0 0\n1 0 0\n0 1 0\n2 0 1\n"), "test.ply, line 13: face 0 has 2 corners;"),
        ("ply", ply("0 0 0\n1 0 0\n0 1 0\n"), "the file ends inside the elements 'face';"),
        (
            "ply",
            ply("").replace("int vert", "float vert") + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
            "line 13: expected the numbers",
        ),
        (
            "ply",
            ply("").replace("double z", "double y") + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
            "test.ply: expected a header that names each element",
        ),
        (
            "ply",
            ply("").replace("double z", "quad z"),
            "test.ply, line 6: expected a line of a PLY header, found 'property quad z'",
        ),
        ("ply", ply("").replace("format ascii 1.0\n", ""), "test.ply: expected a line 'format ascii 1.0'"),
        ("ply", ply("").replace("ply\n", "plx\n"), "test.ply, line 1: expected 'ply' as the first line, found 'plx'"),
        ("ply", ply("").replace("double z", "double w"), "expected vertex properties x, y and z"),
        (
            "stl",
            stl("facet normal 0 0 1\nouter loop\nvertex 0 0 x\n"),
            "test.stl, line 9: expected facet 1 as 'facet',",
        ),
        ("stl", stl("\nfacet normal 0 0 1\nouter loop\nvertex 0 nan 0\n"), "test.stl, line 10: expected facet 1 as"),
        ("stl", format!("solid a\n{facet}"), "the file ends inside facet 1;"),
        ("stl", "solid a\nendsolid a\n".into(), "test.stl: there are no triangles in it;"),
    ];
    for (extension, file, expected) in cases {
        let message = message(extension, &file);
        assert!(message.contains(expected) && !message.contains('\n'), "{message}\n{expected}");
    }
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

    // Facet 2 starts at byte 84 + 2 · 50; its second corner is vertex 7.
    let mut file = written(|o| stl::write(&octahedron(), o));
    file[84 + 2 * 50 + 28..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(self::message("stl", &file).contains("test.stl, byte 184: vertex 7 has the coordinate NaN,"));
    // The third of eight triangles of 13 bytes, and the second of six vertices of 24 bytes.
    let file = written(|o| ply::write(&octahedron(), o));
    let (face, vertex) = (file.len() - 6 * 13, file.len() - 8 * 13 - 5 * 24);
    let mut lost = file.clone();
    lost[face + 1] = 77;
    assert!(self::message("ply", &lost).contains(&format!("byte {face}: face 2 uses vertex 77,")));
    let mut nan = file;
    nan[vertex + 8..][..8].fill(0xff);
    assert!(self::message("ply", &nan).contains(&format!("byte {vertex}: vertex 1 has the coordinate NaN,")));
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
