//! Ours against the references, as a plot.

use std::collections::BTreeMap;

use glam::DVec3;

use super::{Comparison, Item, MOVED, PLACE};
use crate::plot::{Curve, Figure, Panel};
use crate::scene::Reference;

/// Most dots of one curve over time.
const DOTS: usize = 60;

impl Comparison {
    /// A panel for each track, over time, and for each field, as it lies in space; none if the scene compares only numbers.
    pub fn figure(&self) -> Option<Figure> {
        let panels: Vec<Panel> = self.items.iter().filter_map(Item::panel).collect();
        (!panels.is_empty()).then(|| Figure { title: self.title.clone(), panels })
    }
}

impl Item {
    fn panel(&self) -> Option<Panel> {
        match self.kind {
            Reference::Track { .. } => Some(self.over_time()),
            Reference::Field { .. } => Some(self.in_space()),
            Reference::Number { .. } => None,
        }
    }

    fn over_time(&self) -> Panel {
        let mut curves = Vec::new();
        for axis in 0..3 {
            let theirs: Vec<[f64; 2]> = self.due.iter().map(|due| [due.time, due.reference[axis]]).collect();
            let ours: Vec<[f64; 2]> =
                self.due.iter().zip(&self.ours).map(|(due, ours)| [due.time, ours[axis]]).collect();
            let given = theirs.iter().any(|p| p[1].is_finite());
            if !given && self.due.iter().any(|due| !due.reference.is_nan_mask().all()) {
                continue;
            }
            let (name, colour) = (MOVED[axis], 1 + axis);
            if given {
                curves.push(Curve { name: format!("{name} reference"), colour, dots: false, points: theirs });
            }
            let points = ours.iter().step_by(ours.len().div_ceil(DOTS).max(1)).copied().collect();
            curves.push(Curve { name: format!("{name} ours"), colour, dots: true, points });
        }
        let (x, y) = ("time [s]".into(), "displacement [m]".into());
        Panel { title: self.label.clone(), x, y, equal: false, curves }
    }

    /// Deformed places, seen along the axis in which they spread least: lines through those of the reference that lie one
    /// behind the other along the body, dots for ours.
    fn in_space(&self) -> Panel {
        let shown = |u: DVec3| if u.is_nan() { DVec3::ZERO } else { u };
        let rest = spread(self.due.iter().map(|due| due.place));
        let seen = spread(self.due.iter().map(|due| due.place + shown(due.reference)));
        // in steps, so that like bodies are seen alike
        let hidden = (0..3).min_by_key(|&axis| (20.0 * seen[axis] / self.size).round() as i64).unwrap_or(1);
        let along = (0..3).max_by(|&a, &b| rest[a].total_cmp(&rest[b])).unwrap_or(0);
        let [h, v] = [[1, 2], [0, 2], [0, 1]][hidden];
        let project = |x: DVec3| [x[h], x[v]];
        // places in line along the body share their other coordinates
        let mut lines: BTreeMap<[i64; 2], Vec<[f64; 3]>> = BTreeMap::new();
        for due in &self.due {
            let key = [(along + 1) % 3, (along + 2) % 3].map(|c| (due.place[c] / (1e-4 * self.size)).round() as i64);
            let [x, y] = project(due.place + due.reference);
            lines.entry(key).or_default().push([due.place[along], x, y]);
        }
        let mut curves: Vec<Curve> = Vec::new();
        for mut line in lines.into_values() {
            line.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let points: Vec<[f64; 2]> = line.iter().map(|p| [p[1], p[2]]).collect();
            curves.push(Curve { name: String::new(), colour: 0, dots: points.len() == 1, points });
        }
        if let Some(first) = curves.first_mut() {
            first.name = "reference".into();
        }
        let points = self.due.iter().zip(&self.ours).map(|(due, ours)| project(due.place + *ours)).collect();
        curves.push(Curve { name: "ours".into(), colour: 1, dots: true, points });
        let name = |axis: usize| format!("{} [m]", PLACE[axis]);
        Panel { title: self.label.clone(), x: name(h), y: name(v), equal: true, curves }
    }
}

/// Edges of the box around points [m].
fn spread(points: impl Iterator<Item = DVec3>) -> DVec3 {
    let (low, high) = points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    high - low
}
