//! Files as other programs write them: variants built here, and the meshes in FISSURE_MESHES.

use super::*;
use crate::mesh::read;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::{Compression, write::ZlibEncoder};
use std::io::Write;
use std::path::PathBuf;

pub(super) const ASCII_PLY: &str = "ply\r
format ascii 1.0\r
comment a pyramid on a square\r
element vertex 5\r
property uchar red\r
property float32 x\r
property float y\r
property double z\r
property list uint8 float extra\r
element face 5\r
property list uchar int vertex_index\r
property int flags\r
end_header\r
1 0 0 0 0\r
2 1 0 0 1 9\r
3 1 1 0 0\r
4 0 1 0 2 .5 nan\r
5 .5 .5 1 0\r
4 3 2 1 0 1\r
3 0 1 4 1\r
3 1 2 4 1\r
3 2 3 4 1\r
3 3 0 4 1\r
";

pub(super) const ASCII_STL: &str = "solid a corner of a cube
  facet normal 0 0 -1
    outer loop
      vertex 0 0 0
      vertex 0 1 0
      vertex 1 0 -0
    endloop
  endfacet
  FACET NORMAL 0 -1 0
    OUTER LOOP
      VERTEX 0 0 0
      VERTEX 1.0e0 0 0
      VERTEX 0 0 1
    ENDLOOP
  ENDFACET
  facet normal -1 0 0
    outer loop
      vertex 0 0 0
      vertex 0 0 1
      vertex 0 1 0
    endloop
  endfacet
  facet normal .577 .577 .577
    outer loop
      vertex 1 0 0
      vertex 0 1 0
      vertex 0 0 1
    endloop
  endfacet
endsolid
";

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-15
}

#[test]
fn ply_with_polygons_other_properties_and_all_encodings() {
    let ascii = surface("ply", ASCII_PLY);
    assert_eq!((ascii.vertices.len(), ascii.triangles.len()), (5, 6));
    assert!(near(ascii.volume(), 1.0 / 3.0), "{}", ascii.volume());
    // The same mesh, faces first, in both byte orders and with other integer types.
    for big in [false, true] {
        let bytes = |little: &[u8]| {
            let mut bytes = little.to_vec();
            if big {
                bytes.reverse();
            }
            bytes
        };
        let order = if big { "big" } else { "little" };
        let mut file = format!(
            "ply\nformat binary_{order}_endian 1.0\nelement face 6\nproperty list uint ushort vertex_indices\n\
             element vertex 5\nproperty float x\nproperty double y\nproperty short z\nend_header\n"
        )
        .into_bytes();
        for t in &ascii.triangles {
            file.extend(bytes(&3u32.to_le_bytes()));
            t.iter().for_each(|&v| file.extend(bytes(&(v as u16).to_le_bytes())));
        }
        for p in &ascii.vertices {
            file.extend(bytes(&(p.x as f32).to_le_bytes()));
            file.extend(bytes(&p.y.to_le_bytes()));
            file.extend(bytes(&(p.z as i16).to_le_bytes()));
        }
        assert_eq!(surface("ply", file), ascii);
    }
}

#[test]
fn obj_with_quads_relative_numbers_groups_and_continued_lines() {
    let text = "# a pyramid\nmtllib none.mtl\no base\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n\
                g floor\nf 4/1/1 3/1/1 2//1 \\\n 1/1\ns off\ng sides\nusemtl x\nf 1 2 5\nv .5 5e-1 1.0\n\
                f -4 -3 -1 # comment\nf 3 4 5\nf 4 1 5\n";
    let mesh = surface("obj", text);
    assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (5, 6));
    assert!(near(mesh.volume(), 1.0 / 3.0), "{}", mesh.volume());
}

#[test]
fn stl_corners_are_joined_and_solid_headers_do_not_deceive() {
    let mesh = surface("stl", ASCII_STL);
    assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (4, 4));
    assert!(near(mesh.volume(), 1.0 / 6.0), "{}", mesh.volume());
    let mut binary = written(|o| stl::write(&mesh, o));
    binary[..12].copy_from_slice(b"solid liar  ");
    assert_eq!(surface("stl", binary), mesh);
}

