//! A series as a plot.

use super::Series;
use crate::plot::{Curve, Figure, Panel};

/// Phases that have curves of their own.
const SHOWN: usize = 4;

impl Series {
    /// Energies, broken bonds, fragments and wall time over simulated time; a panel for what the series has.
    pub fn figure(&self, title: &str) -> Figure {
        let time = self.column("time").unwrap_or_default();
        let curve = |name: &str, colour: usize, values: &[f64]| Curve {
            name: name.replace('_', " "),
            colour,
            dots: false,
            points: time.iter().zip(values).map(|(t, y)| [*t, *y]).collect(),
        };
        let panel = |title: &str, y: &str, curves: Vec<Curve>| Panel {
            title: title.into(),
            x: "time [s]".into(),
            y: y.into(),
            equal: false,
            curves,
        };
        let named = |names: &[&'static str]| -> Vec<(&'static str, Vec<f64>)> {
            names.iter().filter_map(|name| Some((*name, self.column(name)?.to_vec()))).collect()
        };
        let mut panels = Vec::new();
        let mut energies = named(&["kinetic", "elastic", "gravity"]);
        if let Some((_, first)) = energies.last().filter(|(name, _)| *name == "gravity").cloned() {
            // only its changes mean anything, and those of the start would dwarf the rest
            let low = first.iter().copied().fold(f64::INFINITY, f64::min);
            energies.last_mut().expect("it is there").1.iter_mut().for_each(|y| *y -= low);
        }
        if !energies.is_empty() {
            let total = (0..time.len()).map(|k| energies.iter().map(|(_, y)| y[k]).sum());
            let total: Vec<f64> = total.collect();
            let mut curves = vec![curve("total", 0, &total)];
            curves.extend(energies.iter().enumerate().map(|(k, (name, y))| curve(name, 1 + k, y)));
            panels.push(panel("Energy (gravity above its least)", "energy [J]", curves));
        }
        let bonded = self.column("bonds").is_some_and(|bonds| bonds.iter().any(|&b| b > 0.0));
        for (name, title, y) in [
            ("broken", "Broken bonds", "bonds"),
            ("particles", "Nodes", "nodes"),
            ("fragments", "Fragments", "fragments"),
        ] {
            let shown = match name {
                "broken" => bonded,
                "particles" => self.column(name).is_some_and(|n| n.iter().any(|&k| k != n[0])),
                _ => true,
            };
            if let (true, Some(values)) = (shown, self.column(name)) {
                panels.push(panel(title, y, vec![curve("", 1, values)]));
            }
        }
        let phases = self.phases();
        let phases: Vec<Curve> = phases.iter().enumerate().map(|(k, (name, y))| curve(name, k, y)).collect();
        if !phases.is_empty() {
            panels.push(panel("Wall time of a frame", "time [s]", phases));
        }
        Figure { title: title.into(), panels }
    }
    /// Wall times of the phases that took most, and of all others together \[s\].
    fn phases(&self) -> Vec<(&str, Vec<f64>)> {
        let all = self.names.iter().zip(&self.columns);
        let mut phases: Vec<(&str, Vec<f64>)> =
            all.filter_map(|(name, s)| Some((name.strip_prefix("s_")?, s.clone()))).collect();
        let total = |seconds: &[f64]| seconds.iter().filter(|s| s.is_finite()).sum::<f64>();
        phases.retain(|(_, s)| total(s) > 0.0);
        phases.sort_by(|a, b| total(&b.1).total_cmp(&total(&a.1)));
        if phases.len() > SHOWN + 1 {
            let rest = phases.split_off(SHOWN);
            let sum = |k: usize| rest.iter().map(|(_, s)| s[k]).sum();
            phases.push(("all others", (0..rest[0].1.len()).map(sum).collect()));
        }
        phases
    }
}
