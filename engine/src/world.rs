//! The world: all particles, the bodies they belong to, and the step.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use thiserror::Error;

use crate::adapt;
use crate::anchor::Anchor;
use crate::buffer::Buffer;
use crate::column::{Column, Life, Of, Visitor};
use crate::contact::{self, Collider, Contact};
use crate::integrate::Integrator;
use crate::material::{BuildError, Geometry, Link, Material, Neighbourhood};
use crate::particles::Particles;
use crate::phase::{Phase, Profile};
use crate::relax::{Relax, Relaxed, Scratch};

/// Longest way of what moves fastest in a stable step [spacings].
const WAY: f64 = 0.25;

/// A range of particles with a material.
pub struct Body {
    /// Name, unique in the world.
    pub name: String,
    /// Its particles.
    pub range: Range<usize>,
    /// World position of the rest positions' origin [m].
    pub origin: DVec3,
    /// Mean spacing of its particles [m].
    pub spacing: f64,
    /// Horizon δ of its families [m].
    pub horizon: f64,
    /// What it is made of.
    pub material: Box<dyn Material>,
    /// The links that broke in the last step, counted from the body's first particle.
    pub cuts: Vec<Link>,
}

/// What a new body is made from; one element per particle.
pub struct BodyInput<'a> {
    /// Name, unique in the world.
    pub name: &'a str,
    /// Rest positions in the world [m], in the order of storage.
    pub points: &'a [DVec3],
    /// Volumes [m³].
    pub volumes: &'a [f64],
    /// Number of each particle in the input.
    pub ids: &'a [u32],
    /// Density [kg/m³].
    pub density: f64,
    /// Mean spacing [m].
    pub spacing: f64,
    /// Horizon δ [m].
    pub horizon: f64,
    /// Initial velocity [m/s].
    pub velocity: DVec3,
    /// Initial angular velocity about the centre of mass [rad/s].
    pub spin: DVec3,
    /// What lies about each particle.
    pub neighbourhood: Neighbourhood,
}

/// Why a step could not be made; the state is still that before the step.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum StepError {
    /// A force that is not a number.
    #[error(
        "body `{body}`, particle {particle}: the force is not finite at step {step}, time {time} s; the state before it is kept; try a smaller time step"
    )]
    NotFinite {
        /// Body name.
        body: String,
        /// Particle id in the body's input.
        particle: u32,
        /// Step that failed.
        step: u64,
        /// Time at its start [s].
        time: f64,
    },
    /// A force so large that it would throw a particle past its neighbours within the step.
    #[error(
        "body `{body}`, particle {particle}: the force would throw it past its neighbours at step {step}, time {time} s; the step of {dt} s is too long for what the material has become; give `safety` a smaller value, or dt = \"auto\" if it was given"
    )]
    Unstable {
        /// Body name.
        body: String,
        /// Particle id in the body's input.
        particle: u32,
        /// Step that failed.
        step: u64,
        /// Time at its start [s].
        time: f64,
        /// The time step [s].
        dt: f64,
    },
    /// Forces that cannot be balanced, or not within the iterations. Particles are where they were before the step; if
    /// bonds broke in it, at the equilibrium in which they did, with the anchors at the end of the step.
    #[error(
        "no equilibrium at time {time} s (step {step}): after {iterations} iterations the unbalanced force is {residual:.1e} of the load instead of {wanted:.1e}, most of it at body `{body}`, particle {particle}; is there a piece that nothing holds? If not, load in smaller steps (dt), or give more `iterations` or a larger `residual`"
    )]
    NoEquilibrium {
        /// Body name.
        body: String,
        /// Particle id in the body's input.
        particle: u32,
        /// Unbalanced force as a share of the load.
        residual: f64,
        /// What was wanted.
        wanted: f64,
        /// Iterations made.
        iterations: u64,
        /// Step that failed.
        step: u64,
        /// Time at its end [s].
        time: f64,
    },
    /// A body that knows no forces.
    #[error("body `{body}` is of a material without forces, which cannot be relaxed; choose another integrator")]
    Unrelaxable {
        /// Body name.
        body: String,
    },
    /// [`World::interrupt`] was set; particles are as after [`NoEquilibrium`](Self::NoEquilibrium).
    #[error("interrupted at step {step}, time {time} s")]
    Interrupted {
        /// Step that was not finished.
        step: u64,
        /// Time at its start [s].
        time: f64,
    },
}