/// What the crates would refuse or silently drop, and other programs write.
#[test]
fn what_the_crates_would_refuse_is_read() {
    // Several solids, without names, in capitals, with normals that are no numbers; −0 is 0.
    let facets: Vec<&str> = ASCII_STL.split_inclusive("endfacet\n").collect();
    let first = ASCII_STL.find("  FACET").unwrap();
    let (one, other) = (&ASCII_STL[..first], &ASCII_STL[first..]);
    let several = format!("{one}endsolid a\n\nsolid\n{other}").replace("normal 0 -1 0", "normal nan -nan(ind) 0");
    let mesh = surface("stl", ASCII_STL);
    assert_eq!(facets.len(), 4);
    assert_eq!(surface("stl", &several), mesh);
    assert_eq!(surface("stl", several.to_uppercase().replace('\n', "\r\n")), mesh);

    // Two groups share their vertices; two that only lie at the same place stay two; unused ones keep their number.
    let text = b"v 9 9 9\nv 0 0 0\nv 1 0 0 .5 .5 .5\nv 0 1 0 1 1 1 1\nv 0 0 0\nv 0 0 1\no caf\xe9\nf 2 3 4\ng b\nl 1 2\nf 5 3 6 # \\\nf 4 3 6\n";
    let mesh = surface("obj", text);
    assert_eq!(mesh.triangles, [[1, 2, 3], [4, 2, 5], [3, 2, 5]]);
    assert_eq!((mesh.vertices.len(), mesh.vertices[0]), (6, DVec3::splat(9.0)));

    // Doubles keep their digits in text, also where the crate knows no such spelling; comments may be in any encoding.
    let mut file = b"ply\nformat ascii 1.0\ncomment caf\xe9\n".to_vec();
    file.extend(
        b"element vertex 3\nproperty double x\nproperty double y\nproperty double z\nproperty int n\n\
          element face 1\nproperty list uchar int vertex_index\nend_header\n\n\
          .1234567890123456 -.5 5. 1\n0 1.e-3 +.25 -7\n1 0 0 2147483647\n\n3 0 1 2",
    );
    let mesh = surface("ply", file);
    let expected = [DVec3::new(0.1234567890123456, -0.5, 5.0), DVec3::new(0.0, 1e-3, 0.25), DVec3::X];
    assert_eq!((&mesh.vertices[..], &mesh.triangles[..]), (&expected[..], &[[0, 1, 2]][..]));
}

#[test]
fn tetgen_from_one_with_comments_attributes_markers_and_left_handed_tetrahedra() {
    let t = wedge();
    let mut file = format!("# made by hand\n\n{} 3 2 1\n", t.mesh.vertices.len() + 1);
    for (i, p) in t.mesh.vertices.iter().enumerate() {
        file += &format!("  {}  {:?} {:?} {:?}  0.5 -1 {} # vertex\n", i + 1, p.x, p.y, p.z, i % 2);
    }
    file += "8 9 9 9 0 0 0\n\0# the tetrahedra\n4 4 1\n";
    for (i, ([a, b, c, d], label)) in t.mesh.tets.iter().zip(&t.labels).enumerate() {
        file += &format!("{} {} {} {} {}  {label}.0\n", i + 1, a + 1, b + 1, d + 1, c + 1);
    }
    let read = solid("node", file);
    assert_eq!((&read.labels, &read.mesh.vertices), (&t.labels, &t.mesh.vertices));
    for k in 0..4 {
        assert!(read.mesh.volume(k) > 0.0 && near(read.mesh.volume(k), t.mesh.volume(k)));
    }
}

