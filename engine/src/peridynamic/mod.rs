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

mod passes;
pub mod pose;
mod rows;
mod stable;

use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use self::passes::{Memory, Scene};
use self::pose::{Record, Record32, Record64};
use self::rows::{PerChunk, in_blocks};
pub(crate) use self::stable::largest_eigenvalue;
use crate::bonds::{Bonds, CHUNK};
use crate::buffer::Buffer;
use crate::column::{Column, Of, Visitor};
use crate::frame::Frame;
use crate::law::{BondLaw, Criterion};
use crate::material::{BuildError, Geometry, Link, Material};
use crate::particles::BodyParticles;

/// The weighted volume that a particle is normalised by is at least this share of the body's median. A corner has an
/// eighth. Less is a splinter with one or two neighbours, whose bonds would carry the stiffness of a whole family and
/// dictate the time step to everybody (measured on a vase with walls of 1.7 elements: a tenth of the step).
const LEAST_M: f64 = 0.1;

/// A body of bonds: law `T` with `M` remembered numbers, fracture criterion `C`.
pub struct Peridynamic<T, C, const M: usize> {
    law: T,
    criterion: C,
    horizon: f64,
    bonds: Bonds,
    /// One over the weighted volume m_i [1/m⁵], frozen when bonds break.
    inv_m: Buffer<f64>,
    own: [Buffer<f32>; M],
    twin: [Buffer<f32>; M],
    scratch: Scratch,
}

/// What a step needs and no restart.
#[derive(Default)]
struct Scratch {
    records: Vec<Record32>,
    theta: Vec<f64>,
    /// Bonds that might break, one bit per slot of a chunk.
    marks: Vec<u8>,
    marked: AtomicBool,
}

impl<T: BondLaw<M>, C: Criterion, const M: usize> Peridynamic<T, C, M> {
    /// A body without particles; [`Material::build`] or a restart fills it.
    pub fn new(law: T, criterion: C, horizon: f64) -> Self {
        Self {
            law,
            criterion,
            horizon,
            bonds: Bonds::default(),
            inv_m: Buffer::default(),
            own: std::array::from_fn(|_| Buffer::default()),
            twin: std::array::from_fn(|_| Buffer::default()),
            scratch: Scratch::default(),
        }
    }

    fn memory(&self) -> Memory<'_, M> {
        Memory { own: self.own.each_ref().map(|b| &b[..]), twin: self.twin.each_ref().map(|b| &b[..]) }
    }

    fn frame(&self, p: &BodyParticles<'_>) -> Frame {
        if self.law.needs_cos() { Frame::moved(p) } else { Frame::fit(p) }
    }

    fn pose<R: Record>(inv_m: &[f64], p: &BodyParticles<'_>, frame: &Frame, records: &mut [R]) {
        records.par_iter_mut().enumerate().with_min_len(1024).for_each(|(i, record)| {
            let u = frame.displacement(p.position[i], p.rest[i].as_dvec3());
            *record = R::new(p.rest[i], u, p.volume[i], inv_m[i]);
        });
    }

    /// θ of every particle, into `theta` and the records.
    fn dilate<R: Record>(law: &T, bonds: &Bonds, records: &mut [R], theta: &mut [f64]) {
        let scene = Scene::new(bonds, records);
        in_blocks(0..theta.len(), &mut *theta, &|rows, theta: &mut [f64]| {
            for (theta, i) in theta.iter_mut().zip(rows) {
                *theta = scene.dilatation(law, i);
            }
        });
        records.par_iter_mut().zip(&*theta).with_min_len(1024).for_each(|(r, &t)| r.set_theta(t));
    }

    /// Brings the records up to date with the particles: positions, then θ.
    fn prepare(&mut self, p: &BodyParticles<'_>) -> Frame {
        let frame = self.frame(p);
        let s = &mut self.scratch;
        s.records.resize(p.len(), Record32::default());
        s.theta.resize(p.len(), 0.0);
        Self::pose(&self.inv_m, p, &frame, &mut s.records);
        if T::NEEDS_THETA {
            Self::dilate(&self.law, &self.bonds, &mut s.records, &mut s.theta);
        }
        frame
    }
}

