//! Borders of a surface as loops, and the closing of small ones.
//!
//! A loop is closed with the triangulation of smallest area (the dynamic programme of Barequet & Sharir 1995, Filling gaps
//! in the boundary of a polyhedron), which stays out of the way of the surface around it; no new edge may double one that
//! exists. Where no such triangulation is found, all triangles meet in a new vertex at the centre.

use std::{
    cmp::Reverse,
    collections::{BTreeMap, BinaryHeap},
};

use glam::DVec3;

use super::edges::Edges;
use crate::{TriMesh, trimesh::bounds};

/// Longer loops are not closed: the cost grows with the cube of the edges.
const MOST_EDGES: usize = 400;

/// One loop of border edges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hole {
    /// Its vertices, in the order in which a filling is wound outwards.
    pub vertices: Vec<u32>,
    /// Centre of its bounding box [m].
    pub at: DVec3,
    /// Diagonal of its bounding box [m].
    pub across: f64,
}

/// All border loops of a consistently wound mesh, by their first border edge. Where several meet in a vertex, each edge
/// goes to the shortest loop it can be part of: slits side by side stay slits. No loop visits a vertex twice. Borders that
/// end at an edge with more than two triangles, or change direction on a one-sided surface, make no loop.
pub(super) fn holes(mesh: &TriMesh, edges: &Edges) -> Vec<Hole> {
    let mut steps: Vec<[u32; 2]> = edges
        .iter()
        .filter(|sides| sides.len() == 1)
        .map(|sides| if sides[0].forward { [sides[0].edge[1], sides[0].edge[0]] } else { sides[0].edge })
        .collect();
    steps.sort_unstable();
    let mut taken = vec![false; steps.len()];
    let mut out = Vec::new();
    for start in 0..steps.len() {
        if taken[start] {
            continue;
        }
        taken[start] = true;
        let Some(back) = shortest_way_back(mesh, &steps, &taken, steps[start]) else { continue };
        back.iter().for_each(|&s| taken[s] = true);
        let vertices: Vec<u32> = std::iter::once(start).chain(back).map(|s| steps[s][0]).collect();
        let points: Vec<DVec3> = vertices.iter().map(|&v| mesh.vertices[v as usize]).collect();
        let (lo, hi) = bounds(&points).unwrap_or_default();
        out.push(Hole { vertices, at: (lo + hi) / 2.0, across: hi.distance(lo) });
    }
    out
}

/// The shortest path [m] from the head of a step to its tail along steps that are not taken (Dijkstra; ties by index).
fn shortest_way_back(mesh: &TriMesh, steps: &[[u32; 2]], taken: &[bool], [tail, head]: [u32; 2]) -> Option<Vec<usize>> {
    let at = |v: u32| mesh.vertices[v as usize];
    // Lengths are not negative, so their bits sort as they do.
    let mut queue = BinaryHeap::from([Reverse((0_u64, head, usize::MAX))]);
    let mut reached_by = BTreeMap::new();
    while let Some(Reverse((length, v, step))) = queue.pop() {
        if reached_by.contains_key(&v) {
            continue;
        }
        reached_by.insert(v, step);
        if v == tail {
            let mut path = Vec::new();
            let mut at = tail;
            while at != head {
                let step: usize = reached_by[&at];
                path.push(step);
                at = steps[step][0];
            }
            path.reverse();
            return Some(path);
        }
        let from = steps.partition_point(|s| s[0] < v);
        for next in (from..steps.len()).take_while(|&s| steps[s][0] == v).filter(|&s| !taken[s]) {
            let w = steps[next][1];
            let longer = f64::from_bits(length) + at(v).distance(at(w));
            queue.push(Reverse((longer.to_bits(), w, next)));
        }
    }
    None
}

/// What may be closed.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    /// Widest hole [m].
    pub widest: f64,
    /// Wider holes are closed too if their filling is narrower than this on average [m]: slits.
    pub within: f64,
    /// Area of the piece around the hole [m²]. A filling of half of it or more would not mend a solid but double a sheet.
    pub piece: f64,
}

/// Closes the hole if the limits allow it, and says whether it did. `taken` tells the edges that exist.
pub(super) fn fill(mesh: &mut TriMesh, taken: impl Fn([u32; 2]) -> bool, hole: &Hole, limits: Limits) -> bool {
    let ring = &hole.vertices;
    let n = ring.len();
    let at = |i: usize| mesh.vertices[ring[i % n] as usize];
    let narrow = |area: f64| area <= limits.within * hole.across;
    // No filling has less area than the vector area of its border.
    let vector_area = (1..n - 1).map(|i| (at(i) - at(0)).cross(at(i + 1) - at(0))).sum::<DVec3>().length() / 2.0;
    if !(3..=MOST_EDGES).contains(&n) || (hole.across > limits.widest && !narrow(vector_area)) {
        return false;
    }
    let least = least_area(mesh, taken, ring);
    let centre = (0..n).map(at).sum::<DVec3>() / n as f64;
    let fan_area = || (0..n).map(|i| (at(i) - centre).cross(at(i + 1) - centre).length() / 2.0).sum();
    let area: f64 = least.as_ref().map_or_else(fan_area, |(area, _)| *area);
    if area >= limits.piece / 2.0 || (hole.across > limits.widest && !narrow(area)) {
        return false;
    }
    match least {
        Some((_, triangles)) => mesh.triangles.extend(triangles),
        None => {
            let c = mesh.vertices.len() as u32;
            mesh.triangles.extend((0..n).map(|i| [ring[i], ring[(i + 1) % n], c]));
            mesh.vertices.push(centre);
        }
    }
    true
}

/// Area and triangles of the smallest triangulation of a loop without new vertices.
fn least_area(mesh: &TriMesh, taken: impl Fn([u32; 2]) -> bool, ring: &[u32]) -> Option<(f64, Vec<[u32; 3]>)> {
    let n = ring.len();
    let at = |i: usize| mesh.vertices[ring[i] as usize];
    // cost[i][k]: least area between the chord i–k and the vertices from i to k; apex[i][k]: its third corner.
    let mut cost = vec![0.0_f64; n * n];
    let mut apex = vec![0_usize; n * n];
    for span in 2..n {
        for i in 0..n - span {
            let k = i + span;
            let whole = span == n - 1;
            let mut best = (f64::INFINITY, 0);
            if whole || !taken([ring[i], ring[k]]) {
                for j in i + 1..k {
                    let area = (at(j) - at(i)).cross(at(k) - at(i)).length() / 2.0;
                    let total = cost[i * n + j] + cost[j * n + k] + area;
                    if total < best.0 {
                        best = (total, j);
                    }
                }
            }
            (cost[i * n + k], apex[i * n + k]) = best;
        }
    }
    let area = cost[n - 1];
    if !area.is_finite() {
        return None;
    }
    let mut triangles = Vec::with_capacity(n - 2);
    let mut chords = vec![(0, n - 1)];
    while let Some((i, k)) = chords.pop() {
        if k - i < 2 {
            continue;
        }
        let j = apex[i * n + k];
        triangles.push([ring[i], ring[j], ring[k]]);
        chords.extend([(i, j), (j, k)]);
    }
    Some((area, triangles))
}
