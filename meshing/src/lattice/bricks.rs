//! The raw lattice: whole cubes, outside as within (Ohta et al., Fig. 4 c, e).

use std::collections::HashMap;

use glam::DVec3;

use super::facets::{Facet, Facets};
use super::grid::Grid;
use super::pieces::Pieces;

/// Every cell a cube. Faces between cells that are joined can open; all others are outside.
pub(super) fn bricks(pieces: &Pieces, joined: &[[u32; 2]], grid: Grid) -> Facets {
    let mut known: HashMap<[i32; 3], u32> = HashMap::new();
    let (mut vertices, mut facets) = (Vec::new(), Vec::new());
    // in half cells, so that middles of edges and faces are whole too
    let mut vertex = |at: [i32; 3]| {
        *known.entry(at).or_insert_with(|| {
            vertices.push(grid.origin + DVec3::from_array(at.map(f64::from)) * (0.5 * grid.size));
            vertices.len() as u32 - 1
        })
    };
    let mut square = |cell: [i32; 3], axis: usize, high: bool, front: u32, back: Option<u32>| {
        const AROUND: [[i32; 2]; 8] = [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]];
        let mut point = |[s, t]: [i32; 2]| {
            let mut at = cell.map(|c| 2 * c);
            at[axis] += 2 * i32::from(high);
            at[(axis + 1) % 3] += s;
            at[(axis + 2) % 3] += t;
            vertex(at)
        };
        let centre = point([1, 1]);
        let mut normal = DVec3::ZERO;
        normal[axis] = if high { 1.0 } else { -1.0 };
        for k in 0..8 {
            let (a, b) = (point(AROUND[k]), point(AROUND[(k + 1) % 8]));
            let corners = if high { [a, b, centre] } else { [b, a, centre] };
            facets.push(Facet { corners, front, back, normal });
        }
    };
    let at: HashMap<[i32; 3], Vec<u32>> =
        pieces.place.iter().enumerate().fold(HashMap::new(), |mut map, (p, &cell)| {
            map.entry(cell).or_insert_with(Vec::new).push(p as u32);
            map
        });
    let mut pairs: Vec<[u32; 2]> = joined.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
    pairs.sort_unstable();
    for (p, &cell) in pieces.place.iter().enumerate() {
        let p = p as u32;
        for axis in 0..3 {
            for high in [false, true] {
                let mut across = cell;
                across[axis] += if high { 1 } else { -1 };
                let is_joined = |q: &&u32| pairs.binary_search(&[p.min(**q), p.max(**q)]).is_ok();
                match at.get(&across).and_then(|there| there.iter().find(is_joined)) {
                    Some(&q) if high => square(cell, axis, true, p, Some(q)),
                    Some(_) => {}
                    None => square(cell, axis, high, p, None),
                }
            }
        }
    }
    Facets::new(vertices, facets).separate()
}
