//! The shapes of colliders: signed distances, mass properties, and the points by which two colliders meet.
//!
//! Lengths in m, in the collider's own axes. Ball, box, plane, capsule and cylinder answer in closed form; a triangle mesh
//! (a convex hull is one too) asks parry3d's hierarchy. All in f64: a gap over a time step is a speed.

use glam::{DMat3, DVec2, DVec3};
use thiserror::Error;

use super::mesh::Mesh;

/// A solid, or the half space behind a plane.
#[derive(Debug)]
pub enum Shape {
    /// Everything behind the plane through the origin with this unit normal, which points to the free side.
    Plane {
        /// The normal.
        normal: DVec3,
    },
    /// A ball about the origin.
    Ball {
        /// Its radius.
        radius: f64,
    },
    /// A box about the origin with edges along the axes.
    Box {
        /// Half of its edges.
        half: DVec3,
    },
    /// Everything within `radius` of the segment from y = −`half` to y = `half`.
    Capsule {
        /// Half the length of the segment.
        half: f64,
        /// The radius.
        radius: f64,
    },
    /// A cylinder about the y axis, its middle at the origin.
    Cylinder {
        /// Half its height.
        half: f64,
        /// Its radius.
        radius: f64,
    },
    /// What a closed surface encloses.
    Mesh(Mesh),
}

/// Why a surface cannot be a collider.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ShapeError {
    /// An edge of the surface that does not have two triangles.
    #[error(
        "the surface is open at the edge from ({}, {}, {}) to ({}, {}, {}), so it has no inside; close it, or use its convex hull",
        .from.x, .from.y, .from.z, .to.x, .to.y, .to.z
    )]
    Open {
        /// One end of the edge [m].
        from: DVec3,
        /// The other end [m].
        to: DVec3,
    },
    /// A surface without volume, or wound inwards.
    #[error("the surface encloses no volume ({volume} m³); turn its triangles to face outwards")]
    Flat {
        /// The volume [m³].
        volume: f64,
    },
    /// Points of which no hull can be made.
    #[error("the points have no convex hull with a volume; give four or more that are not in one plane")]
    NoHull,
}

/// Mass, and inertia about the origin, of a solid of density 1.
#[derive(Clone, Copy, Debug)]
pub struct MassProperties {
    /// Volume [m³].
    pub volume: f64,
    /// Centre of mass [m].
    pub centre: DVec3,
    /// Moment of inertia about the centre of mass per density [m⁵].
    pub inertia: DMat3,
}

