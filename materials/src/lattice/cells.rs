//! The finest cells: what they are made of, who is linked to whom, and which node carries each. Nodes are groups of cells
//! that are connected within one octree cell; all else about nodes follows from that.

use fissure_engine::lattice::{CellError, Cells, NEIGHBOURS, morton};
use fissure_engine::{Buffer, Column, Of, Visitor};
use glam::{DMat3, DQuat, DVec3, Vec3};
use rayon::prelude::*;

use super::matching::Turn;
use super::regions::inverse;

/// No cell, no node.
pub const NONE: u32 = u32::MAX;

/// A table of (y, z) may have so many rows per cell.
const SPARSE: usize = 16;

/// The finest cells of a body, in Morton order.
#[derive(Clone, Debug, Default)]
pub struct Finest {
    /// Edge [m], one element.
    size: Buffer<f64>,
    pub index: Buffer<[u32; 3]>,
    /// Centre of mass at rest [m], relative to the body's origin.
    pub rest: Buffer<Vec3>,
    /// Solid volume [m³] and mass [kg].
    pub volume: Buffer<f64>,
    pub mass: Buffer<f64>,
    /// Links of the fresh body, and those that hold still.
    pub built: Buffer<u32>,
    pub links: Buffer<u32>,
    /// The node that carries each cell.
    pub carrier: Buffer<u32>,
    /// The cell across each link that was built, else [`NONE`]; derived.
    beside: Vec<[u32; 26]>,
    /// Place on the Morton curve; derived.
    key: Vec<u64>,
}

impl Finest {
    /// Fresh cells, each carried by a node of its own.
    pub fn new(cells: Cells, rest: &[Vec3], volume: &[f64], mass: &[f64]) -> Self {
        let n = cells.len() as u32;
        let mut finest = Self {
            size: vec![cells.size].into(),
            index: cells.index.into(),
            rest: rest.to_vec().into(),
            volume: volume.to_vec().into(),
            mass: mass.to_vec().into(),
            built: cells.links.clone().into(),
            links: cells.links.into(),
            carrier: (0..n).collect::<Vec<_>>().into(),
            beside: Vec::new(),
            key: Vec::new(),
        };
        finest.find_neighbours();
        finest
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.index.len()
    }

    /// Edge of a cell [m].
    pub fn size(&self) -> f64 {
        self.size[0]
    }

    /// Rest position [m].
    #[inline(always)]
    pub fn place(&self, cell: usize) -> DVec3 {
        self.rest[cell].as_dvec3()
    }

    /// The cell across bit `bit`; the link must have been built.
    #[inline(always)]
    pub fn across(&self, cell: usize, bit: usize) -> usize {
        self.beside[cell][bit] as usize
    }

    /// The cells linked to `cell` still, with the bits of the links.
    #[inline(always)]
    pub fn linked(&self, cell: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.by_bits(cell, self.links[cell])
    }

    /// The cells that `cell` was linked to when it was fresh.
    #[inline(always)]
    pub fn once_linked(&self, cell: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.by_bits(cell, self.built[cell])
    }

