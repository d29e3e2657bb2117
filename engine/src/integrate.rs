//! Integrators: how forces become motion. The phases of each are listed in [`world`](crate::world).
//!
//! ```text
//! symplectic Euler  v += h a(x);  x += h v                            velocities belong to half a step before positions
//! velocity Verlet   v += ½h a;  x += h v;  a = a(x);  v += ½h a       velocities belong to the same time
//! relax             equilibrium under the anchors and gravity of each step: no inertia
//! ```
//! The first two go through the same positions up to rounding where nothing limits velocities: Verlet starts half a step
//! earlier. Each evaluates forces once a step, and is stable up to the same step.

use glam::DVec3;
use rayon::prelude::*;

use crate::relax::Relax;
use crate::world::World;

/// How forces become motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Integrator {
    /// Leapfrog with velocities between positions.
    #[default]
    SymplecticEuler,
    /// Leapfrog with velocities at the time of positions: [`World::energies`] are those of one moment.
    VelocityVerlet,
    /// Every step is an equilibrium.
    Relax(Relax),
}

impl Integrator {
    /// The word in scenes and logs.
    pub fn name(&self) -> &'static str {
        match self {
            Self::SymplecticEuler => "symplectic_euler",
            Self::VelocityVerlet => "velocity_verlet",
            Self::Relax(_) => "relax",
        }
    }
}

impl World {
    /// v += Δv, x += h v, then anchors.
    pub(crate) fn advance(&mut self) {
        let dt = self.dt;
        let p = &mut self.particles;
        let (x, v) = (&mut p.position[..], &mut p.velocity[..]);
        v.par_iter_mut().zip(x).zip(&self.dv).with_min_len(1024).for_each(|((v, x), dv)| {
            *v += *dv;
            *x += *v * dt;
        });
        self.hold(self.time + dt);
    }

    /// Held particles to where they have to be at time `end`, at the mean velocity of the step that ends there.
    pub(crate) fn hold(&mut self, end: f64) {
        let (dt, middle) = (self.dt, end - 0.5 * self.dt);
        let p = &mut self.particles;
        for anchor in self.anchors.iter_mut().filter(|a| a.holds(middle)) {
            let takes_hold = !anchor.holds(middle - dt);
            for k in 0..anchor.particles.len() {
                let i = anchor.particles[k] as usize;
                if takes_hold {
                    anchor.start[k] = p.position[i] - p.velocity[i] * dt;
                }
                let (before, place) = (anchor.place(k, end - dt), anchor.place(k, end));
                p.velocity[i] = (place - before) / dt;
                p.position[i] = place;
            }
        }
    }

    /// Clock and colliders after a step. Nothing can fail any more: free colliders get the velocity that contact has found.
    pub(crate) fn tick(&mut self) {
        self.step += 1;
        self.time += self.dt;
        self.contact.carry(&mut self.colliders, self.time, self.dt);
    }

    /// Half a step's velocity change into `dv`, from the accelerations that the last step ended with.
    pub(crate) fn half_kick(&mut self) {
        self.know_accelerations();
        let half = 0.5 * self.dt;
        self.dv.clear();
        self.dv.extend(self.acceleration.iter().map(|a| *a * half));
    }

    /// Evaluates the accelerations of the present state where no step has left them.
    pub(crate) fn know_accelerations(&mut self) {
        if self.integrator == Integrator::VelocityVerlet && self.acceleration.len() != self.particles.len() {
            let h = self.usual_step();
            self.evaluate(h);
            self.acceleration.set(self.dv.iter().map(|dv| *dv / h).collect());
        }
    }

    /// A step [s] in which forces can be asked for: goal positions do not change velocities in proportion to it.
    pub(crate) fn usual_step(&self) -> f64 {
        if self.bodies.iter().any(|b| b.material.position_based()) { self.dt } else { 1.0 }
    }

    /// The second half of a Verlet step: accelerations at the new positions, and half a step of them.
    pub(crate) fn finish(&mut self) {
        let (dt, end) = (self.dt, self.time + self.dt);
        let v = self.particles.velocity.par_iter_mut();
        v.zip(&mut self.acceleration[..]).zip(&self.dv).with_min_len(1024).for_each(|((v, a), dv)| {
            *v += *dv * 0.5;
            *a = *dv / dt;
        });
        for anchor in self.anchors.iter().filter(|a| a.holds(end - 0.5 * dt)) {
            for (k, &i) in anchor.particles.iter().enumerate() {
                self.particles.velocity[i as usize] = anchor.rate(k, end);
            }
        }
    }

    /// Keeps positions and velocities, so that a step that fails can be undone.
    pub(crate) fn keep(&mut self) {
        let copy = |to: &mut Vec<DVec3>, from: &[DVec3]| {
            to.clear();
            to.extend_from_slice(from);
        };
        copy(&mut self.kept[0], &self.particles.position);
        copy(&mut self.kept[1], &self.particles.velocity);
    }

    /// Back to what was kept.
    pub(crate) fn undo(&mut self) {
        self.particles.position.copy_from_slice(&self.kept[0]);
        self.particles.velocity.copy_from_slice(&self.kept[1]);
    }
}
