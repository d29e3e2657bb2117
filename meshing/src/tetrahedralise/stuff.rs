//! Filling a solid: background tiles, vertices pulled onto the surface, the rest cut off.
//!
//! Isosurface stuffing (Labelle and Shewchuk 2007) on an irregular background: vertices close to the surface are moved
//! onto it, edges that still cross are cut, and what lies inside is split into tetrahedra. Their angle bound needs their
//! lattice; here every move is guarded by the angles around it and the cut leaves work for `improve`. Corners and sharp
//! edges take their vertices before the surface does.

use super::complex::{Complex, angle_score, worst_from};
use super::refine::{Sizing, refine};
use super::solid::Solid;
use super::thin;
use super::tile::Tile;
use glam::{DVec3, IVec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// A vertex closer to the surface than this part of a crossing edge is moved onto it.
const PULL: f64 = 0.36;
/// Moves onto the surface keep every angle above this [degrees].
const KEEP: f64 = 8.0;

/// A filled solid before improvement.
pub struct Filled {
    /// Its tetrahedra.
    pub mesh: Complex,
    /// What each vertex must stay on: 0 corner, 1 sharp edge, 2 surface, 3 nothing.
    pub dim: Vec<u8>,
}

/// Number of background vertices that a size would need; an upper bound.
pub fn background_points(solid: &dyn Solid, tile: &Tile, edge: f64) -> f64 {
    let (lo, hi) = solid.bounds();
    let blocks = ((hi - lo) / (tile.side * edge)).ceil() + 3.0;
    blocks.x * blocks.y * blocks.z * tile.points.len() as f64
}

/// Fills the solid with tetrahedra whose mean background edge is `edge` [m]; `shift` in [0, 1)³ moves the background by
/// that part of a tile.
pub fn fill(solid: &dyn Solid, tile: &Tile, edge: f64, shift: DVec3, growth: f64, seed: u64) -> Filled {
    let mut sizing = Sizing::new(solid, edge, growth);
    // walls may need vertices that are outside for now
    let even = sizing.is_even() && thin::walls(solid, edge, &sizing).is_empty();
    let margin = if even { 0.0 } else { 1.1 * edge };
    let (mut mesh, mut phi) = background(solid, tile, edge, margin, shift);
    refine(solid, &mut sizing, &mut mesh, &mut phi, seed);
    let mut dim = vec![3u8; mesh.points.len()];
    let walls = if even { Vec::new() } else { thin::walls(solid, edge, &sizing) };
    let locked = thin::occupy(&walls, &mut mesh, &mut phi, edge, &sizing);
    let before = (mesh.points.clone(), phi.clone());
    pull(solid, &mut mesh, &mut phi, &mut dim, &locked, edge, &sizing);
    rescue(solid, &mut mesh, &mut phi, &mut dim, before, edge, &sizing);
    cut(solid, mesh, phi, dim, edge)
}

/// Background tetrahedra with at least one vertex inside or less than `margin` outside, and the signed distance at the vertices.
fn background(solid: &dyn Solid, tile: &Tile, edge: f64, margin: f64, shift: DVec3) -> (Complex, Vec<f64>) {
    let (lo, hi) = solid.bounds();
    let side = tile.side * edge;
    let blocks = ((hi - lo) / side).ceil().as_ivec3() + 3;
    let spare = blocks.as_dvec3() * side - (hi - lo);
    let origin = lo - spare / 2.0 + (shift - 0.5) * side * 0.9;
    let block_at = |i: usize| {
        let i = i as i32;
        IVec3::new(i / (blocks.y * blocks.z), i / blocks.z % blocks.y, i % blocks.z)
    };
    let number = |b: IVec3| ((b.x * blocks.y + b.y) * blocks.z + b.z) as usize;
    let n = tile.points.len();
    let count = (blocks.x * blocks.y * blocks.z) as usize;
    let reach = 2.5 * edge;
    let half_diagonal = side * 3f64.sqrt() / 2.0;
    // None: all outside
    let values: Vec<Option<Vec<f64>>> = (0..count)
        .into_par_iter()
        .map(|i| {
            let corner = origin + block_at(i).as_dvec3() * side;
            let far = half_diagonal + reach;
            let middle = solid.signed_distance(corner + side / 2.0, far);
            if middle > far {
                return None;
            }
            if middle < -far {
                return Some(vec![-2.0 * reach; n]);
            }
            Some(tile.points.iter().map(|&p| solid.signed_distance(corner + p * edge, reach)).collect())
        })
        .collect();
    let torus = Complex::new(tile.points.clone(), Vec::new(), Some(tile.side));
    let shifts: Vec<[(IVec3, u32); 4]> = tile
        .tets
        .iter()
        .map(|&t| {
            let c = torus.corners(t);
            [0, 1, 2, 3].map(|k| (((c[k] - tile.points[t[k] as usize]) / tile.side).round().as_ivec3(), t[k]))
        })
        .collect();
    let mut id: Vec<Vec<u32>> =
        values.iter().map(|v| v.as_ref().map_or(Vec::new(), |v| vec![u32::MAX; v.len()])).collect();
    let mut outer: HashMap<(usize, u32), u32> = HashMap::new();
    let (mut points, mut phi, mut tets) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..count {
        let at = block_at(i);
        for tet in &shifts {
            let place = tet.map(|(s, v)| ((at + s).clamp(IVec3::ZERO, blocks - 1), v));
            let value = |(b, v): (IVec3, u32)| values[number(b)].as_ref().map_or(2.0 * reach, |x| x[v as usize]);
            if place.iter().all(|&p| value(p) >= margin) || tet.iter().zip(&place).any(|(t, p)| at + t.0 != p.0) {
                continue;
            }
            tets.push(place.map(|(b, v)| {
                let block = number(b);
                let slot = match id[block].get_mut(v as usize) {
                    Some(slot) => slot,
                    None => outer.entry((block, v)).or_insert(u32::MAX),
                };
                if *slot == u32::MAX {
                    *slot = points.len() as u32;
                    points.push(origin + b.as_dvec3() * side + tile.points[v as usize] * edge);
                    phi.push(value((b, v)));
                }
                *slot
            }));
        }
    }
    (Complex::new(points, tets, None), phi)
}

/// Moves vertices onto corners, sharp edges and the surface where the angles around them allow it.
fn pull(
    solid: &dyn Solid,
    mesh: &mut Complex,
    phi: &mut [f64],
    dim: &mut [u8],
    locked: &[bool],
    edge: f64,
    sizing: &Sizing,
) {
    let features = solid.features();
    let near: Vec<u32> =
        (0..phi.len() as u32).filter(|&v| phi[v as usize].abs() < 1.2 * edge && !locked[v as usize]).collect();
    let guarded = |mesh: &mut Complex, v: u32, to: DVec3, floor: f64| {
        let allowed = worst_from(to, &mesh.view(v), angle_score(floor)) > angle_score(floor);
        if allowed {
            mesh.points[v as usize] = to;
        }
        allowed
    };
    let mut wanted: Vec<(f64, u32, DVec3)> = Vec::new();
    for &corner in &features.corners {
        let mut close: Vec<(f64, u32)> =
            near.iter().map(|&v| (mesh.points[v as usize].distance(corner), v)).filter(|c| c.0 < edge).collect();
        close.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, v) in close.into_iter().take(6) {
            if dim[v as usize] == 3 && guarded(mesh, v, corner, 3.0) {
                (phi[v as usize], dim[v as usize]) = (0.0, 0);
                break;
            }
        }
    }
    if !features.creases.is_empty() {
        for &v in near.iter().filter(|&&v| dim[v as usize] == 3) {
            let p = mesh.points[v as usize];
            if let Some(to) = features.on_crease(p, 0.5 * sizing.at(p)) {
                wanted.push((p.distance(to), v, to));
            }
        }
        wanted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, v, to) in wanted.drain(..) {
            if guarded(mesh, v, to, KEEP) {
                (phi[v as usize], dim[v as usize]) = (0.0, 1);
            }
        }
    }
    let share = |mesh: &Complex, phi: &[f64], v: u32| -> Option<f64> {
        let x = phi[v as usize];
        let across = mesh.neighbours(v).into_iter().filter(|&w| phi[w as usize] * x < 0.0);
        across.map(|w| x.abs() / (x.abs() + phi[w as usize].abs())).reduce(f64::min)
    };
    let (shared, values) = (&*mesh, &*phi);
    let mut order: Vec<(f64, u32, DVec3)> = near
        .par_iter()
        .filter(|&&v| dim[v as usize] == 3)
        .filter_map(|&v| {
            share(shared, values, v).filter(|&t| t < PULL).map(|t| (t, v, solid.project(shared.points[v as usize])))
        })
        .collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (_, v, to) in order {
        if share(mesh, phi, v).is_some_and(|t| t < PULL) && guarded(mesh, v, to, KEEP) {
            (phi[v as usize], dim[v as usize]) = (0.0, 2);
        }
    }
}

