//! Held and driven particles: fixed in place, moved or turned on a given path, and let go at a time.

use glam::{DQuat, DVec3};

use crate::buffer::Buffer;
use crate::column::{Column, Life, Of, Visitor};

/// A rigid motion prescribed to a set of particles, between two times.
#[derive(Clone, Debug, Default)]
pub struct Anchor {
    /// Name for messages and columns.
    pub name: String,
    /// The particles held, in the world's numbering.
    pub particles: Buffer<u32>,
    /// Where each of them was when the anchor took hold [m]; until then where it was at the start.
    pub start: Buffer<DVec3>,
    /// Velocity of the motion [m/s].
    pub velocity: DVec3,
    /// Angular velocity of the motion [rad/s].
    pub spin: DVec3,
    /// Point about which it turns, at the start [m].
    pub centre: DVec3,
    /// Holds from this time [s].
    pub from: f64,
    /// Lets go at this time [s]; infinite for never.
    pub until: f64,
}

impl Anchor {
    /// Whether the anchor holds during the step whose middle is at `time`: the middle, so that rounding of the ends does
    /// not matter.
    pub fn holds(&self, time: f64) -> bool {
        time > self.from && time < self.until
    }

    /// Where particle number `k` of the anchor has to be at `time` [m].
    pub fn place(&self, k: usize, time: f64) -> DVec3 {
        let t = time - self.from;
        let arm = self.start[k] - self.centre;
        let turned = if self.spin == DVec3::ZERO { arm } else { DQuat::from_scaled_axis(self.spin * t) * arm };
        self.centre + turned + self.velocity * t
    }

    /// Velocity of particle number `k` of the anchor at `time` [m/s].
    pub fn rate(&self, k: usize, time: f64) -> DVec3 {
        let middle = self.centre + self.velocity * (time - self.from);
        self.velocity + self.spin.cross(self.place(k, time) - middle)
    }

    /// Shows every column; `life` is that of particle numbers.
    pub fn visit(&mut self, life: Life, v: &mut Visitor<'_>) {
        let scope = format!("anchors/{}", self.name);
        v(&scope, &Column { life, ..Column::live("particles", "1", Of::Thing) }, &mut self.particles);
        v(&scope, &Column::live("start", "m", Of::Thing), &mut self.start);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turning_anchor_keeps_its_radius_and_lets_go() {
        let anchor = Anchor {
            particles: vec![7].into(),
            start: vec![DVec3::X].into(),
            spin: DVec3::Z * std::f64::consts::PI,
            velocity: DVec3::Z,
            until: 1.0,
            ..Default::default()
        };
        assert!(anchor.place(0, 0.5).distance(DVec3::new(0.0, 1.0, 0.5)) < 1e-15);
        assert!(anchor.holds(0.999) && !anchor.holds(1.001) && !anchor.holds(-0.001));
    }
}
