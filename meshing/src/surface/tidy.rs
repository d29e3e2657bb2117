//! Removes what carries no shape: vertices stored twice, triangles without area, triangles stored twice, loose vertices.
//!
//! A mesh that has none of these comes out bit for bit as it went in. Zero-area triangles with three distinct corners
//! are not simply dropped: that would leave a slit where a vertex sits on the edge of its neighbour. The neighbour across
//! the longest side is split at that vertex instead (an edge flip).

use glam::DVec3;

use super::edges::Edges;
use crate::TriMesh;

/// How many of each were removed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Tidied {
    pub merged_vertices: usize,
    pub degenerate_triangles: usize,
    pub duplicate_triangles: usize,
    pub unused_vertices: usize,
}

/// Tidies the mesh; `within` [m] is the distance of vertices that count as one and the height of triangles that count
/// as flat. `ids` has a number for each triangle and loses those of the triangles that go.
pub(super) fn tidy(mesh: &mut TriMesh, ids: &mut Vec<u32>, within: f64) -> Tidied {
    let unused_vertices = mesh.vertices.len() - used(mesh).iter().filter(|&&u| u).count();
    let merged_vertices = merge_vertices(mesh, within);
    let keep: Vec<bool> = mesh.triangles.iter().map(|&[a, b, c]| a != b && b != c && c != a).collect();
    let collapsed = retain(mesh, ids, &keep);
    let duplicate_triangles = drop_duplicates(mesh, ids);
    let degenerate_triangles = collapsed + dissolve_slivers(mesh, ids, within);
    drop_unused(mesh);
    Tidied { merged_vertices, degenerate_triangles, duplicate_triangles, unused_vertices }
}

/// Is the triangle no higher than `within` over its longest side?
pub(super) fn is_sliver([a, b, c]: [DVec3; 3], within: f64) -> bool {
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    (b - a).cross(c - a).length() <= within * longest
}

fn used(mesh: &TriMesh) -> Vec<bool> {
    let mut used = vec![false; mesh.vertices.len()];
    mesh.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    used
}

/// Lets triangles use the first of all used vertices that lie within a distance of each other; returns how many are left
/// out. Sweeps along a direction that no grid or plane of a model is likely to be normal to, so that few vertices share
/// a window; each vertex is compared with the survivors only.
fn merge_vertices(mesh: &mut TriMesh, within: f64) -> usize {
    let along = DVec3::new(0.538_196_6, 0.610_721_3, 0.580_813_2);
    let used = used(mesh);
    let mut order: Vec<(f64, u32)> =
        (0..mesh.vertices.len()).filter(|&v| used[v]).map(|v| (mesh.vertices[v].dot(along), v as u32)).collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let reach = order.iter().fold(0.0_f64, |m, o| m.max(o.0.abs()));
    let window = within + 8.0 * f64::EPSILON * reach;
    // Survivors in sweep order: place, first vertex met, smallest index of those near it.
    let mut groups: Vec<(f64, u32, u32)> = Vec::with_capacity(order.len());
    let mut group_of = vec![usize::MAX; mesh.vertices.len()];
    for &(place, v) in &order {
        let p = mesh.vertices[v as usize];
        let near = (0..groups.len())
            .rev()
            .take_while(|&g| place - groups[g].0 <= window)
            .find(|&g| mesh.vertices[groups[g].1 as usize].distance(p) <= within);
        let group = near.unwrap_or(groups.len());
        match groups.get_mut(group) {
            Some(g) => g.2 = g.2.min(v),
            None => groups.push((place, v, v)),
        }
        group_of[v as usize] = group;
    }
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = groups[group_of[*v as usize]].2);
    order.len() - groups.len()
}

/// Keeps the first of the triangles over the same three vertices, whatever their winding.
fn drop_duplicates(mesh: &mut TriMesh, ids: &mut Vec<u32>) -> usize {
    let mut keys: Vec<([u32; 3], u32)> = (0..mesh.triangles.len())
        .map(|t| {
            let mut key = mesh.triangles[t];
            key.sort_unstable();
            (key, t as u32)
        })
        .collect();
    keys.sort_unstable();
    let mut keep = vec![true; keys.len()];
    for pair in keys.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        keep[pair[1].1 as usize] = false;
    }
    retain(mesh, ids, &keep)
}

/// Removes flat triangles with distinct corners by splitting the neighbour across their longest side; those at an open
/// border are dropped. One that has no place to go (its new edge exists already) stays. Returns how many went.
pub(super) fn dissolve_slivers(mesh: &mut TriMesh, ids: &mut Vec<u32>, within: f64) -> usize {
    let slivers = |mesh: &TriMesh| -> Vec<usize> {
        (0..mesh.triangles.len()).filter(|&t| is_sliver(mesh.corners(t), within)).collect()
    };
    let at_first = slivers(mesh).len();
    let mut left = at_first;
    // A flip can hand the flatness on to the neighbour, along a row of collinear points at most.
    for _ in 0..=at_first.min(100) {
        if left == 0 {
            break;
        }
        let edges = Edges::of(mesh);
        let mut touched = vec![false; mesh.triangles.len()];
        let mut keep = vec![true; mesh.triangles.len()];
        let mut changed = false;
        for t in slivers(mesh) {
            let corner = mesh.corners(t);
            let side = |k: usize| corner[(k + 1) % 3].distance(corner[(k + 2) % 3]);
            let apex = (0..3).max_by(|&j, &k| side(j).total_cmp(&side(k))).unwrap_or(0);
            let [b, u, v] = [0, 1, 2].map(|k| mesh.triangles[t][(apex + k) % 3]);
            let across: Vec<u32> = edges.on(u, v).iter().map(|s| s.triangle).filter(|&s| s as usize != t).collect();
            match across[..] {
                [] if !touched[t] => {
                    (keep[t], touched[t], changed) = (false, true, true);
                }
                [s] if !touched[t] && !touched[s as usize] => {
                    let other = mesh.triangles[s as usize];
                    let Some(far) = other.into_iter().find(|w| *w != u && *w != v) else { continue };
                    if far == b || !edges.on(b, far).is_empty() {
                        continue;
                    }
                    let with_b = |gone: u32| other.map(|w| if w == gone { b } else { w });
                    mesh.triangles[t] = with_b(u);
                    mesh.triangles[s as usize] = with_b(v);
                    (touched[t], touched[s as usize], changed) = (true, true, true);
                }
                _ => {}
            }
        }
        retain(mesh, ids, &keep);
        left = slivers(mesh).len();
        if !changed {
            break;
        }
    }
    at_first.saturating_sub(left)
}

fn drop_unused(mesh: &mut TriMesh) {
    let used = used(mesh);
    if used.iter().all(|&u| u) {
        return;
    }
    let mut renumbered = vec![0; used.len()];
    let mut kept = Vec::with_capacity(used.len());
    for (v, _) in used.iter().enumerate().filter(|(_, u)| **u) {
        renumbered[v] = kept.len() as u32;
        kept.push(mesh.vertices[v]);
    }
    mesh.vertices = kept;
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = renumbered[*v as usize]);
}

/// Drops the triangles, with their numbers, that are not to be kept; returns how many.
fn retain(mesh: &mut TriMesh, ids: &mut Vec<u32>, keep: &[bool]) -> usize {
    let before = mesh.triangles.len();
    let mut flags = keep.iter();
    mesh.triangles.retain(|_| flags.next() != Some(&false));
    let mut flags = keep.iter();
    ids.retain(|_| flags.next() != Some(&false));
    before - mesh.triangles.len()
}
