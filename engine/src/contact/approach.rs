//! How fast a ball may come nearer to a collider in one step.
//!
//! Contact is a limit on velocity, not a spring: what approaches may do so only as fast as its gap allows in one step, so it
//! never penetrates, at any stiffness and step, and resting is quiet. What moves far in a step is followed along its way,
//! so that it neither passes a thin wall nor hits one that it would have missed.

use glam::{DMat3, DQuat, DVec3};

use super::collider::Collider;
use super::shape::Shape;

/// Rebounds slower than this [m/s] are not made, so that things come to rest.
const QUIET: f64 = 0.01;
/// An overlap is pushed out by this share a step, at most this fast [m/s]: over some steps, not shot out.
const PUSH: (f64, f64) = (0.1, 1.0);
/// Longest way in a step, in radii, of which only the start is looked at.
pub const SHORT: f64 = 0.5;
/// Advances along a longer way; what has not arrived by then is held at the plane it has come to.
const ADVANCES: usize = 32;

/// A collider as it stands at the start of a step and moves through it.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    position: DVec3,
    orientation: DQuat,
    turn: DMat3,
    /// Normal of a plane.
    wall: Option<DVec3>,
    /// Whether it gives way.
    free: bool,
    /// Where it goes in the step, as turn and shift about `position`; only of colliders on a path.
    path: Option<(DMat3, DVec3)>,
    /// Radius of a ball about `position` that holds it.
    radius: f64,
    dt: f64,
}

/// What a contact asks for: the relative velocity along `normal`, away from the collider, has to be `speed` [m/s] or more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Unit normal in the world, from the collider outwards.
    pub normal: DVec3,
    /// The least normal speed that is allowed [m/s].
    pub speed: f64,
}

impl Pose {
    /// The collider during the step of `dt` [s] that begins at `time` [s].
    pub fn new(collider: &Collider, time: f64, dt: f64) -> Self {
        let (position, orientation) = collider.pose(time);
        let (next, turned) = collider.pose(time + dt);
        let moves = !collider.is_free() && (next != position || turned != orientation);
        let path = moves.then(|| (DMat3::from_quat(turned * orientation.inverse()), next - position));
        Self { path, ..Self::standing(collider, time, dt) }
    }

    /// The collider as it is at `time` [s], not moving for a step of `dt` [s].
    pub fn standing(collider: &Collider, time: f64, dt: f64) -> Self {
        let (position, orientation) = collider.pose(time);
        let turn = DMat3::from_quat(orientation);
        let free = collider.is_free();
        let wall = match collider.shape {
            Shape::Plane { normal } => Some(turn * normal),
            _ => None,
        };
        Self { position, orientation, turn, wall, free, path: None, radius: collider.shape.radius(), dt }
    }

    /// Velocity [m/s] of the collider at `x` on its path; 0 where it has none.
    #[inline]
    pub fn velocity(&self, x: DVec3) -> DVec3 {
        let Some((turn, shift)) = self.path else { return DVec3::ZERO };
        let arm = x - self.position;
        (turn * arm - arm + shift) / self.dt
    }

    /// Where its origin is, and the turn from its axes to the world's.
    pub(super) fn place(&self) -> (DVec3, DQuat) {
        (self.position, self.orientation)
    }

    /// A bound on how much faster than its origin a point of it moves on its path [m/s].
    pub(super) fn turning(&self) -> f64 {
        let Some((turn, _)) = self.path else { return 0.0 };
        let change = turn - DMat3::IDENTITY;
        let squares = change.x_axis.length_squared() + change.y_axis.length_squared() + change.z_axis.length_squared();
        if squares > 0.0 { squares.sqrt() * self.radius / self.dt } else { 0.0 }
    }

