//! Families: which particles lie within the horizon of which. CSR rows from a k-d tree, clipped by the mesh.
//!
//! Both directions of a bond are stored and rows are exactly symmetric: the tree answers for a slightly larger ball,
//! and a pair near the horizon is decided by |x_j − x_i|² ≤ δ² in f64, the same bits from both ends. (A tree over
//! f32 points gave one-sided bonds on lattices whose spacing divides the horizon.)
//!
//! Rows are built in waves of fixed blocks: the blocks of a wave in parallel, each into a vector of its own, which
//! are then appended in order. So the result is the same on any number of threads, and the peak is the result plus
//! one wave. Two passes, one that counts and one that fills, need no wave but twice the time.

mod clip;
mod triangle;

pub use clip::Clip;

use glam::DVec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;
use thiserror::Error;

/// Particles per block.
const BLOCK: usize = 512;
/// Squared radii differ by this factor between what the tree is asked for, δ², and what is taken without a check.
const MARGIN: f64 = 1e-9;

/// Neighbour lists of all particles: row `i` is `neighbours[offsets[i]..offsets[i + 1]]`, ascending, without `i`
/// itself. If `j` is in row `i` then `i` is in row `j`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Families {
    /// Start of each row, and the end of the last: one number more than particles.
    pub offsets: Vec<u32>,
    /// Particle numbers.
    pub neighbours: Vec<u32>,
    /// How many directed bonds the clip took away.
    pub clipped: usize,
}

impl Families {
    /// The family of particle `i`.
    pub fn row(&self, i: usize) -> &[u32] {
        &self.neighbours[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there are no particles.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Why families, or the clip for them, could not be built.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FamilyError {
    /// A coordinate is infinite or not a number.
    #[error("particle {index} has the position {position}; mend the mesh so that every coordinate is a finite number")]
    NotFinite {
        /// The particle.
        index: usize,
        /// Where it is said to be [m].
        position: DVec3,
    },
    /// The horizon is zero, negative or not a number.
    #[error("the horizon is {0} m; give a positive, finite length, for example 1.4 times the mean edge length")]
    BadHorizon(f64),
    /// Some particles have no other within the horizon.
    #[error(
        "{count} of {particles} particles have no neighbour within the horizon of {horizon:.4e} m, the first is particle \
         {first}; the nearest particle is up to {spacing:.4e} m away, so use a horizon well above that"
    )]
    Isolated {
        /// How many.
        count: usize,
        /// Of how many.
        particles: usize,
        /// The first of them.
        first: usize,
        /// The horizon [m].
        horizon: f64,
        /// Largest distance of an isolated particle to its nearest neighbour [m]; infinite for a single particle.
        spacing: f64,
    },
    /// Row offsets are 32-bit numbers.
    #[error(
        "{0} directed bonds or more are too many, the limit is 4294967295; use a smaller horizon or fewer particles"
    )]
    TooMany(usize),
    /// Points and tetrahedra differ in number.
    #[error(
        "{points} particles but {tets} tetrahedra to clip by; give one particle per tetrahedron, at its barycentre"
    )]
    OtherMesh {
        /// Number of particles.
        points: usize,
        /// Number of tetrahedra.
        tets: usize,
    },
    /// A face of more than two tetrahedra.
    #[error(
        "more than two tetrahedra share the face of vertices {0:?}; mend the mesh so that every face has at most two"
    )]
    CrowdedFace([u32; 3]),
    /// A tetrahedron or cut names a vertex that does not exist.
    #[error("{what} {index} names vertex {vertex}, but there are only {vertices} vertices; mend the mesh")]
    NoVertex {
        /// "tetrahedron" or "cut triangle".
        what: &'static str,
        /// Which one.
        index: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// A corner of a pre-cut is infinite or not a number.
    #[error("vertex {index} of the pre-cut has the position {position}; every coordinate must be a finite number")]
    CutNotFinite {
        /// The vertex of the cut mesh.
        index: usize,
        /// Where it is said to be [m].
        position: DVec3,
    },
    /// The k-d tree refused the points.
    #[error("the k-d tree over the particles could not be built: {0}")]
    Tree(String),
}

/// The k-d tree of this module.
type Tree = ImmutableKdTree<f64, 3>;

/// Particles within `radius` of `center`, with squared distances: all of them, and perhaps some a rounding farther.
fn visit_ball(tree: &Tree, center: DVec3, radius: f64, mut visit: impl FnMut(u32, f64)) {
    let reach = radius * radius * (1.0 + MARGIN);
    tree.query(&center.to_array())
        .within::<SquaredEuclidean<f64>>(reach)
        .unsorted()
        .visit(|found| visit(found.item, found.distance));
}

fn build_tree(points: &[DVec3]) -> Result<Tree, FamilyError> {
    if let Some(index) = points.iter().position(|p| !p.is_finite()) {
        return Err(FamilyError::NotFinite { index, position: points[index] });
    }
    let arrays: Vec<[f64; 3]> = points.iter().map(|p| p.to_array()).collect();
    Tree::new_from_slice(&arrays).map_err(|e| FamilyError::Tree(e.to_string()))
}

