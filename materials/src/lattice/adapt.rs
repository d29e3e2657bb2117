//! Nodes split where their region is stretched, and connected siblings merge where they are calm (Ohta et al., Secs. "Changing
//! the Subdivision Level of Nodes" and "Merging Nodes").
//!
//! The cells of a split node go to where it and the nodes linked to it put them, by least squares, and get the velocity that those
//! have there, so that little jumps (by 0.35 of the fastest speed where a dropped blob lands; 0.85 by least squares over its
//! regions, which reach too far). A merged node has the mass, the centre and the momentum of its siblings.
//! What spin is lost or made by that is given back to the whole piece as a rotation; it is a tiny one, for a piece is much
//! larger than a node.
//!
//! Siblings are the nodes in one octree cell. A part of them that is connected, and held by the same anchors, merges alone, so one
//! cell may hold several nodes; all of that part must be of one level, calm, and lie as the node will show it. A piece keeps at least [`LEAST`] nodes, for a
//! point knows no rotation.

use fissure_engine::{BodyParticles, Descent, Present, Renewal};
use glam::{DMat3, DQuat, DVec3};

use super::Lattice;
use super::cells::{Finest, NONE};
use super::matching::{STRAIGHT, Turn};
use super::params::Settings;
use super::regions::inverse;
use super::spin::Spins;

/// Nodes that a piece keeps.
const LEAST: usize = 8;
/// How far siblings may be from where the rotation of one puts them, in finest cells, beyond what calm stretch explains. At 0.02
/// a dropped blob's surface jumps no less, for it splits more often.
const EVEN: f64 = 0.05;

/// Finds siblings; memory only.
#[derive(Debug, Default)]
pub(super) struct Search {
    seen: Vec<u32>,
    round: u32,
    /// The groups found last.
    found: Vec<u32>,
    families: Families,
}

/// Nodes that merge as soon as all of them are calm: connected siblings of one level, held by the same anchors. Known until
/// nodes, links or anchors change, so that a calm step looks at nodes alone.
#[derive(Debug, Default)]
struct Families {
    known: bool,
    fence: Vec<u64>,
    members: Vec<u32>,
    /// End of each family among the members.
    ends: Vec<u32>,
}

/// Groups as a search sees them.
struct View<'a, O, C, S, F> {
    finest: &'a Finest,
    /// Group of a cell, cells of a group, whether the same anchors hold a group, whether it may merge.
    of: O,
    cells: C,
    same: S,
    fits: F,
}

impl Search {
    /// Forgets the families: nodes or links have changed.
    pub(super) fn forget(&mut self) {
        self.families.known = false;
    }

    /// Forgets what was visited, of so many groups.
    fn begin(&mut self, groups: usize) {
        self.round += 1;
        self.seen.resize(groups.max(self.seen.len()), 0);
    }

    /// Finds the groups that are connected with `start` within its octree cell of `level`; whether all of them may merge.
    fn siblings<'a, O, C, S, F>(&mut self, start: u32, level: u32, view: &View<'a, O, C, S, F>) -> bool
    where
        O: Fn(usize) -> u32,
        C: Fn(u32) -> &'a [u32],
        S: Fn(u32) -> bool,
        F: Fn(u32) -> bool,
    {
        self.found.clear();
        self.found.push(start);
        self.seen[start as usize] = self.round;
        let block = view.finest.block((view.cells)(start)[0] as usize, level);
        let (mut all, mut k) = (true, 0);
        while k < self.found.len() {
            for &cell in (view.cells)(self.found[k]) {
                for (_, other) in view.finest.linked(cell as usize) {
                    let group = (view.of)(other);
                    let seen = self.seen[group as usize] == self.round;
                    if seen || view.finest.block(other, level) != block || !(view.same)(group) {
                        continue;
                    }
                    all &= (view.fits)(group);
                    self.seen[group as usize] = self.round;
                    self.found.push(group);
                }
            }
            k += 1;
        }
        all
    }
}

/// The affine motion of a node and those linked to it.
struct Motion {
    /// What rest vectors about it become, and how fast [1/s].
    gradient: DMat3,
    rate: DMat3,
}

/// What the nodes of [`Group`]s get.
#[derive(Default)]
struct States {
    position: Vec<DVec3>,
    velocity: Vec<DVec3>,
    mass: Vec<f64>,
    turn: Vec<Turn>,
    shape: Vec<DMat3>,
}