#[test]
fn gmsh_with_other_elements_quadratic_tetrahedra_sparse_numbers_and_parameters() {
    let text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 42 \"rock\"\n$EndPhysicalNames\n\
                $Entities\n1 0 1 2\n1 0 0 0 1 5\n1 0 0 0 1 1 1 1 77 0\n1 0 0 0 1 1 1 0 2 1 -1\n9 0 0 0 1 1 1 2 42 43 0\n$EndEntities\n\
                $Nodes\n2 5 2 900\n2 1 1 3\n2\n900\n7\n0 0 0 .1 .2\n1 0 0 .1 .2\n0 1 0 .1 .2\n3 1 0 2\n30\n8\n0 0 1\n5 5 5\n$EndNodes\n\
                $Elements\n3 3 1 3\n2 1 2 1\n1 2 900 7\n3 1 4 1\n2 2 7 900 30\n3 9 11 1\n3 2 900 7 30 8 8 8 8 8 8\n$EndElements\n";
    let read = solid("msh", text);
    assert_eq!((read.mesh.vertices.len(), read.mesh.tets.len()), (4, 2));
    assert_eq!(read.labels, [0, 42]);
    assert!(near(read.mesh.volume(0), 1.0 / 6.0) && near(read.mesh.volume(1), 1.0 / 6.0));
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n\
                $Elements\n3\n1 15 2 0 1 1\n2 2 2 0 1 1 2 3\n3 4 3 0 6 1 1 2 3 4\n$EndElements\n";
    let read = solid("msh", text);
    assert_eq!((read.mesh.tets.len(), read.labels.len()), (1, 0));
    // Nodes with the dimension and tag of their entity and its coordinates, as Gmsh saves them on request.
    let parametric = text.replace("Nodes", "ParametricNodes").replace("1 0 0 0\n", "1 0 0 0 0 9\n");
    let parametric = parametric.replace("2 1 0 0\n", "2 1 0 0 1 9 .5\n").replace("3 0 1 0\n", "3 0 1 0 2 9 .5 .5\n");
    assert_eq!(solid("msh", parametric.replace("4 0 0 1\n", "4 0 0 1 3 9\n")), read);
}

#[derive(Clone, Copy, PartialEq)]
enum Packing {
    Ascii,
    Inline,
    AppendedRaw,
    AppendedBase64,
}

/// The mesh as `.vtu` in every encoding, in two pieces, with a triangle among the cells.
pub(super) fn vtu_variants(mesh: &LabelledTets) -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for packing in [Packing::Ascii, Packing::Inline, Packing::AppendedRaw, Packing::AppendedBase64] {
        for zlib in [false, true] {
            for wide in [false, true] {
                for big in [false, true] {
                    if packing != Packing::Ascii || !(zlib || wide || big) {
                        all.push(vtu_file(mesh, packing, zlib, wide, big));
                    }
                }
            }
        }
    }
    all
}

fn vtu_file(mesh: &LabelledTets, packing: Packing, zlib: bool, wide: bool, big: bool) -> Vec<u8> {
    let mut appended: Vec<u8> = Vec::new();
    let length = |n: usize| match (wide, big) {
        (false, false) => (n as u32).to_le_bytes().to_vec(),
        (false, true) => (n as u32).to_be_bytes().to_vec(),
        (true, false) => (n as u64).to_le_bytes().to_vec(),
        (true, true) => (n as u64).to_be_bytes().to_vec(),
    };
    // Integers are 32 bits in the narrow variant, 64 in the wide one.
    let mut array = |name: &str, values: &[f64], float: bool| {
        let kind = format!("{}{}", if float { "Float" } else { "Int" }, if wide || float { 64 } else { 32 });
        let mut bytes = Vec::new();
        for &v in values {
            let mut one = match (float, wide) {
                (true, _) => v.to_le_bytes().to_vec(),
                (false, true) => (v as i64).to_le_bytes().to_vec(),
                (false, false) => (v as i32).to_le_bytes().to_vec(),
            };
            if big {
                one.reverse();
            }
            bytes.extend(one);
        }
        let (head, body) = if zlib {
            let block = 40;
            let packed: Vec<Vec<u8>> = bytes
                .chunks(block)
                .map(|chunk| {
                    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
                    encoder.write_all(chunk).unwrap();
                    encoder.finish().unwrap()
                })
                .collect();
            let mut head = [length(packed.len()), length(block), length(bytes.len() % block)].concat();
            packed.iter().for_each(|p| head.extend(length(p.len())));
            (head, packed.concat())
        } else {
            (length(bytes.len()), bytes)
        };
        let base64 = if zlib {
            STANDARD.encode(&head) + &STANDARD.encode(&body)
        } else {
            STANDARD.encode([head.clone(), body.clone()].concat())
        };
        let open =
            format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{}\"", if float { 3 } else { 1 });
        match packing {
            Packing::Ascii => {
                let text: Vec<String> = values.iter().map(|v| format!("{v:?}").trim_end_matches(".0").into()).collect();
                format!("{open} format=\"ascii\">\n{}\n</DataArray>", text.join(" "))
            }
            Packing::Inline => format!("{open} format=\"binary\">\n  {base64}\n</DataArray>"),
            Packing::AppendedRaw | Packing::AppendedBase64 => {
                let line = format!("{open} format=\"appended\" offset=\"{}\"/>", appended.len());
                if packing == Packing::AppendedRaw {
                    appended.extend([head, body].concat());
                } else {
                    appended.extend(base64.into_bytes());
                }
                line
            }
        }
    };
    let half = mesh.mesh.tets.len() / 2;
    let mut pieces = String::new();
    for range in [0..half, half..mesh.mesh.tets.len()] {
        // A triangle first, so that cells and tetrahedra are numbered differently.
        let (mut connectivity, mut offsets, mut types, mut labels) =
            (vec![0.0, 1.0, 2.0], vec![3.0], vec![5.0], vec![99.0]);
        for t in range {
            connectivity.extend(mesh.mesh.tets[t].map(f64::from));
            offsets.push(connectivity.len() as f64);
            types.push(10.0);
            labels.push(mesh.labels[t] as f64);
        }
        let points: Vec<f64> = mesh.mesh.vertices.iter().flat_map(|p| p.to_array()).collect();
        pieces += &format!("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", points.len() / 3, types.len());
        pieces += &format!("<PointData/><CellData>{}</CellData>\n", array("MaterialIds", &labels, false));
        pieces += &format!("<Points>{}</Points>\n<Cells>", array("Points", &points, true));
        pieces += &array("connectivity", &connectivity, false);
        pieces += &array("offsets", &offsets, false);
        pieces += &array("types", &types, false);
        pieces += "</Cells></Piece>\n";
    }
    let mut file = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{}\"{}{}>\n\
         <UnstructuredGrid>\n{pieces}</UnstructuredGrid>\n",
        if big { "BigEndian" } else { "LittleEndian" },
        if wide { " header_type=\"UInt64\"" } else { "" },
        if zlib { " compressor=\"vtkZLibDataCompressor\"" } else { "" },
    )
    .into_bytes();
    if !appended.is_empty() {
        let encoding = if packing == Packing::AppendedRaw { "raw" } else { "base64" };
        file.extend(format!("<AppendedData encoding=\"{encoding}\">\n _").bytes());
        file.extend(appended);
        file.extend(b"\n</AppendedData>\n");
    }
    file.extend(b"</VTKFile>\n");
    file
}

