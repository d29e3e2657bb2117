//! The bonds of a body as compressed rows, padded to chunks of eight.
//!
//! ```text
//! row i:  chunks offsets[i] .. offsets[i+1], eight bond slots each
//! slot k: neighbours[k], weight[k]            (f32 lanes read eight at once)
//! chunk c: intact[c], bit l set while the bond in slot 8c + l holds
//! ```
//! Both directions of a bond are stored and a row is written by its own particle only, so no pass needs atomics. A
//! broken bond only loses its bit: neighbours and weights never change, and a checkpoint stores one bit per bond.
//! Padding slots point at their own particle and have no bit. In a body of several regions a row is ordered by the region
//! of the neighbour and padded region by region, so that a chunk holds neighbours of one region only.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::buffer::Buffer;
use crate::column::{Column, Of, Visitor};
use crate::material::Link;

/// Bond slots in a chunk: the width of the widest lane.
pub const CHUNK: usize = 8;

/// Families as the k-d tree finds them: plain rows, both directions, self left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Families {
    /// First neighbour of each row; one more than there are rows.
    pub offsets: Vec<u32>,
    /// Neighbours, row after row.
    pub neighbours: Vec<u32>,
}

impl Families {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The family of particle `i`.
    pub fn row(&self, i: usize) -> &[u32] {
        &self.neighbours[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }
}

/// The bonds of one body.
#[derive(Clone, Debug, Default)]
pub struct Bonds {
    /// First chunk of each row; one more than there are rows.
    pub offsets: Buffer<u32>,
    /// Neighbour in each slot, counted from the body's first particle.
    pub neighbours: Buffer<u32>,
    /// Influence ω [1] of each slot; in a body that is built, times the volume V_j [m³] of the neighbour.
    pub weight: Buffer<f32>,
    /// One bit per slot of a chunk: set while the bond holds.
    pub intact: Buffer<u8>,
    /// N_i, the number of bonds in the undamaged row.
    pub family: Buffer<u32>,
}

impl Bonds {
    /// Lays out the rows of `families`; `influence` gives ω of a rest bond ξ [m].
    pub fn new(families: Families, rest: &[Vec3], influence: impl Fn(usize, DVec3) -> f64 + Sync) -> Self {
        Self::grouped(families, rest, &[], |i, _, xi| influence(i, xi)).0
    }

