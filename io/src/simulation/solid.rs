//! From what a scene says of a body's geometry to its tetrahedra.

use fissure_meshing::lattice::{self, Lattice, LatticeError, size_for};
use fissure_meshing::quality::Report;
use fissure_meshing::surface::{PrepareOptions, SurfaceError, prepare};
use fissure_meshing::tetrahedralise::{self, MeshError, Options, shell_size_for, tetrahedralise};
use fissure_meshing::{TetMesh, TriMesh, shapes};
use glam::DVec3;
use thiserror::Error;

use crate::mesh::{Mesh, read};
use crate::scene::{Body, Fineness, Resolution, Shape, Source};

/// Tetrahedra with what there is to say about how they came to be.
pub struct Solid {
    /// The tetrahedra, where they stand in the world.
    pub mesh: TetMesh,
    /// Their quality against the surface, if they were made from one.
    pub report: Option<Report>,
    /// Repairs and warnings, one sentence each.
    pub notes: Vec<String>,
    /// The label of each tetrahedron in the mesh file, or none.
    pub labels: Vec<i64>,
}

/// Why a body's geometry does not work out.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{message}")]
pub struct Fault {
    /// The key of `[body.NAME]` that is to blame.
    pub key: &'static str,
    /// One sentence with what helps.
    pub message: String,
}

impl Fault {
    /// `error` of `key`, as a function for `map_err`.
    pub(super) fn of<E: ToString>(key: &'static str) -> impl Fn(E) -> Self {
        move |error| Self { key, message: error.to_string() }
    }
}

/// The placed tetrahedra of `body`.
///
/// # Errors
/// What is wrong with the geometry and what helps.
pub fn solid(body: &Body, seed: u64) -> Result<Solid, Fault> {
    let source = match &body.source {
        Source::Mesh { path, .. } => read(path).map_err(Fault::of("mesh"))?,
        Source::Shape(shape) => Mesh::Surface(generate(shape).map_err(Fault::of("shape"))?),
    };
    let scale = body.placement.scale;
    let scaled = |vertices: Vec<DVec3>| vertices.into_iter().map(|v| v * scale).collect();
    let mut made = match source {
        Mesh::Solid(tets) => {
            let mesh = TetMesh { vertices: scaled(tets.mesh.vertices), tets: tets.mesh.tets };
            if body.shell.is_some() {
                let message = "`shell` makes a wall of a surface, but this mesh has tetrahedra already; remove it";
                return Err(Fault::of("shell")(message));
            }
            Solid { mesh, report: None, notes: Vec::new(), labels: tets.labels }
        }
        Mesh::Surface(surface) => {
            fill(TriMesh { vertices: scaled(surface.vertices), ..surface }, body.resolution, body.shell, seed)?
        }
    };
    let turn = body.placement.rotation();
    for v in &mut made.mesh.vertices {
        *v = turn * *v + body.placement.translate;
    }
    Ok(made)
}

/// The cells of a body that is a lattice, with what there is to say about how they came to be.
///
/// # Errors
/// What is wrong with the geometry and what helps.
pub(super) fn cells(body: &Body) -> Result<Lattice, Fault> {
    let surface = match &body.source {
        Source::Mesh { path, .. } => match read(path).map_err(Fault::of("mesh"))? {
            Mesh::Surface(surface) => surface,
            Mesh::Solid(_) => {
                return Err(Fault::of("mesh")(
                    "it has tetrahedra, but a lattice fills surfaces; give a closed surface",
                ));
            }
        },
        Source::Shape(shape) => generate(shape).map_err(Fault::of("shape"))?,
    };
    let vertices = surface.vertices.iter().map(|&v| body.placement.place(v)).collect();
    let placed = TriMesh { vertices, ..surface };
    let (surface, mut notes) = prepare(placed, PrepareOptions::default()).map_err(|error| match error {
        // a lattice has no walls
        SurfaceError::Open { edges, at, .. } => Fault::of("mesh")(LatticeError::Open { edges, at }),
        error => Fault::of("mesh")(error),
    })?;
    let (size, key) = match body.lattice.fineness {
        Fineness::Size(size) => (size, "cell"),
        Fineness::Cells(cells) => (size_for(&surface, cells), "cells"),
    };
    let options = lattice::Options { size, faces: body.lattice.faces, memory: body.lattice.memory };
    let mut made = lattice::lattice(&surface, &options).map_err(|error| {
        let key = match error {
            LatticeError::Folded { .. } => "crack_faces",
            LatticeError::Coarse { .. } | LatticeError::Memory { .. } | LatticeError::Number { .. } => key,
            _ => "mesh",
        };
        Fault::of(key)(error)
    })?;
    notes.append(&mut made.notes);
    Ok(Lattice { notes, ..made })
}

/// Fills a surface, after repairing what can be repaired.
///
/// # Errors
/// What is wrong with the surface, or the elements wanted, and what helps.
pub fn fill(surface: TriMesh, resolution: Resolution, shell: Option<f64>, seed: u64) -> Result<Solid, Fault> {
    let options = PrepareOptions { for_shell: shell.is_some(), ..PrepareOptions::default() };
    let (surface, mut notes) = prepare(surface, options).map_err(Fault::of("mesh"))?;
    let size = match (resolution, shell) {
        (Resolution::Size(size), _) => size,
        (Resolution::Tets(tets), None) => tetrahedralise::size_for(&surface, tets as usize),
        // at least two elements go through a wall, though it take more tetrahedra than asked for
        (Resolution::Tets(tets), Some(thickness)) => {
            shell_size_for(&surface, thickness, tets as usize).min(thickness / 2.0)
        }
    };
    let options = Options { seed, shell, ..Options::new(size) };
    let (mesh, report) = tetrahedralise(&surface, &options).map_err(|error| {
        let key = match (&error, resolution) {
            (MeshError::ThinShell { .. }, _) => "shell",
            (MeshError::TooCoarse { .. } | MeshError::TooFine { .. } | MeshError::Number(_), Resolution::Size(_)) => {
                "size"
            }
            (MeshError::TooCoarse { .. } | MeshError::TooFine { .. } | MeshError::Number(_), Resolution::Tets(_)) => {
                "tets"
            }
            _ => "mesh",
        };
        Fault::of(key)(error)
    })?;
    notes.extend(report.warnings.iter().cloned());
    Ok(Solid { mesh, report: Some(report), notes, labels: Vec::new() })
}

fn generate(shape: &Shape) -> Result<TriMesh, shapes::ShapeError> {
    // fine enough that facets are far below any element size
    const SEGMENTS: usize = 64;
    match *shape {
        Shape::Box { size } => shapes::cuboid(size, DVec3::ZERO),
        Shape::Beam { length, width } => shapes::beam(length, width, DVec3::ZERO),
        Shape::Wall { width, height, thickness } => shapes::wall(width, height, thickness, DVec3::ZERO),
        Shape::Sheet { width, height, thickness } => shapes::sheet(width, height, thickness, DVec3::ZERO),
        Shape::Ball { radius } => shapes::ball(radius, 4),
        Shape::Cylinder { radius, height } => shapes::cylinder(radius, height, SEGMENTS),
        Shape::Revolution { ref profile, segments } => {
            let points: Vec<(f64, f64)> = profile.iter().map(|&[r, y]| (r, y)).collect();
            shapes::revolution(&points, segments as usize)
        }
        Shape::Vase { height, wall } => shapes::vase(height, wall, SEGMENTS),
    }
}