/// The mesh as legacy VTK: old and new cells, text and binary, with a label where `SCALARS` or `FIELD` put it.
pub(super) fn vtk_variants(mesh: &LabelledTets) -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for new in [false, true] {
        for binary in [false, true] {
            let mut file = format!(
                "# vtk DataFile Version {}\nby hand\n{}\nDATASET UNSTRUCTURED_GRID\n",
                if new { "5.1" } else { "4.2" },
                if binary { "BINARY" } else { "ASCII" }
            )
            .into_bytes();
            let put = |file: &mut Vec<u8>, values: &[f64], kind: &str| {
                for &v in values {
                    match (binary, kind) {
                        (false, _) => file.extend(format!("{v} ").bytes()),
                        (true, "double") => file.extend(v.to_be_bytes()),
                        (true, "vtktypeint64") => file.extend((v as i64).to_be_bytes()),
                        (true, _) => file.extend((v as i32).to_be_bytes()),
                    }
                }
                file.push(b'\n');
            };
            let points: Vec<f64> = mesh.mesh.vertices.iter().flat_map(|p| p.to_array()).collect();
            file.extend(format!("POINTS {} double\n", points.len() / 3).bytes());
            put(&mut file, &points, "double");
            let tets = &mesh.mesh.tets;
            if new {
                file.extend(b"METADATA\nINFORMATION 1\nNAME X LOCATION vtkDataArray\nDATA 2 0 1\n\n");
                file.extend(format!("CELLS {} {}\nOFFSETS vtktypeint64\n", tets.len() + 1, 4 * tets.len()).bytes());
                put(&mut file, &(0..=tets.len()).map(|t| 4.0 * t as f64).collect::<Vec<_>>(), "vtktypeint64");
                file.extend(b"CONNECTIVITY vtktypeint64\n");
                put(&mut file, &tets.iter().flatten().map(|&v| f64::from(v)).collect::<Vec<_>>(), "vtktypeint64");
            } else {
                file.extend(format!("CELLS {} {}\n", tets.len(), 5 * tets.len()).bytes());
                let flat = tets.iter().flat_map(|&[a, b, c, d]| [4, a, b, c, d].map(f64::from));
                put(&mut file, &flat.collect::<Vec<_>>(), "int");
            }
            file.extend(format!("CELL_TYPES {}\n", tets.len()).bytes());
            put(&mut file, &vec![10.0; tets.len()], "int");
            let labels: Vec<f64> = mesh.labels.iter().map(|&l| l as f64).collect();
            if new {
                file.extend(
                    format!("POINT_DATA {0}\nSCALARS w double\nLOOKUP_TABLE default\n", points.len() / 3).bytes(),
                );
                put(&mut file, &points[..points.len() / 3], "double");
                file.extend(format!("CELL_DATA {0}\nFIELD FieldData 2\ncost 2 {0} double\n", tets.len()).bytes());
                put(&mut file, &vec![0.5; 2 * tets.len()], "double");
                file.extend(format!("region 1 {} int\n", tets.len()).bytes());
            } else {
                file.extend(format!("CELL_DATA {}\nSCALARS region int 1\nLOOKUP_TABLE default\n", tets.len()).bytes());
            }
            put(&mut file, &labels, "int");
            all.push(file);
        }
    }
    all
}

