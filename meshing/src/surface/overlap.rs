//! Do two triangles of one mesh meet anywhere but in what they share?
//!
//! All decisions are signs from [`predicates`](super::predicates), so nearly touching sheets are told from crossing ones
//! without a tolerance. Triangles are closed sets: touching counts as meeting. Two triangles that share nothing meet
//! exactly if an edge of one meets the other. If they share a corner v, their intersection is convex and contains v, so
//! anything beyond v reaches the edge opposite to v of one of them. If they share an edge, they meet beyond it only when
//! folded flat onto each other.

use std::cmp::Ordering;

use glam::{DVec2, DVec3};

use super::predicates::{orient2d, orient3d};

/// A point where triangles `s` and `t` meet beyond their common vertices (by index); `None` if they don't, or if they
/// have the same three vertices. Neither may be degenerate.
pub(super) fn meeting_point(vertices: &[DVec3], s: [u32; 3], t: [u32; 3]) -> Option<DVec3> {
    let at = |v: u32| vertices[v as usize];
    let shared: Vec<usize> = (0..3).filter(|&i| t.contains(&s[i])).collect();
    match shared[..] {
        [] => {
            let (s, t) = (s.map(at), t.map(at));
            let apart = |s: [DVec3; 3], t: [DVec3; 3]| {
                let side = t.map(|p| orient3d(s[0], s[1], s[2], p));
                side[0] != Ordering::Equal && side[0] == side[1] && side[0] == side[2]
            };
            if apart(s, t) || apart(t, s) {
                return None;
            }
            (0..3)
                .find_map(|i| segment_meets(s[i], s[(i + 1) % 3], t).or_else(|| segment_meets(t[i], t[(i + 1) % 3], s)))
        }
        [i] => {
            let j = (0..3).find(|&j| t[j] == s[i])?;
            let opposite = |t: [u32; 3], i: usize| (at(t[(i + 1) % 3]), at(t[(i + 2) % 3]));
            let (a, b) = opposite(s, i);
            let (c, d) = opposite(t, j);
            segment_meets(a, b, t.map(at)).or_else(|| segment_meets(c, d, s.map(at)))
        }
        [i, j] => {
            let (u, v, a) = (at(s[i]), at(s[j]), at(s[3 - i - j]));
            let b = at(t.into_iter().find(|w| !s.contains(w))?);
            if orient3d(u, v, a, b) != Ordering::Equal {
                return None;
            }
            let flat = flattener([u, v, a]);
            let same_side = orient2d(flat(u), flat(v), flat(a)) == orient2d(flat(u), flat(v), flat(b));
            same_side.then_some((u + v) / 2.0)
        }
        _ => None,
    }
}