impl Shape {
    /// The word for it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Plane { .. } => "plane",
            Self::Ball { .. } => "ball",
            Self::Box { .. } => "box",
            Self::Capsule { .. } => "capsule",
            Self::Cylinder { .. } => "cylinder",
            Self::Mesh(_) => "mesh",
        }
    }

    /// Signed distance [m] of `x` from the surface, negative inside, and the unit direction in which it grows; `None` where
    /// it is more than `reach` (what is further inside than that may be `None` too).
    #[inline]
    pub fn distance(&self, x: DVec3, reach: f64) -> Option<(f64, DVec3)> {
        let (distance, normal) = match self {
            Self::Plane { normal } => (x.dot(*normal), *normal),
            Self::Ball { radius } => round(x, *radius),
            Self::Box { half } => {
                let q = x.abs() - half;
                let sign = DVec3::select(x.cmplt(DVec3::ZERO), DVec3::NEG_ONE, DVec3::ONE);
                let outside = q.max(DVec3::ZERO);
                let (d, inside) = (outside.length(), q.max_element());
                if d > 0.0 {
                    (d, outside * sign / d)
                } else {
                    let axis = if inside == q.x {
                        DVec3::X
                    } else if inside == q.y {
                        DVec3::Y
                    } else {
                        DVec3::Z
                    };
                    (inside, axis * sign)
                }
            }
            Self::Capsule { half, radius } => round(x - DVec3::Y * x.y.clamp(-half, *half), *radius),
            Self::Cylinder { half, radius } => {
                let (flat, out) = (DVec2::new(x.x, x.z), x.y.signum());
                let around = flat.try_normalize().unwrap_or(DVec2::X);
                let (side, cap) = (flat.length() - radius, x.y.abs() - half);
                let q = DVec2::new(side, cap);
                let past = q.max(DVec2::ZERO);
                let (d, weight) = match past.length() {
                    d if d > 0.0 => (d, past / d),
                    _ if side > cap => (side, DVec2::X),
                    _ => (cap, DVec2::Y),
                };
                (d, DVec3::new(around.x * weight.x, out * weight.y, around.y * weight.x))
            }
            Self::Mesh(mesh) => return mesh.distance(x, reach),
        };
        (distance <= reach).then_some((distance, normal))
    }

    /// Radius [m] of a ball about the origin that holds everything; infinite for a plane.
    pub fn radius(&self) -> f64 {
        match self {
            Self::Plane { .. } => f64::INFINITY,
            Self::Ball { radius } => *radius,
            Self::Box { half } => half.length(),
            Self::Capsule { half, radius } => half + radius,
            Self::Cylinder { half, radius } => half.hypot(*radius),
            Self::Mesh(mesh) => mesh.radius(),
        }
    }

    /// Mass properties at density 1; `None` for a plane.
    pub fn mass_properties(&self) -> Option<MassProperties> {
        use std::f64::consts::PI;
        let axial = |volume: f64, across: f64, along: f64| MassProperties {
            volume,
            centre: DVec3::ZERO,
            inertia: DMat3::from_diagonal(DVec3::new(across, along, across)),
        };
        Some(match self {
            Self::Plane { .. } => return None,
            Self::Ball { radius: r } => {
                let v = 4.0 / 3.0 * PI * r.powi(3);
                axial(v, 0.4 * v * r * r, 0.4 * v * r * r)
            }
            Self::Box { half } => {
                let (v, s) = (8.0 * half.element_product(), *half * *half / 3.0);
                let inertia = DMat3::from_diagonal(DVec3::new(s.y + s.z, s.z + s.x, s.x + s.y) * v);
                MassProperties { volume: v, centre: DVec3::ZERO, inertia }
            }
            Self::Cylinder { half: h, radius: r } => {
                let v = 2.0 * PI * r * r * h;
                axial(v, v * (r * r / 4.0 + h * h / 3.0), 0.5 * v * r * r)
            }
            Self::Capsule { half: h, radius: r } => {
                let (tube, ball) = (2.0 * PI * r * r * h, 4.0 / 3.0 * PI * r.powi(3));
                // the half balls' centres of mass are at h + 3r/8
                let caps = ball * (0.4 * r * r + h * h + 0.75 * h * r);
                axial(tube + ball, tube * (r * r / 4.0 + h * h / 3.0) + caps, 0.5 * tube * r * r + 0.4 * ball * r * r)
            }
            Self::Mesh(mesh) => mesh.mass_properties(),
        })
    }

    /// Calls `each` with points of the surface [m], the same number of them always, on which this shape can stand on a plane
    /// that lies in the unit direction `down`: none reaches lower.
    pub fn lowest(&self, down: DVec3, mut each: impl FnMut(DVec3)) {
        match self {
            Self::Plane { .. } => {}
            Self::Ball { radius } => each(down * *radius),
            Self::Box { half } => corners(*half).for_each(each),
            Self::Capsule { half, radius } => {
                [1.0, -1.0].into_iter().for_each(|end| each(DVec3::Y * (end * half) + down * *radius));
            }
            Self::Cylinder { half, radius } => {
                // the lowest point of each rim, and three more for when it stands
                let low = DVec3::new(down.x, 0.0, down.z).try_normalize().unwrap_or(DVec3::X) * *radius;
                let aside = DVec3::new(low.z, 0.0, -low.x);
                for end in [*half, -half] {
                    [low, aside, -low, -aside].into_iter().for_each(|rim| each(rim + DVec3::Y * end));
                }
            }
            Self::Mesh(mesh) => mesh.vertices.iter().for_each(|v| each(*v)),
        }
    }
}