impl<T: BondLaw<M>, C: Criterion, const M: usize> Material for Peridynamic<T, C, M> {
    fn build(&mut self, g: Geometry<'_>) -> Result<(), BuildError> {
        let (p, n) = (g.particles, g.particles.len());
        for (what, column) in [("volume", p.volume), ("mass", p.mass)] {
            if let Some(particle) = column.iter().position(|&x| !(x > 0.0 && x.is_finite())) {
                return Err(BuildError::NotPositive { particle, what, value: column[particle] });
            }
        }
        self.bonds = Bonds::new(&g.families, p.rest, |_, xi| self.law.influence(xi, self.horizon));
        drop(g.families);
        let bonds = &self.bonds;
        let m: Vec<f64> = (0..n)
            .into_par_iter()
            .map(|i| {
                let home = p.rest[i].as_dvec3();
                bonds
                    .slots(i)
                    .map(|k| {
                        let j = bonds.neighbours[k] as usize;
                        f64::from(bonds.weight[k]) * p.rest[j].as_dvec3().distance_squared(home) * p.volume[j]
                    })
                    .sum()
            })
            .collect();
        let mut sorted = m.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let least = LEAST_M * sorted.get(n / 2).copied().unwrap_or(1.0);
        self.inv_m = m.iter().map(|m| 1.0 / m.max(least)).collect::<Vec<_>>().into();
        let slots = self.bonds.neighbours.len();
        for column in self.own.iter_mut().chain(&mut self.twin) {
            column.set(vec![0.0; slots]);
        }
        Ok(())
    }

    fn stable_dt(&self, p: &BodyParticles<'_>) -> f64 {
        stable::largest_step::<T, M>(&self.law, &self.bonds, &self.inv_m, p)
    }

    fn respond(&mut self, p: &BodyParticles<'_>, dt: f64, dv: &mut [DVec3]) {
        let frame = self.prepare(p);
        self.scratch.marks.resize(self.bonds.intact.len(), 0);
        let mut marks = std::mem::take(&mut self.scratch.marks);
        let (memory, law, criterion, marked) = (self.memory(), &self.law, &self.criterion, &self.scratch.marked);
        marked.store(false, Ordering::Relaxed);
        let scene = Scene::new(&self.bonds, &self.scratch.records);
        let work = (dv, PerChunk::<u8, 1> { values: &mut marks, offsets: &self.bonds.offsets });
        in_blocks(0..p.len(), work, &|rows, (dv, marks): (&mut [DVec3], PerChunk<'_, u8, 1>)| {
            let base = scene.chunks(rows.start).start;
            marks.values.fill(0);
            for (dv, i) in dv.iter_mut().zip(rows) {
                let f = scene.force(&memory, law, criterion, i, |chunk, bits| {
                    marks.values[chunk - base] |= bits;
                    marked.store(true, Ordering::Relaxed);
                });
                *dv += frame.rotation * f * (dt * p.volume[i] / p.mass[i]);
            }
        });
        self.scratch.marks = marks;
    }

    fn flow(&mut self, dt: f64) {
        if M == 0 || self.scratch.records.len() != self.bonds.rows() {
            return;
        }
        let scene = Scene::new(&self.bonds, &self.scratch.records);
        let (law, offsets) = (&self.law, &self.bonds.offsets[..]);
        let slots = |b| PerChunk::<f32, CHUNK> { values: b, offsets };
        let own = self.own.each_mut().map(|b| slots(&mut b[..]));
        let twin = self.twin.each_mut().map(|b| slots(&mut b[..]));
        in_blocks(0..self.bonds.rows(), (own, twin), &|rows, (own, twin)| {
            let base = scene.chunks(rows.start).start * CHUNK;
            let (mut own, mut twin) = (own.map(|c| c.values), twin.map(|c| c.values));
            for i in rows {
                scene.flow(law, i, dt, base, &mut own, &mut twin);
            }
        });
    }