/// A group of cells on the way from nodes to nodes.
#[derive(Clone, Debug)]
struct Group {
    cells: Vec<u32>,
    level: u8,
    strain: f32,
    fence: u64,
    /// The nodes before that it is made of; more than one if they have merged.
    from: Vec<u32>,
    /// Whether it is that node, or only a part of it.
    whole: bool,
}

impl Group {
    /// Whether it is a node that is there.
    fn is_a_node(&self) -> bool {
        self.whole && self.from.len() == 1
    }
}

/// The coarsest level that each cell may be carried at: that of the largest octree cell which is solid enough.
pub(super) fn tops(finest: &Finest, settings: &Settings) -> Vec<u8> {
    let mut top = vec![0u8; finest.len()];
    for level in 1..=settings.levels {
        let full = (finest.size() * f64::from(1u32 << level)).powi(3);
        let mut start = 0;
        while start < finest.len() {
            let block = finest.block(start, level);
            let count = (start..finest.len()).take_while(|&c| finest.block(c, level) == block).count();
            let cells = start..start + count;
            if finest.volume[cells.clone()].iter().sum::<f64>() >= settings.fill * full {
                top[cells].fill(level as u8);
            }
            start += count;
        }
    }
    top
}

impl Lattice {
    /// Splits and merges; whether anything has changed.
    pub(super) fn renew(&mut self, now: &Present<'_>, next: &mut Renewal) -> bool {
        let Some(groups) = self.regroup(now) else { return false };
        if groups.iter().any(|g| !g.whole) {
            self.gather(now.particles.position, true); // where nodes are now
        }
        let mut new = self.states(&groups, now);
        self.give_back_spin(&groups, now, &mut new);
        let piece = |k: u32| self.derived.piece.get(k as usize).copied();
        let pieces: Vec<u32> = groups.iter().filter_map(|g| piece(g.from[0])).collect();
        let count = self.nodes.len();
        // columns
        for (k, g) in groups.iter().enumerate() {
            g.cells.iter().for_each(|&c| self.finest.carrier[c as usize] = k as u32);
        }
        self.nodes.level.set(groups.iter().map(|g| g.level).collect());
        self.nodes.derive(&self.finest);
        self.search.forget();
        self.derived.set_pieces(pieces, self.derived.pieces);
        self.strain.clear();
        self.strain.extend(groups.iter().map(|g| g.strain));
        if !self.turn.is_empty() {
            self.turn.set(new.turn);
        }
        if self.shapes.len() > 0 {
            self.shapes.set(new.shape.iter().copied());
        }
        // regions
        if self.derived.regions_known {
            let mut now = vec![NONE; count];
            groups
                .iter()
                .enumerate()
                .filter(|(_, g)| g.is_a_node())
                .for_each(|(k, g)| now[g.from[0] as usize] = k as u32);
            let before = std::mem::take(&mut self.derived.regions);
            let mut same = vec![true; before.len()];
            let changed = (0..count).filter(|&k| now[k] == NONE);
            changed.for_each(|k| before.of(k).for_each(|(r, _)| same[r] = false));
            let mut known = vec![NONE; groups.len()];
            (0..count).filter(|&k| now[k] != NONE && same[k]).for_each(|k| known[now[k] as usize] = k as u32);
            self.connect(Some((&before, &known, &now)), None);
        }
        next.rest.extend(self.nodes.rest.iter().map(|r| r.as_vec3()));
        next.position.extend(&new.position);
        next.velocity.extend(&new.velocity);
        next.volume.extend(&self.nodes.volume);
        next.mass.extend(&self.nodes.mass);
        next.damage.extend(&self.nodes.damage);
        next.id.extend(groups.iter().map(|g| g.cells[0]));
        next.descent.extend(groups.iter().map(|g| Descent { from: g.from[0], same: g.is_a_node() }));
        true
    }

    fn strain_of(&self, node: usize) -> f64 {
        self.strain.get(node).map_or(0.0, |&s| f64::from(s))
    }

    /// Whether siblings so stretched merge; fresh ones do always.
    fn is_calm(&self, strain: f64) -> bool {
        self.strain.is_empty() || strain < self.settings.merge_below
    }

    fn must_split(&self, node: usize) -> bool {
        self.nodes.level[node] > 0 && self.strain_of(node) > self.settings.subdivide_at
    }