/// Energies of a world [J].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// ½ Σ m v², with that of free colliders.
    pub kinetic: f64,
    /// Stored in the bonds, of the materials that have an energy.
    pub elastic: f64,
    /// −Σ m g·y, likewise.
    pub gravity: f64,
}

/// Everything that moves.
pub struct World {
    /// All particles, body after body.
    pub particles: Particles,
    /// The bodies.
    pub bodies: Vec<Body>,
    /// Held and driven particles.
    pub anchors: Vec<Anchor>,
    /// Rigid things that particles cannot enter.
    pub colliders: Vec<Collider>,
    /// How particles meet each other.
    pub contact: Contact,
    /// Gravity [m/s²].
    pub gravity: DVec3,
    /// How forces become motion.
    pub integrator: Integrator,
    /// Time step [s]; the load step of a relaxation.
    pub dt: f64,
    /// Time [s].
    pub time: f64,
    /// Steps made.
    pub step: u64,
    /// Where the time went.
    pub profile: Profile,
    /// How the last equilibrium was found, if the world is relaxed.
    pub relaxed: Relaxed,
    /// Ends a relaxation, which may take long, when it is set.
    pub interrupt: Option<&'static AtomicBool>,
    /// Acceleration at the present positions [m/s²]; of velocity Verlet alone.
    pub(crate) acceleration: Buffer<DVec3>,
    /// Velocity change of the step [m/s]; scratch, as are the following.
    pub(crate) dv: Vec<DVec3>,
    /// Positions and velocities before the step.
    pub(crate) kept: [Vec<DVec3>; 2],
    pub(crate) relaxing: Scratch,
    pub(crate) adapting: adapt::Scratch,
}

impl Default for World {
    fn default() -> Self {
        Self {
            particles: Particles::default(),
            bodies: Vec::new(),
            anchors: Vec::new(),
            colliders: Vec::new(),
            contact: Contact::default(),
            gravity: DVec3::ZERO,
            integrator: Integrator::default(),
            dt: 0.0,
            time: 0.0,
            step: 0,
            profile: Profile::default(),
            relaxed: Relaxed::default(),
            interrupt: None,
            acceleration: Buffer::default(),
            dv: Vec::new(),
            kept: Default::default(),
            relaxing: Scratch::default(),
            adapting: adapt::Scratch::default(),
        }
    }
}

