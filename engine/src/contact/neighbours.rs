//! Which particles may come to touch: rows of neighbours with some slack, made anew only when something has moved too far.
//!
//! ```text
//! members  the particles that can touch anything: near a surface, damaged, or bonded to a damaged one
//! rows     for each member all others within reach_i + reach_j, by index;  reach = radius + slack
//! ```
//! The rows hold more than what touches, and what they hold too much adds nothing, so results do not depend on when they
//! were made: nothing of this needs to survive a restart. They serve while every member has moved, relative to the mean
//! motion of its cluster, and will move in this step, by no more than its slack. Bodies whose boxes are apart are clusters
//! of their own, so a body that falls or two that fly past each other cost nothing.
//!
//! Bonded pairs are in the rows with their bond, so a bond that breaks needs no new rows; a particle that is damaged for
//! the first time is a member already if it was bonded to a damaged one, else all rows are made anew.

use glam::DVec3;
use rayon::prelude::*;

use super::grid::Grid;
use super::{Scene, Still};
use crate::bonds::CHUNK;
use crate::world::Body;

/// Slack in mean radii: of every particle, and the most that room for [`STEPS`] of the fastest may add.
const SLACK: (f64, f64) = (0.2, 0.6);
/// Steps of the fastest particle's motion that all have room for, as far as that is not too much; and of its own.
/// A single particle without room would have all rows made anew.
const STEPS: (f64, f64) = (6.0, 4.0);
/// Rows of one task.
const BLOCK: usize = 256;
/// Neighbours per row that room is made for at once, on the mean of a block; address space only, until it is used.
const ROOM: usize = 32;
/// Particles of a body by which its mean motion is judged, at most.
const SAMPLE: usize = 256;
/// No member.
pub const NONE: u32 = u32::MAX;

/// A member as its neighbours see it: one cache line.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct Record {
    /// Where it is [m].
    pub x: DVec3,
    /// Velocity at the end of the step if nothing touches [m/s].
    pub u: DVec3,
    /// One over its mass [1/kg], 0 while it is held.
    pub inv_mass: f64,
    /// Radius [m].
    pub radius: f32,
    /// Modulus of its material [Pa].
    pub modulus: f32,
}

/// A neighbour in a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Which member.
    pub other: u32,
    /// The slot of the bond between them, [`NONE`] if there never was one.
    pub slot: u32,
    /// Distance at which they touch [m]: the sum of their radii, or their distance at rest if that is less.
    pub d: f32,
}

/// Rows of [`BLOCK`] members, one after the other.
#[derive(Debug, Default)]
struct Block {
    ends: Vec<u32>,
    entries: Vec<Entry>,
}

/// Bodies that are near each other, and how they have moved since the rows were made.
#[derive(Clone, Copy, Debug)]
struct Cluster {
    /// Box of the members with their reach, when the rows were made [m].
    low: DVec3,
    high: DVec3,
    /// Mean shift since then [m], and mean velocity [m/s].
    shift: DVec3,
    velocity: DVec3,
    /// Members in the means.
    count: f64,
    /// Longest way of a member in a step relative to the mean [m], when the rows were made.
    fastest: f64,
    /// Sum of the members' radii [m], likewise.
    radius: f64,
}

/// Members, rows, and what tells when to make them anew.
#[derive(Debug, Default)]
pub struct Neighbours {
    /// Particle of each member, ascending.
    pub members: Vec<u32>,
    /// Member of each particle, or [`NONE`].
    pub rank: Vec<u32>,
    /// The members at the present step.
    pub records: Vec<Record>,
    /// Whether a member can touch anything now: near a surface or damaged.
    pub exposed: Vec<bool>,
    /// First member of each body, and the end.
    first: Vec<u32>,
    /// Cluster of each body.
    cluster: Vec<u32>,
    clusters: Vec<Cluster>,
    /// Where members were when the rows were made [m].
    reference: Vec<DVec3>,
    slack: Vec<f32>,
    blocks: Vec<Block>,
    grid: Grid,
    /// Which particles shall be members when the rows are made next; only grows.
    wanted: Vec<bool>,
    /// Which damaged particles have had their neighbours added to `wanted`.
    spread: Vec<bool>,
    /// Whether something is damaged that is no member yet.
    uncovered: bool,
    /// How often the rows were made.
    pub builds: u64,
}

