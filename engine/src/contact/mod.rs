//! Contact: what keeps particles and colliders out of each other. The second phase of a step; it changes velocities only.
//!
//! ```text
//! held particles get the velocity of their anchor
//! pairs      particle–particle: springs, dampers, friction (memory);
//!            rows with slack (neighbours, search, grid, cluster)        parallel, one particle a row
//! rigid      free colliders with particles and other colliders           one serial list, impulses to both sides
//! approach   every particle at fixed and moved colliders, which have the last word        parallel
//! ```

pub mod approach;
mod cluster;
pub mod collider;
mod grid;
mod manifold;
mod memory;
pub mod mesh;
mod neighbours;
pub mod overlap;
mod pairs;
mod rigid;
mod search;
pub mod shape;

use glam::DVec3;
use rayon::prelude::*;

use self::approach::{Pose, stopped};
pub use self::collider::{Collider, Keyframe, Motion};
use self::manifold::Solids;
pub use self::mesh::Mesh;
use self::neighbours::Record;
use self::pairs::Pairs;
use self::rigid::{Kept, Motions, Mover, Other};
pub use self::shape::{Shape, ShapeError};
use crate::adapt::Descent;
use crate::anchor::Anchor;
use crate::column::Visitor;
use crate::particles::{BodyParticles, Particles};
use crate::world::Body;

/// A particle whose family fills less than this share of its horizon's ball is near a surface: in a half space, one less
/// than 0.43 horizons deep.
const FULL: f64 = 0.8;

/// How particles meet each other, and what contact keeps from step to step: what touching pairs remember, else nothing that
/// matters to a result.
#[derive(Debug)]
pub struct Contact {
    /// Whether particles meet each other at all; colliders they meet always.
    pub between: bool,
    /// Coulomb friction coefficient between particles, 0 or more.
    pub friction: f64,
    /// Restitution between particles, 0 ..= 1.
    pub restitution: f64,
    /// Stiffness of a contact in units of bulk modulus times distance, above 0.
    pub stiffness: f64,
    still: Still,
    pairs: Pairs,
    rigid: Rigid,
}

impl Default for Contact {
    fn default() -> Self {
        Self {
            between: true,
            friction: 0.5,
            restitution: 0.0,
            stiffness: 1.0,
            still: Still::default(),
            pairs: Pairs::default(),
            rigid: Rigid::default(),
        }
    }
}

/// What the contacts of free colliders need.
#[derive(Debug, Default)]
struct Rigid {
    poses: Vec<Pose>,
    movers: Vec<Mover>,
    solids: Solids,
    near: Vec<bool>,
    contacts: Vec<rigid::Contact>,
    /// Alone matters to a result.
    kept: Kept,
}

/// What contact reads of the world.
pub(crate) struct Scene<'a> {
    pub particles: BodyParticles<'a>,
    /// φ [1] of every particle.
    pub damage: &'a [f32],
    pub bodies: &'a [Body],
    pub anchors: &'a [Anchor],
    /// What a step of gravity adds to the velocity of free colliders [m/s]; `dv` of particles has it already.
    pub fall: DVec3,
    pub dt: f64,
    /// Time at the start of the step [s].
    pub time: f64,
    /// Whether velocities belong to the time of positions and `dv` to half a step, as in velocity Verlet; else velocities
    /// are those of the step before.
    pub at_positions: bool,
}

impl Scene<'_> {
    /// Velocity at the end of the step as far as it is known [m/s].
    #[inline]
    fn velocity(&self, i: usize, dv: &[DVec3]) -> DVec3 {
        self.particles.velocity[i] + dv[i]
    }

    /// Velocity in the step before [m/s].
    #[inline]
    fn before(&self, i: usize, dv: &[DVec3]) -> DVec3 {
        self.particles.velocity[i] - if self.at_positions { dv[i] } else { DVec3::ZERO }
    }
}