    /// The same with rows ordered by the region of the neighbour, so that every chunk holds neighbours of one region; and
    /// the region of each chunk. `regions` has one number per particle, or none: then all are in one, and no numbers
    /// come back. `influence` is asked for ω of i, j, ξ. Rows are laid out in the memory of the families, which are half
    /// of what bonds take.
    pub fn grouped(
        families: Families,
        rest: &[Vec3],
        regions: &[u8],
        influence: impl Fn(usize, usize, DVec3) -> f64 + Sync,
    ) -> (Self, Vec<u8>) {
        let rows = families.len();
        let Families { offsets: starts, mut neighbours } = families;
        let plain = |i: usize| starts[i] as usize..starts[i + 1] as usize;
        let region = |j: u32| regions.get(j as usize).copied();
        let alike = |a: &u32, b: &u32| region(*a) == region(*b);
        let mut offsets = Vec::with_capacity(rows + 1);
        offsets.push(0u32);
        for i in 0..rows {
            let row = &mut neighbours[plain(i)];
            if !regions.is_empty() {
                row.sort_by_key(|&j| region(j)); // stable: as before within a region
            }
            let chunks: usize = row.chunk_by(alike).map(|same| same.len().div_ceil(CHUNK)).sum();
            offsets.push(offsets[i] + chunks as u32);
        }
        let chunks = offsets[rows] as usize;
        neighbours.reserve_exact((chunks * CHUNK).saturating_sub(neighbours.len()));
        neighbours.resize(chunks * CHUNK, 0);
        let (mut intact, mut of_chunk) = (vec![0xFF; chunks], vec![0; if regions.is_empty() { 0 } else { chunks }]);
        let mut row = Vec::new();
        // the last row first: a padded row starts where its plain one did, or later, and those behind have moved away
        for i in (0..rows).rev() {
            row.clear();
            row.extend_from_slice(&neighbours[plain(i)]);
            let mut chunk = offsets[i] as usize;
            for same in row.chunk_by(alike) {
                let end = chunk + same.len().div_ceil(CHUNK);
                let (bonds, padding) = neighbours[chunk * CHUNK..end * CHUNK].split_at_mut(same.len());
                bonds.copy_from_slice(same);
                padding.fill(i as u32);
                intact[end - 1] = 0xFF >> padding.len();
                if let Some(region) = region(same[0]) {
                    of_chunk[chunk..end].fill(region);
                }
                chunk = end;
            }
        }
        let mut weight = vec![0.0; neighbours.len()];
        let slots = |i: usize| offsets[i] as usize * CHUNK..offsets[i + 1] as usize * CHUNK;
        let mut rest_of = &mut weight[..];
        let parts: Vec<&mut [f32]> =
            (0..rows).map(|i| rest_of.split_off_mut(..slots(i).len()).expect("as long as all rows")).collect();
        parts.into_par_iter().enumerate().with_min_len(256).for_each(|(i, part)| {
            let home = rest[i].as_dvec3();
            for (weight, &j) in part.iter_mut().zip(&neighbours[slots(i)]) {
                if j as usize != i {
                    *weight = influence(i, j as usize, rest[j as usize].as_dvec3() - home) as f32;
                }
            }
        });
        let family = (0..rows).map(|i| plain(i).len() as u32).collect::<Vec<_>>();
        let bonds = Self {
            offsets: offsets.into(),
            neighbours: neighbours.into(),
            weight: weight.into(),
            intact: intact.into(),
            family: family.into(),
        };
        (bonds, of_chunk)
    }

    /// Number of rows, one per particle.
    pub fn rows(&self) -> usize {
        self.family.len()
    }

    /// Number of directed bonds in the undamaged body, padding not counted.
    pub fn directed(&self) -> u64 {
        self.family.iter().map(|&n| u64::from(n)).sum()
    }

    /// Number of directed bonds that hold.
    pub fn holding(&self) -> u64 {
        self.intact.iter().map(|b| u64::from(b.count_ones())).sum()
    }

    /// Chunks of row `i`.
    #[inline(always)]
    pub fn chunks(&self, i: usize) -> std::ops::Range<usize> {
        self.offsets[i] as usize..self.offsets[i + 1] as usize
    }

    /// Slots of row `i` that have a bond, also where it is broken.
    #[inline(always)]
    pub fn built(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        let row = self.offsets[i] as usize * CHUNK..self.offsets[i + 1] as usize * CHUNK;
        // padding, which comes between the regions of the neighbours too, points at the particle itself
        row.filter(move |&slot| self.neighbours[slot] as usize != i)
    }

    /// Slots of row `i` whose bond holds.
    pub fn slots(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        self.chunks(i)
            .flat_map(move |c| (0..CHUNK).filter(move |l| self.intact[c] >> l & 1 == 1).map(move |l| c * CHUNK + l))
    }

    /// Breaks the bonds whose bit is set in `marks`, one byte per chunk of the `rows`, which ascend: updates the damage φ [1]
    /// of those and appends every link once, in order of `i`. Marks of other rows are not read.
    pub fn part(&mut self, marks: &[u8], rows: impl Iterator<Item = usize>, damage: &mut [f32], cuts: &mut Vec<Link>) {
        let (offsets, neighbours, intact) = (&self.offsets[..], &self.neighbours[..], &mut self.intact[..]);
        for i in rows {
            let row = offsets[i] as usize..offsets[i + 1] as usize;
            if marks[row.clone()].iter().all(|&m| m == 0) {
                continue;
            }
            for chunk in row.clone() {
                let broken = marks[chunk] & intact[chunk];
                intact[chunk] &= !broken;
                for l in (0..CHUNK).filter(|l| broken >> l & 1 == 1) {
                    let j = neighbours[chunk * CHUNK + l];
                    if (i as u32) < j {
                        cuts.push(Link { i: i as u32, j });
                    }
                }
            }
            let left: u32 = intact[row].iter().map(|b| b.count_ones()).sum();
            damage[i] = 1.0 - left as f32 / self.family[i] as f32;
        }
    }

