//! Particles against particles: between bodies, between fragments, and across broken bonds in compression.
//!
//! Two particles without an intact bond may come nearer only as fast as their gap allows in one step. Where they overlap
//! there is a spring k g between them, with k from the bulk moduli, and one along the contact against the way that they
//! have slipped since they touched (Cundall and Strack 1979), as strong as Coulomb friction lets it be: so a heap rests
//! with every velocity at zero. It only ever pushes, so nothing sticks. β = k h²/m stays below [`PUSH`], so that contact
//! hardly asks for a shorter step than the bonds do.
//!
//! Beside the springs everything is damped as much as can be, approach wholly, but never past what would feed energy: an
//! impulse J works along the mean of the velocity v before the kick of the step and w' after it, so what is allowed is
//! J·(v + w')/2 ≤ 0 and not J·w' ≤ 0 (that of symplectic Euler's own energy, in which bonds and springs are conservative).
//! Without this a pile shook for good above 0.75 of the stable step: its fastest modes turn around in every step. What
//! turns around because it falls is stopped nevertheless, for a constant force feeds nothing and else grains would dance by
//! half of g h for good.
//!
//! First all springs act, then what stops approach, then what rubs: each for all pairs at once, from the velocities before.
//! A particle with several contacts enters each with a part of its mass (mass splitting, Tonge, Benevolenski and Voroshilov
//! 2012). The part need not be one over their number: with s = λmax(Σ n nᵀ) along the normals and λmax(Σ (1 − n nᵀ)) across,
//! energy still never grows (by Cauchy and Schwarz, contact by contact), and six contacts from all sides count as two or
//! three. Both at once, along and across, would need the sum of both. Both sides compute the same pair to the bit and sum
//! their own, in order of particles: linear momentum is kept to round-off and the bits are the same on any number of
//! threads. Normal impulses act along the line between the particles and keep angular momentum as well; friction acts at a
//! distance of two radii and particles have no spin to take it up, so it keeps only the linear.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::approach::{damped, rebound};
use super::memory::{Block, Memory, Touch};
use super::neighbours::{Entry, NONE, Neighbours, Record};
use super::{Contact, Scene, Still};
use crate::peridynamic::largest_eigenvalue;

/// Largest share β of an overlap that one spring takes away in a step.
const PUSH: f64 = 0.15;
/// Of a deeper overlap [distance of touch] no more than this is felt.
const DEEPEST: f64 = 0.25;

/// Velocity changes from contacts. What touches is memory, all else is kept for its room only.
#[derive(Debug, Default)]
pub struct Pairs {
    /// Who may touch whom.
    pub neighbours: Neighbours,
    /// Who does, and how far each pair has slipped.
    pub memory: Memory,
    /// Into how many parts each member's mass is split, along and across its contacts; 0 for no contact.
    split: Vec<[f64; 2]>,
    /// Velocity change of each member so far, and of the present exchange [m/s].
    push: Vec<DVec3>,
    kick: Vec<DVec3>,
}

/// Whether two particles overlap, or will within the step.
#[inline(always)]
fn touches(a: &Record, b: &Record, d: f64, dt: f64) -> bool {
    let (y, w) = (b.x - a.x, b.u - a.u);
    let (yy, yw) = (y.length_squared(), y.dot(w));
    if yy < d * d {
        return yy > 0.0; // two particles in one place have no direction to part in
    }
    if yy + 2.0 * dt * yw >= d * d {
        return false;
    }
    // nearest approach within the step: a miss is no contact
    let ww = w.length_squared();
    let when = (-yw / ww).min(dt);
    yy + when * (2.0 * yw + when * ww) < d * d
}

/// Into how many parts a mass is split among contacts with these normals, along and across them; across somewhat more than
/// the eigenvalue, by the root of the sum of squares of all three.
fn parts(normals: impl Iterator<Item = DVec3>) -> [f64; 2] {
    let (mut sum, mut count) = (DMat3::ZERO, 0.0_f64);
    for n in normals {
        sum += DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        count += 1.0;
    }
    match count {
        0.0 => [0.0; 2],
        1.0 => [1.0; 2],
        _ => {
            let m = DMat3::from_diagonal(DVec3::splat(count)) - sum;
            let squares = m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared();
            [largest_eigenvalue(sum), squares.sqrt().min(count)]
        }
    }
}

