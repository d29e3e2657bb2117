//! Particles against particles: between bodies, between fragments, and across broken bonds in compression.
//!
//! Two particles without an intact bond may come nearer only as fast as their gap allows in one step, and where they overlap
//! they are parted like a spring that is damped as much as can be: an overlap g gives the relative speed β g/h, that is the
//! force k g with β = k h²/m and k from the bulk moduli. It only ever pushes, so nothing sticks. β stays below [`PUSH`], so
//! that contact never asks for a shorter step than the bonds do.
//!
//! All pairs are worked out at once, from the velocities before. A particle with several contacts enters each with a part of
//! its mass (mass splitting, Tonge, Benevolenski and Voroshilov 2012). The part need not be one over their number: with
//! s = λmax(Σ n nᵀ) along the normals and λmax(Σ (1 − n nᵀ)) across, energy still never grows (by Cauchy and Schwarz, contact
//! by contact), and six contacts from all sides count as two. Both sides compute the same pair to the bit and sum their own, in order of index: linear
//! momentum is kept to round-off and the bits are the same on any number of threads. Normal impulses act along the line
//! between the particles and keep angular momentum as well; friction acts at a distance of two radii and particles have no
//! spin to take it up, so it keeps only the linear.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::approach::bounced;
use super::neighbours::{Entry, NONE, Neighbours, Record};
use super::{Contact, Scene, Still};
use crate::bonds::CHUNK;
use crate::peridynamic::largest_eigenvalue;

/// Largest share β of an overlap that a step takes away.
const PUSH: f64 = 0.3;
/// Of a deeper overlap [distance of touch] no more than this is felt.
const DEEPEST: f64 = 0.25;

/// Velocity changes from contacts; kept between steps for their memory only.
#[derive(Debug, Default)]
pub struct Pairs {
    /// Who may touch whom.
    pub neighbours: Neighbours,
    /// Into how many parts each member's mass is split, along and across its contacts; 0 for no contact.
    split: Vec<[f64; 2]>,
    /// Velocity change of each member [m/s].
    push: Vec<DVec3>,
}

/// Two particles that are too close or approach too fast, seen from the first.
struct Meeting {
    /// Unit vector from the first to the second.
    normal: DVec3,
    /// Relative velocity, and its part along the normal [m/s].
    w: DVec3,
    speed: f64,
    /// The least normal speed that is allowed [m/s].
    least: f64,
}

/// What two particles have to keep to in this step; `None` if nothing. Swapped, it gives the same numbers and opposite vectors.
#[inline(always)]
fn meeting(a: &Record, b: &Record, d: f64, stiffness: f64, dt: f64) -> Option<Meeting> {
    let (y, w) = (b.x - a.x, b.u - a.u);
    let (yy, yw) = (y.length_squared(), y.dot(w));
    if yy >= d * d && yw >= 0.0 {
        return None;
    }
    let length = yy.sqrt();
    let (gap, speed) = (length - d, yw / length);
    let least = if gap >= 0.0 {
        if gap + speed * dt >= 0.0 {
            return None;
        }
        // nearest approach within the step: a miss is no contact
        let ww = w.length_squared();
        let when = (-yw / ww).min(dt);
        if yy + when * (2.0 * yw + when * ww) >= d * d {
            return None;
        }
        -gap / dt
    } else {
        let k = stiffness * 2.0 / (1.0 / f64::from(a.modulus) + 1.0 / f64::from(b.modulus)) * d;
        let beta = (k * dt * dt * (a.inv_mass + b.inv_mass)).min(PUSH);
        beta * (-gap).min(DEEPEST * d) / dt
    };
    // two particles in one place have no direction to part in
    (speed < least && length > 0.0).then(|| Meeting { normal: y / length, w, speed, least })
}

/// Into how many parts a mass is split among contacts with these normals, along and across them.
fn parts(normals: impl Iterator<Item = DVec3>) -> [f64; 2] {
    let (mut sum, mut count) = (DMat3::ZERO, 0.0);
    for n in normals {
        sum += DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        count += 1.0;
    }
    match count {
        0.0 => [0.0; 2],
        1.0 => [1.0; 2],
        _ => [largest_eigenvalue(sum), count + largest_eigenvalue(sum * -1.0)],
    }
}

impl Pairs {
    /// Adds to `dv` what the particles' contacts with each other change.
    pub fn resolve(&mut self, settings: &Contact, scene: &Scene<'_>, still: &Still, dv: &mut [DVec3]) {
        self.neighbours.update(scene, still, dv);
        let n = &self.neighbours;
        let most = scene.particles.len();
        self.split.reserve(most.saturating_sub(self.split.len()));
        self.push.reserve(most.saturating_sub(self.push.len()));
        self.split.resize(n.members.len(), [0.0; 2]);
        self.push.resize(n.members.len(), DVec3::ZERO);
        let meet = |k: usize, intact: Option<&[u8]>, e: &Entry| {
            let bond = |bits: &[u8]| bits[e.slot as usize / CHUNK] >> (e.slot as usize % CHUNK) & 1 == 1;
            if e.slot != NONE && intact.is_some_and(bond) {
                return None;
            }
            let (a, b) = (&n.records[k], &n.records[e.other as usize]);
            let m = meeting(a, b, f64::from(e.d), settings.stiffness, scene.dt)?;
            (n.exposed[e.other as usize] && a.inv_mass + b.inv_mass > 0.0).then_some(m)
        };
        let intact = |body: usize| scene.bodies[body].material.bonds().map(|b| &b.intact[..]);
        self.split.par_chunks_mut(Neighbours::BLOCK).enumerate().for_each(|(block, split)| {
            n.rows(block, |k, body, row| {
                let split = &mut split[k % Neighbours::BLOCK];
                *split = [0.0; 2];
                if n.exposed[k] {
                    let bits = intact(body);
                    *split = parts(row.iter().filter_map(|e| meet(k, bits, e)).map(|m| m.normal));
                }
            });
        });
        let split = &self.split;
        self.push.par_chunks_mut(Neighbours::BLOCK).enumerate().for_each(|(block, push)| {
            n.rows(block, |k, body, row| {
                let push = &mut push[k % Neighbours::BLOCK];
                *push = DVec3::ZERO;
                if split[k][0] == 0.0 {
                    return;
                }
                let (bits, a) = (intact(body), &n.records[k]);
                for e in row {
                    let Some(m) = meet(k, bits, e) else { continue };
                    let b = &n.records[e.other as usize];
                    let other = split[e.other as usize];
                    let mass = [0, 1].map(|way| 1.0 / (split[k][way] * a.inv_mass + other[way] * b.inv_mass));
                    let along = mass[0] * (bounced(m.least, m.speed, settings.restitution) - m.speed);
                    let slip = m.w - m.normal * m.speed;
                    let fast = slip.length();
                    let across = if fast > 0.0 { (settings.friction * along / fast).min(mass[1]) } else { 0.0 };
                    // the impulse on b is along · n − across · slip, and a takes its opposite
                    *push += (slip * across - m.normal * along) * a.inv_mass;
                }
            });
        });
        let (rank, push) = (&n.rank, &self.push);
        dv.par_iter_mut().zip(rank).with_min_len(4096).for_each(|(dv, &k)| {
            if k != NONE && split[k as usize][0] > 0.0 {
                *dv += push[k as usize];
            }
        });
    }
}
