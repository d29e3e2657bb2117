//! Bodies whose particles split and merge: the last phase of a step.
//!
//! A body's particles are one range without holes at any time, so a change moves everything behind it, and whoever keeps
//! particle numbers is told: anchors and contact. That costs something in a step with a change and nothing in others. What
//! an anchor holds and what it does not is never merged; pieces of what it holds are held.

use glam::{DQuat, DVec3, Vec3};

use crate::anchor::Anchor;
use crate::buffer::{Buffer, Element};
use crate::particles::BodyParticles;
use crate::world::World;

/// What a material sees when it may replace its particles.
#[derive(Clone, Copy, Debug)]
pub struct Present<'a> {
    /// The particles at the end of the step.
    pub particles: BodyParticles<'a>,
    /// Only particles with the same number may be merged: they are held by the same anchors.
    pub fence: &'a [u64],
}

/// Where a new particle comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Descent {
    /// A particle before whose matter it has, counted from the body's first.
    pub from: u32,
    /// Whether it is that very particle.
    pub same: bool,
}

/// The particles of a body after some have split or merged; one element per particle in each column.
#[derive(Clone, Debug, Default)]
#[allow(missing_docs)] // as in `Particles`
pub struct Renewal {
    pub rest: Vec<Vec3>,
    pub position: Vec<DVec3>,
    pub velocity: Vec<DVec3>,
    pub volume: Vec<f64>,
    pub mass: Vec<f64>,
    pub damage: Vec<f32>,
    pub id: Vec<u32>,
    pub descent: Vec<Descent>,
}

impl Renewal {
    /// Forgets all particles and keeps the room.
    pub fn clear(&mut self) {
        self.rest.clear();
        self.position.clear();
        self.velocity.clear();
        self.volume.clear();
        self.mass.clear();
        self.damage.clear();
        self.id.clear();
        self.descent.clear();
    }
}

/// What adapting needs; memory only.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    fence: Vec<u64>,
    renewal: Renewal,
}

impl World {
    /// Lets bodies split and merge their particles.
    pub(crate) fn adapt(&mut self) {
        let mut scratch = std::mem::take(&mut self.adapting);
        for k in 0..self.bodies.len() {
            let range = self.bodies[k].range.clone();
            if !self.bodies[k].material.adapts() {
                continue;
            }
            scratch.fence.clear();
            scratch.fence.resize(range.len(), 0);
            for (number, anchor) in self.anchors.iter().enumerate() {
                for &i in anchor.particles.iter().filter(|&&i| range.contains(&(i as usize))) {
                    let fence = &mut scratch.fence[i as usize - range.start];
                    *fence = fence.wrapping_mul(self.anchors.len() as u64 + 1).wrapping_add(number as u64 + 1);
                }
            }
            scratch.renewal.clear();
            let present = Present { particles: self.particles.of(&range), fence: &scratch.fence };
            if self.bodies[k].material.adapt(&present, &mut scratch.renewal) {
                self.renew(k, &scratch.renewal);
            }
        }
        self.adapting = scratch;
    }

    /// Puts the particles of `next` in the place of those of body `k`.
    fn renew(&mut self, k: usize, next: &Renewal) {
        let (old, n) = (self.bodies[k].range.clone(), next.descent.len());
        let new = old.start..old.start + n;
        for anchor in &mut self.anchors {
            move_on(anchor, self.time + self.dt, old.start, old.len(), &self.particles.position, next);
        }
        let p = &mut self.particles;
        splice(&mut p.rest, &old, &next.rest);
        splice(&mut p.position, &old, &next.position);
        splice(&mut p.velocity, &old, &next.velocity);
        splice(&mut p.volume, &old, &next.volume);
        splice(&mut p.mass, &old, &next.mass);
        splice(&mut p.damage, &old, &next.damage);
        splice(&mut p.id, &old, &next.id);
        self.acceleration.to_mut().clear(); // known again at the next step
        self.bodies[k].range = new;
        for b in &mut self.bodies[k + 1..] {
            b.range = b.range.start + n - old.len()..b.range.end + n - old.len();
        }
        self.contact.renew(&self.particles, &self.bodies, k, &old, &next.descent);
    }
}

/// Replaces the elements of `old` by others, in memory that grows with room to spare.
fn splice<T: Element>(column: &mut Buffer<T>, old: &std::ops::Range<usize>, with: &[T]) {
    column.to_mut().splice(old.clone(), with.iter().copied());
}

/// Lets an anchor hold at `time` what has become of its particles.
fn move_on(anchor: &mut Anchor, time: f64, first: usize, count: usize, position: &[DVec3], next: &Renewal) {
    const NOT: usize = usize::MAX;
    let end = first + count;
    if anchor.particles.iter().all(|&i| (i as usize) < first) {
        return;
    }
    let mut place = vec![NOT; count];
    for (k, &i) in anchor.particles.iter().enumerate() {
        if (first..end).contains(&(i as usize)) {
            place[i as usize - first] = k;
        }
    }
    let back = DQuat::from_scaled_axis(-anchor.spin * (time - anchor.from));
    let (mut particles, mut start) = (Vec::new(), Vec::new());
    let mut keep = |i: usize, at: DVec3| {
        particles.push(i as u32);
        start.push(at);
    };
    let others = || anchor.particles.iter().zip(&anchor.start[..]).map(|(&i, &at)| (i as usize, at));
    others().filter(|(i, _)| *i < first).for_each(|(i, at)| keep(i, at));
    for (k, descent) in next.descent.iter().enumerate() {
        let from = descent.from as usize;
        if place[from] != NOT {
            let moved = next.position[k] - position[first + from];
            keep(first + k, anchor.start[place[from]] + back * moved);
        }
    }
    others().filter(|(i, _)| *i >= end).for_each(|(i, at)| keep(i - count + next.descent.len(), at));
    (anchor.particles, anchor.start) = (particles.into(), start.into());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_anchor_holds_the_pieces_of_what_it_held() {
        let mut anchor = Anchor {
            particles: vec![1, 2, 7].into(),
            start: vec![DVec3::ZERO, DVec3::X, DVec3::Y].into(),
            spin: DVec3::Z * std::f64::consts::FRAC_PI_2,
            until: f64::INFINITY,
            ..Anchor::default()
        };
        let quarter = |x: DVec3| DVec3::new(-x.y, x.x, x.z);
        let position = [DVec3::ONE, DVec3::ZERO, quarter(DVec3::X), DVec3::ONE];
        let piece = |from, same| Descent { from, same };
        // of the body 1..4: the first stays, the second splits along x, the third, which is not held, stays
        let next = Renewal {
            position: vec![DVec3::ZERO, quarter(DVec3::X * 0.5), quarter(DVec3::X * 1.5), DVec3::ONE],
            descent: vec![piece(0, true), piece(1, false), piece(1, false), piece(2, true)],
            ..Renewal::default()
        };
        move_on(&mut anchor, 1.0, 1, 3, &position, &next);
        assert_eq!(&anchor.particles[..], &[1, 2, 3, 8]);
        assert_eq!((anchor.start[0], anchor.start[3]), (DVec3::ZERO, DVec3::Y));
        for k in [1, 2] {
            assert!(anchor.place(k, 1.0).distance(next.position[k]) < 1e-15, "{}", anchor.place(k, 1.0));
        }
    }
}
