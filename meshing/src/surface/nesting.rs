//! Which closed pieces are solids and which are cavities, and are they wound so?
//!
//! A piece inside an even number of others bounds matter from outside and must have positive volume; inside an odd number
//! it is the wall of a cavity and must have negative volume. "Inside" is the winding number of the other piece at a point
//! of this one, summed from solid angles (Van Oosterom & Strackee 1983): no ray that could graze an edge.

use glam::DVec3;
use rayon::prelude::*;

use super::{SurfaceError, error::suggested_wall};
use crate::{TriMesh, trimesh::bounds};

struct Piece {
    triangles: Vec<u32>,
    lo: DVec3,
    hi: DVec3,
    volume: f64,
    /// Middle of its largest triangle.
    point: DVec3,
}

/// Turns the closed pieces that are inside out; returns for each the middle of its box and whether it is a cavity.
/// `piece` is the piece of each triangle out of `pieces`, `within` [m] the mean thickness below which a piece is flat.
///
/// # Errors
/// [`SurfaceError::ZeroVolume`].
pub(super) fn turn_inside_out_pieces(
    mesh: &mut TriMesh,
    piece: &[u32],
    pieces: usize,
    within: f64,
) -> Result<Vec<(DVec3, bool)>, SurfaceError> {
    let mut members = vec![Vec::new(); pieces];
    for (t, &p) in piece.iter().enumerate() {
        members[p as usize].push(t as u32);
    }
    let size = mesh.bounds().map_or(0.0, |(lo, hi)| hi.distance(lo));
    let pieces =
        members.into_iter().map(|m| measure(mesh, m, within, size)).collect::<Result<Vec<_>, SurfaceError>>()?;
    let depth: Vec<usize> = pieces
        .par_iter()
        .enumerate()
        .map(|(i, p)| pieces.iter().enumerate().filter(|&(j, other)| i != j && encloses(mesh, other, p.point)).count())
        .collect();
    let mut turned = Vec::new();
    for (p, depth) in pieces.iter().zip(depth) {
        let cavity = depth % 2 == 1;
        if (p.volume < 0.0) != cavity {
            p.triangles.iter().for_each(|&t| mesh.triangles[t as usize].swap(1, 2));
            turned.push(((p.lo + p.hi) / 2.0, cavity));
        }
    }
    Ok(turned)
}

fn measure(mesh: &TriMesh, triangles: Vec<u32>, within: f64, size: f64) -> Result<Piece, SurfaceError> {
    let corners: Vec<[DVec3; 3]> = triangles.iter().map(|&t| mesh.corners(t as usize)).collect();
    let (lo, hi) = bounds(corners.as_flattened()).unwrap_or_default();
    let centre = (lo + hi) / 2.0;
    let (mut volume, mut total, mut largest, mut point) = (0.0, 0.0, -1.0, centre);
    for [a, b, c] in corners {
        let area = (b - a).cross(c - a).length() / 2.0;
        volume += (a - centre).dot((b - centre).cross(c - centre)) / 6.0;
        total += area;
        if area > largest {
            (largest, point) = (area, (a + b + c) / 3.0);
        }
    }
    // A wall of thickness t has the volume t/2 times its area.
    if volume.abs() <= within * total / 2.0 {
        return Err(SurfaceError::ZeroVolume { triangles: triangles.len(), at: centre, wall: suggested_wall(size) });
    }
    Ok(Piece { triangles, lo, hi, volume, point })
}

/// Is `p` inside the closed piece, whichever way that is wound?
fn encloses(mesh: &TriMesh, piece: &Piece, p: DVec3) -> bool {
    if !(piece.lo.cmple(p).all() && p.cmple(piece.hi).all()) {
        return false;
    }
    let half_angles: f64 = piece
        .triangles
        .iter()
        .map(|&t| {
            let [a, b, c] = mesh.corners(t as usize).map(|q| q - p);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let det = a.dot(b.cross(c));
            det.atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
        })
        .sum();
    // A full turn is 4π, and these are half angles.
    half_angles.abs() > std::f64::consts::PI
}
