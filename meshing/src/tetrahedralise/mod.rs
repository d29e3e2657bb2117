//! Tetrahedra from a closed surface, or from a wall of given thickness around any surface.
//!
//! An irregular periodic background (`tile`) is cut at the surface (`stuff`), its angles are raised (`improve`) and
//! what lies too far from the surface is pulled there (`fit`). Where that misses a promise, thin places get smaller elements
//! (`refine`), then all places do ([`ATTEMPTS`]), and the report says so. Deterministic: the same bits on any number of threads.

mod complex;
mod features;
mod fit;
mod improve;
mod manifold;
mod refine;
mod shave;
mod smooth;
mod solid;
mod stuff;
mod thin;
mod tile;

#[cfg(test)]
pub(crate) mod bodies;

pub use features::Features;
pub use solid::{Inside, Shell, Solid};

use crate::quality::Report;
use crate::{TetMesh, TriMesh};
use glam::DVec3;
use improve::Body;
use smooth::Random;
use thiserror::Error;
use tile::Tile;

/// What to make of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Wanted mean edge length [m].
    pub size: f64,
    /// Which of many equally good irregular meshes.
    pub seed: u64,
    /// Thickness [m] of a wall around the surface; without it the surface is filled and must be closed.
    pub shell: Option<f64>,
}

impl Options {
    /// Elements of `size` [m], seed 0, filled.
    pub fn new(size: f64) -> Self {
        Self { size, seed: 0, shell: None }
    }
}

/// Why there is no mesh.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MeshError {
    /// No triangles.
    #[error("the surface has no triangles: nothing can be filled")]
    Empty,
    /// A coordinate or an option is not a finite number, or an option is not positive.
    #[error("{0} is not a positive, finite number")]
    Number(String),
    /// A vertex is not finite.
    #[error("vertex {vertex} of the surface is not finite: repair the file that it came from")]
    Vertex {
        /// The vertex.
        vertex: usize,
    },
    /// A triangle names a vertex that isn't there.
    #[error("triangle {triangle} names a vertex that the surface does not have")]
    Index {
        /// The triangle.
        triangle: usize,
    },
    /// An edge without a partner.
    #[error(
        "the surface is not closed: edge {a}-{b} near {at} has {forward} triangles one way and {backward} the other; repair the surface, or give it a thickness with `shell`"
    )]
    Open {
        /// One end of the edge.
        a: u32,
        /// The other end.
        b: u32,
        /// Its middle [m].
        at: DVec3,
        /// Triangles that run from `a` to `b`.
        forward: usize,
        /// Triangles that run from `b` to `a`.
        backward: usize,
    },
    /// The surface encloses nothing.
    #[error(
        "the surface encloses a volume of {volume:.3e} m³: its triangles are wound inwards or it is flat; turn them round"
    )]
    InsideOut {
        /// Its signed volume [m³].
        volume: f64,
    },
    /// No element fits.
    #[error("elements of {size} m are too large for this body: none fits; try {advice:.3e} m")]
    TooCoarse {
        /// The wanted size [m].
        size: f64,
        /// A size that should fit [m].
        advice: f64,
    },
    /// The wall is far thinner than the elements.
    #[error(
        "a shell of {thickness} m is too thin for elements of {size} m: use elements of {advice:.3e} m or a thicker shell"
    )]
    ThinShell {
        /// Its thickness [m].
        thickness: f64,
        /// The wanted size [m].
        size: f64,
        /// A size that fits [m].
        advice: f64,
    },
    /// Flat elements that nothing could mend.
    #[error(
        "with elements of {size} m the smallest dihedral angle stays at {angle:.2} degrees, below 10; try {advice:.3e} m or another seed"
    )]
    Flat {
        /// The wanted size [m].
        size: f64,
        /// The smallest angle [degrees].
        angle: f64,
        /// A size to try [m].
        advice: f64,
    },
    /// Too many elements for any memory.
    #[error("elements of {size} m would give about {tets:.1e} tetrahedra, more than fit in memory; try {advice:.3e} m")]
    TooFine {
        /// The wanted size [m].
        size: f64,
        /// Estimated number of tetrahedra.
        tets: f64,
        /// A size that gives about a million [m].
        advice: f64,
    },
}

