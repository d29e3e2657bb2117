//! Plastic rest shapes of regions: Sᵖ, which flows to the present stretch beyond a yield strain (Müller et al. 2005, Sec. 4.5).

use fissure_engine::{Buffer, Column, Of, Visitor};
use glam::{DMat3, DVec3};

use super::params::Plastic;

/// Sᵖ of each region by columns; empty where nothing flows.
#[derive(Debug, Default)]
pub struct Shapes([Buffer<DVec3>; 3]);

impl Shapes {
    /// Number of regions.
    pub fn len(&self) -> usize {
        self.0[0].len()
    }

    /// Sᵖ of a region.
    #[inline(always)]
    pub fn get(&self, region: usize) -> DMat3 {
        match self.len() {
            0 => DMat3::IDENTITY,
            _ => DMat3::from_cols(self.0[0][region], self.0[1][region], self.0[2][region]),
        }
    }

    /// Replaces all.
    pub fn set(&mut self, shapes: impl Iterator<Item = DMat3> + Clone) {
        for (k, column) in self.0.iter_mut().enumerate() {
            column.set(shapes.clone().map(|s| s.col(k)).collect());
        }
    }

    /// Lets the shape of a region with stretch S flow for `h` [s].
    pub fn flow(&mut self, region: usize, stretch: DMat3, told: Plastic, h: f64) {
        let strain = (stretch + stretch.transpose()) * 0.5 - DMat3::IDENTITY;
        if norm(strain) <= told.threshold {
            return;
        }
        let share = -f64::exp_m1(-told.creep * h);
        let flowed = (DMat3::IDENTITY + strain * share) * self.get(region);
        let size = flowed.determinant();
        if size <= 0.0 || !size.is_finite() {
            return;
        }
        let flowed = flowed * size.cbrt().recip();
        let far = norm(flowed - DMat3::IDENTITY);
        let kept =
            if far > told.cap { DMat3::IDENTITY + (flowed - DMat3::IDENTITY) * (told.cap / far) } else { flowed };
        (0..3).for_each(|k| self.0[k][region] = kept.col(k));
    }

    /// Whether every shape is one.
    pub fn consistent(&self, regions: usize) -> bool {
        self.0.iter().all(|c| c.len() == regions && c.iter().all(|x| x.is_finite()))
            && (0..regions).all(|r| self.get(r).determinant() > 0.0)
    }

    /// Shows every column.
    pub fn visit(&mut self, scope: &str, v: &mut Visitor<'_>) {
        for (column, name) in self.0.iter_mut().zip(["rest_shape_x", "rest_shape_y", "rest_shape_z"]) {
            v(scope, &Column::live(name, "1", Of::Thing), column);
        }
    }
}

/// ‖m‖ by Frobenius.
fn norm(m: DMat3) -> f64 {
    (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_flow_beyond_yield_and_keep_their_volume() {
        let told = Plastic { threshold: 0.1, creep: 100.0, cap: 0.5 };
        let mut shapes = Shapes::default();
        shapes.set(std::iter::once(DMat3::IDENTITY));
        shapes.flow(0, DMat3::from_diagonal(DVec3::new(1.05, 1.0, 1.0)), told, 0.01);
        assert_eq!(shapes.get(0), DMat3::IDENTITY);
        for _ in 0..50 {
            shapes.flow(0, DMat3::from_diagonal(DVec3::new(1.3, 0.9, 0.9)), told, 0.01);
            assert!(norm(shapes.get(0) - DMat3::IDENTITY) < 0.5 + 1e-12);
        }
        assert!(shapes.get(0).x_axis.x > 1.3, "{}", shapes.get(0));
        assert!(shapes.consistent(1) && !shapes.consistent(2));
    }
}
