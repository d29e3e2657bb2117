//! State-based peridynamics around any [`BondLaw`]: the passes θ, force, fracture and flow over a body's bonds.
//!
//! ```text
//! respond   pose: frame, records (48 B a particle)      O(particles)
//!           θ:    Σ over the row, then into the records O(bonds), skipped by bond-based laws
//!           force: Σ (T_ij − T_ji) V_j, and marks bonds that might break
//! flow      memory of both sides of each bond           O(bonds), only laws with memory
//! fracture  marked bonds are judged with φ of both ends O(marked)
//! ```
//! Marks are kept as one byte per chunk, so a step allocates nothing however much breaks.

mod body;
mod parts;
mod passes;
pub mod pose;
mod rows;
mod spectrum;
mod stable;
mod surface;

use std::sync::atomic::Ordering;

use glam::DVec3;

use self::body::Body;
use self::parts::{Criteria, Regions};
use self::passes::Scene;
use self::rows::{PerChunk, in_blocks};
use crate::bonds::Bonds;
use crate::column::Visitor;
use crate::erased::{AnyCriterion, AnyLaw};
use crate::fracture::Criterion;
use crate::law::BondLaw;
use crate::material::{BuildError, Geometry, Link, Material};
use crate::particles::BodyParticles;

/// A body of bonds: law `T` with `M` remembered numbers, fracture criterion `C`.
pub struct Peridynamic<T, C, const M: usize> {
    body: Body<T, M>,
    /// One, or one per region.
    criteria: Vec<C>,
}

impl<T: BondLaw<M>, C: Criterion, const M: usize> Peridynamic<T, C, M> {
    /// A body without particles; [`Material::build`] or a restart fills it.
    pub fn new(law: T, criterion: C, horizon: f64) -> Self {
        Self { body: Body::new(vec![law], Regions::default(), horizon), criteria: vec![criterion] }
    }
}

impl<const M: usize> Peridynamic<AnyLaw<M>, AnyCriterion, M> {
    /// The same with a law and a criterion for every region; `strength` of the bonds between a and b at a · count + b, and
    /// the region of every particle.
    pub(crate) fn several(
        laws: Vec<AnyLaw<M>>,
        criteria: Vec<AnyCriterion>,
        strength: Vec<f64>,
        regions: Vec<u8>,
        horizon: f64,
    ) -> Self {
        let regions = Regions { rows: regions.into(), strength, ..Regions::default() };
        Self { body: Body::new(laws, regions, horizon), criteria }
    }
}

impl<T: BondLaw<M>, C: Criterion, const M: usize> Material for Peridynamic<T, C, M> {
    fn build(&mut self, g: Geometry<'_>) -> Result<(), BuildError> {
        self.body.build(g)
    }

    fn stable_dt(&self, p: &BodyParticles<'_>) -> f64 {
        self.body.stable_dt(p)
    }

    fn stiffness(&self, p: &BodyParticles<'_>) -> Vec<f64> {
        self.body.stiffness(p)
    }

    fn respond(&mut self, p: &BodyParticles<'_>, dt: f64, dv: &mut [DVec3]) {
        let b = &mut self.body;
        let frame = b.prepare(p, T::NEEDS_THETA || C::NEEDS_THETA);
        b.scratch.marks.resize(b.bonds.intact.len(), 0);
        let mut marks = std::mem::take(&mut b.scratch.marks);
        let (memory, laws, marked) = (b.memory(), b.laws(), &b.scratch.marked);
        let criteria = Criteria::new(&self.criteria, &b.regions);
        marked.store(false, Ordering::Relaxed);
        let scene = Scene::new(&b.bonds, &b.scratch.records).with_norm(&b.scratch.norm);
        let work = (dv, PerChunk::<u8, 1> { values: &mut marks, offsets: &b.bonds.offsets });
        in_blocks(0..p.len(), work, &|rows, (dv, marks): (&mut [DVec3], PerChunk<'_, u8, 1>)| {
            let base = scene.chunks(rows.start).start;
            marks.values.fill(0);
            for (dv, i) in dv.iter_mut().zip(rows) {
                let f = scene.force(&memory, laws, criteria, i, |chunk, bits| {
                    marks.values[chunk - base] |= bits;
                    marked.store(true, Ordering::Relaxed);
                });
                *dv += frame.rotation * f * (dt * p.volume[i] / p.mass[i]);
            }
        });
        b.scratch.marks = marks;
    }

    fn flow(&mut self, dt: f64) {
        self.body.flow(dt);
    }

    fn fracture(&mut self, damage: &mut [f32], cuts: &mut Vec<Link>) {
        if !C::BREAKS || !std::mem::take(self.body.scratch.marked.get_mut()) {
            return;
        }
        let b = &mut self.body;
        if T::NEEDS_NORM {
            b.update_norms(); // the memory has flowed since
        }
        let mut marks = std::mem::take(&mut b.scratch.marks);
        let (memory, laws) = (b.memory(), b.laws());
        let criteria = Criteria::new(&self.criteria, &b.regions);
        let scene = Scene::new(&b.bonds, &b.scratch.records).with_norm(&b.scratch.norm);
        let phi = &*damage;
        let work = PerChunk::<u8, 1> { values: &mut marks, offsets: &b.bonds.offsets };
        in_blocks(0..b.bonds.rows(), work, &|rows, marks| {
            let base = scene.chunks(rows.start).start;
            for i in rows {
                for chunk in scene.chunks(i) {
                    let mark = &mut marks.values[chunk - base];
                    if *mark != 0 {
                        *mark &= scene.severities(&memory, laws, criteria, i, chunk, phi);
                    }
                }
            }
        });
        b.bonds.part(&marks, damage, cuts);
        b.scratch.marks = marks;
    }

    fn energy(&mut self, p: &BodyParticles<'_>) -> Option<f64> {
        self.body.energy(p)
    }

    fn reference_forces(&self, p: &BodyParticles<'_>) -> Option<Vec<DVec3>> {
        self.body.reference_forces(p)
    }

    fn bonds(&self) -> Option<&Bonds> {
        Some(&self.body.bonds)
    }

    fn consistent(&self, particles: usize) -> bool {
        let b = &self.body;
        let regions = || b.regions.consistent(particles, b.bonds.intact.len(), self.criteria.len());
        b.bonds.consistent(particles) && (!T::SEVERAL || regions())
    }

    fn visit(&mut self, scope: &str, v: &mut Visitor<'_>) {
        self.body.visit(scope, v);
    }
}
