//! Which parts of the cut body belong together, how much each holds, and which cell it becomes.
//!
//! Around a point on a plane of the grid the body lies on both sides, around one on two planes in up to four cells, around a
//! corner in eight. In each of those the triangles and walls at the point bound one part of the body; so parts are
//! found by joining such corners of cells, and two fingers in one cell come out as two parts, whatever the gap.
//!
//! A cell can hold one node. Where it holds several parts that are connected elsewhere the largest keeps the cell, and the
//! others move with the neighbours that they grow out of; parts of which nothing leads to the others get cells of their own,
//! far off in the index space. Parts of less than [`SLIVER`] of a cell go to a neighbour too, where that keeps all links:
//! light nodes are no use and cost as much as others.

use std::collections::{BTreeMap, HashMap};

use fissure_engine::lattice::{Cells, NEIGHBOURS, morton};
use glam::DVec3;
use rayon::prelude::*;

use super::clip::{Clipped, FREE};
use super::grid::Grid;
use super::wall::Wall;

/// Parts below this share of a cell go to a neighbour.
const SLIVER: f64 = 1.0 / 32.0;
/// Index blocks of parts that lead nowhere are at least this long, so that they share no coarse cell.
const BLOCK: i64 = 1 << 8;

/// What fills the cells.
#[derive(Debug)]
pub(super) struct Pieces {
    pub cells: Cells,
    /// Centre of mass of each [m].
    pub points: Vec<DVec3>,
    /// Volume of each [m³].
    pub volumes: Vec<f64>,
    /// Where each lies in the grid.
    pub place: Vec<[i32; 3]>,
    /// The piece of each triangle of the surface.
    pub of_triangle: Vec<u32>,
    /// The pieces below and above each wall; the same twice where a part went to its neighbour.
    pub of_wall: Vec<[u32; 2]>,
    /// Parts that share a cell with others they are connected with elsewhere.
    pub crowded: usize,
}

/// Union-find; the smaller number leads.
pub(super) struct Forest(pub Vec<u32>);

impl Forest {
    pub fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }

    pub fn find(&mut self, mut v: u32) -> u32 {
        while self.0[v as usize] != v {
            self.0[v as usize] = self.0[self.0[v as usize] as usize];
            v = self.0[v as usize];
        }
        v
    }

    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// A part of the body in one cell.
#[derive(Clone, Copy, Debug)]
struct Part {
    cell: [i32; 3],
    volume: f64,
    moment: DVec3,
}

impl Pieces {
    pub fn new(clipped: &Clipped, walls: &[Wall], grid: Grid) -> Self {
        let (mut parts, mut of_triangle, mut of_wall) = parts(clipped, walls, grid);
        fill_cavities(&mut parts, &mut of_triangle);
        let sides: Vec<(u32, u32, f64)> = walls
            .iter()
            .zip(&of_wall)
            .map(|(w, &[a, b])| (a, b, w.triangles.iter().map(|&t| area(clipped, t)).sum()))
            .collect();
        let (into, crowded) = gather(&parts, &sides, grid.size.powi(3));
        // sums and indices of what is kept
        let mut sums: Vec<(f64, DVec3)> = vec![(0.0, DVec3::ZERO); parts.len()];
        for (p, part) in parts.iter().enumerate() {
            let sum = &mut sums[into[p] as usize];
            *sum = (sum.0 + part.volume, sum.1 + part.moment);
        }
        let index = indices(&parts, &into, &sides);
        let mut kept: Vec<u32> =
            (0..parts.len() as u32).filter(|&p| into[p as usize] == p && sums[p as usize].0 > 0.0).collect();
        kept.sort_by_key(|&p| morton(index[p as usize]));
        let mut number = vec![u32::MAX; parts.len()];
        kept.iter().enumerate().for_each(|(k, &p)| number[p as usize] = k as u32);
        let named = |p: u32| number[into[p as usize] as usize];
        of_triangle.iter_mut().for_each(|p| *p = named(*p));
        of_wall.iter_mut().flatten().for_each(|p| *p = named(*p));
        let index: Vec<[u32; 3]> = kept.iter().map(|&p| index[p as usize]).collect();
        let links = links(&index, &of_wall);
        Self {
            points: kept.iter().map(|&p| sums[p as usize].1 / sums[p as usize].0).collect(),
            volumes: kept.iter().map(|&p| sums[p as usize].0).collect(),
            place: kept.iter().map(|&p| parts[p as usize].cell).collect(),
            cells: Cells { size: grid.size, origin: grid.origin, index, links },
            of_triangle,
            of_wall,
            crowded,
        }
    }
}