impl World {
    /// Adds a body at rest in its given shape.
    ///
    /// Rest positions are kept as f32 relative to the middle of the body; that moves a particle by at most 6e-8 of the
    /// body's size, once, and makes rest bonds exact in any precision.
    ///
    /// # Errors
    /// What the material cannot be built from.
    pub fn add(&mut self, input: BodyInput<'_>, mut material: Box<dyn Material>) -> Result<&mut Body, BuildError> {
        let n = input.points.len();
        let start = self.particles.len();
        let first = input.points.first().copied().unwrap_or_default();
        let (low, high) = input.points.iter().fold((first, first), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        let origin = (low + high) / 2.0;
        let rest: Vec<Vec3> = input.points.iter().map(|p| (*p - origin).as_vec3()).collect();
        let volume: f64 = input.volumes.iter().sum();
        let moment: DVec3 = rest.iter().zip(input.volumes).map(|(x, v)| x.as_dvec3() * *v).sum();
        let middle = origin + moment / volume;
        let p = &mut self.particles;
        for k in 0..n {
            let position = origin + rest[k].as_dvec3();
            p.rest.to_mut().push(rest[k]);
            p.position.to_mut().push(position);
            p.velocity.to_mut().push(input.velocity + input.spin.cross(position - middle));
            p.volume.to_mut().push(input.volumes[k]);
            p.mass.to_mut().push(input.volumes[k] * input.density);
            p.damage.to_mut().push(0.0);
            p.id.to_mut().push(input.ids[k]);
        }
        let range = start..start + n;
        material.build(Geometry { particles: self.particles.of(&range), neighbourhood: input.neighbourhood })?;
        let (name, spacing, horizon) = (input.name.to_string(), input.spacing, input.horizon);
        // room for every bond to break in one step: address space only, until it is used
        let cuts = Vec::with_capacity(material.bonds().map_or(0, |b| b.directed() as usize / 2));
        self.bodies.push(Body { name, range, origin, spacing, horizon, material, cuts });
        Ok(self.bodies.last_mut().expect("just pushed"))
    }

    /// Largest step [s] at which every body is stable, also where it rests on another or on a collider, and in which
    /// nothing goes further than a quarter of the spacing of a body with bonds: what hits it faster than sound would throw
    /// its particles past their neighbours before a bond could break.
    pub fn stable_dt(&self) -> f64 {
        let particles = self.particles.velocity.iter().map(|v| v.length());
        let free = self.colliders.iter().filter(|c| c.is_free());
        let fastest = free.map(|c| c.velocity.length()).chain(particles).fold(0.0, f64::max);
        let limit = |b: &Body| {
            let way = if b.material.bonds().is_some() { WAY * b.spacing / fastest } else { f64::INFINITY };
            b.material.stable_dt(&self.particles.of(&b.range)).min(way)
        };
        self.bodies.iter().map(limit).fold(f64::INFINITY, f64::min)
    }

    /// Makes one step of `dt` by the [`Integrator`].
    ///
    /// # Errors
    /// A force that is not finite or absurd; then nothing has changed. No equilibrium, see [`StepError::NoEquilibrium`].
    pub fn step(&mut self) -> Result<(), StepError> {
        self.contact.note_cuts(&self.particles, &self.bodies);
        for b in &mut self.bodies {
            b.cuts.clear();
            b.material.wake();
        }
        if self.step == 0 {
            self.adapt(); // from the finest, after anchors have taken hold
        }
        let mut profile = self.profile;
        let done = match self.integrator {
            Integrator::SymplecticEuler => self.step_euler(&mut profile),
            Integrator::VelocityVerlet => self.step_verlet(&mut profile),
            Integrator::Relax(limit) => self.step_relax(limit, &mut profile),
        };
        self.profile = profile;
        if done.is_ok() {
            self.tick();
        }
        done
    }

    fn step_euler(&mut self, profile: &mut Profile) -> Result<(), StepError> {
        profile.time(Phase::Respond, || self.respond())?;
        profile.time(Phase::Contact, || self.contact());
        profile.time(Phase::Flow, || self.flow(self.dt));
        profile.time(Phase::Fracture, || self.fracture());
        profile.time(Phase::Integrate, || self.advance());
        profile.time(Phase::Adapt, || self.adapt());
        Ok(())
    }

    fn step_verlet(&mut self, profile: &mut Profile) -> Result<(), StepError> {
        profile.time(Phase::Integrate, || self.half_kick());
        profile.time(Phase::Contact, || self.contact());
        profile.time(Phase::Integrate, || (self.keep(), self.advance()));
        profile.time(Phase::Respond, || self.respond()).inspect_err(|_| (self.undo(), self.contact.undo()).1)?;
        profile.time(Phase::Flow, || self.flow(self.dt));
        profile.time(Phase::Fracture, || self.fracture());
        profile.time(Phase::Integrate, || self.finish());
        profile.time(Phase::Adapt, || self.adapt());
        Ok(())
    }

    fn step_relax(&mut self, limit: Relax, profile: &mut Profile) -> Result<(), StepError> {
        let mut dt = self.dt;
        profile.time(Phase::Integrate, || self.load())?;
        loop {
            self.equilibrium(limit, profile).inspect_err(|_| self.undo())?;
            profile.time(Phase::Flow, || self.flow(std::mem::take(&mut dt)));
            let before = self.cut_count();
            profile.time(Phase::Fracture, || self.fracture());
            self.relax_again();
            if self.cut_count() == before {
                return Ok(());
            }
        }
    }

    fn equilibrium(&mut self, limit: Relax, profile: &mut Profile) -> Result<(), StepError> {
        loop {
            if self.interrupt.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
                return Err(StepError::Interrupted { step: self.step, time: self.time });
            }
            profile.time(Phase::Respond, || self.evaluate(1.0));
            profile.time(Phase::Integrate, || self.lighten());
            self.check_forces(0.0)?;
            profile.time(Phase::Contact, || self.lean());
            if profile.time(Phase::Integrate, || self.ease(limit))? {
                return Ok(());
            }
        }
    }

