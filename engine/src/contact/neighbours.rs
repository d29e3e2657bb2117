//! Which particles may come to touch: rows of neighbours with some slack, made anew only when something has moved too far.
//!
//! ```text
//! members  the particles that can touch anything: near a surface, damaged, or bonded to a damaged one;
//!          in order of the cells that they were in when the rows were made
//! rows     for each member all others within reach_i + reach_j that no bond holds;  reach = radius + slack
//! fresh    pairs since then: of broken bonds, and of members that have used up their slack and got a new place
//! ```
//! The rows hold more than what touches, and what they hold too much adds nothing, so results do not depend on when they
//! were made: nothing of this needs to survive a restart. They serve while every member has moved, relative to the mean
//! motion of its cluster, and will move in this step, by no more than its slack.
//!
//! Intact bonds are left out, so the rows of an undamaged body are nearly empty; a bond that breaks adds its pair. A
//! particle that is damaged for the first time is a member already if it was bonded to a damaged one, else all rows are
//! made anew.
//!
//! Measured on cubes of 64 000 particles that fall at 8 % of their speed of sound, one thread, user cycles, before the passes
//! over bonds lost a third of their instructions: contact adds 14 % to a step while the cube is whole (a fifth of it near a
//! surface) and 60 % when it is shattered, of which half are rows, made anew every seventh step or so. Rows that were made
//! in order of particles, with a search by every member and of its bonds for each neighbour, took twice that; without
//! new places for strays they were made every third step, for the few that something had just hit. More slack makes rows
//! rarer and longer, and gained nothing. A member costs 1 µs: a third marking bonds, a third collecting candidates, a third
//! measuring them. What has not been tried: frames of fragments instead of whole bodies.

use std::sync::Mutex;

use glam::DVec3;
use rayon::prelude::*;

use super::cluster::{Clusters, SLACK, STEPS, Seat, sample};
use super::grid::Grid;
use super::search::{MARGIN, Members, Scratch, touch};
use super::{Scene, Still};
use crate::particles::Particles;
use crate::world::Body;

/// Rows of one task.
const BLOCK: usize = 256;
/// Neighbours per row that room is made for at once, on the mean of a block; address space only, until it is used.
const ROOM: usize = 64;
/// Where one particle in so many is damaged, all are wanted: more will follow, and each time rows would be made anew.
const MANY: usize = 8;
/// Up to one member in so many may get a new place; beyond, all rows are made anew.
const STRAYS: usize = 64;
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
    /// Distance at which they touch [m]: the sum of their radii, or their distance at rest if that is less.
    pub d: f32,
    /// How far they were from touching when the rows were made [m].
    pub gap: f32,
}

/// Rows of [`BLOCK`] members, one after the other.
#[derive(Debug, Default)]
pub struct Block {
    /// Where each row ends.
    pub ends: Vec<u32>,
    /// The rows as they were made.
    pub entries: Vec<Entry>,
    /// What has been added since, with the row counted from the block's first; in order of rows.
    pub fresh: Vec<(u32, Entry)>,
}

/// Members, rows, and what tells when to make them anew.
#[derive(Debug, Default)]
pub struct Neighbours {
    /// Particle of each member.
    pub members: Vec<u32>,
    /// Member of each particle, or [`NONE`].
    pub rank: Vec<u32>,
    /// The members at the present step.
    pub records: Vec<Record>,
    /// Whether a member can touch anything now: near a surface or damaged.
    pub exposed: Vec<bool>,
    /// Body of each member.
    body: Vec<u32>,
    /// Members by which the motion of their clusters is judged.
    sample: Vec<u32>,
    clusters: Clusters,
    /// Where members were when the rows were made [m].
    reference: Vec<DVec3>,
    slack: Vec<f32>,
    /// Radius and slack [m].
    reach: Vec<f32>,
    /// How much of the slack is used up at the end of this step [m].
    moved: Vec<f32>,
    /// Members that have got a new place since the rows were made, and whether each is one.
    strays: Vec<u32>,
    strayed: Vec<bool>,
    blocks: Vec<Block>,
    /// How many particles there is room for.
    room: usize,
    grid: Grid,
    seats: Vec<Seat>,
    /// One for each thread.
    scratch: Vec<Mutex<Scratch>>,
    /// Which particles shall be members when the rows are made next; only grows.
    wanted: Vec<bool>,
    /// Which damaged particles have had their neighbours added to `wanted`.
    spread: Vec<bool>,
    /// How many there are of those.
    damaged: usize,
    /// Whether the rows miss something that has broken.
    uncovered: bool,
    /// How often the rows were made.
    pub builds: u64,
}

