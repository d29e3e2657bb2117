//! Each format is read back, by our own readers where there is one.

use serde_json::Value;

use super::*;
use crate::mesh::{Mesh, read};

/// A tetrahedron that breaks in two and turns: outside faces, and one inside on each half from frame 1 on.
fn surface(number: u32) -> Frame {
    let time = f64::from(number) * 0.01;
    let mut frame = Frame { number, time, ..Frame::default() };
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let pieces = if number == 0 { 1 } else { 2 };
    for piece in 0..pieces {
        let first = frame.positions.len() as u32;
        for (k, t) in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].iter().enumerate() {
            let inside = u8::from(pieces == 2 && k == 3);
            for &corner in t {
                let [x, y, z]: [f32; 3] = corners[corner as usize];
                frame.positions.push([x + 2.0 * piece as f32 + time as f32, y, z]);
                frame.normals.push([0.0, 1.0, 0.0]);
                frame.velocity.push([1.0, 0.5, -1e-9]);
                frame.damage.push(0.25);
                frame.stretch.push(0.5);
                frame.id.push(corner);
                frame.inside.push(inside);
                frame.piece.push(piece);
            }
            let v = first + 3 * k as u32;
            frame.triangles.push([v, v + 1, v + 2]);
        }
    }
    frame
}

/// Eight particles a half, which turn about y by 0.1 rad a frame and fly along x.
fn particles(number: u32) -> ParticleFrame {
    let time = f64::from(number) * 0.01;
    let mut frame = ParticleFrame { number, time, ..ParticleFrame::default() };
    let (s, c) = (0.1 * number as f32).sin_cos();
    for k in 0..16_u32 {
        let at = |bit: u32| (k >> bit & 1) as f32 * 0.1 * (1.0 + bit as f32);
        let half = k / 8;
        let [x, y, z] = [at(0), at(1), at(2)];
        frame.positions.push([c * x + s * z + half as f32 * 2.0 + number as f32 * 0.5, y, c * z - s * x]);
        frame.velocity.push([50.0, 0.0, 0.0]);
        frame.damage.push(0.5);
        frame.id.push(k);
        frame.piece.push(if number == 0 { 0 } else { half });
        frame.body.push(0);
        frame.mass.push(0.5);
        frame.volume.push(1e-3);
    }
    frame
}

fn tets(number: u32) -> TetFrame {
    TetFrame {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]],
        velocity: vec![[1.0, 2.0, 3.0]; 5],
        tets: vec![[0, 1, 2, 3], [1, 4, 2, 3]],
        damage: vec![0.0, 1.0],
        id: vec![1, 0],
        piece: vec![0, 1],
        body: vec![0, 0],
        time: f64::from(number) * 0.01,
        number,
    }
}

fn about() -> About {
    About { title: "two \"halves\"".into(), interval: 0.01, bodies: vec!["half".into()], ..About::default() }
}

/// Feeds `numbers` into a stream that begins at the first of them.
fn feed(format: Format, dir: &Path, numbers: std::ops::Range<u32>) {
    let mut stream = open(format, dir, &about(), numbers.start).unwrap().unwrap();
    for number in numbers {
        let (surface, particles, tets) = (surface(number), particles(number), tets(number));
        let shot =
            Shot { surface: &surface, colliders: Some(&surface), particles: Some(&particles), tets: Some(&tets) };
        stream.frame(&shot).unwrap();
        stream.index().unwrap();
    }
}

/// All files below `dir` with their bytes.
fn files(dir: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(files(&path).into_iter().map(|(p, b)| (Path::new(path.file_name().unwrap()).join(p), b)));
        } else {
            all.push((path.file_name().unwrap().into(), fs::read(&path).unwrap()));
        }
    }
    all.sort();
    all
}

