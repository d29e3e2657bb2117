//! Closed surfaces as lattices of cubic cells (Ohta et al., "Preprocessing" and "Fracturing").
//!
//! ```text
//! surface ── cut at the faces of cells ── faces between cells ── parts, volumes, links ──> Cells for the material
//!            (clip.rs)                    (wall.rs, polygon.rs)  (pieces.rs)          └──> Facets for pictures
//! ```
//!
//! The cut is exact: a cell's volume and centre of mass are those of what the surface encloses of it, to rounding, and they
//! add up to the body's. Two cells are linked if the body goes on from one to the other through their common face;
//! diagonal neighbours if such faces lead from one to the other within the block of cells that both are in. Whatever gap
//! is between two parts, however thin, keeps them apart.
//!
//! The same faces are the crack surfaces. They end where the surface does (fitted), and noise bends them: not by moving
//! vertices of a crack afterwards, but by bending the faces between all cells from the start, so that the line
//! along which a crack meets the outside is bent as well and nothing has to be made to fit.

mod bricks;
mod clip;
mod error;
mod facets;
mod follow;
mod grid;
mod pieces;
mod polygon;
mod split;
mod wall;

#[cfg(test)]
mod tests;

use fissure_engine::lattice::{Cells, MOST_CELLS};
use glam::DVec3;

use crate::TriMesh;
use crate::surface::unpaired;
use clip::Clipped;
pub use error::LatticeError;
use facets::Facet;
pub use facets::{Facets, Patchwork};
pub use follow::Follower;
use grid::Grid;
use pieces::Pieces;
use wall::{Tangled, walls};

/// How faces between cells look when they open (Ohta et al., Fig. 4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CrackFaces {
    /// Whole squares, outside as within: the lattice itself.
    Raw,
    /// Plane, and ending where the surface does.
    Fitted,
    /// The same with bent faces.
    Noisy(Noise),
}

/// Perlin noise that bends the faces between cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// How far faces are bent, in cells: at most this far along each axis, a quarter of it in the mean.
    pub amplitude: f64,
    /// Size of the bumps in cells, [`Noise::LEAST_SCALE`] or more for each cell of amplitude.
    pub scale: f64,
    /// Which of many.
    pub seed: u64,
}

impl Noise {
    /// Scale over amplitude below which faces might fold.
    pub const LEAST_SCALE: f64 = 4.0;
    const NONE: Self = Self { amplitude: 0.0, scale: 1.0, seed: 0 };

    /// Whether it might fold cells.
    pub fn bends_too_far(&self) -> bool {
        self.amplitude * Self::LEAST_SCALE > self.scale
    }
}

impl Default for Noise {
    fn default() -> Self {
        Self { amplitude: 0.7, scale: 2.8, seed: 1 }
    }
}

/// What lattice to make of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Edge of a cell [m], above 0.
    pub size: f64,
    /// What cracks look like.
    pub faces: CrackFaces,
    /// Memory that making it may take [MiB].
    pub memory: u64,
}

impl Options {
    /// Cells of `size` [m], default noise, 4 GiB.
    pub fn new(size: f64) -> Self {
        Self { size, faces: CrackFaces::Noisy(Noise::default()), memory: 4096 }
    }
}

/// A body made of cells.
#[derive(Debug)]
pub struct Lattice {
    /// The cells with their links.
    pub cells: Cells,
    /// Centre of mass of what each cell holds [m].
    pub points: Vec<DVec3>,
    /// Volume of it [m³].
    pub volumes: Vec<f64>,
    /// The surface and the faces between cells.
    pub facets: Facets,
    /// What makes the surface follow the nodes.
    pub follower: Follower,
    /// Warnings, one sentence each.
    pub notes: Vec<String>,
}

/// Bytes that one cell takes while a lattice is made, surface included (measured: a run with 1e5 cells of a bunny, 560 MB).
const BYTES_PER_CELL: f64 = 6000.0;

/// The cell edge [m] that gives about `cells` cells for a surface.
pub fn size_for(surface: &TriMesh, cells: u64) -> f64 {
    let (volume, area) = (surface.volume().abs(), surface.area());
    // of the cells that the surface cuts half are beyond the volume, but for slivers
    let count = |size: f64| volume / size.powi(3) + 0.6 * area / size.powi(2);
    let (mut low, mut high) = (1e-12, 1.0);
    while count(high) > cells as f64 {
        (low, high) = (high, 2.0 * high);
    }
    for _ in 0..200 {
        let middle = (low * high).sqrt();
        if count(middle) > cells as f64 { low = middle } else { high = middle }
    }
    high
}

