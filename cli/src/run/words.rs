//! What a run says of itself at its start and at its end.

use std::time::Duration;

use fissure_engine::{Collider, Kind, Motion, NodeCounts, Parameter, Phase, Reaction, Registry};
use fissure_io::scene::Chosen;
use serde_json::json;

use super::Outcome;
use super::driver::Driver;
use crate::Error;
use crate::info::called;
use crate::say::counted;

impl Driver {
    pub fn introduce(&mut self, notes: &[String], registry: &Registry) -> Result<(), Error> {
        let scene = &self.scene;
        self.log.say(&format!("{} ({}), into {}", called(scene), scene.file(), self.folder.dir().display()));
        notes.iter().for_each(|n| self.log.say(n));
        for k in 0..self.simulation.world.bodies.len() {
            let body = &self.simulation.world.bodies[k];
            let told = &self.scene.bodies[k];
            let bonds = body.material.bonds().map_or(0, |b| b.directed());
            let described = |law: &Chosen, criterion: &Chosen| {
                let entry = registry.entry(&law.name).map_err(|e| self.scene.blame(&body.name, &e))?;
                let known = entry.criteria.iter().find(|c| c.name == criterion.name);
                let (material, limits) = (chosen(law, entry.parameters), known.map_or(&[][..], |c| c.parameters));
                Ok::<_, Error>(format!("{material}; fracture {}", chosen(criterion, limits)))
            };
            let material = described(&told.law, &told.criterion)?;
            let (name, particles, spacing) = (&body.name, body.range.len(), body.spacing);
            let sentence = match body.material.nodes() {
                Some(nodes) => format!("body {name}: cells of {spacing:.3e} m in {}; {material}", in_words(&nodes)),
                None => format!(
                    "body {name}: {particles} particles, {bonds} directed bonds ({:.1} each), spacing {spacing:.3e} m, horizon \
                     {:.3e} m; {material}",
                    bonds as f64 / particles.max(1) as f64,
                    body.horizon
                ),
            };
            self.log.say(&sentence);
            for part in &told.parts {
                let density = part.density;
                let made = described(&part.law, &part.criterion)?;
                self.log.say(&format!("  region {}: {density} kg/m³, {made}", part.name));
            }
        }
        let world = &self.simulation.world;
        for c in world.colliders.iter() {
            self.log.say(&format!("collider {}", described(c)));
        }
        let c = &world.contact;
        let how = if world.relaxes().is_some() {
            "none while every step is an equilibrium".into()
        } else if c.between {
            format!("friction {}, restitution {}, stiffness {}", c.friction, c.restitution, c.stiffness)
        } else {
            "off".into()
        };
        self.log.say(&format!("contact between particles: {how}"));
        let dt = self.simulation.world.dt;
        let relax = self.simulation.world.relaxes();
        let how = match relax {
            _ if self.scene.dt.is_some() => "as given",
            Some(_) => "one a frame",
            None => "from the stable step",
        };
        let integrator = self.scene.integrator.name();
        self.log.say(&format!("{} steps of {dt:.3e} s ({how}), {integrator}", self.last));
        if let Some(relax) = relax {
            let sentence = format!(
                "every step is an equilibrium: unbalanced force below {:.1e} of the load, in at most {} iterations",
                relax.residual, relax.iterations
            );
            self.log.say(&sentence);
            return Ok(());
        }
        let stable = self.simulation.world.stable_dt();
        if dt > stable {
            self.log
                .say(&format!("warning: this is {:.1} times the longest stable step of {stable:.3e} s", dt / stable));
        }
        Ok(())
    }

