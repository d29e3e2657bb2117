//! What a lattice of cells is, and what a surface that is embedded in one asks of it.
//!
//! A solid is cut into cubes of one size. A cell holds what of the solid lies in it: its particle is the centre of mass of
//! that part, with the part's volume. Cells are *linked* where the solid goes on from one to the other; two fingers that
//! touch one face from both sides are not. A coarser cell of level l holds the finest cells whose indices agree but for their
//! lowest l bits, so in Morton order the cells of a coarse one follow each other.

use glam::{DMat3, DVec3};
use thiserror::Error;

/// Steps to the 26 neighbours of a cell, by the bit of [`Cells::links`]: x fastest, then y, then z, from (−1, −1, −1) on,
/// with the cell itself left out. The way back of bit k is bit 25 − k.
pub const NEIGHBOURS: [[i32; 3]; 26] = {
    let mut steps = [[0; 3]; 26];
    let (mut k, mut code) = (0, 0);
    while code < 27 {
        if code != 13 {
            steps[k] = [code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1];
            k += 1;
        }
        code += 1;
    }
    steps
};

/// All 26 links.
pub const WHOLE: u32 = (1 << 26) - 1;

/// Cell indices are below this along each axis, so that a Morton key has 63 bits.
pub const MOST_CELLS: u32 = 1 << 21;

/// The place of a cell on the Morton curve: bits of x, y and z in turn, x the lowest.
pub fn morton(index: [u32; 3]) -> u64 {
    let spread = |v: u32| {
        let mut x = u64::from(v) & 0x1F_FFFF;
        x = (x | x << 32) & 0x001F_0000_0000_FFFF;
        x = (x | x << 16) & 0x001F_0000_FF00_00FF;
        x = (x | x << 8) & 0x100F_00F0_0F00_F00F;
        x = (x | x << 4) & 0x10C3_0C30_C30C_30C3;
        (x | x << 2) & 0x1249_2492_4924_9249
    };
    spread(index[0]) | spread(index[1]) << 1 | spread(index[2]) << 2
}

/// The finest cells of a body, one per particle of the fresh body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cells {
    /// Edge of a cell [m].
    pub size: f64,
    /// World position of the corner at which all indices are 0 [m].
    pub origin: DVec3,
    /// Number of each cell along x, y and z, below [`MOST_CELLS`], in [`morton`] order without doubles.
    pub index: Vec<[u32; 3]>,
    /// One bit for each of the [`NEIGHBOURS`] to which the solid goes on, set from both sides.
    pub links: Vec<u32>,
}

impl Cells {
    /// Number of cells.
    pub fn len(&self) -> usize {
        self.index.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.index.is_empty()
    }

    /// The cell at `index`, if there is one.
    pub fn at(&self, index: [u32; 3]) -> Option<usize> {
        let key = morton(index);
        self.index.binary_search_by_key(&key, |&i| morton(i)).ok()
    }

    /// The index across bit `bit` of the cell at `index`, if it is one.
    pub fn across(index: [u32; 3], bit: usize) -> Option<[u32; 3]> {
        let to: [i64; 3] = std::array::from_fn(|a| i64::from(index[a]) + i64::from(NEIGHBOURS[bit][a]));
        to.iter().all(|x| (0..i64::from(MOST_CELLS)).contains(x)).then(|| to.map(|x| x as u32))
    }

    /// Whether this is a lattice of so many particles.
    ///
    /// # Errors
    /// The first thing that is not as the fields say.
    pub fn check(&self, particles: usize) -> Result<(), CellError> {
        let (cells, links) = (self.index.len(), self.links.len());
        if cells != particles || links != particles || cells == 0 {
            return Err(CellError::Lengths { cells, links, particles });
        }
        if !(self.size > 0.0 && self.size.is_finite()) {
            return Err(CellError::Size { size: self.size });
        }
        let behind = |k: usize| k == 0 || morton(self.index[k - 1]) < morton(self.index[k]);
        let inside = |k: usize| self.index[k].iter().all(|&x| x < MOST_CELLS);
        if let Some(cell) = (0..cells).find(|&k| !(inside(k) && behind(k))) {
            return Err(CellError::Order { cell });
        }
        for (cell, &bits) in self.links.iter().enumerate() {
            let loose = |bit: &u32| {
                let other = Self::across(self.index[cell], *bit as usize % 26).and_then(|to| self.at(to));
                *bit >= 26 || other.is_none_or(|other| self.links[other] >> (25 - bit) & 1 == 0)
            };
            if let Some(bit) = (0..32).filter(|bit| bits >> bit & 1 == 1).find(loose) {
                return Err(CellError::Link { cell, bit });
            }
        }
        Ok(())
    }
}