/// What contact knows about particles beside their columns; all but `held` changes only where particles split and merge or a
/// body without bonds falls to pieces.
#[derive(Debug, Default)]
struct Still {
    /// [`radius`] [m].
    radius: Vec<f64>,
    /// Whether it is near a surface of the undamaged body.
    surface: Vec<bool>,
    /// Bulk modulus [Pa]; infinite where the material has none, which leaves stiffness to the time step.
    modulus: Vec<f32>,
    /// Connected piece, of bodies without bonds.
    piece: Vec<u32>,
    /// Whether an anchor holds it in this step.
    held: Vec<bool>,
    /// Version of each body's pieces.
    versions: Vec<u64>,
}

/// Radius [m] of the ball that a particle of `volume` [m³] meets others as: half the edge of a cube as large.
fn radius(volume: f64) -> f64 {
    0.5 * volume.cbrt()
}

impl Still {
    fn of(scene: &Scene<'_>) -> Self {
        let p = scene.particles;
        let radius: Vec<f64> = p.volume.par_iter().map(|&v| radius(v)).collect();
        let (mut surface, mut modulus) = (vec![true; p.len()], vec![f32::INFINITY; p.len()]);
        let (mut piece, mut versions) = (vec![0; p.len()], Vec::with_capacity(scene.bodies.len()));
        for b in scene.bodies {
            let kappa = b.material.bulk_moduli();
            modulus[b.range.clone()].iter_mut().zip(kappa).for_each(|(m, kappa)| *m = kappa as f32);
            let touching = b.material.touching();
            versions.push(touching.map_or(0, |t| t.version));
            if let Some(t) = touching {
                surface[b.range.clone()].copy_from_slice(t.exposed);
                piece[b.range.clone()].iter_mut().zip(t.piece).for_each(|(to, from)| *to = *from);
            }
            let Some(bonds) = b.material.bonds() else { continue };
            let volume = &p.volume[b.range.clone()];
            let full = FULL * 4.0 / 3.0 * std::f64::consts::PI * b.horizon.powi(3);
            surface[b.range.clone()].par_iter_mut().enumerate().for_each(|(i, surface)| {
                let family = bonds.built(i).map(|slot| volume[bonds.neighbours[slot] as usize]);
                *surface = volume[i] + family.sum::<f64>() < full;
            });
        }
        Self { radius, surface, modulus, piece, held: Vec::new(), versions }
    }

    /// Brings pieces up to date where a body has fallen into more; whether one has.
    fn update(&mut self, bodies: &[Body]) -> bool {
        let mut any = false;
        for (b, known) in bodies.iter().zip(&mut self.versions) {
            let Some(t) = b.material.touching().filter(|t| t.version != *known) else { continue };
            *known = t.version;
            any = true;
            self.surface[b.range.clone()].copy_from_slice(t.exposed);
            self.piece[b.range.clone()].iter_mut().zip(t.piece).for_each(|(to, from)| *to = *from);
        }
        any
    }

    /// The particles of body `k` are others than those of `old`.
    fn renew(&mut self, particles: &Particles, bodies: &[Body], k: usize, old: &std::ops::Range<usize>) {
        let (b, n) = (&bodies[k], bodies[k].range.len());
        let volumes = particles.volume[b.range.clone()].iter();
        self.radius.splice(old.clone(), volumes.map(|v| radius(*v)));
        self.surface.splice(old.clone(), std::iter::repeat_n(true, n));
        self.modulus.splice(old.clone(), std::iter::repeat_n(f32::INFINITY, n));
        self.piece.splice(old.clone(), std::iter::repeat_n(0, n));
        self.versions[k] = u64::MAX; // brought up to date before the next contact
    }

    /// One over the mass [1/kg]; 0 while it is held.
    #[inline]
    fn inverse_mass(&self, i: usize, mass: f64) -> f64 {
        if self.held[i] { 0.0 } else { 1.0 / mass }
    }

    #[inline]
    fn record(&self, i: usize, x: DVec3, u: DVec3, mass: f64) -> Record {
        Record { x, u, inv_mass: self.inverse_mass(i, mass), modulus: self.modulus[i] }
    }
}

impl Contact {
    /// How often the rows of neighbours were made: for judging cost.
    pub fn builds(&self) -> u64 {
        self.pairs.neighbours.builds
    }

    /// How many particles may touch another: near a surface, damaged, or bonded to a damaged one.
    pub fn exposed(&self) -> usize {
        self.pairs.neighbours.members.len()
    }

