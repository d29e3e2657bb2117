//! What the bond passes gather of a particle: one 32-byte record, or its f64 counterpart for reference.
//!
//! The displacement is counted in quanta, as 32-bit integers that wrap ([`quantum`](super::quantum)), so a fragment that
//! flies far from its body's frame keeps its precision: with f32 it would jitter by 6e-8 of the distance every step, and
//! heat up (measured: about 1e-4 m/s per step and particle at 1 m distance and dt = 1e-4 s).

use std::ops::Sub;

use glam::{DVec3, Vec3};
use wide::{f32x8, i32x8, u32x8};

use super::quantum::count;
use crate::bonds::{CHUNK, influence};
use crate::lane::{Lane, Mask8};

/// A particle as the passes see it.
pub trait Record: Copy + Send + Sync + 'static {
    /// The lane that reads this record.
    type Lane: Kernel<Record = Self>;
    /// Rest position x [m], displacement u in the frame [m] to be counted in `quantum` [m], volume [m³], inverse weighted
    /// volume [1/m⁵].
    fn new(x: Vec3, u: DVec3, quantum: f64, volume: f64, inv_m: f64) -> Self;
    /// Sets the dilatation θ [1].
    fn set_theta(&mut self, theta: f64);
}

/// The neighbours' side of a chunk of bonds, relative to the row's own particle.
#[derive(Clone, Copy)]
pub struct Gathered<L> {
    /// Rest bond ξ = x_j − x_i [m].
    pub xi: [L; 3],
    /// Half the difference of displacements, (u_j − u_i)/2 [m].
    pub half: [L; 3],
    /// θ_j [1].
    pub theta: L,
    /// 1/m_j [1/m⁵].
    pub inv_m: L,
}

/// What the passes ask of a lane beyond arithmetic: loading, gathering and summing.
pub trait Kernel: Lane {
    /// The record this lane gathers from.
    type Record: Record<Lane = Self>;
    /// Numbers per lane: 1 or 8; divides a chunk.
    const WIDTH: usize;
    /// The first `WIDTH` bond values.
    fn load(values: &[f32]) -> Self;
    /// Stores into the first `WIDTH` bond values.
    fn store(self, values: &mut [f32]);
    /// The first `WIDTH` neighbours, relative to `home`; displacements are counted in `quantum` [m].
    fn gather(records: &[Self::Record], quantum: f64, neighbours: &[u32], home: &Self::Record) -> Gathered<Self>;
    /// The weights ωV_j [m³] of the first `WIDTH` neighbours. In f64 without the rounding of the column, which differs
    /// between the two ends: there momentum is kept to the last bits.
    fn weight(weights: &[f32], records: &[Self::Record], neighbours: &[u32]) -> Self;
    /// θ and 1/m of one record, in every number.
    fn own(record: &Self::Record) -> (Self, Self);
    /// A particle's number of the first `WIDTH` neighbours.
    fn pick_out(values: &[f64], neighbours: &[u32]) -> Self;
    /// The sum of the numbers, always in the same order.
    fn total(self) -> f64;
    /// `self` where the mask holds, 0 elsewhere, also for what is not a number.
    fn only(self, mask: Self::Mask) -> Self;
    /// The mask whose number `l` is bit `l`.
    fn unpack(bits: u8) -> Self::Mask;
    /// Bit `l` is number `l` of the mask.
    fn pack(mask: Self::Mask) -> u8;
}

/// Particle record for f32 lanes, 32 bytes.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub struct Record32 {
    x: [f32; 3],
    inv_m: f32,
    /// u in quanta, modulo 2³².
    u: [i32; 3],
    theta: f32,
}

impl Record for Record32 {
    type Lane = f32x8;
    #[inline(always)]
    fn new(x: Vec3, u: DVec3, quantum: f64, _: f64, inv_m: f64) -> Self {
        // a count is never infinite: let the rest position say it
        let x = if u.is_finite() { x } else { Vec3::NAN };
        let per = 1.0 / quantum;
        Self { x: x.into(), inv_m: inv_m as f32, u: u.to_array().map(|u| count(u, per)), theta: 0.0 }
    }
    #[inline(always)]
    fn set_theta(&mut self, theta: f64) {
        self.theta = theta as f32;
    }
}

impl Kernel for f32x8 {
    type Record = Record32;
    const WIDTH: usize = 8;

    #[inline(always)]
    fn load(values: &[f32]) -> Self {
        let eight: [f32; CHUNK] = values[..CHUNK].try_into().expect("a chunk is eight");
        f32x8::from(eight)
    }

    #[inline(always)]
    fn store(self, values: &mut [f32]) {
        values[..CHUNK].copy_from_slice(&self.to_array());
    }

