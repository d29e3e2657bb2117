//! Plane polygons with holes as triangles, over all their vertices and no others but the middles of spanning edges.
//!
//! Ears are cut one by one, the best shaped first. No vertex is left out, not even one in the middle of a straight side, for
//! neighbours have it too; and there is always a result, for rounding may have bent a thin polygon into itself.

use std::cmp::Ordering;

use glam::DVec2;

use crate::surface::predicates::orient2d;

/// Above this many vertices the first ear is taken, not the best.
const CHOOSY: usize = 200;

/// Triangulates a polygon. `at[i]` is where vertex `i` lies; `outer` turns counter-clockwise, `holes` clockwise. The
/// triangles turn as `outer` does, and use every side of it and of the holes once.
pub(super) fn triangulate(at: &[DVec2], outer: &[u32], holes: &[Vec<u32>]) -> Vec<[u32; 3]> {
    let mut ring = outer.to_vec();
    let mut holes: Vec<&Vec<u32>> = holes.iter().collect();
    // from right to left, so that a bridge need not cross a hole that comes later
    let right = |hole: &[u32]| hole.iter().map(|&v| at[v as usize].x).fold(f64::NEG_INFINITY, f64::max);
    holes.sort_by(|a, b| right(b).total_cmp(&right(a)));
    for k in 0..holes.len() {
        bridge(at, &mut ring, &holes[k..]);
    }
    let mut out = Vec::with_capacity(ring.len().saturating_sub(2));
    while ring.len() > 3 {
        let i = best_ear(at, &ring);
        out.push(corner(&ring, i));
        ring.remove(i);
    }
    if let [a, b, c] = ring[..] {
        out.push([a, b, c]);
    }
    out
}

fn corner(ring: &[u32], i: usize) -> [u32; 3] {
    let n = ring.len();
    [ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]]
}

/// Joins the first of `holes` to `ring` by a bridge walked twice: the shortest one that meets nothing.
fn bridge(at: &[DVec2], ring: &mut Vec<u32>, holes: &[&Vec<u32>]) {
    let hole = holes[0];
    let p = |v: u32| at[v as usize];
    let mut pairs: Vec<(usize, usize)> = (0..ring.len()).flat_map(|i| (0..hole.len()).map(move |j| (i, j))).collect();
    let length = |&(i, j): &(usize, usize)| p(ring[i]).distance_squared(p(hole[j]));
    pairs.sort_by(|a, b| length(a).total_cmp(&length(b)));
    let free = |&&(i, j): &&(usize, usize)| {
        let (a, b) = (p(ring[i]), p(hole[j]));
        let meets = |ring: &[u32]| (0..ring.len()).any(|k| crosses(a, b, p(ring[k]), p(ring[(k + 1) % ring.len()])));
        // of several copies of a vertex that bridges made, the one that opens towards the hole
        let [before, here, after] = corner(ring, i).map(p);
        let opens = if orient2d(before, here, after) == Ordering::Less {
            orient2d(here, after, b) != Ordering::Less || orient2d(before, here, b) != Ordering::Less
        } else {
            orient2d(here, after, b) != Ordering::Less && orient2d(before, here, b) != Ordering::Less
        };
        opens && !meets(ring) && !holes.iter().any(|h| meets(h))
    };
    let (i, j) = pairs.iter().find(free).copied().unwrap_or(pairs[0]);
    let around = (0..=hole.len()).map(|k| hole[(j + k) % hole.len()]);
    let joined: Vec<u32> = around.chain(std::iter::once(ring[i])).collect();
    ring.splice(i + 1..i + 1, joined);
}

/// Whether a–b and c–d meet other than at a common end.
fn crosses(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    if a == c || a == d || b == c || b == d {
        return false;
    }
    let (c_side, d_side) = (orient2d(a, b, c), orient2d(a, b, d));
    let (a_side, b_side) = (orient2d(c, d, a), orient2d(c, d, b));
    if c_side == Ordering::Equal && d_side == Ordering::Equal {
        let along = b - a;
        let (s, t) = ((c - a).dot(along), (d - a).dot(along));
        return s.max(t) >= 0.0 && s.min(t) <= along.length_squared();
    }
    c_side != d_side && a_side != b_side
}

