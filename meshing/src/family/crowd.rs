//! Rows for many particles at once: a run of particles that lie together asks the tree a single question, and each then
//! takes its own out of the answer.

use std::ops::Range;

use glam::DVec3;

use super::MARGIN;
use super::near::{Tree, visit_ball};

/// A run ends before its box gets longer than this share of the horizon, or it has [`MOST`] particles.
const EDGE: f64 = 1.25;
const MOST: usize = 64;

/// Runs of consecutive particles whose boxes are small beside the horizon. Particles in no order get one each.
pub(super) fn runs(points: &[DVec3], horizon: f64) -> Vec<Range<usize>> {
    let (mut all, mut start) = (Vec::new(), 0);
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (i, &p) in points.iter().enumerate() {
        let (l, h) = (low.min(p), high.max(p));
        if i > start && ((h - l).max_element() > EDGE * horizon || i - start == MOST) {
            all.push(start..i);
            (start, low, high) = (i, p, p);
        } else {
            (low, high) = (l, h);
        }
    }
    all.push(start..points.len());
    all
}

/// Everybody who may be near somebody of a run, with their places.
#[derive(Default)]
pub(super) struct Crowd {
    numbers: Vec<u32>,
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    row: Vec<u32>,
}

impl Crowd {
    /// The crowd around `run`, by number if it is `sorted`.
    pub(super) fn gather(&mut self, tree: &Tree, points: &[DVec3], run: Range<usize>, horizon: f64, sorted: bool) {
        let (mut low, mut high) = (points[run.start], points[run.start]);
        for &p in &points[run] {
            (low, high) = (low.min(p), high.max(p));
        }
        let (middle, reach) = ((low + high) / 2.0, horizon * horizon * (1.0 + MARGIN));
        self.numbers.clear();
        visit_ball(tree, middle, horizon + low.distance(high) / 2.0, |j, _| {
            let p = points[j as usize];
            if p.distance_squared(p.clamp(low, high)) <= reach {
                self.numbers.push(j);
            }
        });
        if sorted {
            self.numbers.sort_unstable();
        }
        for (axis, column) in [&mut self.x, &mut self.y, &mut self.z].into_iter().enumerate() {
            column.clear();
            column.extend(self.numbers.iter().map(|&j| points[j as usize][axis]));
        }
    }

    /// Which of the crowd lie within the horizon of `p`, itself too if it is one of them. The sum of squares has the same
    /// bits from both ends of a bond, so rows are symmetric.
    fn within(&self, p: DVec3, squared: f64) -> impl Iterator<Item = bool> {
        let places = self.x.iter().zip(&self.y).zip(&self.z);
        places.map(move |((&x, &y), &z)| DVec3::new(x, y, z).distance_squared(p) <= squared)
    }

    /// How many lie within the horizon of a member at `p`, itself left out.
    pub(super) fn count(&self, p: DVec3, horizon: f64) -> u32 {
        self.within(p, horizon * horizon).map(u32::from).sum::<u32>() - 1
    }

    /// Writes the row of particle `i` at `p`, which is as long as [`count`](Self::count) said. No branch depends on who
    /// is near: it would be guessed wrong for every third of the crowd.
    pub(super) fn fill(&mut self, i: usize, p: DVec3, horizon: f64, row: &mut [u32]) {
        let mut buffer = std::mem::take(&mut self.row);
        buffer.resize(self.numbers.len() + 1, 0);
        let mut n = 0;
        for (&j, near) in self.numbers.iter().zip(self.within(p, horizon * horizon)) {
            buffer[n] = j;
            n += usize::from(near & (j as usize != i));
        }
        row.copy_from_slice(&buffer[..n]);
        self.row = buffer;
    }
}
