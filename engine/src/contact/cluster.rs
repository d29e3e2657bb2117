//! Bodies that are near each other move as one frame, in which their members use up their slack.
//!
//! Bodies whose boxes are apart are clusters of their own, so a body that falls or two that fly past each other cost nothing.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::{Scene, Still};

/// Slack in mean radii: of every particle, and the most that room for [`STEPS`] of the fastest may add, and of its own.
pub const SLACK: [f64; 3] = [0.2, 0.8, 2.0];
/// Steps that all have room for: of the fastest particle's motion and of its own, as far as that is not too much, and of its
/// own in any case.
pub const STEPS: [f64; 3] = [6.0, 24.0, 6.0];
/// Particles of a body by which its mean motion is judged, at most.
const SAMPLE: usize = 256;

/// A member to be, before members are in order.
#[derive(Clone, Copy, Debug)]
pub struct Seat {
    /// What members are sorted by.
    pub key: u64,
    /// Which particle.
    pub particle: u32,
    /// Its body.
    pub body: u32,
    /// How far it may move before rows are made anew [m].
    pub slack: f32,
}

/// Bodies that are near each other, and how they have moved since the rows were made.
#[derive(Clone, Copy, Debug)]
pub struct Cluster {
    /// Box of the members with their reach, when the rows were made [m].
    low: DVec3,
    high: DVec3,
    /// Mean shift since then [m].
    pub shift: DVec3,
    /// Mean velocity [m/s].
    pub velocity: DVec3,
    /// Members in the means.
    count: f64,
}

const EMPTY: Cluster =
    Cluster { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY, shift: DVec3::ZERO, velocity: DVec3::ZERO, count: 0.0 };

/// Room [m] for the motion of a particle that goes `way` [m] in a step among others of radius `mean` [m].
pub fn own_room(way: f64, mean: f64) -> f64 {
    (STEPS[1] * way).min(SLACK[2] * mean).max(STEPS[2] * way)
}

impl Cluster {
    /// The middle of its box, moved along [m].
    #[inline]
    pub fn middle(&self) -> DVec3 {
        (self.low + self.high) / 2.0 + self.shift
    }
}

/// All clusters.
#[derive(Debug, Default)]
pub struct Clusters {
    /// Cluster of each body.
    of: Vec<u32>,
    all: Vec<Cluster>,
    /// Of each cluster: the longest way of a member in a step relative to the mean [m], the sum of radii [m], members.
    extent: Vec<(f64, f64, f64)>,
}

impl Clusters {
    /// The cluster of a body.
    #[inline]
    pub fn of(&self, body: u32) -> &Cluster {
        &self.all[self.of[body as usize] as usize]
    }

    /// The middle of all boxes [m].
    pub fn middle(&self) -> DVec3 {
        let low = self.all.iter().map(|c| c.low).fold(DVec3::INFINITY, DVec3::min);
        let high = self.all.iter().map(|c| c.high).fold(DVec3::NEG_INFINITY, DVec3::max);
        (low + high) / 2.0
    }

    /// Takes the means of body, shift and velocity of some members.
    pub fn measure(&mut self, motions: impl Iterator<Item = (u32, DVec3, DVec3)>) {
        for c in &mut self.all {
            (c.shift, c.velocity, c.count) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        }
        for (body, shift, velocity) in motions {
            let c = &mut self.all[self.of[body as usize] as usize];
            c.shift += shift;
            c.velocity += velocity;
            c.count += 1.0;
        }
        for c in &mut self.all {
            c.shift /= c.count.max(1.0);
            c.velocity /= c.count.max(1.0);
        }
    }

    /// Makes the box of a body's cluster hold a ball about `x` in its frame.
    pub fn hold(&mut self, body: u32, x: DVec3, reach: f64) {
        let c = &mut self.all[self.of[body as usize] as usize];
        (c.low, c.high) = (c.low.min(x - reach), c.high.max(x + reach));
    }

    /// Whether members of two clusters may touch in this step.
    pub fn meet(&self, dt: f64) -> bool {
        let swept = |c: &Cluster| swept(c, c.shift, dt);
        self.all.iter().enumerate().any(|(k, a)| self.all[..k].iter().any(|b| overlap(swept(a), swept(b))))
    }

