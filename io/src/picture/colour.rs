//! Colours: sRGB and linear light, the scales of damage, speed and pieces, and tone mapping.

use glam::Vec3A;

use super::sample::hash;

/// Linear light of an sRGB colour (IEC 61966-2-1).
pub(super) fn linear(srgb: [f32; 3]) -> Vec3A {
    let one = |c: f32| if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
    Vec3A::from(srgb.map(|c| one(if c.is_finite() { c.clamp(0.0, 1.0) } else { 0.0 })))
}

/// From pale (whole) over orange to deep red (broken); `t` from 0 to 1.
pub(super) fn damage(t: f32) -> Vec3A {
    scale(&[[0.87, 0.88, 0.89], [0.96, 0.80, 0.53], [0.90, 0.42, 0.22], [0.58, 0.07, 0.13]], t)
}

/// From blue (−1, shorter) over pale to red (1, longer), readable without colour vision (after Brewer's red-blue).
pub(super) fn stretch(t: f32) -> Vec3A {
    let stops = [[0.13, 0.40, 0.67], [0.57, 0.77, 0.87], [0.94, 0.94, 0.93], [0.96, 0.65, 0.51], [0.70, 0.09, 0.17]];
    scale(&stops, 0.5 + 0.5 * if t.is_finite() { t } else { 0.0 })
}

/// Dark blue over green to yellow, readable without colour vision (after viridis, Smith and van der Walt 2015).
pub(super) fn speed(t: f32) -> Vec3A {
    scale(&[[0.27, 0.00, 0.33], [0.23, 0.32, 0.55], [0.13, 0.57, 0.55], [0.37, 0.79, 0.38], [0.99, 0.91, 0.14]], t)
}

/// A colour of its own for a piece: hues by the golden ratio, lightness in three steps.
pub(super) fn piece(number: u32) -> Vec3A {
    let turn = number.wrapping_mul(2_654_435_769) as f32 / 4_294_967_296.0;
    let light = 0.66 + 0.10 * (hash(number) % 3) as f32;
    let channel = |shift: f32| {
        let x = ((turn + shift).fract() * 6.0 - 3.0).abs() - 1.0;
        light * (1.0 - 0.42 * (1.0 - x.clamp(0.0, 1.0)))
    };
    linear([channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0)])
}

fn scale(stops: &[[f32; 3]], t: f32) -> Vec3A {
    let t = if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 } * (stops.len() - 1) as f32;
    let k = (t as usize).min(stops.len() - 2);
    linear(stops[k]).lerp(linear(stops[k + 1]), t - k as f32)
}

/// Bytes of sRGB for linear `light`: a filmic curve (Hable-like shoulder, fitted by Narkowicz 2015) that keeps bright
/// porcelain from burning out, then the sRGB curve. Half a step of noise by `pixel` hides bands in smooth gradients.
pub(super) fn to_bytes(light: Vec3A, pixel: u32) -> [u8; 3] {
    let x = light.clamp(Vec3A::ZERO, Vec3A::splat(1e4)) * 0.64;
    let x = (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
    let noise = hash(pixel) as f32 / 4_294_967_296.0 - 0.5;
    x.to_array().map(|c| {
        let c = c.clamp(0.0, 1.0);
        let s = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (s * 255.0 + 0.5 + noise).clamp(0.0, 255.0) as u8
    })
}
