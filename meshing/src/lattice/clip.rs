//! The surface cut at the faces of the cells.
//!
//! Triangles are cut plane by plane into triangles, one axis after the other, and a point on an edge is made once for both
//! triangles on it: what comes out is closed as what went in, whatever rounding does. No vertex of the input lies on a
//! plane; one that would is moved by [`OFF`] of a cell, in cell coordinates alone, its place stays. So which side a vertex
//! is on is never in doubt, and which planes a vertex lies on is known, not measured.

use std::cell::RefCell;
use std::collections::HashMap;

use glam::DVec3;

use super::grid::Grid;
use super::split::split_edges;
use crate::TriMesh;

/// Not on a plane of this axis.
pub(super) const FREE: i32 = i32::MIN;
/// Vertices keep this far off planes that they were not made on, in cells.
const OFF: f64 = 1e-9;

/// Points in the body and where they are among the cells.
#[derive(Clone, Debug, Default)]
pub(super) struct Points {
    /// Places [m].
    pub x: Vec<DVec3>,
    /// Cell coordinates.
    pub u: Vec<DVec3>,
    /// For each axis the plane that the point lies on, or [`FREE`].
    pub on: Vec<[i32; 3]>,
}

impl Points {
    pub fn push(&mut self, x: DVec3, u: DVec3, on: [i32; 3]) -> u32 {
        self.x.push(x);
        self.u.push(u);
        self.on.push(on);
        self.x.len() as u32 - 1
    }

    /// On how many planes point `v` lies.
    pub fn planes(&self, v: u32) -> usize {
        self.on[v as usize].iter().filter(|&&k| k != FREE).count()
    }

    /// The planes that two points share.
    fn common(&self, a: u32, b: u32) -> [i32; 3] {
        let (a, b) = (self.on[a as usize], self.on[b as usize]);
        std::array::from_fn(|i| if a[i] == b[i] { a[i] } else { FREE })
    }

    /// A new point at share `t` of the way from `a` to `b`; on plane `k` of an axis, if one is given, beside those that both share.
    fn between(&mut self, a: u32, b: u32, t: f64, plane: Option<(usize, i32)>) -> u32 {
        let mut on = self.common(a, b);
        let (from, to) = (self.u[a as usize], self.u[b as usize]);
        let mut u = from.lerp(to, t);
        if let Some((axis, k)) = plane {
            on[axis] = k;
        }
        for i in 0..3 {
            u[i] = if on[i] != FREE { f64::from(on[i]) } else { off_planes(u[i], 0.5 * (from[i] + to[i])) };
        }
        let x = self.x[a as usize].lerp(self.x[b as usize], t);
        self.push(x, u, on)
    }
}

/// `u`, or a place beside the plane that it is on, towards `inner`.
fn off_planes(u: f64, inner: f64) -> f64 {
    let plane = u.round();
    if (u - plane).abs() >= OFF {
        u
    } else if inner < plane {
        plane - OFF
    } else {
        plane + OFF
    }
}

/// A surface whose triangles each lie in one cell.
#[derive(Clone, Debug, Default)]
pub(super) struct Clipped {
    pub points: Points,
    /// Outwards.
    pub triangles: Vec<[u32; 3]>,
    /// The triangle of the input that each is a part of.
    pub parent: Vec<u32>,
}

impl Clipped {
    /// Cuts `surface`, which is closed. Edges are no longer than `longest` [m] afterwards.
    pub fn new(surface: &TriMesh, grid: Grid, longest: f64) -> Self {
        let (x, triangles, parent) = refined(surface, longest);
        let inward = inward(&x, &triangles);
        let mut points = Points::default();
        for (x, inward) in x.iter().zip(inward) {
            let u = grid.to_cells(*x);
            let u = DVec3::from_array(std::array::from_fn(|i| off_planes(u[i], u[i] + inward[i])));
            points.push(*x, u, [FREE; 3]);
        }
        let mut clipped = Self { points, triangles, parent };
        (0..3).for_each(|axis| clipped.cut(axis));
        clipped.halve_spans();
        clipped
    }

    /// The cell of triangle `t`.
    pub fn cell(&self, t: usize) -> [i32; 3] {
        let [a, b, c] = self.triangles[t].map(|v| self.points.u[v as usize]);
        // no triangle has all corners on one plane, so the mean is off all of them
        ((a + b + c) / 3.0).floor().as_ivec3().to_array()
    }