    /// Whether it surely leaves a ball of radius `r` [m] at `x` alone that moves at `u` [m/s]; that costs less than to look
    /// closer.
    #[inline(always)]
    pub fn is_clear(&self, x: DVec3, r: f64, u: DVec3) -> bool {
        if self.free {
            return true;
        }
        match self.wall {
            Some(normal) if self.path.is_none() => {
                let gap = (x - self.position).dot(normal) - r;
                gap > 0.0 && gap + 2.0 * self.dt * u.dot(normal) > 0.0
            }
            _ => false,
        }
    }

    /// What a ball of radius `r` [m] at `x` has to keep to, which would move at `w` [m/s] relative to the collider; `None` if
    /// nothing.
    #[inline]
    pub fn approach(&self, shape: &Shape, x: DVec3, r: f64, w: DVec3) -> Option<Approach> {
        let arm = x - self.position;
        if let Some(normal) = self.wall {
            let gap = arm.dot(normal) - r;
            let speed = least(gap, self.dt);
            return (w.dot(normal) < speed).then_some(Approach { normal, speed });
        }
        let way = w.length() * self.dt;
        let reach = r + way;
        if arm.length_squared() > (self.radius + reach) * (self.radius + reach) {
            return None;
        }
        let local = self.turn.transpose() * arm;
        let (distance, normal) = shape.distance(local, reach)?;
        let gap = distance - r;
        let toward = self.turn.transpose() * w;
        let found = |normal: DVec3, speed: f64| {
            (toward.dot(normal) < speed).then(|| Approach { normal: self.turn * normal, speed })
        };
        if gap < 0.0 || way <= SHORT * r {
            return found(normal, least(gap, self.dt));
        }
        // conservative advancement: no further than the distance that is left
        let (mut gap, mut normal, mut share) = (gap, normal, 0.0);
        for _ in 0..ADVANCES {
            if gap <= 1e-6 * r {
                break;
            }
            share += gap / way;
            if share >= 1.0 {
                return None;
            }
            let (distance, there) = shape.distance(local + toward * (self.dt * share), reach)?;
            (gap, normal) = (distance - r, there);
        }
        found(normal, share * toward.dot(normal) - gap / self.dt)
    }
}

/// The least normal speed [m/s] that keeps a `gap` [m] open through a step, or closes an overlap.
#[inline]
pub fn least(gap: f64, dt: f64) -> f64 {
    if gap < 0.0 { (-PUSH.0 * gap / dt).min(PUSH.1) } else { -gap / dt }
}

/// The normal speed [m/s] with which what comes with `speed` leaves, but no faster than it came `before` in the step before;
/// −∞ where it is too slow to rebound.
#[inline]
pub fn rebound(speed: f64, before: f64, restitution: f64) -> f64 {
    let rebound = -restitution * speed;
    if rebound > QUIET { rebound.min(-before) } else { f64::NEG_INFINITY }
}

/// The least share of the velocity `w` that damping has to leave so that it takes energy and gives none: it works along
/// the mean of what is left and of the velocity `v` in the step before. Of that, as much as the `fall` of a step does not count.
#[inline]
pub fn damped(w: DVec3, v: DVec3, fall: f64) -> f64 {
    let (ww, vv) = (w.length_squared(), v.length());
    if ww > 0.0 && vv > fall { (-w.dot(v) * (1.0 - fall / vv) / ww).clamp(0.0, 1.0) } else { 0.0 }
}