/// The ear to be cut next; where rounding left none, the corner that turns least to the right.
fn best_ear(at: &[DVec2], ring: &[u32]) -> usize {
    let (mut best, mut found) = (0, (false, f64::NEG_INFINITY));
    for i in 0..ring.len() {
        let [a, b, c] = corner(ring, i).map(|v| at[v as usize]);
        let ear = is_ear(at, ring, i);
        let doubled = (b - a).perp_dot(c - a);
        let quality = if ear {
            // the area over the squared edges falls with the smallest angle
            doubled / (a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a))
        } else {
            doubled
        };
        if (ear, quality) > found {
            (best, found) = (i, (ear, quality));
            if ear && ring.len() > CHOOSY {
                break;
            }
        }
    }
    best
}

/// Whether corner `i` turns left and no other vertex lies in its triangle.
fn is_ear(at: &[DVec2], ring: &[u32], i: usize) -> bool {
    let [a, b, c] = corner(ring, i).map(|v| at[v as usize]);
    if orient2d(a, b, c) != Ordering::Greater {
        return false;
    }
    let inside = |q: DVec2| {
        let corner = q == a || q == b || q == c;
        !corner && [(a, b), (b, c), (c, a)].iter().all(|&(s, t)| orient2d(s, t, q) != Ordering::Less)
    };
    !ring.iter().any(|&v| inside(at[v as usize]))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Checks that sides are used once, inner edges twice, and returns the area.
    fn check(at: &[DVec2], outer: &[u32], holes: &[Vec<u32>]) -> f64 {
        let triangles = triangulate(at, outer, holes);
        let n = outer.len() + holes.iter().map(|h| h.len() + 2).sum::<usize>();
        assert_eq!(triangles.len(), n - 2);
        let mut edges: BTreeMap<(u32, u32), i32> = BTreeMap::new();
        let mut add = |a: u32, b: u32, by: i32| {
            *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { by } else { -by };
        };
        for [a, b, c] in &triangles {
            [(a, b), (b, c), (c, a)].iter().for_each(|&(s, t)| add(*s, *t, 1));
        }
        for ring in holes.iter().map(Vec::as_slice).chain([outer]) {
            (0..ring.len()).for_each(|k| add(ring[k], ring[(k + 1) % ring.len()], -1));
        }
        assert!(edges.values().all(|&n| n == 0), "{edges:?}");
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| at[v as usize]);
            (b - a).perp_dot(c - a) / 2.0
        };
        assert!(triangles.iter().all(|t| area(t) >= 0.0), "{triangles:?}");
        triangles.iter().map(area).sum()
    }

    fn circle(at: &mut Vec<DVec2>, centre: DVec2, radius: f64, n: usize, back: bool) -> Vec<u32> {
        let first = at.len() as u32;
        for k in 0..n {
            let angle = std::f64::consts::TAU * k as f64 / n as f64 * if back { -1.0 } else { 1.0 };
            at.push(centre + radius * DVec2::from_angle(angle));
        }
        (first..first + n as u32).collect()
    }

    #[test]
    fn squares_with_points_on_their_sides_keep_them() {
        let at: Vec<DVec2> = [(0., 0.), (1., 0.), (2., 0.), (2., 1.), (2., 2.), (1., 2.), (0., 2.), (0., 1.)]
            .map(|(x, y)| DVec2::new(x, y))
            .into();
        assert_eq!(check(&at, &[0, 1, 2, 3, 4, 5, 6, 7], &[]), 4.0);
    }

    #[test]
    fn bent_polygons_and_holes_are_filled_exactly() {
        let mut at: Vec<DVec2> = Vec::new();
        let outer = circle(&mut at, DVec2::ZERO, 2.0, 40, false);
        for (k, v) in outer.iter().enumerate() {
            at[*v as usize] *= if k % 2 == 0 { 1.0 } else { 0.7 };
        }
        let star: f64 = check(&at, &outer, &[]);
        let holes: Vec<Vec<u32>> = [(-0.5, 0.3), (0.6, 0.2), (0.0, -0.8), (0.1, 0.9)]
            .iter()
            .map(|&(x, y)| circle(&mut at, DVec2::new(x, y), 0.25, 11, true))
            .collect();
        let one = 11.0 / 2.0 * 0.25f64.powi(2) * (std::f64::consts::TAU / 11.0).sin();
        assert!((check(&at, &outer, &holes) - (star - 4.0 * one)).abs() < 1e-12); // measured 4e-15
    }

    #[test]
    fn flat_and_folded_polygons_still_give_every_side_once() {
        // a line, and a bow tie
        for at in [[(0., 0.), (1., 0.), (2., 0.), (1., 0.)], [(0., 0.), (1., 1.), (1., 0.), (0., 1.)]] {
            let at = at.map(|(x, y)| DVec2::new(x, y));
            assert_eq!(triangulate(&at, &[0, 1, 2, 3], &[]).len(), 2);
        }
    }
}
