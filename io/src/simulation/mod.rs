//! A scene that runs: the world, and the surface that is embedded in each body.
//!
//! ```text
//! build:   mesh → prepare → tetrahedra → order → families → world, crack mesh, skin     (build.rs)
//! restore: frozen.fis and a checkpoint → world, crack mesh, skin                         (restore.rs)
//! step:    world.step, then each body's cuts split its mesh
//! frame:   skins follow the particles, surfaces are put together                         (frame.rs)
//! ```

mod build;
mod colliders;
mod error;
mod frame;
mod regions;
mod restore;
mod solid;

use fissure_engine::{StepError, Visitor, World};
use fissure_meshing::crack::CrackMesh;
use fissure_meshing::skin::{Particles, Skin};
use glam::DVec3;

pub use build::Making;
pub use error::SimulationError;
pub use solid::{Fault, Solid, fill, solid};

use crate::checkpoint::Columns;

/// The mesh of a body, which its particles carry along.
pub struct Embedded {
    /// The tetrahedra, in the order of the body's particles.
    pub mesh: CrackMesh,
    /// Where its vertices are.
    pub skin: Skin,
    /// Rest positions of the particles in the world [m].
    rest: Vec<DVec3>,
    /// The last cuts as pairs; scratch.
    links: Vec<(u32, u32)>,
}

/// A world with its embedded meshes.
pub struct Simulation {
    /// Particles, bodies and the step.
    pub world: World,
    /// One mesh per body, in the same order.
    pub meshes: Vec<Embedded>,
}

impl Simulation {
    /// One step of the world; then meshes split where bonds between face neighbours broke. Returns how many vertices
    /// are new.
    ///
    /// # Errors
    /// See [`World::step`].
    pub fn step(&mut self) -> Result<usize, StepError> {
        let done = self.world.step();
        let mut new = 0;
        for (body, embedded) in self.world.bodies.iter().zip(&mut self.meshes) {
            if body.cuts.is_empty() {
                continue;
            }
            embedded.links.clear();
            embedded.links.extend(body.cuts.iter().map(|l| (l.i, l.j)));
            let copies = embedded.mesh.cut(&embedded.links);
            if copies > 0 {
                let p = self.world.particles.of(&body.range);
                let particles =
                    Particles { rest: &embedded.rest, position: p.position, velocity: p.velocity, mass: p.mass };
                embedded.skin.split(&embedded.mesh, &particles);
            }
            new += copies;
        }
        done.map(|()| new)
    }

    /// Moves the vertices of mesh `k` to where the particles are. Skins remember rotations, so when this is done is part of
    /// a run; checkpoints keep that.
    pub(crate) fn follow(&mut self, k: usize) {
        let (embedded, p) = (&mut self.meshes[k], self.world.particles.of(&self.world.bodies[k].range));
        let particles = Particles { rest: &embedded.rest, position: p.position, velocity: p.velocity, mass: p.mass };
        embedded.skin.update(&embedded.mesh, &particles);
    }

    /// Fragment of each particle's tetrahedron, numbered through all bodies, and how many there are.
    pub fn fragments(&self) -> (Vec<u32>, usize) {
        let (mut all, mut total) = (Vec::new(), 0);
        for embedded in &self.meshes {
            let (pieces, count) = embedded.mesh.fragments();
            all.extend(pieces.iter().map(|p| p + total as u32));
            total += count;
        }
        (all, total)
    }
}

impl Columns for Simulation {
    fn visit(&mut self, v: &mut Visitor<'_>) {
        self.world.visit(v);
        for (body, embedded) in self.world.bodies.iter().zip(&mut self.meshes) {
            embedded.mesh.visit(&format!("bodies/{}/mesh", body.name), v);
            embedded.skin.visit(&format!("bodies/{}/skin", body.name), v);
        }
    }
}
