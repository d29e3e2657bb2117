//! The loops over bonds, written once for every law, criterion and lane.
//!
//! A row is a call that is not inlined: then the compiler knows that what it is given can be read at any time and changed by
//! nobody, and takes the constants of law and criterion out of the loop over its bonds, and decisions like
//! [`BondLaw::needs_cos`] with them.
//!
//! What it costs: instructions per directed bond and step on a lattice of 16³ with 133 neighbours, by callgrind
//! (`bench/examples/kernel.rs`, in which contact of the block's surface has 2 to 3). A loop of isotropic θ has 112 for eight
//! bonds, of its force 132; with some hundred cycles from the first load to the sum, what limits it is how many of the loops the
//! processor keeps in flight, so a shorter chain counts as much as fewer instructions.
//!
//! | | isotropic | plastic, not yielding | pmb |
//! |---|---|---|---|
//! | records of 48 bytes with u as a pair of f32, V_j gathered, memory flows everywhere | 46.7 | 88.4 | 22.9 |
//! | records of 32 bytes, V_j in the weight, \|y\|² as \|ξ\|² and what it gained | 42.2 | 71.4 | 21.0 |
//! | places of records kept in an array that the compiler does not copy | 38.2 | 67.4 | 19.0 |
//! | rows as calls, and formulation of the law known outside the loop | 35.5 | 52.8 | 18.6 |
//! | one formulation in plastic, not one of its own and one of its base | 35.5 | 46.4 | 18.6 |
//!
//! Traps: `map` of an array of arrays is a call, and doubles everything. A write in the loop, also of a byte that is rarely
//! written, makes the compiler read the law's constants again for every chunk: so a row only says that something may break.
//! One division for 1/|y| and 1/(|y| + |ξ|) has a longer chain and more instructions than two. `mul_add` is faster and is not
//! there on every processor. Gathering a whole row first and computing in a second loop, so that less waits in the processor's
//! queues, came out between even and a tenth slower, though a model of the ports (llvm-mca) promises a fifth.
//!
//! Sixteen lanes (AVX-512, chosen when the program runs, two chunks a loop, the same bits) have 21 instructions a bond instead
//! of 37 and were 1.10 to 1.15 times as fast, which their code isn't worth: the ports of 512 bits are two, those of 256 three,
//! and 24 shuffles and 8 inserts for sixteen bonds use them as much as the arithmetic does. Asymptotically, for very long rows,
//! a bond took 2.35 ns against 2.73, and a row 44 ns besides. A third of the time would go without roots and quotients.
//! What is read back from the upper half of a store of 64 bytes waits for the store to retire: that alone halved the speed
//! (Sapphire Rapids). Places read one by one from the bonds themselves, with a comparison of vectors for forged ones beside
//! them, saved a tenth there and nothing for eight lanes; gathering the next bonds before computing with the present ones saved
//! nothing. An operation that is a function with a target feature is inlined from `#[inline(always)]` functions, but not from
//! closures, and not from a law that says less.
//!
//! Each row is summed by one thread in a fixed order and writes only itself, so the result has the same bits on any
//! number of threads. A chunk whose bonds are all broken is skipped: as bonds break, steps get faster.

use std::marker::PhantomData;

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
    /// ω of every slot; empty for laws without.
    influence: &'a [f32],
    intact: &'a [u8],
    records: &'a [R],
    /// What displacements are counted in [m].
    quantum: f64,
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
        let load = |columns: [&[f32]; M]| {
            std::array::from_fn(|k| {
                let here = &columns[k][slot..slot + L::WIDTH];
                fetch_ahead(here);
                L::load(here)
            })
        };
        (load(self.own), load(self.twin))
    }
}

/// Slots ahead of the one at work that are asked of memory: a page of each column.
const AHEAD: usize = 1024;

/// Asks memory for what comes [`AHEAD`] slots behind `here`, which may lie beyond the column: a hint never faults. Left to
/// itself the processor finds the columns too late, for the eight gathered records lie in its way: a step of 4.8·10⁷ bonds
/// takes 1.36 times as long without. (128 slots ahead 1.05 times, 256 to 4096 within 3 %; huge pages, or asking for the
/// gathered records, bring nothing.)
#[inline(always)]
fn fetch_ahead<T>(here: &[T]) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a prefetch reads nothing, wherever it points.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(here.as_ptr().wrapping_add(AHEAD).cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = here;
}

