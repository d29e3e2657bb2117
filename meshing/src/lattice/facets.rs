//! The surface of a lattice, and the faces inside it that cracks open.
//!
//! All triangles are made once: those of the outside, each in one cell, and those between two cells, which are seen from
//! both sides when their link is broken. As in a cracked mesh of tetrahedra (Chen et al., Sec. 5.2) a vertex has as many copies
//! as there are groups of cells around it that faces still join, and a broken face is part of the surface where its two
//! sides differ in a vertex. That is a function of what is broken alone: nothing else is kept from step to step.
//!
//! The surface is closed at every moment, and no edge has more than two triangles; see the walls for why. Vertices may touch,
//! at the end of a crack.

use fissure_engine::buffer::Buffer;
use fissure_engine::column::{Column, Of, Visitor};
use glam::{DVec3, Vec3};

use super::pieces::Forest;
use crate::crack::{Smoothing, Surface, shaded};

const NONE: u32 = u32::MAX;

/// The triangles of a lattice and which of them are open.
#[derive(Clone, Debug, Default)]
pub struct Facets {
    vertices: Buffer<DVec3>,
    /// Outside ones first, then those between cells, in the order of their pairs.
    triangles: Buffer<[u32; 3]>,
    /// The cell that each triangle is seen from outside of.
    front: Buffer<u32>,
    /// The cell on its other side, or [`NONE`].
    back: Buffer<u32>,
    /// Unit normals at rest, of whole input triangles.
    normals: Buffer<Vec3>,
    /// 1 for each triangle whose link is broken.
    open: Buffer<u8>,
}

/// A triangle between cells, or outside of one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    pub corners: [u32; 3],
    pub front: u32,
    /// None for an outside one.
    pub back: Option<u32>,
    pub normal: DVec3,
}

/// The surface at one time.
#[derive(Clone, Debug, Default)]
pub struct Patchwork {
    /// The triangles, over copies of vertices; what it calls tetrahedra are cells.
    pub surface: Surface,
    /// The vertex that each copy is one of.
    pub origin: Vec<u32>,
    /// Where the cells of each copy begin, and where the last ones end.
    pub offsets: Vec<u32>,
    /// The cells that copies follow, ascending for each.
    pub cells: Vec<u32>,
}

impl Patchwork {
    /// The cells around copy `v`.
    pub fn cells_of(&self, v: usize) -> &[u32] {
        &self.cells[self.offsets[v] as usize..self.offsets[v + 1] as usize]
    }
}

/// A vertex at a crack: its cells with the copy that each has a share in.
struct Star {
    vertex: u32,
    /// Cell and copy, ascending by cell.
    copies: Vec<(u32, u32)>,
}

impl Facets {
    /// All triangles over `vertices` [m].
    pub(super) fn new(vertices: Vec<DVec3>, mut facets: Vec<Facet>) -> Self {
        let key = |f: &Facet| f.back.map(|back| (f.front.min(back), f.front.max(back)));
        facets.sort_by_key(key); // outside ones first; equal ones keep their order
        Self {
            vertices: vertices.into(),
            triangles: facets.iter().map(|f| f.corners).collect::<Vec<_>>().into(),
            front: facets.iter().map(|f| f.front).collect::<Vec<_>>().into(),
            back: facets.iter().map(|f| f.back.unwrap_or(NONE)).collect::<Vec<_>>().into(),
            normals: facets.iter().map(|f| f.normal.as_vec3()).collect::<Vec<_>>().into(),
            open: vec![0; facets.len()].into(),
        }
    }

    /// Rest position of vertex `v` [m].
    pub fn rest_position(&self, v: u32) -> DVec3 {
        self.vertices[v as usize]
    }