#[test]
fn vtu_in_every_encoding_and_in_pieces() {
    let mesh = wedge();
    let variants = vtu_variants(&mesh);
    assert_eq!(variants.len(), 25);
    for file in variants {
        let read = solid("vtu", &file);
        assert_eq!(read.labels, mesh.labels);
        // Each piece brings its points; those it does not use are gone.
        for t in 0..4 {
            assert_eq!(read.mesh.corners(t), mesh.mesh.corners(t), "{}", String::from_utf8_lossy(&file));
        }
    }
}

#[test]
fn legacy_vtk_old_and_new_text_and_binary() {
    let mesh = wedge();
    for file in vtk_variants(&mesh) {
        assert_eq!(solid("vtk", &file), mesh, "{}", String::from_utf8_lossy(&file));
    }
}

/// Files in a folder of FISSURE_MESHES; a line is printed where there is none.
fn files(folder: &str) -> Vec<PathBuf> {
    let Some(root) = std::env::var_os("FISSURE_MESHES") else {
        println!("skipped: FISSURE_MESHES is not set");
        return Vec::new();
    };
    let entries = std::fs::read_dir(Path::new(&root).join(folder)).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    paths.sort();
    assert!(!paths.is_empty());
    paths
}

#[test]
fn shared_surfaces_are_closed() {
    for path in files("surface") {
        let Mesh::Surface(mesh) = read(&path).unwrap() else { panic!("{path:?} is solid") };
        let mut edges: Vec<[u32; 2]> = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        edges.sort_unstable();
        let twins = edges.iter().filter(|[a, b]| edges.binary_search(&[*b, *a]).is_ok()).count();
        assert_eq!(twins, edges.len(), "{path:?}");
        assert!(mesh.volume() > 0.0, "{path:?}");
    }
}

/// One mesh in many formats: the same counts and the same volume.
#[test]
fn shared_solids_agree_between_formats() {
    let mut before: Option<(String, usize, usize, f64)> = None;
    let mut compared = 0;
    let mut worst = 0.0f64;
    for path in files("tet") {
        let Mesh::Solid(LabelledTets { mesh, .. }) = read(&path).unwrap() else { panic!("{path:?} is a surface") };
        let stem = path.file_name().unwrap().to_string_lossy().split('.').next().unwrap().to_owned();
        let volume: f64 = (0..mesh.tets.len()).map(|t| mesh.volume(t)).sum();
        if let Some((other, vertices, tets, reference)) = &before
            && *other == stem
        {
            assert_eq!((mesh.vertices.len(), mesh.tets.len()), (*vertices, *tets), "{path:?}");
            // The text files have 7 digits; the largest difference measured is 8.0e-8.
            assert!((volume / reference - 1.0).abs() < 1e-6, "{path:?}: {volume} {reference}");
            compared += 1;
            worst = worst.max((volume / reference - 1.0).abs());
            continue;
        }
        before = Some((stem, mesh.vertices.len(), mesh.tets.len(), volume));
    }
    println!("{compared} files compared, largest difference of volumes {worst:.1e}");
}
