//! Borders of a surface as loops, and the closing of small ones.
//!
//! A loop is closed with the triangulation of smallest area (the dynamic programme of Barequet & Sharir 1995, Filling gaps
//! in the boundary of a polyhedron), which stays out of the way of the surface around it; no new edge may double one that
//! exists. Where no such triangulation is found, all triangles meet in a new vertex at the centre.

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

/// All border loops of a consistently wound mesh, by their first border edge. No loop visits a vertex twice.
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
        let mut path: Vec<u32> = vec![steps[start][0]];
        let mut next = Some(start);
        while let Some(step) = next {
            taken[step] = true;
            let v = steps[step][1];
            if let Some(first) = path.iter().position(|&u| u == v) {
                out.push(hole(mesh, path.split_off(first)));
            }
            path.push(v);
            let from = steps.partition_point(|s| s[0] < v);
            next = (from..steps.len()).take_while(|&s| steps[s][0] == v).find(|&s| !taken[s]);
        }
        // A path that does not come back ends at an edge with more than two triangles.
        if path.len() > 1 {
            out.push(hole(mesh, path));
        }
    }
    out
}

fn hole(mesh: &TriMesh, vertices: Vec<u32>) -> Hole {
    let points: Vec<DVec3> = vertices.iter().map(|&v| mesh.vertices[v as usize]).collect();
    let (lo, hi) = bounds(&points).unwrap_or_default();
    Hole { vertices, at: (lo + hi) / 2.0, across: hi.distance(lo) }
}

/// Closes the hole if it is no wider than `widest`, or so narrow a slit that its filling has no area to speak of
/// (`within` times its length). Says whether it did. `taken` tells the edges that exist.
pub(super) fn fill(
    mesh: &mut TriMesh,
    taken: impl Fn([u32; 2]) -> bool,
    hole: &Hole,
    widest: f64,
    within: f64,
) -> bool {
    let n = hole.vertices.len();
    if !(3..=MOST_EDGES).contains(&n) {
        return false;
    }
    let least = least_area(mesh, taken, &hole.vertices);
    let slit = least.as_ref().is_some_and(|(area, _)| *area <= within * hole.across);
    if hole.across > widest && !slit {
        return false;
    }
    match least {
        Some((_, triangles)) => mesh.triangles.extend(triangles),
        None => {
            let centre = hole.vertices.iter().map(|&v| mesh.vertices[v as usize]).sum::<DVec3>() / n as f64;
            let c = mesh.vertices.len() as u32;
            mesh.vertices.push(centre);
            mesh.triangles.extend((0..n).map(|i| [hole.vertices[i], hole.vertices[(i + 1) % n], c]));
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
