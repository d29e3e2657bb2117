//! The nodes of a lattice: what carries the finest cells now.

use fissure_engine::lattice::morton;
use fissure_engine::{Buffer, Column, Of, Visitor};
use glam::DVec3;

use super::cells::{Finest, NONE};

/// One element per node, in the order of their first cells. All but the level follows from the cells.
#[derive(Debug, Default)]
pub struct Nodes {
    /// 0 for a finest cell, l for a group within an octree cell of 2^l cells along an edge.
    pub level: Buffer<u8>,
    /// Rest centre of mass [m], mass [kg], solid volume [m³].
    pub rest: Vec<DVec3>,
    pub mass: Vec<f64>,
    pub volume: Vec<f64>,
    /// Whether a cell of it has not all 26 neighbours.
    pub exposed: Vec<bool>,
    /// Share of its links that are broken [1].
    pub damage: Vec<f32>,
    /// First member of each node; one more than there are nodes.
    offsets: Vec<u32>,
    /// Cells, node after node.
    members: Vec<u32>,
    cursor: Vec<u32>,
}

impl Nodes {
    /// One node for each of so many cells.
    pub fn finest(cells: usize) -> Self {
        Self { level: vec![0; cells].into(), ..Self::default() }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.level.len()
    }

    /// The cells of a node, in order.
    #[inline(always)]
    pub fn cells(&self, node: usize) -> &[u32] {
        &self.members[self.offsets[node] as usize..self.offsets[node + 1] as usize]
    }

    /// Finds all that follows from the cells.
    pub fn derive(&mut self, finest: &Finest) {
        let n = self.len();
        self.offsets.clear();
        self.offsets.resize(n + 1, 0);
        finest.carrier.iter().for_each(|&k| self.offsets[k as usize + 1] += 1);
        (0..n).for_each(|k| self.offsets[k + 1] += self.offsets[k]);
        self.cursor.clone_from(&self.offsets);
        self.members.resize(finest.len(), 0);
        for (cell, &k) in finest.carrier.iter().enumerate() {
            self.members[self.cursor[k as usize] as usize] = cell as u32;
            self.cursor[k as usize] += 1;
        }
        for column in [&mut self.mass, &mut self.volume] {
            column.clear();
            column.resize(n, 0.0);
        }
        self.rest.clear();
        self.rest.resize(n, DVec3::ZERO);
        for k in 0..n {
            let own = self.offsets[k] as usize..self.offsets[k + 1] as usize;
            let (mut moment, first) = (DVec3::ZERO, finest.place(self.members[own.start] as usize));
            for &c in &self.members[own] {
                let c = c as usize;
                self.mass[k] += finest.mass[c];
                self.volume[k] += finest.volume[c];
                moment += (finest.place(c) - first) * finest.mass[c];
            }
            self.rest[k] = first + moment / self.mass[k];
        }
        self.derive_links(finest);
    }

    /// Finds what follows from links.
    pub fn derive_links(&mut self, finest: &Finest) {
        const WHOLE: u32 = fissure_engine::lattice::WHOLE;
        self.exposed.clear();
        self.damage.clear();
        for k in 0..self.len() {
            let cells = &self.members[self.offsets[k] as usize..self.offsets[k + 1] as usize];
            self.exposed.push(cells.iter().any(|&c| finest.links[c as usize] != WHOLE));
            let count = |links: &[u32]| cells.iter().map(|&c| links[c as usize].count_ones()).sum::<u32>();
            let (left, all) = (count(&finest.links), count(&finest.built));
            self.damage.push(if all == 0 { 0.0 } else { 1.0 - left as f32 / all as f32 });
        }
    }

    /// Connected pieces of the body: the piece of each node, numbered in the order of first nodes, and how many.
    pub fn pieces(&self, finest: &Finest) -> (Vec<u32>, usize) {
        let mut piece = vec![NONE; self.len()];
        let (mut count, mut stack) = (0, Vec::new());
        for start in 0..self.len() {
            if piece[start] != NONE {
                continue;
            }
            piece[start] = count;
            stack.push(start as u32);
            while let Some(node) = stack.pop() {
                for &cell in self.cells(node as usize) {
                    for (_, other) in finest.linked(cell as usize) {
                        let next = finest.carrier[other] as usize;
                        if piece[next] == NONE {
                            piece[next] = count;
                            stack.push(next as u32);
                        }
                    }
                }
            }
            count += 1;
        }
        (piece, count as usize)
    }

    /// Whether restored levels fit the cells: every node lies within one octree cell of its level.
    pub fn consistent(&self, finest: &Finest, levels: u32) -> bool {
        let mut block = vec![None; self.len()];
        self.level.iter().all(|&l| u32::from(l) <= levels)
            && finest.carrier.iter().enumerate().all(|(cell, &k)| {
                // not `block`: a body that is restored has not made its keys yet
                let own = morton(finest.index[cell]) >> (3 * u32::from(self.level[k as usize]));
                *block[k as usize].get_or_insert(own) == own
            })
    }

    /// Shows every column.
    pub fn visit(&mut self, scope: &str, v: &mut Visitor<'_>) {
        v(scope, &Column::live("level", "1", Of::Particle), &mut self.level);
    }
}