impl Neighbours {
    /// Brings records and rows up to date.
    pub fn update(&mut self, scene: &Scene<'_>, still: &Still, dv: &[DVec3]) {
        if self.know_damage(scene, still) {
            self.measure(scene, dv);
            if self.pose(scene, still, dv) && !self.clusters_meet(scene.dt) {
                return;
            }
        }
        self.build(scene, still, dv);
        self.uncovered = false;
        self.builds += 1;
    }

    /// Body and neighbours of each member of `rows`, in order.
    pub fn rows(&self, block: usize, mut each: impl FnMut(usize, usize, &[Entry])) {
        let first = block * BLOCK;
        let mut body = self.first.partition_point(|&f| f as usize <= first) - 1;
        let mut start = 0;
        for (k, &end) in self.blocks[block].ends.iter().enumerate() {
            while self.first[body + 1] as usize <= first + k {
                body += 1;
            }
            each(first + k, body, &self.blocks[block].entries[start..end as usize]);
            start = end as usize;
        }
    }

    /// Members of a block.
    pub const BLOCK: usize = BLOCK;

    /// Wants what the step before has damaged, with its neighbours.
    pub fn note_cuts(&mut self, bodies: &[Body]) {
        if !self.rank.is_empty() {
            for b in bodies {
                b.cuts.iter().flat_map(|l| [l.i, l.j]).for_each(|k| self.want(b, k as usize));
            }
        }
    }

    /// Wants the damaged particle `k` of a body and what it is bonded to.
    fn want(&mut self, b: &Body, k: usize) {
        let (Some(bonds), first) = (b.material.bonds(), b.range.start) else { return };
        if !self.spread[first + k] {
            self.spread[first + k] = true;
            self.wanted[first + k] = true;
            bonds.slots(k).for_each(|slot| self.wanted[first + bonds.neighbours[slot] as usize] = true);
        }
        self.uncovered |= self.rank.get(first + k).is_none_or(|&rank| rank == NONE);
    }

    /// Whether the rows have all of the damaged; finds those anew where nothing is known.
    fn know_damage(&mut self, scene: &Scene<'_>, still: &Still) -> bool {
        if self.rank.len() == scene.particles.len() {
            return !self.uncovered;
        }
        self.rank.clear();
        self.wanted.clear();
        self.wanted.extend(&still.surface);
        self.spread.clear();
        self.spread.resize(self.wanted.len(), false);
        for b in scene.bodies {
            let damage = &scene.particles.damage[b.range.clone()];
            (0..damage.len()).filter(|&k| damage[k] > 0.0).for_each(|k| self.want(b, k));
        }
        false
    }

    /// Members by which the mean motion of body `b` is judged.
    fn sample(&self, b: usize) -> impl Iterator<Item = usize> + use<> {
        let (from, to) = (self.first[b] as usize, self.first[b + 1] as usize);
        (from..to).step_by((to - from).div_ceil(SAMPLE).max(1))
    }

    /// How the clusters have moved.
    fn measure(&mut self, scene: &Scene<'_>, dv: &[DVec3]) {
        for c in &mut self.clusters {
            (c.shift, c.velocity, c.count) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        }
        for b in 0..self.cluster.len() {
            for k in self.sample(b) {
                let i = self.members[k] as usize;
                let c = &mut self.clusters[self.cluster[b] as usize];
                c.shift += scene.particles.position[i] - self.reference[k];
                c.velocity += scene.velocity(i, dv);
                c.count += 1.0;
            }
        }
        for c in &mut self.clusters {
            c.shift /= c.count.max(1.0);
            c.velocity /= c.count.max(1.0);
        }
    }

