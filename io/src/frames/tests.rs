use std::path::Path;

use super::*;

fn sample() -> Frame {
    Frame {
        positions: vec![[0.0, 0.1, 0.2], [1.0, -0.0, 1e-30], [0.3, 2.0, 0.1], [f32::MAX, 0.7, -3.5]],
        normals: vec![[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.6, 0.8, 0.0]],
        triangles: vec![[0, 1, 2], [2, 1, 3]],
        velocity: vec![[0.0, -4.5, 0.0], [1.0, 2.0, 3.0], [0.1, 0.2, 0.3], [-1.0, 0.0, 9.0]],
        damage: vec![0.0, 0.25, 1.0, 0.1],
        stretch: vec![0.5, -0.25, 0.0, 1e-7],
        id: vec![7, 0, 16_777_217, u32::MAX],
        inside: vec![0, 1, 1, 0],
        piece: vec![3, 3, 0, 70_000],
        time: 0.1 + 0.2,
        number: 42,
    }
}

#[test]
fn a_frame_comes_back_bit_for_bit() {
    let dir = tempfile::tempdir().unwrap();
    let folder = FrameFolder::new(dir.path().join("frames"));
    let path = folder.write(&sample()).unwrap();
    assert_eq!(path.file_name().unwrap(), "frame_0042.ply");
    assert_eq!(folder.read(42).unwrap(), sample());
    assert_eq!(folder.time(42).unwrap(), sample().time);
    assert!(folder.time(41).unwrap_err().to_string().contains("frame_0041.ply"));
    assert_eq!(std::fs::read_dir(folder.folder()).unwrap().count(), 1, "no temporary file stays behind");
    let empty = Frame { number: 3, ..Frame::default() };
    folder.write(&empty).unwrap();
    assert_eq!(folder.read(3).unwrap(), empty);
}

#[test]
fn the_folder_lists_its_frames_in_order_and_passes_over_others() {
    let dir = tempfile::tempdir().unwrap();
    let folder = FrameFolder::new(dir.path());
    assert_eq!(FrameFolder::new(dir.path().join("absent")).next().unwrap(), 0);
    for number in [10_000, 2, 0, 9_999] {
        folder.write(&Frame { number, ..Frame::default() }).unwrap();
    }
    for other in ["frame_1.ply", "frame_00002.ply", "frame_0003.ply.tmp", ".writing-x", "frame_+001.ply", "log.txt"] {
        std::fs::write(dir.path().join(other), b"x").unwrap();
    }
    assert_eq!(folder.numbers().unwrap(), [0, 2, 9_999, 10_000]);
    assert_eq!(folder.next().unwrap(), 10_001);
}

#[test]
fn particles_come_back_bit_for_bit() {
    let sample = ParticleFrame {
        positions: vec![[0.0, 0.1, 0.2], [1.0, -0.0, 1e-30]],
        velocity: vec![[0.0, -4.5, 0.0], [1.0, 2.0, 3.0]],
        damage: vec![0.25, 1.0],
        id: vec![16_777_217, u32::MAX],
        piece: vec![0, 70_000],
        body: vec![1, 0],
        mass: vec![1e-6, 3.0],
        volume: vec![8e-9, 0.0],
        time: 0.1 + 0.2,
        number: 12_345,
    };
    let dir = tempfile::tempdir().unwrap();
    let folder = FrameFolder::new(dir.path().join("particles"));
    assert_eq!(folder.write_particles(&sample).unwrap().file_name().unwrap(), "frame_12345.ply");
    assert_eq!(folder.read_particles(12_345).unwrap(), sample);
    let as_surface = folder.read(12_345).unwrap(); // what knows surfaces only sees points
    assert_eq!((as_surface.positions.len(), as_surface.piece[1], as_surface.triangles.len()), (2, 70_000, 0));
    let bytes = sample.to_bytes().unwrap();
    assert!(String::from_utf8_lossy(&bytes).contains("property float width"));
    assert_eq!(sample.width(0), 2e-3);
    for length in 0..bytes.len() {
        assert!(ParticleFrame::from_bytes(&bytes[..length], Path::new("cut.ply")).is_err(), "{length}");
    }
    let short = ParticleFrame { mass: vec![1.0], ..sample };
    assert!(short.to_bytes().unwrap_err().to_string().contains("1 values of mass for 2 vertices"));
}

#[test]
fn columns_that_do_not_fit_are_refused_by_name() {
    let mut frame = sample();
    frame.damage.pop();
    assert!(to_bytes(&frame).unwrap_err().to_string().contains("3 values of damage for 4 vertices"));
    let mut frame = sample();
    frame.triangles[1][2] = 4;
    assert!(to_bytes(&frame).unwrap_err().to_string().contains("triangle 1 names vertex 4"));
}

#[test]
fn a_file_cut_anywhere_is_an_error_and_never_a_panic() {
    let bytes = to_bytes(&sample()).unwrap();
    for length in 0..bytes.len() {
        let error = from_bytes(&bytes[..length], Path::new("cut.ply")).unwrap_err().to_string();
        assert!(error.starts_with("cut.ply: "), "{length}: {error}");
    }
    for k in 0..bytes.len() {
        let mut flipped = bytes.clone();
        flipped[k] ^= 0x41;
        let _ = from_bytes(&flipped, Path::new("flipped.ply")); // any answer but a panic or endless memory
    }
}

#[test]
fn foreign_files_open_by_property_name() {
    let mut bytes = b"ply\nformat binary_little_endian 1.0\ncomment made elsewhere\nelement vertex 3\n\
        property double z\nproperty uchar inside\nproperty float x\nproperty float y\n\
        element face 1\nproperty list uchar uint vertex_index\nend_header\n"
        .to_vec();
    for k in 0..3_u8 {
        bytes.extend(f64::from(k).to_le_bytes());
        bytes.push(1);
        bytes.extend(5.0_f32.to_le_bytes());
        bytes.extend(6.0_f32.to_le_bytes());
    }
    bytes.push(3);
    for v in [2_u32, 0, 1] {
        bytes.extend(v.to_le_bytes());
    }
    let frame = from_bytes(&bytes, Path::new("somewhere/frame_0017.ply")).unwrap();
    assert_eq!(frame.positions[2], [5.0, 6.0, 2.0]);
    assert_eq!((frame.number, frame.inside[0], frame.id[2]), (17, 1, 2));
    assert_eq!(frame.triangles, [[2, 0, 1]]);
    let ascii = b"ply\nformat ascii 1.0\n";
    let error = from_bytes(ascii, Path::new("a.ply")).unwrap_err().to_string();
    assert!(error.contains("line 2 \"format ascii 1.0\""), "{error}");
}

#[test]
fn a_folder_that_cannot_be_written_is_one_sentence() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("file");
    std::fs::write(&file, b"x").unwrap();
    let error = FrameFolder::new(file.join("frames")).write(&sample()).unwrap_err().to_string();
    assert!(error.contains("cannot create") && error.contains("frames"), "{error}");
}