    #[inline(always)]
    fn gather(records: &[Record32], quantum: f64, neighbours: &[u32], home: &Record32) -> Gathered<Self> {
        let [first, second] = halves(neighbours[..CHUNK].try_into().expect("a chunk is eight"), records);
        let [x, y, z, inv_m] = transpose(first);
        let [u, v, w, theta] = transpose(second);
        let own = |v: f32| f32x8::splat(v);
        let unit = Self::of(0.5 * quantum);
        let apart = |u: f32x8, home: i32| {
            let counts: i32x8 = bytemuck::cast(u);
            (counts - i32x8::splat(home)).round_float() * unit
        };
        Gathered {
            xi: [x - own(home.x[0]), y - own(home.x[1]), z - own(home.x[2])],
            half: [apart(u, home.u[0]), apart(v, home.u[1]), apart(w, home.u[2])],
            theta,
            inv_m,
        }
    }

    #[inline(always)]
    fn weight(weights: &[f32], _: &[Record32], _: &[u32]) -> Self {
        Self::load(weights)
    }

    #[inline(always)]
    fn own(record: &Record32) -> (Self, Self) {
        (f32x8::splat(record.theta), f32x8::splat(record.inv_m))
    }

    #[inline(always)]
    fn pick_out(values: &[f64], neighbours: &[u32]) -> Self {
        f32x8::from(std::array::from_fn(|l| values[neighbours[l] as usize] as f32))
    }

    #[inline(always)]
    fn total(self) -> f64 {
        let a = self.to_array();
        f64::from(((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7])))
    }

    #[inline(always)]
    fn only(self, mask: Mask8) -> Self {
        self & mask.0
    }

    #[inline(always)]
    fn unpack(bits: u8) -> Mask8 {
        Mask8(bytemuck::cast(MASKS[bits as usize]))
    }

    #[inline(always)]
    fn pack(mask: Mask8) -> u8 {
        mask.0.to_bitmask() as u8
    }
}