    fn fracture(&mut self, damage: &mut [f32], cuts: &mut Vec<Link>) {
        if !C::BREAKS || !std::mem::take(self.scratch.marked.get_mut()) {
            return;
        }
        let mut marks = std::mem::take(&mut self.scratch.marks);
        let (memory, law, criterion) = (self.memory(), &self.law, &self.criterion);
        let scene = Scene::new(&self.bonds, &self.scratch.records);
        let phi = &*damage;
        let work = PerChunk::<u8, 1> { values: &mut marks, offsets: &self.bonds.offsets };
        in_blocks(0..self.bonds.rows(), work, &|rows, marks| {
            let base = scene.chunks(rows.start).start;
            for i in rows {
                for chunk in scene.chunks(i) {
                    let mark = &mut marks.values[chunk - base];
                    if *mark != 0 {
                        *mark &= scene.severities(&memory, law, criterion, i, chunk, phi);
                    }
                }
            }
        });
        let bonds = &mut self.bonds;
        let (offsets, neighbours, family) = (&bonds.offsets[..], &bonds.neighbours[..], &bonds.family[..]);
        let intact = &mut bonds.intact[..];
        for i in 0..family.len() {
            let row = offsets[i] as usize..offsets[i + 1] as usize;
            if marks[row.clone()].iter().all(|&m| m == 0) {
                continue;
            }
            for chunk in row.clone() {
                let broken = marks[chunk] & intact[chunk];
                intact[chunk] &= !broken;
                for l in (0..CHUNK).filter(|l| broken >> l & 1 == 1) {
                    let j = neighbours[chunk * CHUNK + l];
                    if (i as u32) < j {
                        cuts.push(Link { i: i as u32, j });
                    }
                }
            }
            let left: u32 = intact[row].iter().map(|b| b.count_ones()).sum();
            damage[i] = 1.0 - left as f32 / family[i] as f32;
        }
        self.scratch.marks = marks;
    }

    fn energy(&mut self, p: &BodyParticles<'_>) -> Option<f64> {
        if !self.law.has_energy() {
            return None;
        }
        self.prepare(p);
        let scene = Scene::new(&self.bonds, &self.scratch.records);
        let memory = self.memory();
        let density: Vec<f64> = (0..p.len())
            .into_par_iter()
            .map(|i| scene.energy(&memory, &self.law, i) + self.law.theta_energy(self.scratch.theta[i]))
            .collect();
        Some(density.iter().zip(p.volume).map(|(w, v)| w * v).sum())
    }

    fn reference_forces(&self, p: &BodyParticles<'_>) -> Option<Vec<DVec3>> {
        // not turned with the body: the fast path must agree with the plainest arithmetic
        let frame = Frame::moved(p);
        let mut records = vec![Record64::default(); p.len()];
        Self::pose(&self.inv_m, p, &frame, &mut records);
        if T::NEEDS_THETA {
            Self::dilate(&self.law, &self.bonds, &mut records, &mut vec![0.0; p.len()]);
        }
        let (scene, memory) = (Scene::new(&self.bonds, &records), self.memory());
        let rows = (0..p.len()).into_par_iter();
        Some(rows.map(|i| scene.force(&memory, &self.law, &self.criterion, i, |_, _| ())).collect())
    }

    fn bulk_modulus(&self) -> Option<f64> {
        Some(stable::bulk_modulus::<T, M>(&self.law, self.horizon))
    }

    fn bonds(&self) -> Option<&Bonds> {
        Some(&self.bonds)
    }

    fn visit(&mut self, scope: &str, v: &mut Visitor<'_>) {
        self.bonds.visit(&format!("{scope}/bonds"), v);
        v(
            &format!("{scope}/bonds"),
            &Column::frozen("inverse_weighted_volume", "1/m^5", Of::Particle),
            &mut self.inv_m,
        );
        for (column, buffer) in T::MEMORY.iter().zip(&mut self.own) {
            v(&format!("{scope}/memory"), column, buffer);
        }
        for (column, buffer) in T::MEMORY.iter().zip(&mut self.twin) {
            v(&format!("{scope}/twin_memory"), column, buffer);
        }
    }
}