    /// Whether anything would change; looks at nodes and allocates nothing.
    fn stirs(&mut self, now: &Present<'_>) -> bool {
        if (0..self.nodes.len()).any(|k| self.must_split(k)) {
            return true;
        }
        if self.settings.merge_below < 0.0 && !self.strain.is_empty() {
            return false;
        }
        self.find_families(now.fence);
        let Families { members, ends, .. } = &self.search.families;
        let mut start = 0;
        ends.iter().any(|&end| {
            let family = &members[std::mem::replace(&mut start, end as usize)..end as usize];
            family.iter().all(|&k| self.is_calm(self.strain_of(k as usize)))
                && self.leaves_enough(family[0], family.len())
                && self.even(family, now.particles.position)
        })
    }

    fn find_families(&mut self, fence: &[u64]) {
        if self.search.families.known && self.search.families.fence == fence {
            return;
        }
        let mut search = std::mem::take(&mut self.search);
        let mut families = std::mem::take(&mut search.families);
        families.members.clear();
        families.ends.clear();
        families.fence.clear();
        families.fence.extend(fence);
        let level = |k: u32| u32::from(self.nodes.level[k as usize]);
        let may = |k: u32| level(k) < u32::from(self.derived.top[self.nodes.cells(k as usize)[0] as usize]);
        let mut done = vec![false; self.nodes.len()];
        for start in 0..self.nodes.len() as u32 {
            if done[start as usize] || !may(start) {
                continue;
            }
            search.begin(done.len());
            let view = View {
                finest: &self.finest,
                of: |cell| self.finest.carrier[cell],
                cells: |k| self.nodes.cells(k as usize),
                same: |k| fence[k as usize] == fence[start as usize],
                fits: |k| level(k) == level(start),
            };
            let all = search.siblings(start, level(start) + 1, &view);
            // finer ones may be a family of their own
            search.found.iter().filter(|&&k| level(k) == level(start)).for_each(|&k| done[k as usize] = true);
            if all {
                families.members.extend(&search.found);
                families.ends.push(families.members.len() as u32);
            }
        }
        families.known = true;
        search.families = families;
        self.search = search;
    }

    /// Whether the piece of a node keeps enough when so many of its nodes become one.
    fn leaves_enough(&self, node: u32, merged: usize) -> bool {
        let piece = self.derived.piece.get(node as usize).copied().unwrap_or(0);
        let count = self.derived.piece_nodes.get(piece as usize).map_or(self.nodes.len(), |&n| n as usize);
        merged == 1 || count + 1 >= LEAST + merged
    }

    /// Whether siblings at `x` [m] lie as the node that they would merge into shows them, so that nothing jumps. Regions may be
    /// calm while the few in them are pushed or swing about each other. Asks columns alone, for the sake of restarts.
    fn even(&self, nodes: &[u32], x: &[DVec3]) -> bool {
        if self.strain.is_empty() || nodes.len() == 1 {
            return true;
        }
        let (mass, rest, first) = (&self.nodes.mass, &self.nodes.rest, nodes[0] as usize);
        let turn = self.turn.get(first).copied().unwrap_or(STRAIGHT);
        let turn = DMat3::from_quat(DQuat::from_array(turn.map(f64::from)).normalize());
        let off = |k: usize| (x[k] - x[first]) - turn * (rest[k] - rest[first]);
        let nodes = || nodes.iter().map(|&k| k as usize);
        let all: f64 = nodes().map(|k| mass[k]).sum();
        let mean = nodes().map(|k| off(k) * (mass[k] / all)).sum::<DVec3>();
        let middle = nodes().map(|k| rest[k] * (mass[k] / all)).sum::<DVec3>();
        let limit = |k: usize| EVEN * self.finest.size() + self.settings.merge_below * rest[k].distance(middle);
        nodes().all(|k| off(k).distance(mean) < limit(k))
    }

