//! The phases of a step, and where the time goes.

use std::time::{Duration, Instant};

/// The phases of [`World::step`](crate::World::step), in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Deformation changes velocities.
    Respond,
    /// Particles and colliders push each other apart.
    Contact,
    /// Plastic memory flows.
    Flow,
    /// Bonds break.
    Fracture,
    /// Positions follow velocities.
    Integrate,
    /// Nodes of lattices split and merge.
    Adapt,
}

impl Phase {
    /// All phases in order.
    pub const ALL: [Phase; 6] =
        [Self::Respond, Self::Contact, Self::Flow, Self::Fracture, Self::Integrate, Self::Adapt];

    /// The word in logs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Respond => "respond",
            Self::Contact => "contact",
            Self::Flow => "flow",
            Self::Fracture => "fracture",
            Self::Integrate => "integrate",
            Self::Adapt => "adapt",
        }
    }
}

/// Time spent in each phase since the world was made.
#[derive(Clone, Copy, Debug, Default)]
pub struct Profile {
    spent: [Duration; Phase::ALL.len()],
}

impl Profile {
    /// Time spent in `phase`.
    pub fn spent(&self, phase: Phase) -> Duration {
        self.spent[phase as usize]
    }

    /// Time spent in all phases.
    pub fn total(&self) -> Duration {
        self.spent.iter().sum()
    }

    pub(crate) fn time<T>(&mut self, phase: Phase, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let out = work();
        self.spent[phase as usize] += start.elapsed();
        out
    }
}
