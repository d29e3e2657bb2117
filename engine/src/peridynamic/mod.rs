//! State-based peridynamics around any [`BondLaw`]: the passes θ, force, fracture and flow over a body's bonds.
//!
//! ```text
//! respond   pose: frame, records (32 B a particle)      O(particles)
//!           θ:    Σ over the row, then into the records O(bonds), skipped by bond-based laws
//!           force: Σ (T_ij − T_ji) V_j, and an outlook on each row
//! flow      memory of both sides of each bond           only rows that flow
//! fracture  bonds are judged with φ of both ends        only rows that may break
//! ```
//! What breaks is kept as one byte per chunk, so a step allocates nothing however much breaks.

mod body;
mod parts;
mod passes;
pub mod pose;
mod quantum;
mod rows;
mod spectrum;
mod stable;
mod surface;

use std::sync::atomic::Ordering;

use glam::DVec3;

use self::body::Body;
use self::parts::{Criteria, Regions};
use self::passes::Outlook;
use self::rows::{PerChunk, in_blocks};
pub(crate) use self::stable::largest_eigenvalue;
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

impl<const M: usize, const FAMILY: bool> Peridynamic<AnyLaw<M, FAMILY>, AnyCriterion, M> {
    /// The same with a law and a criterion for every region; `strength` of the bonds between a and b at a · count + b, and
    /// the region of every particle.
    pub(crate) fn several(
        laws: Vec<AnyLaw<M, FAMILY>>,
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
        let mut outlook = std::mem::take(&mut b.scratch.outlook);
        outlook.resize(p.len(), Outlook::default());
        b.scratch.broken.resize(if C::BREAKS { b.bonds.intact.len() } else { 0 }, 0);
        let (memory, laws, scene) = (b.memory(), b.laws(), b.scene());
        let (criteria, marked) = (Criteria::new(&self.criteria, &b.regions), &b.scratch.marked);
        marked.store(false, Ordering::Relaxed);
        in_blocks(0..p.len(), (dv, &mut outlook[..]), &|rows, (dv, outlook): (&mut [DVec3], &mut [Outlook])| {
            for ((dv, outlook), i) in dv.iter_mut().zip(&mut *outlook).zip(rows) {
                let (f, sees) = scene.force(&memory, laws, criteria, i);
                *outlook = sees;
                *dv += frame.rotation * f * (dt * p.volume[i] / p.mass[i]);
            }
            if outlook.iter().any(|row| row.breaks) {
                marked.store(true, Ordering::Relaxed);
            }
        });
        b.scratch.outlook = outlook;
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
        let mut broken = std::mem::take(&mut b.scratch.broken);
        let (memory, laws, scene) = (b.memory(), b.laws(), b.scene());
        let (criteria, outlook) = (Criteria::new(&self.criteria, &b.regions), &b.scratch.outlook);
        let phi = &*damage;
        let work = PerChunk::<u8, 1> { values: &mut broken, offsets: &b.bonds.offsets };
        in_blocks(0..b.bonds.rows(), work, &|rows, broken| {
            let base = scene.chunks(rows.start).start;
            for i in rows.filter(|&i| outlook[i].breaks) {
                for chunk in scene.chunks(i) {
                    broken.values[chunk - base] = scene.severities(&memory, laws, criteria, i, chunk, (phi, outlook));
                }
            }
        });
        let suspects = (0..b.bonds.rows()).filter(|&i| b.scratch.outlook[i].breaks);
        b.bonds.part(&broken, suspects, damage, cuts);
        b.scratch.broken = broken;
    }

    fn energy(&mut self, p: &BodyParticles<'_>) -> Option<f64> {
        self.body.energy(p)
    }

    fn reference_forces(&self, p: &BodyParticles<'_>) -> Option<Vec<DVec3>> {
        self.body.reference_forces(p)
    }

    fn bulk_moduli(&self) -> Vec<f64> {
        self.body.bulk_moduli()
    }

    fn bonds(&self) -> Option<&Bonds> {
        Some(&self.body.bonds)
    }

    fn consistent(&self, particles: usize) -> bool {
        self.body.consistent(particles, self.criteria.len())
    }

    fn visit(&mut self, scope: &str, v: &mut Visitor<'_>) {
        self.body.visit(scope, v);
    }
}
