//! What of a bond body does not depend on when bonds break: its bonds, its law, and every pass but force and fracture.
//!
//! Kept apart from the criterion so that it is compiled once per law, not once per law and criterion.

use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use super::parts::{Criteria, Laws, Regions};
use super::passes::{Memory, Outlook, Scene};
use super::pose::{MOST, Record, Record32, Record64};
use super::quantum::Growth;
use super::rows::{PerChunk, in_blocks};
use super::{stable, surface};
use crate::bonds::{Bonds, CHUNK, shortened};
use crate::buffer::Buffer;
use crate::column::{Column, Of, Visitor};
use crate::fracture::{Bulk, Unbreakable};
use crate::frame::Frame;
use crate::law::BondLaw;
use crate::material::{BuildError, Geometry, Neighbourhood};
use crate::particles::BodyParticles;
use glam::{DVec3, Vec3};

/// The weighted volume that a particle is normalised by is at least this share of the body's median. A corner has an
/// eighth. Less is a splinter with one or two neighbours, whose bonds would carry the stiffness of a whole family and
/// dictate the time step to everybody (measured on a vase with walls of 1.7 elements: a tenth of the step).
const LEAST_M: f64 = 0.1;

/// The bonds of a body and their law `T` with `M` remembered numbers.
pub(super) struct Body<T, const M: usize> {
    /// One, or one per region.
    laws: Vec<T>,
    pub regions: Regions,
    horizon: f64,
    pub bonds: Bonds,
    /// One over the weighted volume m_i [1/m⁵], frozen when bonds break.
    inv_m: Buffer<f64>,
    own: [Buffer<f32>; M],
    twin: [Buffer<f32>; M],
    /// ω [1] of every slot, for a law that reads it.
    influence: Buffer<f32>,
    /// What the law counts per particle, if it does.
    tally: Buffer<f64>,
    pub scratch: Scratch,
}

/// What a step needs and no restart.
#[derive(Default)]
pub(super) struct Scratch {
    pub records: Vec<Record32>,
    /// What displacements are counted in [m].
    quantum: f64,
    growth: Growth,
    pub theta: Vec<f64>,
    /// Norm of every particle before the flow; empty where the law needs none.
    pub norm: Vec<f64>,
    /// What the last force pass found in every row; whether a bond may break in any.
    pub outlook: Vec<Outlook>,
    pub marked: AtomicBool,
    /// Bonds that break, one bit per slot of a chunk.
    pub broken: Vec<u8>,
}

/// m_i = Σ ω|ξ|²V [m⁵] of every row, at least [`LEAST_M`] of the median.
fn weighted_volumes(bonds: &Bonds, rest: &[Vec3], volume: &[f64]) -> Vec<f64> {
    let of = |i: usize| -> f64 {
        let home = rest[i].as_dvec3();
        let share = |k: usize| {
            let j = bonds.neighbours[k] as usize;
            f64::from(bonds.weight[k]) * rest[j].as_dvec3().distance_squared(home) * volume[j]
        };
        bonds.slots(i).map(share).sum()
    };
    let mut m: Vec<f64> = (0..bonds.rows()).into_par_iter().map(of).collect();
    let mut sorted = m.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let least = LEAST_M * sorted.get(m.len() / 2).copied().unwrap_or(1.0);
    m.iter_mut().for_each(|m| *m = m.max(least));
    m
}

impl<T: BondLaw<M>, const M: usize> Body<T, M> {
    pub fn new(laws: Vec<T>, regions: Regions, horizon: f64) -> Self {
        Self {
            laws,
            regions,
            horizon,
            bonds: Bonds::default(),
            inv_m: Buffer::default(),
            own: std::array::from_fn(|_| Buffer::default()),
            twin: std::array::from_fn(|_| Buffer::default()),
            influence: Buffer::default(),
            tally: Buffer::default(),
            scratch: Scratch::default(),
        }
    }