    /// Those across `bits`, of links that were built.
    #[inline(always)]
    pub fn by_bits(&self, cell: usize, mut bits: u32) -> impl Iterator<Item = (usize, usize)> + '_ {
        std::iter::from_fn(move || {
            (bits != 0).then(|| {
                let bit = bits.trailing_zeros() as usize;
                bits &= bits - 1;
                (bit, self.across(cell, bit))
            })
        })
    }

    /// What rest vectors about a cell have become with cells at `x`: by least squares over those linked to it, and by its `turn`
    /// along axes in which they have no extent.
    pub fn gradient(&self, cell: usize, x: &[DVec3], turn: Turn) -> DMat3 {
        let (mut mixed, mut spread) = (DMat3::ZERO, DMat3::ZERO);
        for (_, other) in self.linked(cell) {
            let (y, r) = (x[other] - x[cell], self.place(other) - self.place(cell));
            mixed += DMat3::from_cols(y * r.x, y * r.y, y * r.z);
            spread += DMat3::from_cols(r * r.x, r * r.y, r * r.z);
        }
        let (inverse, lost) = inverse(spread);
        mixed * inverse + DMat3::from_quat(DQuat::from_array(turn.map(f64::from)).normalize()) * lost
    }

    /// Breaks the link `bit` of `cell` from both sides.
    pub fn part(&mut self, cell: usize, bit: usize) {
        let other = self.across(cell, bit);
        self.links[cell] &= !(1 << bit);
        self.links[other] &= !(1 << (25 - bit));
    }

    /// Which cell of level `level` a cell lies in, as a number that cells in it share.
    #[inline(always)]
    pub fn block(&self, cell: usize, level: u32) -> u64 {
        self.key[cell] >> (3 * level)
    }

    /// The lowest index along each axis, and how many from there to the highest.
    pub fn extent(&self) -> ([u32; 3], [usize; 3]) {
        let low = self.index.iter().fold([NONE; 3], |m, i| std::array::from_fn(|a| m[a].min(i[a])));
        let high = self.index.iter().fold([0; 3], |m, i| std::array::from_fn(|a| m[a].max(i[a])));
        (low, std::array::from_fn(|a| (high[a] - low[a]) as usize + 1))
    }

    /// Finds the cell across every link that was built. Rows of cells along x, found by a table of (y, z).
    pub fn find_neighbours(&mut self) {
        let index = &self.index[..];
        self.key.clear();
        self.key.extend(index.iter().map(|&i| morton(i)));
        let (low, [_, ny, nz]) = self.extent();
        if ny * nz > SPARSE * index.len() {
            return self.search_neighbours();
        }
        let row = |y: u32, z: u32| (z - low[2]) as usize * ny + (y - low[1]) as usize;
        let mut order: Vec<u32> = (0..index.len() as u32).collect();
        order.par_sort_unstable_by_key(|&c| {
            let [x, y, z] = index[c as usize];
            (z, y, x)
        });
        let mut starts = vec![0u32; ny * nz + 1];
        index.iter().for_each(|&[_, y, z]| starts[row(y, z) + 1] += 1);
        (0..ny * nz).for_each(|k| starts[k + 1] += starts[k]);
        let find = |[x, y, z]: [u32; 3]| {
            let cells = &order[starts[row(y, z)] as usize..starts[row(y, z) + 1] as usize];
            let first = index[cells[0] as usize][0];
            // nearly all rows have no gap
            let direct = cells.get((x - first) as usize).filter(|&&c| index[c as usize][0] == x);
            direct
                .or_else(|| cells.binary_search_by_key(&x, |&c| index[c as usize][0]).ok().map(|k| &cells[k]))
                .copied()
        };
        let built = &self.built[..];
        self.beside.resize(index.len(), [NONE; 26]);
        self.beside.par_iter_mut().enumerate().with_min_len(1024).for_each(|(c, beside)| {
            for bit in (0..26).filter(|bit| built[c] >> bit & 1 == 1) {
                let to = std::array::from_fn(|a| index[c][a].wrapping_add_signed(NEIGHBOURS[bit][a]));
                beside[bit] = find(to).expect("links lead to cells");
            }
        });
    }

    /// The same for cells that are few in their box: by bisection.
    fn search_neighbours(&mut self) {
        let (index, built) = (&self.index[..], &self.built[..]);
        self.beside.resize(index.len(), [NONE; 26]);
        self.beside.par_iter_mut().enumerate().with_min_len(1024).for_each(|(c, beside)| {
            for bit in (0..26).filter(|bit| built[c] >> bit & 1 == 1) {
                let to = std::array::from_fn(|a| index[c][a].wrapping_add_signed(NEIGHBOURS[bit][a]));
                let found = index.binary_search_by_key(&morton(to), |&i| morton(i));
                beside[bit] = found.expect("links lead to cells") as u32;
            }
        });
    }

    /// Whether restored columns are a lattice of nodes that so many particles carry.
    pub fn consistent(&self, nodes: usize) -> bool {
        let n = self.index.len();
        let lengths = [
            self.rest.len(),
            self.volume.len(),
            self.mass.len(),
            self.built.len(),
            self.links.len(),
            self.carrier.len(),
        ];
        if lengths.iter().any(|&l| l != n) || self.size.len() != 1 {
            return false;
        }
        let cells =
            Cells { size: self.size(), origin: DVec3::ZERO, index: self.index.to_vec(), links: self.built.to_vec() };
        let whole = |cells: &Cells| cells.check(n) == Ok::<(), CellError>(());
        let holding = Cells { links: self.links.to_vec(), ..cells.clone() };
        let solid = |x: &f64| *x > 0.0 && x.is_finite();
        // nodes are numbered in the order of their first cells
        let mut seen = 0;
        let numbered = self.carrier.iter().all(|&k| {
            let next = k as usize == seen;
            seen += usize::from(next);
            next || (k as usize) < seen
        });
        whole(&cells)
            && whole(&holding)
            && self.links.iter().zip(&self.built[..]).all(|(now, once)| now & !once == 0)
            && self.volume.iter().chain(&self.mass[..]).all(solid)
            && self.rest.iter().all(|x| x.is_finite())
            && numbered
            && seen == nodes
    }

    /// Shows every column.
    pub fn visit(&mut self, scope: &str, v: &mut Visitor<'_>) {
        v(scope, &Column::frozen("cell_size", "m", Of::Thing), &mut self.size);
        v(scope, &Column::frozen("cell_index", "1", Of::Thing), &mut self.index);
        v(scope, &Column::frozen("cell_rest", "m", Of::Thing), &mut self.rest);
        v(scope, &Column::frozen("cell_volume", "m^3", Of::Thing), &mut self.volume);
        v(scope, &Column::frozen("cell_mass", "kg", Of::Thing), &mut self.mass);
        v(scope, &Column::frozen("cell_built", "1", Of::Thing), &mut self.built);
        v(scope, &Column::live("cell_links", "1", Of::Thing), &mut self.links);
        v(scope, &Column::live("carrier", "1", Of::Thing), &mut self.carrier);
    }
}
