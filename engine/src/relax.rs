//! Dynamic relaxation: the equilibrium of a body, as the rest that a damped motion comes to.
//!
//! Inertia plays no part in the result, so it is chosen for speed: every particle gets the mass with which one iteration is
//! its longest stable step, ½ λmax(K_i) in units of iterations, and the damping is critical for the slowest mode that still
//! moves. Its frequency is read off the motion itself, by the Rayleigh quotient ω² = Δx·ΔF / Δx·MΔx between two iterations
//! (Underwood 1983; he takes a diagonal for the stiffness, we the forces). Motion against the forces is stopped at once: loose
//! pieces, which move without a force, would otherwise leave the others undamped.
//!
//! A step of the world is a load step of `dt`: anchors go where they have to be at its end, and stay there until what is
//! free has come to rest. Memory is that before the step all the while, and laws return forces on their yield surface, so
//! the rest is that of an implicit (backward Euler) plastic step. Then memory flows, once, and bonds over their limit
//! break, all at the same time; if any did, what is left is relaxed again under the same load, until none does. How
//! finely cracks and plastic paths are followed is thus up to `dt`.

use glam::DVec3;
use rayon::prelude::*;

use crate::integrate::Integrator;
use crate::sum::sum;
use crate::world::{StepError, World};

/// Masses are this much above what is just stable at rest: stretched bonds are stiffer across.
const RESERVE: f64 = 1.1;
/// Above this ω² a motion is about to become unstable (4 is the limit), and masses grow.
const UNSTABLE: f64 = 3.8;
/// A strain that is as good as none: where nothing acts from outside, forces are measured by what it would cause.
const STILL: f64 = 1e-8;
/// A strain that f32 forces may answer with rounding alone, where neighbours have turned against the body as a whole (6e-8
/// measured, on the pieces of a torn bar).
const ROUNDING: f64 = 1e-7;
/// In so many iterations forces fall by a tenth, or they have come down to rounding.
const PATIENCE: u64 = 2000;

/// When a relaxation is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relax {
    /// Unbalanced force that is small enough, as a share of what acts from outside: of the root of the sum of squares of
    /// all forces on held particles or of all weights, whichever is larger. Between 0 and 1; f32 forces allow about 1e-7.
    pub residual: f64,
    /// Iterations of one step after which it is given up.
    pub iterations: u64,
}

impl Default for Relax {
    fn default() -> Self {
        Self { residual: 1e-5, iterations: 100_000 }
    }
}

/// How the last step found its equilibrium.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Relaxed {
    /// Unbalanced force as a share of what acts from outside.
    pub residual: f64,
    /// Force evaluations.
    pub iterations: u64,
    /// Equilibria: one more than there were rounds of breaking.
    pub equilibria: u32,
    /// Whether the search ended because forces no longer fell, at a strain of less than 1e-7: as it does where a body has
    /// been torn apart and next to nothing acts from outside any more.
    pub at_rounding: bool,
}

/// What a relaxation needs and no restart.
#[derive(Default)]
pub(crate) struct Scratch {
    /// λmax(K_i) [N/m], as long as the bodies are the same.
    stiffness: Vec<f64>,
    held: Vec<bool>,
    /// Forces of the iteration before [N].
    force: Vec<DVec3>,
    /// Masses are so many times half the stiffness.
    heavier: f64,
    /// Force on all particles at a strain of 1 [N], as the root of the sum of squares.
    scale: f64,
    /// The smallest unbalanced force so far [N], but for tenths, and the iteration that had it.
    least: (f64, u64),
}

impl World {
    /// Starts a load step: everything stands, and anchors are where they have to be at its end.
    pub(crate) fn load(&mut self) -> Result<(), StepError> {
        let n = self.particles.len();
        self.keep();
        if self.relaxing.stiffness.len() != n {
            let mut stiffness = Vec::with_capacity(n);
            for body in &self.bodies {
                stiffness.extend(body.material.stiffness(&self.particles.of(&body.range)));
                if stiffness.len() != body.range.end {
                    return Err(StepError::Unrelaxable { body: body.name.clone() });
                }
            }
            self.relaxing.stiffness = stiffness;
            self.relaxing.force = vec![DVec3::ZERO; n];
        }
        self.particles.velocity.fill(DVec3::ZERO);
        self.hold(self.time + self.dt);
        self.particles.velocity.fill(DVec3::ZERO);
        let r = &mut self.relaxing;
        r.held.clear();
        r.held.resize(n, false);
        let middle = self.time + 0.5 * self.dt;
        for anchor in self.anchors.iter().filter(|a| a.holds(middle)) {
            anchor.particles.iter().for_each(|&i| r.held[i as usize] = true);
        }
        let spacing = self.bodies.iter().map(|b| b.spacing).fold(f64::INFINITY, f64::min);
        r.scale = spacing * sum(0..n, &|i| [r.stiffness[i].powi(2)])[0].sqrt();
        r.least = (f64::INFINITY, 0);
        r.heavier = RESERVE;
        self.relaxed = Relaxed::default();
        Ok(())
    }