    /// Whether the columns fit each other and `rows` particles, as far as lengths go: what a restored file may get wrong.
    /// Neighbours are not read, for that would pull the whole map into memory.
    pub fn consistent(&self, rows: usize) -> bool {
        let chunks = self.intact.len();
        self.offsets.len() == rows + 1
            && self.offsets.is_sorted()
            && self.offsets.first() == Some(&0)
            && self.offsets.last() == Some(&(chunks as u32))
            && self.neighbours.len() == chunks * CHUNK
            && self.weight.len() == chunks * CHUNK
            && self.family.len() == rows
    }

    /// Shows every column.
    pub fn visit(&mut self, scope: &str, v: &mut Visitor<'_>) {
        v(scope, &Column::frozen("offsets", "1", Of::Row), &mut self.offsets);
        v(scope, &Column::frozen("neighbours", "1", Of::Bond), &mut self.neighbours);
        v(scope, &Column::frozen("weight", "m^3", Of::Bond), &mut self.weight);
        v(scope, &Column::live("intact", "1", Of::Chunk), &mut self.intact);
        v(scope, &Column::frozen("family", "1", Of::Particle), &mut self.family);
    }
}

/// ω with one bit less than f32 has, so that [`influence`] finds it again.
pub(crate) fn shortened(influence: f32) -> f32 {
    nearest(f64::from(influence)) as f32
}

/// The ω that a `weight` ωV, rounded to f32, was made of: exactly, and so the same from both ends of a bond.
#[inline(always)]
pub(crate) fn influence(weight: f32, volume: f64) -> f64 {
    nearest(f64::from(weight) / volume)
}

/// `x` to 22 binary places behind its leading one.
#[inline(always)]
fn nearest(x: f64) -> f64 {
    const DROPPED: u32 = f64::MANTISSA_DIGITS - 1 - 22;
    f64::from_bits((x.to_bits() + (1 << (DROPPED - 1))) >> DROPPED << DROPPED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_influence_is_found_again_in_the_weight() {
        for k in 0..200_000u32 {
            let omega = shortened(1.0 + k as f32 * 7.3e-6);
            let volume = 1e-9 * (1.0 + f64::from(k % 977) * 0.0123);
            assert_eq!(influence((f64::from(omega) * volume) as f32, volume), f64::from(omega));
        }
        assert_eq!((shortened(0.0), influence(0.0, 1.0)), (0.0, 0.0));
    }

    #[test]
    fn rows_are_padded_to_chunks_and_padding_is_never_intact() {
        let families = Families { offsets: vec![0, 9, 10, 10], neighbours: vec![1, 2, 1, 2, 1, 2, 1, 2, 1, 0] };
        let rest = [Vec3::ZERO, Vec3::X, Vec3::new(0.0, 2.0, 0.0)];
        let bonds = Bonds::new(families, &rest, |_, xi| 1.0 / xi.length());
        assert_eq!(&bonds.offsets[..], &[0, 2, 3, 3]);
        assert_eq!((bonds.directed(), bonds.holding()), (10, 10));
        assert_eq!(&bonds.intact[..], &[0xFF, 1, 1]);
        assert_eq!(bonds.neighbours[9..16], [0; 7]);
        assert_eq!((bonds.weight[0], bonds.weight[1], bonds.weight[9]), (1.0, 0.5, 0.0));
        assert_eq!(bonds.slots(0).collect::<Vec<_>>(), (0..9).collect::<Vec<_>>());
        assert_eq!(bonds.slots(2).count(), 0);
    }
}