    /// Cuts at all planes of one axis.
    fn cut(&mut self, axis: usize) {
        let (mut triangles, mut parent) = (Vec::new(), Vec::new());
        let (points, mut made) = (&mut self.points, HashMap::new());
        let mut stack = Vec::new();
        for (t, &of) in std::mem::take(&mut self.triangles).into_iter().zip(&self.parent) {
            stack.push(t);
            while let Some(t) = stack.pop() {
                let along = t.map(|v| points.u[v as usize][axis]);
                let (low, high) = (along[0].min(along[1]).min(along[2]), along[0].max(along[1]).max(along[2]));
                let k = low.floor() as i32 + 1;
                if f64::from(k) >= high {
                    triangles.push(t);
                    parent.push(of);
                    continue;
                }
                let above = along.map(|u| u > f64::from(k));
                if let Some(i) = t.iter().position(|&v| points.on[v as usize][axis] == k) {
                    let (z, b, c) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
                    let p = cross(points, &mut made, (axis, k), b, c);
                    stack.extend([[z, b, p], [z, p, c]]);
                } else {
                    // the corner that is alone on its side
                    let i = (0..3).find(|&i| above[(i + 1) % 3] == above[(i + 2) % 3]).unwrap_or(0);
                    let (a, b, c) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
                    let (p, q) = (cross(points, &mut made, (axis, k), a, b), cross(points, &mut made, (axis, k), a, c));
                    stack.push([a, p, q]);
                    if shorter(&points.x, p, c, b, q) {
                        stack.extend([[p, b, c], [p, c, q]]);
                    } else {
                        stack.extend([[p, b, q], [b, c, q]]);
                    }
                }
            }
        }
        (self.triangles, self.parent) = (triangles, parent);
    }

    /// Puts a point on each edge that runs across a face from side to side: only there do two pieces alone meet.
    fn halve_spans(&mut self) {
        let points = RefCell::new(&mut self.points);
        let halve = |a: u32, b: u32| {
            let mut points = points.borrow_mut();
            let spans = points.planes(a) > 1 && points.planes(b) > 1 && points.common(a, b) != [FREE; 3];
            spans.then(|| points.between(a, b, 0.5, None))
        };
        let split = split_edges(&self.triangles, halve, |a, b, c, d| shorter(&points.borrow().x, a, b, c, d));
        self.parent = split.iter().map(|&(_, old)| self.parent[old as usize]).collect();
        self.triangles = split.into_iter().map(|(t, _)| t).collect();
    }
}

/// The point on edge a–b and plane `k` of `axis`, made when it is first asked for.
fn cross(
    points: &mut Points,
    made: &mut HashMap<(u32, u32, i32), u32>,
    (axis, k): (usize, i32),
    a: u32,
    b: u32,
) -> u32 {
    let (a, b) = (a.min(b), a.max(b));
    *made.entry((a, b, k)).or_insert_with(|| {
        let (from, to) = (points.u[a as usize][axis], points.u[b as usize][axis]);
        points.between(a, b, (f64::from(k) - from) / (to - from), Some((axis, k)))
    })
}

fn shorter(x: &[DVec3], a: u32, b: u32, c: u32, d: u32) -> bool {
    let squared = |a: u32, b: u32| x[a as usize].distance_squared(x[b as usize]);
    squared(a, b) <= squared(c, d)
}

/// Halves edges until none is longer than `longest` [m]; the parent of each triangle with it.
fn refined(surface: &TriMesh, longest: f64) -> (Vec<DVec3>, Vec<[u32; 3]>, Vec<u32>) {
    let mut x = surface.vertices.clone();
    let mut triangles = surface.triangles.clone();
    let mut parent: Vec<u32> = (0..triangles.len() as u32).collect();
    loop {
        let before = x.len();
        let places = RefCell::new(&mut x);
        let halve = |a: u32, b: u32| {
            let mut x = places.borrow_mut();
            let (p, q) = (x[a as usize], x[b as usize]);
            (p.distance(q) > longest).then(|| {
                x.push((p + q) / 2.0);
                x.len() as u32 - 1
            })
        };
        let split = split_edges(&triangles, halve, |a, b, c, d| shorter(&places.borrow(), a, b, c, d));
        if x.len() == before {
            return (x, triangles, parent);
        }
        parent = split.iter().map(|&(_, old)| parent[old as usize]).collect();
        triangles = split.into_iter().map(|(t, _)| t).collect();
    }
}

/// A direction into the body at each vertex, of length 1 or 0.
fn inward(x: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut inward = vec![DVec3::ZERO; x.len()];
    for t in triangles {
        let [a, b, c] = t.map(|v| x[v as usize]);
        let normal = (b - a).cross(c - a);
        t.iter().for_each(|&v| inward[v as usize] -= normal);
    }
    inward.into_iter().map(DVec3::normalize_or_zero).collect()
}
