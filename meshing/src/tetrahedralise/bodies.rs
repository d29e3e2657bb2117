//! Small closed surfaces for the tests.

use crate::TriMesh;
use glam::DVec3;

/// An axis-aligned box of twelve triangles.
pub fn cuboid(lo: DVec3, hi: DVec3) -> TriMesh {
    let vertices = (0..8).map(|k| DVec3::select(glam::BVec3::new(k & 1 > 0, k & 2 > 0, k & 4 > 0), hi, lo)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriMesh { vertices, triangles }
}

/// A unit ball: an octahedron whose triangles were quartered `levels` times.
pub fn ball(levels: usize) -> TriMesh {
    let axes = [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
    let mut mesh = TriMesh {
        vertices: axes.to_vec(),
        triangles: vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]],
    };
    for _ in 0..levels {
        let mut known = std::collections::BTreeMap::new();
        let old = std::mem::take(&mut mesh.triangles);
        for t in old {
            let m = [0, 1, 2].map(|k| {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                *known.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let p = (mesh.vertices[a as usize] + mesh.vertices[b as usize]).normalize();
                    mesh.vertices.push(p);
                    mesh.vertices.len() as u32 - 1
                })
            });
            mesh.triangles.extend([[t[0], m[0], m[2]], [t[1], m[1], m[0]], [t[2], m[2], m[1]], m]);
        }
    }
    mesh
}

/// An L-shaped prism in the unit cube, with one concave edge.
pub fn ell() -> TriMesh {
    let outline = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (0.5, 0.5), (0.5, 1.0), (0.0, 1.0)];
    let mut vertices = Vec::new();
    for z in [0.0, 1.0] {
        vertices.extend(outline.map(|(x, y)| DVec3::new(x, y, z)));
    }
    let mut triangles = Vec::new();
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        triangles.extend([[a, c, b], [a + 6, b + 6, c + 6]]);
    }
    for k in 0..6 {
        let n = (k + 1) % 6;
        triangles.extend([[k, n, n + 6], [k, n + 6, k + 6]]);
    }
    TriMesh { vertices, triangles }
}

/// A prism over an outline (counter-clockwise, star-shaped around the origin) from z = 0 to `height`.
fn prism(outline: &[DVec3], height: f64) -> TriMesh {
    let n = outline.len() as u32;
    let mut vertices = outline.to_vec();
    vertices.extend(outline.iter().map(|p| p + DVec3::Z * height));
    vertices.extend([DVec3::ZERO, DVec3::Z * height]);
    let mut triangles = Vec::new();
    for k in 0..n {
        let m = (k + 1) % n;
        triangles.extend([[k, m, m + n], [k, m + n, k + n], [m, k, 2 * n], [k + n, m + n, 2 * n + 1]]);
    }
    TriMesh { vertices, triangles }
}

/// A star-shaped prism: `points` tips of radius 1 over a core of radius `inner`.
pub fn star(points: usize, inner: f64, height: f64) -> TriMesh {
    let turn = std::f64::consts::PI / points as f64;
    let outline: Vec<DVec3> = (0..2 * points)
        .map(|k| {
            let radius = if k % 2 == 0 { 1.0 } else { inner };
            radius * DVec3::new((k as f64 * turn).cos(), (k as f64 * turn).sin(), 0.0)
        })
        .collect();
    prism(&outline, height)
}

/// A cone of the given radius on z = 0 with its tip at `height`.
pub fn cone(radius: f64, height: f64, segments: u32) -> TriMesh {
    let turn = std::f64::consts::TAU / f64::from(segments);
    let mut vertices: Vec<DVec3> = (0..segments)
        .map(|k| radius * DVec3::new((f64::from(k) * turn).cos(), (f64::from(k) * turn).sin(), 0.0))
        .collect();
    vertices.extend([DVec3::ZERO, DVec3::Z * height]);
    let ring = (0..segments).map(|k| (k, (k + 1) % segments));
    let triangles = ring.flat_map(|(k, m)| [[m, k, segments], [k, m, segments + 1]]).collect();
    TriMesh { vertices, triangles }
}

/// Both surfaces in one; the second is wound as it comes.
pub fn both(mut first: TriMesh, second: TriMesh) -> TriMesh {
    let start = first.vertices.len() as u32;
    first.vertices.extend(second.vertices);
    first.triangles.extend(second.triangles.iter().map(|t| t.map(|v| v + start)));
    first
}

/// The unit cube with a cubic cavity.
pub fn hollow() -> TriMesh {
    let mut inner = cuboid(DVec3::splat(0.3), DVec3::splat(0.7));
    inner.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    both(cuboid(DVec3::ZERO, DVec3::ONE), inner)
}
