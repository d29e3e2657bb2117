//! The particles of all bodies, one column per quantity; a body is a range of particles.

use std::ops::Range;

use glam::{DVec3, Vec3};

use crate::buffer::Buffer;
use crate::column::{Column, Life, Of, Visitor};

/// Structure of arrays: element `i` of every column belongs to particle `i`.
#[derive(Clone, Debug, Default)]
pub struct Particles {
    /// Rest position x relative to its body's origin [m]. Exactly an f32, so that a rest bond ξ is the same number in
    /// f32 and f64 arithmetic.
    pub rest: Buffer<Vec3>,
    /// Current position y in the world [m].
    pub position: Buffer<DVec3>,
    /// Velocity [m/s].
    pub velocity: Buffer<DVec3>,
    /// Rest volume V [m³].
    pub volume: Buffer<f64>,
    /// Mass [kg].
    pub mass: Buffer<f64>,
    /// Damage φ = 1 − n/N [1] (Eq. 19): the share of broken bonds.
    pub damage: Buffer<f32>,
    /// Number of the particle in its body's input.
    pub id: Buffer<u32>,
}

impl Particles {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.rest.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// The columns of one body.
    pub fn of(&self, range: &Range<usize>) -> BodyParticles<'_> {
        let r = || range.clone();
        BodyParticles {
            rest: &self.rest[r()],
            position: &self.position[r()],
            velocity: &self.velocity[r()],
            volume: &self.volume[r()],
            mass: &self.mass[r()],
        }
    }

    /// Shows every column; `life` is that of what changes only where particles split and merge.
    pub fn visit(&mut self, life: Life, v: &mut Visitor<'_>) {
        const SCOPE: &str = "particles";
        let matter = |name, unit| Column { life, ..Column::live(name, unit, Of::Particle) };
        v(SCOPE, &matter("rest", "m"), &mut self.rest);
        v(SCOPE, &Column::live("position", "m", Of::Particle), &mut self.position);
        v(SCOPE, &Column::live("velocity", "m/s", Of::Particle), &mut self.velocity);
        v(SCOPE, &matter("volume", "m^3"), &mut self.volume);
        v(SCOPE, &matter("mass", "kg"), &mut self.mass);
        v(SCOPE, &Column::live("damage", "1", Of::Particle), &mut self.damage);
        v(SCOPE, &matter("id", "1"), &mut self.id);
    }
}

/// What a material sees of its body's particles; indices count from the body's first.
#[derive(Clone, Copy, Debug)]
pub struct BodyParticles<'a> {
    /// Rest positions [m], relative to the body's origin.
    pub rest: &'a [Vec3],
    /// Current positions [m].
    pub position: &'a [DVec3],
    /// Velocities [m/s].
    pub velocity: &'a [DVec3],
    /// Rest volumes [m³].
    pub volume: &'a [f64],
    /// Masses [kg].
    pub mass: &'a [f64],
}

impl BodyParticles<'_> {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.rest.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }
}