/// One block of rows, end to end.
struct Block {
    /// Row lengths.
    lengths: Vec<u32>,
    neighbours: Vec<u32>,
    clipped: usize,
    /// Particles with nobody within the horizon.
    isolated: Vec<u32>,
}

/// Finds every particle's family within `horizon` [m] of `points` [m]; with a `clip`, points are the barycentres of
/// its tetrahedra and bonds that cross a gap or a pre-cut are left out. Order the points along a curve first
/// ([`crate::order::morton_order`]): it makes this and every later pass over bonds faster.
///
/// # Errors
/// Non-finite points, a horizon that is not positive, particles alone within the horizon (those that only the clip
/// left alone are no error: they are dust), more bonds than 32-bit offsets can count, a clip of another mesh.
pub fn families(points: &[DVec3], horizon: f64, clip: Option<&Clip>) -> Result<Families, FamilyError> {
    if !(horizon > 0.0 && horizon.is_finite() && (horizon * horizon).is_normal()) {
        return Err(FamilyError::BadHorizon(horizon));
    }
    if points.is_empty() {
        return Ok(Families { offsets: vec![0], ..Families::default() });
    }
    let tree = build_tree(points)?;
    let clip = clip.map(|c| c.prepare(&tree, points, horizon)).transpose()?;
    let sure = horizon * horizon * (1.0 - MARGIN);
    let rows = |block: usize, room: usize| -> Block {
        let range = block * BLOCK..points.len().min((block + 1) * BLOCK);
        let (mut lengths, mut neighbours) = (Vec::with_capacity(range.len()), Vec::with_capacity(room));
        let (mut isolated, mut clipped) = (Vec::new(), 0);
        for i in range {
            let start = neighbours.len();
            let mut found = 0;
            visit_ball(&tree, points[i], horizon, |j, d2| {
                // The tree may sum the squares in another order for the two ends of a bond; our sum is symmetric.
                let near = d2 <= sure || points[j as usize].distance_squared(points[i]) <= horizon * horizon;
                if near && j as usize != i {
                    found += 1;
                    if clip.as_ref().is_none_or(|c| c.keeps(i, j as usize)) {
                        neighbours.push(j);
                    }
                }
            });
            neighbours[start..].sort_unstable();
            lengths.push((neighbours.len() - start) as u32);
            clipped += found - (neighbours.len() - start);
            if found == 0 {
                isolated.push(i as u32);
            }
        }
        Block { lengths, neighbours, clipped, isolated }
    };

    let blocks = points.len().div_ceil(BLOCK);
    let wave = 32.max(4 * rayon::current_num_threads());
    let mut all = Families { offsets: Vec::with_capacity(points.len() + 1), ..Families::default() };
    all.offsets.push(0);
    let (mut isolated, mut room) = (Vec::new(), 0);
    for first in (0..blocks).step_by(wave) {
        let built: Vec<Block> = (first..blocks.min(first + wave)).into_par_iter().map(|b| rows(b, room)).collect();
        let total = all.neighbours.len() + built.iter().map(|b| b.neighbours.len()).sum::<usize>();
        if total > u32::MAX as usize {
            return Err(FamilyError::TooMany(total));
        }
        if total > all.neighbours.capacity() {
            // Room for all particles at the mean so far, and a little more: memory not yet written costs nothing.
            let done = points.len().min((first + built.len()) * BLOCK);
            let guess = (1.05 * total as f64 * points.len() as f64 / done as f64) as usize;
            all.neighbours.reserve_exact(guess.max(total) - all.neighbours.len());
        }
        room = built.iter().map(|b| b.neighbours.len()).max().unwrap_or(0);
        for block in built {
            let mut end = all.neighbours.len() as u32;
            all.offsets.extend(block.lengths.iter().map(|n| {
                end += n;
                end
            }));
            all.neighbours.extend_from_slice(&block.neighbours);
            all.clipped += block.clipped;
            isolated.extend_from_slice(&block.isolated);
        }
    }
    if let Some(&first) = isolated.first() {
        let spacing = |&i: &u32| nearest(&tree, points, i as usize);
        return Err(FamilyError::Isolated {
            count: isolated.len(),
            particles: points.len(),
            first: first as usize,
            horizon,
            spacing: isolated.par_iter().map(spacing).reduce(|| 0.0, f64::max),
        });
    }
    all.neighbours.shrink_to_fit();
    Ok(all)
}

/// Distance from particle `i` to the nearest other one [m].
fn nearest(tree: &Tree, points: &[DVec3], i: usize) -> f64 {
    let two = std::num::NonZeroUsize::new(2).expect("2 is not 0");
    let found = tree.query(&points[i].to_array()).nearest_n::<SquaredEuclidean<f64>>(two).execute();
    let other = found.iter().filter(|f| f.item as usize != i).map(|f| f.distance);
    other.fold(f64::INFINITY, f64::min).sqrt()
}

#[cfg(test)]
pub(crate) mod tests;