    /// Takes note of what the step before has cut.
    pub(crate) fn note_cuts(&mut self, particles: &Particles, bodies: &[Body]) {
        self.pairs.neighbours.note_cuts(particles, &self.still, bodies);
    }

    /// Takes note that the particles of body `k`, which were those of `old`, have split and merged.
    pub(crate) fn renew(
        &mut self,
        particles: &Particles,
        bodies: &[Body],
        k: usize,
        old: &std::ops::Range<usize>,
        descent: &[Descent],
    ) {
        if self.still.radius.is_empty() {
            return;
        }
        self.still.renew(particles, bodies, k, old);
        self.pairs.memory.renew(old, descent);
        self.pairs.neighbours.rank.clear();
    }

    /// What contact knows about the particles, up to date.
    fn know(&mut self, scene: &Scene<'_>) {
        if self.still.radius.len() != scene.particles.len() {
            self.still = Still::of(scene);
        }
        if self.still.update(scene.bodies) {
            self.pairs.neighbours.rank.clear();
        }
    }

    /// Shows what touching pairs remember, and free `colliders`. Forgets the rows of neighbours, because the particles may have
    /// been replaced; that changes no result.
    pub(crate) fn visit(&mut self, colliders: &[Collider], v: &mut Visitor<'_>) {
        self.pairs.memory.visit(v);
        if colliders.len() > 1 && colliders.iter().any(Collider::is_free) {
            self.rigid.kept.visit(v);
        }
        self.pairs.neighbours.rank.clear();
    }

    /// Takes back what the last step has put into memory.
    pub(crate) fn undo(&mut self) {
        self.pairs.memory.undo();
        self.rigid.kept.undo();
    }

    /// Adds to `dv` what contacts change in this step; [`carry`](Self::carry) does the same for free colliders.
    pub(crate) fn resolve(&mut self, scene: &Scene<'_>, colliders: &[Collider], dv: &mut [DVec3]) {
        self.know(scene);
        self.hold(scene, dv);
        self.rigid.poses.clear();
        self.rigid.poses.extend(colliders.iter().map(|c| Pose::new(c, scene.time, scene.dt)));
        if self.between && may_meet(scene.bodies) {
            let mut pairs = std::mem::take(&mut self.pairs);
            pairs.resolve(self, scene, &self.still, |i, u| self.stopped(scene, colliders, i, u), dv);
            self.pairs = pairs;
        }
        if colliders.iter().any(Collider::is_free) {
            self.push_free(scene, colliders, dv);
        }
        self.stop(scene, colliders, dv);
    }

    /// Stops particles at the colliders as they stand at the time of `scene`: contact in a relaxation, where velocities are
    /// ways per iteration. Particles do not meet each other there, and free colliders stand and are passed.
    pub(crate) fn lean(&mut self, scene: &Scene<'_>, colliders: &[Collider], dv: &mut [DVec3]) {
        self.know(scene);
        self.rigid.movers.clear();
        self.rigid.poses.clear();
        self.rigid.poses.extend(colliders.iter().map(|c| Pose::standing(c, scene.time, scene.dt)));
        self.stop(scene, colliders, dv);
    }

    /// Moves the colliders through the step of `dt` [s] that ends at `time` [s], free ones at the velocity they were found
    /// to have.
    pub(crate) fn carry(&self, colliders: &mut [Collider], time: f64, dt: f64) {
        for (c, mover) in colliders.iter_mut().zip(&self.rigid.movers).filter(|(c, _)| c.is_free()) {
            mover.settle(c);
        }
        let relaxing = self.rigid.movers.is_empty();
        colliders.iter_mut().filter(|c| !(c.is_free() && relaxing)).for_each(|c| c.advance(time, dt));
    }

    /// Gives held particles the velocity that their anchor will give them, so that others meet them as they will move.
    fn hold(&mut self, scene: &Scene<'_>, dv: &mut [DVec3]) {
        let held = &mut self.still.held;
        held.clear();
        held.resize(scene.particles.len(), false);
        let (time, dt) = (scene.time, scene.dt);
        for anchor in scene.anchors.iter().filter(|a| a.holds(time + 0.5 * dt)) {
            for (k, &i) in anchor.particles.iter().enumerate() {
                let i = i as usize;
                held[i] = true;
                let moves = (anchor.place(k, time + dt) - anchor.place(k, time)) / dt;
                dv[i] = moves - scene.particles.velocity[i];
            }
        }
    }