/// Fills a closed surface, wound outwards, with cells.
///
/// # Errors
/// See [`LatticeError`].
pub fn lattice(surface: &TriMesh, options: &Options) -> Result<Lattice, LatticeError> {
    let noise = match options.faces {
        CrackFaces::Noisy(noise) => noise,
        CrackFaces::Raw | CrackFaces::Fitted => Noise::NONE,
    };
    let (low, high) = check(surface, options, noise)?;
    let size = options.size;
    // where a body is a whole number of cells long, its cells are whole
    let counts = ((high - low) / size - 1e-6).ceil().max(DVec3::ONE);
    let margin = if noise.amplitude > 0.0 { noise.amplitude.ceil() + 1.0 } else { 0.0 };
    let origin = (low + high) / 2.0 - counts * (0.5 * size) - DVec3::splat(margin * size);
    // Where the surface runs through corners of the grid to the last bit, rounding may see it on both sides; then the
    // grid is shifted a little.
    const SHIFTS: [f64; 4] = [0.0, 0.013, 0.031, 0.047];
    let mut tangled = Tangled(low);
    for shift in SHIFTS {
        let around = if shift > 0.0 { 1.0 } else { 0.0 };
        let shift = DVec3::new(1.0, 0.7, 0.4) * shift - around;
        let grid = Grid { origin: origin + shift * size, size, noise };
        match on_grid(surface, grid, options) {
            Ok(lattice) if lattice.cells.len() > 1 => return Ok(lattice),
            Ok(lattice) => return Err(coarse(surface, size, (high - low).max_element(), lattice.cells.len())),
            Err(fault) => tangled = fault,
        }
    }
    Err(LatticeError::Tangled { at: tangled.0 })
}

fn coarse(surface: &TriMesh, size: f64, extent: f64, cells: usize) -> LatticeError {
    LatticeError::Coarse { size, extent, cells, advice: size_for(surface, 1000) }
}

fn on_grid(surface: &TriMesh, grid: Grid, options: &Options) -> Result<Lattice, Tangled> {
    // bends are followed by short edges, a bent body by edges no longer than a cell
    let longest = if grid.noise.amplitude > 0.0 { 0.5 } else { 1.0 } * grid.size;
    let mut clipped = Clipped::new(surface, grid, longest);
    let walls = walls(&mut clipped, grid)?;
    let pieces = Pieces::new(&clipped, &walls, grid);
    let facets = if options.faces == CrackFaces::Raw {
        bricks::bricks(&pieces, &pieces.of_wall, grid)
    } else {
        facets(surface, clipped, walls, &pieces)
    };
    let mut notes = Vec::new();
    if pieces.crowded > 0 {
        notes.push(format!(
            "{} of the body with another part of it in the same cell of {:.3e} m and no node of their own: they follow their \
             neighbours, smaller cells would part them.",
            crate::surface::counted(pieces.crowded, "part"),
            grid.size
        ));
    }
    let follower = Follower::new(&pieces.cells);
    Ok(Lattice { cells: pieces.cells, follower, points: pieces.points, volumes: pieces.volumes, facets, notes })
}

/// The triangles outside, and those of walls between different cells.
fn facets(surface: &TriMesh, clipped: Clipped, walls: Vec<wall::Wall>, pieces: &Pieces) -> Facets {
    let x = &clipped.points.x;
    let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).normalize_or_zero();
    let outside = (0..clipped.triangles.len()).map(|t| Facet {
        corners: clipped.triangles[t],
        front: pieces.of_triangle[t],
        back: None,
        normal: normal(surface.corners(clipped.parent[t] as usize)),
    });
    let between = walls.iter().zip(&pieces.of_wall).filter(|(_, [low, high])| low != high);
    let inside = between.flat_map(|(wall, &[low, high])| {
        wall.triangles.iter().map(move |&corners| Facet {
            corners,
            front: low,
            back: Some(high),
            normal: normal(corners.map(|v| x[v as usize])),
        })
    });
    let all = outside.chain(inside).collect();
    Facets::new(clipped.points.x, all)
}

/// What can be told before anything is cut: bounds of the body [m].
fn check(surface: &TriMesh, options: &Options, noise: Noise) -> Result<(DVec3, DVec3), LatticeError> {
    let size = options.size;
    if !(size > 0.0 && size.is_finite()) {
        return Err(LatticeError::Number { what: "the cell size", value: size });
    }
    let positive = noise.amplitude >= 0.0 && noise.amplitude.is_finite() && noise.scale > 0.0;
    if !positive || noise.bends_too_far() {
        let Noise { amplitude, scale, .. } = noise;
        return Err(LatticeError::Folded { amplitude, scale, most: scale / Noise::LEAST_SCALE });
    }
    let Some((low, high)) = surface.bounds().filter(|_| !surface.triangles.is_empty()) else {
        return Err(LatticeError::Empty);
    };
    if let (edges @ 1.., at) = unpaired(surface) {
        return Err(LatticeError::Open { edges, at });
    }
    let volume = surface.volume();
    if volume <= 0.0 {
        return Err(LatticeError::InsideOut { volume });
    }
    let extent = (high - low).max_element();
    if size >= extent {
        return Err(coarse(surface, size, extent, 1));
    }
    let cells = volume / size.powi(3) + surface.area() / size.powi(2);
    let needed = cells * BYTES_PER_CELL / f64::from(1 << 20);
    let given = options.memory;
    if needed > given as f64 || extent / size > f64::from(MOST_CELLS / 4) {
        let fitting = (given as f64 * f64::from(1 << 20) / BYTES_PER_CELL).max(1.0);
        let advice = size_for(surface, fitting as u64).max(8.0 * extent / f64::from(MOST_CELLS));
        return Err(LatticeError::Memory { size, cells, needed, given, advice });
    }
    Ok((low, high))
}
