//! Bodies of cells for the tests.

use fissure_engine::lattice::{Cells, NEIGHBOURS, morton};
pub use fissure_engine::noise::noise;
use fissure_engine::world::BodyInput;
use fissure_engine::{Surroundings, Value, World};
use glam::{DMat3, DVec3};

/// A vector of noise.
pub fn vector(k: usize, seed: u64) -> DVec3 {
    let k = 3 * k as u64 + (seed << 32);
    DVec3::new(noise(k), noise(k + 1), noise(k + 2))
}

/// A solid of cells of 0.1 m.
pub struct Solid {
    pub index: Vec<[u32; 3]>,
    /// Whether cells are filled by different shares, with their centres of mass off the middle.
    pub partial: bool,
}

pub const SIZE: f64 = 0.1;

impl Solid {
    /// The cells of a box in which `inside` is true.
    pub fn new([nx, ny, nz]: [u32; 3], inside: impl Fn([u32; 3]) -> bool) -> Self {
        let all = (0..nx * ny * nz).map(|k| [k % nx, k / nx % ny, k / nx / ny]);
        let mut index: Vec<[u32; 3]> = all.filter(|&i| inside(i)).collect();
        index.sort_unstable_by_key(|&i| morton(i));
        Self { index, partial: false }
    }

    pub fn block(size: [u32; 3]) -> Self {
        Self::new(size, |_| true)
    }

    /// An ellipsoid that fills a box.
    pub fn ellipsoid(size: [u32; 3]) -> Self {
        Self::new(size, |i| {
            (0..3).map(|a| ((f64::from(i[a]) + 0.5) / f64::from(size[a]) * 2.0 - 1.0).powi(2)).sum::<f64>() <= 1.0
        })
    }

    pub fn partial(self) -> Self {
        Self { partial: true, ..self }
    }

    /// All present neighbours are linked, but for pairs that `cut` names.
    pub fn cells(&self, cut: impl Fn([u32; 3], [u32; 3]) -> bool) -> Cells {
        let mut cells = Cells { size: SIZE, origin: DVec3::ZERO, index: self.index.clone(), links: vec![] };
        let links = |i: &[u32; 3]| {
            let linked = |bit: &usize| Cells::across(*i, *bit).is_some_and(|to| cells.at(to).is_some() && !cut(*i, to));
            (0..NEIGHBOURS.len()).filter(linked).map(|bit| 1 << bit).sum::<u32>()
        };
        cells.links = self.index.iter().map(links).collect();
        cells
    }

    /// A world with this body alone, at rest, without gravity; dt = 0.01 s.
    pub fn world(&self, given: &[(&str, Value)]) -> World {
        self.world_of(given, self.cells(|_, _| false))
    }

    pub fn world_of(&self, given: &[(&str, Value)], cells: Cells) -> World {
        let mut world = World::default();
        world.dt = 0.01;
        self.add(&mut world, "body", given, cells, DVec3::ZERO);
        world
    }

    /// Adds the body to a world, with its box's corner at `place`.
    pub fn add(&self, world: &mut World, name: &str, given: &[(&str, Value)], cells: Cells, place: DVec3) {
        let middle =
            |i: &[u32; 3]| (DVec3::new(f64::from(i[0]), f64::from(i[1]), f64::from(i[2])) + 0.5) * SIZE + place;
        let off = |k: usize| if self.partial { vector(k, 3) * (0.2 * SIZE) } else { DVec3::ZERO };
        let points: Vec<DVec3> = self.index.iter().enumerate().map(|(k, i)| middle(i) + off(k)).collect();
        let fill = |k: usize| if self.partial { 0.6 + 0.39 * noise(k as u64) } else { 1.0 };
        let volumes: Vec<f64> = (0..points.len()).map(|k| SIZE.powi(3) * fill(k)).collect();
        let (mut law, mut breaks) = (Vec::new(), Vec::new());
        for (key, value) in given {
            let list = if *key == "critical_stretch" { &mut breaks } else { &mut law };
            list.push((key.to_string(), value.clone()));
        }
        let criterion = if breaks.is_empty() { "none" } else { "critical_stretch" };
        let at = Surroundings { horizon: SIZE, spacing: SIZE };
        let made = fissure_materials::registry().make(("lattice", law), (criterion, breaks), &at);
        let input = BodyInput {
            name,
            points: &points,
            volumes: &volumes,
            ids: &(0..points.len() as u32).collect::<Vec<_>>(),
            density: 1000.0,
            spacing: SIZE,
            horizon: SIZE,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
            neighbourhood: cells.into(),
        };
        world.add(input, made.expect("valid parameters")).expect("a lattice");
    }
}

pub fn number(x: f64) -> Value {
    Value::Number(x)
}

pub fn word(w: &str) -> Value {
    Value::Word(w.into())
}

/// What the body's goals do to velocities in a step of `h` [s].
pub fn response(world: &mut World, h: f64) -> Vec<DVec3> {
    let body = &mut world.bodies[0];
    let mut dv = vec![DVec3::ZERO; body.range.len()];
    body.material.respond(&world.particles.of(&body.range), h, &mut dv);
    dv
}

/// Deforms, turns and shakes the body.
pub fn shake(world: &mut World, strain: f64, turn: DMat3, noise: f64) {
    let bend = |x: DVec3| {
        DVec3::new(x.x * (1.0 + strain) + strain * x.y * x.y, x.y + strain * x.z, x.z * (1.0 - 0.3 * strain))
    };
    for i in 0..world.particles.len() {
        let x = world.particles.rest[i].as_dvec3();
        world.particles.position[i] = turn * (bend(x) + vector(i, 9) * (noise * SIZE)) + DVec3::new(7.0, -3.0, 2.0);
        world.particles.velocity[i] = turn * (vector(i, 11) * noise + DVec3::new(1.0, 2.0, -1.0));
    }
}

/// Linear and angular momentum, and a size to measure both by.
pub fn momenta(world: &World) -> (DVec3, DVec3, f64) {
    let p = &world.particles;
    let linear = (0..p.len()).map(|i| p.velocity[i] * p.mass[i]).sum();
    let angular = (0..p.len()).map(|i| p.position[i].cross(p.velocity[i]) * p.mass[i]).sum();
    (linear, angular, (0..p.len()).map(|i| p.velocity[i].length() * p.mass[i]).sum())
}

/// All columns of a world: scope/name and bytes.
pub fn columns(world: &mut World) -> Vec<(String, Vec<u8>)> {
    let mut out = Vec::new();
    world.visit(&mut |scope, column, data| out.push((format!("{scope}/{}", column.name), data.bytes().to_vec())));
    out
}

pub const METHODS: [&str; 5] = ["ohta", "lsm", "single", "clustered", "steinemann"];
