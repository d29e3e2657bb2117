//! The loops over bonds, written once for every law, criterion and lane.
//!
//! Each row is summed by one thread in a fixed order and writes only itself, so the result has the same bits on any
//! number of threads. A chunk whose bonds are all broken is skipped: as bonds break, steps get faster.

use glam::DVec3;

use super::parts::{Criteria, Laws};
use super::pose::{Kernel, Record};
use crate::bonds::{Bonds, CHUNK};
use crate::fracture::{Criterion, Opening};
use crate::lane::Lane;
use crate::law::{Bond, BondLaw};

/// Everything that a pass reads of a body, as plain slices.
#[derive(Clone, Copy)]
pub(super) struct Scene<'a, R> {
    offsets: &'a [u32],
    neighbours: &'a [u32],
    weight: &'a [f32],
    intact: &'a [u8],
    records: &'a [R],
    /// Norm of every particle; empty while it is being summed, and for laws without.
    norm: &'a [f64],
}

/// The remembered numbers of every slot: of its own side, and of the neighbour's. Both are kept in the row, so a pass
/// never looks up the twin of a bond.
#[derive(Clone, Copy)]
pub(super) struct Memory<'a, const M: usize> {
    pub own: [&'a [f32]; M],
    pub twin: [&'a [f32]; M],
}

impl<const M: usize> Memory<'_, M> {
    #[inline(always)]
    fn at<L: Kernel>(&self, slot: usize) -> ([L; M], [L; M]) {
        let load = |columns: [&[f32]; M]| std::array::from_fn(|k| L::load(&columns[k][slot..]));
        (load(self.own), load(self.twin))
    }
}

/// Neighbours and weights of the bonds of one lane.
#[derive(Clone, Copy)]
struct Ends<'a> {
    neighbours: &'a [u32],
    weight: &'a [f32],
}

/// Runs a block for each lane of bonds of a row, with its first slot, its intact bits and its ends; chunks without a bond
/// that holds are passed over. A macro, because a closure here becomes a call, with every register saved around it. The
/// row is cut once and walked by iterators: indexing the columns in every chunk costs a tenth of a pass.
macro_rules! for_each_lane {
    ($scene:ident, $record:ident, $row:expr, |$slot:ident, $intact:ident, $ends:ident| $block:block) => {
        let row = $scene.chunks($row);
        let (start, slots) = (row.start, row.start * CHUNK..row.end * CHUNK);
        let neighbours = $scene.neighbours[slots.clone()].as_chunks::<CHUNK>().0;
        let weights = $scene.weight[slots].as_chunks::<CHUNK>().0;
        let chunks = neighbours.iter().zip(weights).zip(&$scene.intact[row]);
        for (k, ((neighbours, weight), &holding)) in chunks.enumerate() {
            if holding == 0 {
                continue;
            }
            for part in 0..CHUNK / $record::Lane::WIDTH {
                let first = part * $record::Lane::WIDTH;
                #[allow(unused_variables)] // not every pass remembers
                let ($slot, $intact) = ((start + k) * CHUNK + first, holding >> first);
                let $ends = Ends { neighbours: &neighbours[first..], weight: &weight[first..] };
                $block
            }
        }
    };
}

/// One chunk's geometry: what both sides of its bonds share.
struct Geometry<L> {
    own: Bond<L>,
    other: Bond<L>,
    /// y = ξ + u_j − u_i [m] and 1/|y|.
    y: [L; 3],
    inv_length: L,
    volume: L,
}

impl<'a, R: Record> Scene<'a, R> {
    pub fn new(bonds: &'a Bonds, records: &'a [R]) -> Self {
        Self {
            offsets: &bonds.offsets,
            neighbours: &bonds.neighbours,
            weight: &bonds.weight,
            intact: &bonds.intact,
            records,
            norm: &[],
        }
    }

    pub fn with_norm(self, norm: &'a [f64]) -> Self {
        Self { norm, ..self }
    }

    /// Chunks of row `i`.
    #[inline(always)]
    pub fn chunks(&self, i: usize) -> std::ops::Range<usize> {
        self.offsets[i] as usize..self.offsets[i + 1] as usize
    }