    /// Number of triangles, those between cells counted once.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Opens the faces between the linked cells; links of cells without a common face are passed over. Returns how many
    /// triangles are newly open.
    pub fn cut(&mut self, links: &[(u32, u32)]) -> usize {
        let key = |t: usize| (self.front[t].min(self.back[t]), self.front[t].max(self.back[t]));
        let outside = self.back.partition_point(|&b| b == NONE);
        let mut newly = Vec::new();
        for &(a, b) in links {
            let pair = (a.min(b), a.max(b));
            let (mut low, mut high) = (outside, self.len());
            while low < high {
                let middle = (low + high) / 2;
                if key(middle) < pair { low = middle + 1 } else { high = middle }
            }
            newly.extend((low..self.len()).take_while(|&t| key(t) == pair).filter(|&t| self.open[t] == 0));
        }
        newly.sort_unstable();
        newly.dedup();
        newly.iter().for_each(|&t| self.open[t] = 1);
        newly.len()
    }

    /// The fragment of each of `cells` cells, numbered by their first ones, and how many there are. Closed faces join.
    pub fn fragments(&self, cells: usize) -> (Vec<u32>, usize) {
        let mut forest = Forest::new(cells);
        for t in 0..self.len() {
            if self.back[t] != NONE && self.open[t] == 0 {
                forest.join(self.front[t], self.back[t]);
            }
        }
        let (mut number, mut count) = (vec![NONE; cells], 0);
        for cell in 0..cells as u32 {
            let root = forest.find(cell) as usize; // the smallest of its tree, so it is numbered
            if root == cell as usize {
                number[root] = count;
                count += 1;
            }
            number[cell as usize] = number[root];
        }
        (number, count as usize)
    }

    /// The current surface with the default smoothing.
    pub fn surface(&self) -> Patchwork {
        let mut cracked = vec![false; self.vertices.len()];
        for t in (0..self.len()).filter(|&t| self.open[t] == 1) {
            self.triangles[t].iter().for_each(|&v| cracked[v as usize] = true);
        }
        self.surface_around(&cracked)
    }

    /// The surface, with the groups of cells counted around the `cracked` vertices; around others all are one group.
    fn surface_around(&self, cracked: &[bool]) -> Patchwork {
        let mut patchwork = Patchwork { offsets: vec![0], ..Patchwork::default() };
        let stars = self.stars(cracked, &mut patchwork);
        let mut copy_of = vec![NONE; self.vertices.len()];
        let mut copy = |patchwork: &mut Patchwork, v: u32, cell: u32| {
            if cracked[v as usize] {
                let star = &stars[stars.partition_point(|s| s.vertex < v)].copies;
                return star[star.partition_point(|c| c.0 < cell)].1;
            }
            let known = &mut copy_of[v as usize];
            if *known == NONE {
                *known = patchwork.add(v, &[cell]);
            }
            *known
        };
        let (mut triangles, mut cells, mut inner, mut normals) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for t in 0..self.len() {
            let (corners, normal) = (self.triangles[t], self.normals[t].as_dvec3());
            let mut add = |corners: [u32; 3], cell: u32, normal: DVec3| {
                triangles.push(corners);
                cells.push(cell);
                inner.push(u8::from(self.back[t] != NONE));
                normals.push(normal);
            };
            if self.back[t] == NONE {
                add(corners.map(|v| copy(&mut patchwork, v, self.front[t])), self.front[t], normal);
            } else if self.open[t] == 1 {
                let front = corners.map(|v| copy(&mut patchwork, v, self.front[t]));
                let back = corners.map(|v| copy(&mut patchwork, v, self.back[t]));
                if front != back {
                    add(front, self.front[t], normal);
                    add([back[0], back[2], back[1]], self.back[t], -normal);
                }
            }
        }
        patchwork.surface = shaded(triangles, cells, &inner, &normals, Smoothing::default());
        patchwork
    }