    pub fn laws(&self) -> Laws<'_, T, M> {
        Laws::new(&self.laws, &self.regions)
    }

    /// Bulk modulus of the law of every particle [Pa].
    pub fn bulk_moduli(&self) -> Vec<f64> {
        let each: Vec<f64> = self.laws.iter().map(|law| Bulk::of(law, self.horizon).bulk).collect();
        match &self.regions.rows[..] {
            [] => vec![each[0]; self.bonds.rows()],
            rows => rows.iter().map(|&r| each[usize::from(r)]).collect(),
        }
    }

    pub fn memory(&self) -> Memory<'_, M> {
        Memory { own: self.own.each_ref().map(|b| &b[..]), twin: self.twin.each_ref().map(|b| &b[..]) }
    }

    /// What the passes read, with the records of the present step.
    pub fn scene(&self) -> Scene<'_, Record32> {
        self.scene_of(&self.scratch.records, self.scratch.quantum).with_norm(&self.scratch.norm)
    }

    fn scene_of<'a, R: Record>(&'a self, records: &'a [R], quantum: f64) -> Scene<'a, R> {
        Scene::new(&self.bonds, &self.influence, records, quantum)
    }

    fn frame(&self, p: &BodyParticles<'_>) -> Frame {
        if self.laws().needs_cos() { Frame::moved(p) } else { Frame::fit(p) }
    }

    /// Fills the records; returns what displacements are counted in [m].
    fn pose<R: Record>(&self, p: &BodyParticles<'_>, frame: &Frame, growth: &mut Growth, records: &mut [R]) -> f64 {
        let u = |i: usize| frame.displacement(p.position[i], p.rest[i].as_dvec3());
        let quantum = growth.quantum(&self.bonds, self.horizon, &u);
        records.par_iter_mut().enumerate().with_min_len(1024).for_each(|(i, record)| {
            *record = R::new(p.rest[i], u(i), quantum, p.volume[i], self.inv_m[i]);
        });
        quantum
    }

    /// θ of every particle, into `theta` and the records.
    fn dilate<R: Record>(&self, records: &mut [R], quantum: f64, theta: &mut [f64]) {
        let (laws, scene) = (self.laws(), self.scene_of(records, quantum));
        in_blocks(0..theta.len(), &mut *theta, &|rows, theta: &mut [f64]| {
            for (theta, i) in theta.iter_mut().zip(rows) {
                *theta = scene.dilatation(laws, i);
            }
        });
        records.par_iter_mut().zip(&*theta).with_min_len(1024).for_each(|(r, &t)| r.set_theta(t));
    }

    /// Norm of every particle, of records that have their θ.
    fn sum_norms<R: Record>(laws: Laws<'_, T, M>, scene: Scene<'_, R>, memory: &Memory<'_, M>, norm: &mut [f64]) {
        in_blocks(0..norm.len(), norm, &|rows, norm: &mut [f64]| {
            for (norm, i) in norm.iter_mut().zip(rows) {
                *norm = scene.norm(memory, laws, laws.own(i), i);
            }
        });
    }

    /// The norms of the present memory, at the positions of the records.
    pub fn update_norms(&mut self) {
        let mut norm = std::mem::take(&mut self.scratch.norm);
        norm.resize(self.bonds.rows(), 0.0);
        Self::sum_norms(self.laws(), self.scene().with_norm(&[]), &self.memory(), &mut norm);
        self.scratch.norm = norm;
    }

    /// Brings the scratch up to date with the particles: positions, then θ if anybody wants it, then norms.
    pub fn prepare(&mut self, p: &BodyParticles<'_>, with_theta: bool) -> Frame {
        let frame = self.frame(p);
        let mut s = std::mem::take(&mut self.scratch);
        s.records.resize(p.len(), Record32::default());
        s.theta.resize(p.len(), 0.0);
        s.quantum = self.pose(p, &frame, &mut s.growth, &mut s.records);
        if with_theta {
            self.dilate(&mut s.records, s.quantum, &mut s.theta);
        }
        self.scratch = s;
        if T::NEEDS_NORM {
            self.update_norms();
        }
        frame
    }

    pub fn build(&mut self, g: Geometry<'_>) -> Result<(), BuildError> {
        let (p, n) = (g.particles, g.particles.len());
        let Neighbourhood::Families(families) = g.neighbourhood else {
            return Err(BuildError::Unfit { wanted: "families within a horizon" });
        };
        if n > MOST {
            return Err(BuildError::TooMany { particles: n, most: MOST });
        }
        for (what, column) in [("volume", p.volume), ("mass", p.mass)] {
            if let Some(particle) = column.iter().position(|&x| !(x > 0.0 && x.is_finite())) {
                return Err(BuildError::NotPositive { particle, what, value: column[particle] });
            }
        }
        let (laws, regions) = (&self.laws, &self.regions.rows[..]);
        let (bonds, chunks) = Bonds::grouped(families, p.rest, regions, |i, j, xi| {
            let middle = 0.5 * (p.rest[i].as_dvec3() + p.rest[j].as_dvec3());
            let of = |region: u8| laws[usize::from(region)].influence_at(middle, xi, self.horizon);
            match (regions.get(i), regions.get(j)) {
                (Some(&a), Some(&b)) if a != b => 0.5 * (of(a) + of(b)),
                (region, _) => of(region.copied().unwrap_or(0)),
            }
        });
        (self.bonds, self.regions.chunks) = (bonds, chunks.into());
        let m = weighted_volumes(&self.bonds, p.rest, p.volume);
        if self.laws().needs_influence() {
            self.influence.set(self.bonds.weight.to_vec());
        }
        // the factor belongs to the geometry, so it is for bodies all of whose laws want it
        if self.laws.iter().all(T::compensates_surface) {
            let full = |i: usize| match &laws[usize::from(regions.get(i).copied().unwrap_or(0))] {
                law if law.needs_influence() => {
                    surface::full_family(|n| law.influence_at(p.rest[i].as_dvec3(), n * self.horizon, self.horizon))
                }
                _ => surface::SPHERE,
            };
            surface::compensate(&mut self.bonds, p.rest, p.volume, &m, &full);
        }
        self.bonds.weight.to_mut().iter_mut().for_each(|weight| *weight = shortened(*weight));
        // of the final weights: θ is exact for a pure dilatation, and any κ > 0 is stable beside any μ
        let m = weighted_volumes(&self.bonds, p.rest, p.volume);
        self.inv_m = m.iter().map(|m| 1.0 / m).collect::<Vec<_>>().into();
        let ends = self.bonds.weight.to_mut().iter_mut().zip(&self.bonds.neighbours[..]);
        ends.for_each(|(weight, &j)| *weight = (f64::from(*weight) * p.volume[j as usize]) as f32);
        let slots = self.bonds.neighbours.len();
        for column in self.own.iter_mut().chain(&mut self.twin) {
            column.set(vec![0.0; slots]);
        }
        if T::TALLY.is_some() {
            self.tally.set(vec![0.0; n]);
        }
        Ok(())
    }

    pub fn stable_dt(&self, p: &BodyParticles<'_>) -> f64 {
        let n = p.len();
        let size = 1e-6 * self.horizon;
        let mut position = vec![DVec3::ZERO; n];
        let (mut records, mut theta, mut growth) = (vec![Record32::default(); n], vec![0.0; n], Growth::default());
        let zeros = vec![0.0; if M > 0 { self.bonds.neighbours.len() } else { 0 }];
        let (laws, none) = (self.laws(), Criteria::new(&[Unbreakable], &self.regions));
        let memory = Memory { own: [&zeros[..]; M], twin: [&zeros[..]; M] };
        let dt = stable::largest_step(p, &self.stiffness(p), |u, out| {
            let scale = size / u.iter().map(|u| u.length()).fold(f64::MIN_POSITIVE, f64::max);
            position.par_iter_mut().enumerate().for_each(|(i, y)| *y = p.rest[i].as_dvec3() + u[i] * scale);
            let p = BodyParticles { position: &position, ..*p };
            let quantum = self.pose(&p, &Frame::moved(&p), &mut growth, &mut records);
            if T::NEEDS_THETA {
                self.dilate(&mut records, quantum, &mut theta);
            }
            let scene = self.scene_of(&records, quantum);
            in_blocks(0..n, out, &|rows, out: &mut [DVec3]| {
                for (out, i) in out.iter_mut().zip(rows) {
                    let (f, _) = scene.force(&memory, laws, none, i);
                    *out = f * (p.volume[i] / (p.mass[i] * scale));
                }
            });
        });
        let lags = M > 0 && dt.is_finite();
        if lags { dt / stable::lag(self.laws(), &self.bonds, &self.inv_m, p, dt).sqrt() } else { dt }
    }

    pub fn stiffness(&self, p: &BodyParticles<'_>) -> Vec<f64> {
        stable::stiffness(self.laws(), &self.bonds, &self.inv_m, p)
    }

    pub fn flow(&mut self, dt: f64) {
        if (M == 0 && T::TALLY.is_none()) || self.scratch.outlook.len() != self.bonds.rows() {
            return;
        }
        if T::TALLY.is_some() {
            let laws = Laws::new(&self.laws, &self.regions);
            let norms = self.scratch.norm.iter().zip(&self.inv_m[..]);
            for (i, (tally, (norm, inv_m))) in self.tally.iter_mut().zip(norms).enumerate() {
                *tally += laws.own(i).tally(*norm, *inv_m);
            }
        }
        let s = &self.scratch;
        let scene = Scene::new(&self.bonds, &self.influence, &s.records, s.quantum).with_norm(&s.norm);
        let (laws, offsets) = (Laws::new(&self.laws, &self.regions), &self.bonds.offsets[..]);
        let slots = |b| PerChunk::<f32, CHUNK> { values: b, offsets };
        let own = self.own.each_mut().map(|b| slots(&mut b[..]));
        let twin = self.twin.each_mut().map(|b| slots(&mut b[..]));
        in_blocks(0..self.bonds.rows(), (own, twin), &|rows, (own, twin)| {
            let base = scene.chunks(rows.start).start * CHUNK;
            let (mut own, mut twin) = (own.map(|c| c.values), twin.map(|c| c.values));
            for i in rows.filter(|&i| s.outlook[i].flows) {
                scene.flow(laws, laws.own(i), i, dt, base, [&mut own, &mut twin]);
            }
        });
    }

    pub fn energy(&mut self, p: &BodyParticles<'_>) -> Option<f64> {
        if !self.laws.iter().all(T::has_energy) {
            return None;
        }
        self.prepare(p, T::NEEDS_THETA);
        let (scene, memory, laws) = (self.scene(), self.memory(), self.laws());
        let density: Vec<f64> = (0..p.len())
            .into_par_iter()
            .map(|i| scene.energy(&memory, laws, i) + laws.own(i).theta_energy(self.scratch.theta[i]))
            .collect();
        Some(density.iter().zip(p.volume).map(|(w, v)| w * v).sum())
    }

    pub fn reference_forces(&self, p: &BodyParticles<'_>) -> Option<Vec<DVec3>> {
        // not turned with the body: the fast path must agree with the plainest arithmetic
        let frame = Frame::moved(p);
        let mut records = vec![Record64::default(); p.len()];
        let quantum = self.pose(p, &frame, &mut Growth::default(), &mut records);
        if T::NEEDS_THETA {
            self.dilate(&mut records, quantum, &mut vec![0.0; p.len()]);
        }
        let (scene, memory) = (self.scene_of(&records, quantum), self.memory());
        let mut norm = vec![0.0; if T::NEEDS_NORM { p.len() } else { 0 }];
        Self::sum_norms(self.laws(), scene, &memory, &mut norm);
        let scene = scene.with_norm(&norm);
        let rows = (0..p.len()).into_par_iter();
        let (laws, none) = (self.laws(), Criteria::new(&[Unbreakable], &self.regions));
        Some(rows.map(|i| scene.force(&memory, laws, none, i).0).collect())
    }

    /// Whether restored columns fit each other, so many particles and so many criteria.
    pub fn consistent(&self, particles: usize, criteria: usize) -> bool {
        let slots = self.bonds.neighbours.len();
        self.bonds.consistent(particles)
            && self.inv_m.len() == particles
            && (!T::SEVERAL || self.regions.consistent(particles, self.bonds.intact.len(), criteria))
            && (!self.laws().needs_influence() || self.influence.len() == slots)
            && self.own.iter().chain(&self.twin).all(|column| column.len() == slots)
            && (T::TALLY.is_none() || self.tally.len() == particles)
    }

    pub fn visit(&mut self, scope: &str, v: &mut Visitor<'_>) {
        self.scratch.growth.forget();
        self.bonds.visit(&format!("{scope}/bonds"), v);
        v(
            &format!("{scope}/bonds"),
            &Column::frozen("inverse_weighted_volume", "1/m^5", Of::Particle),
            &mut self.inv_m,
        );
        if self.laws().needs_influence() {
            v(&format!("{scope}/bonds"), &Column::frozen("influence", "1", Of::Bond), &mut self.influence);
        }
        if T::SEVERAL {
            self.regions.visit(scope, v);
        }
        for (column, buffer) in T::MEMORY.iter().zip(&mut self.own) {
            v(&format!("{scope}/memory"), column, buffer);
        }
        for (column, buffer) in T::MEMORY.iter().zip(&mut self.twin) {
            v(&format!("{scope}/twin_memory"), column, buffer);
        }
        if let Some(column) = &T::TALLY {
            v(&format!("{scope}/tally"), column, &mut self.tally);
        }
    }
}