/// An edge from a vertex on the surface to one outside should not run through the solid: it would cross the surface once
/// more and not be cut there. Its end on the surface goes back inside if it came from there, or the outer end is pulled
/// onto the surface as well.
fn uncross(
    solid: &dyn Solid,
    mesh: &mut Complex,
    phi: &mut [f64],
    dim: &mut [u8],
    (points, depth): (&[DVec3], &[f64]),
    edge: f64,
) {
    let (shared, values) = (&*mesh, &*phi);
    let outer: Vec<u32> =
        (0..phi.len() as u32).filter(|&v| phi[v as usize] > 0.0 && phi[v as usize] < 1.2 * edge).collect();
    let mut wrong: Vec<(f64, u32, u32)> = outer
        .into_par_iter()
        .flat_map_iter(|o| shared.neighbours(o).into_iter().map(move |z| (z, o)))
        .filter(|&(z, _)| values[z as usize] == 0.0)
        .filter_map(|(z, o)| {
            let (p, q) = (shared.points[z as usize], shared.points[o as usize]);
            let middle = (p + q) / 2.0;
            // within the empty ball around the outer vertex there is nothing to find out
            let clear = middle.distance(q) < values[o as usize];
            (!clear).then(|| (solid.signed_distance(middle, edge), z, o))
        })
        .filter(|w| w.0 < -0.2 * edge)
        .collect();
    wrong.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let floor = angle_score(2.0);
    for (_, z, o) in wrong {
        let (zi, oi) = (z as usize, o as usize);
        if phi[zi] != 0.0 || phi[oi] <= 0.0 {
            continue;
        }
        if dim[zi] == 2 && depth[zi] < -0.05 * edge && worst_from(points[zi], &mesh.view(z), floor) > floor {
            mesh.points[zi] = points[zi];
            (phi[zi], dim[zi]) = (depth[zi], 3);
            continue;
        }
        let to = solid.project(mesh.points[oi]);
        if phi[oi] < 0.6 * edge && worst_from(to, &mesh.view(o), floor) > floor {
            mesh.points[oi] = to;
            (phi[oi], dim[oi]) = (0.0, 2);
        }
    }
}

