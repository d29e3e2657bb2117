//! Distance to a triangle surface, and which side of it a point lies on.
//!
//! One bounding-volume tree serves both questions. The closest point is a branch-and-bound descent. The side is the
//! generalised winding number (Jacobson et al. 2013) with a dipole for far nodes (Barill et al. 2018, first order), so
//! that small holes and self-intersections don't turn the sign over as they do with pseudonormals. A polyline is served
//! too: give each segment as a triangle with a repeated corner.
//!
//! Tried: `obvhs`, which is f32 and made for rays; here distances feed a mesher that wants f64.

use crate::TriMesh;
use glam::DVec3;

const LEAF: usize = 4;
/// A node counts as far when the point is this many radii away from its centre; errors stay below about 0.01 of a turn.
const FAR: f64 = 2.3;

/// The nearest point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The point itself [m].
    pub point: DVec3,
    /// Its distance [m], never negative.
    pub distance: f64,
    /// The triangle it lies on, as numbered in the mesh.
    pub triangle: u32,
}

struct Node {
    lo: DVec3,
    hi: DVec3,
    /// Inner node: the right child (the left one follows its parent). Leaf: the first triangle.
    next: u32,
    /// Triangles in a leaf, 0 for an inner node.
    count: u32,
    centre: DVec3,
    radius: f64,
    area_normal: DVec3,
}

/// A search tree over the triangles of a surface. Lengths in metres.
pub struct Distance {
    nodes: Vec<Node>,
    corners: Vec<[DVec3; 3]>,
    ids: Vec<u32>,
}

