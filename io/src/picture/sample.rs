//! Where rays go: evenly spread numbers that differ from pixel to pixel.
//!
//! Each pixel walks an additive recurrence (R-sequence: steps from the generalised golden ratio, Roberts 2018) from a
//! start that a hash of the pixel gives. The samples of one pixel, and their shadow rays, so cover their range evenly.

use std::f32::consts::TAU;

use glam::Vec3A;

/// The random numbers of one pixel.
pub(super) struct Sampler {
    seed: u32,
    index: u32,
}

impl Sampler {
    pub fn new([x, y]: [u32; 2]) -> Self {
        Self { seed: hash(x ^ hash(y)), index: 0 }
    }

    /// Goes to sample `index` of the pixel.
    pub fn start(&mut self, index: u32) {
        self.index = index;
    }

    /// Two numbers in [0, 1) for purpose `stream`, evenly spread over the samples of this pixel.
    pub fn pair(&self, stream: u32) -> [f32; 2] {
        // 2³²/g and 2³²/g², with g = 1.3247… the root of g³ = g + 1
        let start = hash(self.seed.wrapping_add(stream.wrapping_mul(0x9E37_79B9)));
        let a = start.wrapping_add(self.index.wrapping_mul(3_242_174_889));
        let b = hash(start).wrapping_add(self.index.wrapping_mul(2_447_445_413));
        [unit(a), unit(b)]
    }
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
