//! Writes the corpus that fuzzing starts from: small files of every kind, by our own writers and by hand.

use std::fs;
use std::path::Path;

use fissure_engine::column::Life;
use fissure_io::checkpoint::{About, write};
use fissure_io::frames;
use fissure_io::mesh::{self, LabelledTets, Mesh, MshFormat};
use fissure_io::scene::Scene;
use fissure_io::simulation::Simulation;

const SCENE: &str = r#"
duration = 0.01
[body.a]
shape = { kind = "box", size = [0.1, 0.1, 0.1] }
tets = 40
density = 1000
[body.a.material]
law = "isotropic"
bulk_modulus = 1e6
shear_modulus = 5e5
"#;

const VTK: &str = "# vtk DataFile Version 3.0\ntet\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\n\
                   CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\nCELL_DATA 1\nSCALARS region int 1\nLOOKUP_TABLE default\n7\n";
const OBJ: &str = "# a quad and a triangle\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvt 0 0\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf -1 -2 -3\n";
const PLY: &str = "ply\nformat ascii 1.0\ncomment hand\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
const MSH: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n$Elements\n1\n\
                   1 4 2 7 1 1 2 3 4\n$EndElements\n";
const NODE: &str = "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
const ELE: &str = "1 4 1\n1 1 2 3 4 7\n";

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("seeds");
    let at = |target: &str, name: &str| {
        fs::create_dir_all(root.join(target)).expect("a folder");
        root.join(target).join(name)
    };
    let scene = Scene::parse(SCENE, Path::new("scene.toml"), &[]).expect("a scene");
    let mut simulation = Simulation::build(&scene, &fissure_materials::registry(), &mut |_| ()).expect("a world");
    let about = About { program: "seed".into(), ..About::default() };
    let frozen = write(at("checkpoint", "frozen.fis"), Life::Frozen, 0, &about, &mut simulation).expect("written");
    write(at("checkpoint", "live.fis"), Life::Live, frozen.fingerprint, &about, &mut simulation).expect("written");
    let mut frame = simulation.frame(3);
    fs::write(at("frame", "frame.ply"), frames::to_bytes(&frame).expect("a frame")).expect("written");

    let tets = simulation.meshes[0].mesh.tets().to_vec();
    let vertices =
        std::mem::take(&mut frame.positions).iter().map(|p| glam::Vec3::from(*p).as_dvec3()).collect::<Vec<_>>();
    let surface = fissure_meshing::TriMesh { vertices, triangles: frame.triangles.clone() };
    for (target, name) in [("obj", "ours.obj"), ("ply", "ours.ply"), ("stl", "ours.stl")] {
        mesh::write(at(target, name), &Mesh::Surface(surface.clone())).expect("written");
    }
    let count = simulation.meshes[0].mesh.origin().len() as u32;
    let vertices = (0..count).map(|v| simulation.meshes[0].mesh.rest_position(v)).collect();
    let labels = (0..tets.len() as i64).collect();
    let solid = LabelledTets { mesh: fissure_meshing::TetMesh { vertices, tets }, labels };
    mesh::write(at("vtu", "ours.vtu"), &Mesh::Solid(solid.clone())).expect("written");
    for (name, format) in [("v2.msh", MshFormat::V2Binary), ("v4.msh", MshFormat::V4Binary)] {
        mesh::write_msh(at("gmsh", name), &solid, format).expect("written");
    }
    fs::write(at("tetgen", "hand"), [NODE.as_bytes(), &[0], ELE.as_bytes()].concat()).expect("written");
    for (target, name, text) in [
        ("vtk", "hand.vtk", VTK),
        ("obj", "hand.obj", OBJ),
        ("ply", "hand.ply", PLY),
        ("stl", "hand.stl", STL),
        ("gmsh", "hand.msh", MSH),
        ("scene", "small.toml", SCENE),
        ("scene", "vase.toml", include_str!("../../../scenes/vase.toml")),
        ("scene", "bullet.toml", include_str!("../../../scenes/fig08_jello.toml")),
    ] {
        fs::write(at(target, name), text).expect("written");
    }
    fs::write(at("restore", "some"), [3, 0, 5, 0, 4, 255, 255, 255, 127, 1, 1, 9, 0, 0]).expect("written");
}