    /// Free colliders against particles and other colliders.
    fn push_free(&mut self, scene: &Scene<'_>, colliders: &[Collider], dv: &mut [DVec3]) {
        let Self { still, rigid: Rigid { poses, movers, solids, near, contacts, kept }, .. } = self;
        let p = scene.particles;
        if solids.len() != colliders.len() {
            *solids = Solids::new(colliders.iter().map(|c| &c.shape));
            let most = solids.spots() * colliders.len();
            contacts.reserve(p.len() + most);
            kept.reserve(most);
        }
        movers.clear();
        movers.extend(colliders.iter().map(|c| Mover::new(c, scene.fall)));
        contacts.clear();
        near.resize(p.len(), false);
        for (k, c) in colliders.iter().enumerate().filter(|(_, c)| c.is_free()) {
            let (pose, mover) = (&poses[k], &movers[k]);
            let meet = |i: usize, dv: &[DVec3]| {
                let (x, w) = (p.position[i], scene.velocity(i, dv) - mover.at(p.position[i]));
                pose.approach(&c.shape, x, still.radius[i], w).map(|at| (at, w))
            };
            let before = &*dv;
            near.par_iter_mut().enumerate().with_min_len(4096).for_each(|(i, near)| {
                *near = meet(i, before).is_some();
            });
            for i in (0..p.len()).filter(|&i| near[i]) {
                let Some((at, w)) = meet(i, dv) else { continue };
                let other = Other::Particle(i as u32, still.inverse_mass(i, p.mass[i]));
                let x = p.position[i];
                contacts.push(rigid::Contact::new(k as u32, other, x, at, w, c.friction, c.restitution));
            }
        }
        rigid::between(colliders, poses, movers, solids, kept, scene.dt, contacts);
        Motions { movers, velocity: p.velocity, dv }.solve(contacts);
        kept.keep(contacts);
    }

    /// Every particle at the colliders that do not give way.
    fn stop(&self, scene: &Scene<'_>, colliders: &[Collider], dv: &mut [DVec3]) {
        if colliders.iter().all(Collider::is_free) {
            return;
        }
        let (p, radius) = (scene.particles, &self.still.radius[..]);
        dv.par_iter_mut().enumerate().with_min_len(1024).for_each(|(i, dv)| {
            let u = p.velocity[i] + *dv;
            // what most particles are asked about, and mostly for nothing
            if !self.rigid.poses.iter().all(|pose| pose.is_clear(p.position[i], radius[i], u)) {
                *dv += self.stopped(scene, colliders, i, u) - u;
            }
        });
    }

    /// What the velocity `u` of particle `i` becomes at the colliders that do not give way [m/s].
    #[inline]
    fn stopped(&self, scene: &Scene<'_>, colliders: &[Collider], i: usize, u: DVec3) -> DVec3 {
        let (x, before, fall) = (scene.particles.position[i], scene.particles.velocity[i], scene.fall.length());
        let mut v = u;
        for (c, pose) in colliders.iter().zip(&self.rigid.poses).filter(|(c, _)| !c.is_free()) {
            let path = pose.velocity(x);
            if let Some(at) = pose.approach(&c.shape, x, self.still.radius[i], v - path) {
                v = path + stopped(v - path, before - path, fall, at, c.friction, c.restitution);
            }
        }
        v
    }
}

/// Whether any two particles can: those of one body without bonds cannot while it is in one piece.
fn may_meet(bodies: &[Body]) -> bool {
    let alone = |b: &Body| b.material.bonds().is_none() && b.material.touching().is_none_or(|t| t.piece.is_empty());
    bodies.len() > 1 || !bodies.iter().all(alone)
}

#[cfg(test)]
mod tests {
    /// A number in [0, 1) that depends on nothing but `k`.
    pub fn unit(k: u64) -> f64 {
        0.5 + 0.5 * crate::noise::noise(k)
    }
}