fn area(clipped: &Clipped, t: [u32; 3]) -> f64 {
    let [a, b, c] = t.map(|v| clipped.points.x[v as usize]);
    (b - a).cross(c - a).length() / 2.0
}

/// The parts, with those of every triangle and of both sides of every wall.
fn parts(clipped: &Clipped, walls: &[Wall], grid: Grid) -> (Vec<Part>, Vec<u32>, Vec<[u32; 2]>) {
    let points = &clipped.points;
    // eight corners of cells at each point; those of axes it is on no plane of are the low ones
    let mut forest = Forest::new(8 * points.x.len());
    let slot = |v: u32, cell: [i32; 3]| {
        let on = points.on[v as usize];
        let high = |axis: usize| u32::from(on[axis] != FREE && cell[axis] >= on[axis]);
        8 * v + high(0) + 2 * high(1) + 4 * high(2)
    };
    let join = |forest: &mut Forest, t: &[u32; 3], cell: [i32; 3]| {
        let [a, b, c] = t.map(|v| slot(v, cell));
        forest.join(a, b);
        forest.join(b, c);
    };
    let cells: Vec<[i32; 3]> = (0..clipped.triangles.len()).into_par_iter().map(|t| clipped.cell(t)).collect();
    for (t, &cell) in clipped.triangles.iter().zip(&cells) {
        join(&mut forest, t, cell);
    }
    for wall in walls {
        for t in &wall.triangles {
            join(&mut forest, t, wall.low);
            join(&mut forest, t, wall.high());
        }
    }
    let mut number: HashMap<u32, u32> = HashMap::new();
    let mut parts: Vec<Part> = Vec::new();
    let mut part = |forest: &mut Forest, v: u32, cell: [i32; 3]| {
        *number.entry(forest.find(slot(v, cell))).or_insert_with(|| {
            parts.push(Part { cell, volume: 0.0, moment: DVec3::ZERO });
            parts.len() as u32 - 1
        })
    };
    let of_triangle: Vec<u32> =
        clipped.triangles.iter().zip(&cells).map(|(t, &cell)| part(&mut forest, t[0], cell)).collect();
    let of_wall: Vec<[u32; 2]> =
        walls.iter().map(|w| [w.low, w.high()].map(|cell| part(&mut forest, w.triangles[0][0], cell))).collect();
    // by the divergence theorem, about the middle of each cell
    let mut add = |p: u32, t: [u32; 3], sign: f64| {
        let part = &mut parts[p as usize];
        let middle = grid.origin + (DVec3::from_array(part.cell.map(f64::from)) + 0.5) * grid.size;
        let [a, b, c] = t.map(|v| points.x[v as usize] - middle);
        let volume = sign * a.dot(b.cross(c)) / 6.0;
        part.volume += volume;
        part.moment += volume * (middle + (a + b + c) / 4.0);
    };
    for (&t, &p) in clipped.triangles.iter().zip(&of_triangle) {
        add(p, t, 1.0);
    }
    for (wall, &[low, high]) in walls.iter().zip(&of_wall) {
        for &t in &wall.triangles {
            add(low, t, 1.0);
            add(high, t, -1.0);
        }
    }
    (parts, of_triangle, of_wall)
}