    /// Fills the records; whether every member is within its slack.
    fn pose(&mut self, scene: &Scene<'_>, still: &Still, dv: &[DVec3]) -> bool {
        let Self { members, records, exposed, first, cluster, clusters, reference, slack, .. } = self;
        let blocks = records.par_chunks_mut(BLOCK).zip(exposed.par_chunks_mut(BLOCK)).enumerate();
        let fits = |(block, (records, exposed)): (usize, (&mut [Record], &mut [bool]))| {
            let start = block * BLOCK;
            let mut body = first.partition_point(|&f| f as usize <= start) - 1;
            let mut fits = true;
            for (l, (record, exposed)) in records.iter_mut().zip(exposed).enumerate() {
                let k = start + l;
                while first[body + 1] as usize <= k {
                    body += 1;
                }
                let c = &clusters[cluster[body] as usize];
                let i = members[k] as usize;
                let (x, u) = (scene.particles.position[i], scene.velocity(i, dv));
                *record = still.record(i, x, u, scene.particles.mass[i]);
                *exposed = still.surface[i] || scene.particles.damage[i] > 0.0;
                let moved = (x - reference[k] - c.shift).length() + scene.dt * (u - c.velocity).length();
                fits &= moved <= f64::from(slack[k]);
            }
            fits
        };
        blocks.map(fits).reduce(|| true, |a, b| a & b)
    }

    /// Whether members of two clusters may touch in this step.
    fn clusters_meet(&self, dt: f64) -> bool {
        let swept = |c: &Cluster| {
            let (a, b) = (c.shift, c.shift + c.velocity * dt);
            (c.low + a.min(b), c.high + a.max(b))
        };
        self.clusters.iter().enumerate().any(|(k, a)| self.clusters[..k].iter().any(|b| overlap(swept(a), swept(b))))
    }

    fn build(&mut self, scene: &Scene<'_>, still: &Still, dv: &[DVec3]) {
        self.make_room(scene.particles.len());
        self.choose_members(scene);
        let n = self.members.len();
        self.records.resize(n, Record::default());
        self.exposed.resize(n, false);
        self.slack.resize(n, 0.0);
        self.reference.clear();
        self.reference.extend(self.members.iter().map(|&i| scene.particles.position[i as usize]));
        self.make_clusters(scene, still, dv);
        self.pose(scene, still, dv);
        let (records, slack) = (&self.records, &self.slack);
        let reach = |k: usize| f64::from(records[k].radius) + f64::from(slack[k]);
        self.grid.build(n, |k| (records[k].x, reach(k)));
        let blocks = n.div_ceil(BLOCK);
        let (grid, first, members) = (&self.grid, &self.first, &self.members);
        self.blocks[..blocks].par_iter_mut().enumerate().for_each(|(block, Block { ends, entries })| {
            ends.clear();
            entries.clear();
            for k in block * BLOCK..((block + 1) * BLOCK).min(n) {
                let body = first.partition_point(|&f| f as usize <= k) - 1;
                let (own, bodies) = (&records[k], &scene.bodies[body]);
                let start = entries.len();
                grid.near(own.x, reach(k), |j| {
                    let other = &records[j as usize];
                    let near = reach(k) + reach(j as usize);
                    if j as usize == k || other.x.distance_squared(own.x) > near * near {
                        return;
                    }
                    let (mut d, mut slot) = (own.radius + other.radius, NONE);
                    if (first[body]..first[body + 1]).contains(&j) {
                        let Some(bonds) = bodies.material.bonds() else { return };
                        let (a, b) = (members[k] as usize, members[j as usize] as usize);
                        let rest = scene.particles.rest[a].distance(scene.particles.rest[b]);
                        // rounded down, so that nothing pushes at rest
                        d = d.min(rest * (1.0 - 1e-6));
                        if f64::from(rest) <= bodies.horizon * 1.001 {
                            let (i, j) = (a - bodies.range.start, (b - bodies.range.start) as u32);
                            let start = bonds.chunks(i).start * CHUNK;
                            let row = &bonds.neighbours[start..start + bonds.family[i] as usize];
                            let place = match still.sorted[body] {
                                true => row.binary_search(&j).ok(),
                                false => row.iter().position(|&other| other == j),
                            };
                            slot = place.map_or(NONE, |p| (start + p) as u32);
                        }
                    }
                    entries.push(Entry { other: j, slot, d });
                });
                entries[start..].sort_unstable_by_key(|e| e.other);
                ends.push(entries.len() as u32);
            }
        });
    }

