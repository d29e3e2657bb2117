//! The ground: a plane that nothing passes.
//!
//! Contact is a limit on velocity, not a spring: a particle may approach only as fast as its gap allows in one step, so
//! it never penetrates, at any stiffness and step, and resting is quiet.

use glam::DVec3;

/// Rebounds slower than this [m/s] are not made, so that a body comes to rest.
const QUIET: f64 = 0.01;

/// An infinite plane with restitution and Coulomb friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Unit normal, pointing to the free side.
    pub normal: DVec3,
    /// Signed distance of the plane from the origin along the normal [m].
    pub height: f64,
    /// Restitution: share of the normal speed that returns, 0 ..= 1.
    pub restitution: f64,
    /// Coulomb friction coefficient, 0 or more.
    pub friction: f64,
}

impl Default for Ground {
    fn default() -> Self {
        Self { normal: DVec3::Y, height: 0.0, restitution: 0.1, friction: 0.5 }
    }
}

impl Ground {
    /// The velocity [m/s] that a particle of radius `r` [m] at `x` keeps, which would move at `v` for a step of `dt` [s].
    #[inline]
    pub fn limit(&self, x: DVec3, r: f64, v: DVec3, dt: f64) -> DVec3 {
        let gap = x.dot(self.normal) - self.height - r;
        let normal_speed = v.dot(self.normal);
        // what would be left of the gap at the end of the step; an overlap is pushed out over some steps, not shot out
        let allowed = if gap >= 0.0 { -gap / dt } else { (-0.1 * gap / dt).min(1.0) };
        if normal_speed >= allowed {
            return v;
        }
        let rebound = -self.restitution * normal_speed;
        let bounced = if rebound > QUIET { allowed.max(rebound) } else { allowed };
        let push = bounced - normal_speed;
        let slide = v - self.normal * normal_speed;
        let speed = slide.length();
        let keep = if speed > 0.0 { (1.0 - self.friction * push / speed).max(0.0) } else { 0.0 };
        slide * keep + self.normal * bounced
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_falling_particle_stops_on_the_plane_and_friction_slows_it() {
        let ground = Ground { restitution: 0.0, friction: 0.5, ..Default::default() };
        let (mut x, mut v) = (DVec3::new(0.0, 1.0, 0.0), DVec3::new(3.0, 0.0, 0.0));
        for _ in 0..2000 {
            v = ground.limit(x, 0.1, v + DVec3::NEG_Y * 9.81 * 1e-3, 1e-3);
            x += v * 1e-3;
            assert!(x.y >= 0.1 - 1e-12, "penetrates: {}", x.y);
        }
        // lands at 4.2 m/s, which takes all of 0.5 · 4.2 m/s and then 0.5 g of the slide
        assert!((x.y - 0.1).abs() < 1e-9 && v.length() < 1e-9, "{x} {v}");
    }

    #[test]
    fn restitution_returns_its_share() {
        let ground = Ground { restitution: 0.5, friction: 0.0, ..Default::default() };
        let v = ground.limit(DVec3::new(0.0, 0.1, 0.0), 0.1, DVec3::new(1.0, -2.0, 0.0), 1e-3);
        assert_eq!(v, DVec3::new(1.0, 1.0, 0.0));
    }
}