fn text(path: PathBuf) -> String {
    fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A run that reached frame 4, was killed, and went on from a checkpoint after frame 1.
#[test]
fn a_resumed_stream_leaves_the_files_of_one_that_never_stopped() {
    for (format, name) in Format::ALL.iter().filter(|(format, _)| *format != Format::Glb) {
        let (whole, resumed) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        feed(*format, whole.path(), 0..6);
        feed(*format, resumed.path(), 0..5);
        feed(*format, resumed.path(), 2..6);
        assert!(files(whole.path()) == files(resumed.path()), "{name} differs");
        // what is later than the checkpoint is forgotten, though its files are there still
        feed(*format, resumed.path(), 2..3);
        match format {
            Format::Usd => {
                let stage = text(resumed.path().join("stage.usda"));
                assert!(stage.contains("frame_0002") && !stage.contains("frame_0003"), "{stage}");
                assert!(stage.contains("endTimeCode = 2\n"));
            }
            Format::Vtu => {
                let pvd = text(resumed.path().join("tets.pvd"));
                assert_eq!(pvd.matches("<DataSet").count(), 3, "{pvd}");
                assert!(pvd.contains("timestep=\"0.01\" part=\"0\" file=\"tets/frame_0001.vtu\""));
            }
            _ => {}
        }
    }
}

/// The numbers of a list in brackets that begins behind `name` samples.
fn samples(clip: &str, name: &str) -> Vec<f64> {
    let start = clip.find(&format!("{name}.timeSamples")).unwrap_or_else(|| panic!("no {name}"));
    let list = clip[start..].split_once('[').unwrap().1.split_once(']').unwrap().0;
    let numbers = list.split([',', '(', ')', ' ']).filter(|s| !s.is_empty());
    numbers.map(|n| n.parse().unwrap()).collect()
}

#[test]
fn clips_name_vertices_that_exist_and_the_stage_declares_what_they_hold() {
    let dir = tempfile::tempdir().unwrap();
    feed(Format::Usd, dir.path(), 0..3);
    let stage = text(dir.path().join("stage.usda"));
    for part in ["defaultPrim = \"run\"", "metersPerUnit = 1\n", "upAxis = \"Y\"", "timeCodesPerSecond = 100\n"] {
        assert!(stage.contains(part), "no {part}");
    }
    assert!(stage.contains("active = [(0, 0), (1, 1), (2, 2)]") && stage.contains("times = [(0, 0), (1, 1), (2, 2)]"));
    assert!(!stage.contains("timeSamples") && !stage.contains("two \"halves\""));
    let manifest = text(dir.path().join("manifest.usda"));
    let clip = text(dir.path().join("clips/frame_0002.usda"));
    for line in clip.lines().filter(|l| l.contains(".timeSamples")) {
        let declared = line.split(".timeSamples").next().unwrap();
        let attribute = declared.trim();
        assert!(stage.contains(attribute) && manifest.contains(attribute), "{attribute} is not declared");
        assert!(line.contains(".timeSamples = { 2: ["), "{line}");
    }
    // each side has its own vertices, in the order of the triangles
    let want = surface(2);
    for (name, sides, next) in [("outside", 6, "inside"), ("inside", 2, "colliders")] {
        let at = |name: &str| clip.find(&format!("over \"{name}\"")).unwrap();
        let mesh = &clip[at(name)..at(next)];
        let (points, indices) = (samples(mesh, " points"), samples(mesh, "faceVertexIndices"));
        assert_eq!(samples(mesh, "faceVertexCounts"), vec![3.0; sides], "{name}");
        assert_eq!(indices, (0..3 * sides).map(|k| k as f64).collect::<Vec<_>>());
        let own = (0..24).filter(|&v| (want.inside[v] == 1) == (name == "inside"));
        let places: Vec<f64> = own.flat_map(|v| want.positions[v]).map(f64::from).collect();
        assert!(points.iter().zip(&places).all(|(a, b)| *a as f32 == *b as f32) && points.len() == places.len());
        for name in ["normals", "velocities"] {
            assert_eq!(samples(mesh, name).len(), points.len(), "{name}");
        }
        assert_eq!(samples(mesh, "velocities")[2] as f32, -1e-9);
        for name in ["primvars:damage", "primvars:id", "primvars:piece", "primvars:inside"] {
            assert_eq!(samples(mesh, name).len(), 3 * sides, "{name}");
        }
        assert_eq!(samples(mesh, "primvars:inside")[0], f64::from(u8::from(name == "inside")));
    }
    let whole = text(dir.path().join("clips/frame_0000.usda"));
    let cracks = &whole[whole.find("over \"inside\"").unwrap()..whole.find("over \"colliders\"").unwrap()];
    assert_eq!((samples(cracks, " points").len(), samples(cracks, "faceVertexIndices").len()), (3, 0));
    let dots = &clip[clip.find("over \"particles\"").unwrap()..];
    assert_eq!(samples(dots, "ids").len(), 16);
    assert!((samples(dots, "widths")[0] - 0.1).abs() < 1e-7);
    let extent = samples(dots, "extent");
    let places = samples(dots, " points");
    assert!((0..16).all(|k| (0..3).all(|a| extent[a] < places[3 * k + a] && places[3 * k + a] < extent[3 + a])));
}

/// The numbers of an array of a `.vtu`, as bytes.
fn array(vtu: &[u8], name: &str) -> (String, Vec<u8>) {
    let start = vtu.windows(17).position(|w| w == b"encoding=\"raw\">\n_").unwrap() + 17;
    let xml = String::from_utf8_lossy(&vtu[..start]).into_owned();
    let line = xml.lines().find(|l| l.contains(&format!("Name=\"{name}\""))).unwrap_or_else(|| panic!("no {name}"));
    let get = |key: &str| line.split_once(&format!("{key}=\"")).unwrap().1.split_once('"').unwrap().0.to_owned();
    let mut at = start + get("offset").parse::<usize>().unwrap();
    let mut word = || {
        at += 8;
        u64::from_le_bytes(vtu[at - 8..at].try_into().unwrap()) as usize
    };
    let (blocks, _, _) = (word(), word(), word());
    let lengths: Vec<usize> = (0..blocks).map(|_| word()).collect();
    let mut bytes = Vec::new();
    for length in lengths {
        let mut decoder = flate2::read::ZlibDecoder::new(&vtu[at..at + length]);
        io::Read::read_to_end(&mut decoder, &mut bytes).unwrap();
        at += length;
    }
    (get("type"), bytes)
}

#[test]
fn grids_have_the_columns_of_frames() {
    let dir = tempfile::tempdir().unwrap();
    feed(Format::Vtu, dir.path(), 0..2);
    let Mesh::Solid(solid) = read(dir.path().join("tets/frame_0001.vtu")).unwrap() else { panic!("no tetrahedra") };
    assert_eq!(solid.mesh.tets, [[0, 1, 2, 3], [1, 4, 2, 3]]);
    assert_eq!(solid.mesh.vertices[4], glam::DVec3::ONE);
    let want = surface(1);
    let vtu = fs::read(dir.path().join("surface/frame_0001.vtu")).unwrap();
    assert_eq!(array(&vtu, "velocity"), ("Float32".into(), bytemuck::cast_slice(&want.velocity).to_vec()));
    assert_eq!(array(&vtu, "inside"), ("UInt8".into(), want.inside.clone()));
    assert_eq!(array(&vtu, "Points").1, bytemuck::cast_slice::<_, u8>(&want.positions));
    assert_eq!(array(&vtu, "types").1, vec![5; want.triangles.len()]);
    let corners: Vec<i64> = want.triangles.iter().flatten().map(|&v| v.into()).collect();
    assert_eq!(array(&vtu, "connectivity").1, bytemuck::cast_slice::<_, u8>(&corners));
    let vtu = fs::read(dir.path().join("particles/frame_0001.vtu")).unwrap();
    assert_eq!(array(&vtu, "mass").1, bytemuck::cast_slice::<_, u8>(&particles(1).mass));
}

/// Longer than one block, and with a last one that is shorter.
#[test]
fn long_arrays_are_packed_in_blocks() {
    let dir = tempfile::tempdir().unwrap();
    let n = 30_001;
    let mut long = surface(0);
    let grow = |v: &[f32; 3], k: usize| [v[0] + k as f32, v[1], v[2]];
    long.positions = (0..n).map(|k| grow(&long.positions[k % 12], k)).collect();
    (long.normals, long.velocity) = (vec![[0.0; 3]; n], vec![[1.0; 3]; n]);
    (long.damage, long.stretch, long.id) = (vec![0.0; n], vec![0.0; n], (0..n as u32).collect());
    (long.inside, long.piece) = (vec![0; n], vec![0; n]);
    let mut stream = open(Format::Vtu, dir.path(), &about(), 0).unwrap().unwrap();
    stream.frame(&Shot { surface: &long, colliders: None, particles: None, tets: None }).unwrap();
    stream.index().unwrap();
    let vtu = fs::read(dir.path().join("surface/frame_0000.vtu")).unwrap();
    assert_eq!(array(&vtu, "Points").1, bytemuck::cast_slice::<_, u8>(&long.positions));
    assert_eq!(array(&vtu, "id").1, bytemuck::cast_slice::<_, u8>(&long.id));
    assert!(!dir.path().join("particles.pvd").exists() && dir.path().join("surface.pvd").exists());
}

#[test]
fn ply_and_obj_come_back_through_our_readers() {
    let dir = tempfile::tempdir().unwrap();
    feed(Format::Ply, dir.path(), 0..2);
    let path = dir.path().join("frame_0001.ply");
    assert_eq!(crate::frames::read(&path).unwrap(), surface(1));
    let bytes = fs::read(&path).unwrap();
    let head = String::from_utf8_lossy(&bytes[..600]).into_owned();
    assert!(head.contains("property uchar red\nproperty uchar green\nproperty uchar blue\n"));
    // the colours of the first and of the last vertex: outside and inside
    let start = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let colour = |v: usize| &bytes[start + 56 * v + 53..][..3];
    let [outside, inside, _] = colours(&about()).map(|c| c.map(|x| (x * 255.0).round() as u8));
    assert_eq!((colour(0), colour(23)), (&outside[..], &inside[..]));

    feed(Format::Obj, dir.path(), 0..2);
    let obj = text(dir.path().join("frame_0001.obj"));
    let groups: Vec<&str> = obj.lines().filter(|l| l.starts_with("g ") || l.starts_with("usemtl ")).collect();
    let half = ["usemtl outside", "usemtl inside"];
    let whole = [
        &["g piece0"][..],
        &half,
        &["g piece1"],
        &half,
        &["g collider0", "usemtl collider", "g collider1", "usemtl collider"],
    ];
    assert_eq!(groups, whole.concat());
    let Mesh::Surface(mesh) = read(dir.path().join("frame_0001.obj")).unwrap() else { panic!("no surface") };
    assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (48, 16));
    let mtl = text(dir.path().join("fissure.mtl"));
    assert!(["outside", "inside", "collider"].iter().all(|m| mtl.contains(&format!("newmtl {m}\n"))));
}