impl Distance {
    /// Builds the tree; O(n log² n). An empty mesh is allowed: everything is then infinitely far and outside.
    pub fn new(mesh: &TriMesh) -> Self {
        Self::of_triangles((0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect())
    }

    /// The same from corners; repeated corners make segments or points.
    pub fn of_triangles(triangles: Vec<[DVec3; 3]>) -> Self {
        let mut ids: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut nodes = Vec::with_capacity(triangles.len());
        if !ids.is_empty() {
            grow(&triangles, &mut ids, 0, &mut nodes);
        }
        let corners = ids.iter().map(|&t| triangles[t as usize]).collect();
        Self { nodes, corners, ids }
    }

    /// Whether there is nothing to be near to.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The closest point, or `None` if nothing lies within `reach` [m] (infinity is allowed).
    pub fn closest_within(&self, p: DVec3, reach: f64) -> Option<Closest> {
        if self.nodes.is_empty() {
            return None;
        }
        let mut best = if reach.is_finite() { reach * reach } else { f64::INFINITY };
        let mut found = None;
        let mut stack = [(0u32, 0.0f64); 64];
        let mut top = 1;
        stack[0] = (0, self.gap(0, p));
        while top > 0 {
            top -= 1;
            let (at, gap) = stack[top];
            if gap > best {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count > 0 {
                for k in node.next as usize..(node.next + node.count) as usize {
                    let q = closest_on_triangle(p, &self.corners[k]);
                    let d2 = p.distance_squared(q);
                    if d2 < best || (found.is_none() && d2 <= best) {
                        best = d2;
                        found = Some((q, k));
                    }
                }
            } else {
                let (l, r) = (at + 1, node.next);
                let (gl, gr) = (self.gap(l, p), self.gap(r, p));
                let (first, second) = if gl <= gr { ((l, gl), (r, gr)) } else { ((r, gr), (l, gl)) };
                stack[top] = second;
                stack[top + 1] = first;
                top += 2;
            }
        }
        found.map(|(point, k)| Closest { point, distance: best.sqrt(), triangle: self.ids[k] })
    }

    /// The closest point; `None` only for an empty surface or a point that is not finite.
    pub fn closest(&self, p: DVec3) -> Option<Closest> {
        self.closest_within(p, f64::INFINITY)
    }

    /// Unsigned distance [m]; infinite for an empty surface.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.closest(p).map_or(f64::INFINITY, |c| c.distance)
    }

    /// How often the surface winds around `p`: 1 inside, 0 outside, in between near a hole.
    pub fn winding(&self, p: DVec3) -> f64 {
        let mut sum = 0.0;
        let mut stack = [0u32; 64];
        let mut top = usize::from(!self.nodes.is_empty());
        while top > 0 {
            top -= 1;
            let at = stack[top];
            let node = &self.nodes[at as usize];
            let d = node.centre - p;
            let d2 = d.length_squared();
            if d2 > (FAR * node.radius).powi(2) {
                sum += node.area_normal.dot(d) / (d2 * d2.sqrt());
            } else if node.count > 0 {
                for c in &self.corners[node.next as usize..(node.next + node.count) as usize] {
                    sum += solid_angle(p, c);
                }
            } else {
                stack[top] = at + 1;
                stack[top + 1] = node.next;
                top += 2;
            }
        }
        sum / (4.0 * std::f64::consts::PI)
    }

    /// Whether the surface winds around `p` by at least half a turn.
    pub fn inside(&self, p: DVec3) -> bool {
        self.winding(p) > 0.5
    }

    fn gap(&self, node: u32, p: DVec3) -> f64 {
        let n = &self.nodes[node as usize];
        (n.lo - p).max(p - n.hi).max(DVec3::ZERO).length_squared()
    }
}

/// Builds the subtree over `ids`, which start at `first` in the final order. Halving by count keeps the depth below 32.
fn grow(triangles: &[[DVec3; 3]], ids: &mut [u32], first: usize, nodes: &mut Vec<Node>) {
    let at = nodes.len();
    let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (mut clo, mut chi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (mut area, mut area_normal, mut centre) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for &t in ids.iter() {
        let [a, b, c] = triangles[t as usize];
        lo = lo.min(a).min(b).min(c);
        hi = hi.max(a).max(b).max(c);
        let m = (a + b + c) / 3.0;
        (clo, chi) = (clo.min(m), chi.max(m));
        let n = (b - a).cross(c - a) / 2.0;
        let w = n.length();
        area += w;
        area_normal += n;
        centre += w * m;
    }
    centre = if area > 0.0 { centre / area } else { (lo + hi) / 2.0 };
    let radius = (hi - centre).max(centre - lo).length();
    nodes.push(Node { lo, hi, next: first as u32, count: ids.len() as u32, centre, radius, area_normal });
    if ids.len() <= LEAF {
        return;
    }
    let extent = chi - clo;
    let axis = if extent.x >= extent.y && extent.x >= extent.z { 0 } else { 1 + usize::from(extent.z > extent.y) };
    let key = |t: u32| triangles[t as usize].iter().map(|c| c[axis]).sum::<f64>();
    let half = ids.len() / 2;
    ids.select_nth_unstable_by(half, |&s, &t| key(s).total_cmp(&key(t)).then(s.cmp(&t)));
    let (left, right) = ids.split_at_mut(half);
    grow(triangles, left, first, nodes);
    let next = nodes.len() as u32;
    grow(triangles, right, first + half, nodes);
    (nodes[at].next, nodes[at].count) = (next, 0);
}

/// Solid angle of a triangle seen from `p` (van Oosterom and Strackee 1983), positive from the back.
fn solid_angle(p: DVec3, &[a, b, c]: &[DVec3; 3]) -> f64 {
    let (a, b, c) = (a - p, b - p, c - p);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * a.dot(b.cross(c)).atan2(below)
}

/// Closest point of a triangle (Ericson, Real-Time Collision Detection, 5.1.5); degenerate triangles are segments.
pub fn closest_on_triangle(p: DVec3, &[a, b, c]: &[DVec3; 3]) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let scale = 1.0 / (va + vb + vc);
    a + ab * (vb * scale) + ac * (vc * scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tetrahedralise::bodies;

    fn scatter(n: usize) -> impl Iterator<Item = DVec3> {
        (0..n).map(|i| {
            let u = |k: f64| (i as f64 * k + 0.5).fract() * 3.0 - 1.5;
            DVec3::new(u(0.8191725134), u(0.6710436067), u(0.5497004779))
        })
    }

    #[test]
    fn closest_point_agrees_with_every_triangle_tried() {
        let ball = bodies::ball(2);
        let tree = Distance::new(&ball);
        for p in scatter(300) {
            let brute = (0..ball.triangles.len())
                .map(|t| closest_on_triangle(p, &ball.corners(t)).distance(p))
                .fold(f64::INFINITY, f64::min);
            let found = tree.closest(p).unwrap();
            assert!((found.distance - brute).abs() < 1e-14); // measured 0
            assert!((found.point.distance(p) - brute).abs() < 1e-14);
            let owner = closest_on_triangle(p, &ball.corners(found.triangle as usize));
            assert!(owner.distance(found.point) < 1e-14);
        }
    }

    #[test]
    fn winding_tells_inside_from_outside() {
        let ball = bodies::ball(2);
        let tree = Distance::new(&ball);
        for p in scatter(300).filter(|p| (p.length() - 0.985).abs() > 0.02) {
            let expected = if p.length() < 1.0 { 1.0 } else { 0.0 };
            assert!((tree.winding(p) - expected).abs() < 0.02, "{p} {}", tree.winding(p)); // measured 0.003
        }
    }

    #[test]
    fn nothing_is_near_an_empty_surface() {
        let tree = Distance::new(&TriMesh::default());
        assert!(tree.is_empty() && tree.closest(DVec3::ZERO).is_none() && !tree.inside(DVec3::ZERO));
        assert_eq!(tree.distance(DVec3::ZERO), f64::INFINITY);
    }

    #[test]
    fn reach_limits_the_search() {
        let tree = Distance::new(&bodies::cuboid(DVec3::ZERO, DVec3::ONE));
        assert!(tree.closest_within(DVec3::new(0.5, 0.5, 1.3), 0.2).is_none());
        let hit = tree.closest_within(DVec3::new(0.5, 0.5, 1.3), 0.4).unwrap();
        assert!((hit.distance - 0.3).abs() < 1e-15);
    }
}
