//! Where rigid things touch each other: parry3d's contact manifolds, and planes, of which every shape knows its lowest points.
//!
//! Manifolds are made anew in every step, for one that is carried on would have to survive a restart; what is carried on are
//! the impulses (`rigid.rs`), by the features that touch. What moves far in a step is followed to where it arrives first,
//! as `approach.rs` does for particles.

use glam::DVec3;
use parry3d_f64::math::Pose as Place;
use parry3d_f64::query::details::ShapeCastOptions;
use parry3d_f64::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher, cast_shapes};
use parry3d_f64::shape::{Ball, Capsule, Cuboid, Cylinder, Shape as Solid};

use super::approach::{Approach, Pose, SHORT, least};
use super::shape::Shape;

/// Share of the smaller one's radius within which things count as touching, so that what one of them is pushed to in this
/// step is known to the other.
const SKIN: f64 = 0.01;

/// Overlaps up to this share of the smaller one's radius are left alone: pushing them out would rock for good what rests.
const LEFT: f64 = 5e-4;
/// Room for the points at which two faces touch.
const FACE: usize = 64;

/// Which features of which two colliders touch; the same from step to step.
pub type Key = [u32; 6];

/// One point of two colliders that touch, or may in this step.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// The features.
    pub key: Key,
    /// Where [m].
    pub x: DVec3,
    /// What the second may do relative to the first; the normal points to the second.
    pub at: Approach,
}

/// A collider in the step, as far as its kind does not matter.
#[derive(Clone, Copy)]
pub struct Side<'a> {
    /// Its shape, and where it is.
    pub shape: &'a Shape,
    /// The step.
    pub pose: &'a Pose,
    /// Velocity [m/s] of its origin, and a bound on that of its parts relative to it.
    pub velocity: DVec3,
    /// See above.
    pub turning: f64,
}

/// The colliders as parry3d has them; memory only.
#[derive(Default)]
pub struct Solids {
    /// None of planes.
    all: Vec<Option<Box<dyn Solid>>>,
    spots: usize,
    manifolds: Vec<ContactManifold<(), ()>>,
}

impl std::fmt::Debug for Solids {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Solids").field("count", &self.all.len()).finish_non_exhaustive()
    }
}

impl Solids {
    /// Those of `shapes`.
    pub fn new<'a>(shapes: impl Iterator<Item = &'a Shape> + Clone) -> Self {
        let mut spots = 0;
        shapes.clone().for_each(|s| s.lowest(DVec3::NEG_Y, |_| spots += 1));
        let mut manifold = ContactManifold::default();
        manifold.points.reserve(FACE);
        Self { all: shapes.map(solid).collect(), spots: spots.max(FACE), manifolds: vec![manifold] }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// About how many points each may touch another with.
    pub fn spots(&self) -> usize {
        self.spots
    }

    /// Finds where the colliders number `a` and `b` touch, or may in a step of `dt` [s].
    pub fn meet(&mut self, (a, b): (usize, usize), sides: [Side<'_>; 2], dt: f64, mut found: impl FnMut(Spot)) {
        let pair = [a as u32, b as u32];
        let velocity = sides[1].velocity - sides[0].velocity;
        let small = sides[0].shape.radius().min(sides[1].shape.radius());
        let way = velocity.length() * dt + (sides[0].turning + sides[1].turning) * dt;
        let reach = way + SKIN * small;
        let (Some(first), Some(second)) = (&self.all[a], &self.all[b]) else {
            return at_plane(pair, sides, (small, reach), dt, found);
        };
        let places = sides.map(|s| {
            let (position, orientation) = s.pose.place();
            Place::from_parts(position, orientation)
        });
        let apart = places[0].translation.distance(places[1].translation);
        if apart > sides[0].shape.radius() + sides[1].shape.radius() + reach {
            return;
        }
        let mut passed = 0.0;
        if way > SHORT * small {
            let options = ShapeCastOptions::with_max_time_of_impact(dt);
            let hit = cast_shapes(&places[0], DVec3::ZERO, &**first, &places[1], velocity, &**second, options);
            match hit {
                Ok(Some(hit)) => passed = hit.time_of_impact,
                Ok(None) => return,
                // of two meshes: as they stand
                Err(_) => {}
            }
        }
        let arrived = Place::from_parts(places[1].translation + velocity * passed, places[1].rotation);
        let composite = first.as_composite_shape().is_some() || second.as_composite_shape().is_some();
        if composite {
            self.manifolds.clear();
        } else {
            self.manifolds.resize_with(1, ContactManifold::default);
            self.manifolds[0].clear();
            self.manifolds[0].local_n1 = DVec3::ZERO;
        }
        let between = places[0].inv_mul(&arrived);
        // all pairs of these kinds are supported
        let _ = DefaultQueryDispatcher.contact_manifolds(
            &between,
            &**first,
            &**second,
            reach,
            &mut self.manifolds,
            &mut None,
        );
        for m in &self.manifolds {
            let normal = places[0].rotation * m.local_n1;
            for p in &m.points {
                let (x, y) = (places[0] * p.local_p1, places[1] * p.local_p2);
                let key = [pair[0], pair[1], m.subshape1, m.subshape2, p.fid1.0, p.fid2.0];
                let speed = allowed(p.dist, small, dt) + velocity.dot(normal) * (passed / dt);
                found(Spot { key, x: (x + y) / 2.0, at: Approach { normal, speed } });
            }
        }
    }
}

/// [`least`] of things of which the smaller one has the radius `small` [m].
fn allowed(gap: f64, small: f64, dt: f64) -> f64 {
    least(if gap > 0.0 { gap } else { (gap + LEFT * small).min(0.0) }, dt)
}

/// The points of one of two `sides`, of radius `small` [m], that are within `reach` [m] of the other, which is a plane.
fn at_plane(pair: [u32; 2], sides: [Side<'_>; 2], (small, reach): (f64, f64), dt: f64, mut found: impl FnMut(Spot)) {
    let (plane, other, sign) = match (sides[0].shape, sides[1].shape) {
        (Shape::Plane { normal }, _) => ((sides[0].pose, *normal), sides[1], 1.0),
        (_, Shape::Plane { normal }) => ((sides[1].pose, *normal), sides[0], -1.0),
        _ => return,
    };
    let (origin, turn) = plane.0.place();
    let (position, orientation) = other.pose.place();
    let normal = turn * plane.1;
    let mut feature = 0;
    other.shape.lowest(orientation.inverse() * -normal, |point| {
        let x = position + orientation * point;
        let gap = (x - origin).dot(normal);
        if gap <= reach {
            let key = [pair[0], pair[1], 0, 0, feature, 0];
            found(Spot { key, x, at: Approach { normal: normal * sign, speed: allowed(gap, small, dt) } });
        }
        feature += 1;
    });
}

fn solid(shape: &Shape) -> Option<Box<dyn Solid>> {
    Some(match shape {
        Shape::Plane { .. } => return None,
        Shape::Ball { radius } => Box::new(Ball::new(*radius)),
        Shape::Box { half } => Box::new(Cuboid::new(*half)),
        Shape::Capsule { half, radius } => Box::new(Capsule::new_y(*half, *radius)),
        Shape::Cylinder { half, radius } => Box::new(Cylinder::new(*half, *radius)),
        Shape::Mesh(mesh) => mesh.solid()?,
    })
}
