//! The light of a pixel in parts, and a filter for the two noisy ones.
//!
//! Only the visibility of the key light and the openness of the sky are random. Both are numbers between 0 and 1, so
//! they are smoothed alone, with weights that fall off across edges of the surface (à-trous wavelets, Dammertz et
//! al. 2010), while colours and crack edges stay sharp.

use glam::Vec3A;
use rayon::prelude::*;

/// Sums, then means, over the samples of a pixel.
#[derive(Clone, Copy, Default)]
pub(super) struct Pixel {
    key: Vec3A,
    sky: Vec3A,
    rest: Vec3A,
    normal: Vec3A,
    depth: f32,
    /// Visibility of the key and openness of the sky, weighted by the light they scale.
    seen: [f32; 2],
    weight: [f32; 2],
    samples: f32,
}

impl Pixel {
    /// Adds one sample. A bright one counts for less, or the edge of white on grey would look like a staircase: the
    /// eye sees the mean after tone mapping. The weight does not know of shadows, so penumbrae keep their level.
    pub fn add(&mut self, key: Vec3A, sky: Vec3A, rest: Vec3A, seen: [f32; 2], normal: Vec3A, depth: f32) {
        let share = 1.0 / (1.0 + 0.5 * (key + sky + rest).element_sum());
        let (key, sky) = (key * share, sky * share);
        self.key += key;
        self.sky += sky;
        self.rest += rest * share;
        self.normal += normal * share;
        self.depth += depth * share;
        self.samples += share;
        let weight = [key.element_sum() + 1e-6, sky.element_sum() + 1e-6];
        for k in 0..2 {
            self.seen[k] += seen[k] * weight[k];
            self.weight[k] += weight[k];
        }
    }

    /// Divides by the weight of the samples.
    pub fn mean(mut self) -> Self {
        let part = 1.0 / self.samples;
        for v in [&mut self.key, &mut self.sky, &mut self.rest, &mut self.normal] {
            *v *= part;
        }
        self.depth *= part;
        for k in 0..2 {
            self.seen[k] /= self.weight[k];
        }
        self
    }

    /// The sum of all light.
    pub fn light(&self) -> Vec3A {
        self.key * self.seen[0] + self.sky * self.seen[1] + self.rest
    }
}

/// Smooths the visibilities of all pixels of a picture `width` wide, unless they had `samples` enough to be smooth.
/// Steps of 1 and 2 together cancel all patterns that repeat every 2 or 4 pixels, as those of the samples do.
pub(super) fn smooth(pixels: &mut [Pixel], width: usize, samples: u32) {
    let passes: &[usize] = match samples {
        0..=32 => &[1, 2],
        _ => &[],
    };
    for &step in passes {
        let smoothed: Vec<[f32; 2]> = (0..pixels.len())
            .into_par_iter()
            .with_min_len(4096)
            .map(|k| around(pixels, width, k % width, k / width, step))
            .collect();
        for (pixel, seen) in pixels.iter_mut().zip(smoothed) {
            pixel.seen = seen;
        }
    }
}

/// The weighted mean over 5 × 5 pixels, `step` apart, around one.
fn around(pixels: &[Pixel], width: usize, x: usize, y: usize, step: usize) -> [f32; 2] {
    const KERNEL: [f32; 5] = [1.0, 4.0, 6.0, 4.0, 1.0];
    let centre = &pixels[y * width + x];
    if centre.normal == Vec3A::ZERO {
        return centre.seen;
    }
    let height = pixels.len() / width;
    let mut sum = [0.0; 2];
    let mut total = 0.0;
    for (j, kj) in KERNEL.iter().enumerate() {
        let Some(row) = (y + j * step).checked_sub(2 * step).filter(|&r| r < height) else { continue };
        for (i, ki) in KERNEL.iter().enumerate() {
            let Some(column) = (x + i * step).checked_sub(2 * step).filter(|&c| c < width) else { continue };
            let other = &pixels[row * width + column];
            let bend = (centre.normal - other.normal).length_squared();
            let jump = (centre.depth - other.depth) / (centre.depth * 0.004 * step as f32 + 1e-6);
            let weight = ki * kj / ((1.0 + 60.0 * bend) * (1.0 + jump * jump));
            sum[0] += weight * other.seen[0];
            sum[1] += weight * other.seen[1];
            total += weight;
        }
    }
    [sum[0] / total, sum[1] / total]
}
