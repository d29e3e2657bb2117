//! The rotation nearest to a matrix, four at a time, from a guess: never a reflection, and defined for every matrix.
//!
//! Maximises tr(RᵀA) by Newton steps on the rotation group. With B = RᵀA the step ω solves (tr B · 1 − sym B) ω = axl B, and
//! at the end B is symmetric: S of the polar decomposition A = RS, with its smallest eigenvalue below 0 where A is inverted.
//! Where A says nothing about an axis (all points on a line) the guess stays. Where the guess is far off, the problem is not
//! convex there, and the largest eigenvector of Davenport's matrix (Horn 1987) answers.
//!
//! Two steps suffice from the rotation of the step before, if a region turns by less than 0.1 in a step. The fixed point
//! iteration of Müller, Bender, Chentanez and Macklin (2016) costs less per step and gains one digit in two.

use glam::{DMat3, DQuat};
use wide::f64x4;

/// Newton steps before the guess counts as hopeless.
const STEPS: usize = 8;
/// A step [rad] below this is the last: the next would be its square.
const CLOSE: f64 = 1e-7;
/// What holds an axis that A says nothing about, in units of ‖A‖.
const HOLD: f64 = 1e-10;
/// Eigenvalues nearer than this share of the largest are one: the guess chooses between their vectors.
const SAME: f64 = 1e-9;

/// Four quaternions x, y, z, w.
pub type Turns = [f64x4; 4];
/// Four matrices by rows.
pub type Matrices = [[f64x4; 3]; 3];

/// The matrices of four unit quaternions.
#[inline(always)]
pub fn matrices(q: &Turns) -> Matrices {
    let [x, y, z, w] = *q;
    let (x2, y2, z2) = (x + x, y + y, z + z);
    let one = f64x4::ONE;
    let (xx, yy, zz) = (x * x2, y * y2, z * z2);
    let (xy, xz, yz) = (x * y2, x * z2, y * z2);
    let (wx, wy, wz) = (w * x2, w * y2, w * z2);
    [[one - yy - zz, xy - wz, xz + wy], [xy + wz, one - xx - zz, yz - wx], [xz - wy, yz + wx, one - xx - yy]]
}

/// Four quaternions of length 1.
#[inline(always)]
fn normalised(q: Turns) -> Turns {
    let over = f64x4::ONE / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    q.map(|x| x * over)
}