#[test]
fn a_scene_for_pov_ray_keeps_the_look_that_it_was_given() {
    let dir = tempfile::tempdir().unwrap();
    feed(Format::Pov, dir.path(), 0..1);
    let look = dir.path().join("look.inc");
    assert!(
        text(look.clone()).contains("camera {") && text(look.clone()).contains("#declare inside_texture = texture")
    );
    fs::write(&look, "// mine").unwrap();
    feed(Format::Pov, dir.path(), 1..2);
    assert_eq!(text(look), "// mine");
    let pov = text(dir.path().join("frame_0001.pov"));
    assert_eq!(pov.matches("mesh2 {").count(), 2);
    assert!(pov.contains("vertex_vectors {\n    24,") && pov.contains("face_indices {\n    8,"));
    assert!(pov.contains("<9,10,11>,1,\n") && pov.contains("<0,1,2>,0,\n"), "inside has the second texture");
}

/// Header, chunks, and the numbers of an accessor.
fn parts(bytes: &[u8]) -> (Value, Vec<u8>) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], word(4), word(8), &bytes[16..20]), (&b"glTF"[..], 2, bytes.len(), &b"JSON"[..]));
    let binary = 20 + word(12);
    assert_eq!((word(12) % 4, &bytes[binary + 4..binary + 8]), (0, &b"BIN\0"[..]));
    assert_eq!(binary + 8 + word(binary), bytes.len());
    (serde_json::from_slice(&bytes[20..binary]).unwrap(), bytes[binary + 8..].to_vec())
}

