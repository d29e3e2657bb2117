//! What the bond passes gather of a particle: one 48-byte record, or its f64 counterpart for reference.
//!
//! The displacement is kept as a pair hi + lo of f32 and differences are taken pair-wise, so a fragment that flies far
//! from its body's frame keeps its precision: with one f32 it would jitter by 6e-8 of the distance every step, and
//! heat up (measured: about 1e-4 m/s per step and particle at 1 m distance and dt = 1e-4 s).

use std::ops::Sub;

use glam::{DVec3, Vec3};
use wide::{f32x8, u32x8};

use crate::bonds::CHUNK;
use crate::lane::{Lane, Mask8};

/// A particle as the passes see it.
pub trait Record: Copy + Send + Sync + 'static {
    /// The lane that reads this record.
    type Lane: Kernel<Record = Self>;
    /// Rest position x [m], displacement u in the frame [m], volume V [m³], inverse weighted volume [1/m⁵].
    fn new(x: Vec3, u: DVec3, volume: f64, inv_m: f64) -> Self;
    /// Sets the dilatation θ [1].
    fn set_theta(&mut self, theta: f64);
}

/// The neighbours' side of a chunk of bonds, relative to the row's own particle.
#[derive(Clone, Copy)]
pub struct Gathered<L> {
    /// Rest bond ξ = x_j − x_i [m].
    pub xi: [L; 3],
    /// Difference of displacements u_j − u_i [m].
    pub du: [L; 3],
    /// V_j [m³].
    pub volume: L,
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
    /// The first `WIDTH` neighbours, relative to `home`.
    fn gather(records: &[Self::Record], neighbours: &[u32], home: &Self::Record) -> Gathered<Self>;
    /// θ and 1/m of one record, in every number.
    fn own(record: &Self::Record) -> (Self, Self);
    /// A particle's number of the first `WIDTH` neighbours.
    fn pick_out(values: &[f64], neighbours: &[u32]) -> Self;
    /// The sum of the numbers, always in the same order.
    fn total(self) -> f64;
    /// The mask whose number `l` is bit `l`.
    fn unpack(bits: u8) -> Self::Mask;
    /// Bit `l` is number `l` of the mask.
    fn pack(mask: Self::Mask) -> u8;
}

/// Particle record for f32 lanes, 48 bytes.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(16))]
pub struct Record32 {
    x: [f32; 3],
    volume: f32,
    hi: [f32; 3],
    theta: f32,
    lo: [f32; 3],
    inv_m: f32,
}