    /// Velocity changes of the step, if they are sane.
    fn respond(&mut self) -> Result<(), StepError> {
        self.evaluate(self.dt);
        self.check_forces(self.dt)
    }

    /// What gravity and deformation change of the velocities in `h` [s], into `dv`. Changes no state.
    pub(crate) fn evaluate(&mut self, h: f64) {
        self.dv.clear();
        self.dv.resize(self.particles.len(), self.gravity * h);
        respond(&mut self.bodies, &self.particles, 0, h, &mut self.dv);
    }

    /// Refuses velocity changes that are not finite or would throw a particle past its neighbours within `h` [s]; at 0 none is too far.
    fn check_forces(&self, h: f64) -> Result<(), StepError> {
        for body in &self.bodies {
            let dv = &self.dv[body.range.clone()];
            let limit = if body.material.position_based() { f64::INFINITY } else { body.spacing / h };
            let wild = |d: &DVec3| d.length_squared() > limit * limit || !d.is_finite();
            let bad = dv.par_iter().with_min_len(4096).position_first(wild);
            if let Some(k) = bad {
                let (name, particle) = (body.name.clone(), self.particles.id[body.range.start + k]);
                let (step, time, dt) = (self.step, self.time, self.dt);
                return Err(if dv[k].is_finite() {
                    StepError::Unstable { body: name, particle, step, time, dt }
                } else {
                    StepError::NotFinite { body: name, particle, step, time }
                });
            }
        }
        Ok(())
    }

    /// Changes `dv` so that nothing passes anything else in this step.
    fn contact(&mut self) {
        let Self { particles, bodies, anchors, colliders, contact, dv, .. } = self;
        let (dt, time, at_positions) = (self.dt, self.time, self.integrator == Integrator::VelocityVerlet);
        let (damage, particles) = (&particles.damage[..], particles.of(&(0..particles.len())));
        let fall = self.gravity * dt;
        let scene = contact::Scene { particles, damage, bodies, anchors, fall, dt, time, at_positions };
        contact.resolve(&scene, colliders, dv);
    }

    /// Changes `dv` so that nothing passes a collider in one iteration of a relaxation; they stand where the step ends.
    fn lean(&mut self) {
        let Self { particles, bodies, anchors, colliders, contact, dv, .. } = self;
        let time = self.time + self.dt;
        let (damage, particles) = (&particles.damage[..], particles.of(&(0..particles.len())));
        let (fall, dt, at_positions) = (DVec3::ZERO, 1.0, false);
        let scene = contact::Scene { particles, damage, bodies, anchors, fall, dt, time, at_positions };
        contact.lean(&scene, colliders, dv);
    }

    fn flow(&mut self, dt: f64) {
        self.bodies.iter_mut().for_each(|b| b.material.flow(dt));
    }

    fn fracture(&mut self) {
        for body in &mut self.bodies {
            body.material.fracture(&mut self.particles.damage[body.range.clone()], &mut body.cuts);
        }
    }

    fn cut_count(&self) -> usize {
        self.bodies.iter().map(|b| b.cuts.len()).sum()
    }