/// Cells per side of the background tile.
const TILE: usize = 8;
/// Background edge length per wanted mean edge length.
const EDGE: f64 = 1.02;
/// More background vertices than this are refused.
const MOST_POINTS: f64 = 2e8;
/// Every dihedral angle is at least this [degrees].
pub const MIN_DIHEDRAL: f64 = 10.0;
/// What improvement aims at [degrees].
const AIM: f64 = 16.0;

/// Fills `surface` with tetrahedra whose mean edge is close to `options.size`; see the module.
///
/// # Errors
/// [`MeshError`]: bad numbers, an open surface without `shell`, a size that doesn't suit the body.
pub fn tetrahedralise(surface: &TriMesh, options: &Options) -> Result<(TetMesh, Report), MeshError> {
    check(surface, options)?;
    match options.shell {
        Some(thickness) => shell(surface, thickness, options),
        None => fill(&Inside::new(surface, options.size), options),
    }
}

/// A wall, with elements small enough that at least [`LAYERS`] of them fit into it.
fn shell(surface: &TriMesh, thickness: f64, options: &Options) -> Result<(TetMesh, Report), MeshError> {
    let (size, fitting) = (options.size, thickness / LAYERS);
    if size > MOST_REFINED * fitting {
        return Err(MeshError::ThinShell { thickness, size, advice: fitting });
    }
    let solid = Shell::new(surface, thickness);
    let (mesh, mut report) = fill(&solid, &Options { size: size.min(fitting), ..options.clone() })?;
    if size > fitting {
        report.warnings.insert(
            0,
            format!("a wall of {thickness} m needs elements of {fitting:.3e} m: these were used instead of {size} m"),
        );
    }
    Ok((mesh, report))
}

/// Elements through the thickness of a shell. With fewer, pits and holes appear (a ball's shell: none at
/// 2.0, some at 1.7).
const LAYERS: f64 = 2.0;
/// A shell's elements are made smaller by at most this factor without being asked.
const MOST_REFINED: f64 = 2.5;

/// The same for any solid known by its signed distance; `options.shell` is not used.
///
/// # Errors
/// As [`tetrahedralise`].
pub fn fill(solid: &dyn Solid, options: &Options) -> Result<(TetMesh, Report), MeshError> {
    let size = options.size;
    let tile = Tile::new(TILE, options.seed);
    let edge = size * EDGE;
    if stuff::background_points(solid, &tile, edge) > MOST_POINTS {
        let (lo, hi) = solid.bounds();
        let d = hi - lo;
        let volume = solid.volume().unwrap_or(d.element_product()).abs();
        let area = 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x);
        let (tets, advice) = (tets_from(volume, area, size), size_from(volume, area, 1e6));
        return Err(MeshError::TooFine { size, tets, advice });
    }
    let mut best: Option<(TetMesh, Report)> = None;
    let mut attempt = 0;
    while let Some(try_) = ATTEMPTS.get(attempt) {
        let mut random = Random::of(options.seed, 100 + attempt as u64);
        let shift = DVec3::new(random.unit(), random.unit(), random.unit());
        let mesh = once(solid, &tile, size * try_.part, shift, try_.growth, options.seed ^ ((attempt as u64) << 48));
        attempt += 1;
        if mesh.tets.is_empty() {
            continue;
        }
        let mut report = Report::against(&mesh, solid, size);
        try_.tell(&mut report);
        warn(&mut report, solid);
        let (flaw, torn) = (flaw(&report, solid), tears(&report, solid));
        if best.as_ref().is_none_or(|b| flaw < self::flaw(&b.1, solid)) {
            best = Some((mesh, report));
        }
        if flaw == 0.0 {
            break;
        }
        if torn > HOPELESS {
            attempt = attempt.max(ATTEMPTS.len() - 1);
        }
    }
    // what keeps less than a quarter of the body is no mesh of it
    let (mesh, report) = best.filter(|b| b.1.volume_ratio.is_none_or(|v| v > 0.25)).ok_or_else(|| {
        let (lo, hi) = solid.bounds();
        let flat = (hi - lo).min_element() / 2.0;
        let thin = thin::typical(solid, size.min(flat)).map_or(flat, |radius| flat.min(2.0 * radius / LAYERS));
        MeshError::TooCoarse { size, advice: thin }
    })?;
    if report.min_dihedral < MIN_DIHEDRAL {
        return Err(MeshError::Flat { size, angle: report.min_dihedral, advice: 0.8 * size });
    }
    Ok((mesh, report))
}

