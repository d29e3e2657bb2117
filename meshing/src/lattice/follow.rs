//! The surface follows the nodes.
//!
//! A vertex moves with the affine motion that fits its nodes best (moving least squares, as the skin of tetrahedra fits
//! its own). A node at X_k counts with a quadratic B-spline of (X − X_k) over the node's size along each axis: smooth from cell
//! to cell and over changes of level, exact for every affine motion, rigid for a node that is alone, which turns as its
//! regions do. Blending motions fitted around each node instead shows the cells at a bent surface, where nodes lie
//! irregularly: normals were off by 0.03 rad at a radius of 10 cells, as much as facets would be.
//!
//! Nodes count if links lead to them from the vertex's own cell through others near by: so the two sides of a crack go
//! each with their own, and around its end both do.
//!
//! A coarse node counts as eight points, half as far apart, which move with the motion fitted to it and its linked
//! neighbours: with one point its surroundings would be smoothed over twice the distance, and the surface would jump by as
//! much when nodes merge or split.
//!
//! Where the points of a vertex fill space, the fit is a sum over them with weights that know rest positions alone. Those are
//! kept from frame to frame (12 bytes for each of its 30 to 80 points), and found anew near nodes and links that have
//! changed: a frame then costs a fifteenth of fitting them all.

mod nodes;
mod rows;

use fissure_engine::buffer::Buffer;
use fissure_engine::column::{Column, Of, Visitor};
use fissure_engine::lattice::{Cells, LatticePose, morton};
use glam::DVec3;
use rayon::prelude::*;

use self::nodes::Nodes;
use self::rows::Rows;
use super::{Facets, Patchwork};

const NONE: u32 = u32::MAX;

/// What is to be known of the cells to make a surface follow them.
#[derive(Debug, Default)]
pub struct Follower {
    /// Index of every cell.
    index: Buffer<[u32; 3]>,
    /// Edge of the cells [m].
    size: Buffer<f64>,
    /// The cells across the neighbour bits, or [`NONE`]; made when first needed.
    beside: Vec<[u32; 26]>,
    /// The nodes and weights of the last call; they follow from what it was given.
    nodes: Nodes,
    rows: Rows,
    positions: Vec<DVec3>,
    velocities: Vec<DVec3>,
}

impl Follower {
    pub(super) fn new(cells: &Cells) -> Self {
        Self { index: cells.index.clone().into(), size: vec![cells.size].into(), ..Self::default() }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.index.len()
    }

    /// Computes positions and velocities of all copies of `patchwork`. `origin` [m] is the origin of the rest positions of
    /// `pose`. The same bits on any number of threads, and whatever was followed before.
    pub fn follow(&mut self, facets: &Facets, patchwork: &Patchwork, pose: &LatticePose, origin: DVec3) {
        self.know_neighbours();
        let changed = !self.nodes.are_of(pose);
        let before = if changed {
            let nodes = Nodes::new(pose, &self.index, &self.beside, self.size[0]);
            std::mem::replace(&mut self.nodes, nodes)
        } else {
            Nodes::default()
        };
        let now = if changed { Some(self.nodes.since(&before)) } else { None };
        self.rows.renew(facets, patchwork, origin, &self.nodes, now.as_ref());
        self.nodes.pose(pose);
        self.rows.sum(facets, patchwork, origin, &self.nodes, pose, [&mut self.positions, &mut self.velocities]);
    }

    /// Positions of the copies at the last call of [`follow`](Self::follow) [m].
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Velocities of the copies likewise [m/s].
    pub fn velocities(&self) -> &[DVec3] {
        &self.velocities
    }

    fn know_neighbours(&mut self) {
        if self.beside.len() == self.index.len() {
            return;
        }
        let keys: Vec<u64> = self.index.iter().map(|&i| morton(i)).collect();
        let across = |index: [u32; 3], bit: usize| {
            let to = Cells::across(index, bit)?;
            keys.binary_search(&morton(to)).ok().map(|k| k as u32)
        };
        self.beside =
            self.index.par_iter().map(|&index| std::array::from_fn(|bit| across(index, bit).unwrap_or(NONE))).collect();
    }

    /// Whether this follows so many cells: what a restored file may get wrong.
    pub fn consistent(&self, cells: usize) -> bool {
        self.index.len() == cells && self.size.len() == 1 && self.size[0] > 0.0
    }

    /// Shows every column to `v`, under `scope`. Positions and velocities follow from the nodes and are none.
    pub fn visit(&mut self, scope: &str, v: &mut Visitor) {
        v(scope, &Column::frozen("cell_index", "1", Of::Thing), &mut self.index);
        v(scope, &Column::frozen("cell_size", "m", Of::Thing), &mut self.size);
    }
}
