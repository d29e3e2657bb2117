//! A vase: foot, round belly, narrow neck, flared rim.
//!
//! The outer contour is one cubic B-spline, so its curvature has no jumps that the light would show. The inner contour is
//! the outer one moved inwards by the wall, down to the thick base, where it turns into a bowl; a half circle joins both
//! at the rim. Tried: Catmull-Rom through the widest and narrowest points, which dents the shoulder.

use std::f64::consts::PI;

use glam::DVec2;

use super::{ShapeError, length, revolution};
use crate::TriMesh;

/// Control points (r, y) of the outer contour from foot to rim, as fractions of the height. The spline touches the first
/// and the last and stays inside the polygon of the others.
const CONTOUR: [(f64, f64); 11] = [
    (0.152, 0.000),
    (0.152, 0.030),
    (0.116, 0.052),
    (0.138, 0.120),
    (0.252, 0.262),
    (0.296, 0.455),
    (0.278, 0.640),
    (0.142, 0.735),
    (0.121, 0.852),
    (0.142, 0.958),
    (0.200, 1.000),
];

/// A porcelain vase on the plane y = 0 with its axis along y, as a closed solid with a wall: `height` and `wall` in metres,
/// the wall 0.01 to 0.06 of the height, `segments` (8 to 10 000) around. For height 0.3 the belly has a radius of about
/// 0.085, the neck 0.04 and the rim 0.06. Triangles are about as wide as high at the belly.
///
/// # Errors
/// A height outside 1e-9 to 1e9 m, a wall that does not fit, a number of segments out of range.
pub fn vase(height: f64, wall: f64, segments: usize) -> Result<TriMesh, ShapeError> {
    if !(8..=10_000).contains(&segments) {
        let (value, wanted) = (segments as f64, "8 to 10000");
        return Err(ShapeError::OutOfRange { shape: "vase", name: "segments", value, wanted });
    }
    length("vase", "height", height)?;
    let belly = 0.283 * height;
    revolution(&vase_profile(height, wall, 2.0 * PI * belly / segments as f64)?, segments)
}

/// The outline (r, y) [m] of [`vase`] from the centre of the foot, up outside, over the rim, down inside to the floor, in
/// steps of about `spacing` [m] (at most a tenth of the height; finer where the rim turns).
///
/// # Errors
/// Those of [`vase`].
pub fn vase_profile(height: f64, wall: f64, spacing: f64) -> Result<Vec<(f64, f64)>, ShapeError> {
    length("vase", "height", height)?;
    length("vase", "spacing", spacing)?;
    if !(0.01 * height..=0.06 * height).contains(&wall) {
        return Err(ShapeError::WallDoesNotFit { wall, height });
    }
    let spacing = spacing.clamp(1e-3 * height, 0.1 * height);
    let control = contour(height, wall);
    let outer = |t: f64| spline(&control, t).0;
    let inward = |t: f64| spline(&control, t).1.normalize().perp();
    let inner = |t: f64| outer(t) + wall * inward(t);

    // Floor of the cavity, and where on the wall the bowl begins.
    let floor = 0.035 * height + 0.8 * wall;
    let bowl_top = bisect(|t| inner(t).y - floor - 0.10 * height);
    let from = inner(bowl_top);
    let down = (inner(bowl_top) - inner(bowl_top + 1e-4)).normalize();
    let handle = 0.6 * (from.y - floor);
    let bowl = [from, from + handle * down, DVec2::new(0.62 * from.x, floor), DVec2::new(0.0, floor)];

    let foot = outer(0.0);
    let lip = (outer(1.0) + inner(1.0)) / 2.0;
    // From the outer side over the end of the contour, whose tangent is the inward normal turned back.
    let (out, up) = (outer(1.0) - lip, -inward(1.0).perp() * (wall / 2.0));

    let mut outline = Vec::new();
    sample(&mut outline, 1, spacing, |t| foot * t);
    sample(&mut outline, 8, spacing, outer);
    sample(&mut outline, 6, spacing, |t| lip + out * (PI * t).cos() + up * (PI * t).sin());
    sample(&mut outline, 8, spacing, |t| inner(1.0 - t * (1.0 - bowl_top)));
    sample(&mut outline, 4, spacing, |t| bezier(&bowl, t));
    outline.push(bowl[3]);
    Ok(outline.into_iter().map(|p| (p.x, p.y)).collect())
}