    /// Room for all `n` particles to become members, so that no later step allocates.
    fn make_room(&mut self, n: usize) {
        if self.blocks.len() >= n.div_ceil(BLOCK) {
            return;
        }
        self.members.reserve(n);
        self.rank.reserve(n);
        self.records.reserve(n);
        self.exposed.reserve(n);
        self.reference.reserve(n);
        self.slack.reserve(n);
        self.grid.reserve(n);
        self.blocks.resize_with(n.div_ceil(BLOCK), || Block {
            ends: Vec::with_capacity(BLOCK),
            entries: Vec::with_capacity(BLOCK * ROOM),
        });
    }

    fn choose_members(&mut self, scene: &Scene<'_>) {
        self.members.clear();
        self.first.clear();
        self.rank.clear();
        self.rank.resize(scene.particles.len(), NONE);
        for b in scene.bodies {
            self.first.push(self.members.len() as u32);
            for i in b.range.clone().filter(|&i| self.wanted[i]) {
                self.rank[i] = self.members.len() as u32;
                self.members.push(i as u32);
            }
        }
        self.first.push(self.members.len() as u32);
    }

    /// Joins bodies whose boxes are, or soon will be, in reach of each other, and gives every member its slack.
    fn make_clusters(&mut self, scene: &Scene<'_>, still: &Still, dv: &[DVec3]) {
        let bodies = scene.bodies.len();
        self.cluster.clear();
        self.cluster.extend(0..bodies as u32);
        self.clusters.clear();
        let empty = Cluster {
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
            shift: DVec3::ZERO,
            velocity: DVec3::ZERO,
            count: 0.0,
            fastest: 0.0,
            radius: 0.0,
        };
        self.clusters.resize(bodies, empty);
        loop {
            self.measure(scene, dv);
            self.clusters.iter_mut().for_each(|c| *c = Cluster { shift: c.shift, velocity: c.velocity, ..empty });
            for b in 0..bodies {
                let c = &mut self.clusters[self.cluster[b] as usize];
                for k in self.first[b] as usize..self.first[b + 1] as usize {
                    let own = (scene.velocity(self.members[k] as usize, dv) - c.velocity).length() * scene.dt;
                    self.slack[k] = own as f32;
                    c.fastest = c.fastest.max(own);
                    c.radius += still.radius[self.members[k] as usize];
                    c.count += 1.0;
                }
            }
            for b in 0..bodies {
                let c = &mut self.clusters[self.cluster[b] as usize];
                for k in self.first[b] as usize..self.first[b + 1] as usize {
                    let radius = still.radius[self.members[k] as usize];
                    // who is slow now may be hit by a wave: the same room for all, but more for the fast
                    let mean = c.radius / c.count;
                    let room = (STEPS.0 * c.fastest).min(SLACK.1 * mean).max(STEPS.1 * f64::from(self.slack[k]));
                    self.slack[k] = (SLACK.0 * mean + room) as f32;
                    let reach = DVec3::splat(radius + f64::from(self.slack[k]));
                    c.low = c.low.min(self.reference[k] - reach);
                    c.high = c.high.max(self.reference[k] + reach);
                }
            }
            let swept = |c: &Cluster| {
                let way = c.velocity * (STEPS.0 * scene.dt);
                (c.low + way.min(DVec3::ZERO), c.high + way.max(DVec3::ZERO))
            };
            let near = |a: usize, b: usize| overlap(swept(&self.clusters[a]), swept(&self.clusters[b]));
            let Some((a, b)) = (0..bodies).flat_map(|a| (0..a).map(move |b| (a, b))).find(|&(a, b)| near(a, b)) else {
                return;
            };
            self.cluster.iter_mut().filter(|c| **c == a as u32).for_each(|c| *c = b as u32);
        }
    }
}

/// Whether two boxes overlap; empty ones overlap nothing.
fn overlap((a_low, a_high): (DVec3, DVec3), (b_low, b_high): (DVec3, DVec3)) -> bool {
    a_low.cmple(b_high).all() && b_low.cmple(a_high).all()
}