impl Neighbours {
    /// Brings records and rows up to date.
    pub fn update(&mut self, scene: &Scene<'_>, still: &Still, dv: &[DVec3]) {
        if self.know_damage(scene, still) {
            let motion = self.sample.iter().map(|&k| {
                let (k, i) = (k as usize, self.members[k as usize] as usize);
                (self.body[k], scene.particles.position[i] - self.reference[k], scene.velocity(i, dv))
            });
            self.clusters.measure(motion);
            self.pose(scene, still, dv);
            if self.reseat(scene, still) && !self.clusters.meet(scene.dt) {
                let unsorted = |b: &&mut Block| !b.fresh.is_sorted_by_key(|f| f.0);
                self.blocks.iter_mut().filter(unsorted).for_each(|b| b.fresh.sort_unstable_by_key(|f| f.0));
                return;
            }
        }
        self.build(scene, still, dv);
        self.uncovered = false;
        self.builds += 1;
    }

    /// Neighbours of each member of a block: as the rows were made, and fresh ones.
    pub fn rows(&self, block: usize, mut each: impl FnMut(usize, &[Entry], &[(u32, Entry)])) {
        let Block { ends, entries, fresh } = &self.blocks[block];
        let (mut start, mut from) = (0, 0);
        for (k, &end) in ends.iter().enumerate() {
            let to = from + fresh[from..].iter().take_while(|f| f.0 as usize == k).count();
            each(block * BLOCK + k, &entries[start..end as usize], &fresh[from..to]);
            (start, from) = (end as usize, to);
        }
    }

    /// Whether the member `k` and a neighbour may touch in this step; that costs less than to look at it.
    #[inline(always)]
    pub fn may_touch(&self, k: usize, e: &Entry) -> bool {
        e.gap <= self.moved[k] + self.moved[e.other as usize]
    }

    /// Members of a block.
    pub const BLOCK: usize = BLOCK;