    /// The nodes to be, in the order of their first cells; `None` if they are those that are there.
    fn regroup(&mut self, now: &Present<'_>) -> Option<Vec<Group>> {
        let fence = now.fence;
        if !self.stirs(now) {
            return None;
        }
        let mut of: Vec<u32> = self.finest.carrier.to_vec();
        let mut groups: Vec<Option<Group>> = (0..self.nodes.len())
            .map(|k| {
                let cells = self.nodes.cells(k).to_vec();
                let (level, strain) = (self.nodes.level[k], self.strain_of(k) as f32);
                Some(Group { cells, level, strain, fence: fence[k], from: vec![k as u32], whole: true })
            })
            .collect();
        for k in (0..self.nodes.len()).filter(|&k| self.must_split(k)) {
            let parent = groups[k].take().expect("each is split once");
            for cells in self.parts(&parent) {
                cells.iter().for_each(|&c| of[c as usize] = groups.len() as u32);
                groups.push(Some(Group {
                    cells,
                    level: parent.level - 1,
                    whole: false,
                    from: parent.from.clone(),
                    ..parent
                }));
            }
        }
        let mut changed = groups.len() > self.nodes.len();
        for level in 0..self.settings.levels {
            changed |= self.merge_level(level, &mut of, &mut groups, now.particles.position);
        }
        if !changed {
            return None;
        }
        let mut groups: Vec<Group> = groups.into_iter().flatten().collect();
        groups.sort_unstable_by_key(|g| g.cells[0]);
        Some(groups)
    }

    /// The connected parts of a group in the octree cells one level finer.
    fn parts(&self, group: &Group) -> Vec<Vec<u32>> {
        let level = u32::from(group.level) - 1;
        let (mut parts, mut left) = (Vec::new(), group.cells.clone());
        while let Some(&start) = left.first() {
            let block = self.finest.block(start as usize, level);
            let mut part = vec![start];
            let mut k = 0;
            while k < part.len() {
                for (_, other) in self.finest.linked(part[k] as usize) {
                    let other = other as u32;
                    // a block holds at most some hundred cells of a group
                    if self.finest.block(other as usize, level) == block
                        && left.binary_search(&other).is_ok()
                        && !part.contains(&other)
                    {
                        part.push(other);
                    }
                }
                k += 1;
            }
            part.sort_unstable();
            left.retain(|c| part.binary_search(c).is_err());
            parts.push(part);
        }
        parts
    }

    /// Merges the calm groups of a level; whether there were any.
    fn merge_level(&mut self, level: u32, of: &mut [u32], groups: &mut Vec<Option<Group>>, x: &[DVec3]) -> bool {
        let mut search = std::mem::take(&mut self.search);
        let mut changed = false;
        for start in 0..groups.len() {
            let fits = |g: &Option<Group>| {
                g.as_ref().is_some_and(|g| {
                    u32::from(g.level) == level
                        && g.whole
                        && self.is_calm(f64::from(g.strain))
                        && level < u32::from(self.derived.top[g.cells[0] as usize])
                })
            };
            let Some(fence) = groups[start].as_ref().map(|g| g.fence) else { continue };
            if !fits(&groups[start]) {
                continue;
            }
            search.begin(groups.len());
            let view = View {
                finest: &self.finest,
                of: |cell| of[cell],
                cells: |k: u32| groups[k as usize].as_ref().map_or(&[][..], |g| &g.cells),
                same: |k: u32| groups[k as usize].as_ref().is_some_and(|g| g.fence == fence),
                fits: |k: u32| fits(&groups[k as usize]),
            };
            if !search.siblings(start as u32, level + 1, &view) {
                continue;
            }
            let first = groups[start].as_ref().map_or(0, |g| g.from[0]);
            let found = search.found.iter().filter_map(|&k| groups[k as usize].as_ref());
            let nodes: Vec<u32> = found.flat_map(|g| g.from.iter().copied()).collect();
            if !self.leaves_enough(first, search.found.len()) || !self.even(&nodes, x) {
                continue;
            }
            let merged: Vec<Group> = search.found.iter().filter_map(|&k| groups[k as usize].take()).collect();
            if let Some(count) =
                self.derived.piece_nodes.get_mut(self.derived.piece.get(first as usize).map_or(0, |&p| p as usize))
            {
                *count -= merged.len() as u32 - 1;
            }
            let mut cells: Vec<u32> = merged.iter().flat_map(|g| g.cells.iter().copied()).collect();
            cells.sort_unstable();
            let mut from: Vec<u32> = merged.iter().flat_map(|g| g.from.iter().copied()).collect();
            from.sort_unstable();
            cells.iter().for_each(|&c| of[c as usize] = groups.len() as u32);
            let strain = merged.iter().map(|g| g.strain).fold(0.0, f32::max);
            groups.push(Some(Group { cells, level: level as u8 + 1, strain, fence, from, whole: true }));
            changed = true;
        }
        self.search = search;
        changed
    }

