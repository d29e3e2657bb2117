//! What holding takes: the force and torque of each anchor.

use glam::DVec3;

use crate::world::World;

/// What an anchor does to the particles it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Reaction {
    /// Name of the anchor.
    pub anchor: String,
    /// Force [N] on the body.
    pub force: DVec3,
    /// Torque [N m] on the body about `centre`.
    pub torque: DVec3,
    /// The point of the torque [m]: where the anchor's centre is now.
    pub centre: DVec3,
}

impl Reaction {
    /// The torque about another point [N m].
    pub fn torque_about(&self, point: DVec3) -> DVec3 {
        self.torque + (self.centre - point).cross(self.force)
    }
}

impl World {
    /// What holding takes in the present state, of the anchors that held in the last step: Σ m (a − g) − f, with a the
    /// acceleration of the prescribed motion, by a force evaluation of its own. A particle in two anchors counts for the
    /// later one, which places it. Leave out contact: what lies on the ground leans on the anchor here.
    pub fn reactions(&mut self) -> Vec<Reaction> {
        let h = self.usual_step();
        self.evaluate(h);
        let middle = if self.step == 0 { self.time + 0.5 * self.dt } else { self.time - 0.5 * self.dt };
        let holding = || self.anchors.iter().enumerate().filter(|(_, a)| a.holds(middle));
        let mut holder = vec![usize::MAX; self.particles.len()];
        for (number, anchor) in holding() {
            anchor.particles.iter().for_each(|&i| holder[i as usize] = number);
        }
        let p = &self.particles;
        let reaction = |(number, anchor): (usize, &crate::Anchor)| {
            let centre = anchor.centre + anchor.velocity * (self.time - anchor.from);
            let (mut force, mut torque) = (DVec3::ZERO, DVec3::ZERO);
            for i in anchor.particles.iter().map(|&i| i as usize).filter(|&i| holder[i] == number) {
                let arm = p.position[i] - centre;
                let turning = anchor.spin.cross(anchor.spin.cross(arm));
                let inertia = if self.relaxes().is_some() { DVec3::ZERO } else { turning };
                let f = (inertia - self.dv[i] / h) * p.mass[i];
                force += f;
                torque += arm.cross(f);
            }
            Reaction { anchor: anchor.name.clone(), force, torque, centre }
        };
        holding().map(reaction).collect()
    }
}
