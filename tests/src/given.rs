//! Bodies whose particles and law are given number by number, as the reference of a test has them.

use fissure_engine::{BodyInput, Families, Surroundings, Value, World};
use glam::{DMat3, DVec3};

use crate::naive_families;

/// A law or criterion with its parameters.
pub type Spec<'a> = (&'a str, &'a [(&'a str, Value)]);

/// A body of equal particles.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a> {
    /// Rest positions [m].
    pub points: &'a [DVec3],
    /// Volume of each [m³].
    pub volume: f64,
    /// Density [kg/m³].
    pub density: f64,
    /// Spacing [m].
    pub spacing: f64,
    /// Horizon δ [m], inclusive.
    pub horizon: f64,
    /// The law.
    pub law: Spec<'a>,
    /// The fracture criterion; `("none", &[])` for none.
    pub criterion: Spec<'a>,
}

impl Given<'_> {
    /// A world with this body alone, at rest, with no gravity, and dt not set.
    pub fn world(&self) -> World {
        self.world_of(naive_families(self.points, self.horizon))
    }

    /// As [`world`](Self::world), with these families.
    pub fn world_of(&self, families: Families) -> World {
        let own = |pairs: &[(&str, Value)]| pairs.iter().map(|(k, v)| (k.to_string(), v.clone())).collect::<Vec<_>>();
        let at = Surroundings { horizon: self.horizon, spacing: self.spacing };
        let material = fissure_materials::registry()
            .make((self.law.0, own(self.law.1)), (self.criterion.0, own(self.criterion.1)), &at)
            .expect("the test's parameters are valid");
        let input = BodyInput {
            name: "body",
            points: self.points,
            volumes: &vec![self.volume; self.points.len()],
            ids: &(0..self.points.len() as u32).collect::<Vec<_>>(),
            density: self.density,
            spacing: self.spacing,
            horizon: self.horizon,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
            neighbourhood: families.into(),
        };
        let mut world = World::default();
        world.add(input, material).expect("volumes are positive");
        world
    }
}

/// `cells` particles at distance `spacing` [m] along each axis, around the origin; x slowest.
pub fn lattice(cells: [usize; 3], spacing: f64) -> Vec<DVec3> {
    let [_, ny, nz] = cells;
    let middle = DVec3::from(cells.map(|n| (n as f64 - 1.0) / 2.0));
    let cell = |k: usize| DVec3::new((k / (ny * nz)) as f64, (k / nz % ny) as f64, (k % nz) as f64);
    (0..cells.iter().product()).map(|k| (cell(k) - middle) * spacing).collect()
}

/// Moves every particle to F times its rest position.
pub fn deform(world: &mut World, f: DMat3) {
    for i in 0..world.particles.len() {
        world.particles.position[i] = f * world.particles.rest[i].as_dvec3();
    }
}

/// Force density [N/m³] on every particle, in all-f64 arithmetic.
pub fn reference_forces(world: &World) -> Vec<DVec3> {
    let p = world.particles.of(&(0..world.particles.len()));
    world.bodies[0].material.reference_forces(&p).expect("bond laws have a reference")
}

/// Force density [N/m³] on every particle, as a step computes it.
pub fn lane_forces(world: &mut World) -> Vec<DVec3> {
    let p = world.particles.of(&(0..world.particles.len()));
    let mut dv = vec![DVec3::ZERO; p.len()];
    world.bodies[0].material.respond(&p, 1e-9, &mut dv);
    (0..p.len()).map(|i| dv[i] * (p.mass[i] / (p.volume[i] * 1e-9))).collect()
}

/// Force [N] with which the particles at rest x > 0 pull on those at x < 0.
pub fn pull_through_middle(world: &World) -> DVec3 {
    let p = &world.particles;
    let force = reference_forces(world);
    (0..p.len()).filter(|&i| p.rest[i].x < 0.0).map(|i| force[i] * p.volume[i]).sum()
}

/// The largest distance of two fields, relative to the longest of `want`.
pub fn relative_error(got: &[DVec3], want: &[DVec3]) -> f64 {
    let longest = want.iter().map(|v| v.length()).fold(0.0, f64::max);
    got.iter().zip(want).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max) / longest
}

/// The rows of a table of numbers with one line of headings.
pub fn table(csv: &str) -> Vec<Vec<f64>> {
    let number = |x: &str| x.parse().expect("a table of numbers");
    csv.lines().skip(1).map(|line| line.split(',').map(number).collect()).collect()
}