    /// How node `node` and those linked to it move, by least squares; as its regions do along axes in which they have no extent.
    fn motion(&self, node: usize, p: &BodyParticles<'_>) -> Motion {
        let cells = self.nodes.cells(node).iter().flat_map(|&c| self.finest.linked(c as usize));
        let mut around: Vec<u32> = cells.map(|(_, other)| self.finest.carrier[other]).collect();
        around.sort_unstable();
        around.dedup();
        let (mut spread, mut moved, mut moving) = (DMat3::ZERO, DMat3::ZERO, DMat3::ZERO);
        for i in around.into_iter().map(|k| k as usize).filter(|&i| i != node) {
            let (q, m) = (self.nodes.rest[i] - self.nodes.rest[node], self.nodes.mass[i]);
            let outer = |a: DVec3| DMat3::from_cols(a * (q.x * m), a * (q.y * m), a * (q.z * m));
            spread += outer(q);
            moved += outer(p.position[i] - p.position[node]);
            moving += outer(p.velocity[i] - p.velocity[node]);
        }
        let (inverse, lost) = inverse(spread);
        let found = self.lists.gradient(node, &self.derived.regions);
        Motion { gradient: moved * inverse + found * lost, rate: moving * inverse }
    }

    /// Where the nodes to be are, how they move and what they remember.
    fn states(&self, groups: &[Group], now: &Present<'_>) -> States {
        let (p, mut s) = (&now.particles, States::default());
        let mut split: Option<(usize, Motion)> = None;
        let remembers = |k: usize| self.turn.get(k).copied().unwrap_or(STRAIGHT);
        for g in groups {
            let k = g.from[0] as usize;
            let mass = g.cells.iter().map(|&c| self.finest.mass[c as usize]).sum::<f64>();
            let (mut x, mut v, mut turn, mut shape) = (p.position[k], p.velocity[k], remembers(k), self.shapes.get(k));
            if g.from.len() > 1 {
                let parts = || g.from.iter().map(|&k| (k as usize, self.nodes.mass[k as usize] / mass));
                x += parts().map(|(k, share)| (p.position[k] - p.position[g.from[0] as usize]) * share).sum::<DVec3>();
                v = parts().map(|(k, share)| p.velocity[k] * share).sum();
                shape = parts().fold(DMat3::ZERO, |sum, (k, share)| sum + self.shapes.get(k) * share);
                let heaviest = parts().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(k, |(k, _)| k);
                turn = remembers(heaviest);
            } else if !g.whole {
                let first = self.nodes.rest[k];
                let moment =
                    g.cells.iter().map(|&c| (self.finest.place(c as usize) - first) * self.finest.mass[c as usize]);
                let d = moment.sum::<DVec3>() / mass;
                if split.as_ref().is_none_or(|(parent, _)| *parent != k) {
                    split = Some((k, self.motion(k, p)));
                }
                let (_, motion) = split.as_ref().expect("just found");
                x += motion.gradient * d;
                v += motion.rate * d;
            }
            s.position.push(x);
            s.velocity.push(v);
            s.mass.push(mass);
            s.turn.push(turn);
            s.shape.push(shape);
        }
        s
    }

    /// Turns the pieces whose nodes have changed, so that each keeps its angular momentum.
    fn give_back_spin(&self, groups: &[Group], now: &Present<'_>, new: &mut States) {
        let piece = |g: &Group| self.derived.piece.get(g.from[0] as usize).map_or(0, |&p| p as usize);
        let all = groups.iter().enumerate().map(|(k, g)| (piece(g), new.mass[k], new.position[k]));
        let mut spins = Spins::default();
        spins.reset(self.derived.pieces, all);
        let mut split = vec![true; self.nodes.len()];
        for (k, g) in groups.iter().enumerate().filter(|(_, g)| !g.is_a_node()) {
            spins.gain(piece(g), new.mass[k], new.position[k], new.velocity[k]);
            for &old in g.from.iter().filter(|&&old| std::mem::take(&mut split[old as usize])) {
                let old = old as usize;
                spins.lose(piece(g), self.nodes.mass[old], now.particles.position[old], now.particles.velocity[old]);
            }
        }
        spins.solve();
        for (k, g) in groups.iter().enumerate() {
            new.velocity[k] += spins.at(piece(g), new.position[k]);
        }
    }
}
