//! What touching particles remember: how far each pair has slipped elastically. The only state of contact between particles.
//!
//! Rows come and go, so the memory is kept by particle: the touches of each row of the step before, in order of the other
//! particle. A checkpoint gets every pair once.

use glam::DVec3;
use rayon::prelude::*;

use super::neighbours::{Entry, NONE, Neighbours};
use crate::adapt::Descent;
use crate::buffer::Buffer;
use crate::column::{Column, Of, Visitor};

/// Touches per row that room is made for at once, on the mean of a block; address space only, until it is used.
const ROOM: usize = 24;

/// Another particle that a row's own touches. From the other's row it has the same numbers and opposite vectors.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// Which particle, and which member.
    pub particle: u32,
    pub member: u32,
    /// Unit vector towards the other.
    pub normal: DVec3,
    /// Velocity of the other relative to the row's own in the step before [m/s].
    pub v: DVec3,
    /// How far the other has slipped along the contact against an elastic force [m]; alone remembered.
    pub slip: DVec3,
    /// Impulse of a spring per overlap or slip [kg/s].
    pub stiffness: f64,
    /// The least normal velocity that the gap allows [m/s]; 0 or less.
    pub least: f64,
    /// Impulse along the normal in this step [kg m/s].
    pub along: f64,
}

/// Touches of a block of rows.
#[derive(Debug, Default)]
pub struct Block {
    /// Particle of each row.
    pub rows: Vec<u32>,
    pub ends: Vec<u32>,
    pub touches: Vec<Touch>,
    /// What a row touches, particle by particle, while it is looked for.
    pub met: Vec<(u32, Entry)>,
}

impl Block {
    fn clear(&mut self) {
        self.rows.clear();
        self.ends.clear();
        self.touches.clear();
    }

    /// The touches of a row.
    pub fn row(&self, k: usize) -> std::ops::Range<usize> {
        let start = if k == 0 { 0 } else { self.ends[k - 1] };
        start as usize..self.ends[k] as usize
    }
}

/// The touches of this step and of the one before.
#[derive(Debug, Default)]
pub struct Memory {
    pub now: Vec<Block>,
    before: Vec<Block>,
    /// Row of each particle in `before`, or [`NONE`].
    row: Vec<u32>,
    /// How often rows had been made when `row` was.
    builds: u64,
    /// What a restart has brought, pairs in both directions and in order; it stands for `before` until the next step.
    restored: Option<Vec<(u64, DVec3)>>,
}

impl Memory {
    /// Makes the touches of the step before out of the present ones; room for rows of `n` particles.
    pub fn turn(&mut self, n: usize) {
        for side in [&mut self.now, &mut self.before] {
            side.resize_with(n.div_ceil(Neighbours::BLOCK), || Block {
                rows: Vec::with_capacity(Neighbours::BLOCK),
                ends: Vec::with_capacity(Neighbours::BLOCK),
                touches: Vec::with_capacity(Neighbours::BLOCK * ROOM),
                met: Vec::with_capacity(Neighbours::BLOCK * ROOM),
            });
        }
        std::mem::swap(&mut self.now, &mut self.before);
        self.now.iter_mut().for_each(Block::clear);
    }

    /// The step before, beside the present one.
    pub fn split(&mut self) -> (&mut [Block], Past<'_>) {
        let past = Past { blocks: &self.before, row: &self.row, restored: self.restored.as_deref() };
        (&mut self.now, past)
    }

    /// Ends a step whose rows belong to `neighbours`.
    pub fn settle(&mut self, neighbours: &Neighbours) {
        self.restored = None;
        if self.builds != neighbours.builds || self.row.len() != neighbours.rank.len() {
            self.builds = neighbours.builds;
            self.row.clone_from(&neighbours.rank);
        }
    }

    /// Back to the touches of the step before.
    pub fn undo(&mut self) {
        std::mem::swap(&mut self.now, &mut self.before);
        self.restored = Some(self.pairs());
    }

