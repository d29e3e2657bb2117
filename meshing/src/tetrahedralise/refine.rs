//! Smaller elements where the solid, or a gap in it, is thin: a size field, and splitting of background edges to it.
//!
//! Every edge that is too long for its place is halved, longest first, and flips and moves raise the angles again. Most
//! bodies have few such places (ears, claws, tips). A body that is thin all over would grow beyond what was asked
//! for, so the finest size is raised until the number of tetrahedra is at most [`MOST_MORE`] times as large.

use super::complex::{Complex, angle_score};
use super::smooth::smooth;
use super::solid::Solid;
use super::thin::{self, Middle};
use glam::{DVec3, IVec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Wanted number of local edges through a wall, and across a gap.
const THROUGH: f64 = 1.7;
const ACROSS: f64 = 1.2;
/// Smallest local edge, as a part of the asked one.
const FINEST: f64 = 0.45;
/// By how much an edge may grow per length away from a thin place.
const GRADING: f64 = 0.6;
/// Edges longer than this many local sizes are halved.
const TOO_LONG: f64 = 1.5;
/// Splits leave angles of at least this [degrees]; improvement follows.
const FLOOR: f64 = 7.0;
/// Rounds of splitting.
const ROUNDS: u64 = 5;

/// Wanted edge lengths by place.
pub struct Sizing {
    edge: f64,
    finest: f64,
    growth: f64,
    cells: HashMap<IVec3, Vec<(DVec3, f64, f64)>>,
}

impl Sizing {
    /// Looks for thin places of the solid, for background edges of length `edge` [m]. They may raise the number of
    /// tetrahedra by the factor `growth`; with 1 they aren't looked for.
    pub fn new(solid: &dyn Solid, edge: f64, growth: f64) -> Self {
        if growth <= 1.0 {
            return Self { edge, finest: edge, growth, cells: HashMap::new() };
        }
        let wanted = |m: Middle, count: f64| (m.at, m.radius, (2.0 * m.radius / count).max(FINEST * edge));
        let mut all: Vec<(DVec3, f64, f64)> = thin::middles(solid, edge, 0.5 * THROUGH * edge, 1.0)
            .into_iter()
            .map(|m| wanted(m, THROUGH))
            .chain(thin::middles(solid, edge, 0.5 * ACROSS * edge, -1.0).into_iter().map(|m| wanted(m, ACROSS)))
            .collect();
        // the finest of each small cube speaks for it
        let fine = |p: DVec3| (p / (0.3 * edge)).floor().as_ivec3().to_array();
        all.sort_by(|a, b| fine(a.0).cmp(&fine(b.0)).then(a.2.total_cmp(&b.2)));
        all.dedup_by_key(|m| fine(m.0));
        let mut cells: HashMap<IVec3, Vec<(DVec3, f64, f64)>> = HashMap::new();
        for m in all {
            cells.entry((m.0 / edge).floor().as_ivec3()).or_default().push(m);
        }
        Self { edge, finest: FINEST * edge, growth, cells }
    }

    /// Whether there are no thin places.
    pub fn is_even(&self) -> bool {
        self.cells.is_empty()
    }

    /// Wanted background edge length [m] at `p`.
    pub fn at(&self, p: DVec3) -> f64 {
        if self.cells.is_empty() {
            return self.edge;
        }
        let cell = (p / self.edge).floor().as_ivec3();
        let mut wanted = self.edge;
        for k in 0..27 {
            let near = self.cells.get(&(cell + IVec3::new(k % 3, k / 3 % 3, k / 9) - 1));
            for (at, radius, size) in near.into_iter().flatten() {
                wanted = wanted.min(size + GRADING * (at.distance(p) - radius).max(0.0));
            }
        }
        wanted.max(self.finest)
    }

    /// Raises the finest size until places with these wanted edges don't cost too much.
    fn afford(&mut self, edges: &[f64]) {
        let growth = |finest: f64| {
            edges.iter().map(|&h| (self.edge / h.max(finest)).powi(3)).sum::<f64>() / edges.len().max(1) as f64
        };
        while self.finest < self.edge && growth(self.finest) > self.growth {
            self.finest = (self.finest + 0.02 * self.edge).min(self.edge);
        }
    }
}

/// Splits the edges of a background that are too long for their place. `phi` is the signed distance at its vertices.
pub fn refine(solid: &dyn Solid, sizing: &mut Sizing, mesh: &mut Complex, phi: &mut Vec<f64>, seed: u64) {
    if sizing.is_even() {
        return;
    }
    let edge = sizing.edge;
    let wanted = |sizing: &Sizing, mesh: &Complex| -> Vec<f64> {
        mesh.points.par_iter().with_min_len(256).map(|&p| sizing.at(p)).collect()
    };
    let inner: Vec<f64> =
        wanted(sizing, mesh).into_iter().zip(&*phi).filter(|&(_, &x)| x < 0.3 * edge).map(|x| x.0).collect();
    sizing.afford(&inner);
    for round in 0..ROUNDS {
        let size = wanted(sizing, mesh);
        if !split(mesh, &size) {
            break;
        }
        raise(sizing, mesh, seed ^ round);
    }
    let (old, points) = (&*phi, &mesh.points);
    let value = |v: usize| {
        let unchanged = v < old.len() && sizing.at(points[v]) >= edge;
        if unchanged { old[v] } else { solid.signed_distance(points[v], 2.5 * edge) }
    };
    *phi = (0..points.len()).into_par_iter().with_min_len(64).map(value).collect();
}

/// Halves long edges. Returns whether there were any.
fn split(mesh: &mut Complex, size: &[f64]) -> bool {
    const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    let shared = &*mesh;
    let mut long: Vec<(f64, [u32; 2])> = (0..mesh.tets.len() as u32)
        .into_par_iter()
        .with_min_len(1024)
        .filter(|&t| shared.alive(t))
        .flat_map_iter(|t| {
            let tet = shared.tets[t as usize];
            PAIRS.into_iter().map(move |[i, j]| [tet[i].min(tet[j]), tet[i].max(tet[j])])
        })
        .filter_map(|[a, b]| {
            let length = shared.points[a as usize].distance(shared.points[b as usize]);
            let ratio = 2.0 * length / (size[a as usize] + size[b as usize]);
            (ratio > TOO_LONG).then_some((ratio, [a, b]))
        })
        .collect();
    long.sort_unstable_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
    long.dedup();
    let floor = angle_score(FLOOR);
    let mut any = false;
    for (_, [a, b]) in long {
        let middle = (mesh.points[a as usize] + mesh.points[b as usize]) / 2.0;
        any |= mesh.split(a, b, middle, floor).is_some();
    }
    any
}

/// Flips and moves where the size isn't even.
fn raise(sizing: &Sizing, mesh: &mut Complex, seed: u64) {
    let mut free: Vec<bool> = mesh.points.par_iter().with_min_len(256).map(|&p| sizing.at(p) < sizing.edge).collect();
    for v in mesh.boundary(|_| true).into_iter().flatten() {
        free[v as usize] = false;
    }
    let vertices: Vec<u32> = (0..free.len() as u32).filter(|&v| free[v as usize]).collect();
    for pass in 0..2 {
        let aim = angle_score(30.0);
        for t in 0..mesh.tets.len() as u32 {
            let near = |mesh: &Complex| mesh.alive(t) && mesh.tets[t as usize].iter().any(|&v| free[v as usize]);
            if !near(mesh) || mesh.score(mesh.tets[t as usize]) > aim {
                continue;
            }
            let [a, b, c, d] = mesh.tets[t as usize];
            let turned = [[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]]
                .into_iter()
                .any(|[p, q]| mesh.remove_edge(p, q, None, |_, _| false));
            if !turned {
                let _ = (0..4).any(|k| mesh.remove_face(t, k, None));
            }
        }
        smooth(mesh, &vertices, 0.1 * sizing.edge, seed ^ (pass << 40), |_, p| Some(p));
    }
}