/// Tetrahedra in the middle of the solid that would be cut away for want of an inner vertex get one: a vertex that was
/// inside before it was pulled goes back, or else the deepest one is brought in.
fn rescue(
    solid: &dyn Solid,
    mesh: &mut Complex,
    phi: &mut [f64],
    dim: &mut [u8],
    (points, depth): (Vec<DVec3>, Vec<f64>),
    edge: f64,
    sizing: &Sizing,
) {
    let doomed = |mesh: &Complex, phi: &[f64], t: u32| {
        let tet = mesh.tets[t as usize];
        tet.iter().all(|&v| phi[v as usize] >= 0.0)
            && tet.iter().any(|&v| phi[v as usize] > 0.0)
            && tet.iter().all(|&v| phi[v as usize] < 2.0 * edge)
    };
    uncross(solid, mesh, phi, dim, (&points, &depth), edge);
    let (shared, values) = (&*mesh, &*phi);
    let all: Vec<u32> = mesh.living().collect();
    let mut lost: Vec<(f64, u32, DVec3)> = all
        .into_par_iter()
        .filter(|&t| doomed(shared, values, t))
        .filter_map(|t| {
            let tet = shared.tets[t as usize];
            let middle = tet.iter().map(|&v| shared.points[v as usize]).sum::<DVec3>() / 4.0;
            let clear = tet.iter().any(|&v| middle.distance(shared.points[v as usize]) < values[v as usize]);
            (!clear).then(|| (solid.signed_distance(middle, edge), t, middle))
        })
        .filter(|l| l.0 < -0.12 * sizing.at(l.2))
        .collect();
    lost.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (deep, t, middle) in lost {
        if !doomed(mesh, phi, t) {
            continue;
        }
        let mut tet = mesh.tets[t as usize];
        tet.sort_by(|&a, &b| depth[a as usize].total_cmp(&depth[b as usize]).then(a.cmp(&b)));
        for v in tet.into_iter().filter(|&v| dim[v as usize] > 1) {
            let was_inside = depth[v as usize] < -0.1 * edge;
            let (to, value) = if was_inside { (points[v as usize], depth[v as usize]) } else { (middle, deep) };
            let from = mesh.points[v as usize];
            let view = mesh.view(v);
            let floor = angle_score(2.0);
            let place = [1.0, 0.7, 0.45, 0.3].into_iter().find(|&part| {
                let p = from.lerp(to, part);
                worst_from(p, &view, floor) > floor && (was_inside || solid.signed_distance(p, edge) < -0.1 * edge)
            });
            if let Some(part) = place {
                mesh.points[v as usize] = from.lerp(to, part);
                (phi[v as usize], dim[v as usize]) = (value * part, 3);
                break;
            }
        }
    }
}

