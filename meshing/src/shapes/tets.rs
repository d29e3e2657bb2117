//! A box of tetrahedra for tests and benches.
//!
//! Each cell of a grid is cut into the six tetrahedra around its main diagonal, one for each order of the axes (Kuhn
//! 1960). All cells are cut alike, so neighbours agree on the diagonals of their common side. Random offsets of the inner
//! vertices take away the regularity; a vertex whose offset squeezes a tetrahedron below a tenth of its volume gets half
//! the offset, until none does.

use glam::DVec3;

use super::{ShapeError, length};
use crate::TetMesh;

const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

/// A box with the edges `size` [m] around the origin, cut into `n` cells along each axis and 6 tetrahedra a cell. Vertices
/// run x fastest, z slowest. Inner vertices move by at most `jitter` (0 to 0.5) of the cell along each axis, as `seed`
/// decides; those on the surface stay. All volumes are positive, at least a tenth of the regular ones.
///
/// # Errors
/// An edge outside 1e-9 to 1e9 m, a number of cells outside 1 to 1000 along an axis, a jitter outside 0 to 0.5.
pub fn tet_box(size: DVec3, n: [usize; 3], jitter: f64, seed: u64) -> Result<TetMesh, ShapeError> {
    let shape = "tet_box";
    for axis in 0..3 {
        length(shape, ["size along x", "size along y", "size along z"][axis], size[axis])?;
        if !(1..=1000).contains(&n[axis]) {
            let (value, wanted) = (n[axis] as f64, "1 to 1000 cells along each axis");
            return Err(ShapeError::OutOfRange { shape, name: "n", value, wanted });
        }
    }
    if !(0.0..=0.5).contains(&jitter) {
        return Err(ShapeError::OutOfRange { shape, name: "jitter", value: jitter, wanted: "0 to 0.5" });
    }
    let cells = DVec3::new(n[0] as f64, n[1] as f64, n[2] as f64);
    let step = [1, n[0] + 1, (n[0] + 1) * (n[1] + 1)];
    let mut random = SplitMix(seed);
    let mut regular = Vec::with_capacity(step[2] * (n[2] + 1));
    let mut offsets = Vec::with_capacity(regular.capacity());
    for k in 0..=n[2] {
        for j in 0..=n[1] {
            for i in 0..=n[0] {
                let at = [i, j, k];
                let p = DVec3::new(i as f64, j as f64, k as f64) / cells - 0.5;
                regular.push(p * size);
                let inner = (0..3).all(|a| at[a] > 0 && at[a] < n[a]);
                let offset = DVec3::new(random.symmetric(), random.symmetric(), random.symmetric());
                offsets.push(if inner { jitter * offset * size / cells } else { DVec3::ZERO });
            }
        }
    }
    let mut tets = Vec::with_capacity(6 * n[0] * n[1] * n[2]);
    for k in 0..n[2] {
        for j in 0..n[1] {
            for i in 0..n[0] {
                let corner = i * step[0] + j * step[1] + k * step[2];
                for [a, b, _] in ORDERS {
                    let path =
                        [corner, corner + step[a], corner + step[a] + step[b], corner + step[0] + step[1] + step[2]];
                    // Even orders of the axes give positive volume as they are.
                    let even = (b + 3 - a) % 3 == 1;
                    let [p, q, r, s] = path.map(|v| v as u32);
                    tets.push(if even { [p, q, r, s] } else { [p, r, q, s] });
                }
            }
        }
    }
    let least = (size / cells).element_product() / 60.0;
    let vertices = regular.iter().zip(&offsets).map(|(p, d)| p + d).collect();
    let mut mesh = TetMesh { vertices, tets };
    loop {
        let squeezed: Vec<usize> = (0..mesh.tets.len()).filter(|&t| mesh.volume(t) < least).collect();
        if squeezed.is_empty() {
            return Ok(mesh);
        }
        let mut victims: Vec<u32> = squeezed.iter().flat_map(|&t| mesh.tets[t]).collect();
        victims.sort_unstable();
        victims.dedup();
        for v in victims.into_iter().map(|v| v as usize) {
            offsets[v] =
                if offsets[v].abs().max_element() < 1e-6 * size.min_element() { DVec3::ZERO } else { offsets[v] / 2.0 };
            mesh.vertices[v] = regular[v] + offsets[v];
        }
    }
}

/// SplitMix64 (Steele, Lea & Flood 2014).
struct SplitMix(u64);

impl SplitMix {
    /// The next number in [−1, 1).
    fn symmetric(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}