/// The nearest rotations to `a` from the guesses, which need not have length 1.
#[inline(always)]
pub fn nearest(a: &Matrices, guess: Turns) -> Turns {
    let guess = normalised(guess);
    let mut q = guess;
    let size = a.iter().flatten().fold(f64x4::ZERO, |sum, x| sum + *x * *x).sqrt();
    let scale = f64x4::ONE / (size + f64x4::splat(1e-300));
    let a = a.map(|row| row.map(|x| x * scale));
    let (mut convex, mut done) = (f64x4::ONE.simd_eq(f64x4::ONE), f64x4::ZERO);
    for _ in 0..STEPS {
        let r = matrices(&q);
        let b = |i: usize, j: usize| r[0][i] * a[0][j] + r[1][i] * a[1][j] + r[2][i] * a[2][j];
        let (b00, b11, b22) = (b(0, 0), b(1, 1), b(2, 2));
        let (b01, b10, b02, b20, b12, b21) = (b(0, 1), b(1, 0), b(0, 2), b(2, 0), b(1, 2), b(2, 1));
        let (gx, gy, gz) = (b21 - b12, b02 - b20, b10 - b01);
        let (half, hold) = (f64x4::splat(-0.5), f64x4::splat(HOLD));
        let (hxx, hyy, hzz) = (b11 + b22 + hold, b00 + b22 + hold, b00 + b11 + hold);
        let (hxy, hxz, hyz) = ((b01 + b10) * half, (b02 + b20) * half, (b12 + b21) * half);
        // cofactors, by which Cramer solves
        let (cxx, cxy, cxz) = (hyy * hzz - hyz * hyz, hxz * hyz - hxy * hzz, hxy * hyz - hxz * hyy);
        let (cyy, cyz, czz) = (hxx * hzz - hxz * hxz, hxy * hxz - hxx * hyz, hxx * hyy - hxy * hxy);
        let det = hxx * cxx + hxy * cxy + hxz * cxz;
        convex = hxx.simd_gt(f64x4::ZERO) & czz.simd_gt(f64x4::ZERO) & det.simd_gt(f64x4::ZERO);
        let over = f64x4::splat(0.5) / det;
        let (ox, oy, oz) = (
            (cxx * gx + cxy * gy + cxz * gz) * over,
            (cxy * gx + cyy * gy + cyz * gz) * over,
            (cxz * gx + cyz * gy + czz * gz) * over,
        );
        // q (ω/2, 1), normalised
        let [x, y, z, w] = q;
        let next = [
            x + w * ox + y * oz - z * oy,
            y + w * oy + z * ox - x * oz,
            z + w * oz + x * oy - y * ox,
            w - x * ox - y * oy - z * oz,
        ];
        let step = ox * ox + oy * oy + oz * oz;
        let over = f64x4::ONE / (f64x4::ONE + step).sqrt();
        q = std::array::from_fn(|k| convex.select(next[k] * over, q[k]));
        done = step.simd_lt(f64x4::splat(0.25 * CLOSE * CLOSE)) & convex;
        if (done | !convex).all() {
            break;
        }
    }
    if !(done & convex).all() {
        q = rescue(&a, &guess, q, (done & convex).to_bitmask());
    }
    normalised(q)
}

/// Answers for the lanes that are not in `good`.
#[cold]
fn rescue(a: &Matrices, guess: &Turns, found: Turns, good: u32) -> Turns {
    let mut out = found.map(|x| x.to_array());
    for lane in (0..4).filter(|lane| good >> lane & 1 == 0) {
        let at = |x: f64x4| x.to_array()[lane];
        let rows = a.map(|row| row.map(at));
        let start = DQuat::from_array(guess.map(at));
        let q = nearest_of_all(DMat3::from_cols_array_2d(&rows).transpose(), start).to_array();
        (0..4).for_each(|k| out[k][lane] = q[k]);
    }
    out.map(f64x4::from)
}

/// The nearest rotation from no matter how bad a guess; of several that are equally near, the one nearest to the guess. Input
/// that is not finite returns the guess.
fn nearest_of_all(a: DMat3, guess: DQuat) -> DQuat {
    let at = |i: usize, j: usize| a.col(j)[i];
    // qᵀKq = tr(R(q)ᵀA)
    let mut k = [
        [at(0, 0) - at(1, 1) - at(2, 2), at(0, 1) + at(1, 0), at(0, 2) + at(2, 0), at(2, 1) - at(1, 2)],
        [0.0, at(1, 1) - at(0, 0) - at(2, 2), at(1, 2) + at(2, 1), at(0, 2) - at(2, 0)],
        [0.0, 0.0, at(2, 2) - at(0, 0) - at(1, 1), at(1, 0) - at(0, 1)],
        [0.0, 0.0, 0.0, at(0, 0) + at(1, 1) + at(2, 2)],
    ];
    (0..4).for_each(|i| (0..i).for_each(|j| k[i][j] = k[j][i]));
    let size = k.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    if size == 0.0 || !k.iter().flatten().all(|x| x.is_finite()) {
        return guess;
    }
    let (values, vectors) = eigen(k);
    let top = values.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
    let start = guess.to_array();
    let mut q = [0.0; 4];
    for (_, v) in values.iter().zip(&vectors).filter(|(value, _)| top - **value <= SAME * size) {
        let along: f64 = (0..4).map(|i| v[i] * start[i]).sum();
        (0..4).for_each(|i| q[i] += along * v[i]);
    }
    if q.iter().map(|x| x * x).sum::<f64>() < 1e-12 {
        // the guess is as far away as can be: any will do
        q = vectors[(0..4).max_by(|&i, &j| values[i].total_cmp(&values[j])).unwrap_or(3)];
    }
    DQuat::from_array(q).normalize()
}

