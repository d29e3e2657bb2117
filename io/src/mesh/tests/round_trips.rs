//! What is written comes back, to the bit where the format can hold it, and other libraries read it the same.

use super::*;
use crate::mesh::{read, write, write_msh};

#[test]
fn surfaces_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = octahedron();
    for extension in ["obj", "ply", "stl"] {
        let path = folder.path().join(format!("o.{extension}"));
        write(&path, &Mesh::Surface(mesh.clone())).unwrap();
        let Mesh::Surface(back) = read(&path).unwrap() else { panic!("a solid") };
        if extension == "stl" {
            // Vertices come in the order of their use; the triangles are the same places.
            let corners = |m: &TriMesh| (0..m.triangles.len()).map(|t| m.corners(t)).collect::<Vec<_>>();
            assert_eq!((back.vertices.len(), corners(&back)), (mesh.vertices.len(), corners(&mesh)));
        } else {
            assert_eq!(back, mesh, "{extension}");
        }
    }
}

#[test]
fn solids_come_back_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let unlabelled = LabelledTets { labels: Vec::new(), ..wedge() };
    for mesh in [wedge(), unlabelled] {
        for name in ["t.node", "t.ELE", "t.msh", "t.v22.msh", "t.vtu"] {
            let path = folder.path().join(name);
            write(&path, &Mesh::Solid(mesh.clone())).unwrap();
            assert_eq!(read(&path).unwrap(), Mesh::Solid(mesh.clone()), "{name}");
        }
        for format in [MshFormat::V2Ascii, MshFormat::V2Binary, MshFormat::V4Ascii, MshFormat::V4Binary] {
            let path = folder.path().join("f.msh");
            write_msh(&path, &mesh, format).unwrap();
            assert_eq!(read(&path).unwrap(), Mesh::Solid(mesh.clone()), "{format:?}");
        }
    }
    // Nothing temporary is left: t.node, t.ele, t.NODE, t.ELE, t.msh, t.v22.msh, t.vtu, f.msh.
    let left = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(left, 8);
}

/// The crates see our files as they are, without what our readers do around them.
#[test]
fn other_libraries_read_our_surfaces() {
    let mesh = octahedron();
    let obj = written(|o| obj::write(&mesh, o));
    let options = tobj::LoadOptions::default();
    let (models, _) = tobj::load_obj_buf(&mut &obj[..], &options, |_| unreachable!("no materials")).unwrap();
    let theirs = &models[0].mesh; // renumbered by first use
    let place = |v: u32| DVec3::from_slice(&[0, 1, 2].map(|k| theirs.positions[3 * v as usize + k]));
    let corners: Vec<DVec3> = theirs.indices.iter().map(|&v| place(v)).collect();
    let ours: Vec<DVec3> = (0..8).flat_map(|t| mesh.corners(t)).collect();
    assert_eq!((models.len(), theirs.positions.len(), corners), (1, 18, ours));

    let stl = written(|o| stl::write(&mesh, o));
    let theirs = stl_io::read_stl(&mut std::io::Cursor::new(stl)).unwrap();
    theirs.validate().unwrap(); // closed, and the stored normals agree with the winding
    assert_eq!((theirs.vertices.len(), theirs.faces.len()), (6, 8));

    let ply = written(|o| ply::write(&mesh, o));
    let parser = ply_rs_bw::parser::Parser::<ply_rs_bw::ply::DefaultElement>::new();
    let theirs = parser.read_ply(&mut &ply[..]).unwrap().payload;
    assert_eq!((theirs["vertex"].len(), theirs["face"].len()), (6, 8));
    assert_eq!(theirs["vertex"][5]["z"], ply_rs_bw::ply::Property::Double(-1.25));
    assert_eq!(theirs["face"][7]["vertex_indices"].to_u32_list(), Some(vec![0, 3, 5]));
}