/// Two particles that touch, seen from the first. Swapped, it gives the same numbers and opposite vectors.
struct Meeting {
    /// Unit vector from the first to the second.
    normal: DVec3,
    /// How far apart they are [m]; below 0 they overlap.
    gap: f64,
    /// Impulse of a spring per overlap or slip [kg/s].
    stiffness: f64,
    /// Velocity of the second relative to the first, as far as it is known [m/s], and in the step before.
    w: DVec3,
    v: DVec3,
    /// The mass that moves, along the normal and across [kg].
    mass: [f64; 2],
}

impl Meeting {
    /// What springs do to the second [kg m/s]. Forgets the slip that friction does not hold.
    fn spring(&self, t: &mut Touch, friction: f64) -> DVec3 {
        let overlap = (-self.gap).clamp(0.0, DEEPEST * t.d);
        t.along = self.stiffness * overlap;
        t.slip = t.slip.clamp_length_max(friction * overlap);
        self.normal * t.along - t.slip * self.stiffness
    }

    /// What stops the approach of the second [kg m/s].
    fn stop(&self, t: &mut Touch, restitution: f64, dt: f64, fall: f64) -> DVec3 {
        let (speed, before) = (self.w.dot(self.normal), self.v.dot(self.normal));
        // no faster than the gap allows, but what opened in the step before may close again
        let least = (-self.gap.max(0.0) / dt).min((fall - before).min(0.0));
        let after = speed.max(least).max(rebound(speed, before, restitution));
        let along = self.mass[0] * (after - speed);
        t.along += along;
        self.normal * along
    }

    /// What rubs on the second [kg m/s], beside the spring that slip has wound.
    fn rub(&self, t: &mut Touch, friction: f64, fall: f64) -> DVec3 {
        let across = |v: DVec3| v - self.normal * v.dot(self.normal);
        let (slide, wound) = (across(self.w), t.slip * -self.stiffness);
        let rubbed = slide * ((damped(slide, across(self.v), fall) - 1.0) * self.mass[1]);
        (wound + rubbed).clamp_length_max(friction * t.along) - wound
    }
}

impl Pairs {
    /// Adds to `dv` what the particles' contacts with each other change. `held` tells what a particle's velocity becomes at
    /// things that do not give way.
    pub fn resolve(
        &mut self,
        settings: &Contact,
        scene: &Scene<'_>,
        still: &Still,
        held: impl Fn(usize, DVec3) -> DVec3 + Sync,
        dv: &mut [DVec3],
    ) {
        self.neighbours.update(scene, still, dv);
        self.memory.turn(scene.particles.len());
        self.find(scene, dv);
        let (members, most) = (self.neighbours.members.len(), scene.particles.len());
        for column in [&mut self.push, &mut self.kick] {
            column.clear();
            column.reserve(most);
            column.resize(members, DVec3::ZERO);
        }
        let (friction, restitution, dt, fall) =
            (settings.friction, settings.restitution, scene.dt, scene.fall.length());
        self.exchange(settings, scene, dv, |m, t| m.spring(t, friction));
        // who rests on the ground does not fall away from what rests on it
        let Neighbours { records, members, .. } = &mut self.neighbours;
        records.par_iter_mut().zip(&members[..]).zip(&self.split).with_min_len(1024).for_each(
            |((record, &i), split)| {
                if split[0] > 0.0 {
                    record.u = held(i as usize, record.u);
                }
            },
        );
        self.exchange(settings, scene, dv, |m, t| m.stop(t, restitution, dt, fall));
        if friction > 0.0 {
            self.exchange(settings, scene, dv, |m, t| m.rub(t, friction, fall));
        }
        self.memory.settle(&self.neighbours);
        let (rank, push, split) = (&self.neighbours.rank, &self.push, &self.split);
        dv.par_iter_mut().zip(rank).with_min_len(4096).for_each(|(dv, &k)| {
            if k != NONE && split[k as usize][0] > 0.0 {
                *dv += push[k as usize];
            }
        });
    }