/// For each byte the eight lane masks of its bits.
static MASKS: [[u32; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut k = 0;
    while k < 2048 {
        if (k / 8) >> (k % 8) & 1 == 1 {
            table[k / 8][k % 8] = u32::MAX;
        }
        k += 1;
    }
    table
};

/// Most particles of a body with bonds.
pub const MOST: usize = u32::MAX as usize / size_of::<Record32>();

/// Eight records as four pairs of their first halves, and four of their second halves: record k beside record k + 4.
///
/// Checked indexing reads all halves before the first shuffle, spills most of them and computes eight addresses: half of
/// the instructions of a step. Here neighbours are held below the number of records by a minimum of vectors, so that
/// reading needs no further check. A neighbour beyond the records, which only a forged file can have, reads the last one.
/// Joining two halves while loading leaves the shuffle ports alone, which whole records of 32 bytes would need half as
/// much again.
#[inline(always)]
fn halves(neighbours: [u32; CHUNK], records: &[Record32]) -> [[[[f32; 4]; 2]; 4]; 2] {
    const { assert!(size_of::<Record32>() == 32) };
    let last = u32x8::splat(records.len() as u32 - 1);
    let places: u32x8 = u32x8::from(neighbours).min(last) << 5; // in bytes; enough for MOST
    let places = places.to_array();
    let base = records.as_ptr().cast::<u8>();
    // SAFETY: a place is 32 times an index below the number of records, so what is read
    // there are halves of a record, plain numbers and aligned to 16 bytes. (With more than MOST records a place would wrap
    // to an earlier record.) Places are read back from memory, volatile, because the compiler would rather take them out of
    // the vector, which keeps the ports busy that the shuffles need.
    unsafe {
        let place = |l: usize| base.add((&raw const places[l]).read_volatile() as usize).cast::<[f32; 4]>();
        let pair = |k: usize| {
            let (a, b) = (place(k), place(k + 4));
            ([a.read(), b.read()], [a.add(1).read(), b.add(1).read()])
        };
        let (a, b, c, d) = (pair(0), pair(1), pair(2), pair(3)); // an array's `map` would not be inlined
        [[a.0, b.0, c.0, d.0], [a.1, b.1, c.1, d.1]]
    }
}

/// Eight rows of four to four columns of eight; row k comes beside row k + 4.
#[inline(always)]
fn transpose(rows: [[[f32; 4]; 2]; 4]) -> [f32x8; 4] {
    #[cfg(target_feature = "avx")]
    {
        use std::arch::x86_64::{__m256, _mm256_shuffle_ps, _mm256_unpackhi_ps, _mm256_unpacklo_ps};
        // SAFETY: 256 bits of plain f32, and AVX is there at build time.
        unsafe {
            let pair = |k: usize| std::mem::transmute::<[[f32; 4]; 2], __m256>(rows[k]);
            let (a, b, c, d) = (pair(0), pair(1), pair(2), pair(3));
            let (ab_lo, ab_hi) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
            let (cd_lo, cd_hi) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
            let columns = [
                _mm256_shuffle_ps::<0b01_00_01_00>(ab_lo, cd_lo),
                _mm256_shuffle_ps::<0b11_10_11_10>(ab_lo, cd_lo),
                _mm256_shuffle_ps::<0b01_00_01_00>(ab_hi, cd_hi),
                _mm256_shuffle_ps::<0b11_10_11_10>(ab_hi, cd_hi),
            ];
            columns.map(|v| std::mem::transmute::<__m256, f32x8>(v))
        }
    }
    #[cfg(not(target_feature = "avx"))]
    {
        let four = |side: usize| {
            let quad = |k: usize| wide::f32x4::from(rows[k][side]);
            wide::f32x4::transpose([quad(0), quad(1), quad(2), quad(3)])
        };
        let (low, high) = (four(0), four(1));
        let column = |c: usize| bytemuck::cast::<[wide::f32x4; 2], f32x8>([low[c], high[c]]);
        [column(0), column(1), column(2), column(3)]
    }
}

/// Particle record for the f64 reference.
#[derive(Clone, Copy, Debug, Default)]
pub struct Record64 {
    x: [f64; 3],
    u: [f64; 3],
    volume: f64,
    theta: f64,
    inv_m: f64,
}

impl Record for Record64 {
    type Lane = f64;
    fn new(x: Vec3, u: DVec3, _: f64, volume: f64, inv_m: f64) -> Self {
        Self { x: x.as_dvec3().into(), u: u.into(), volume, theta: 0.0, inv_m }
    }
    fn set_theta(&mut self, theta: f64) {
        self.theta = theta;
    }
}

impl Kernel for f64 {
    type Record = Record64;
    const WIDTH: usize = 1;
    fn load(values: &[f32]) -> Self {
        f64::from(values[0])
    }
    fn store(self, values: &mut [f32]) {
        values[0] = self as f32;
    }
    fn gather(records: &[Record64], _: f64, neighbours: &[u32], home: &Record64) -> Gathered<Self> {
        let r = &records[neighbours[0] as usize];
        let minus = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|k| Sub::sub(a[k], b[k]));
        let half = minus(r.u, home.u).map(|du: f64| 0.5 * du);
        Gathered { xi: minus(r.x, home.x), half, theta: r.theta, inv_m: r.inv_m }
    }
    fn weight(weights: &[f32], records: &[Record64], neighbours: &[u32]) -> Self {
        let volume = records[neighbours[0] as usize].volume;
        influence(weights[0], volume) * volume
    }
    fn own(record: &Record64) -> (Self, Self) {
        (record.theta, record.inv_m)
    }
    fn pick_out(values: &[f64], neighbours: &[u32]) -> Self {
        values[neighbours[0] as usize]
    }
    fn total(self) -> f64 {
        self
    }
    fn only(self, mask: bool) -> Self {
        if mask { self } else { 0.0 }
    }
    fn unpack(bits: u8) -> bool {
        bits & 1 == 1
    }
    fn pack(mask: bool) -> u8 {
        u8::from(mask)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gathering_transposes_and_subtracts_counts_that_wrap() {
        const QUANTUM: f64 = 1.0 / (1u64 << 39) as f64;
        let far = DVec3::new(1e3, -2e3, 5e2);
        let records: Vec<Record32> = (0..9)
            .map(|k| {
                let s = f64::from(k);
                let u = far + DVec3::new(s, 2.0 * s, -s) * 1e-9;
                let mut r = Record32::new(Vec3::new(k as f32, 0.5, -1.0), u, QUANTUM, 1.0, 1.0 / (s + 1.0));
                r.set_theta(s * 0.1);
                r
            })
            .collect();
        let g = f32x8::gather(&records, QUANTUM, &[1, 2, 3, 4, 5, 6, 7, 8], &records[0]);
        for l in 0..8 {
            let s = l as f32 + 1.0;
            assert_eq!(g.xi.map(|v| v.to_array()[l]), [s, 0.0, 0.0]);
            assert_eq!(g.inv_m.to_array()[l], 1.0 / (s + 1.0));
            assert_eq!(g.theta.to_array()[l], (f64::from(s) * 0.1) as f32);
            // at 2 km, with half a quantum of each end: measured 1.8e-12
            let error = 2.0 * g.half[1].to_array()[l] - 2e-9 * s;
            assert!(error.abs() < 2e-12, "{error:e}");
        }
    }

    #[test]
    fn masks_and_bits_are_each_others_inverse() {
        for bits in 0..=255u8 {
            assert_eq!(f32x8::pack(f32x8::unpack(bits)), bits);
        }
    }
}