/// One way to go about it, tried when those before it missed a promise.
struct Attempt {
    /// Element size as a part of the asked one.
    part: f64,
    /// Thin places may raise the number of tetrahedra by this factor; 1 for even elements.
    growth: f64,
}

/// All of them; each also shifts the background.
const ATTEMPTS: [Attempt; 6] = [
    Attempt { part: 1.0, growth: 1.0 },
    Attempt { part: 1.0, growth: 1.0 },
    Attempt { part: 1.0, growth: 1.3 },
    Attempt { part: 1.0, growth: 1.6 },
    Attempt { part: 0.9, growth: 1.5 },
    Attempt { part: 0.8, growth: 1.3 },
];
/// With more tears than this, only the last attempt is worth the time.
const HOPELESS: i64 = 8;
/// Promised largest distance between surface and boundary, in element sizes.
pub const MAX_DEVIATION: f64 = 0.35;

impl Attempt {
    /// Says which elements were used, if not those asked for.
    fn tell(&self, report: &mut Report) {
        let size = report.size;
        if self.part < 1.0 {
            report.warnings.push(format!(
                "elements of {:.3e} m instead of {size:.3e} m, because larger ones missed a promise: thin parts would have been lost, opened or joined",
                self.part * size
            ));
        } else if self.growth > 1.0 {
            report.warnings.push(format!(
                "elements of {size:.3e} m were made smaller where the body or a gap is thin, because larger ones missed a promise there"
            ));
        }
    }
}

/// By how much the boundary's Euler characteristic differs from the surface's.
fn tears(report: &Report, solid: &dyn Solid) -> i64 {
    solid.euler().map_or(0, |wanted| (wanted - report.euler).abs())
}

/// By how much a mesh misses the promises; 0 if it keeps them. Angles come first, then distance, then holes.
fn flaw(report: &Report, solid: &dyn Solid) -> f64 {
    let far = (report.hausdorff().sizes - MAX_DEVIATION).max(0.0);
    100.0 * (MIN_DIHEDRAL - report.min_dihedral).max(0.0) + far + 0.05 * tears(report, solid) as f64
}

/// Says in words which promises were missed, where, and what would help.
fn warn(report: &mut Report, solid: &dyn Solid) {
    let size = report.size;
    let (lost, spare) = (report.surface_to_mesh, report.mesh_to_surface);
    for (far, what) in [(lost, "a part of the surface was lost"), (spare, "the mesh's boundary leaves the surface")] {
        if far.sizes > MAX_DEVIATION {
            let fitting = size * MAX_DEVIATION / far.sizes;
            let thin = thin::thinnest(solid, far.at, size).map_or(fitting, |radius| 3.0 * radius);
            report.warnings.push(format!(
                "{what} near [{:.4}, {:.4}, {:.4}]: they are {:.2} element sizes apart; elements of {:.3e} m would keep it",
                far.at.x, far.at.y, far.at.z, far.sizes, thin.min(0.8 * size)
            ));
        }
    }
    if let Some(wanted) = solid.euler()
        && wanted != report.euler
    {
        report.warnings.push(format!(
            "the boundary has Euler characteristic {} and the surface {wanted}: parts nearer than an element were joined, thin ones opened, or the surface overlaps itself; smaller elements may help",
            report.euler
        ));
    }
}