impl Record for Record32 {
    type Lane = f32x8;
    #[inline(always)]
    fn new(x: Vec3, u: DVec3, volume: f64, inv_m: f64) -> Self {
        let hi = u.as_vec3();
        let lo = (u - hi.as_dvec3()).as_vec3();
        Self { x: x.into(), volume: volume as f32, hi: hi.into(), theta: 0.0, lo: lo.into(), inv_m: inv_m as f32 }
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
    fn gather(records: &[Record32], neighbours: &[u32], home: &Record32) -> Gathered<Self> {
        let at = Eight::new(neighbours[..CHUNK].try_into().expect("a chunk is eight"), records);
        let [x, y, z, volume] = transpose(at.quads::<0>());
        let [hx, hy, hz, theta] = transpose(at.quads::<1>());
        let [lx, ly, lz, inv_m] = transpose(at.quads::<2>());
        let own = |v: f32| f32x8::splat(v);
        Gathered {
            xi: [x - own(home.x[0]), y - own(home.x[1]), z - own(home.x[2])],
            du: [
                (hx - own(home.hi[0])) + (lx - own(home.lo[0])),
                (hy - own(home.hi[1])) + (ly - own(home.lo[1])),
                (hz - own(home.hi[2])) + (lz - own(home.lo[2])),
            ],
            volume,
            theta,
            inv_m,
        }
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

/// Eight records, to be read a third at a time.
///
/// Checked indexing reads all 24 quads before the first shuffle, spills most of them and multiplies eight addresses: half
/// of the instructions of a step. Here neighbours are held below the number of records by a minimum of vectors, so that
/// reading needs no further check. A neighbour beyond the records, which only a forged file can have, reads the last one.
struct Eight<'a> {
    records: &'a [Record32],
    /// Places in bytes: 32 bits are quicker to take out of a vector, and enough for [`MOST`] records.
    at: [u32; CHUNK],
}

/// Most particles of a body with bonds.
pub const MOST: usize = u32::MAX as usize / size_of::<Record32>();

impl<'a> Eight<'a> {
    #[inline(always)]
    fn new(neighbours: [u32; CHUNK], records: &'a [Record32]) -> Self {
        let last = u32x8::splat(records.len() as u32 - 1);
        let n = u32x8::from(neighbours).min(last);
        let (sixteen, thirty_two): (u32x8, u32x8) = (n << 4, n << 5);
        Self { records, at: (sixteen + thirty_two).to_array() }
    }

    /// The quads `K` of all eight.
    #[inline(always)]
    fn quads<const K: usize>(&self) -> [[f32; 4]; CHUNK] {
        const { assert!(size_of::<Record32>() == 48 && K < 3) };
        let base = self.records.as_ptr().cast::<u8>();
        let one = |l: usize| {
            // SAFETY: `at` is 48 times an index below the number of records, so this is a third of a record, which is plain
            // f32 and aligned to 16 bytes. (With more than MOST records `at` wraps to an earlier record.)
            unsafe { base.add(self.at[l] as usize + 16 * K).cast::<[f32; 4]>().read() }
        };
        [one(0), one(1), one(2), one(3), one(4), one(5), one(6), one(7)]
    }
}

/// Eight rows of four to four columns of eight.
#[inline(always)]
fn transpose(rows: [[f32; 4]; 8]) -> [f32x8; 4] {
    #[cfg(target_feature = "avx")]
    {
        use std::arch::x86_64::{
            __m128, __m256, _mm256_set_m128, _mm256_shuffle_ps, _mm256_unpackhi_ps, _mm256_unpacklo_ps,
        };
        // SAFETY: plain 128- and 256-bit vectors of f32, and AVX is there at build time.
        unsafe {
            let quad = |r: [f32; 4]| std::mem::transmute::<[f32; 4], __m128>(r);
            let pair = |k: usize| _mm256_set_m128(quad(rows[k + 4]), quad(rows[k]));
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
        [0, 1, 2, 3].map(|c| f32x8::from(rows.map(|row| row[c])))
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
    fn new(x: Vec3, u: DVec3, volume: f64, inv_m: f64) -> Self {
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
    fn gather(records: &[Record64], neighbours: &[u32], home: &Record64) -> Gathered<Self> {
        let r = &records[neighbours[0] as usize];
        let minus = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|k| Sub::sub(a[k], b[k]));
        Gathered { xi: minus(r.x, home.x), du: minus(r.u, home.u), volume: r.volume, theta: r.theta, inv_m: r.inv_m }
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
    fn gathering_transposes_and_subtracts_in_pairs() {
        let far = DVec3::new(1e3, -2e3, 5e2);
        let records: Vec<Record32> = (0..9)
            .map(|k| {
                let s = f64::from(k);
                let u = far + DVec3::new(s, 2.0 * s, -s) * 1e-9;
                let mut r = Record32::new(Vec3::new(k as f32, 0.5, -1.0), u, s + 1.0, 1.0 / (s + 1.0));
                r.set_theta(s * 0.1);
                r
            })
            .collect();
        let g = f32x8::gather(&records, &[1, 2, 3, 4, 5, 6, 7, 8], &records[0]);
        for l in 0..8 {
            let s = l as f32 + 1.0;
            assert_eq!(g.xi.map(|v| v.to_array()[l]), [s, 0.0, 0.0]);
            assert_eq!((g.volume.to_array()[l], g.inv_m.to_array()[l]), (s + 1.0, 1.0 / (s + 1.0)));
            assert_eq!(g.theta.to_array()[l], (f64::from(s) * 0.1) as f32);
            // at 2 km the pair resolves 2000 · 2⁻⁴⁸ = 7e-12 m; measured 5e-12
            assert!((g.du[1].to_array()[l] - 2e-9 * s).abs() < 1e-11, "{:e}", g.du[1].to_array()[l] - 2e-9 * s);
        }
    }

    #[test]
    fn masks_and_bits_are_each_others_inverse() {
        for bits in 0..=255u8 {
            assert_eq!(f32x8::pack(f32x8::unpack(bits)), bits);
        }
    }
}
