//! The table of errors.

use glam::DVec3;

use super::{Comparison, Item};
use crate::scene::{Quantity, Reference};

/// A line of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Of what, with its unit in brackets.
    pub what: String,
    /// Our number; none where only an error is told.
    pub ours: Option<f64>,
    /// The reference's number; none likewise.
    pub reference: Option<f64>,
    /// The relative error, 0.01 for 1 %. Of numbers it has a sign; of positions it is relative to the diagonal of the
    /// body's box (Chen et al., Sec. 6), of the energy to the most that was kinetic and elastic at a time.
    pub error: f64,
}

impl Row {
    fn of(what: String, ours: f64, reference: f64) -> Self {
        Self { what, ours: Some(ours), reference: Some(reference), error: ours / reference - 1.0 }
    }

    fn error(what: String, error: f64) -> Self {
        Self { what, ours: None, reference: None, error }
    }
}

impl Comparison {
    /// The errors of what was sampled, in the order of the scene.
    pub fn table(&self) -> Vec<Row> {
        let mut rows: Vec<Row> = self.items.iter().flat_map(Item::rows).collect();
        let total = |e: &[f64; 4]| e[1] + e[2] + e[3];
        if let Some([first, rest @ ..]) = self.energies.as_deref() {
            let all = || rest.iter().chain([first]);
            let moved = all().map(|e| e[1] + e[2]).fold(0.0, f64::max);
            let drift = rest.iter().map(|e| (total(e) - total(first)).abs()).fold(0.0, f64::max);
            rows.push(Row::error("total energy, largest change".into(), drift / moved));
        }
        rows
    }
}

impl Item {
    fn rows(&self) -> Vec<Row> {
        let label = &self.label;
        if let Reference::Number { of, along, value, .. } = self.kind {
            let unit = match of {
                Quantity::Displacement { .. } => "m",
                Quantity::Force(_) => "N",
                Quantity::Torque(_) => "N m",
            };
            return self.ours.iter().map(|ours| Row::of(format!("{label} [{unit}]"), ours.dot(along), value)).collect();
        }
        // what both have; a component that the reference does not give says nothing
        let both: Vec<(f64, DVec3, DVec3)> = self
            .due
            .iter()
            .zip(&self.ours)
            .filter(|(due, ours)| !ours.is_nan() && !due.reference.is_nan_mask().all())
            .map(|(due, ours)| (due.time, known(due.reference, due.reference), known(*ours, due.reference)))
            .collect();
        if both.is_empty() {
            return Vec::new();
        }
        let apart = || both.iter().map(|(_, reference, ours)| ours.distance(*reference) / self.size);
        let mut rows = vec![
            Row::error(format!("{label}: position, largest"), apart().fold(0.0, f64::max)),
            Row::error(format!("{label}: position, mean"), apart().sum::<f64>() / both.len() as f64),
        ];
        if let Reference::Track { .. } = self.kind {
            let lengths = |of: fn(&(f64, DVec3, DVec3)) -> DVec3| both.iter().map(|row| of(row).length()).collect();
            let (reference, ours): (Vec<f64>, Vec<f64>) = (lengths(|row| row.1), lengths(|row| row.2));
            let largest = |lengths: &[f64]| lengths.iter().copied().fold(0.0, f64::max);
            let (far, theirs) = (largest(&ours), largest(&reference));
            rows.push(Row::of(format!("{label}: largest displacement [m]"), far, theirs));
            let (ours, reference) = (both[first_swing(&ours)].0, both[first_swing(&reference)].0);
            rows.push(Row::of(format!("{label}: time of the first swing [s]"), ours, reference));
        }
        rows
    }
}

/// A swing reaches so much of the largest displacement.
const SWING: f64 = 0.8;

/// Where `lengths` first turns back after coming near its largest: what swings on may be farthest in any of its swings, which
/// differ by less than two methods do.
fn first_swing(lengths: &[f64]) -> usize {
    let least = SWING * lengths.iter().copied().fold(0.0, f64::max);
    let turns = |k: &usize| lengths[*k] >= least && lengths.get(k + 1).is_none_or(|next| next < &lengths[*k]);
    (0..lengths.len()).find(turns).unwrap_or(0)
}

/// The components of `x` that `reference` has, 0 for the others.
fn known(x: DVec3, reference: DVec3) -> DVec3 {
    DVec3::select(reference.is_nan_mask(), DVec3::ZERO, x)
}