    /// The bonds of a lane of row `i` as a law sees them from both sides.
    #[inline(always)]
    fn bond<T: BondLaw<M>, const M: usize>(
        &self,
        laws: Laws<'_, T, M>,
        i: usize,
        home: &R,
        ends: Ends<'_>,
    ) -> Geometry<R::Lane> {
        let of = <R::Lane as Lane>::of;
        let g = R::Lane::gather(self.records, ends.neighbours, home);
        let weight = R::Lane::load(ends.weight);
        let (theta, inv_m) = R::Lane::own(home);
        let y = [g.xi[0] + g.du[0], g.xi[1] + g.du[1], g.xi[2] + g.du[2]];
        let dot = |a: [R::Lane; 3], b: [R::Lane; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        // a padding slot has ξ = 0, and a crushed bond y = 0: keep both finite
        let tiny = of(1e-30);
        let rest = dot(g.xi, g.xi).max(tiny).sqrt();
        let length = dot(y, y).max(tiny).sqrt();
        let sum = length + rest;
        // one division for 1/|y| and 1/(|y| + |ξ|)
        let both = of(1.0) / (length * sum);
        let inv_length = sum * both;
        // e = |y| − |ξ| without cancellation: (2ξ·du + du·du)/(|y| + |ξ|)
        let two_xi = [g.xi[0] + y[0], g.xi[1] + y[1], g.xi[2] + y[2]];
        let ext = dot(two_xi, g.du) * (length * both);
        let cos = if laws.needs_cos() { dot(g.xi, y) * inv_length / rest } else { of(1.0) };
        let (mut own_norm, mut other_norm) = (of(0.0), of(0.0));
        if T::NEEDS_NORM && !self.norm.is_empty() {
            own_norm = of(self.norm[i]);
            other_norm = R::Lane::pick_out(self.norm, ends.neighbours);
        }
        let own = Bond { rest, ext, cos, weight, theta, inv_m, norm: own_norm };
        let other = Bond { theta: g.theta, inv_m: g.inv_m, norm: other_norm, ..own };
        Geometry { own, other, y, inv_length, volume: g.volume }
    }

    /// θ_i (Eq. 6), the sum of the law's shares.
    #[inline(always)]
    pub fn dilatation<T: BondLaw<M>, const M: usize>(&self, laws: Laws<'_, T, M>, i: usize) -> f64 {
        let (law, home) = (laws.own(i), &self.records[i]);
        let zero = R::Lane::of(0.0);
        let mut sum = zero;
        for_each_lane!(self, R, i, |slot, intact, ends| {
            let g = self.bond(laws, i, home, ends);
            let share = law.dilatation(&g.own) * g.volume;
            sum = sum + R::Lane::pick(R::Lane::unpack(intact), share, zero);
        });
        sum.total()
    }

    /// The norm of row `i`, the root of the sum of the law's shares.
    #[inline(always)]
    pub fn norm<T: BondLaw<M>, const M: usize>(&self, memory: &Memory<'_, M>, laws: Laws<'_, T, M>, i: usize) -> f64 {
        let (law, home) = (laws.own(i), &self.records[i]);
        let zero = R::Lane::of(0.0);
        let mut sum = zero;
        for_each_lane!(self, R, i, |slot, intact, ends| {
            let g = self.bond(laws, i, home, ends);
            let share = law.norm_share(&g.own, memory.at(slot).0) * g.volume;
            sum = sum + R::Lane::pick(R::Lane::unpack(intact), share, zero);
        });
        sum.total().sqrt()
    }

    /// Force density Σ (T_ij − T_ji) V_j [N/m³] on particle `i` (Eq. 2), in the frame of the records. `hit(chunk, bits)`
    /// is told which bonds might break; it errs on the side of too many.
    #[inline(always)]
    pub fn force<T: BondLaw<M>, C: Criterion, const M: usize>(
        &self,
        memory: &Memory<'_, M>,
        laws: Laws<'_, T, M>,
        criteria: Criteria<'_, T, C, M>,
        i: usize,
        mut hit: impl FnMut(usize, u8),
    ) -> DVec3 {
        let (law, home) = (laws.own(i), &self.records[i]);
        let zero = R::Lane::of(0.0);
        let mut sum = [zero; 3];
        for_each_lane!(self, R, i, |slot, intact, ends| {
            let g = self.bond(laws, i, home, ends);
            let (own, twin) = memory.at(slot);
            // T_ji points the other way, so the pair adds up (Eq. 3); a + b = b + a makes it antisymmetric to the bit
            let pair = law.force(&g.own, own) + laws.other(slot / CHUNK).force(&g.other, twin);
            let pair = pair * (g.volume * g.inv_length);
            let pair = R::Lane::pick(R::Lane::unpack(intact), pair, zero);
            for k in 0..3 {
                sum[k] = sum[k] + pair * g.y[k];
            }
            if C::BREAKS {
                let bits = R::Lane::pack(criteria.suspects(
                    i,
                    slot / CHUNK,
                    &openings(law, laws.other(slot / CHUNK), &g, own, twin),
                )) & intact;
                if bits != 0 {
                    hit(slot / CHUNK, bits << (slot % CHUNK));
                }
            }
        });
        DVec3::new(sum[0].total(), sum[1].total(), sum[2].total())
    }

    /// Which of the bonds in `bits` of `chunk` break, given the damage φ of both particles: eight severities.
    #[inline(always)]
    pub fn severities<T: BondLaw<M>, C: Criterion, const M: usize>(
        &self,
        memory: &Memory<'_, M>,
        laws: Laws<'_, T, M>,
        criteria: Criteria<'_, T, C, M>,
        i: usize,
        chunk: usize,
        damage: &[f32],
    ) -> u8 {
        let (law, home) = (laws.own(i), &self.records[i]);
        let mut out = 0;
        for part in 0..CHUNK / R::Lane::WIDTH {
            let slot = chunk * CHUNK + part * R::Lane::WIDTH;
            let ends = Ends { neighbours: &self.neighbours[slot..], weight: &self.weight[slot..] };
            let g = self.bond(laws, i, home, ends);
            let (own, twin) = memory.at(slot);
            let mut phi = [0.0; CHUNK];
            for l in 0..R::Lane::WIDTH {
                phi[l] = damage[self.neighbours[slot + l] as usize].max(damage[i]);
            }
            let sides = openings(law, laws.other(chunk), &g, own, twin);
            let severity = criteria.severity(i, chunk, &sides, R::Lane::load(&phi));
            out |= R::Lane::pack(severity.above(R::Lane::of(1.0))) << (part * R::Lane::WIDTH);
        }
        out
    }

    /// Replaces the memory of both sides of row `i`; the slices start at slot `base`.
    #[inline(always)]
    pub fn flow<T: BondLaw<M>, const M: usize>(
        &self,
        laws: Laws<'_, T, M>,
        i: usize,
        dt: f64,
        base: usize,
        own: &mut [&mut [f32]; M],
        twin: &mut [&mut [f32]; M],
    ) {
        let (law, home) = (laws.own(i), &self.records[i]);
        for_each_lane!(self, R, i, |slot, intact, ends| {
            let g = self.bond(laws, i, home, ends);
            let mask = R::Lane::unpack(intact);
            let side = |law: &T, bond: &Bond<R::Lane>, columns: &mut [&mut [f32]; M]| {
                let old: [R::Lane; M] = std::array::from_fn(|k| R::Lane::load(&columns[k][slot - base..]));
                let new = law.flow(bond, old, dt);
                for k in 0..M {
                    R::Lane::pick(mask, new[k], old[k]).store(&mut columns[k][slot - base..]);
                }
            };
            side(law, &g.own, own);
            side(laws.other(slot / CHUNK), &g.other, twin);
        });
    }

    /// Energy Σ_j w_ij V_j of the directed bonds of row `i` [J/m³].
    pub fn energy<T: BondLaw<M>, const M: usize>(&self, memory: &Memory<'_, M>, laws: Laws<'_, T, M>, i: usize) -> f64 {
        let (law, home) = (laws.own(i), &self.records[i]);
        let zero = R::Lane::of(0.0);
        let mut sum = zero;
        for_each_lane!(self, R, i, |slot, intact, ends| {
            let g = self.bond(laws, i, home, ends);
            let energy = law.bond_energy(&g.own, memory.at(slot).0) * g.volume;
            sum = sum + R::Lane::pick(R::Lane::unpack(intact), energy, zero);
        });
        sum.total()
    }
}

/// What the criteria of both sides see, measured by the law of either. The mean of both sides: a + b = b + a, so both ends
/// see the same bits.
#[inline(always)]
fn openings<L: Lane, T: BondLaw<M>, const M: usize>(
    law: &T,
    other: &T,
    g: &Geometry<L>,
    memory: [L; M],
    twin: [L; M],
) -> [Opening<L>; 2] {
    let both = law.elastic_extension(&g.own, memory) + other.elastic_extension(&g.other, twin);
    let (half, theta) = (L::of(0.5), g.own.theta + g.other.theta);
    let by = |gauge| Opening { rest: g.own.rest, elastic: both * half, gauge, theta: theta * half };
    [by(law.gauge(&g.own)), by(other.gauge(&g.other))]
}