/// A closed surface within a cell that encloses less than nothing is a cavity: it bounds the largest part of its cell.
fn fill_cavities(parts: &mut [Part], of_triangle: &mut [u32]) {
    let mut largest: HashMap<[i32; 3], u32> = HashMap::new();
    for (p, part) in parts.iter().enumerate() {
        let best = largest.entry(part.cell).or_insert(p as u32);
        if part.volume > parts[*best as usize].volume {
            *best = p as u32;
        }
    }
    let home = |p: u32| if parts[p as usize].volume < 0.0 { largest[&parts[p as usize].cell] } else { p };
    let homes: Vec<u32> = (0..parts.len() as u32).map(home).collect();
    of_triangle.iter_mut().for_each(|p| *p = homes[*p as usize]);
    for p in 0..parts.len() {
        if homes[p] as usize != p {
            let Part { volume, moment, .. } = parts[p];
            let to = &mut parts[homes[p] as usize];
            (to.volume, to.moment) = (to.volume + volume, to.moment + moment);
            (parts[p].volume, parts[p].moment) = (0.0, DVec3::ZERO);
        }
    }
}

/// The part that each part goes to, itself if it is kept, and how many had to go because their cell is taken. `sides` are
/// pairs of parts with the area between them, `full` [m³] the volume of a cell.
fn gather(parts: &[Part], sides: &[(u32, u32, f64)], full: f64) -> (Vec<u32>, usize) {
    let n = parts.len();
    let mut next_to: Vec<BTreeMap<u32, f64>> = vec![BTreeMap::new(); n];
    let mut component = Forest::new(n);
    for &(a, b, area) in sides.iter().filter(|(a, b, _)| a != b) {
        *next_to[a as usize].entry(b).or_default() += area;
        *next_to[b as usize].entry(a).or_default() += area;
        component.join(a, b);
    }
    let component: Vec<u32> = (0..n as u32).map(|p| component.find(p)).collect();
    let mut largest: HashMap<([i32; 3], u32), u32> = HashMap::new();
    let mut heart: HashMap<u32, u32> = HashMap::new();
    for p in 0..n as u32 {
        let larger = |best: u32| parts[p as usize].volume > parts[best as usize].volume;
        let best = largest.entry((parts[p as usize].cell, component[p as usize])).or_insert(p);
        *best = if larger(*best) { p } else { *best };
        let best = heart.entry(component[p as usize]).or_insert(p);
        *best = if larger(*best) { p } else { *best };
    }
    let crowded_out = |p: usize| largest[&(parts[p].cell, component[p])] as usize != p;
    let is_heart = |p: usize| heart[&component[p]] as usize == p;
    let small = |p: usize| parts[p].volume < SLIVER * full && !is_heart(p);
    let near = |a: usize, b: usize| (0..3).all(|i| (parts[a].cell[i] - parts[b].cell[i]).abs() <= 1);
    let by_area = |p: usize, fits: &dyn Fn(usize) -> bool| {
        let fitting = next_to[p].iter().filter(|(q, _)| fits(**q as usize));
        fitting.max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0))).map(|(q, _)| *q)
    };
    let mut into: Vec<u32> = (0..n as u32).collect();
    let mut lost: Vec<usize> = Vec::new();
    let mut crowded = 0;
    for p in 0..n {
        if crowded_out(p) {
            crowded += usize::from(parts[p].volume >= SLIVER * full);
            into[p] = u32::MAX;
            lost.push(p);
        } else if small(p) {
            let keeps_links = |q: usize| next_to[p].keys().all(|&r| near(q, r as usize));
            let fits = |q: usize| !small(q) && !crowded_out(q) && keeps_links(q);
            into[p] = by_area(p, &fits).unwrap_or(p as u32);
        }
    }
    // outwards from what is kept: there is some in every component
    while !lost.is_empty() {
        let found: Vec<(usize, Option<u32>)> =
            lost.iter().map(|&p| (p, by_area(p, &|q| into[q] != u32::MAX))).collect();
        for &(p, to) in &found {
            into[p] = to.map_or(u32::MAX, |q| into[q as usize]);
        }
        lost = found.into_iter().filter(|(_, to)| to.is_none()).map(|(p, _)| p).collect();
    }
    (into, crowded)
}

