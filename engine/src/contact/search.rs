//! Makes rows of neighbours: for every cell once, who is near it; for every member then who of those is in reach and not
//! bonded to it, eight at a time.

use std::ops::Range;

use glam::DVec3;
use wide::f32x8;

use super::grid::Grid;
use super::neighbours::{Block, Entry, NONE};
use super::{Scene, Still};
use crate::bonds::CHUNK;
use crate::particles::Particles;
use crate::world::Body;

/// Candidates that are measured at once.
const WIDE: usize = 8;
/// Rows are measured in f32; no pair in reach may be lost by that.
pub const MARGIN: f64 = 1.0 + 1e-5;
const LESS: f32 = (1.0 / MARGIN) as f32;

/// Distance [m] at which two particles of one body touch.
#[inline]
pub fn touch(particles: &Particles, still: &Still, i: usize, j: usize) -> f32 {
    let rest = particles.rest[i].distance(particles.rest[j]);
    // rounded down, so that nothing pushes at rest
    (still.radius[i] as f32 + still.radius[j] as f32).min(rest * (1.0 - 1e-6))
}

/// What making rows reads of the members.
pub struct Members<'a> {
    pub members: &'a [u32],
    pub body: &'a [u32],
    pub reference: &'a [DVec3],
    pub reach: &'a [f32],
}

/// What one thread needs to make rows.
#[derive(Debug, Default)]
pub struct Scratch {
    /// Candidates near a cell: place relative to its middle and reach [m], padded to eights.
    place: [Vec<f32>; 4],
    /// Their members, particles and bodies.
    who: Vec<[u32; 3]>,
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
        let middle = grid.middle(cell);
        grid.near(cell, |balls| {
            for j in balls {
                let x = (members.reference[j] - middle).as_vec3();
                place[0].push(x.x);
                place[1].push(x.y);
                place[2].push(x.z);
                place[3].push(members.reach[j]);
                who.push([j as u32, members.members[j], members.body[j]]);
            }
        });
        let full = who.len().next_multiple_of(WIDE);
        place.iter_mut().for_each(|p| p.resize(full, f32::INFINITY));
        place[3][who.len()..].fill(0.0);
        who.resize(full, [NONE; 3]);
    }

    /// Remembers whom a bond holds to particle `i`, and that one itself.
    pub fn see(&mut self, b: &Body, i: usize) {
        self.row = self.row.checked_add(1).unwrap_or_else(|| {
            self.seen.fill(0);
            1
        });
        self.seen[i] = self.row;
        let Some(bonds) = b.material.bonds() else { return };
        for chunk in bonds.chunks(i - b.range.start) {
            let mut bits = bonds.intact[chunk];
            while bits != 0 {
                let other = bonds.neighbours[chunk * CHUNK + bits.trailing_zeros() as usize];
                self.seen[b.range.start + other as usize] = self.row;
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
            let own = (m.reference[k] - grid.middle(cell)).as_vec3();
            let [x, y, z] = own.to_array().map(f32x8::splat);
            let reach = f32x8::splat(m.reach[k]);
            for start in (0..self.who.len()).step_by(WIDE) {
                let at = |axis: usize| {
                    f32x8::from(<[f32; WIDE]>::try_from(&self.place[axis][start..start + WIDE]).expect("eight"))
                };
                let (dx, dy, dz) = (at(0) - x, at(1) - y, at(2) - z);
                let near = (at(3) + reach) * f32x8::splat(MARGIN as f32);
                let apart = dx * dx + dy * dy + dz * dz;
                let mut bits = (near * near - apart).simd_ge(f32x8::ZERO).to_bitmask();
                let apart = apart.to_array();
                while bits != 0 {
                    let lane = bits.trailing_zeros() as usize;
                    let [j, particle, its_body] = self.who[start + lane];
                    bits &= bits - 1;
                    let other = particle as usize;
                    let same = its_body == body;
                    if same && (if bonded { self.saw(other) } else { still.piece[i] == still.piece[other] }) {
                        continue;
                    }
                    let d = match same {
                        true => touch(scene.particles, still, i, other),
                        false => still.radius[i] as f32 + still.radius[other] as f32,
                    };
                    entries.push(Entry { other: j, d, gap: apart[lane].sqrt() * LESS - d });
                }
            }
            ends.push(entries.len() as u32);
        }
    }
}
