//! The rigid motion of parts whose points are followed from frame to frame.

use std::collections::{BTreeMap, HashMap};

use glam::{DMat3, DQuat, DVec3};

use crate::fragments::outer;
use crate::frames::{Frame, ParticleFrame};

/// Something that is followed from frame to frame.
#[derive(Clone, Copy)]
pub(super) struct Point {
    /// The same in every frame.
    pub key: (u32, u32),
    pub piece: u32,
    pub place: DVec3,
    pub mass: f64,
}

/// Particles by body and id.
pub(super) fn particles(p: &ParticleFrame) -> Vec<Point> {
    let point = |k: usize| Point {
        key: (p.body[k], p.id[k]),
        piece: p.piece[k],
        place: DVec3::from(p.positions[k].map(f64::from)),
        mass: p.mass[k].into(),
    };
    (0..p.positions.len()).map(point).collect()
}

/// The vertices of rigid things.
pub(super) fn vertices(frame: &Frame) -> Vec<Point> {
    let point = |k: usize| Point {
        key: (frame.piece[k], frame.id[k]),
        piece: frame.piece[k],
        place: DVec3::from(frame.positions[k].map(f64::from)),
        mass: 1.0,
    };
    (0..frame.positions.len()).map(point).collect()
}

/// The rigid motion of parts, found frame by frame.
pub(super) struct Fit {
    reference: HashMap<(u32, u32), Point>,
    pub parts: Vec<Part>,
    of_piece: HashMap<u32, usize>,
}

/// A part and where it is at each frame.
pub(super) struct Part {
    pub id: u32,
    /// Its centre in the reference.
    pub centre: DVec3,
    /// Where that is at each frame, and how the part has turned.
    pub poses: Vec<(DVec3, DQuat)>,
}

/// Sums over the points of a part: mass, places now, places in the reference about the centre, and their products.
#[derive(Clone, Copy)]
struct Sums {
    mass: f64,
    now: DVec3,
    arm: DVec3,
    product: DMat3,
    spread: f64,
}

impl Fit {
    /// Parts are the pieces of the reference.
    pub fn new(reference: Vec<Point>) -> Self {
        let mut sums: BTreeMap<u32, (DVec3, f64)> = BTreeMap::new();
        for p in &reference {
            let (sum, mass) = sums.entry(p.piece).or_default();
            (*sum, *mass) = (*sum + p.mass * p.place, *mass + p.mass);
        }
        let part = |(id, (sum, mass))| Part { id, centre: sum / mass, poses: Vec::new() };
        let parts: Vec<Part> = sums.into_iter().map(part).collect();
        let of_piece = parts.iter().enumerate().map(|(k, part)| (part.id, k)).collect();
        Self { reference: reference.into_iter().map(|p| (p.key, p)).collect(), parts, of_piece }
    }

    /// Finds where the parts are in the next frame; one of which nothing is seen stays.
    pub fn frame(&mut self, now: &[Point]) {
        // the default of a matrix is the identity
        let none = Sums { mass: 0.0, now: DVec3::ZERO, arm: DVec3::ZERO, product: DMat3::ZERO, spread: 0.0 };
        let mut sums = vec![none; self.parts.len()];
        for p in now {
            let Some(of) = self.reference.get(&p.key) else { continue };
            let Some(&part) = self.of_piece.get(&of.piece) else { continue };
            // a node of a lattice that was coarser is another one with the same number
            let (m, s, arm) = (p.mass.min(of.mass), &mut sums[part], of.place - self.parts[part].centre);
            s.mass += m;
            s.now += m * p.place;
            s.arm += m * arm;
            s.product += m * outer(p.place, arm);
            s.spread += m * arm.length_squared();
        }
        for (part, s) in self.parts.iter_mut().zip(sums) {
            let (place, turn) = part.poses.last().copied().unwrap_or((part.centre, DQuat::IDENTITY));
            if s.mass == 0.0 {
                part.poses.push((place, turn));
                continue;
            }
            let (now, arm) = (s.now / s.mass, s.arm / s.mass);
            // a millionth of the turn of the frame before decides where the points alone do not
            let product = s.product - s.mass * outer(now, arm) + DMat3::from_quat(turn) * (1e-6 * s.spread / 3.0);
            let turn = nearest_rotation(product, turn);
            part.poses.push((now - turn * arm, turn));
        }
    }
}

/// The rotation R with the largest tr(Rᵀ M), which is the least-squares one between points with Σ m y xᵀ = M (Horn 1987): the
/// eigenvector of the largest eigenvalue of a symmetric 4 × 4 matrix, by Jacobi's rotations. Of the two quaternions that nearer to
/// `near`, and `near` itself where M is nothing.
fn nearest_rotation(m: DMat3, near: DQuat) -> DQuat {
    let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = m.to_cols_array_2d();
    let mut a = [
        [xx - yy - zz, yx + xy, zx + xz, zy - yz],
        [yx + xy, yy - xx - zz, zy + yz, xz - zx],
        [zx + xz, zy + yz, zz - xx - yy, yx - xy],
        [zy - yz, xz - zx, yx - xy, xx + yy + zz],
    ];
    let mut v = [[0.0; 4]; 4];
    (0..4).for_each(|k| v[k][k] = 1.0);
    let scale: f64 = a.iter().flatten().map(|x| x * x).sum();
    for _ in 0..32 {
        for (p, q) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
            let (c, s) = (1.0 / t.hypot(1.0), t / t.hypot(1.0));
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            for k in 0..4 {
                (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
                (v[k][p], v[k][q]) = (c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]);
            }
        }
        let rest: f64 = (0..4).flat_map(|p| (0..p).map(move |q| (p, q))).map(|(p, q)| a[p][q] * a[p][q]).sum();
        if rest <= 1e-28 * scale {
            break;
        }
    }
    let largest = (0..4).max_by(|&p, &q| a[p][p].total_cmp(&a[q][q])).expect("four of them");
    let found = DQuat::from_array(v.map(|row| row[largest])).normalize();
    match found {
        _ if scale == 0.0 || !found.is_finite() => near,
        found if found.dot(near) < 0.0 => -found,
        found => found,
    }
}