/// The velocity [m/s] that `w` becomes at a thing that does not give way, with Coulomb friction; `v` is that of the step
/// before, `fall` what gravity adds in one.
#[inline]
pub fn stopped(w: DVec3, v: DVec3, fall: f64, at: Approach, friction: f64, restitution: f64) -> DVec3 {
    let (speed, before) = (w.dot(at.normal), v.dot(at.normal));
    let after = at.speed.max(rebound(speed, before, restitution));
    let slide = w - at.normal * speed;
    let fast = slide.length();
    let keep = if fast > 0.0 { 1.0 - friction * (after - speed) / fast } else { 0.0 };
    slide * keep.max(damped(slide, v - at.normal * before, fall)) + at.normal * after
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(c: &Collider, x: DVec3, r: f64, v: DVec3, dt: f64) -> DVec3 {
        match Pose::new(c, 0.0, dt).approach(&c.shape, x, r, v) {
            Some(at) => stopped(v, v, 0.0, at, c.friction, c.restitution),
            None => v,
        }
    }

    #[test]
    fn a_falling_particle_stops_on_the_plane_and_friction_slows_it() {
        let ground = Collider { restitution: 0.0, ..Collider::plane("ground", DVec3::Y, 0.0) };
        let (mut x, mut v) = (DVec3::new(0.0, 1.0, 0.0), DVec3::new(3.0, 0.0, 0.0));
        for _ in 0..2000 {
            v = step(&ground, x, 0.1, v + DVec3::NEG_Y * 9.81 * 1e-3, 1e-3);
            x += v * 1e-3;
            assert!(x.y >= 0.1 - 1e-12, "penetrates: {}", x.y);
        }
        // lands at 4.2 m/s, which takes all of 0.5 · 4.2 m/s and then 0.5 g of the slide
        assert!((x.y - 0.1).abs() < 1e-9 && v.length() < 1e-9, "{x} {v}");
    }

    #[test]
    fn restitution_returns_its_share() {
        let ground = Collider { restitution: 0.5, friction: 0.0, ..Collider::plane("ground", DVec3::Y, 0.0) };
        let v = step(&ground, DVec3::new(0.0, 0.1, 0.0), 0.1, DVec3::new(1.0, -2.0, 0.0), 1e-3);
        assert_eq!(v, DVec3::new(1.0, 1.0, 0.0));
    }

    #[test]
    fn a_way_of_many_sizes_ends_at_what_it_meets_and_nowhere_else() {
        let wall = Shape::Box { half: DVec3::new(1.0, 1.0, 0.005) };
        let thin = Collider { restitution: 0.0, ..Collider::new("wall", wall) };
        for speed in [10.0, 100.0, 1e4] {
            let v = DVec3::new(0.3, 0.1, 1.0) * speed;
            let after = step(&thin, DVec3::new(0.0, 0.0, -0.2), 0.01, v, 1e-2);
            let z = -0.2 + after.z * 1e-2;
            assert!((z + 0.015).abs() < 1e-5 || (speed == 10.0 && after == v), "{speed}: at {z}");
        }
        // a ball is passed at a distance of 1.2 radii, though the way is 20 of them
        let ball = Collider::new("ball", Shape::Ball { radius: 0.05 });
        let v = DVec3::X * 100.0;
        assert_eq!(step(&ball, DVec3::new(-0.5, 0.072, 0.0), 0.01, v, 1e-2), v);
        assert_ne!(step(&ball, DVec3::new(-0.5, 0.055, 0.0), 0.01, v, 1e-2), v);
    }

    #[test]
    fn a_moving_wall_pushes() {
        use super::super::{Keyframe, Motion};
        use glam::DQuat;
        let frame = |time, z| Keyframe { time, position: DVec3::Z * z, orientation: DQuat::IDENTITY };
        let motion = Motion::Keyframes(vec![frame(0.0, 0.0), frame(1.0, 2.0)]);
        let wall = Collider { motion, ..Collider::new("wall", Shape::Box { half: DVec3::ONE }) };
        let (x, pose) = (DVec3::new(0.0, 0.0, 1.01), Pose::new(&wall, 0.25, 1e-3));
        assert!((pose.velocity(x) - DVec3::Z * 2.0).length() < 1e-12);
        // it stands at z = 0.5 then, so x is half inside and is pushed out
        let at = pose.approach(&wall.shape, x, 0.01, -pose.velocity(x)).unwrap();
        assert_eq!((at.normal, at.speed), (DVec3::Z, 1.0));
    }
}