    /// From accelerations to Δv per iteration under the masses of the relaxation.
    pub(crate) fn lighten(&mut self) {
        let (r, mass) = (&self.relaxing, &self.particles.mass);
        let half = 0.5 * r.heavier;
        self.dv.par_iter_mut().enumerate().with_min_len(1024).for_each(|(i, dv)| {
            let fictitious = half * r.stiffness[i];
            *dv = if fictitious > 0.0 { *dv * (mass[i] / fictitious) } else { DVec3::ZERO };
        });
    }

    /// Judges the forces; if they are not balanced, one iteration of damped motion. Says whether they are.
    pub(crate) fn ease(&mut self, limit: Relax) -> Result<bool, StepError> {
        let (p, r, dv) = (&mut self.particles, &mut self.relaxing, &self.dv);
        let (n, half, gravity) = (p.len(), 0.5 * r.heavier, self.gravity.length());
        let force = |i: usize| dv[i] * (half * r.stiffness[i]);
        let [unbalanced, held, weight, work, inertia, power] = sum(0..n, &|i| {
            let f = force(i);
            if r.held[i] {
                return [0.0, f.length_squared(), 0.0, 0.0, 0.0, 0.0];
            }
            let (v, w) = (p.velocity[i], p.mass[i] * gravity);
            let inertia = half * r.stiffness[i] * v.length_squared();
            [f.length_squared(), 0.0, w * w, v.dot(r.force[i] - f), inertia, v.dot(f)]
        });
        let (unbalanced, outside) = (unbalanced.sqrt(), held.max(weight).sqrt().max(STILL * r.scale));
        let relaxed = &mut self.relaxed;
        relaxed.residual = unbalanced / outside;
        relaxed.iterations += 1;
        if unbalanced < 0.9 * r.least.0 {
            r.least = (unbalanced, relaxed.iterations);
        }
        let stuck = relaxed.iterations - r.least.1 > PATIENCE;
        relaxed.at_rounding = stuck && unbalanced <= ROUNDING * r.scale;
        if relaxed.residual <= limit.residual || relaxed.at_rounding {
            p.velocity.fill(DVec3::ZERO);
            return Ok(true);
        }
        if relaxed.iterations >= limit.iterations {
            return Err(self.no_equilibrium(limit));
        }
        let omega2 = if inertia > 0.0 { (work / inertia).max(0.0) } else { 0.0 };
        if omega2 > UNSTABLE {
            r.heavier *= RESERVE;
        }
        // uphill: the motion has overshot, or some pieces swing while others fly and hide that from the quotient
        if omega2 > UNSTABLE || power < 0.0 {
            p.velocity.fill(DVec3::ZERO);
        }
        // critical for the mode that moves: c = 2 ω
        let c = 2.0 * omega2.sqrt();
        let (keep, gain) = ((2.0 - c) / (2.0 + c), 2.0 / (2.0 + c));
        let (held, stiffness) = (&r.held, &r.stiffness);
        let moving = p.position.par_iter_mut().zip(&mut p.velocity[..]).zip(&mut r.force).enumerate();
        moving.with_min_len(1024).for_each(|(i, ((x, v), f))| {
            if !held[i] {
                *f = dv[i] * (half * stiffness[i]);
                *v = *v * keep + dv[i] * gain;
                *x += *v;
            }
        });
        Ok(false)
    }

    fn no_equilibrium(&self, limit: Relax) -> StepError {
        let r = &self.relaxing;
        let force = |i: usize| if r.held[i] { 0.0 } else { self.dv[i].length() * r.stiffness[i] };
        let worst = (0..self.particles.len()).fold(0, |a, b| if force(b) > force(a) { b } else { a });
        let body = self.bodies.iter().find(|b| b.range.contains(&worst));
        StepError::NoEquilibrium {
            body: body.map_or(String::new(), |b| b.name.clone()),
            particle: self.particles.id.get(worst).copied().unwrap_or_default(),
            residual: self.relaxed.residual,
            wanted: limit.residual,
            iterations: self.relaxed.iterations,
            step: self.step,
            time: self.time + self.dt,
        }
    }

    /// After breaking: what is there is where the next search starts, and where a failed one ends.
    pub(crate) fn relax_again(&mut self) {
        self.relaxed.equilibria += 1;
        self.relaxing.least = (f64::INFINITY, self.relaxed.iterations);
        self.keep();
    }

    /// The parameters of the relaxation, if the world is relaxed.
    pub fn relaxes(&self) -> Option<Relax> {
        match self.integrator {
            Integrator::Relax(relax) => Some(relax),
            _ => None,
        }
    }
}