    /// Joins bodies whose boxes are, or soon will be, in reach of each other, and gives every member its slack. `seats` are in
    /// order of particles.
    pub fn make(&mut self, scene: &Scene<'_>, still: &Still, dv: &[DVec3], seats: &mut [Seat]) {
        let bodies = scene.bodies.len();
        self.of.clear();
        self.of.extend(0..bodies as u32);
        self.all.clear();
        self.all.resize(bodies, EMPTY);
        let body = |seats: &[Seat], b: usize| -> Range<usize> {
            let end = |b: usize| seats.partition_point(|s| (s.body as usize) < b);
            end(b)..end(b + 1)
        };
        loop {
            let sample =
                sample(seats).map(|k| (seats[k].body, DVec3::ZERO, scene.velocity(seats[k].particle as usize, dv)));
            self.measure(sample);
            self.extent.clear();
            self.extent.resize(bodies, (0.0, 0.0, 0.0));
            for b in 0..bodies {
                let (range, mean) = (body(seats, b), self.of(b as u32).velocity);
                let own = |s: &mut Seat| {
                    let way = (scene.velocity(s.particle as usize, dv) - mean).length() * scene.dt;
                    s.slack = way as f32;
                    (way, still.radius[s.particle as usize])
                };
                let all = seats[range.clone()].par_iter_mut().with_min_len(4096).map(own);
                let (way, radius) = all.reduce(|| (0.0, 0.0), |a, b| (f64::max(a.0, b.0), a.1 + b.1));
                let e = &mut self.extent[self.of[b] as usize];
                *e = (e.0.max(way), e.1 + radius, e.2 + range.len() as f64);
            }
            self.all.iter_mut().for_each(|c| (c.low, c.high) = (EMPTY.low, EMPTY.high));
            for b in 0..bodies {
                let (fastest, radius, count) = self.extent[self.of[b] as usize];
                let mean = radius / f64::max(count, 1.0);
                let reach = |s: &mut Seat| {
                    let (x, radius) =
                        (scene.particles.position[s.particle as usize], still.radius[s.particle as usize]);
                    // who is slow now may be hit by a wave: the same room for all, but more for the fast
                    let room = (STEPS[0] * fastest).min(SLACK[1] * mean).max(own_room(f64::from(s.slack), mean));
                    s.slack = (SLACK[0] * mean + room) as f32;
                    let reach = DVec3::splat(radius + f64::from(s.slack));
                    (x - reach, x + reach)
                };
                let range = body(seats, b);
                let all = seats[range].par_iter_mut().with_min_len(4096).map(reach);
                let (low, high) = all.reduce(|| (EMPTY.low, EMPTY.high), |a, b| (a.0.min(b.0), a.1.max(b.1)));
                let c = &mut self.all[self.of[b] as usize];
                (c.low, c.high) = (c.low.min(low), c.high.max(high));
            }
            if !self.join(STEPS[0] * scene.dt) {
                return;
            }
        }
    }

    /// Joins clusters that may touch within `time` [s]; whether there were any.
    fn join(&mut self, time: f64) -> bool {
        let mut joined = false;
        for a in 0..self.all.len() {
            for b in 0..a {
                let (to, from) = (self.of[b], self.of[a]);
                let near = |a: &Cluster, b: &Cluster| overlap(swept(a, DVec3::ZERO, time), swept(b, DVec3::ZERO, time));
                if to != from && near(&self.all[a], &self.all[b]) {
                    self.of.iter_mut().filter(|c| **c == from).for_each(|c| *c = to);
                    joined = true;
                }
            }
        }
        joined
    }
}

/// Some members of every body, by which its mean motion is judged.
pub fn sample(seats: &[Seat]) -> impl Iterator<Item = usize> + '_ {
    let bodies = seats.chunk_by(|a, b| a.body == b.body);
    bodies
        .scan(0, |start, body| {
            let from = std::mem::replace(start, *start + body.len());
            Some((from..*start).step_by(body.len().div_ceil(SAMPLE)))
        })
        .flatten()
}

/// The box of a cluster that has moved by `shift` [m], over the next `time` [s].
fn swept(c: &Cluster, shift: DVec3, time: f64) -> (DVec3, DVec3) {
    let end = shift + c.velocity * time;
    (c.low + shift.min(end), c.high + shift.max(end))
}

/// Whether two boxes overlap; empty ones overlap nothing.
fn overlap((a_low, a_high): (DVec3, DVec3), (b_low, b_high): (DVec3, DVec3)) -> bool {
    a_low.cmple(b_high).all() && b_low.cmple(a_high).all()
}