    /// Wants what the step before has damaged, with its neighbours, and adds the pairs that no bond holds any more.
    pub fn note_cuts(&mut self, particles: &Particles, still: &Still, bodies: &[Body]) {
        if self.rank.is_empty() {
            return;
        }
        for b in bodies.iter().filter(|b| b.material.bonds().is_some()) {
            for link in &b.cuts {
                self.want(b, link.i as usize);
                self.want(b, link.j as usize);
                self.add(particles, still, b.range.start + link.i as usize, b.range.start + link.j as usize);
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
            self.damaged += 1;
            if self.damaged == self.spread.len() / MANY + 1 {
                self.wanted.fill(true);
            }
        }
        self.uncovered |= self.rank.get(first + k).is_none_or(|&rank| rank == NONE);
    }

    /// Adds two particles of one body to each other's rows, if they are in reach.
    fn add(&mut self, particles: &Particles, still: &Still, i: usize, j: usize) {
        if self.uncovered {
            return;
        }
        let (a, b) = (self.rank[i] as usize, self.rank[j] as usize);
        let apart = self.reference[a].distance(self.reference[b]);
        if apart > f64::from(self.reach[a] + self.reach[b]) * MARGIN {
            return;
        }
        let d = touch(particles, still, i, j);
        let gap = (apart / MARGIN) as f32 - d;
        self.uncovered |= !push(&mut self.blocks, a, b, d, gap);
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
        self.damaged = 0;
        for b in scene.bodies {
            let damage = &scene.particles.damage[b.range.clone()];
            (0..damage.len()).filter(|&k| damage[k] > 0.0).for_each(|k| self.want(b, k));
        }
        false
    }

    /// Fills the records, and finds how far every member goes.
    fn pose(&mut self, scene: &Scene<'_>, still: &Still, dv: &[DVec3]) {
        let Self { members, records, exposed, body, clusters, reference, moved, .. } = self;
        let fill = |(k, ((record, exposed), moved)): (usize, ((&mut Record, &mut bool), &mut f32))| {
            let (c, i) = (clusters.of(body[k]), members[k] as usize);
            let (x, u) = (scene.particles.position[i], scene.velocity(i, dv));
            *record = still.record(i, x, u, scene.particles.mass[i]);
            *exposed = still.surface[i] || scene.particles.damage[i] > 0.0;
            let way = (x - reference[k] - c.shift).length() + scene.dt * (u - c.velocity).length();
            *moved = (way * MARGIN) as f32;
        };
        records.par_iter_mut().zip(exposed).zip(moved).enumerate().with_min_len(1024).for_each(fill);
    }

    /// Finds new neighbours for the members that have used up their slack, if they are few; else, or if there is no room, the
    /// rows are of no use any more.
    fn reseat(&mut self, scene: &Scene<'_>, still: &Still) -> bool {
        let most = self.members.len() / STRAYS;
        for k in 0..self.members.len() {
            if self.moved[k] <= self.slack[k] {
                continue;
            }
            if !self.strayed[k] {
                self.strayed[k] = true;
                self.strays.push(k as u32);
            }
            if self.strays.len() > most || self.uncovered {
                return false;
            }
            self.reseat_one(scene, still, k);
        }
        !self.uncovered
    }

    fn reseat_one(&mut self, scene: &Scene<'_>, still: &Still, k: usize) {
        let (i, body, c) = (self.members[k] as usize, self.body[k], *self.clusters.of(self.body[k]));
        let (x, radius) = (self.records[k].x - c.shift, still.radius[i]);
        let own = scene.dt * (self.records[k].u - c.velocity).length();
        let slack = ((SLACK.0 + SLACK.1) * radius + STEPS.1 * own) as f32;
        let reach = radius as f32 + slack;
        (self.reference[k], self.slack[k], self.reach[k]) = (x, slack, reach);
        self.moved[k] = (own * MARGIN) as f32;
        self.clusters.hold(body, x, f64::from(reach));
        let b = &scene.bodies[body as usize];
        let Self { reference, reach, members, strays, strayed, blocks, grid, body: of, uncovered, .. } = self;
        let scratch = self.scratch[0].get_mut().unwrap_or_else(|poisoned| poisoned.into_inner());
        scratch.see(b, i);
        let mut meet = |j: usize| {
            let (other, apart) = (members[j] as usize, reference[j].distance(x));
            let same = of[j] == body;
            let held = same && scratch.holds(b, still, i, other);
            if j == k || held || apart > f64::from(reach[j] + reach[k]) * MARGIN {
                return;
            }
            let d = match same {
                true => touch(scene.particles, still, i, other),
                false => still.radius[i] as f32 + still.radius[other] as f32,
            };
            let gap = (apart / MARGIN) as f32 - d;
            *uncovered |= !push(blocks, k, j, d, gap);
        };
        grid.around(x, f64::from(reach[k]), |balls| balls.filter(|&j| !strayed[j]).for_each(&mut meet));
        strays.iter().for_each(|&j| meet(j as usize));
    }

    fn build(&mut self, scene: &Scene<'_>, still: &Still, dv: &[DVec3]) {
        self.make_room(scene.particles.len());
        self.choose_members(scene, still, dv);
        let n = self.members.len();
        self.records.resize(n, Record::default());
        self.exposed.resize(n, false);
        self.moved.resize(n, 0.0);
        self.strays.clear();
        self.strayed.clear();
        self.strayed.resize(n, false);
        self.pose(scene, still, dv);
        let Self { members, body, reference, reach, blocks, grid, scratch, .. } = self;
        let members = Members { members, body, reference, reach };
        grid.build(n, |k| (members.reference[k], f64::from(members.reach[k])));
        blocks[..n.div_ceil(BLOCK)].par_iter_mut().enumerate().for_each(|(block, b)| {
            let thread = rayon::current_thread_index().unwrap_or(0);
            // never contended: a thread makes one block at a time
            let mut scratch = scratch[thread].lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            scratch.rows(scene, still, &members, grid, block * BLOCK..((block + 1) * BLOCK).min(n), b);
        });
    }

    /// Room for all `n` particles to become members, so that no later step allocates.
    fn make_room(&mut self, n: usize) {
        let threads = rayon::current_num_threads();
        if self.scratch.len() < threads {
            self.scratch.resize_with(threads, || Mutex::new(Scratch::new(n.max(self.room))));
        }
        if self.room >= n {
            return;
        }
        // particles that split may come to be more
        let n = if self.room == 0 { n } else { n + n / 2 };
        self.room = n;
        self.scratch.iter_mut().for_each(|s| *s = Mutex::new(Scratch::new(n)));
        self.members.reserve(n);
        self.rank.reserve(n);
        self.records.reserve(n);
        self.exposed.reserve(n);
        self.body.reserve(n);
        self.reference.reserve(n);
        self.slack.reserve(n);
        self.moved.reserve(n);
        self.strays.reserve(n);
        self.strayed.reserve(n);
        self.reach.reserve(n);
        self.seats.reserve(n);
        self.sample.reserve(n);
        self.grid.reserve(n);
        self.blocks.resize_with(n.div_ceil(BLOCK), || Block {
            ends: Vec::with_capacity(BLOCK),
            entries: Vec::with_capacity(BLOCK * ROOM),
            fresh: Vec::with_capacity(BLOCK * ROOM),
        });
    }

    /// Members in order of their cells, with all that is known of them.
    fn choose_members(&mut self, scene: &Scene<'_>, still: &Still, dv: &[DVec3]) {
        let Self { seats, wanted, clusters, grid, rank, sample: judged, .. } = self;
        seats.clear();
        for (body, b) in scene.bodies.iter().enumerate() {
            let members = b.range.clone().filter(|&i| wanted[i]);
            seats.extend(members.map(|i| Seat { key: 0, particle: i as u32, body: body as u32, slack: 0.0 }));
        }
        clusters.make(scene, still, dv, seats);
        judged.clear();
        judged.extend(sample(seats).map(|k| seats[k].particle));
        let reach = |s: &Seat| (still.radius[s.particle as usize] + f64::from(s.slack)) as f32;
        let sum: f64 = seats.iter().map(|s| f64::from(reach(s))).sum();
        grid.fit(sum / seats.len().max(1) as f64);
        let position = &scene.particles.position;
        seats.par_iter_mut().with_min_len(1024).for_each(|s| {
            s.key = grid.key(position[s.particle as usize], f64::from(reach(s)));
        });
        seats.par_sort_unstable_by_key(|s| (s.key, s.particle));
        rank.clear();
        rank.resize(scene.particles.len(), NONE);
        seats.iter().enumerate().for_each(|(k, s)| rank[s.particle as usize] = k as u32);
        judged.iter_mut().for_each(|k| *k = rank[*k as usize]);
        fill(&mut self.members, seats, |s| s.particle);
        fill(&mut self.body, seats, |s| s.body);
        fill(&mut self.slack, seats, |s| s.slack);
        fill(&mut self.reach, seats, reach);
        fill(&mut self.reference, seats, |s| position[s.particle as usize]);
    }
}

/// Adds two members to each other's rows; false where there is no room.
fn push(blocks: &mut [Block], a: usize, b: usize, d: f32, gap: f32) -> bool {
    [(a, b), (b, a)].into_iter().all(|(row, other)| {
        let fresh = &mut blocks[row / BLOCK].fresh;
        let room = fresh.len() < fresh.capacity();
        if room {
            fresh.push(((row % BLOCK) as u32, Entry { other: other as u32, d, gap }));
        }
        room
    })
}

fn fill<T>(column: &mut Vec<T>, seats: &[Seat], of: impl Fn(&Seat) -> T) {
    column.clear();
    column.extend(seats.iter().map(of));
}