/// Eigenvalues and eigenvectors of a symmetric matrix, by Jacobi rotations.
pub fn eigen<const N: usize>(mut a: [[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut v: [[f64; N]; N] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let size = a.iter().flatten().map(|x| x * x).sum::<f64>();
    for _ in 0..40 {
        let off: f64 = (0..N).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a[i][j] * a[i][j]).sum();
        if off <= 1e-34 * size {
            break;
        }
        for p in 0..N {
            for q in p + 1..N {
                if a[p][q] == 0.0 {
                    continue;
                }
                let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for k in 0..N {
                    (a[k][p], a[k][q]) = (c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]);
                }
                for k in 0..N {
                    (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
                    (v[p][k], v[q][k]) = (c * v[p][k] - s * v[q][k], s * v[p][k] + c * v[q][k]);
                }
            }
        }
    }
    (std::array::from_fn(|i| a[i][i]), v)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn one(a: DMat3, guess: DQuat) -> DQuat {
        let rows = a.transpose().to_cols_array_2d().map(|row| row.map(f64x4::splat));
        let q = nearest(&rows, guess.to_array().map(f64x4::splat));
        let lanes = q.map(|x| x.to_array());
        assert!((1..4).all(|l| (0..4).all(|k| lanes[k][l] == lanes[k][0])));
        DQuat::from_array(lanes.map(|x| x[0]))
    }

    #[test]
    fn the_rotation_of_a_strained_turn_is_the_turn_from_any_guess() {
        let strain =
            DMat3::from_cols(DVec3::new(1.3, 0.1, 0.0), DVec3::new(0.1, 0.8, -0.2), DVec3::new(0.0, -0.2, 1.0));
        for (axis, angle) in [(DVec3::X, 0.05), (DVec3::new(1.0, 2.0, -1.0), 2.5), (DVec3::Z, std::f64::consts::PI)] {
            let turn = DQuat::from_axis_angle(axis.normalize(), angle);
            let found = one(DMat3::from_quat(turn) * strain, DQuat::IDENTITY);
            assert!(found.angle_between(turn) < 1e-7, "{found} instead of {turn}");
            let rest = DMat3::from_quat(found).transpose() * DMat3::from_quat(turn);
            // measured 3e-16
            assert!((rest - DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 2e-15), "{rest}");
        }
    }

    #[test]
    fn what_says_nothing_leaves_the_guess() {
        let guess = DQuat::from_axis_angle(DVec3::new(0.3, -1.0, 0.4).normalize(), 1.1);
        for a in [DMat3::ZERO, DMat3::from_diagonal(DVec3::NAN)] {
            assert!(one(a, guess).angle_between(guess) < 1e-7);
        }
        // points along x turned by a little: the turn about x stays that of the guess
        let line = DMat3::from_quat(DQuat::from_rotation_z(0.01) * guess) * DMat3::from_diagonal(DVec3::X);
        let found = one(line, guess);
        let want = DQuat::from_rotation_z(0.01) * guess;
        assert!((found * DVec3::X).distance(want * DVec3::X) < 1e-9);
        assert!(found.angle_between(guess) < 0.0101, "{}", found.angle_between(guess));
    }

    #[test]
    fn inverted_and_flat_matrices_give_proper_rotations() {
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 1.0, 0.3).normalize(), 0.7);
        for s in [DVec3::new(1.0, 0.8, -0.3), DVec3::new(1.0, 0.7, 0.0), DVec3::new(0.9, -0.2, 1.1)] {
            let found = one(DMat3::from_quat(turn) * DMat3::from_diagonal(s), DQuat::IDENTITY);
            assert!(found.angle_between(turn) < 1e-7, "{s}: {found} instead of {turn}");
        }
    }
}
