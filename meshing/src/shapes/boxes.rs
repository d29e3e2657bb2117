//! Boxes and the names under which experiments know them.

use glam::DVec3;

use super::{ShapeError, length};
use crate::TriMesh;

/// Corner k of the box is at its low or high end in x, y, z by bits 0, 1, 2 of k.
const SIDES: [[u32; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// A box with the edges `size` [m] around `centre` [m]: 8 vertices, 12 triangles.
///
/// # Errors
/// An edge outside 1e-9 to 1e9 m, a centre farther out than 1e9 times the shortest edge.
pub fn cuboid(size: DVec3, centre: DVec3) -> Result<TriMesh, ShapeError> {
    named("cuboid", ["size along x", "size along y", "size along z"], size, centre)
}

/// A beam along x: `length` [m] by a square section of `side` × `side` [m] in y and z.
///
/// # Errors
/// Those of [`cuboid`].
pub fn beam(length: f64, side: f64, centre: DVec3) -> Result<TriMesh, ShapeError> {
    named("beam", ["length", "side", "side"], DVec3::new(length, side, side), centre)
}

/// An upright wall: `width` along x, `height` along y, `thickness` along z [m].
///
/// # Errors
/// Those of [`cuboid`].
pub fn wall(width: f64, height: f64, thickness: f64, centre: DVec3) -> Result<TriMesh, ShapeError> {
    named("wall", ["width", "height", "thickness"], DVec3::new(width, height, thickness), centre)
}

/// A lying sheet: `width` along x, `depth` along z, `thickness` along y [m].
///
/// # Errors
/// Those of [`cuboid`].
pub fn sheet(width: f64, depth: f64, thickness: f64, centre: DVec3) -> Result<TriMesh, ShapeError> {
    named("sheet", ["width", "thickness", "depth"], DVec3::new(width, thickness, depth), centre)
}

fn named(shape: &'static str, names: [&'static str; 3], size: DVec3, centre: DVec3) -> Result<TriMesh, ShapeError> {
    for axis in 0..3 {
        length(shape, names[axis], size[axis])?;
    }
    for axis in 0..3 {
        // Farther out, the rounding of coordinates would change the edges by more than 1e-6.
        if centre[axis].is_nan() || centre[axis].abs() > 1e9 * size.min_element() {
            let wanted = "a centre no farther out than 1e9 times the shortest edge";
            return Err(ShapeError::OutOfRange { shape, name: "centre", value: centre[axis], wanted });
        }
    }
    let end = |k: u32, bit: u32| if k >> bit & 1 == 1 { 0.5 } else { -0.5 };
    let vertices = (0..8).map(|k| centre + size * DVec3::new(end(k, 0), end(k, 1), end(k, 2))).collect();
    let triangles = SIDES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Ok(TriMesh { vertices, triangles })
}
