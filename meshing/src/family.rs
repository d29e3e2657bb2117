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
mod error;
mod near;
mod triangle;

pub use clip::Clip;
pub use error::FamilyError;

use fissure_engine::Families;
use glam::DVec3;
use rayon::prelude::*;

use near::{build_tree, nearest, visit_ball};

/// Particles per block.
const BLOCK: usize = 512;
/// Squared radii differ by this factor between what the tree is asked for, δ², and what is taken without a check.
const MARGIN: f64 = 1e-9;

/// One block of rows, end to end.
struct Block {
    /// Row lengths.
    lengths: Vec<u32>,
    neighbours: Vec<u32>,
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
        let mut isolated = Vec::new();
        for i in range {
            let start = neighbours.len();
            let mut any = false;
            visit_ball(&tree, points[i], horizon, |j, d2| {
                // The tree may sum the squares in another order for the two ends of a bond; our sum is symmetric.
                let near = d2 <= sure || points[j as usize].distance_squared(points[i]) <= horizon * horizon;
                if near && j as usize != i {
                    any = true;
                    if clip.as_ref().is_none_or(|c| c.keeps(i, j as usize)) {
                        neighbours.push(j);
                    }
                }
            });
            neighbours[start..].sort_unstable();
            lengths.push((neighbours.len() - start) as u32);
            if !any {
                isolated.push(i as u32);
            }
        }
        Block { lengths, neighbours, isolated }
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

#[cfg(test)]
pub(crate) mod tests;
