//! Signs of determinants, exact for f64 input: on which side of a line or a plane does a point lie?
//!
//! A float filter answers nearly always; when the determinant is smaller than its rounding error, it is summed again as
//! an expansion, a list of floats whose exact sum is the number (Shewchuk 1997, Adaptive precision floating-point
//! arithmetic and fast robust geometric predicates). Exact unless a product leaves the range of f64: callers refuse
//! coordinates beyond 1e30.

use std::cmp::Ordering;

use glam::{DVec2, DVec3};

/// Half a unit in the last place of 1, Shewchuk's ε.
const HALF_ULP: f64 = f64::EPSILON / 2.0;

/// Sign of (b−a) × (c−a): `Greater` if a, b, c turn counter-clockwise, `Equal` if they are collinear.
pub(crate) fn orient2d(a: DVec2, b: DVec2, c: DVec2) -> Ordering {
    let left = (a.x - c.x) * (b.y - c.y);
    let right = (a.y - c.y) * (b.x - c.x);
    let det = left - right;
    let bound = (3.0 + 16.0 * HALF_ULP) * HALF_ULP * (left.abs() + right.abs());
    if det.abs() > bound {
        return sign(det);
    }
    if bound == 0.0 {
        return Ordering::Equal;
    }
    let left = product(&difference(a.x, c.x), &difference(b.y, c.y));
    let right = product(&difference(a.y, c.y), &difference(b.x, c.x));
    expansion_sign(&sum(left, &negated(right)))
}

/// Sign of det(b−a, c−a, d−a), six times the signed volume of the tetrahedron: `Greater` if `d` lies on the side of
/// plane a-b-c from which the three turn counter-clockwise, `Equal` if the four are coplanar.
pub(crate) fn orient3d(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Ordering {
    let (u, v, w) = (b - a, c - a, d - a);
    let (vw_x, wv_x) = (v.y * w.z, v.z * w.y);
    let (vw_y, wv_y) = (v.z * w.x, v.x * w.z);
    let (vw_z, wv_z) = (v.x * w.y, v.y * w.x);
    let det = u.x * (vw_x - wv_x) + u.y * (vw_y - wv_y) + u.z * (vw_z - wv_z);
    let permanent = u.x.abs() * (vw_x.abs() + wv_x.abs())
        + u.y.abs() * (vw_y.abs() + wv_y.abs())
        + u.z.abs() * (vw_z.abs() + wv_z.abs());
    let bound = (7.0 + 56.0 * HALF_ULP) * HALF_ULP * permanent;
    if det.abs() > bound {
        return sign(det);
    }
    if bound == 0.0 {
        return Ordering::Equal;
    }
    let exact = |p: DVec3| [difference(p.x, a.x), difference(p.y, a.y), difference(p.z, a.z)];
    let (u, v, w) = (exact(b), exact(c), exact(d));
    let mut total = Vec::new();
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let minor = sum(product(&v[j], &w[k]), &negated(product(&v[k], &w[j])));
        total = sum(total, &product(&u[i], &minor));
    }
    expansion_sign(&total)
}

fn sign(x: f64) -> Ordering {
    x.partial_cmp(&0.0).unwrap_or(Ordering::Equal)
}

/// a + b as rounded sum and rounding error (Knuth).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let from_b = s - a;
    (s, (a - (s - from_b)) + (b - from_b))
}

/// a · b as rounded product and rounding error.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let p = a * b;
    (p, a.mul_add(b, -p))
}

/// a − b exactly.
fn difference(a: f64, b: f64) -> Vec<f64> {
    let (s, e) = two_sum(a, -b);
    [e, s].into_iter().filter(|&x| x != 0.0).collect()
}

/// `e` + `x`; components stay non-overlapping, in increasing magnitude, without zeros.
fn grow(e: &mut Vec<f64>, x: f64) {
    let mut carry = x;
    let mut kept = 0;
    for i in 0..e.len() {
        let (s, error) = two_sum(carry, e[i]);
        if error != 0.0 {
            e[kept] = error;
            kept += 1;
        }
        carry = s;
    }
    e.truncate(kept);
    if carry != 0.0 {
        e.push(carry);
    }
}