/// Neighbours and weights of the bonds of one lane.
#[derive(Clone, Copy)]
struct Ends<'a> {
    neighbours: &'a [u32],
    weight: &'a [f32],
}

/// What the force pass found in a row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Outlook {
    /// A bond may break.
    pub breaks: bool,
    /// The memory of a bond may change.
    pub flows: bool,
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
            fetch_ahead(neighbours);
            fetch_ahead(weight);
            for part in 0..CHUNK / $record::Lane::WIDTH {
                let first = part * $record::Lane::WIDTH;
                let ($slot, $intact) = ((start + k) * CHUNK + first, holding >> first);
                let $ends = Ends { neighbours: &neighbours[first..], weight: &weight[first..] };
                $block
            }
        }
    };
}

/// What all bonds of a row have in common.
struct Home<R, T> {
    record: R,
    norm: f64,
    needs_cos: bool,
    law: PhantomData<T>,
}

/// One chunk's geometry: what both sides of its bonds share.
struct Geometry<L> {
    own: Bond<L>,
    other: Bond<L>,
    /// y = ξ + u_j − u_i [m] and |y|.
    y: [L; 3],
    length: L,
}

/// A bond is never taken for shorter than this share of its rest length, squared: |y|² is a sum that may cancel.
const CRUSHED: f64 = 1e-6;