/// Cuts the edges that still cross, and keeps the inside.
fn cut(solid: &dyn Solid, mesh: Complex, phi: Vec<f64>, mut dim: Vec<u8>, edge: f64) -> Filled {
    let mut number: HashMap<[u32; 2], u32> = HashMap::new();
    let mut crossing: Vec<[u32; 2]> = Vec::new();
    let first = mesh.points.len() as u32;
    for t in mesh.living() {
        let tet = mesh.tets[t as usize];
        for &i in &tet {
            for &o in &tet {
                if phi[i as usize] < 0.0 && phi[o as usize] > 0.0 {
                    number.entry([i, o]).or_insert_with(|| {
                        crossing.push([i, o]);
                        first + crossing.len() as u32 - 1
                    });
                }
            }
        }
    }
    let mut points = mesh.points.clone();
    let roots: Vec<DVec3> = crossing.par_iter().map(|&[i, o]| root(solid, &mesh, &phi, i, o, edge)).collect();
    points.extend(roots);
    dim.resize(points.len(), 2);
    let mut tets = Vec::with_capacity(mesh.tets.len());
    let flat = |tet: [u32; 4]| {
        let middle = tet.iter().map(|&v| mesh.points[v as usize]).sum::<DVec3>() / 4.0;
        let depth = -solid.signed_distance(middle, edge) / edge;
        depth < 0.05 || (depth < 0.2 && mesh.score(tet) < angle_score(8.0))
    };
    let on = |i: u32, o: u32| number[&[i, o]];
    for t in mesh.living() {
        let tet = mesh.tets[t as usize];
        let part = |sign: fn(f64) -> bool| tet.iter().copied().filter(|&v| sign(phi[v as usize])).collect::<Vec<u32>>();
        let (mut inner, zero, out) = (part(|x| x < 0.0), part(|x| x == 0.0), part(|x| x > 0.0));
        inner.sort_unstable_by_key(|&v| mix(v));
        match (&inner[..], &zero[..], &out[..]) {
            // all on the surface: inside where a wall is one tetrahedron thick
            ([], _, []) if !flat(tet) => tets.push(tet),
            ([], ..) => {}
            (_, _, []) => tets.push(tet),
            (&[a], _, _) => {
                let mut all = vec![a];
                all.extend(&zero);
                all.extend(out.iter().map(|&o| on(a, o)));
                tets.push([all[0], all[1], all[2], all[3]]);
            }
            // the diagonal of a cut face starts at the inner vertex that comes first
            (&[a, b], &[z], &[o]) => tets.extend([[a, b, z, on(b, o)], [a, z, on(b, o), on(a, o)]]),
            (&[a, b], _, &[o, p]) => {
                let (ao, ap, bo, bp) = (on(a, o), on(a, p), on(b, o), on(b, p));
                tets.push([a, b, bo, bp]);
                let length = |x: u32, y: u32| points[x as usize].distance_squared(points[y as usize]);
                if length(ao, bp) < length(ap, bo) {
                    tets.extend([[a, ao, bo, bp], [a, ao, ap, bp]]);
                } else {
                    tets.extend([[a, ao, bo, ap], [a, bo, ap, bp]]);
                }
            }
            (&[a, b, c], _, &[o]) => {
                let (ao, bo, co) = (on(a, o), on(b, o), on(c, o));
                tets.extend([[a, b, c, co], [a, b, bo, co], [a, ao, bo, co]]);
            }
            _ => {}
        }
    }
    for tet in &mut tets {
        let [a, b, c, d] = tet.map(|v| points[v as usize]);
        if (b - a).dot((c - a).cross(d - a)) < 0.0 {
            tet.swap(2, 3);
        }
    }
    compact(points, dim, tets)
}