    /// The closing lines.
    pub fn conclude(&mut self, outcome: Outcome, wall: Duration, steps: u64) {
        let (fragment, pieces) = self.simulation.fragments();
        let mut sizes = vec![0_u32; pieces];
        fragment.iter().for_each(|&f| sizes[f as usize] += 1);
        let largest = f64::from(sizes.into_iter().max().unwrap_or(0)) / fragment.len().max(1) as f64;
        let largest_too = if pieces > 1 { format!(", the largest of {:.1} %", 100.0 * largest) } else { String::new() };
        let world = &mut self.simulation.world;
        let reactions = if world.anchors.is_empty() { Vec::new() } else { world.reactions() };
        let (bonds, broken) = world.bond_counts();
        let dir = self.folder.dir().display().to_string();
        let (seconds, n) = (wall.as_secs_f64(), steps.max(1) as f64);
        let per_bond = world.profile.total().as_secs_f64() / n / bonds.max(1) as f64 * 1e9;
        let how = match outcome {
            Outcome::Finished => format!("finished at step {}, time {:.6} s", world.step, world.time),
            Outcome::Stopped => {
                format!("stopped at step {}, time {:.6} s; go on with `fissure resume {dir}`", world.step, world.time)
            }
        };
        let mut parts: Vec<(String, Duration)> =
            Phase::ALL.iter().map(|&p| (p.name().to_string(), world.profile.spent(p))).collect();
        let spent = &self.spent;
        parts.push(("surface".into(), spent.surface));
        parts.push(("frames".into(), spent.frames));
        parts.push(("checkpoints".into(), spent.checkpoints));
        parts.push(("picture".into(), spent.picture));
        let share = |d: Duration| 100.0 * d.as_secs_f64() / seconds.max(1e-9);
        let shares: Vec<String> =
            parts.iter().filter(|p| share(p.1) >= 0.05).map(|p| format!("{} {:.1} %", p.0, share(p.1))).collect();
        let event = json!({
            "event": "end", "outcome": format!("{outcome:?}").to_lowercase(), "step": world.step, "time": world.time,
            "seconds": seconds, "ns_per_bond": per_bond, "bonds": bonds / 2, "broken": broken / 2, "fragments": pieces,
            "largest_fragment": largest, "reactions": reactions.iter().map(told).collect::<Vec<_>>(),
            "spent": parts.iter().map(|p| (p.0.clone(), p.1.as_secs_f64().into())).collect::<serde_json::Map<_, _>>(),
        });
        let (per_bond_too, of_bonds) = match bonds {
            0 => Default::default(),
            _ => (
                format!(", {per_bond:.2} ns per directed bond"),
                format!("{} of {} bonds broken, ", broken / 2, bonds / 2),
            ),
        };
        let mut lines = vec![
            how,
            format!("{steps} steps in {seconds:.1} s, {:.3} ms a step{per_bond_too}", 1e3 * seconds / n),
            format!("time: {}", shares.join(", ")),
            format!("{of_bonds}{}{largest_too}", counted(pieces, "fragment")),
        ];
        lines.extend(reactions.iter().map(sentence));
        self.log.close(&lines.join("\n"), &event);
    }
}

/// How far a lattice is resolved: `231 nodes (200 + 31, the finest first)`.
pub(super) fn in_words(nodes: &NodeCounts) -> String {
    let levels: Vec<String> = nodes.levels.iter().map(usize::to_string).collect();
    let levels = if levels.len() > 1 { format!(" ({}, the finest first)", levels.join(" + ")) } else { String::new() };
    format!("{}{levels}", counted(nodes.nodes(), "node"))
}

/// A collider in words.
fn described(c: &Collider) -> String {
    let motion = match &c.motion {
        Motion::Fixed => "fixed".into(),
        Motion::Keyframes(frames) => format!("moved along {}", counted(frames.len(), "keyframe")),
        Motion::Free { mass, .. } => format!("free, {mass:.4e} kg"),
    };
    format!("{}: {}, {motion}, friction {}, restitution {}", c.name, c.shape.name(), c.friction, c.restitution)
}

/// What holding takes, for people.
fn sentence(r: &Reaction) -> String {
    let list = |v: glam::DVec3| v.to_array().map(|x| format!("{x:.4e}")).join(", ");
    let (force, torque, centre) = (list(r.force), list(r.torque), list(r.centre));
    format!("anchor {}: holding takes a force of ({force}) N and a torque of ({torque}) N m about ({centre})", r.anchor)
}

/// What holding takes, for programs.
fn told(r: &Reaction) -> serde_json::Value {
    let (force, torque, centre) = (r.force.to_array(), r.torque.to_array(), r.centre.to_array());
    json!({ "anchor": r.anchor, "force": force, "torque": torque, "about": centre })
}

/// A law or criterion with what the scene gives and what it leaves at its default.
fn chosen(chosen: &Chosen, parameters: &[Parameter]) -> String {
    let value = |p: &Parameter| match (chosen.given.iter().find(|g| g.key == p.name), p.kind) {
        (Some(given), _) => Some(format!("{} {}", p.name, given.value)),
        (None, Kind::NumberOr(_, default)) => Some(format!("{} {default}", p.name)),
        (None, Kind::Word(words)) => Some(format!("{} {}", p.name, words[0])),
        (None, _) => None,
    };
    let values: Vec<String> = parameters.iter().filter_map(value).collect();
    if values.is_empty() { chosen.name.clone() } else { format!("{} ({})", chosen.name, values.join(", ")) }
}
