//! Angular momentum that something has taken from the nodes of a piece, given back as a rotation of the whole piece.

use glam::{DMat3, DVec3};

/// An inertia whose determinant is below this share of its cubed trace is that of a line: it cannot take every spin.
const LINE: f64 = 1e-9;

/// What each piece has lost, and what it takes to turn it.
#[derive(Clone, Debug, Default)]
pub struct Spins {
    mass: Vec<f64>,
    /// Centre of mass [m].
    centre: Vec<DVec3>,
    inertia: Vec<DMat3>,
    /// What was lost, then the rotation that gives it back.
    lost: Vec<DVec3>,
}

impl Spins {
    /// Nothing lost by pieces of nodes with piece, mass [kg] and position [m].
    pub fn reset(&mut self, pieces: usize, nodes: impl Iterator<Item = (usize, f64, DVec3)> + Clone) {
        let Self { mass, centre, inertia, lost } = self;
        fill(mass, pieces, 0.0);
        fill(centre, pieces, DVec3::ZERO);
        fill(inertia, pieces, DMat3::ZERO);
        fill(lost, pieces, DVec3::ZERO);
        for (piece, m, x) in nodes.clone() {
            mass[piece] += m;
            let off = x - centre[piece];
            centre[piece] += off * (m / mass[piece]);
        }
        for (piece, m, x) in nodes {
            let r = x - centre[piece];
            let along = DMat3::from_cols(r * r.x, r * r.y, r * r.z);
            inertia[piece] += (DMat3::from_diagonal(DVec3::splat(r.length_squared())) - along) * m;
        }
    }

    /// A node of mass `m` [kg] at `x` [m] no longer moves by `v`.
    pub fn lose(&mut self, piece: usize, m: f64, x: DVec3, v: DVec3) {
        self.lost[piece] += (x - self.centre[piece]).cross(v) * m;
    }

    /// It does now.
    pub fn gain(&mut self, piece: usize, m: f64, x: DVec3, v: DVec3) {
        self.lose(piece, m, x, -v);
    }

    /// Finds how pieces turn.
    pub fn solve(&mut self) {
        for (inertia, lost) in self.inertia.iter().zip(&mut self.lost) {
            let size = inertia.x_axis.x + inertia.y_axis.y + inertia.z_axis.z;
            let solid = *lost != DVec3::ZERO && inertia.determinant() > LINE * size.powi(3);
            *lost = if solid { inertia.inverse() * *lost } else { DVec3::ZERO };
        }
    }

    /// After [`solve`](Self::solve): what is added at `x` to the motion of a piece.
    pub fn at(&self, piece: usize, x: DVec3) -> DVec3 {
        self.lost[piece].cross(x - self.centre[piece])
    }
}

fn fill<T: Clone>(column: &mut Vec<T>, n: usize, with: T) {
    column.clear();
    column.resize(n, with);
}
