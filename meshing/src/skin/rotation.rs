//! The rotation nearest to a matrix, which is never a reflection.
//!
//! Davenport's q-method: tr(Rᵀ M) is a quadratic form in the unit quaternion of R, so the best rotation is the
//! eigenvector of a symmetric 4×4 matrix at its largest eigenvalue. It is the global best whatever M, inverted and
//! singular ones included. Müller's warm-started iteration (2016) is cheaper but stops at half turns, which are
//! saddle points, and then mirrors a fragment of two tetrahedra that has turned over between two frames.
//!
//! Where the largest eigenvalue stands alone, Newton's method finds it (Theobald, 2005) in a fifth of the time of Jacobi's,
//! which is for the rest.

use glam::{DMat3, DQuat, DVec3};

/// Sweeps of Jacobi rotations; four or five are enough for full precision, two or three from near the answer.
const SWEEPS: usize = 12;
/// Steps of Newton's method; four or five are enough where it is good for anything.
const NEWTON: usize = 12;
/// Least product of the distances from the largest eigenvalue λ to the others, relative to λ³ and the square of the quaternion's w.
const ALONE: f64 = 1e-3;

/// The rotation R with the largest tr(Rᵀ M). Of q and −q the one nearer to `old` is returned; `old` itself if `m` is
/// not finite.
pub(crate) fn nearest_rotation(m: DMat3, old: DQuat) -> DQuat {
    if !m.is_finite() {
        return old;
    }
    let size = m.to_cols_array().iter().fold(0.0f64, |s, x| s.max(x.abs()));
    if size == 0.0 {
        return old;
    }
    // Seen from the old rotation the answer is nearly the unit quaternion and the form nearly diagonal: half the sweeps.
    let seen = DMat3::from_quat(old).transpose() * m;
    let turn = by_newton(seen * (1.0 / size)).unwrap_or_else(|| by_jacobi(seen * (1.0 / size))).normalize();
    if !turn.is_finite() {
        return old;
    }
    let q = (old * turn).normalize();
    if q.dot(old) < 0.0 { -q } else { q }
}

/// Davenport's form of `m`: its upper left 3×3, and what stands beside and below that. The last number of its diagonal is the
/// trace of `m`.
fn form(m: DMat3) -> (DMat3, DVec3) {
    let m = m.transpose().to_cols_array_2d(); // m[row][column]
    let (xx, yy, zz) = (m[0][0], m[1][1], m[2][2]);
    let (yx, zx, zy) = (m[1][0] + m[0][1], m[2][0] + m[0][2], m[2][1] + m[1][2]);
    let square = [[xx - yy - zz, yx, zx], [yx, yy - xx - zz, zy], [zx, zy, zz - xx - yy]];
    (DMat3::from_cols_array_2d(&square), DVec3::new(m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]))
}

/// The determinant of `m` and its cofactors.
fn cofactors(m: DMat3) -> (f64, DMat3) {
    let [a, b, c] = [m.x_axis, m.y_axis, m.z_axis];
    (a.dot(b.cross(c)), DMat3::from_cols(b.cross(c), c.cross(a), a.cross(b)))
}

fn squared(m: DMat3) -> f64 {
    m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()
}

/// The best rotation of a matrix of size 1, not normalised, if it turns by well below a half turn and no other is nearly as good.
fn by_newton(m: DMat3) -> Option<DQuat> {
    let (det, cofactor) = cofactors(m);
    let s = squared(m);
    // λ⁴ + c₂ λ² + c₁ λ + c₀ has real roots only; from above, Newton falls onto the largest
    let (c2, c1, c0) = (-2.0 * s, -8.0 * det, s * s - 4.0 * squared(cofactor));
    let mut largest = (3.0 * s).sqrt();
    let mut last = f64::INFINITY;
    for _ in 0..NEWTON {
        let l = largest;
        last = ((((l * l + c2) * l) + c1) * l + c0) / ((4.0 * l * l + 2.0 * c2) * l + c1);
        largest -= last;
        if last.abs() < 1e-9 {
            break; // its square is below rounding
        }
    }
    let (square, beside) = form(m);
    let (w, cofactor) = cofactors(square - DMat3::from_diagonal(DVec3::splat(largest)));
    let v = cofactor * beside;
    let alone = last.abs() < 1e-9 && w.abs() > ALONE * largest.powi(3);
    alone.then(|| DQuat::from_xyzw(v.x, v.y, v.z, -w))
}

fn by_jacobi(m: DMat3) -> DQuat {
    let (square, v) = form(m);
    let [a, b, c] = square.to_cols_array_2d();
    let w = m.x_axis.x + m.y_axis.y + m.z_axis.z;
    DQuat::from_array(largest_eigenvector([
        [a[0], a[1], a[2], v.x],
        [b[0], b[1], b[2], v.y],
        [c[0], c[1], c[2], v.z],
        [v.x, v.y, v.z, w],
    ]))
}