fn floats(json: &Value, binary: &[u8], accessor: usize) -> Vec<f32> {
    let accessor = &json["accessors"][accessor];
    let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let [start, length] = ["byteOffset", "byteLength"].map(|k| view[k].as_u64().unwrap() as usize);
    let width = match accessor["type"].as_str().unwrap() {
        "SCALAR" => 1,
        "VEC3" => 3,
        _ => 4,
    };
    assert_eq!(length, 4 * width * accessor["count"].as_u64().unwrap() as usize, "a view is its accessor");
    bytemuck::pod_collect_to_vec(&binary[start..start + length])
}

/// In the shape of the last frame, and in that at rest.
#[test]
fn nodes_of_a_glb_move_as_the_particles_do() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("run.glb");
    let (numbers, last) = ([0, 1, 2, 3], surface(3));
    let run = |numbers, rest| glb::Run {
        numbers,
        last: &last,
        rest,
        particles: &|n| Ok(particles(n)),
        colliders: &|n| Ok(Some(surface(n))),
    };
    let corners = [glam::DVec3::ZERO, glam::DVec3::X, glam::DVec3::Y, glam::DVec3::Z];
    let shapes = [None, Some(corners.to_vec())];
    for rest in &shapes {
        let reference = if rest.is_some() { 0 } else { 3 };
        glb::write(&path, &about(), &run(&numbers, std::slice::from_ref(rest))).unwrap();
        let (json, binary) = parts(&fs::read(&path).unwrap());
        assert_eq!(json["buffers"][0]["byteLength"], binary.len());
        let names: Vec<&str> = json["nodes"].as_array().unwrap().iter().map(|n| n["name"].as_str().unwrap()).collect();
        assert_eq!(names, ["piece_0", "piece_1", "collider_0", "collider_1"]);
        let extras = &json["nodes"][1]["extras"];
        assert_eq!((&extras["parent"], &extras["born"], &extras["body"]), (&0.into(), &0.01.into(), &"half".into()));
        assert_eq!((extras["mass"].as_f64().unwrap(), extras["inertia"].as_array().unwrap().len()), (4.0, 9));
        let mean = |number: u32, node: usize, axis: usize| {
            particles(number).positions[8 * node..][..8].iter().map(|p| p[axis]).sum::<f32>() / 8.0
        };
        // every corner of the mesh is where it is in the reference, and each side has its material
        let primitives = json["meshes"][1]["primitives"].as_array().unwrap();
        assert_eq!(primitives.iter().map(|p| p["material"].as_u64().unwrap()).collect::<Vec<_>>(), [0, 1]);
        let accessor = |name: &str| primitives[0]["attributes"][name].as_u64().unwrap() as usize;
        let (at, normals) = (floats(&json, &binary, accessor("POSITION")), floats(&json, &binary, accessor("NORMAL")));
        for v in 0..12 {
            let want: [f32; 3] = match rest {
                Some(rest) => rest[last.id[12 + v] as usize].as_vec3().into(),
                None => last.positions[12 + v],
            };
            let off = (0..3).map(|k| (at[3 * v + k] + mean(reference, 1, k) - want[k]).abs()).fold(0.0, f32::max);
            assert!(off < 1e-6, "vertex {v}: {off}"); // measured: f32
        }
        // the face in the plane z = 0 looks down, whatever the frame said of it
        let down = if rest.is_some() { [0.0, 0.0, -1.0] } else { [0.0, 1.0, 0.0] };
        assert_eq!(normals[..3], down);
        let channels = json["animations"][0]["channels"].as_array().unwrap();
        let output = |node: usize, path: &str| {
            let of = |c: &&Value| c["target"]["node"] == node && c["target"]["path"] == path;
            let sampler = channels.iter().find(of).unwrap()["sampler"].as_u64().unwrap() as usize;
            let sampler = &json["animations"][0]["samplers"][sampler];
            assert_eq!(floats(&json, &binary, sampler["input"].as_u64().unwrap() as usize), [0.0, 0.01, 0.02, 0.03]);
            floats(&json, &binary, sampler["output"].as_u64().unwrap() as usize)
        };
        for node in 0..2 {
            let (turns, places) = (output(node, "rotation"), output(node, "translation"));
            for (number, (turn, place)) in (0..).zip(turns.chunks(4).zip(places.chunks(3))) {
                let angle = 0.1 * (number as f32 - reference as f32);
                let want = [0.0, (angle / 2.0).sin(), 0.0, (angle / 2.0).cos()];
                let off = turn.iter().zip(want).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(off < 1e-5, "frame {number}: {turn:?} {want:?}"); // measured: below 1e-6
                assert!((0..3).all(|k| (place[k] - mean(number, node, k)).abs() < 1e-5), "{place:?}");
            }
        }
    }
    let none = glb::write(&path, &about(), &run(&[], &[None]));
    assert!(none.unwrap_err().to_string().contains("no frame"));
}
