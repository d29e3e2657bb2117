//! Bodies that are put into each other by mistake.

use glam::DVec3;

use super::grid::Grid;
use crate::world::World;

/// Two particles of different bodies nearer than this share of the sum of their radii are in one place: those of two bodies
/// that only lie against each other are not.
const SAME: f64 = 0.25;

/// Two particles in one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Their bodies.
    pub bodies: [usize; 2],
    /// How deep one is in the other [m].
    pub depth: f64,
    /// Where [m].
    pub place: DVec3,
}

/// The deepest overlap of two bodies of `world`; `None` if they are apart or merely touch.
pub fn deepest(world: &World) -> Option<Overlap> {
    let p = &world.particles;
    let boxes = world.bodies.iter().map(|b| {
        let places = || p.position[b.range.clone()].iter();
        (places().fold(DVec3::INFINITY, |a, x| a.min(*x)), places().fold(DVec3::NEG_INFINITY, |a, x| a.max(*x)))
    });
    let boxes: Vec<(DVec3, DVec3)> = boxes.collect();
    let meets = |a: usize, b: usize| boxes[a].0.cmple(boxes[b].1).all() && boxes[b].0.cmple(boxes[a].1).all();
    let near = |b: &usize| (0..boxes.len()).any(|other| other != *b && meets(*b, other));
    let mut grid = Grid::default();
    let radius = |i: usize| super::radius(p.volume[i]);
    let of_body = |b: usize| world.bodies[b].range.clone().map(move |i| (b, i));
    let mut balls: Vec<(usize, usize)> = (0..boxes.len()).filter(near).flat_map(of_body).collect();
    grid.fit(balls.iter().map(|&(_, i)| radius(i)).sum::<f64>() / balls.len().max(1) as f64);
    balls.sort_by_cached_key(|&(_, i)| grid.key(p.position[i], radius(i)));
    let keys: Vec<u64> = balls.iter().map(|&(_, i)| grid.key(p.position[i], radius(i))).collect();
    grid.build(keys.into_iter(), |k| (p.position[balls[k].1], radius(balls[k].1)));
    let mut deepest: Option<Overlap> = None;
    for &(a, i) in &balls {
        grid.around(p.position[i], radius(i), |others| {
            for &(b, j) in &balls[others] {
                let (touch, apart) = (radius(i) + radius(j), p.position[i].distance(p.position[j]));
                if a < b && apart < SAME * touch && deepest.is_none_or(|d| d.depth < touch - apart) {
                    deepest = Some(Overlap { bodies: [a, b], depth: touch - apart, place: p.position[i] });
                }
            }
        });
    }
    deepest
}
