//! From what a scene says of a body's geometry to its tetrahedra.

use fissure_meshing::quality::Report;
use fissure_meshing::surface::{PrepareOptions, prepare};
use fissure_meshing::tetrahedralise::{Options, shell_size_for, size_for, tetrahedralise};
use fissure_meshing::{TetMesh, TriMesh, shapes};
use glam::DVec3;

use crate::mesh::{Mesh, read};
use crate::scene::{Body, Resolution, Shape, Source};

/// Tetrahedra with what there is to say about how they came to be.
pub struct Solid {
    /// The tetrahedra, where they stand in the world.
    pub mesh: TetMesh,
    /// Their quality against the surface, if they were made from one.
    pub report: Option<Report>,
    /// Repairs and warnings, one sentence each.
    pub notes: Vec<String>,
}

/// The placed tetrahedra of `body`.
///
/// # Errors
/// One sentence that says what is wrong with the geometry and what helps.
pub fn solid(body: &Body, seed: u64) -> Result<Solid, String> {
    let source = match &body.source {
        Source::Mesh { path, .. } => read(path).map_err(|e| e.to_string())?,
        Source::Shape(shape) => Mesh::Surface(generate(shape).map_err(|e| e.to_string())?),
    };
    let scale = body.placement.scale;
    let scaled = |vertices: Vec<DVec3>| vertices.into_iter().map(|v| v * scale).collect();
    let mut made = match source {
        Mesh::Solid(tets) => {
            let mesh = TetMesh { vertices: scaled(tets.mesh.vertices), tets: tets.mesh.tets };
            if body.shell.is_some() {
                return Err("`shell` makes a wall of a surface, but this mesh has tetrahedra already; remove it".into());
            }
            Solid { mesh, report: None, notes: Vec::new() }
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

/// Fills a surface, after repairing what can be repaired.
pub fn fill(surface: TriMesh, resolution: Resolution, shell: Option<f64>, seed: u64) -> Result<Solid, String> {
    let options = PrepareOptions { for_shell: shell.is_some(), ..PrepareOptions::default() };
    let (surface, mut notes) = prepare(surface, options).map_err(|e| e.to_string())?;
    let size = match (resolution, shell) {
        (Resolution::Size(size), _) => size,
        (Resolution::Tets(tets), None) => size_for(&surface, tets as usize),
        (Resolution::Tets(tets), Some(thickness)) => shell_size_for(&surface, thickness, tets as usize),
    };
    let options = Options { seed, shell, ..Options::new(size) };
    let (mesh, report) = tetrahedralise(&surface, &options).map_err(|e| e.to_string())?;
    notes.extend(report.warnings.iter().cloned());
    Ok(Solid { mesh, report: Some(report), notes })
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