/// Eigenvector of a symmetric matrix at its largest eigenvalue, by cyclic Jacobi rotations.
fn largest_eigenvector(mut a: [[f64; 4]; 4]) -> [f64; 4] {
    let mut v = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    for _ in 0..SWEEPS {
        let mut rest = 0.0f64;
        for p in 0..3 {
            for q in p + 1..4 {
                let b = a[p][q];
                rest = rest.max(b.abs());
                if b.abs() < 1e-300 {
                    continue;
                }
                let theta = (a[q][q] - a[p][p]) / (2.0 * b);
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for k in 0..4 {
                    (a[k][p], a[k][q]) = (c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]);
                }
                for k in 0..4 {
                    (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
                }
                for row in &mut v {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
            }
        }
        if rest < 1e-15 {
            break;
        }
    }
    let best = (0..4).max_by(|&i, &j| a[i][i].total_cmp(&a[j][j])).expect("there are four");
    v.map(|row| row[best])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(x: f64, y: f64, z: f64, angle: f64) -> DQuat {
        DQuat::from_axis_angle(DVec3::new(x, y, z).normalize(), angle)
    }

    #[test]
    fn finds_the_rotation_of_a_stretched_and_turned_matrix() {
        let stretch = DMat3::from_cols_array(&[2.0, 0.3, 0.1, 0.3, 1.0, -0.2, 0.1, -0.2, 0.5]);
        for angle in [0.0, 1e-9, 1.0, 2.5, 3.0, std::f64::consts::PI] {
            let r = turn(1.0, -2.0, 0.5, angle);
            let found = nearest_rotation(DMat3::from_quat(r) * stretch, DQuat::IDENTITY);
            // Measured: below 4e-16.
            assert!(1.0 - found.dot(r).abs() < 1e-14, "{angle}: {found} for {r}");
        }
    }

    #[test]
    fn newton_and_jacobi_agree_and_newton_knows_when_not() {
        let axis =
            |k: usize| DVec3::new((k * 7 % 11) as f64 - 5.0, (k * 5 % 13) as f64 - 6.0, (k * 3 % 7) as f64 - 3.5);
        let (mut found, mut worst) = (0, 0.0f64);
        for k in 0..500 {
            let spread = DMat3::from_diagonal(DVec3::new(1.0, (k % 10) as f64 / 9.0, (k % 3) as f64 / 4.0 - 0.1));
            let frame = DMat3::from_quat(turn(axis(k).x, axis(k).y, axis(k).z, k as f64));
            let by = turn(axis(k + 1).x, axis(k + 1).y, axis(k + 1).z, (k % 37) as f64 / 10.0);
            let m = DMat3::from_quat(by) * frame * spread * frame.transpose();
            let jacobi = by_jacobi(m).normalize();
            if let Some(newton) = by_newton(m) {
                found += 1;
                worst = worst.max(1.0 - newton.normalize().dot(jacobi).abs());
            }
        }
        // Measured: 2e-16, in 481; what is left are plane ones that turn by a half turn, and the like.
        assert!(worst < 1e-14 && found > 400, "{worst:e} in {found}");
        for m in [DMat3::ZERO, -DMat3::IDENTITY, DMat3::from_diagonal(DVec3::X)] {
            assert_eq!(by_newton(m), None, "several rotations are best of {m}");
        }
    }

    #[test]
    fn never_mirrors_and_never_gives_up() {
        let old = turn(1.0, 1.0, 0.0, 0.7);
        let axis = DVec3::new(1.0, 2.0, 2.0) / 3.0;
        let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
        for m in [-DMat3::IDENTITY, DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0)), outer(-axis, axis), DMat3::ZERO] {
            let r = DMat3::from_quat(nearest_rotation(m, old));
            assert!((r.determinant() - 1.0).abs() < 1e-12 && (r * r.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-12));
        }
        assert_eq!(nearest_rotation(DMat3::ZERO, old), old);
        assert_eq!(nearest_rotation(DMat3::IDENTITY * f64::NAN, old), old);
        // A turned-over pair: its axis follows, and what it leaves open stays as near to the old rotation as it can.
        let old = DMat3::IDENTITY;
        let r = DMat3::from_quat(nearest_rotation(outer(DVec3::Y, DVec3::X) + old * 1e-3, DQuat::IDENTITY));
        let expected = DMat3::from_rotation_z(std::f64::consts::FRAC_PI_2);
        assert!(r.abs_diff_eq(expected, 3e-3), "{r}"); // measured 1e-3, as the weight of the old rotation
    }
}