/// The control points in metres, the last two shifted so that the top of the rounded rim is at `height`.
fn contour(height: f64, wall: f64) -> Vec<DVec2> {
    let mut control: Vec<DVec2> = CONTOUR.iter().map(|&(r, y)| height * DVec2::new(r, y)).collect();
    let n = control.len();
    // The rim ends along the last control side; its half circle of radius wall/2 is centred half a wall inwards.
    let inward = (control[n - 1] - control[n - 2]).normalize().perp();
    let top = control[n - 1].y + wall / 2.0 * (inward.y + 1.0);
    for p in &mut control[n - 2..] {
        p.y += height - top;
    }
    control
}

/// Point and derivative of the clamped uniform cubic B-spline at t in [0, 1].
fn spline(control: &[DVec2], t: f64) -> (DVec2, DVec2) {
    let n = control.len();
    // Knots 0 0 0 0 1 2 … m m m m; de Boor's algorithm on the span that holds t.
    let m = n - 3;
    let x = t.clamp(0.0, 1.0) * m as f64;
    let span = (x as usize).min(m - 1);
    let knot = |i: usize| (i as f64 - 3.0).clamp(0.0, m as f64);
    let mut d = [0, 1, 2, 3].map(|i| control[span + i]);
    let mut slope = DVec2::ZERO;
    for level in 1..4 {
        if level == 3 {
            slope = 3.0 * m as f64 * (d[3] - d[2]) / (knot(span + 4) - knot(span + 3));
        }
        for i in (level..4).rev() {
            let (low, high) = (knot(span + i), knot(span + i + 4 - level));
            d[i] = d[i - 1].lerp(d[i], (x - low) / (high - low));
        }
    }
    (d[3], slope)
}

fn bezier(p: &[DVec2; 4], t: f64) -> DVec2 {
    let s = 1.0 - t;
    p[0] * (s * s * s) + p[1] * (3.0 * s * s * t) + p[2] * (3.0 * s * t * t) + p[3] * (t * t * t)
}

/// The t in [0, 1] where the increasing function `f` is 0.
fn bisect(f: impl Fn(f64) -> f64) -> f64 {
    let (mut lo, mut hi) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = (lo + hi) / 2.0;
        if f(middle) < 0.0 {
            lo = middle;
        } else {
            hi = middle;
        }
    }
    (lo + hi) / 2.0
}

/// Points of the curve about `spacing` apart, closer where it turns (a turn of 1 rad counts like `spacing`), at least
/// `least` of them, without its end.
fn sample(out: &mut Vec<DVec2>, least: usize, spacing: f64, curve: impl Fn(f64) -> DVec2) {
    const FINE: usize = 2000;
    let points: Vec<DVec2> = (0..=FINE).map(|i| curve(i as f64 / FINE as f64)).collect();
    let mut run = vec![0.0];
    for i in 0..FINE {
        let step = points[i + 1] - points[i];
        let turn = if i == 0 { 0.0 } else { (points[i] - points[i - 1]).angle_to(step).abs() };
        run.push(run[i] + step.length() + turn * spacing);
    }
    let whole = run[FINE];
    let n = ((whole / spacing).round() as usize).max(least);
    for k in 0..n {
        let at = whole * k as f64 / n as f64;
        let i = run.partition_point(|&r| r <= at).clamp(1, FINE) - 1;
        out.push(points[i].lerp(points[i + 1], (at - run[i]) / (run[i + 1] - run[i])));
    }
}
