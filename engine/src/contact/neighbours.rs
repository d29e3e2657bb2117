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
//! In shards most rows are empty: of the vase on the ground (52 598 particles, a fifth of its bonds broken) 26 % have
//! neighbours, 0.8 on the mean, while 17 are in reach of each particle and bonded to it. So a step is what every member
//! costs though it touches nothing, and making rows: there one thread took 11.1 ms a step of 29 before, 4.9 ms of 21 now.
//! What brought that: rows that serve for 20 steps instead of 8, since fast dust has more room (it alone used up its
//! slack); wider cells (fewer of them to ask for); records for members with neighbours only; columns as slices outside
//! the loops (a `Buffer` asks at each access what it is); one look at each pair, in f32, before its records are read.
//! Still more room made rows of dust so long that it cost twice as much. With rows made in order of particles, or
//! without new places for strays, it took twice to three times as much.

use std::sync::Mutex;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::cluster::{Clusters, SLACK, Seat, own_room, sample};
use super::grid::Grid;
use super::search::{MARGIN, Members, Scratch, touch};
use super::{Scene, Still};
use crate::particles::Particles;
use crate::world::Body;

/// Rows of one task.
const BLOCK: usize = 256;
/// Neighbours per row that room is made for at once, on the mean of a block; address space only, until it is used.
const ROOM: usize = 128;
/// Where one particle in so many is damaged, all are wanted: more will follow, and each time rows would be made anew.
const MANY: usize = 8;
/// Up to one member in so many may get a new place; beyond, all rows are made anew.
const STRAYS: usize = 64;
/// What `may_touch` allows for its rounding of distances, and of places [sizes of the cluster].
const NEAR: f32 = 1.0 + 1e-5;
const ROUNDED: f64 = 2.5e-7;
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
}

