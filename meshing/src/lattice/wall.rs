//! The faces between cells, as far as they lie in the body.
//!
//! Where the cut surface meets a plane of the grid it leaves directed edges, and where it meets two planes it leaves
//! points, at which their common line enters the body or leaves it. The parts of lines within the body and those edges close
//! to loops in every square of every plane; what they enclose is the face between two cells, fitted to the surface without
//! error (the paper's marching squares put straight lines there).
//!
//! Edges that run from grid line to grid line, or from corner to corner, have a point in their middle, and faces one within.
//! So every edge of the whole complex has an end around which there are just the pieces that are around the edge, and a
//! crack that parts these parts the edge: that is what keeps cracked surfaces closed with two triangles at every edge.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::clip::{Clipped, FREE, Points};
use super::grid::Grid;
use super::polygon::triangulate;
use super::split::split_edges;

/// The surface meets itself so closely that inside and outside cannot be told at this place [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tangled(pub DVec3);

/// A face between two cells.
#[derive(Clone, Debug)]
pub(super) struct Wall {
    /// The axis that it stands across.
    pub axis: usize,
    /// The cell on its low side.
    pub low: [i32; 3],
    /// Counter-clockwise as seen from the high side.
    pub triangles: Vec<[u32; 3]>,
}

impl Wall {
    /// The cell on its high side.
    pub fn high(&self) -> [i32; 3] {
        let mut cell = self.low;
        cell[self.axis] += 1;
        cell
    }
}

/// A directed part of the border of what lies in the body in one square, the body on its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Segment {
    square: Square,
    from: u32,
    to: u32,
}

/// A square of a plane: axis, number of the plane, and the cell along the two axes that follow.
type Square = (u8, i32, i32, i32);

/// All walls, in the order of their squares. Points that they need are added to the clipped ones.
pub(super) fn walls(clipped: &mut Clipped, grid: Grid) -> Result<Vec<Wall>, Tangled> {
    let mut segments = surface_segments(clipped);
    let points = &mut clipped.points;
    line_segments(points, grid, &mut segments)?;
    segments.par_sort_unstable();
    let squares: Vec<&[Segment]> = segments.chunk_by(|a, b| a.square == b.square).collect();
    let traced: Vec<Result<Vec<Region>, Tangled>> = squares.par_iter().map(|s| regions(points, grid, s)).collect();
    let mut walls = Vec::new();
    for region in traced {
        for mut region in region? {
            let first = points.x.len() as u32;
            for (x, u) in region.new {
                let mut on = [FREE; 3];
                on[region.wall.axis] = u[region.wall.axis] as i32;
                points.push(x, u, on);
            }
            for v in region.wall.triangles.iter_mut().flatten().filter(|v| **v >= NEW) {
                *v = *v - NEW + first;
            }
            walls.push(region.wall);
        }
    }
    Ok(walls)
}

/// Where triangles end at planes, once for each edge, from the triangle below.
fn surface_segments(clipped: &Clipped) -> Vec<Segment> {
    let points = &clipped.points;
    let mut segments = Vec::new();
    for (t, corners) in clipped.triangles.iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            for axis in 0..3 {
                let k = points.on[a as usize][axis];
                if k == FREE || k != points.on[b as usize][axis] {
                    continue;
                }
                let cell = clipped.cell(t);
                if cell[axis] < k {
                    let square = (axis as u8, k, cell[(axis + 1) % 3], cell[(axis + 2) % 3]);
                    segments.push(Segment { square, from: b, to: a });
                }
            }
        }
    }
    segments
}

/// A point of the surface on a grid line, along which the body begins or ends there.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    /// The axis of the line and its places along the two that follow.
    line: (u8, i32, i32),
    along: f64,
    enters: bool,
    point: u32,
}