impl<'a, R: Record> Scene<'a, R> {
    pub fn new(bonds: &'a Bonds, influence: &'a [f32], records: &'a [R], quantum: f64) -> Self {
        Self {
            offsets: &bonds.offsets,
            neighbours: &bonds.neighbours,
            weight: &bonds.weight,
            influence,
            intact: &bonds.intact,
            records,
            quantum,
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

    /// Row `i`, whose law is `law`; `needs_cos` is the answer of [`Laws::needs_cos`]. A law decides by the same what else it
    /// computes (the formulation of Chen et al. as written): where the answer is a constant, it does not ask in every bond.
    #[inline(always)]
    fn home<T: BondLaw<M>, const M: usize>(&self, law: &T, i: usize, needs_cos: bool) -> Home<R, T> {
        assert!(T::SEVERAL || law.needs_cos() == needs_cos);
        let norm = if self.norm.is_empty() { 0.0 } else { self.norm[i] };
        Home { record: self.records[i], norm, needs_cos, law: PhantomData }
    }

    /// The bonds of the lane at `slot` of the row as a law sees them from both sides.
    #[inline(always)]
    fn bond<T: BondLaw<M>, const M: usize>(&self, home: &Home<R, T>, slot: usize, ends: Ends<'_>) -> Geometry<R::Lane> {
        let of = <R::Lane as Lane>::of;
        let dot = |a: [R::Lane; 3], b: [R::Lane; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let plus = |a: [R::Lane; 3], b: [R::Lane; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        let g = R::Lane::gather(self.records, self.quantum, ends.neighbours, &home.record);
        let (theta, inv_m) = R::Lane::own(&home.record);
        // (ξ + y)/2 and y
        let middle = plus(g.xi, g.half);
        let y = plus(middle, g.half);
        // |y|² − |ξ|² = (y + ξ)·(y − ξ), without cancellation
        let gain = of(4.0) * dot(middle, g.half);
        // a padding slot has ξ = 0
        let square = dot(g.xi, g.xi).max(of(1e-30));
        let rest = square.sqrt();
        let length = (square + gain).max(of(CRUSHED) * square).sqrt();
        let ext = gain / (length + rest);
        let cos = if home.needs_cos { dot(g.xi, y) / (length * rest) } else { of(1.0) };
        let influence = self.influence.get(slot..slot + R::Lane::WIDTH).map_or(of(f64::NAN), R::Lane::load);
        let (mut own_norm, mut other_norm) = (of(0.0), of(0.0));
        if T::NEEDS_NORM && !self.norm.is_empty() {
            own_norm = of(home.norm);
            other_norm = R::Lane::pick_out(self.norm, ends.neighbours);
        }
        let weight = R::Lane::weight(ends.weight, self.records, ends.neighbours);
        let own = Bond { rest, ext, cos, weight, influence, theta, inv_m, norm: own_norm };
        let other = Bond { theta: g.theta, inv_m: g.inv_m, norm: other_norm, ..own };
        Geometry { own, other, y, length }
    }

    /// θ_i (Eq. 6), the sum of the law's shares.
    #[inline(always)]
    pub fn dilatation<T: BondLaw<M>, const M: usize>(&self, laws: Laws<'_, T, M>, i: usize) -> f64 {
        let row =
            if laws.needs_cos() { Self::dilatation_row::<T, M, true> } else { Self::dilatation_row::<T, M, false> };
        row(self, laws.own(i), i)
    }

    #[inline(never)]
    fn dilatation_row<T: BondLaw<M>, const M: usize, const COS: bool>(&self, law: &T, i: usize) -> f64 {
        let home = self.home(law, i, COS);
        let mut sum = R::Lane::of(0.0);
        for_each_lane!(self, R, i, |slot, intact, ends| {
            let g = self.bond(&home, slot, ends);
            sum = sum + law.dilatation(&g.own).only(R::Lane::unpack(intact));
        });
        sum.total()
    }

    /// The norm of row `i`, the root of the sum of the law's shares.
    #[inline(never)]
    pub fn norm<T: BondLaw<M>, const M: usize>(
        &self,
        memory: &Memory<'_, M>,
        laws: Laws<'_, T, M>,
        law: &T,
        i: usize,
    ) -> f64 {
        let home = self.home(law, i, laws.needs_cos());
        let mut sum = R::Lane::of(0.0);
        for_each_lane!(self, R, i, |slot, intact, ends| {
            let g = self.bond(&home, slot, ends);
            sum = sum + law.norm_share(&g.own, memory.at(slot).0).only(R::Lane::unpack(intact));
        });
        sum.total().sqrt()
    }

    /// Force density Σ (T_ij − T_ji) V_j [N/m³] on particle `i` (Eq. 2), in the frame of the records; and what may happen in
    /// its row: it errs on the side of too much. The loop writes nothing, so what it reads again and again (law, criterion, home)
    /// stays in registers.
    #[inline(always)]
    pub fn force<T: BondLaw<M>, C: Criterion, const M: usize>(
        &self,
        memory: &Memory<'_, M>,
        laws: Laws<'_, T, M>,
        criteria: Criteria<'_, T, C, M>,
        i: usize,
    ) -> (DVec3, Outlook) {
        let row = if laws.needs_cos() { Self::force_row::<T, C, M, true> } else { Self::force_row::<T, C, M, false> };
        row(self, memory, laws, laws.own(i), criteria, i)
    }

    #[inline(never)]
    fn force_row<T: BondLaw<M>, C: Criterion, const M: usize, const COS: bool>(
        &self,
        memory: &Memory<'_, M>,
        laws: Laws<'_, T, M>,
        law: &T,
        criteria: Criteria<'_, T, C, M>,
        i: usize,
    ) -> (DVec3, Outlook) {
        let home = self.home(law, i, COS);
        let mut sum = [R::Lane::of(0.0); 3];
        let none = R::Lane::unpack(0);
        let (mut suspects, mut flowing) = (none, none);
        for_each_lane!(self, R, i, |slot, intact, ends| {
            let (g, other) = (self.bond(&home, slot, ends), laws.other(law, slot / CHUNK));
            let (memory, twin) = memory.at(slot);
            let holds = R::Lane::unpack(intact);
            // T_ji points the other way, so the pair adds up (Eq. 3); a + b = b + a makes it antisymmetric to the bit
            let pair = law.force(&g.own, memory) + other.force(&g.other, twin);
            let per_length = (pair / g.length).only(holds);
            for k in 0..3 {
                sum[k] = sum[k] + per_length * g.y[k];
            }
            if C::BREAKS {
                let sides = openings(law, other, &g, memory, twin);
                suspects = suspects | (criteria.suspects(i, slot / CHUNK, &sides) & holds);
            }
            if M > 0 {
                flowing = flowing | ((law.flows(&g.own, memory) | other.flows(&g.other, twin)) & holds);
            }
        });
        let any = |mask| R::Lane::pack(mask) != 0;
        let outlook = Outlook { breaks: C::BREAKS && any(suspects), flows: M > 0 && any(flowing) };
        (DVec3::new(sum[0].total(), sum[1].total(), sum[2].total()), outlook)
    }

    /// Which of the bonds of `chunk` in row `i` break, given the damage φ of both particles: eight severities. Judged are
    /// those whose both ends were found to be near breaking in `outlook`: memory may have flowed since the force, and a flow
    /// that overshoots (Eq. 15 as written) would let one end judge what the other does not look at.
    pub fn severities<T: BondLaw<M>, C: Criterion, const M: usize>(
        &self,
        memory: &Memory<'_, M>,
        laws: Laws<'_, T, M>,
        criteria: Criteria<'_, T, C, M>,
        i: usize,
        chunk: usize,
        (damage, outlook): (&[f32], &[Outlook]),
    ) -> u8 {
        let law = laws.own(i);
        let home = self.home(law, i, laws.needs_cos());
        let mut out = 0;
        for part in 0..CHUNK / R::Lane::WIDTH {
            let slot = chunk * CHUNK + part * R::Lane::WIDTH;
            let ends = Ends { neighbours: &self.neighbours[slot..], weight: &self.weight[slot..] };
            let g = self.bond(&home, slot, ends);
            let (own, twin) = memory.at(slot);
            let mut phi = [0.0; CHUNK];
            let mut judged = 0;
            for l in 0..R::Lane::WIDTH {
                let j = self.neighbours[slot + l] as usize;
                phi[l] = damage[j].max(damage[i]);
                judged |= u8::from(outlook[j].breaks) << l;
            }
            let sides = openings(law, laws.other(law, chunk), &g, own, twin);
            let severity = criteria.severity(i, chunk, &sides, R::Lane::load(&phi));
            out |= (R::Lane::pack(severity.above(R::Lane::of(1.0))) & judged) << (part * R::Lane::WIDTH);
        }
        out & self.intact[chunk]
    }

    /// Replaces the memory of both sides of row `i`; the slices start at slot `base`.
    #[inline(never)]
    pub fn flow<T: BondLaw<M>, const M: usize>(
        &self,
        laws: Laws<'_, T, M>,
        law: &T,
        i: usize,
        dt: f64,
        base: usize,
        [own, twin]: [&mut [&mut [f32]; M]; 2],
    ) {
        let home = self.home(law, i, laws.needs_cos());
        for_each_lane!(self, R, i, |slot, intact, ends| {
            let g = self.bond(&home, slot, ends);
            let mask = R::Lane::unpack(intact);
            let side = |law: &T, bond: &Bond<R::Lane>, columns: &mut [&mut [f32]; M]| {
                let old: [R::Lane; M] = std::array::from_fn(|k| R::Lane::load(&columns[k][slot - base..]));
                let new = law.flow(bond, old, dt);
                for k in 0..M {
                    R::Lane::pick(mask, new[k], old[k]).store(&mut columns[k][slot - base..]);
                }
            };
            side(law, &g.own, own);
            side(laws.other(law, slot / CHUNK), &g.other, twin);
        });
    }

    /// Energy Σ_j w_ij V_j of the directed bonds of row `i` [J/m³].
    pub fn energy<T: BondLaw<M>, const M: usize>(&self, memory: &Memory<'_, M>, laws: Laws<'_, T, M>, i: usize) -> f64 {
        let law = laws.own(i);
        let home = self.home(law, i, laws.needs_cos());
        let mut sum = R::Lane::of(0.0);
        for_each_lane!(self, R, i, |slot, intact, ends| {
            let g = self.bond(&home, slot, ends);
            sum = sum + law.bond_energy(&g.own, memory.at(slot).0).only(R::Lane::unpack(intact));
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