    /// Energies of the present state. With symplectic Euler velocities belong to half a step before the positions, so the
    /// sum swings a little; velocity Verlet has both at one time.
    pub fn energies(&mut self) -> Energies {
        let p = &self.particles;
        let free = || self.colliders.iter().filter(|c| c.is_free());
        let kinetic = p.velocity.iter().zip(&p.mass[..]).map(|(v, m)| 0.5 * m * v.length_squared()).sum::<f64>()
            + free().map(Collider::kinetic).sum::<f64>();
        let gravity = p.position.iter().zip(&p.mass[..]).map(|(x, m)| -m * self.gravity.dot(*x)).sum::<f64>()
            - free().map(|c| c.mass() * self.gravity.dot(c.position)).sum::<f64>();
        let elastic = self.bodies.iter_mut().filter_map(|b| b.material.energy(&self.particles.of(&b.range))).sum();
        Energies { kinetic, elastic, gravity }
    }

    /// Directed bonds built, and directed bonds broken since.
    pub fn bond_counts(&self) -> (u64, u64) {
        let count = |b: &Body| b.material.bonds().map_or((0, 0), |bonds| (bonds.directed(), bonds.holding()));
        let (all, left) = self.bodies.iter().map(count).fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        (all, all - left)
    }

    /// Shows every column of the world, always in the same order.
    pub fn visit(&mut self, v: &mut Visitor<'_>) {
        self.know_accelerations();
        let mut clock = Buffer::new(vec![self.time, self.dt]);
        let mut step = Buffer::new(vec![self.step]);
        v("world", &Column::live("clock", "s", Of::Thing), &mut clock);
        v("world", &Column::live("step", "1", Of::Thing), &mut step);
        if let ([time, dt], [step]) = (&clock[..], &step[..]) {
            (self.time, self.dt, self.step) = (*time, *dt, *step);
        }
        let life = if self.bodies.iter().any(|b| b.material.adapts()) { Life::Live } else { Life::Frozen };
        self.particles.visit(life, v);
        if self.integrator == Integrator::VelocityVerlet {
            v("particles", &Column::live("acceleration", "m/s^2", Of::Particle), &mut self.acceleration);
        }
        for body in &mut self.bodies {
            let scope = format!("bodies/{}", body.name);
            let mut range = Buffer::new(vec![body.range.start as u64, body.range.end as u64]);
            let mut origin = Buffer::new(vec![body.origin]);
            let mut lengths = Buffer::new(vec![body.spacing, body.horizon]);
            v(&scope, &Column { life, ..Column::live("range", "1", Of::Thing) }, &mut range);
            v(&scope, &Column::frozen("origin", "m", Of::Thing), &mut origin);
            v(&scope, &Column::frozen("spacing_and_horizon", "m", Of::Thing), &mut lengths);
            if let ([start, end], [place], [spacing, horizon]) = (&range[..], &origin[..], &lengths[..]) {
                body.range = *start as usize..*end as usize;
                (body.origin, body.spacing, body.horizon) = (*place, *spacing, *horizon);
            }
            body.material.visit(&scope, v);
        }
        for anchor in &mut self.anchors {
            anchor.visit(life, v);
        }
        self.colliders.iter_mut().for_each(|c| c.visit(v));
        self.contact.visit(&self.colliders, v);
    }
}

/// Every body's velocity changes, bodies beside each other; `dv` begins with particle `first`.
fn respond(bodies: &mut [Body], particles: &Particles, first: usize, h: f64, dv: &mut [DVec3]) {
    match bodies {
        [] => {}
        [body] => {
            let own = body.range.start - first..body.range.end - first;
            body.material.respond(&particles.of(&body.range), h, &mut dv[own]);
        }
        _ => {
            let (left, right) = bodies.split_at_mut(bodies.len() / 2);
            let middle = right[0].range.start;
            let (before, behind) = dv.split_at_mut(middle - first);
            rayon::join(|| respond(left, particles, first, h, before), || respond(right, particles, middle, h, behind));
        }
    }
}
