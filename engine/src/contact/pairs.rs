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
use super::neighbours::{NONE, Neighbours, Record};
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
    /// Each member that touches another before and after an exchange.
    moving: [Vec<Moving>; 2],
    /// How it yields across its contacts [1/kg], and its velocity change so far [m/s]; no change where nothing touches.
    across: Vec<f64>,
    push: Vec<Option<DVec3>>,
}

/// What an exchange reads of another member: half a cache line.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
struct Moving {
    /// Velocity [m/s].
    u: DVec3,
    /// One over the part of the mass that enters each contact [1/kg].
    yields: f64,
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

/// What all contacts of a step have in common.
#[derive(Clone, Copy)]
struct Rules {
    friction: f64,
    restitution: f64,
    /// What gravity adds to a velocity in a step [m/s].
    fall: f64,
}

impl Touch {
    /// What the spring of a contact of which the `gap` [m] is open, and which touches at `d` [m], does to the other [kg m/s].
    /// Forgets the slip that friction does not hold.
    fn spring(&mut self, gap: f64, d: f64, friction: f64) -> DVec3 {
        let overlap = (-gap).clamp(0.0, DEEPEST * d);
        self.along = self.stiffness * overlap;
        self.slip = self.slip.clamp_length_max(friction * overlap);
        self.normal * self.along - self.slip * self.stiffness
    }

    /// What stops the approach of the other, which comes with `w` [m/s], `mass` [kg] moving [kg m/s].
    fn stop(&mut self, w: DVec3, mass: f64, rules: &Rules) -> DVec3 {
        let (speed, before) = (w.dot(self.normal), self.v.dot(self.normal));
        // no faster than the gap allows, but what opened in the step before may close again
        let least = self.least.min((rules.fall - before).min(0.0));
        let after = speed.max(least).max(rebound(speed, before, rules.restitution));
        let along = mass * (after - speed);
        self.along += along;
        self.normal * along
    }

    /// What rubs on the other [kg m/s], beside the spring that slip has wound.
    fn rub(&mut self, w: DVec3, mass: f64, rules: &Rules) -> DVec3 {
        let across = |v: DVec3| v - self.normal * v.dot(self.normal);
        let (slide, wound) = (across(w), self.slip * -self.stiffness);
        let rubbed = slide * ((damped(slide, across(self.v), rules.fall) - 1.0) * mass);
        (wound + rubbed).clamp_length_max(rules.friction * self.along) - wound
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
        self.make_room(scene.particles.len());
        self.find(settings, scene, held, dv);
        let rules = Rules { friction: settings.friction, restitution: settings.restitution, fall: scene.fall.length() };
        self.exchange(|t, w, mass| t.stop(w, mass, &rules));
        if rules.friction > 0.0 {
            self.exchange(|t, w, mass| t.rub(w, mass, &rules));
        }
        self.memory.settle(&self.neighbours);
        let (rank, push) = (&self.neighbours.rank, &self.push);
        dv.par_iter_mut().zip(rank).with_min_len(4096).for_each(|(dv, &k)| {
            if k != NONE
                && let Some(push) = push[k as usize]
            {
                *dv += push;
            }
        });
    }

    /// Room for rows of `n` particles, so that no later step allocates.
    fn make_room(&mut self, n: usize) {
        let members = self.neighbours.members.len();
        for moving in &mut self.moving {
            moving.reserve(n.saturating_sub(moving.len()));
            moving.resize(members, Moving::default());
        }
        self.across.reserve(n.saturating_sub(self.across.len()));
        self.across.resize(members, 0.0);
        self.push.reserve(n.saturating_sub(self.push.len()));
        self.push.resize(members, None);
    }