    /// Goes on with other particles in the place of `old`; those that are new remember nothing.
    pub fn renew(&mut self, old: &std::ops::Range<usize>, descent: &[Descent]) {
        let mut pairs = self.pairs();
        let mut heir = vec![NONE; old.len()];
        for (k, d) in descent.iter().enumerate().filter(|(_, d)| d.same) {
            heir[d.from as usize] = (old.start + k) as u32;
        }
        let now = |i: u32| match i as usize {
            i if i < old.start => i as u32,
            i if i < old.end => heir[i - old.start],
            i => (i - old.len() + descent.len()) as u32,
        };
        pairs.retain_mut(|(pair, _)| {
            let (i, j) = (now((*pair >> 32) as u32), now(*pair as u32));
            *pair = key(i, j);
            i != NONE && j != NONE
        });
        pairs.sort_unstable_by_key(|p| p.0);
        self.restored = Some(pairs);
    }

    /// All pairs that touch, in both directions and in order.
    fn pairs(&self) -> Vec<(u64, DVec3)> {
        if let Some(restored) = &self.restored {
            return restored.clone();
        }
        let of_block = |b: &'_ Block| -> Vec<(u64, DVec3)> {
            let row = |k: usize| b.touches[b.row(k)].iter().map(move |t| (key(b.rows[k], t.particle), t.slip));
            (0..b.rows.len()).flat_map(row).collect()
        };
        let mut pairs: Vec<_> = self.now.iter().flat_map(of_block).collect();
        pairs.par_sort_unstable_by_key(|p| p.0);
        pairs
    }

    /// Shows every pair once.
    pub fn visit(&mut self, v: &mut Visitor<'_>) {
        const SCOPE: &str = "contact";
        let pairs = self.pairs();
        let once = || pairs.iter().filter(|(key, _)| key >> 32 < key & u64::from(u32::MAX));
        let mut first = Buffer::new(once().map(|p| (p.0 >> 32) as u32).collect());
        let mut second = Buffer::new(once().map(|p| p.0 as u32).collect());
        let mut slip = Buffer::new(once().map(|p| p.1).collect());
        v(SCOPE, &Column::live("touching_first", "1", Of::Thing), &mut first);
        v(SCOPE, &Column::live("touching_second", "1", Of::Thing), &mut second);
        v(SCOPE, &Column::live("slip", "m", Of::Thing), &mut slip);
        let both = |((i, j), slip): ((&u32, &u32), &DVec3)| [(key(*i, *j), *slip), (key(*j, *i), -*slip)];
        let mut restored: Vec<_> = first.iter().zip(&second[..]).zip(&slip[..]).flat_map(both).collect();
        restored.par_sort_unstable_by_key(|p| p.0);
        self.restored = Some(restored);
    }
}

/// The touches of the step before.
#[derive(Clone, Copy)]
pub struct Past<'a> {
    blocks: &'a [Block],
    row: &'a [u32],
    restored: Option<&'a [(u64, DVec3)]>,
}

/// Those of one particle, still to be asked for.
pub enum Recall<'a> {
    Touches(&'a [Touch]),
    Restored(&'a [(u64, DVec3)]),
}

impl<'a> Past<'a> {
    /// What particle `i` remembers.
    pub fn of(&self, i: u32) -> Recall<'a> {
        if let Some(restored) = self.restored {
            return Recall::Restored(&restored[restored.partition_point(|r| r.0 < key(i, 0))..]);
        }
        let Some(&row) = self.row.get(i as usize).filter(|&&row| row != NONE) else { return Recall::Touches(&[]) };
        let block = &self.blocks[row as usize / Neighbours::BLOCK];
        Recall::Touches(&block.touches[block.row(row as usize % Neighbours::BLOCK)])
    }
}

impl Recall<'_> {
    /// Slip [m] of particle `j` along `i` at the end of the step before; `None` if they did not touch then. Particles have to
    /// be asked for in their order.
    #[inline]
    pub fn slip(&mut self, i: u32, j: u32) -> Option<DVec3> {
        match self {
            Self::Touches(left) => {
                let skip = left.iter().take_while(|t| t.particle < j).count();
                *left = &left[skip..];
                left.first().filter(|t| t.particle == j).map(|t| t.slip)
            }
            Self::Restored(left) => {
                let skip = left.iter().take_while(|r| r.0 < key(i, j)).count();
                *left = &left[skip..];
                left.first().filter(|r| r.0 == key(i, j)).map(|r| r.1)
            }
        }
    }
}

fn key(i: u32, j: u32) -> u64 {
    u64::from(i) << 32 | u64::from(j)
}
