//! Triangles are split where edges get a point on them, so that no neighbour is left with a gap.

use std::collections::HashMap;

/// Splits each triangle at the marked ones of its edges. `point` is asked once for every edge, with the lower vertex
/// first, and answers with the new vertex on it if it is to be split; `shorter(a, b, c, d)` tells whether diagonal a–b is
/// to be preferred to c–d. Returns the new triangles with the number of the old one each came from.
pub(super) fn split_edges(
    triangles: &[[u32; 3]],
    mut point: impl FnMut(u32, u32) -> Option<u32>,
    shorter: impl Fn(u32, u32, u32, u32) -> bool,
) -> Vec<([u32; 3], u32)> {
    let mut known: HashMap<(u32, u32), Option<u32>> = HashMap::new();
    let mut out = Vec::with_capacity(triangles.len());
    for (k, t) in triangles.iter().enumerate() {
        let k = k as u32;
        let on: [Option<u32>; 3] = std::array::from_fn(|i| {
            let (a, b) = (t[i].min(t[(i + 1) % 3]), t[i].max(t[(i + 1) % 3]));
            *known.entry((a, b)).or_insert_with(|| point(a, b))
        });
        // turned so that the edges that are split, or the one that is not, begin at corner 0
        let turned = |i: usize| ([t[i], t[(i + 1) % 3], t[(i + 2) % 3]], [on[i], on[(i + 1) % 3], on[(i + 2) % 3]]);
        match on.iter().flatten().count() {
            0 => out.push((*t, k)),
            1 => {
                let first = on.iter().position(Option::is_some).unwrap_or(0);
                if let ([a, b, c], [Some(p), ..]) = turned(first) {
                    out.extend([([a, p, c], k), ([p, b, c], k)]);
                }
            }
            2 => {
                let whole = on.iter().position(Option::is_none).unwrap_or(0);
                if let ([a, b, c], [_, Some(p), Some(q)]) = turned(whole) {
                    out.push(([p, c, q], k));
                    if shorter(a, p, b, q) {
                        out.extend([([a, b, p], k), ([a, p, q], k)]);
                    } else {
                        out.extend([([a, b, q], k), ([b, p, q], k)]);
                    }
                }
            }
            _ => {
                if let ([a, b, c], [Some(p), Some(q), Some(r)]) = turned(0) {
                    out.extend([([a, p, r], k), ([p, b, q], k), ([r, q, c], k), ([p, q, r], k)]);
                }
            }
        }
    }
    out
}