    /// Finds what touches, carries its memory on, and lets the springs act; what rests on something that does not give way
    /// does not fall away then from what rests on it.
    fn find(
        &mut self,
        settings: &Contact,
        scene: &Scene<'_>,
        held: impl Fn(usize, DVec3) -> DVec3 + Sync,
        dv: &[DVec3],
    ) {
        let (n, dt) = (&self.neighbours, scene.dt);
        let (now, past) = self.memory.split();
        let moving =
            self.moving[0].par_chunks_mut(Neighbours::BLOCK).zip(self.across.par_chunks_mut(Neighbours::BLOCK));
        let blocks = moving.zip(self.push.par_chunks_mut(Neighbours::BLOCK)).zip(now).enumerate();
        blocks.for_each(|(block, (((moving, across), push), Block { rows, ends, touches: list, met }))| {
            n.rows(block, |k, row, fresh| {
                let (a, i, own) = (&n.records[k], n.members[k], k % Neighbours::BLOCK);
                let start = list.len();
                rows.push(i);
                push[own] = None;
                met.clear();
                for e in row.iter().chain(fresh.iter().map(|f| &f.1)).filter(|e| n.may_touch(k, e)) {
                    let (b, d) = (&n.records[e.other as usize], f64::from(e.d));
                    if touches(a, b, d, dt) && a.inv_mass + b.inv_mass > 0.0 {
                        met.push((n.members[e.other as usize], *e));
                    }
                }
                if met.is_empty() {
                    return ends.push(start as u32);
                }
                met.sort_unstable_by_key(|m| m.0);
                // who has got a new place may be in a row twice
                met.dedup_by_key(|m| m.0);
                let (mut kick, mut remembered) = (DVec3::ZERO, past.of(i));
                let before = scene.before(i as usize, dv);
                for &(particle, e) in met.iter() {
                    let (b, d) = (&n.records[e.other as usize], f64::from(e.d));
                    let y = b.x - a.x;
                    let length = y.length();
                    let modulus = 2.0 / (1.0 / f64::from(a.modulus) + 1.0 / f64::from(b.modulus));
                    let (normal, gap, reduced) = (y / length, length - d, 1.0 / (a.inv_mass + b.inv_mass));
                    let v = scene.before(particle as usize, dv) - before;
                    let slip = remembered.slip(i, particle).map_or(DVec3::ZERO, |slip| {
                        let slip = slip + v * dt;
                        slip - normal * slip.dot(normal)
                    });
                    let stiffness = (settings.stiffness * modulus * d * dt).min(PUSH * reduced / dt);
                    let least = -gap.max(0.0) / dt;
                    let mut touch = Touch { particle, member: e.other, normal, v, slip, stiffness, least, along: 0.0 };
                    kick -= touch.spring(gap, d, settings.friction) * a.inv_mass;
                    list.push(touch);
                }
                let [along, aside] = parts(list[start..].iter().map(|t| t.normal));
                moving[own] = Moving { u: held(i as usize, a.u + kick), yields: along * a.inv_mass };
                across[own] = aside * a.inv_mass;
                push[own] = Some(kick);
                ends.push(list.len() as u32);
            });
        });
    }

    /// Adds the impulses on the other of each pair, and their opposites, to velocities and `push`, all from the velocities
    /// before. What follows acts across contacts.
    fn exchange(&mut self, impulse: impl Fn(&mut Touch, DVec3, f64) -> DVec3 + Sync) {
        let ([from, to], across, records) = (&mut self.moving, &self.across, &self.neighbours.records);
        let rows = to.par_chunks_mut(Neighbours::BLOCK).zip(self.push.par_chunks_mut(Neighbours::BLOCK));
        rows.zip(&mut self.memory.now).enumerate().for_each(|(block, ((to, push), touching))| {
            for (row, (to, push)) in to.iter_mut().zip(push).enumerate() {
                let Some(push) = push else { continue };
                let k = block * Neighbours::BLOCK + row;
                let (a, inv_mass, mut kick) = (&from[k], records[k].inv_mass, DVec3::ZERO);
                let range = touching.row(row);
                for t in &mut touching.touches[range] {
                    let b = &from[t.member as usize];
                    kick -= impulse(t, b.u - a.u, 1.0 / (a.yields + b.yields)) * inv_mass;
                }
                *to = Moving { u: a.u + kick, yields: across[k] };
                *push += kick;
            }
        });
        self.moving.swap(0, 1);
    }
}
