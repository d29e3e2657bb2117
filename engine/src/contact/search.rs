//! Makes rows of neighbours: for every cell once, who is near it; for every member then who of those is in reach and not
//! bonded to it, eight at a time.

use std::ops::Range;

use glam::Vec3;
use wide::f32x8;

use super::grid::Grid;
use super::neighbours::{Block, Entry, NONE};
use super::{Scene, Still};
use crate::bonds::CHUNK;
use crate::world::Body;

/// Candidates that are measured at once.
const WIDE: usize = 8;
/// Rows are measured in f32; no pair in reach may be lost by that.
pub const MARGIN: f64 = 1.0 + 1e-5;

/// Distance [m] at which two particles of one body touch.
#[inline]
pub fn touch(rest: &[Vec3], still: &Still, i: usize, j: usize) -> f32 {
    let rest = rest[i].distance(rest[j]);
    // rounded down, so that nothing pushes at rest
    (still.radius[i] as f32 + still.radius[j] as f32).min(rest * (1.0 - 1e-6))
}

/// What making rows reads of the members.
pub struct Members<'a> {
    pub members: &'a [u32],
    pub body: &'a [u32],
    /// Place relative to the middle of all, and reach with what rounding the place may take [m].
    pub spots: &'a [[f32; 4]],
}

/// What one thread needs to make rows.
#[derive(Debug, Default)]
pub struct Scratch {
    /// Candidates near a cell: their spots, axis by axis, padded to eights.
    place: [Vec<f32>; 4],
    /// Their members.
    who: Vec<u32>,
    /// Of each particle, the last row in which it was seen bonded.
    seen: Vec<u32>,
    row: u32,
}

impl Scratch {
    /// Room for `n` particles.
    pub fn new(n: usize) -> Self {
        let room = || Vec::with_capacity(n.next_multiple_of(WIDE));
        let place = [room(), room(), room(), room()];
        Self { place, who: Vec::with_capacity(n.next_multiple_of(WIDE)), seen: vec![0; n], row: 0 }
    }

    /// Collects what may touch the balls of `cell`.
    fn gather(&mut self, grid: &Grid, cell: usize, members: &Members<'_>) {
        let Self { place, who, .. } = self;
        place.iter_mut().for_each(Vec::clear);
        who.clear();
        grid.near(cell, |balls| {
            let spots = &members.spots[balls.clone()];
            place.iter_mut().enumerate().for_each(|(axis, place)| place.extend(spots.iter().map(|s| s[axis])));
            who.extend(balls.start as u32..balls.end as u32);
        });
        let full = who.len().next_multiple_of(WIDE);
        // not a number: near nobody, also where a damaged file gives somebody an infinite reach
        place.iter_mut().for_each(|p| p.resize(full, f32::NAN));
        place[3][who.len()..].fill(0.0);
        who.resize(full, NONE);
    }

    /// Remembers whom a bond holds to particle `i`, and that one itself.
    pub fn see(&mut self, b: &Body, i: usize) {
        self.row = self.row.checked_add(1).unwrap_or_else(|| {
            self.seen.fill(0);
            1
        });
        self.seen[i] = self.row;
        let Some(bonds) = b.material.bonds() else { return };
        let chunks = bonds.chunks(i - b.range.start);
        let seen = &mut self.seen[b.range.clone()];
        let neighbours = bonds.neighbours[chunks.start * CHUNK..chunks.end * CHUNK].as_chunks::<CHUNK>().0;
        for (&intact, row) in bonds.intact[chunks].iter().zip(neighbours) {
            let mut bits = intact;
            while bits != 0 {
                seen[row[bits.trailing_zeros() as usize % CHUNK] as usize] = self.row;
                bits &= bits - 1;
            }
        }
    }

    /// Whether a bond holds particle `other` to the one that was last [seen](Self::see).
    #[inline]
    fn saw(&self, other: usize) -> bool {
        self.seen[other] == self.row
    }

    /// Whether a bond of body `b` holds particle `other` to `i`, which was last [seen](Self::see); without bonds, whether they
    /// are of one piece.
    #[inline]
    pub fn holds(&self, b: &Body, still: &Still, i: usize, other: usize) -> bool {
        if b.material.bonds().is_some() { self.saw(other) } else { still.piece[i] == still.piece[other] }
    }

    /// Makes the rows of `range`.
    pub fn rows(
        &mut self,
        scene: &Scene<'_>,
        still: &Still,
        m: &Members<'_>,
        grid: &Grid,
        range: Range<usize>,
        block: &mut Block,
    ) {
        let Block { ends, entries, fresh } = block;
        ends.clear();
        entries.clear();
        fresh.clear();
        let mut cell = grid.cell_of(range.start);
        let first = range.start;
        for k in range {
            while k >= grid.balls(cell).end {
                cell += 1;
            }
            if k == first || k == grid.balls(cell).start {
                self.gather(grid, cell, m);
            }
            let (i, body) = (m.members[k] as usize, m.body[k]);
            let b = &scene.bodies[body as usize];
            let bonded = b.material.bonds().is_some();
            self.see(b, i);
            let [x, y, z, reach] = m.spots[k].map(f32x8::splat);
            let [xs, ys, zs, reaches] = [0, 1, 2, 3].map(|axis| self.place[axis].as_chunks::<WIDE>().0.iter());
            let eights = xs.zip(ys).zip(zs).zip(reaches).zip(self.who.as_chunks::<WIDE>().0);
            for ((((xs, ys), zs), reaches), who) in eights {
                let (dx, dy, dz) = (f32x8::from(*xs) - x, f32x8::from(*ys) - y, f32x8::from(*zs) - z);
                let near = (f32x8::from(*reaches) + reach) * f32x8::splat(MARGIN as f32);
                let apart = dx * dx + dy * dy + dz * dz;
                let mut bits = apart.simd_le(near * near).to_bitmask();
                while bits != 0 {
                    let j = who[bits.trailing_zeros() as usize % WIDE];
                    bits &= bits - 1;
                    let other = m.members[j as usize] as usize;
                    let same = m.body[j as usize] == body;
                    if same && (if bonded { self.saw(other) } else { still.piece[i] == still.piece[other] }) {
                        continue;
                    }
                    let d = match same {
                        true => touch(scene.particles.rest, still, i, other),
                        false => still.radius[i] as f32 + still.radius[other] as f32,
                    };
                    entries.push(Entry { other: j, d });
                }
            }
            ends.push(entries.len() as u32);
        }
    }
}
