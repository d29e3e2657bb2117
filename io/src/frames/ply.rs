//! Frames as binary little-endian PLY.
//!
//! One vertex is 53 bytes: position, normal, velocity, damage and stretch as `float`, `id` as `uint`, `inside` as `uchar`,
//! `piece` as `uint`. Faces hold nothing but three `int` indices. Time and number are one comment line.
//! Layout by hand rather than by a PLY crate: the record is fixed, and a general writer asks for each number by name.

use std::io::Read;
use std::path::Path;

use super::{Frame, FrameError, folder::number_of, header::Header};
use crate::atomic::write_atomically;

/// Vertex properties in file order.
const PROPERTIES: [(&str, &str); 14] = [
    ("float", "x"),
    ("float", "y"),
    ("float", "z"),
    ("float", "nx"),
    ("float", "ny"),
    ("float", "nz"),
    ("float", "velocity_x"),
    ("float", "velocity_y"),
    ("float", "velocity_z"),
    ("float", "damage"),
    ("float", "stretch"),
    ("uint", "id"),
    ("uchar", "inside"),
    ("uint", "piece"),
];
/// What [`coloured`] frames have behind them.
const COLOURS: [(&str, &str); 3] = [("uchar", "red"), ("uchar", "green"), ("uchar", "blue")];
const VERTEX_BYTES: usize = 12 * 4 + 1 + 4;
const FACE_BYTES: usize = 1 + 3 * 4;

/// The bytes of `frame` as a PLY file.
///
/// # Errors
/// [`FrameError::Length`] or [`FrameError::Index`] if the columns do not fit together.
pub fn to_bytes(frame: &Frame) -> Result<Vec<u8>, FrameError> {
    bytes(frame, &PROPERTIES, &|_| None)
}

/// As [`to_bytes`], with the red, green and blue of each vertex.
pub(crate) fn coloured(frame: &Frame, colour: &dyn Fn(usize) -> [u8; 3]) -> Result<Vec<u8>, FrameError> {
    bytes(frame, &[&PROPERTIES[..], &COLOURS].concat(), &|v| Some(colour(v)))
}

fn bytes(
    frame: &Frame,
    properties: &[(&str, &str)],
    colour: &dyn Fn(usize) -> Option<[u8; 3]>,
) -> Result<Vec<u8>, FrameError> {
    frame.check()?;
    let (vertices, faces) = (frame.positions.len(), frame.triangles.len());
    let mut out = Vec::with_capacity(600 + vertices * (VERTEX_BYTES + 3) + faces * FACE_BYTES);
    begin(&mut out, frame.number, frame.time, vertices, properties);
    out.extend_from_slice(format!("element face {faces}\nproperty list uchar int vertex_indices\n").as_bytes());
    out.extend_from_slice(b"end_header\n");
    for k in 0..vertices {
        for vector in [frame.positions[k], frame.normals[k], frame.velocity[k]] {
            for number in vector {
                out.extend_from_slice(&number.to_le_bytes());
            }
        }
        out.extend_from_slice(&frame.damage[k].to_le_bytes());
        out.extend_from_slice(&frame.stretch[k].to_le_bytes());
        out.extend_from_slice(&frame.id[k].to_le_bytes());
        out.push(frame.inside[k]);
        out.extend_from_slice(&frame.piece[k].to_le_bytes());
        out.extend(colour(k).into_iter().flatten());
    }
    for corners in &frame.triangles {
        out.push(3);
        for v in corners {
            out.extend_from_slice(&v.to_le_bytes());
        }
    }
    Ok(out)
}

/// The lines of a header up to the properties of its vertices.
pub(crate) fn begin(out: &mut Vec<u8>, number: u32, time: f64, vertices: usize, properties: &[(&str, &str)]) {
    // {:?} prints the shortest decimal that reads back to the same bits.
    let mut text = format!(
        "ply\nformat binary_little_endian 1.0\ncomment fissure frame {number} time {time:?} s\nelement vertex {vertices}\n"
    );
    for (kind, name) in properties {
        text += &format!("property {kind} {name}\n");
    }
    out.extend_from_slice(text.as_bytes());
}

/// Writes `frame` to `path`, complete or not at all.
///
/// # Errors
/// As [`to_bytes`], and [`FrameError::Io`].
pub fn write(frame: &Frame, path: &Path) -> Result<(), FrameError> {
    let bytes = to_bytes(frame)?;
    write_atomically(path, &bytes).map_err(|source| FrameError::Io { action: "write", path: path.into(), source })
}

/// Reads a frame. Without a comment line of ours the number comes from the file name (0 if there is none) and the
/// time is 0.
///
/// # Errors
/// [`FrameError::Io`], [`FrameError::Format`], [`FrameError::Index`].
pub fn read(path: &Path) -> Result<Frame, FrameError> {
    let bytes = std::fs::read(path).map_err(|source| FrameError::Io { action: "read", path: path.into(), source })?;
    from_bytes(&bytes, path)
}

/// The time in the head of the file at `path` [s].
pub(super) fn time(path: &Path) -> Result<f64, FrameError> {
    // the head of a frame of ours takes 430 bytes
    let mut head = Vec::with_capacity(4096);
    let read = std::fs::File::open(path).and_then(|file| file.take(4096).read_to_end(&mut head));
    read.map_err(|source| FrameError::Io { action: "read", path: path.into(), source })?;
    let header = Header::parse(&head).map_err(|problem| FrameError::Format { path: path.into(), problem })?;
    Ok(header.time)
}

/// As [`read`] from bytes already in memory; `path` is only named in errors and asked for the frame number.
///
/// # Errors
/// [`FrameError::Format`], [`FrameError::Index`].
pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Frame, FrameError> {
    let format = |problem: String| FrameError::Format { path: path.into(), problem };
    let header = Header::parse(bytes).map_err(format)?;
    let name = path.file_name().and_then(|n| n.to_str());
    let number = header.number.or_else(|| name.and_then(number_of)).unwrap_or(0);
    let mut frame = Frame { number, time: header.time, ..Frame::default() };
    let faces = header.read_vertices(&bytes[header.length..], &mut frame).map_err(format)?;
    frame.triangles = header.read_faces(faces).map_err(format)?;
    frame.check_triangles()?;
    Ok(frame)
}