/// Where the surface crosses an edge, by a few steps of false position.
fn root(solid: &dyn Solid, mesh: &Complex, phi: &[f64], i: u32, o: u32, edge: f64) -> DVec3 {
    let (p, q) = (mesh.points[i as usize], mesh.points[o as usize]);
    let (mut low, mut high) = ((0.0, phi[i as usize]), (1.0, phi[o as usize]));
    let mut at = 0.5;
    for step in 0..4 {
        let guess = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
        at = if step == 2 { (low.0 + high.0) / 2.0 } else { guess };
        let value = solid.signed_distance(p.lerp(q, at), 2.5 * edge);
        if value.abs() < 0.01 * edge {
            break;
        }
        if value < 0.0 { low = (at, value) } else { high = (at, value) }
    }
    p.lerp(q, at.clamp(0.1, 0.95))
}

/// Renumbers so that only used vertices remain, and frees vertices that ended up inside.
fn compact(points: Vec<DVec3>, dim: Vec<u8>, mut tets: Vec<[u32; 4]>) -> Filled {
    let mut new = vec![u32::MAX; points.len()];
    let (mut kept, mut kept_dim) = (Vec::new(), Vec::new());
    for v in tets.iter_mut().flatten() {
        let slot = &mut new[*v as usize];
        if *slot == u32::MAX {
            *slot = kept.len() as u32;
            kept.push(points[*v as usize]);
            kept_dim.push(dim[*v as usize]);
        }
        *v = *slot;
    }
    Filled { mesh: Complex::new(kept, tets, None), dim: kept_dim }
}

/// A fixed scramble of vertex numbers, so that diagonals have no common direction.
fn mix(v: u32) -> u64 {
    let x = u64::from(v).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    (x ^ (x >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9)
}
