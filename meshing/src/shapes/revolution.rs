//! Solids of revolution.

use std::{cmp::Ordering, f64::consts::TAU};

use glam::{DVec2, DVec3};

use super::ShapeError;
use crate::{TriMesh, surface::predicates::orient2d};

/// The solid swept by a closed outline that turns about the y axis, as `segments` (3 to 100 000) flat sectors.
///
/// `profile` lists the corners (r, y) [m] of the outline once around, in either sense, the last joined to the first; r ≥ 0.
/// Points with r = 0 become poles, sides along the axis vanish. Quads are split along one and the other
/// diagonal in turn. The volume is sin(2π/n) / (2π/n) of the smooth solid's.
///
/// # Errors
/// A point across the axis or not finite, an outline that crosses or touches itself, encloses nothing or touches the
/// axis in a single point, a number of segments out of range.
pub fn revolution(profile: &[(f64, f64)], segments: usize) -> Result<TriMesh, ShapeError> {
    if !(3..=100_000).contains(&segments) {
        let (value, wanted) = (segments as f64, "3 to 100000");
        return Err(ShapeError::OutOfRange { shape: "revolution", name: "segments", value, wanted });
    }
    let outline = outward(profile)?;
    let n = outline.len();
    let on_axis = |i: usize| outline[i % n].x == 0.0;
    let mut mesh = TriMesh::default();
    // First vertex of each ring; a point between two sides on the axis makes none.
    let mut ring = Vec::with_capacity(n);
    for (i, p) in outline.iter().enumerate() {
        ring.push(mesh.vertices.len() as u32);
        if !on_axis(i) {
            for k in 0..segments {
                let (sin, cos) = (TAU * k as f64 / segments as f64).sin_cos();
                mesh.vertices.push(DVec3::new(p.x * cos, p.y, -p.x * sin));
            }
        } else if !(on_axis(i + 1) && on_axis(i + n - 1)) {
            mesh.vertices.push(DVec3::new(0.0, p.y, 0.0));
        }
    }
    let segments = segments as u32;
    for i in 0..n {
        let (lower, upper) = (ring[i], ring[(i + 1) % n]);
        for k in 0..segments {
            let next = (k + 1) % segments;
            match (on_axis(i), on_axis(i + 1)) {
                (true, true) => {}
                (true, false) => mesh.triangles.push([lower, upper + next, upper + k]),
                (false, true) => mesh.triangles.push([lower + k, lower + next, upper]),
                (false, false) => {
                    let [a, b, c, d] = [lower + k, lower + next, upper + next, upper + k];
                    // Isosceles trapezoid: both diagonals are equal. Alternate, so that the solid has no handedness.
                    if (i as u32 + k).is_multiple_of(2) {
                        mesh.triangles.extend([[a, b, c], [a, c, d]]);
                    } else {
                        mesh.triangles.extend([[a, b, d], [b, c, d]]);
                    }
                }
            }
        }
    }
    Ok(mesh)
}

/// Checks the outline and returns it counter-clockwise in the r-y plane.
fn outward(profile: &[(f64, f64)]) -> Result<Vec<DVec2>, ShapeError> {
    for (point, &(r, y)) in profile.iter().enumerate() {
        if !((0.0..=1e9).contains(&r) && y.abs() <= 1e9) {
            return Err(ShapeError::AcrossAxis { point, r, y });
        }
    }
    let n = profile.len();
    if n < 3 {
        return Err(ShapeError::Flat);
    }
    let points: Vec<DVec2> = profile.iter().map(|&(r, y)| DVec2::new(r, y)).collect();
    // Relative to the first point, so that a profile far up the axis keeps its area.
    let area: f64 =
        (0..n).map(|i| (points[i] - points[0]).perp_dot(points[(i + 1) % n] - points[0])).sum::<f64>() / 2.0;
    let size = points.iter().fold(0.0_f64, |s, p| s.max(p.distance(points[0])));
    if area.abs() <= 1e-12 * size * size {
        return Err(ShapeError::Flat);
    }
    for first in 0..n {
        for second in first + 1..n {
            let side = |i: usize| (points[i], points[(i + 1) % n]);
            let ((a, b), (c, d)) = (side(first), side(second));
            let meet = if second == first + 1 {
                folds_back(a, b, d)
            } else if (second + 1) % n == first {
                folds_back(c, d, b)
            } else {
                sides_meet(a, b, c, d)
            };
            if meet {
                return Err(ShapeError::Crossed { first, second });
            }
        }
    }
    let axis = |i: usize| points[i % n].x == 0.0;
    if let Some(point) = (0..n).find(|&i| axis(i) && !axis(i + 1) && !axis(i + n - 1)) {
        return Err(ShapeError::Pinched { point });
    }
    Ok(if area > 0.0 { points } else { points.into_iter().rev().collect() })
}

/// Do the sides a–b and b–c overlap, or has one of them no length?
fn folds_back(a: DVec2, b: DVec2, c: DVec2) -> bool {
    a == b || b == c || (orient2d(a, b, c) == Ordering::Equal && (a - b).dot(c - b) > 0.0)
}

/// Do the closed segments a–b and c–d meet?
fn sides_meet(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let boxes_apart = a.max(b).cmplt(c.min(d)).any() || c.max(d).cmplt(a.min(b)).any();
    if boxes_apart {
        return false;
    }
    let (ac, ad) = (orient2d(a, b, c), orient2d(a, b, d));
    let (ca, cb) = (orient2d(c, d, a), orient2d(c, d, b));
    // All four on one line: their boxes meet, so they do.
    (ac != ad && ca != cb) || [ac, ad, ca, cb] == [Ordering::Equal; 4]
}