/// A member as most that never touch it need it: from the middle of its cluster [m], and how far it goes in this step beside
/// the mean motion [m]; that is not a number for who can touch nothing.
type Near = [f32; 4];

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
    near: Vec<Near>,
    /// Whether a member has any neighbours; who has none needs no record.
    busy: Vec<bool>,
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
    /// Places as [`Members`] has them.
    spots: Vec<[f32; 4]>,
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
            let serve = !self.has_strays(scene, dv) || self.reseat(scene, still, dv);
            if serve && !self.clusters.meet(scene.dt) {
                let unsorted = |b: &&mut Block| !b.fresh.is_sorted_by_key(|f| f.0);
                self.blocks.iter_mut().filter(unsorted).for_each(|b| b.fresh.sort_unstable_by_key(|f| f.0));
                return self.pose(scene, still, dv);
            }
        }
        self.build(scene, still, dv);
        self.pose(scene, still, dv);
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

    /// Whether the member `k` and a neighbour may touch in this step; that costs less than to look at their records.
    #[inline(always)]
    pub fn may_touch(&self, k: usize, e: &Entry) -> bool {
        let (a, b) = (&self.near[k], &self.near[e.other as usize]);
        let (x, y, z, reach) = (b[0] - a[0], b[1] - a[1], b[2] - a[2], a[3] + b[3] + e.d);
        x * x + y * y + z * z <= reach * reach * NEAR
    }

    /// Members of a block.
    pub const BLOCK: usize = BLOCK;

    /// Wants what the step before has damaged, with its neighbours, and adds the pairs that no bond holds any more.
    pub fn note_cuts(&mut self, particles: &Particles, still: &Still, bodies: &[Body]) {
        if self.rank.is_empty() {
            return;
        }
        let rest = &particles.rest[..];
        for b in bodies.iter().filter(|b| b.material.bonds().is_some()) {
            for link in &b.cuts {
                self.want(b, link.i as usize);
                self.want(b, link.j as usize);
                self.add(rest, still, b.range.start + link.i as usize, b.range.start + link.j as usize);
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
    fn add(&mut self, rest: &[Vec3], still: &Still, i: usize, j: usize) {
        if self.uncovered {
            return;
        }
        let (a, b) = (self.rank[i] as usize, self.rank[j] as usize);
        let apart = self.reference[a].distance(self.reference[b]);
        if apart > f64::from(self.reach[a] + self.reach[b]) * MARGIN {
            return;
        }
        let d = touch(rest, still, i, j);
        self.uncovered |= !push(&mut self.blocks, &mut self.busy, a, b, d);
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
            let damage = &scene.damage[b.range.clone()];
            (0..damage.len()).filter(|&k| damage[k] > 0.0).for_each(|k| self.want(b, k));
        }
        false
    }

    /// Finds how far every member goes, and whether one has used up its slack.
    fn has_strays(&mut self, scene: &Scene<'_>, dv: &[DVec3]) -> bool {
        let Self { members, body, clusters, reference, slack, moved, .. } = self;
        let rows = moved.par_chunks_mut(BLOCK).zip(members.par_chunks(BLOCK)).zip(body.par_chunks(BLOCK));
        let rows = rows.zip(reference.par_chunks(BLOCK)).zip(slack.par_chunks(BLOCK)).with_min_len(4);
        let strays = rows.map(|((((moved, members), body), reference), slack)| {
            let mut any = false;
            for k in 0..moved.len() {
                let (c, i) = (clusters.of(body[k]), members[k] as usize);
                let gone = (scene.particles.position[i] - reference[k] - c.shift).length();
                let way = gone + scene.dt * (scene.velocity(i, dv) - c.velocity).length();
                moved[k] = (way * MARGIN) as f32;
                any |= moved[k] > slack[k];
            }
            any
        });
        strays.reduce(|| false, |a, b| a | b)
    }

    /// Fills the records of the members that have neighbours.
    fn pose(&mut self, scene: &Scene<'_>, still: &Still, dv: &[DVec3]) {
        let Self { members, records, near, busy, body, clusters, .. } = self;
        let fill = |(k, (record, near)): (usize, (&mut Record, &mut Near))| {
            if !busy[k] {
                return;
            }
            let (c, i) = (clusters.of(body[k]), members[k] as usize);
            let (x, u) = (scene.particles.position[i], scene.velocity(i, dv));
            *record = still.record(i, x, u, scene.particles.mass[i]);
            let (place, way) = (x - c.middle(), scene.dt * (u - c.velocity).length());
            let exposed = still.surface[i] || scene.damage[i] > 0.0;
            let reach = if exposed { way + ROUNDED * place.abs().max_element() } else { f64::NAN };
            *near = place.extend(reach).as_vec4().to_array();
        };
        records.par_iter_mut().zip(near).enumerate().with_min_len(1024).for_each(fill);
    }

    /// Finds new neighbours for the members that have used up their slack, if they are few; else, or if there is no room, the
    /// rows are of no use any more.
    fn reseat(&mut self, scene: &Scene<'_>, still: &Still, dv: &[DVec3]) -> bool {
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
            self.reseat_one(scene, still, dv, k);
        }
        !self.uncovered
    }

    fn reseat_one(&mut self, scene: &Scene<'_>, still: &Still, dv: &[DVec3], k: usize) {
        let (i, body, c) = (self.members[k] as usize, self.body[k], *self.clusters.of(self.body[k]));
        let (x, radius) = (scene.particles.position[i] - c.shift, still.radius[i]);
        let own = scene.dt * (scene.velocity(i, dv) - c.velocity).length();
        let slack = ((SLACK[0] + SLACK[1]) * radius + own_room(own, radius)) as f32;
        let reach = radius as f32 + slack;
        (self.reference[k], self.slack[k], self.reach[k]) = (x, slack, reach);
        self.moved[k] = (own * MARGIN) as f32;
        self.clusters.hold(body, x, f64::from(reach));
        let b = &scene.bodies[body as usize];
        let Self { reference, reach, members, strays, strayed, blocks, busy, grid, body: of, uncovered, .. } = self;
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
                true => touch(scene.particles.rest, still, i, other),
                false => still.radius[i] as f32 + still.radius[other] as f32,
            };
            *uncovered |= !push(blocks, busy, k, j, d);
        };
        grid.around(x, f64::from(reach[k]), |balls| balls.filter(|&j| !strayed[j]).for_each(&mut meet));
        strays.iter().for_each(|&j| meet(j as usize));
    }

    fn build(&mut self, scene: &Scene<'_>, still: &Still, dv: &[DVec3]) {
        self.make_room(scene.particles.len());
        self.choose_members(scene, still, dv);
        let n = self.members.len();
        self.records.resize(n, Record::default());
        self.near.resize(n, Near::default());
        self.moved.resize(n, 0.0);
        self.strays.clear();
        self.strayed.clear();
        self.strayed.resize(n, false);
        self.busy.resize(n, false);
        let Self { members, body, reference, reach, seats, spots, blocks, busy, grid, scratch, .. } = self;
        grid.build(seats.iter().map(|s| s.key), |k| (reference[k], f64::from(reach[k])));
        let members = Members { members, body, spots };
        blocks.par_iter_mut().zip(busy.par_chunks_mut(BLOCK)).enumerate().for_each(|(block, (b, busy))| {
            let thread = rayon::current_thread_index().unwrap_or(0);
            // never contended: a thread makes one block at a time
            let mut scratch = scratch[thread].lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            scratch.rows(scene, still, &members, grid, block * BLOCK..((block + 1) * BLOCK).min(n), b);
            let starts = std::iter::once(0).chain(b.ends.iter().copied());
            busy.iter_mut().zip(&b.ends).zip(starts).for_each(|((busy, &end), start)| *busy = end > start);
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
        self.near.reserve(n);
        self.busy.reserve(n);
        self.body.reserve(n);
        self.reference.reserve(n);
        self.slack.reserve(n);
        self.moved.reserve(n);
        self.strays.reserve(n);
        self.strayed.reserve(n);
        self.reach.reserve(n);
        self.spots.reserve(n);
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
        let middle = clusters.middle();
        let spot = |s: &Seat| {
            let place = position[s.particle as usize] - middle;
            let rounded = ROUNDED * place.abs().max_element();
            place.extend(f64::from(reach(s)) + rounded).as_vec4().to_array()
        };
        fill(&mut self.spots, seats, spot);
    }
}

/// Adds two members to each other's rows; false where there is no room.
fn push(blocks: &mut [Block], busy: &mut [bool], a: usize, b: usize, d: f32) -> bool {
    [(a, b), (b, a)].into_iter().all(|(row, other)| {
        busy[row] = true;
        let fresh = &mut blocks[row / BLOCK].fresh;
        let room = fresh.len() < fresh.capacity();
        if room {
            fresh.push(((row % BLOCK) as u32, Entry { other: other as u32, d }));
        }
        room
    })
}

fn fill<T>(column: &mut Vec<T>, seats: &[Seat], of: impl Fn(&Seat) -> T) {
    column.clear();
    column.extend(seats.iter().map(of));
}
