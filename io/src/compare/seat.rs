//! A place in a body, carried along by the tetrahedron that it is in.

use fissure_meshing::crack::CrackMesh;
use glam::{DMat3, DVec3};

/// How far outside the nearest tetrahedron a place may lie, in heights of that: a mesh follows a curved surface only nearly.
const OUTSIDE: f64 = 1.0;

/// A tetrahedron and barycentric coordinates in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seat {
    tet: usize,
    shares: [f64; 4],
}

impl Seat {
    /// The seats of `places` [m] in the mesh at rest.
    ///
    /// # Errors
    /// The first place that is outside.
    pub(super) fn find(mesh: &CrackMesh, places: &[DVec3]) -> Result<Vec<Self>, DVec3> {
        let lowest = |shares: [f64; 4]| shares.into_iter().fold(f64::INFINITY, f64::min);
        let nowhere = Self { tet: 0, shares: [f64::NEG_INFINITY; 4] };
        let mut best = vec![nowhere; places.len()];
        for (tet, corners) in mesh.tets().iter().enumerate() {
            let [a, b, c, d] = corners.map(|v| mesh.rest_position(v));
            let inverse = DMat3::from_cols(b - a, c - a, d - a).inverse();
            for (seat, place) in best.iter_mut().zip(places) {
                let s = inverse * (*place - a);
                let shares = [1.0 - s.x - s.y - s.z, s.x, s.y, s.z];
                if lowest(shares) > lowest(seat.shares) {
                    *seat = Self { tet, shares };
                }
            }
        }
        match best.iter().position(|seat| lowest(seat.shares) < -OUTSIDE) {
            Some(k) => Err(places[k]),
            None => Ok(best),
        }
    }

    /// How far the place has moved [m] when the vertices of the mesh are at `positions` [m].
    pub(super) fn displacement(&self, mesh: &CrackMesh, positions: &[DVec3]) -> DVec3 {
        let corners = mesh.tets()[self.tet];
        corners.iter().zip(self.shares).map(|(&v, s)| (positions[v as usize] - mesh.rest_position(v)) * s).sum()
    }
}
