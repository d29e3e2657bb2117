//! Distance from a point to a triangle, and whether a segment passes through one.

use glam::DVec3;

/// Distance from `p` to the nearest point of the triangle (Ericson, Real-Time Collision Detection, Sec. 5.1.5).
/// A triangle of no area gives the distance to one of its edges.
pub(super) fn distance(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(ac);
    let area2 = normal.length_squared();
    // Inside the prism over the triangle: the distance to the plane.
    if area2 > 0.0
        && normal.cross(ab).dot(ap) >= 0.0
        && normal.cross(c - b).dot(p - b) >= 0.0
        && normal.cross(-ac).dot(p - c) >= 0.0
    {
        return normal.dot(ap).abs() / area2.sqrt();
    }
    edge(p, a, b).min(edge(p, b, c)).min(edge(p, c, a))
}

/// Distance from `p` to the segment `a b`.
fn edge(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let ab = b - a;
    let length2 = ab.length_squared();
    let t = if length2 > 0.0 { ((p - a).dot(ab) / length2).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + ab * t)
}

/// Whether the segment from `p` to `q` passes through the triangle. Ends on opposite sides count, an end in the plane
/// belongs to the positive side; a pass through an edge counts, so that no bond slips between two triangles.
pub(super) fn crosses(p: DVec3, q: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let normal = (b - a).cross(c - a);
    let above = |x: DVec3| normal.dot(x - a) >= 0.0;
    if above(p) == above(q) {
        return false;
    }
    let d = q - p;
    let (a, b, c) = (a - p, b - p, c - p);
    let turn = [d.dot(a.cross(b)), d.dot(b.cross(c)), d.dot(c.cross(a))];
    turn.iter().all(|&t| t >= 0.0) || turn.iter().all(|&t| t <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    #[test]
    fn distance_to_face_edges_and_corners() {
        let cases = [
            (DVec3::new(0.2, 0.3, -0.5), 0.5),
            (DVec3::new(0.5, -2.0, 0.0), 2.0),
            (DVec3::new(1.0, 1.0, 0.0), 0.5f64.sqrt()),
            (DVec3::new(3.0, 0.0, 0.0), 2.0),
            (DVec3::new(-3.0, -4.0, 0.0), 5.0),
        ];
        for (p, expected) in cases {
            assert!((distance(p, CORNERS) - expected).abs() < 1e-15, "{p}");
        }
        assert_eq!(distance(DVec3::Z, [DVec3::ZERO; 3]), 1.0);
    }

    #[test]
    fn crossing_inside_on_an_edge_and_beside() {
        let at = |x: f64, y: f64| crosses(DVec3::new(x, y, -1.0), DVec3::new(x, y, 1.0), CORNERS);
        assert!(at(0.2, 0.2) && at(0.0, 0.5) && at(0.5, 0.5));
        assert!(!at(-0.1, 0.5) && !at(0.6, 0.6));
        let up = |z: f64| DVec3::new(0.2, 0.2, z);
        assert!(!crosses(up(0.1), up(2.0), CORNERS));
        assert!(crosses(up(0.0), up(-1.0), CORNERS) && !crosses(up(0.0), up(1.0), CORNERS));
        assert!(!crosses(up(-1.0), up(1.0), [DVec3::ZERO; 3]));
    }
}