/// The corners of a box about the origin.
fn corners(half: DVec3) -> impl Iterator<Item = DVec3> {
    let sign = |k: usize, bit: usize| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
    (0..8).map(move |k| half * DVec3::new(sign(k, 0), sign(k, 1), sign(k, 2)))
}

/// Distance from a ball of radius `r` about the origin of `x`.
#[inline]
fn round(x: DVec3, r: f64) -> (f64, DVec3) {
    let d = x.length();
    (d - r, if d > 0.0 { x / d } else { DVec3::Y })
}

#[cfg(test)]
mod tests {
    use super::super::tests::unit;
    use super::*;

    fn shapes() -> Vec<Shape> {
        let hull = Mesh::hull(&corners(DVec3::new(0.3, 0.5, 0.2)).collect::<Vec<_>>()).unwrap();
        vec![
            Shape::Ball { radius: 0.7 },
            Shape::Box { half: DVec3::new(0.3, 0.5, 0.2) },
            Shape::Capsule { half: 0.4, radius: 0.3 },
            Shape::Cylinder { half: 0.4, radius: 0.3 },
            Shape::Mesh(hull),
        ]
    }

    fn point(k: u64) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|c| 2.0 * unit(3 * k + c) - 1.0))
    }

    #[test]
    fn going_the_distance_along_the_normal_arrives_at_the_surface() {
        for shape in shapes() {
            for k in 0..2000 {
                let x = point(k);
                let (d, n) = shape.distance(x, f64::MAX).unwrap();
                assert!((n.length() - 1.0).abs() < 1e-12);
                let (there, _) = shape.distance(x - n * d, f64::MAX).unwrap();
                assert!(there.abs() < 1e-12, "{}: {there:e} after {d} from {x}", shape.name()); // measured 4e-16
                assert!(d <= 0.1 || shape.distance(x, 0.1).is_none(), "{}: {d} is out of reach", shape.name());
            }
        }
    }

    #[test]
    fn volume_and_inertia_are_those_of_the_points_inside() {
        for shape in shapes() {
            let m = shape.mass_properties().unwrap();
            let (mut n, mut inside, mut moment) = (0.0, 0.0, DVec3::ZERO);
            for k in 0..1_000_000 {
                let x = point(k) * 0.75;
                n += 1.0;
                if shape.distance(x, f64::MAX).unwrap().0 < 0.0 {
                    inside += 1.0;
                    let s = x * x;
                    moment += DVec3::new(s.y + s.z, s.z + s.x, s.x + s.y);
                }
            }
            let (volume, inertia) = (1.5 * 1.5 * 1.5 * inside / n, moment * (1.5 * 1.5 * 1.5) / n);
            let diagonal = DVec3::new(m.inertia.x_axis.x, m.inertia.y_axis.y, m.inertia.z_axis.z);
            // sampling: measured up to 0.4 % and 0.6 %
            assert!((volume / m.volume - 1.0).abs() < 0.015, "{}: {volume} {}", shape.name(), m.volume);
            assert!((inertia / diagonal - 1.0).abs().max_element() < 0.02, "{}: {inertia} {diagonal}", shape.name());
        }
    }

    #[test]
    fn an_open_or_inverted_surface_is_no_collider() {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let closed = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        assert!(Mesh::new(vertices.clone(), closed.clone()).is_ok());
        assert!(matches!(Mesh::new(vertices.clone(), closed[..3].to_vec()), Err(ShapeError::Open { .. })));
        let inverted = closed.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        assert!(matches!(Mesh::new(vertices, inverted), Err(ShapeError::Flat { .. })));
        assert_eq!(Mesh::hull(&[DVec3::ZERO, DVec3::X, DVec3::Y]).unwrap_err(), ShapeError::NoHull);
    }
}