    /// Finds what touches, and carries its memory on.
    fn find(&mut self, scene: &Scene<'_>, dv: &[DVec3]) {
        let n = &self.neighbours;
        self.split.reserve(scene.particles.len().saturating_sub(self.split.len()));
        self.split.resize(n.members.len(), [0.0; 2]);
        let (now, past) = self.memory.split();
        let blocks = self.split.par_chunks_mut(Neighbours::BLOCK).zip(now).enumerate();
        blocks.for_each(|(block, (split, Block { rows, ends, touches: list }))| {
            n.rows(block, |k, row, fresh| {
                let (a, i, start) = (&n.records[k], n.members[k], list.len());
                let mut meet = |e: &Entry| {
                    if !n.may_touch(k, e) {
                        return;
                    }
                    let (b, d) = (&n.records[e.other as usize], f64::from(e.d));
                    if touches(a, b, d, scene.dt) && n.exposed[e.other as usize] && a.inv_mass + b.inv_mass > 0.0 {
                        let particle = n.members[e.other as usize];
                        list.push(Touch { particle, member: e.other, d, slip: DVec3::ZERO, along: 0.0 });
                    }
                };
                if n.exposed[k] {
                    row.iter().for_each(&mut meet);
                    fresh.iter().for_each(|f| meet(&f.1));
                }
                list[start..].sort_unstable_by_key(|t| t.particle);
                // who has got a new place may be in a row twice
                let mut kept = start;
                for t in start..list.len() {
                    if kept == start || list[kept - 1].particle != list[t].particle {
                        list[kept] = list[t];
                        kept += 1;
                    }
                }
                list.truncate(kept);
                let own = &mut list[start..];
                let normal = |t: &Touch| (n.records[t.member as usize].x - a.x).normalize();
                for t in own.iter_mut() {
                    let Some(slip) = past.slip(i, t.particle) else { continue };
                    let moved = scene.before(t.particle as usize, dv) - scene.before(i as usize, dv);
                    let (slip, normal) = (slip + moved * scene.dt, normal(t));
                    t.slip = slip - normal * slip.dot(normal);
                }
                split[k % Neighbours::BLOCK] = parts(own.iter().map(normal));
                rows.push(i);
                ends.push(list.len() as u32);
            });
        });
    }

    /// Adds the impulses on the second of each pair, and their opposites, to velocities and `push`.
    fn exchange(
        &mut self,
        settings: &Contact,
        scene: &Scene<'_>,
        dv: &[DVec3],
        impulse: impl Fn(&Meeting, &mut Touch) -> DVec3 + Sync,
    ) {
        let (n, split, dt) = (&self.neighbours, &self.split, scene.dt);
        let blocks = self.kick.par_chunks_mut(Neighbours::BLOCK).zip(&mut self.memory.now).enumerate();
        blocks.for_each(|(block, (kick, touching))| {
            for (row, kick) in kick.iter_mut().enumerate() {
                *kick = DVec3::ZERO;
                let (k, range) = (block * Neighbours::BLOCK + row, touching.row(row));
                let a = &n.records[k];
                for t in &mut touching.touches[range] {
                    let other = t.member as usize;
                    let b = &n.records[other];
                    let y = b.x - a.x;
                    let length = y.length();
                    let modulus = 2.0 / (1.0 / f64::from(a.modulus) + 1.0 / f64::from(b.modulus));
                    let reduced = 1.0 / (a.inv_mass + b.inv_mass);
                    let meeting = Meeting {
                        normal: y / length,
                        gap: length - t.d,
                        stiffness: (settings.stiffness * modulus * t.d * dt).min(PUSH * reduced / dt),
                        w: b.u - a.u,
                        v: scene.before(t.particle as usize, dv) - scene.before(n.members[k] as usize, dv),
                        mass: [0, 1].map(|way| 1.0 / (split[k][way] * a.inv_mass + split[other][way] * b.inv_mass)),
                    };
                    *kick -= impulse(&meeting, t) * a.inv_mass;
                }
            }
        });
        let kicked = self.neighbours.records.par_iter_mut().zip(&mut self.push).zip(&self.kick).with_min_len(4096);
        kicked.for_each(|((record, push), kick)| {
            record.u += *kick;
            *push += *kick;
        });
    }
}