    /// The groups of cells around cracked vertices, each a copy in `patchwork`.
    fn stars(&self, cracked: &[bool], patchwork: &mut Patchwork) -> Vec<Star> {
        let mut at: Vec<(u32, u32)> = Vec::new();
        for (t, corners) in self.triangles.iter().enumerate() {
            at.extend(corners.iter().filter(|v| cracked[**v as usize]).map(|&v| (v, t as u32)));
        }
        at.sort_unstable();
        let mut stars = Vec::new();
        let mut cells: Vec<u32> = Vec::new();
        for fan in at.chunk_by(|a, b| a.0 == b.0) {
            cells.clear();
            let sides = |t: u32| [self.front[t as usize], self.back[t as usize]];
            cells.extend(fan.iter().flat_map(|&(_, t)| sides(t)).filter(|&c| c != NONE));
            cells.sort_unstable();
            cells.dedup();
            let mut forest = Forest::new(cells.len());
            for &(_, t) in fan {
                if let (0, [a, b]) = (self.open[t as usize], sides(t))
                    && b != NONE
                {
                    let place = |c: u32| cells.partition_point(|&x| x < c) as u32;
                    forest.join(place(a), place(b));
                }
            }
            let vertex = fan[0].0;
            let mut copies: Vec<(u32, u32)> = cells.iter().map(|&c| (c, NONE)).collect();
            for leader in 0..cells.len() as u32 {
                if forest.find(leader) == leader {
                    let group: Vec<usize> = (0..cells.len()).filter(|&k| forest.find(k as u32) == leader).collect();
                    let members: Vec<u32> = group.iter().map(|&k| cells[k]).collect();
                    let copy = patchwork.add(vertex, &members);
                    group.iter().for_each(|&k| copies[k].1 = copy);
                }
            }
            stars.push(Star { vertex, copies });
        }
        stars
    }

    /// Gives every group of cells around a vertex that faces do not join a vertex of its own, where cells only touch.
    pub(super) fn separate(mut self) -> Self {
        let mut groups = Patchwork { offsets: vec![0], ..Patchwork::default() };
        let stars = self.stars(&vec![true; self.vertices.len()], &mut groups);
        let copy = |v: u32, cell: u32| {
            let star = &stars[stars.partition_point(|s| s.vertex < v)].copies;
            star[star.partition_point(|c| c.0 < cell)].1
        };
        let triangles: Vec<[u32; 3]> =
            self.triangles.iter().zip(&self.front[..]).map(|(t, &cell)| t.map(|v| copy(v, cell))).collect();
        self.triangles = triangles.into();
        self.vertices = groups.origin.iter().map(|&v| self.vertices[v as usize]).collect::<Vec<_>>().into();
        self
    }

    /// Whether the columns fit each other and so many cells: what a restored file may get wrong.
    pub fn consistent(&self, cells: usize) -> bool {
        let n = self.triangles.len();
        [self.front.len(), self.back.len(), self.normals.len(), self.open.len()].iter().all(|&l| l == n)
            && self.triangles.iter().flatten().all(|&v| (v as usize) < self.vertices.len())
            && self.front.iter().all(|&c| (c as usize) < cells)
            && self.back.iter().all(|&c| c == NONE || (c as usize) < cells)
    }

    /// Shows every column to `v`, under `scope`.
    pub fn visit(&mut self, scope: &str, v: &mut Visitor) {
        v(scope, &Column::frozen("rest_vertex", "m", Of::Thing), &mut self.vertices);
        v(scope, &Column::frozen("triangle", "1", Of::Thing), &mut self.triangles);
        v(scope, &Column::frozen("triangle_front", "1", Of::Thing), &mut self.front);
        v(scope, &Column::frozen("triangle_back", "1", Of::Thing), &mut self.back);
        v(scope, &Column::frozen("triangle_normal", "1", Of::Thing), &mut self.normals);
        v(scope, &Column::live("triangle_open", "1", Of::Thing), &mut self.open);
    }
}

impl Patchwork {
    fn add(&mut self, vertex: u32, cells: &[u32]) -> u32 {
        self.origin.push(vertex);
        self.cells.extend_from_slice(cells);
        self.offsets.push(self.cells.len() as u32);
        self.origin.len() as u32 - 1
    }
}