/// What is wrong with cells.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CellError {
    /// Columns of different lengths, or none at all.
    #[error(
        "a lattice of {cells} cells with {links} rows of links and {particles} particles; it needs one of each for every cell"
    )]
    Lengths {
        /// Indices given.
        cells: usize,
        /// Rows of links given.
        links: usize,
        /// Particles given.
        particles: usize,
    },
    /// Cells out of order, twice, or too far out.
    #[error(
        "lattice cell {cell} is not in Morton order behind the one before it, or has an index of {MOST_CELLS} or more"
    )]
    Order {
        /// Which.
        cell: usize,
    },
    /// A link to nobody, or one that the other side does not know.
    #[error("lattice cell {cell} is linked to a neighbour that is not there or not linked back (bit {bit})")]
    Link {
        /// Which.
        cell: usize,
        /// Bit of its links.
        bit: u32,
    },
    /// A size that is not positive.
    #[error("lattice cells of size {size} m; it must be above 0")]
    Size {
        /// The size.
        size: f64,
    },
}

/// What moves the surface: the deformation that the nodes of a lattice carry. Nodes are the particles of the body as they are
/// now; a coarse node carries all finest cells of its connected group.
#[derive(Clone, Copy, Debug)]
pub struct LatticePose<'a> {
    /// Of each finest cell, the node that carries it, counted from the body's first particle.
    pub carrier: &'a [u32],
    /// Rest centre of mass of each node [m], relative to the body's origin.
    pub rest: &'a [DVec3],
    /// Where the nodes are in the world [m].
    pub position: &'a [DVec3],
    /// Velocity of the nodes [m/s].
    pub velocity: &'a [DVec3],
    /// What rest vectors about each node have become: the mean of the goal shapes of its regions (R, or βA + (1 − β)R of
    /// Ohta's Eq. 5), at the present positions.
    pub deformation: &'a [DMat3],
    /// One bit for each of the [`NEIGHBOURS`] with which a finest cell is connected still.
    pub links: &'a [u32],
}

/// How far a lattice is resolved now, for logs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeCounts {
    /// Nodes at each level, the finest first.
    pub levels: Vec<usize>,
    /// Connected pieces.
    pub pieces: usize,
}

impl NodeCounts {
    /// All nodes.
    pub fn nodes(&self) -> usize {
        self.levels.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_back_has_the_opposite_bit() {
        for k in 0..26 {
            assert_eq!(NEIGHBOURS[k].map(|d| -d), NEIGHBOURS[25 - k], "bit {k}");
        }
        assert_eq!((NEIGHBOURS[0], NEIGHBOURS[12], NEIGHBOURS[13]), ([-1; 3], [-1, 0, 0], [1, 0, 0]));
    }

    #[test]
    fn the_cells_of_a_coarse_one_follow_each_other() {
        assert_eq!((morton([1, 0, 0]), morton([0, 1, 0]), morton([0, 0, 1]), morton([2, 0, 0])), (1, 2, 4, 8));
        let last = MOST_CELLS - 1;
        assert_eq!(morton([last; 3]), (1 << 63) - 1);
        assert_eq!(morton([5, 6, 7]) >> 6, morton([1, 1, 1]));
    }

    #[test]
    fn links_are_two_sided_and_cells_in_order() {
        let pair =
            Cells { size: 1.0, origin: DVec3::ZERO, index: vec![[4, 0, 0], [5, 0, 0]], links: vec![1 << 13, 1 << 12] };
        assert_eq!(pair.check(2), Ok(()));
        assert_eq!(pair.check(3), Err(CellError::Lengths { cells: 2, links: 2, particles: 3 }));
        let alone = Cells { links: vec![1 << 13, 0], ..pair.clone() };
        assert_eq!(alone.check(2), Err(CellError::Link { cell: 0, bit: 13 }));
        let beyond = Cells { links: vec![1 << 30, 0], ..pair.clone() };
        assert_eq!(beyond.check(2), Err(CellError::Link { cell: 0, bit: 30 }));
        let turned = Cells { index: vec![[5, 0, 0], [4, 0, 0]], ..pair.clone() };
        assert_eq!(turned.check(2), Err(CellError::Order { cell: 1 }));
        assert!(Cells { size: f64::NAN, ..pair }.check(2).is_err());
    }
}