/// Where the closed segment p–q meets the closed triangle.
fn segment_meets(p: DVec3, q: DVec3, [a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let (at_p, at_q) = (orient3d(a, b, c, p), orient3d(a, b, c, q));
    if at_p == at_q {
        return if at_p == Ordering::Equal { segment_meets_flat(p, q, [a, b, c]) } else { None };
    }
    // The line passes through the triangle if it sees all three edges turn the same way.
    let turns = [orient3d(p, q, a, b), orient3d(p, q, b, c), orient3d(p, q, c, a)];
    if turns.contains(&Ordering::Less) && turns.contains(&Ordering::Greater) {
        return None;
    }
    let normal = (b - a).cross(c - a);
    let (height, rise) = (normal.dot(p - a), normal.dot(p - q));
    let t = if rise == 0.0 { 0.5 } else { (height / rise).clamp(0.0, 1.0) };
    Some(p.lerp(q, t))
}

/// The same for a segment in the plane of the triangle.
fn segment_meets_flat(p: DVec3, q: DVec3, t: [DVec3; 3]) -> Option<DVec3> {
    let flat = flattener(t);
    let f = t.map(&flat);
    let inside = |x: DVec2| {
        let turns = [orient2d(f[0], f[1], x), orient2d(f[1], f[2], x), orient2d(f[2], f[0], x)];
        !(turns.contains(&Ordering::Less) && turns.contains(&Ordering::Greater))
    };
    let (fp, fq) = (flat(p), flat(q));
    if inside(fp) {
        return Some(p);
    }
    if inside(fq) {
        return Some(q);
    }
    // Both ends outside: the segment meets the triangle only by crossing an edge. A segment along the line of an edge
    // would have to pass one of that edge's ends, and so crosses or touches another edge as well.
    (0..3).find_map(|i| {
        let (a, b) = (f[i], f[(i + 1) % 3]);
        let across = |a, b, p, q| orient2d(a, b, p) != orient2d(a, b, q);
        (across(a, b, fp, fq) && across(fp, fq, a, b)).then(|| (t[i] + t[(i + 1) % 3]) / 2.0)
    })
}

/// Drops the coordinate along which the triangle's normal is longest.
fn flattener([a, b, c]: [DVec3; 3]) -> impl Fn(DVec3) -> DVec2 {
    let n = (b - a).cross(c - a).abs();
    let axis = if n.x >= n.y && n.x >= n.z { 0 } else { 1 + usize::from(n.z > n.y) };
    move |p| DVec2::new(p[(axis + 1) % 3], p[(axis + 2) % 3])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meet(points: &[[f64; 3]], s: [u32; 3], t: [u32; 3]) -> bool {
        let vertices: Vec<DVec3> = points.iter().map(|&p| DVec3::from_array(p)).collect();
        let turned = |t: [u32; 3], k: usize| [t[k % 3], t[(k + 1) % 3], t[(k + 2) % 3]];
        let first = meeting_point(&vertices, s, t).is_some();
        for k in 0..9 {
            assert_eq!(
                meeting_point(&vertices, turned(t, k), turned(s, k / 3)).is_some(),
                first,
                "order must not matter"
            );
        }
        first
    }

    #[test]
    fn apart_crossing_touching() {
        let base = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let with = |t: [[f64; 3]; 3]| [base, t].concat();
        let (s, t) = ([0, 1, 2], [3, 4, 5]);
        assert!(meet(&with([[0.2, 0.2, -1.0], [0.3, 0.2, 1.0], [0.2, 0.3, 1.0]]), s, t), "pierces");
        assert!(!meet(&with([[0.2, 0.2, 1e-300], [0.3, 0.2, 1.0], [0.2, 0.3, 1.0]]), s, t), "hovers");
        assert!(meet(&with([[0.2, 0.2, 0.0], [0.3, 0.2, 1.0], [0.2, 0.3, 1.0]]), s, t), "stands on it");
        assert!(!meet(&with([[0.6, 0.6, -1.0], [0.7, 0.6, 1.0], [0.6, 0.7, 1.0]]), s, t), "passes beside it");
        assert!(meet(&with([[0.1, 0.1, 0.0], [0.3, 0.1, 0.0], [0.1, 0.3, 0.0]]), s, t), "lies in it");
        assert!(meet(&with([[-1.0, -1.0, 0.0], [5.0, -1.0, 0.0], [-1.0, 5.0, 0.0]]), s, t), "covers it");
        assert!(meet(&with([[-0.1, 0.2, 0.0], [2.0, 0.2, 0.0], [-0.1, 0.3, 0.0]]), s, t), "strip across it");
        assert!(!meet(&with([[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [1.0, 2.0, 0.0]]), s, t), "beside it in its plane");
        assert!(meet(&with([[-1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), s, t), "abuts along an edge");
    }

    #[test]
    fn neighbours_meet_only_beyond_what_they_share() {
        let fan = |d: [f64; 3], e: [f64; 3]| [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], d, e];
        assert!(!meet(&fan([-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]), [0, 1, 2], [0, 3, 4]), "bow tie");
        assert!(meet(&fan([1.0, 1.0, 0.0], [0.0, 0.0, 1.0]), [0, 1, 2], [0, 3, 4]), "slices through the shared corner");
        assert!(meet(&fan([0.2, 0.1, 0.0], [0.1, 0.2, 0.0]), [0, 1, 2], [0, 3, 4]), "small wedge in the same plane");
        assert!(!meet(&fan([1.0, 1.0, 1e-12], [0.0, 0.0, 1.0]), [0, 1, 2], [0, 3, 4]), "leaves the plane");
        let flap = |d: [f64; 3]| [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], d];
        assert!(!meet(&flap([0.5, -1.0, 0.0]), [0, 1, 2], [1, 0, 3]), "flat neighbours");
        assert!(meet(&flap([0.5, 1.0, 0.0]), [0, 1, 2], [1, 0, 3]), "folded flat");
        assert!(!meet(&flap([0.5, 1.0, 1e-12]), [0, 1, 2], [1, 0, 3]), "a sharp fold");
    }
}
