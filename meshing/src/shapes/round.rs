//! Balls and cylinders.

use glam::DVec3;

use super::{ShapeError, length, revolution};
use crate::TriMesh;

/// A ball of `radius` [m] around the origin: an icosahedron whose triangles are split in four `subdivisions` times (0 to
/// 8), all vertices on the sphere. 20 · 4^subdivisions triangles; its volume falls short of the ball's by about
/// 0.55 / 4^subdivisions of it (0.39 for none).
///
/// # Errors
/// A radius outside 1e-9 to 1e9 m, more than 8 subdivisions.
pub fn ball(radius: f64, subdivisions: usize) -> Result<TriMesh, ShapeError> {
    length("ball", "radius", radius)?;
    if subdivisions > 8 {
        let (value, wanted) = (subdivisions as f64, "0 to 8");
        return Err(ShapeError::OutOfRange { shape: "ball", name: "subdivisions", value, wanted });
    }
    let mut mesh = icosahedron();
    for _ in 0..subdivisions {
        split_in_four(&mut mesh);
    }
    mesh.vertices.iter_mut().for_each(|p| *p *= radius);
    Ok(mesh)
}

/// A cylinder of `radius` and `height` [m] around the y axis, centred at the origin, as a regular prism of `segments` (3 to
/// 100 000) sides with its edges on the cylinder.
///
/// # Errors
/// A length outside 1e-9 to 1e9 m, too few or too many segments.
pub fn cylinder(radius: f64, height: f64, segments: usize) -> Result<TriMesh, ShapeError> {
    let r = length("cylinder", "radius", radius)?;
    let y = length("cylinder", "height", height)? / 2.0;
    revolution(&[(0.0, -y), (r, -y), (r, y), (0.0, y)], segments)
}

/// On the unit sphere. Vertices are the cyclic permutations of (0, ±1, ±φ).
fn icosahedron() -> TriMesh {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut vertices = Vec::with_capacity(12);
    for (a, b) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        vertices.push(DVec3::new(a, b, 0.0).normalize());
    }
    for (a, b) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        vertices.push(DVec3::new(0.0, a, b).normalize());
    }
    for (a, b) in [(golden, -1.0), (golden, 1.0), (-golden, -1.0), (-golden, 1.0)] {
        vertices.push(DVec3::new(a, 0.0, b).normalize());
    }
    let around_0 = [[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11]];
    let beside_0 = [[1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8]];
    let around_3 = [[3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9]];
    let beside_3 = [[4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]];
    TriMesh { vertices, triangles: [around_0, beside_0, around_3, beside_3].concat() }
}

/// Splits each triangle at the middles of its sides, pushed out to the unit sphere.
fn split_in_four(mesh: &mut TriMesh) {
    let mut edges: Vec<[u32; 2]> = mesh
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .filter(|[u, v]| u < v) // closed: each edge runs once each way
        .collect();
    edges.sort_unstable();
    let first = mesh.vertices.len() as u32;
    for [u, v] in &edges {
        let middle = (mesh.vertices[*u as usize] + mesh.vertices[*v as usize]).normalize();
        mesh.vertices.push(middle);
    }
    let middle = |u: u32, v: u32| first + edges.partition_point(|e| *e < [u.min(v), u.max(v)]) as u32;
    mesh.triangles = mesh
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        })
        .collect();
}
