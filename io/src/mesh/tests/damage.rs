//! Damaged files give an error or a mesh, never a panic, a hang or a flood of memory.

use super::*;

/// Splitmix64: numbers that look random and are the same every time.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}

/// Whatever comes out obeys the promises of the reader.
fn check(extension: &str, bytes: &[u8]) -> bool {
    match parse(extension, bytes) {
        Err(e) => {
            let message = e.to_string();
            assert!(message.starts_with("test.") && message.contains("; ") && !message.contains('\n'), "{message}");
            false
        }
        Ok(Mesh::Surface(m)) => {
            let n = m.vertices.len() as u32;
            assert!(m.triangles.iter().flatten().all(|&v| v < n) && m.vertices.iter().all(|p| p.is_finite()));
            true
        }
        Ok(Mesh::Solid(m)) => {
            assert!((0..m.mesh.tets.len()).all(|t| m.mesh.volume(t) > 0.0));
            assert!(m.labels.is_empty() || m.labels.len() == m.mesh.tets.len());
            true
        }
    }
}

#[test]
fn every_truncation_is_survived() {
    for (extension, bytes) in samples() {
        assert!(check(extension, &bytes), "{extension}");
        let whole = (0..bytes.len()).filter(|&n| check(extension, &bytes[..n])).count();
        // What may be missing unseen: a last line end or digit; OBJ faces, which nobody counts; the closing tags behind
        // raw data; data behind the cells of a legacy VTK file.
        let most = match extension {
            "obj" => 15,
            "vtu" => 28,
            "vtk" => 150,
            _ => 2,
        };
        assert!(whole <= most, "{extension}: {whole} of {}", bytes.len());
    }
}

#[test]
fn thousands_of_flipped_bytes_are_survived() {
    let mut dice = Dice(1);
    for (extension, bytes) in samples() {
        for _ in 0..1000 {
            let mut bytes = bytes.clone();
            for _ in 0..=dice.below(4) {
                let k = dice.below(bytes.len());
                bytes[k] = match dice.below(4) {
                    0 => 0xff,
                    1 => b"0159- \n"[dice.below(7)],
                    2 => bytes[k] ^ (1 << dice.below(8)),
                    _ => dice.below(256) as u8,
                };
            }
            check(extension, &bytes);
        }
    }
}

/// Headers that announce the world, in every format that has counts.
#[test]
fn absurd_counts_are_refused_at_once() {
    let huge = "18446744073709551615";
    let vtu = format!(
        "<VTKFile><UnstructuredGrid><Piece NumberOfPoints=\"{huge}\" NumberOfCells=\"1\"/></UnstructuredGrid></VTKFile>"
    );
    let cases = [
        (
            "ply",
            format!(
                "ply\nformat ascii 1.0\nelement vertex {huge}\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
            ),
        ),
        ("ply", format!("ply\nformat ascii 1.0\nelement nothing {huge}\nend_header\n")),
        (
            "ply",
            "ply\nformat ascii 1.0\nelement face 1\nproperty list uint int vertex_indices\nend_header\n4294967295 1\n"
                .into(),
        ),
        ("node", format!("{huge} 3 0 0\n\0001 4 0\n")),
        ("node", format!("1 3 0 0\n1 0 0 0\n\0{huge} 4 0\n")),
        ("msh", format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{huge}\n")),
        ("msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n9223372036854775807 1 1 1\n".into()),
        ("msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 1 1 1\n3 2000000000 1 9223372036854775807\n".into()),
        ("vtk", format!("# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {huge} double\n")),
        ("vtu", vtu),
    ];
    for (extension, text) in cases {
        assert!(!check(extension, text.as_bytes()), "{text}");
    }
    let mut stl = vec![0; 200];
    stl[80..84].fill(0xff);
    assert!(!check("stl", &stl));
}

/// Lengths of PLY lists that are negative, fractions or larger than the file; a text of one endless continued line.
#[test]
fn absurd_lists_and_lines_are_refused() {
    for length in ["char", "short", "int", "uint", "float", "double"] {
        for item in ["char", "int", "double"] {
            for order in ["binary_little_endian", "binary_big_endian"] {
                let mut file =
                    format!("ply\nformat {order} 1.0\nelement face 2\nproperty list {length} {item} vertex_indices\nend_header\n")
                        .into_bytes();
                file.extend([0xff; 40]);
                assert!(!check("ply", &file), "{length} {item}");
            }
        }
    }
    // Text as `ply-rs-bw` would take it: a row of nothing is a row.
    assert!(!check(
        "ply",
        b"ply\nformat ascii 1.0\nelement face 9\nproperty list int int vertex_indices\nend_header\n-1\n"
    ));
    assert!(!check("obj", &b"f \\\n".repeat(200_000)));
    assert!(!check("obj", &b"f 1 2 -9/-9/-9223372036854775808\nvt 0 0\nvn 0 0 1\n".repeat(2)));
}

/// A zlib stream of a few kilobytes that would unpack to megabytes is not unpacked: its announced size is wrong.
#[test]
fn packed_floods_stay_packed() {
    use base64::Engine;
    use base64::engine::general_purpose::STANDARD;
    use std::io::Write;
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(&vec![0; 10_000_000]).unwrap();
    let packed = encoder.finish().unwrap();
    for announced in [10_000_000, 24, u32::MAX] {
        let head: Vec<u8> = [1, announced, 0, packed.len() as u32].iter().flat_map(|n| n.to_le_bytes()).collect();
        let data = STANDARD.encode(head) + &STANDARD.encode(&packed);
        let file = format!(
            "<VTKFile compressor=\"vtkZLibDataCompressor\"><UnstructuredGrid><Piece NumberOfPoints=\"1\" NumberOfCells=\"1\">\
             <Points><DataArray type=\"Float64\" format=\"binary\">{data}</DataArray></Points></Piece></UnstructuredGrid></VTKFile>"
        );
        let message = parse("vtu", file.as_bytes()).unwrap_err().to_string();
        let found = if announced == 24 { 25 } else { announced };
        assert!(message.contains(&format!("has {found} values where 24")), "{message}");
    }
}

/// XML nested a hundred thousand deep.
#[test]
fn deep_xml_is_survived() {
    assert!(!check("vtu", "<a>".repeat(100_000).as_bytes()));
    let closed = "<VTKFile>".repeat(100_000) + &"</VTKFile>".repeat(100_000);
    assert!(!check("vtu", closed.as_bytes()));
}
