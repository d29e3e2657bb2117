//! The parts of the renderer by themselves.

use glam::Vec3A;

use crate::picture::{colour, sample};
use sample::Sampler;

/// All pairs of one 4 × 4 tile with 4 samples a pixel.
fn tile(stream: u32) -> Vec<[f32; 2]> {
    let pixels = (0..16).map(|k| [36 + k % 4, 8 + k / 4]);
    pixels
        .flat_map(|at| {
            let mut sampler = Sampler::new(at, 4);
            (0..4).map(move |k| {
                sampler.start(k);
                sampler.pair(stream)
            })
        })
        .collect()
}

#[test]
fn a_tile_covers_the_unit_square_evenly() {
    for stream in 0..10 {
        let mut counts = [0; 16];
        for [u, v] in tile(stream) {
            assert!((0.0..1.0).contains(&u) && (0.0..1.0).contains(&v));
            counts[(u * 4.0) as usize * 4 + (v * 4.0) as usize] += 1;
        }
        // 64 points in 16 cells: 4 each; measured 3 to 6. Independent ones would leave some cell with 0 or 1.
        assert!(counts.iter().all(|c| (2..=6).contains(c)), "{stream}: {counts:?}");
    }
}

#[test]
fn directions_follow_their_distributions() {
    let n = Vec3A::new(0.6, -0.48, 0.64);
    let cosines: Vec<f32> = tile(1).into_iter().map(|uv| sample::cosine(n, uv).dot(n)).collect();
    let mean = cosines.iter().sum::<f32>() / 64.0;
    // The mean cosine of a cosine-weighted hemisphere is 2/3; measured within 0.01.
    assert!((mean - 2.0 / 3.0).abs() < 0.03, "{mean}");
    for uv in tile(2) {
        let d = sample::cone(n, 0.1, uv);
        assert!((d.length() - 1.0).abs() < 1e-6 && d.dot(n) > (0.1_f32).atan().cos() - 1e-6);
    }
    let tents: f32 = tile(3).iter().map(|uv| sample::tent(uv[0])).sum();
    assert!(tents.abs() / 64.0 < 0.05 && sample::tent(0.0) == -1.0, "{tents}");
}

#[test]
fn brighter_light_gives_brighter_bytes_and_nothing_overflows() {
    let mut last = 0;
    for k in 0..200 {
        let [r, g, b] = colour::to_bytes(Vec3A::splat(k as f32 * 0.02), 7);
        assert!(r >= last && r == g && g == b, "{k}");
        last = r;
    }
    assert!(last > 240);
    assert_eq!(colour::to_bytes(Vec3A::splat(f32::INFINITY), 7), [255; 3]);
    assert_eq!(colour::to_bytes(Vec3A::splat(-1.0), 7)[0], 0);
    // 0.5 in sRGB is 0.2140 of the light (IEC 61966-2-1).
    assert!((colour::linear([0.5, 0.0, 1.0]) - Vec3A::new(0.2140, 0.0, 1.0)).abs().max_element() < 1e-4);
    assert_eq!(colour::damage(f32::NAN), colour::damage(0.0));
    assert_eq!(colour::speed(9.0), colour::speed(1.0));
}
