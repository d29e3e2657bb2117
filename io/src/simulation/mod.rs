//! A scene that runs: the world, and the surface that is embedded in each body.
//!
//! ```text
//! build:   mesh → prepare → tetrahedra → order → families → world, crack mesh, skin     (build.rs)
//! restore: frozen.fis and a checkpoint → world, crack mesh, skin                         (restore.rs)
//!          mesh → prepare → cells and facets → world, follower                           (for lattices)
//! step:    world.step, then each body's cuts split its mesh
//! frame:   skins follow the particles, surfaces are put together                         (frame.rs)
//! ```

mod build;
mod colliders;
mod embedded;
mod error;
mod frame;
mod pieces;
mod regions;
mod restore;
mod solid;

use fissure_engine::{StepError, Visitor, World};

pub use build::Making;
pub use embedded::{Cells, Embedded, Tets};
pub use error::SimulationError;
pub use solid::{Fault, Solid, fill, solid};

use self::pieces::Pieces;
use crate::checkpoint::Columns;

/// A world with its embedded meshes.
pub struct Simulation {
    /// Particles, bodies and the step.
    pub world: World,
    /// One surface per body, in the same order.
    pub meshes: Vec<Embedded>,
    /// The fragments as of the last frame, under ids that last.
    pieces: Pieces,
}

impl Simulation {
    /// One step of the world; then meshes split where bonds between face neighbours broke. Returns how many vertices, or
    /// triangles of a lattice, are new.
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
            new += embedded.cut(body, &self.world.particles);
        }
        done.map(|()| new)
    }

    /// Moves the vertices of body `k` to where its particles are. Skins of tetrahedra remember rotations, so when this is done is part of
    /// a run; checkpoints keep that.
    pub(crate) fn follow(&mut self, k: usize) {
        self.meshes[k].follow(&mut self.world.bodies[k], &self.world.particles);
    }

    /// Fragment of each particle's tetrahedron, or of each finest cell of a lattice, numbered through all bodies, and how many there are.
    pub fn fragments(&self) -> (Vec<u32>, usize) {
        let (mut all, mut total) = (Vec::new(), 0);
        for embedded in &self.meshes {
            let (pieces, count) = embedded.fragments();
            all.extend(pieces.iter().map(|p| p + total as u32));
            total += count;
        }
        (all, total)
    }
}

impl Columns for Simulation {
    fn visit(&mut self, v: &mut Visitor<'_>) {
        Nameless(self).visit(v);
        self.pieces.visit(self.world.bodies.iter().map(|b| b.name.as_str()), v);
    }
}

/// A simulation without the ids of fragments, as older checkpoints have it.
struct Nameless<'s>(&'s mut Simulation);

impl Columns for Nameless<'_> {
    fn visit(&mut self, v: &mut Visitor<'_>) {
        let Simulation { world, meshes, .. } = &mut *self.0;
        world.visit(v);
        for (body, embedded) in world.bodies.iter().zip(meshes) {
            embedded.visit(&body.name, v);
        }
    }
}