/// Adds the parts of grid lines within the body; and the corners of cells and the middles of whole edges to the points.
fn line_segments(points: &mut Points, grid: Grid, segments: &mut Vec<Segment>) -> Result<(), Tangled> {
    let mut crossings = crossings(points, segments)?;
    // lines along z first: they make the corners
    crossings.par_sort_unstable_by(|a, b| {
        (std::cmp::Reverse(a.line.0), a.line.1, a.line.2)
            .cmp(&(std::cmp::Reverse(b.line.0), b.line.1, b.line.2))
            .then(a.along.total_cmp(&b.along))
            .then(a.point.cmp(&b.point))
    });
    let mut corners: HashMap<[i32; 3], u32> = HashMap::new();
    let mut met = [0usize; 3];
    for line in crossings.chunk_by_mut(|a, b| a.line == b.line) {
        alternate(line).map_err(|point| Tangled(points.x[point as usize]))?;
        for pair in line.chunks_exact(2) {
            let (axis, first, second) = (usize::from(pair[0].line.0), pair[0].line.1, pair[0].line.2);
            let at = |m: i32| {
                let mut corner = [0; 3];
                (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (m, first, second);
                corner
            };
            let (mut from, mut from_corner) = (pair[0].point, false);
            let start = pair[0].along.floor() as i32;
            for m in start..=pair[1].along.floor() as i32 {
                let last = m == pair[1].along.floor() as i32;
                let to = if last {
                    pair[1].point
                } else {
                    let on = at(m + 1);
                    let u = DVec3::from_array(on.map(f64::from));
                    met[axis] += 1;
                    match corners.get(&on) {
                        Some(&corner) => corner,
                        None if axis == 2 => {
                            let corner = points.push(grid.place(u), u, on);
                            corners.insert(on, corner);
                            corner
                        }
                        None => return Err(Tangled(grid.place(u))),
                    }
                };
                let mut run = vec![from, to];
                if from_corner && !last {
                    let mut on = at(m);
                    on[axis] = FREE;
                    let u = (points.u[from as usize] + points.u[to as usize]) / 2.0;
                    run.insert(1, points.push(grid.place(u), u, on));
                }
                around(axis, at(m), &run, segments);
                (from, from_corner) = (to, !last);
            }
        }
    }
    if met != [corners.len(); 3] {
        let somewhere = crossings.first().map_or(DVec3::ZERO, |c| points.x[c.point as usize]);
        return Err(Tangled(somewhere));
    }
    Ok(())
}

/// The four squares around an edge along `axis` that begins at `corner`; `run` are its points upwards.
fn around(axis: usize, corner: [i32; 3], run: &[u32], segments: &mut Vec<Segment>) {
    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut add = |square: Square, up: bool| {
        for pair in run.windows(2) {
            let (from, to) = if up { (pair[0], pair[1]) } else { (pair[1], pair[0]) };
            segments.push(Segment { square, from, to });
        }
    };
    // in a plane across b the edge runs along the second axis: down at the left, up at the right
    add((b as u8, corner[b], corner[c], corner[axis]), false);
    add((b as u8, corner[b], corner[c] - 1, corner[axis]), true);
    // in a plane across c along the first: up at the bottom, down at the top
    add((c as u8, corner[c], corner[axis], corner[b]), true);
    add((c as u8, corner[c], corner[axis], corner[b] - 1), false);
}

/// Which points lie on grid lines, and whether their line enters the body there: both planes of the line must say the same.
fn crossings(points: &Points, segments: &[Segment]) -> Result<Vec<Crossing>, Tangled> {
    const NEITHER: u8 = 2;
    let mut said = vec![[NEITHER; 2]; points.x.len()];
    for s in segments {
        let on = points.on[s.from as usize];
        let axis = usize::from(s.square.0);
        for (step, other) in [(axis + 1) % 3, (axis + 2) % 3].into_iter().enumerate() {
            if on[other] == FREE {
                continue;
            }
            let up = points.u[s.to as usize][other] > f64::from(on[other]);
            // the body is on the left of the segment: seen along the other axis, above it if that axis comes second
            let enters = up == (step == 0);
            said[s.from as usize][step] = u8::from(enters);
        }
    }
    let mut out = Vec::new();
    for (v, on) in points.on.iter().enumerate() {
        if points.planes(v as u32) != 2 {
            continue;
        }
        let axis = on.iter().position(|&k| k == FREE).unwrap_or(0);
        let [one, two] = said[v];
        if one != two || one == NEITHER {
            return Err(Tangled(points.x[v]));
        }
        out.push(Crossing {
            line: (axis as u8, on[(axis + 1) % 3], on[(axis + 2) % 3]),
            along: points.u[v][axis],
            enters: one == 1,
            point: v as u32,
        });
    }
    Ok(out)
}

/// Puts the crossings of one line into an order in which it enters and leaves in turn: rounding may have swapped two that lie
/// as close as it reaches. The error is a point where that cannot be.
fn alternate(line: &mut [Crossing]) -> Result<(), u32> {
    for k in 0..line.len() {
        let wanted = k % 2 == 0;
        let found = line[k..].iter().position(|c| c.enters == wanted).ok_or(line[k].point)?;
        if line[k + found].along - line[k].along > 1e-6 {
            return Err(line[k].point);
        }
        line[k..=k + found].rotate_right(1);
    }
    if line.len() % 2 == 1 { Err(line[0].point) } else { Ok(()) }
}

/// Numbers of points that are still to be made begin here.
const NEW: u32 = 1 << 31;

/// A wall with the points that it adds.
struct Region {
    wall: Wall,
    new: Vec<(DVec3, DVec3)>,
}

/// What the segments of one square enclose.
fn regions(points: &Points, grid: Grid, segments: &[Segment]) -> Result<Vec<Region>, Tangled> {
    let (axis, plane, first, second) = segments[0].square;
    let axis = usize::from(axis);
    let flat = |u: DVec3| DVec2::new(u[(axis + 1) % 3], u[(axis + 2) % 3]);
    let at = |v: u32| flat(points.u[v as usize]);
    let mut loops = loops(segments).map_err(|v| Tangled(points.x[v as usize]))?;
    let doubled =
        |ring: &[u32]| (0..ring.len()).map(|k| at(ring[k]).perp_dot(at(ring[(k + 1) % ring.len()]))).sum::<f64>();
    loops.sort_by(|a, b| doubled(b).total_cmp(&doubled(a)));
    let mut shapes: Vec<(Vec<u32>, Vec<Vec<u32>>)> = Vec::new();
    for ring in loops {
        // the smallest that holds it, for they come sorted
        let holder = if doubled(&ring) < 0.0 {
            shapes.iter_mut().rev().find(|(outer, _)| holds(outer.iter().map(|&v| at(v)), at(ring[0])))
        } else {
            None
        };
        match holder {
            Some((_, holes)) => holes.push(ring),
            None => shapes.push((ring, Vec::new())),
        }
    }
    let mut low = [0; 3];
    (low[axis], low[(axis + 1) % 3], low[(axis + 2) % 3]) = (plane - 1, first, second);
    let region = |(outer, holes): (Vec<u32>, Vec<Vec<u32>>)| {
        let mut new = Vec::new();
        let mut add = |p: DVec2| {
            let mut u = DVec3::ZERO;
            (u[axis], u[(axis + 1) % 3], u[(axis + 2) % 3]) = (f64::from(plane), p.x, p.y);
            new.push((grid.place(u), u));
            NEW + new.len() as u32 - 1
        };
        let triangles = match centre(&outer, &holes, at) {
            Some(c) => {
                let c = add(c);
                (0..outer.len()).map(|k| [outer[k], outer[(k + 1) % outer.len()], c]).collect()
            }
            None => eared(points, &outer, &holes, at, &mut add),
        };
        Region { wall: Wall { axis, low, triangles }, new }
    };
    Ok(shapes.into_iter().map(region).collect())
}

/// Follows segments, sorted by where they begin, to closed loops; the error is a point where one ends.
fn loops(segments: &[Segment]) -> Result<Vec<Vec<u32>>, u32> {
    let mut used = vec![false; segments.len()];
    let mut loops = Vec::new();
    for first in 0..segments.len() {
        let (mut ring, mut at) = (Vec::new(), first);
        while !used[at] {
            used[at] = true;
            ring.push(segments[at].from);
            let to = segments[at].to;
            at = segments.binary_search_by_key(&to, |s| s.from).map_err(|_| to)?;
        }
        if !ring.is_empty() {
            if at != first {
                return Err(segments[at].from);
            }
            loops.push(ring);
        }
    }
    Ok(loops)
}

/// Whether a ring winds around `p`, by crossings of a ray to the right.
fn holds(ring: impl Iterator<Item = DVec2> + Clone, p: DVec2) -> bool {
    let next = ring.clone().cycle().skip(1);
    ring.zip(next)
        .filter(|(a, b)| (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y))
        .count()
        % 2
        == 1
}

/// A point from which the whole polygon is seen well, if its centre is one.
fn centre(outer: &[u32], holes: &[Vec<u32>], at: impl Fn(u32) -> DVec2) -> Option<DVec2> {
    /// Least share of the mean triangle around the centre.
    const LEAST: f64 = 0.02;
    let n = outer.len();
    if n < 3 || !holes.is_empty() {
        return None;
    }
    let start = at(outer[0]);
    let (mut area, mut moment) = (0.0, DVec2::ZERO);
    for k in 1..n - 1 {
        let (a, b) = (at(outer[k]) - start, at(outer[k + 1]) - start);
        let doubled = a.perp_dot(b);
        area += doubled;
        moment += (a + b) / 3.0 * doubled;
    }
    let c = start + moment / area;
    let seen = |k: usize| {
        let (a, b) = (at(outer[k]), at(outer[(k + 1) % n]));
        // a short side makes a small triangle without being badly seen
        (a - c).perp_dot(b - c) > LEAST * area.sqrt() * a.distance(b)
    };
    (area > 0.0 && c.is_finite() && (0..n).all(seen)).then_some(c)
}

/// Ears, and a point in the middle of inner edges from grid line to grid line.
fn eared(
    points: &Points,
    outer: &[u32],
    holes: &[Vec<u32>],
    at: impl Fn(u32) -> DVec2,
    add: &mut impl FnMut(DVec2) -> u32,
) -> Vec<[u32; 3]> {
    let rings = || std::iter::once(outer).chain(holes.iter().map(Vec::as_slice));
    let all: Vec<u32> = rings().flatten().copied().collect();
    let places: Vec<DVec2> = all.iter().map(|&v| at(v)).collect();
    let mut next = 0;
    let mut local = |ring: &[u32]| {
        next += ring.len() as u32;
        (next - ring.len() as u32..next).collect::<Vec<u32>>()
    };
    let (outer_local, holes_local) = (local(outer), holes.iter().map(|h| local(h)).collect::<Vec<_>>());
    let triangles = triangulate(&places, &outer_local, &holes_local);
    let side = |a: u32, b: u32| {
        let ring = if a < outer.len() as u32 {
            &outer_local
        } else {
            holes_local.iter().find(|h| h.contains(&a)).unwrap_or(&outer_local)
        };
        let n = ring.len() as u32;
        b >= ring[0] && b < ring[0] + n && (a.abs_diff(b) == 1 || a.abs_diff(b) == n - 1)
    };
    let mut middles = Vec::new();
    let halve = |a: u32, b: u32| {
        let spans = [a, b].iter().all(|&v| points.planes(all[v as usize]) > 1) && !side(a, b);
        spans.then(|| {
            middles.push(add((places[a as usize] + places[b as usize]) / 2.0));
            (all.len() + middles.len()) as u32 - 1
        })
    };
    let split = split_edges(&triangles, halve, |_, _, _, _| true);
    let global = |v: u32| all.get(v as usize).copied().unwrap_or_else(|| middles[v as usize - all.len()]);
    split.iter().map(|(t, _)| t.map(global)).collect()
}