/// One attempt.
fn once(solid: &dyn Solid, tile: &Tile, size: f64, shift: DVec3, growth: f64, seed: u64) -> TetMesh {
    let filled = stuff::fill(solid, tile, size * EDGE, shift, growth, seed);
    let mut body = Body { mesh: filled.mesh, dim: filled.dim, solid, size, slack: 0.0, floor: 11.0 };
    body.settle();
    body.unpinch(true);
    body.improve(AIM, 8, seed);
    body.fit(seed);
    body.unpinch(false);
    body.improve(AIM, 8, seed ^ 1);
    body.slack = 0.15;
    body.improve(MIN_DIHEDRAL + 1.0, 12, seed ^ 2);
    body.unpinch(false);
    body.shave(MIN_DIHEDRAL + 0.2, seed ^ 3);
    body.finish()
}

/// Tetrahedra per cubed element size of volume, and per squared element size of surface; measured on boxes and scans,
/// within 7 %.
const PER_VOLUME: f64 = 10.2;
const PER_AREA: f64 = 3.2;

/// An element size [m] that gives about `tets` tetrahedra in a closed surface; NaN if it has neither volume nor area.
pub fn size_for(surface: &TriMesh, tets: usize) -> f64 {
    size_from(surface.volume().abs(), surface.area(), tets.max(1) as f64)
}

/// An element size [m] that gives about `tets` tetrahedra in a wall of `thickness` [m] around `surface`.
pub fn shell_size_for(surface: &TriMesh, thickness: f64, tets: usize) -> f64 {
    let area = surface.area();
    size_from(area * thickness, 2.0 * area, tets.max(1) as f64)
}

fn tets_from(volume: f64, area: f64, size: f64) -> f64 {
    PER_VOLUME * volume / size.powi(3) + PER_AREA * area / size.powi(2)
}

/// Inverts [`tets_from`] by halving intervals: it falls with size.
fn size_from(volume: f64, area: f64, tets: f64) -> f64 {
    let alone = (PER_VOLUME * volume / tets).cbrt().max((PER_AREA * area / tets).sqrt());
    if alone <= 0.0 || !alone.is_finite() {
        return f64::NAN;
    }
    let (mut low, mut high) = (alone, 4.0 * alone);
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if tets_from(volume, area, middle) > tets { low = middle } else { high = middle }
    }
    high
}

/// Cheap checks: numbers, indices, closedness.
fn check(surface: &TriMesh, options: &Options) -> Result<(), MeshError> {
    if surface.triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    let positive = |x: f64| x.is_finite() && x > 0.0;
    if !positive(options.size) {
        return Err(MeshError::Number(format!("the element size {}", options.size)));
    }
    if let Some(t) = options.shell.filter(|&t| !positive(t)) {
        return Err(MeshError::Number(format!("the shell thickness {t}")));
    }
    if let Some(vertex) = surface.vertices.iter().position(|v| !v.is_finite()) {
        return Err(MeshError::Vertex { vertex });
    }
    let count = surface.vertices.len() as u32;
    if let Some(triangle) = surface.triangles.iter().position(|t| t.iter().any(|&v| v >= count)) {
        return Err(MeshError::Index { triangle });
    }
    if options.shell.is_some() {
        return Ok(());
    }
    for same in features::edges(surface).chunk_by(|x, y| x.0 == y.0) {
        let forward = same.iter().filter(|e| e.2).count();
        let backward = same.len() - forward;
        if forward != backward {
            let [a, b] = same[0].0;
            let at = (surface.vertices[a as usize] + surface.vertices[b as usize]) / 2.0;
            return Err(MeshError::Open { a, b, at, forward, backward });
        }
    }
    let volume = surface.volume();
    if volume <= 0.0 {
        return Err(MeshError::InsideOut { volume });
    }
    Ok(())
}

#[cfg(test)]
mod planes;
#[cfg(test)]
mod sweep;
#[cfg(test)]
mod tests;