fn sum(mut e: Vec<f64>, f: &[f64]) -> Vec<f64> {
    f.iter().for_each(|&x| grow(&mut e, x));
    e
}

fn product(e: &[f64], f: &[f64]) -> Vec<f64> {
    let mut out = Vec::with_capacity(2 * e.len() * f.len());
    for &x in e {
        for &y in f {
            let (p, error) = two_product(x, y);
            grow(&mut out, error);
            grow(&mut out, p);
        }
    }
    out
}

fn negated(e: Vec<f64>) -> Vec<f64> {
    e.into_iter().map(|x| -x).collect()
}

/// The last component is larger than the sum of all others, so it has the sign of the whole.
fn expansion_sign(e: &[f64]) -> Ordering {
    sign(e.last().copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_unit_in_the_last_place_decides_the_plane() {
        // x + y + z = 1.5 holds exactly for these four; the plain determinant drowns in rounding.
        let (a, b, c) = (DVec3::new(0.5, 0.5, 0.5), DVec3::new(0.9, 0.3, 0.3), DVec3::new(0.1, 0.7, 0.7));
        let d = DVec3::new(12.0, -7.0, 3.3);
        for step in [0.0, f64::EPSILON * 8.0] {
            let moved = DVec3::new(0.5 + step, 0.5, 0.5);
            let forward = orient3d(a, b, DVec3::new(0.3, 0.9, 0.3), moved);
            assert_eq!(orient3d(b, a, DVec3::new(0.3, 0.9, 0.3), moved), forward.reverse());
            assert_eq!(forward, if step > 0.0 { Ordering::Greater } else { Ordering::Equal });
        }
        assert_eq!(orient3d(a, b, c, d), orient3d(c, a, b, d), "even permutations agree");
    }

    #[test]
    fn matches_integer_arithmetic_on_a_far_lattice() {
        // All coordinates are integers below 2^40, so i128 gives the exact determinant.
        let mut state = 1_u64;
        let mut next = |n: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((state >> 33) % n) as i128
        };
        let mut equal = 0;
        for _ in 0..2000 {
            let p: Vec<[i128; 3]> = (0..4).map(|_| [next(3) + (1 << 39), next(3), next(3) - (1 << 38)]).collect();
            let e = |i: usize, k: usize| p[i][k] - p[0][k];
            let det = e(1, 0) * (e(2, 1) * e(3, 2) - e(2, 2) * e(3, 1))
                + e(1, 1) * (e(2, 2) * e(3, 0) - e(2, 0) * e(3, 2))
                + e(1, 2) * (e(2, 0) * e(3, 1) - e(2, 1) * e(3, 0));
            let f: Vec<DVec3> = p.iter().map(|q| DVec3::from_array(q.map(|x| x as f64))).collect();
            assert_eq!(orient3d(f[0], f[1], f[2], f[3]), det.cmp(&0));
            equal += usize::from(det == 0);
        }
        assert!(equal > 300, "the lattice must produce coplanar quadruples, got {equal}");
    }

    #[test]
    fn points_on_a_rounded_line_are_told_apart() {
        // Kettner et al. 2008, Classroom examples of robustness problems: the plain formula gets these wrong.
        let (b, c) = (DVec2::new(12.0, 12.0), DVec2::new(24.0, 24.0));
        let u = 2.0_f64.powi(-53);
        for i in 0..64 {
            for j in 0..64 {
                let a = DVec2::new(0.5 + f64::from(i) * u * 2.0, 0.5 + f64::from(j) * u * 2.0);
                // counter-clockwise exactly if a lies above the diagonal run from b to c
                assert_eq!(orient2d(b, c, a), j.cmp(&i));
            }
        }
    }
}
