//! The world: all particles, the bodies they belong to, and the step.

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use thiserror::Error;

use crate::anchor::Anchor;
use crate::bonds::Families;
use crate::buffer::Buffer;
use crate::column::{Column, Of, Visitor};
use crate::contact::{self, Collider, Contact};
use crate::material::{BuildError, Geometry, Link, Material};
use crate::particles::Particles;
use crate::phase::{Phase, Profile};

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
    /// Who is in whose horizon.
    pub families: Families,
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
        "body `{body}`, particle {particle}: the force would throw it past its neighbours at step {step}, time {time} s; the step of {dt} s is too long for this material, try dt = \"auto\" or a smaller one"
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
    /// Time step [s].
    pub dt: f64,
    /// Time [s].
    pub time: f64,
    /// Steps made.
    pub step: u64,
    /// Where the time went.
    pub profile: Profile,
    /// Velocity change of the step [m/s]; scratch.
    dv: Vec<DVec3>,
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
            dt: 0.0,
            time: 0.0,
            step: 0,
            profile: Profile::default(),
            dv: Vec::new(),
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
        material.build(Geometry { particles: self.particles.of(&range), families: input.families })?;
        let (name, spacing, horizon) = (input.name.to_string(), input.spacing, input.horizon);
        // room for every bond to break in one step: address space only, until it is used
        let cuts = Vec::with_capacity(material.bonds().map_or(0, |b| b.directed() as usize / 2));
        self.bodies.push(Body { name, range, origin, spacing, horizon, material, cuts });
        Ok(self.bodies.last_mut().expect("just pushed"))
    }

    /// Largest step [s] at which every body is stable.
    pub fn stable_dt(&self) -> f64 {
        let limit = |b: &Body| b.material.stable_dt(&self.particles.of(&b.range));
        self.bodies.iter().map(limit).fold(f64::INFINITY, f64::min)
    }

    /// Makes one step of `dt` by symplectic Euler: v += h f/ρ + h g, then x += h v.
    ///
    /// # Errors
    /// A force that is not finite or absurd; then nothing has changed.
    pub fn step(&mut self) -> Result<(), StepError> {
        let mut profile = self.profile;
        profile.time(Phase::Respond, || self.respond())?;
        profile.time(Phase::Contact, || self.contact());
        profile.time(Phase::Flow, || self.bodies.iter_mut().for_each(|b| b.material.flow(self.dt)));
        profile.time(Phase::Fracture, || self.fracture());
        profile.time(Phase::Integrate, || self.integrate());
        self.profile = profile;
        Ok(())
    }

    fn respond(&mut self) -> Result<(), StepError> {
        self.dv.clear();
        self.dv.resize(self.particles.len(), DVec3::ZERO);
        for body in &mut self.bodies {
            let dv = &mut self.dv[body.range.clone()];
            body.material.respond(&self.particles.of(&body.range), self.dt, dv);
            let limit = body.spacing / self.dt;
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

    fn contact(&mut self) {
        let scene = contact::Scene {
            particles: &self.particles,
            bodies: &self.bodies,
            anchors: &self.anchors,
            fall: self.gravity * self.dt,
            dt: self.dt,
            time: self.time,
        };
        self.contact.resolve(&scene, &mut self.colliders, &mut self.dv);
    }

    fn fracture(&mut self) {
        for body in &mut self.bodies {
            body.cuts.clear();
            body.material.fracture(&mut self.particles.damage[body.range.clone()], &mut body.cuts);
        }
    }

    fn integrate(&mut self) {
        let (dt, fall) = (self.dt, self.gravity * self.dt);
        self.step += 1;
        self.time += dt;
        let p = &mut self.particles;
        let (x, v) = (&mut p.position[..], &mut p.velocity[..]);
        v.par_iter_mut().zip(x).zip(&self.dv).with_min_len(1024).for_each(|((v, x), dv)| {
            *v += *dv + fall;
            *x += *v * dt;
        });
        self.colliders.iter_mut().for_each(|c| c.advance(self.time, dt));
        let middle = self.time - 0.5 * dt;
        for anchor in self.anchors.iter_mut().filter(|a| a.holds(middle)) {
            let takes_hold = !anchor.holds(middle - dt);
            for k in 0..anchor.particles.len() {
                let i = anchor.particles[k] as usize;
                if takes_hold {
                    anchor.start[k] = p.position[i] - p.velocity[i] * dt;
                }
                let (before, place) = (anchor.place(k, self.time - dt), anchor.place(k, self.time));
                p.velocity[i] = (place - before) / dt;
                p.position[i] = place;
            }
        }
    }

    /// Energies of the present state. Leapfrog: velocities belong to half a step before the positions.
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
        let mut clock = Buffer::new(vec![self.time, self.dt]);
        let mut step = Buffer::new(vec![self.step]);
        v("world", &Column::live("clock", "s", Of::Thing), &mut clock);
        v("world", &Column::live("step", "1", Of::Thing), &mut step);
        if let ([time, dt], [step]) = (&clock[..], &step[..]) {
            (self.time, self.dt, self.step) = (*time, *dt, *step);
        }
        self.particles.visit(v);
        for body in &mut self.bodies {
            let scope = format!("bodies/{}", body.name);
            let mut range = Buffer::new(vec![body.range.start as u64, body.range.end as u64]);
            let mut origin = Buffer::new(vec![body.origin]);
            let mut lengths = Buffer::new(vec![body.spacing, body.horizon]);
            v(&scope, &Column::frozen("range", "1", Of::Thing), &mut range);
            v(&scope, &Column::frozen("origin", "m", Of::Thing), &mut origin);
            v(&scope, &Column::frozen("spacing_and_horizon", "m", Of::Thing), &mut lengths);
            if let ([start, end], [place], [spacing, horizon]) = (&range[..], &origin[..], &lengths[..]) {
                body.range = *start as usize..*end as usize;
                (body.origin, body.spacing, body.horizon) = (*place, *spacing, *horizon);
            }
            body.material.visit(&scope, v);
        }
        for anchor in &mut self.anchors {
            anchor.visit(v);
        }
        self.colliders.iter_mut().for_each(|c| c.visit(v));
        self.contact.forget();
    }
}
