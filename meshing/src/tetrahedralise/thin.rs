//! Keeping thin parts: a vertex in the middle of every wall that the background would step over.
//!
//! A wall thinner than an element may lie between the background's vertices, and cutting then leaves holes in it. So
//! the middle of thin walls is found first (the largest ball inside that touches a surface point, by shrinking: Ma, Bae
//! and Choi 2012), and where no vertex is near, the nearest one is brought there and kept inside.

use super::complex::{Complex, angle_score, worst_from};
use super::refine::Sizing;
use super::solid::Solid;
use glam::{DVec3, IVec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Walls thinner than twice this many edges get vertices in the middle. Tried: 0.35 (holes in one-element walls) and 0.9
/// (needless short edges).
const THIN: f64 = 0.45;
/// Walls thinner than twice this many edges can't be kept with good angles.
const LOST: f64 = 0.12;
/// One middle vertex serves the wall this far around it, in edges.
const SERVED: f64 = 0.6;

/// A point in the middle of a wall and half the wall's thickness there [m].
#[derive(Clone, Copy, Debug)]
pub struct Middle {
    /// The point.
    pub at: DVec3,
    /// The radius of the ball around it that touches both sides.
    pub radius: f64,
}

/// Middles of walls whose background edges are too long for them, but not hopelessly so.
pub fn walls(solid: &dyn Solid, edge: f64, sizing: &Sizing) -> Vec<Middle> {
    let fits = |m: &Middle| (LOST..THIN).contains(&(m.radius / sizing.at(m.at)));
    middles(solid, edge, THIN * edge, 1.0).into_iter().filter(fits).collect()
}

/// Middles of walls (`side` = 1) or gaps (−1) no wider than `2 · limit` [m], sampled for background edges of length `edge`
/// [m].
pub fn middles(solid: &dyn Solid, edge: f64, limit: f64, side: f64) -> Vec<Middle> {
    let found = |(p, n): (DVec3, DVec3)| middle(solid, p, side * n, limit).filter(|m| m.radius > 0.25 * LOST * edge);
    solid.samples(0.4 * edge).into_par_iter().filter_map(found).collect()
}

/// Half the thickness [m] of thin walls within `size` of `place`: the lower quartile, since single points near an edge
/// may find nearly nothing.
pub fn thinnest(solid: &dyn Solid, place: DVec3, size: f64) -> Option<f64> {
    let near = |s: &(DVec3, DVec3)| s.0.distance(place) < size;
    let found = |(p, n)| middle(solid, p, n, size).map(|m| m.radius);
    let mut all: Vec<f64> = solid.samples(0.3 * size).into_iter().filter(near).filter_map(found).collect();
    all.sort_unstable_by(f64::total_cmp);
    all.get(all.len() / 4).copied()
}

/// Half the thickness [m] that at most half of the surface has, where walls thinner than `2 · size` are typical.
pub fn typical(solid: &dyn Solid, size: f64) -> Option<f64> {
    let radius = |(p, n)| middle(solid, p, n, size).map(|m| m.radius);
    let mut all: Vec<f64> = solid.samples(size).into_iter().filter_map(radius).collect();
    all.sort_unstable_by(f64::total_cmp);
    all.get(all.len() / 2).copied().filter(|r| *r > 0.0)
}

fn middle(solid: &dyn Solid, p: DVec3, n: DVec3, limit: f64) -> Option<Middle> {
    if n == DVec3::ZERO {
        return None;
    }
    let mut radius = limit;
    let mut touch = None;
    for _ in 0..30 {
        let centre = p - n * radius;
        let q = solid.project(centre);
        if q.distance(centre) > radius * 0.999 {
            break;
        }
        let across = p - q;
        let depth = n.dot(across);
        if depth <= 1e-9 * limit {
            return None;
        }
        radius = across.length_squared() / (2.0 * depth);
        touch = Some(q);
    }
    let centre = p - n * radius;
    // the two touching points must face each other; at a convex edge they stand at its opening angle, and right on one
    // the ball shrinks to nothing
    let facing = (p - centre).normalize_or_zero().dot((touch? - centre).normalize_or_zero());
    (facing < -0.5 && radius > 1e-3 * limit && radius < limit).then_some(Middle { at: centre, radius })
}

/// Brings background vertices into thin walls. Returns for each vertex whether it must stay inside.
pub fn occupy(walls: &[Middle], mesh: &mut Complex, phi: &mut [f64], edge: f64, sizing: &Sizing) -> Vec<bool> {
    let mut locked = vec![false; phi.len()];
    if walls.is_empty() {
        return locked;
    }
    let cell = |p: DVec3| (p / edge).floor().as_ivec3();
    let mut cells: HashMap<IVec3, Vec<u32>> = HashMap::new();
    for v in (0..phi.len() as u32).filter(|&v| phi[v as usize].abs() < 1.5 * edge) {
        cells.entry(cell(mesh.points[v as usize])).or_default().push(v);
    }
    for wall in walls {
        let local = sizing.at(wall.at);
        let mut near: Vec<(f64, u32)> = Vec::new();
        for k in 0..27 {
            let c = cell(wall.at) + IVec3::new(k % 3, k / 3 % 3, k / 9) - 1;
            near.extend(cells.get(&c).into_iter().flatten().map(|&v| (mesh.points[v as usize].distance(wall.at), v)));
        }
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        if near.iter().any(|&(d, v)| d < SERVED * local && locked[v as usize]) {
            continue;
        }
        // a vertex that is deep enough already only has to stay
        let deep = near.iter().find(|&&(d, v)| d < SERVED * local && -phi[v as usize] > 0.5 * wall.radius);
        if let Some(&(_, v)) = deep {
            locked[v as usize] = true;
            continue;
        }
        for &(d, v) in near.iter().filter(|n| !locked[n.1 as usize]).take(4) {
            let view = mesh.view(v);
            let floor = angle_score(6.0);
            let place = [1.0, 0.75].map(|part| mesh.points[v as usize].lerp(wall.at, part)).into_iter().find(|&p| {
                d < 0.9 * local && p.distance(wall.at) < 0.5 * wall.radius && worst_from(p, &view, floor) > floor
            });
            if let Some(p) = place {
                mesh.points[v as usize] = p;
                phi[v as usize] = -(wall.radius - p.distance(wall.at));
                locked[v as usize] = true;
                break;
            }
        }
    }
    locked
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tetrahedralise::{Inside, bodies};

    #[test]
    fn the_middle_of_a_wall_is_found() {
        let wall = bodies::cuboid(DVec3::ZERO, DVec3::new(1.0, 1.0, 0.05));
        let solid = Inside::new(&wall, 0.1);
        let sizing = |edge| Sizing::new(&solid, edge, 1.0);
        let found = walls(&solid, 0.1, &sizing(0.1));
        assert!(found.len() > 400, "{}", found.len()); // measured 2,600
        for wall in found {
            assert!((wall.radius - 0.025).abs() < 1e-9 && (wall.at.z - 0.025).abs() < 1e-9);
        }
        assert_eq!(walls(&solid, 0.01, &sizing(0.01)).len(), 0);
        assert!((thinnest(&solid, DVec3::new(0.5, 0.5, 0.0), 0.1).unwrap() - 0.025).abs() < 1e-9);
    }
}
