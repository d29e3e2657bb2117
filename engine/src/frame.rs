//! A co-rotating frame: the rigid motion that best carries a body's rest positions to where it is now.
//!
//! Bond arithmetic runs in f32. Seen from the world, a body that has turned by 1 rad has displacements as large as the
//! bonds themselves, and the strain is what is left after they cancel: 6e-4 of the force is lost at strain 1e-4. Seen
//! from a frame that turns with the body, displacements are as small as the strain. A law that depends on lengths only
//! does not care which frame it is evaluated in, so any rotation near the right one will do: it is fitted to a fixed
//! sample of the particles, and the cost does not grow with the body.

use glam::{DMat3, DQuat, DVec3};

use crate::particles::BodyParticles;

/// At most this many particles are looked at.
const SAMPLE: usize = 2048;

/// World position y = `centre` + `rotation` · (x − `rest_centre` + u), with rest position x and displacement u.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// From the frame to the world.
    pub rotation: DMat3,
    /// World position of the frame's origin [m].
    pub centre: DVec3,
    /// Rest position of the frame's origin [m].
    pub rest_centre: DVec3,
}

impl Frame {
    /// The frame that follows the body.
    pub fn fit(p: &BodyParticles<'_>) -> Self {
        let still = Self::moved(p);
        let sample = || (0..p.len()).step_by(p.len().div_ceil(SAMPLE).max(1));
        let mut moment = DMat3::ZERO;
        for i in sample() {
            let (y, x) = (p.position[i] - still.centre, p.rest[i].as_dvec3() - still.rest_centre);
            moment += DMat3::from_cols(y * x.x, y * x.y, y * x.z);
        }
        Self { rotation: DMat3::from_quat(rotation_of(moment, DQuat::IDENTITY)), ..still }
    }

    /// A frame that follows the body without turning, for laws that look at directions.
    pub fn moved(p: &BodyParticles<'_>) -> Self {
        let (mut centre, mut rest_centre, mut n) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for i in (0..p.len()).step_by(p.len().div_ceil(SAMPLE).max(1)) {
            centre += p.position[i];
            rest_centre += p.rest[i].as_dvec3();
            n += 1.0;
        }
        Self {
            rotation: DMat3::IDENTITY,
            centre: centre / f64::max(n, 1.0),
            rest_centre: rest_centre / f64::max(n, 1.0),
        }
    }

    /// Displacement in the frame [m] of the particle at world position `y` with rest position `x`.
    #[inline(always)]
    pub fn displacement(&self, y: DVec3, x: DVec3) -> DVec3 {
        self.rotation.transpose() * (y - self.centre) - (x - self.rest_centre)
    }
}

/// The rotation nearest to `a`, found from the guess `start` (Müller, Bender, Chentanez and Macklin 2016): never a
/// reflection, and never undefined, also where `a` is singular or inverted. Non-finite input returns `start`.
pub fn rotation_of(a: DMat3, start: DQuat) -> DQuat {
    let mut q = start;
    for _ in 0..50 {
        let r = DMat3::from_quat(q);
        let dot = r.x_axis.dot(a.x_axis) + r.y_axis.dot(a.y_axis) + r.z_axis.dot(a.z_axis);
        let cross = r.x_axis.cross(a.x_axis) + r.y_axis.cross(a.y_axis) + r.z_axis.cross(a.z_axis);
        let step = cross / (dot.abs() + 1e-300);
        let angle = step.length();
        if !angle.is_finite() {
            return start;
        }
        if angle < 1e-12 {
            break;
        }
        q = (DQuat::from_axis_angle(step / angle, angle) * q).normalize();
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rotation_of_a_strained_turn_is_the_turn() {
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 2.5);
        let strain = DMat3::from_diagonal(DVec3::new(1.3, 0.8, 1.0));
        let found = rotation_of(DMat3::from_quat(turn) * strain, DQuat::IDENTITY);
        assert!(found.dot(turn).abs() > 1.0 - 1e-12, "{found} instead of {turn}");
    }

    #[test]
    fn singular_and_hopeless_matrices_still_give_a_rotation() {
        for a in [DMat3::ZERO, DMat3::from_diagonal(DVec3::X), DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0))] {
            assert!((rotation_of(a, DQuat::IDENTITY).length() - 1.0).abs() < 1e-12);
        }
        assert_eq!(rotation_of(DMat3::from_diagonal(DVec3::NAN), DQuat::IDENTITY), DQuat::IDENTITY);
    }
}
