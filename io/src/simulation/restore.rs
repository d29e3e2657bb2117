//! From the files of a run back to a simulation.

use fissure_engine::registry::Wants;
use fissure_engine::{Body, Collider, Registry, Surroundings, World};
use glam::DVec3;

use super::build::{follow, set_contact, wants};
use super::colliders::colliders;
use super::pieces::{self, Pieces};
use super::{Cells, Embedded, Nameless, Simulation, SimulationError, Tets};
use crate::checkpoint::Latest;
use crate::scene::Scene;

impl Simulation {
    /// The simulation of `scene` as the checkpoint `latest` has it. Neither meshes nor families are made again: frozen
    /// columns are mapped shared, the others copy-on-write.
    ///
    /// # Errors
    /// Files that do not belong to this scene, or are damaged.
    pub fn restore(scene: &Scene, registry: &Registry, latest: &Latest) -> Result<Self, SimulationError> {
        scene.check(registry)?;
        let mut simulation = Self { world: World::default(), meshes: Vec::new(), pieces: Pieces::default() };
        for body in &scene.bodies {
            let lengths = latest.frozen.column::<f64>(&format!("bodies/{}", body.name), "spacing_and_horizon")?;
            let &[spacing, horizon] = lengths else {
                return Err(SimulationError::Whole {
                    file: latest.frozen.path().display().to_string(),
                    message: format!("body `{}` has no spacing and horizon; this is no file of this scene", body.name),
                });
            };
            let at = Surroundings { horizon, spacing };
            let material = super::regions::material(scene, body, registry, Vec::new(), &at)?;
            simulation.world.bodies.push(Body {
                name: body.name.clone(),
                range: 0..0,
                origin: DVec3::ZERO,
                spacing,
                horizon,
                material,
                cuts: Vec::new(),
            });
            simulation.meshes.push(match wants(scene, registry, body)? {
                Wants::Bonds => Embedded::Tets(Tets::empty(follow(body))),
                Wants::Cells => Embedded::Cells(Cells::default()),
            });
        }
        simulation.world.anchors = scene.anchors.iter().map(super::build::anchor).collect();
        simulation.world.integrator = scene.integrator;
        simulation.world.gravity = scene.gravity;
        simulation.world.colliders = colliders(scene, false)?;
        set_contact(scene, &mut simulation.world);
        if latest.live.find(pieces::SCOPE, pieces::NEXT).is_ok() {
            simulation.pieces = Pieces::new(vec![0; scene.bodies.len()]);
            latest.live.restore(&mut simulation, &latest.frozen)?;
        } else {
            latest.live.restore(&mut Nameless(&mut simulation), &latest.frozen)?;
            simulation.pieces = Pieces::new(simulation.meshes.iter().map(Embedded::cells_or_tets));
        }
        simulation.check(latest)?;
        simulation.world.colliders.iter_mut().for_each(Collider::prepare);
        let Simulation { world, meshes, .. } = &mut simulation;
        for (body, embedded) in world.bodies.iter_mut().zip(meshes) {
            if !embedded.restored(body, &world.particles) {
                let message = format!(
                    "body `{}` has other cells than its surface; the file was not written by this program",
                    body.name
                );
                return Err(SimulationError::Whole { file: latest.live.path().display().to_string(), message });
            }
            // the count of each family is a column of its own, which may lie
            body.cuts.reserve(body.material.bonds().map_or(0, |b| (b.directed() as usize).min(b.neighbours.len()) / 2));
        }
        Ok(simulation)
    }

    /// Lengths and ranges that the engine indexes by: a file with right checksums may still lie about them.
    fn check(&self, latest: &Latest) -> Result<(), SimulationError> {
        let bad = |what: String| {
            let message = format!("{what}; the file was not written by this program");
            SimulationError::Whole { file: latest.live.path().display().to_string(), message }
        };
        let p = &self.world.particles;
        let n = p.len();
        let lengths = [p.position.len(), p.velocity.len(), p.volume.len(), p.mass.len(), p.damage.len(), p.id.len()];
        if lengths.iter().any(|&l| l != n) {
            return Err(bad("columns of particles differ in length".into()));
        }
        let mut next = 0;
        for (body, embedded) in self.world.bodies.iter().zip(&self.meshes) {
            if body.range.start != next || body.range.end < next || body.range.end > n {
                return Err(bad(format!("body `{}` has an impossible range of particles", body.name)));
            }
            next = body.range.end;
            // asked of the file and not of the map, whose pages nobody needs yet
            let neighbours = || latest.frozen.largest(&format!("bodies/{}/bonds", body.name), "neighbours");
            let known = body.material.bonds().is_none_or(|b| b.neighbours.is_empty());
            let known = known || neighbours()? < body.range.len() as u32;
            if !known || !body.material.consistent(body.range.len()) {
                return Err(bad(format!("the bonds of body `{}` contradict each other", body.name)));
            }
            if !embedded.consistent(body) {
                return Err(bad(format!("the surface of body `{}` contradicts itself", body.name)));
            }
        }
        if !self.pieces.consistent(&self.meshes) {
            return Err(bad("the ids of fragments contradict the bodies".into()));
        }
        for collider in &self.world.colliders {
            if !collider.consistent() {
                return Err(bad(format!("collider `{}` contradicts itself", collider.name)));
            }
        }
        for anchor in &self.world.anchors {
            if anchor.start.len() != anchor.particles.len() || anchor.particles.iter().any(|&i| i as usize >= n) {
                return Err(bad(format!("anchor `{}` holds particles that do not exist", anchor.name)));
            }
        }
        Ok(())
    }
}
