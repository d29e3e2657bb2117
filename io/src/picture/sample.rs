//! Where rays go: evenly spread numbers that neighbouring pixels share out among themselves.
//!
//! All numbers come from one additive recurrence (R-sequence: steps from the generalised golden ratio, Roberts 2018).
//! The 16 pixels of each 4 × 4 tile take different stretches of it, so a tile together covers a light or a hemisphere
//! with 16 times the samples of a pixel, evenly; the filter averages over just such tiles. Independent random numbers
//! for each pixel, tried first, left visible grain in wide penumbrae.

use std::f32::consts::TAU;

use glam::Vec3A;

/// The random numbers of one pixel.
pub(super) struct Sampler {
    first: u32,
    index: u32,
}

impl Sampler {
    /// The numbers of the pixel at `x`, `y` if each has `samples` samples.
    pub fn new([x, y]: [u32; 2], samples: u32) -> Self {
        // Bits interleaved as in an ordered dither, so that pixels side by side are far apart in the sequence.
        let d = x ^ y;
        let tile = (d & 1) << 3 | (y & 1) << 2 | (d & 2) | (y & 2) >> 1;
        Self { first: tile.wrapping_mul(samples), index: 0 }
    }

    /// Goes to sample `index` of the pixel.
    pub fn start(&mut self, index: u32) {
        self.index = index;
    }

    /// Two numbers in [0, 1) for the place in the pixel: the same for all pixels, so that edges come out even.
    pub fn place(&self) -> [f32; 2] {
        steps(1 << 31, self.index).map(unit)
    }

    /// Two numbers in [0, 1) for purpose `stream`, evenly spread over the samples of a tile.
    pub fn pair(&self, stream: u32) -> [f32; 2] {
        let [a, b] = steps(hash(stream), self.first.wrapping_add(self.index));
        [unit(a), unit(hash(stream + 100).wrapping_add(b))]
    }
}

/// Step `index` of the recurrence: multiples of 2³²/g and 2³²/g², with g = 1.3247… the root of g³ = g + 1.
fn steps(start: u32, index: u32) -> [u32; 2] {
    [3_242_174_889, 2_447_445_413].map(|step: u32| start.wrapping_add(index.wrapping_mul(step)))
}

/// The upper 24 bits as a number in [0, 1).
fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / 16_777_216.0
}

/// A well mixed 32-bit hash (lowbias32, Wellons 2018).
pub(super) fn hash(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x7FEB_352D);
    x = (x ^ (x >> 15)).wrapping_mul(0x846C_A68B);
    x ^ (x >> 16)
}

/// An offset in pixels, −1 to 1, as likely as a tent is high.
pub(super) fn tent(u: f32) -> f32 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}

/// A direction around unit `n`, as likely as its cosine.
pub(super) fn cosine(n: Vec3A, [u, v]: [f32; 2]) -> Vec3A {
    let (a, b) = n.any_orthonormal_pair();
    let (sin, cos) = (TAU * v).sin_cos();
    let r = u.sqrt();
    a * (r * cos) + b * (r * sin) + n * (1.0 - u).max(0.0).sqrt()
}

/// A direction in the cone around unit `axis` whose half angle has tangent `spread`.
pub(super) fn cone(axis: Vec3A, spread: f32, [u, v]: [f32; 2]) -> Vec3A {
    let (a, b) = axis.any_orthonormal_pair();
    let (sin, cos) = (TAU * v).sin_cos();
    let r = spread * u.sqrt();
    (axis + a * (r * cos) + b * (r * sin)).normalize()
}