/// Cell indices of the kept parts: where they lie, or for components that would have to share a cell in a block of their own.
fn indices(parts: &[Part], into: &[u32], sides: &[(u32, u32, f64)]) -> Vec<[u32; 3]> {
    let mut component = Forest::new(parts.len());
    sides.iter().for_each(|&(a, b, _)| component.join(a, b));
    let mut members: BTreeMap<u32, (f64, Vec<u32>)> = BTreeMap::new();
    for p in 0..parts.len() as u32 {
        if into[p as usize] == p {
            let entry = members.entry(component.find(p)).or_default();
            entry.0 += parts[p as usize].volume;
            entry.1.push(p);
        }
    }
    let mut components: Vec<(f64, Vec<u32>)> = members.into_values().collect();
    components.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut index = vec![[0; 3]; parts.len()];
    let mut taken: HashMap<[i64; 3], ()> = HashMap::new();
    let longest = parts.iter().map(|p| i64::from(p.cell[0]) + 2).max().unwrap_or(0);
    let block = BLOCK.max(longest.unsigned_abs().next_power_of_two() as i64);
    let mut end = 0;
    for (_, members) in components {
        let cell = |p: u32, shift: i64| {
            let [x, y, z] = parts[p as usize].cell.map(i64::from);
            [x + shift, y, z]
        };
        let shift =
            if members.iter().any(|&p| taken.contains_key(&cell(p, 0))) { (end / block + 1) * block } else { 0 };
        for &p in &members {
            let at = cell(p, shift);
            end = end.max(at[0]);
            taken.insert(at, ());
            index[p as usize] = at.map(|x| x as u32);
        }
    }
    index
}

/// Link bits: to cells across walls, and to those around an edge or corner that walls lead to within the block of two by
/// two, or two by two by two, cells that both are in.
fn links(index: &[[u32; 3]], of_wall: &[[u32; 2]]) -> Vec<u32> {
    let mut pairs: Vec<(u32, u32)> =
        of_wall.iter().filter(|[a, b]| a != b).flat_map(|&[a, b]| [(a, b), (b, a)]).collect();
    pairs.par_sort_unstable();
    pairs.dedup();
    let mut offsets = vec![0usize; index.len() + 1];
    pairs.iter().for_each(|&(a, _)| offsets[a as usize + 1] += 1);
    (0..index.len()).for_each(|k| offsets[k + 1] += offsets[k]);
    let next = |p: u32| pairs[offsets[p as usize]..offsets[p as usize + 1]].iter().map(|&(_, q)| q);
    let step = |a: u32, b: u32| -> [i64; 3] {
        std::array::from_fn(|i| i64::from(index[b as usize][i]) - i64::from(index[a as usize][i]))
    };
    // of a way that ends at `to`, all stops lie in the block between both ends
    let within = |stop: [i64; 3], to: [i64; 3]| (0..3).all(|i| stop[i] == 0 || stop[i] == to[i]);
    let bit = |to: [i64; 3]| NEIGHBOURS.iter().position(|n| n.map(i64::from) == to).map_or(0, |k| 1u32 << k);
    (0..index.len() as u32)
        .into_par_iter()
        .map(|a| {
            let mut bits = 0;
            for b in next(a) {
                let first = step(a, b);
                bits |= bit(first);
                for c in next(b) {
                    let second = step(a, c);
                    if within(first, second) {
                        bits |= bit(second);
                    }
                    for d in next(c) {
                        let third = step(a, d);
                        if within(first, third) && within(second, third) {
                            bits |= bit(third);
                        }
                    }
                }
            }
            bits
        })
        .collect()
}
