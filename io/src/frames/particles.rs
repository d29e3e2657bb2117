//! Particles at one instant, as numbered PLY files with vertices only.
//!
//! A particle is 52 bytes: position, velocity and damage as `float`; `id`, `piece` and `body` as `uint`; `mass`, `volume` and
//! `width` as `float`. `width`, the cube root of the volume, is there for programs that draw points; readers need it not.

use std::path::Path;

use super::header::Header;
use super::{FrameError, folder::number_of, ply};
use crate::atomic::write_atomically;

/// The particles of all bodies at one time; of a lattice, its nodes. Column `k` of each belongs to particle `k`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParticleFrame {
    /// Where they are (m).
    pub positions: Vec<[f32; 3]>,
    /// Velocities (m/s).
    pub velocity: Vec<[f32; 3]>,
    /// Damage, 0 (whole) to 1 (every bond broken).
    pub damage: Vec<f32>,
    /// Number of the particle in its body's input: the same in every frame. Nodes of a lattice have that of their first
    /// finest cell.
    pub id: Vec<u32>,
    /// Which fragment, under an id that lasts.
    pub piece: Vec<u32>,
    /// Number of the body in the scene, from 0.
    pub body: Vec<u32>,
    /// Mass (kg).
    pub mass: Vec<f32>,
    /// Rest volume (m³).
    pub volume: Vec<f32>,
    /// Simulated time (s).
    pub time: f64,
    /// Number of the frame in its run, from 0.
    pub number: u32,
}

/// Vertex properties in file order.
const PROPERTIES: [(&str, &str); 13] = [
    ("float", "x"),
    ("float", "y"),
    ("float", "z"),
    ("float", "velocity_x"),
    ("float", "velocity_y"),
    ("float", "velocity_z"),
    ("float", "damage"),
    ("uint", "id"),
    ("uint", "piece"),
    ("uint", "body"),
    ("float", "mass"),
    ("float", "volume"),
    ("float", "width"),
];
const BYTES: usize = 13 * 4;

impl ParticleFrame {
    /// Edge of a cube with the volume of particle `k` (m): how large to draw it.
    pub fn width(&self, k: usize) -> f32 {
        self.volume[k].cbrt()
    }

    /// Checks that all columns have one length.
    ///
    /// # Errors
    /// [`FrameError::Length`] for the first that has another.
    pub fn check(&self) -> Result<(), FrameError> {
        let want = self.positions.len();
        let columns = [
            ("velocity", self.velocity.len()),
            ("damage", self.damage.len()),
            ("id", self.id.len()),
            ("piece", self.piece.len()),
            ("body", self.body.len()),
            ("mass", self.mass.len()),
            ("volume", self.volume.len()),
        ];
        match columns.into_iter().find(|&(_, got)| got != want) {
            Some((column, got)) => Err(FrameError::Length { number: self.number, column, got, want }),
            None => Ok(()),
        }
    }

    /// The bytes as a PLY file.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn to_bytes(&self) -> Result<Vec<u8>, FrameError> {
        self.check()?;
        let particles = self.positions.len();
        let mut out = Vec::with_capacity(600 + particles * BYTES);
        ply::begin(&mut out, self.number, self.time, particles, &PROPERTIES);
        out.extend_from_slice(b"end_header\n");
        for k in 0..particles {
            for vector in [self.positions[k], self.velocity[k]] {
                vector.iter().for_each(|number| out.extend_from_slice(&number.to_le_bytes()));
            }
            out.extend_from_slice(&self.damage[k].to_le_bytes());
            for number in [self.id[k], self.piece[k], self.body[k]] {
                out.extend_from_slice(&number.to_le_bytes());
            }
            for number in [self.mass[k], self.volume[k], self.width(k)] {
                out.extend_from_slice(&number.to_le_bytes());
            }
        }
        Ok(out)
    }

    /// Writes to `path`, complete or not at all.
    ///
    /// # Errors
    /// As [`to_bytes`](Self::to_bytes), and [`FrameError::Io`].
    pub fn write(&self, path: &Path) -> Result<(), FrameError> {
        let bytes = self.to_bytes()?;
        write_atomically(path, &bytes).map_err(|source| FrameError::Io { action: "write", path: path.into(), source })
    }

    /// Reads particles. Columns are found by name; those that are missing are zero, `id` the number of the particle.
    ///
    /// # Errors
    /// [`FrameError::Io`], [`FrameError::Format`].
    pub fn read(path: &Path) -> Result<Self, FrameError> {
        let bytes =
            std::fs::read(path).map_err(|source| FrameError::Io { action: "read", path: path.into(), source })?;
        Self::from_bytes(&bytes, path)
    }

    /// As [`read`](Self::read) from bytes already in memory; `path` is only named in errors and asked for the number.
    ///
    /// # Errors
    /// [`FrameError::Format`].
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, FrameError> {
        let format = |problem: String| FrameError::Format { path: path.into(), problem };
        let header = Header::parse(bytes).map_err(format)?;
        let name = path.file_name().and_then(|n| n.to_str());
        let number = header.number.or_else(|| name.and_then(number_of)).unwrap_or(0);
        let (columns, _) = header.columns(&bytes[header.length..]).map_err(format)?;
        let n = header.vertices;
        let mut frame = Self {
            positions: vec![[0.0; 3]; n],
            velocity: vec![[0.0; 3]; n],
            damage: vec![0.0; n],
            id: (0..n as u32).collect(),
            piece: vec![0; n],
            body: vec![0; n],
            mass: vec![0.0; n],
            volume: vec![0.0; n],
            time: header.time,
            number,
        };
        for (name, values) in columns {
            let values = values.iter().enumerate();
            match name {
                "x" => values.for_each(|(k, v)| frame.positions[k][0] = v as f32),
                "y" => values.for_each(|(k, v)| frame.positions[k][1] = v as f32),
                "z" => values.for_each(|(k, v)| frame.positions[k][2] = v as f32),
                "velocity_x" => values.for_each(|(k, v)| frame.velocity[k][0] = v as f32),
                "velocity_y" => values.for_each(|(k, v)| frame.velocity[k][1] = v as f32),
                "velocity_z" => values.for_each(|(k, v)| frame.velocity[k][2] = v as f32),
                "damage" => values.for_each(|(k, v)| frame.damage[k] = v as f32),
                "id" => values.for_each(|(k, v)| frame.id[k] = v as u32),
                "piece" => values.for_each(|(k, v)| frame.piece[k] = v as u32),
                "body" => values.for_each(|(k, v)| frame.body[k] = v as u32),
                "mass" => values.for_each(|(k, v)| frame.mass[k] = v as f32),
                "volume" => values.for_each(|(k, v)| frame.volume[k] = v as f32),
                _ => {}
            }
        }
        Ok(frame)
    }
}
