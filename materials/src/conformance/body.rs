//! The body that laws are checked on: a jittered block, what is done to it, and what it answers.

pub(super) use fissure_engine::noise::noise;
use fissure_engine::world::BodyInput;
use fissure_engine::{Families, Registry, Surroundings, Value, World};
use glam::{DMat3, DVec3};

use super::example;
use super::report::Trouble;

/// Parameters as a scene gives them.
pub(super) type Given = Vec<(String, Value)>;

/// Mean distance of the particles [m].
pub(super) const SPACING: f64 = 0.1;
/// Horizon δ [m]: about 70 neighbours.
pub(super) const HORIZON: f64 = 2.6 * SPACING;
/// Particles along the edges of the usual block: more than one task's share, and no symmetry.
const EDGES: [usize; 3] = [7, 6, 5];

/// A law with parameters that it accepts.
pub(super) struct Subject<'a> {
    pub registry: &'a Registry,
    pub law: &'a str,
    pub given: Given,
    /// The criterion under which nothing should break: the first that is registered, `none` in general.
    pub calm: (String, Given),
    /// The others, with parameters or why none were found.
    pub breaking: Vec<(String, Result<Given, String>)>,
}

impl<'a> Subject<'a> {
    /// Finds what is not given.
    pub fn new(
        registry: &'a Registry,
        law: &'a str,
        given: &Given,
        criteria: &[(String, Given)],
    ) -> Result<Self, String> {
        let entry = registry.entry(law).map_err(|e| e.to_string())?;
        let at = Self::surroundings();
        let make = |law_values: &Given, criterion: &str, values: &Given| {
            let made = registry.make((law, law_values.clone()), (criterion, values.clone()), &at);
            made.map(drop).map_err(|e| e.to_string())
        };
        let of = |name: &str| criteria.iter().find(|(n, _)| n == name).map(|(_, g)| g.clone()).unwrap_or_default();
        let first = entry.criteria.iter().find(|c| c.name == "none").or(entry.criteria.first());
        let first = first.ok_or("it is registered without any fracture criterion, not even `none`")?;
        // a criterion wants its parameters before the law can be asked: the law's come first in the answer
        let calm = (first.name.to_string(), example::required(first.parameters, &of(first.name)));
        let given = example::find(entry.parameters, given, |g| make(g, &calm.0, &calm.1))?;
        let others = entry.criteria.iter().filter(|c| c.name != "none");
        let breaking =
            others.map(|c| (c.name.to_string(), example::find(c.parameters, &of(c.name), |g| make(&given, c.name, g))));
        let breaking = breaking.collect();
        Ok(Self { registry, law, given, calm, breaking })
    }

    /// What a law is told of the block.
    pub fn surroundings() -> Surroundings {
        Surroundings { horizon: HORIZON, spacing: SPACING }
    }

    /// The usual block, at rest, which does not break.
    pub fn world(&self) -> Result<World, Trouble> {
        self.block(EDGES, &self.given, &self.calm)
    }

    /// A block of `edges` particles with a law of these parameters and this criterion, at rest. Its dt is 0.4
    /// of what is stable.
    pub fn block(&self, edges: [usize; 3], law: &Given, criterion: &(String, Given)) -> Result<World, Trouble> {
        let [nx, ny, nz] = edges;
        let points: Vec<DVec3> = (0..nx * ny * nz)
            .map(|k| {
                let cell = DVec3::new((k / (ny * nz)) as f64, (k / nz % ny) as f64, (k % nz) as f64);
                (cell + vector(k, 1) * 0.25 + DVec3::new(3.0, -2.0, 5.0)) * SPACING
            })
            .collect();
        let families = families(&points);
        // volumes differ as those of a mesh do
        let volumes: Vec<f64> = (0..points.len()).map(|k| SPACING.powi(3) * (1.0 + 0.2 * noise(k as u64))).collect();
        let material =
            self.registry.make((self.law, law.clone()), (&criterion.0, criterion.1.clone()), &Self::surroundings())?;
        let input = BodyInput {
            name: "block",
            points: &points,
            volumes: &volumes,
            ids: &(0..points.len() as u32).collect::<Vec<_>>(),
            density: 1000.0,
            spacing: SPACING,
            horizon: HORIZON,
            velocity: DVec3::ZERO,
            spin: DVec3::ZERO,
            neighbourhood: families.into(),
        };
        let mut world = World::default();
        world.add(input, material)?;
        let stable = world.stable_dt();
        world.dt = if stable.is_finite() && stable > 0.0 { 0.4 * stable } else { 1e-3 };
        Ok(world)
    }
}

/// The parameters as in a scene.
pub(super) fn shown(given: &Given) -> String {
    given.iter().map(|(k, v)| format!("{k} = {v}")).collect::<Vec<_>>().join(", ")
}

/// A vector of noise for particle `i`; another one for every `seed`.
pub(super) fn vector(i: usize, seed: u64) -> DVec3 {
    let k = (i as u64) * 3 + (seed << 32);
    DVec3::new(noise(k), noise(k + 1), noise(k + 2))
}

/// Everybody within the horizon of everybody.
fn families(points: &[DVec3]) -> Families {
    let mut out = Families { offsets: vec![0], neighbours: Vec::new() };
    for (i, p) in points.iter().enumerate() {
        let near = |j: &usize| *j != i && points[*j].distance_squared(*p) <= HORIZON * HORIZON;
        out.neighbours.extend((0..points.len()).filter(near).map(|j| j as u32));
        out.offsets.push(out.neighbours.len() as u32);
    }
    out
}

/// A strain of size `s` with every component in it: stretch, shear and volume change.
pub(super) fn strain(s: f64) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(1.0 + s, 0.4 * s, 0.1 * s),
        DVec3::new(-0.2 * s, 1.0 - 0.3 * s, 0.3 * s),
        DVec3::new(0.2 * s, 0.1 * s, 1.0 + 0.6 * s),
    )
}

/// Where the particles are put: rest positions strained by `strain(s)` and shaken by `s` of a fifth of the spacing.
pub(super) fn strained(world: &World, s: f64) -> Vec<DVec3> {
    let f = strain(s);
    let rest = world.particles.rest.iter().enumerate();
    rest.map(|(i, x)| f * x.as_dvec3() + vector(i, 7) * (0.2 * s * SPACING)).collect()
}

/// Puts the particles at `motion` of `places`.
pub(super) fn put(world: &mut World, places: &[DVec3], motion: impl Fn(DVec3) -> DVec3) {
    for (position, place) in world.particles.position.iter_mut().zip(places) {
        *position = motion(*place);
    }
}

/// The forces of the fast path [N]: Δv m / dt.
pub(super) fn forces(world: &mut World) -> Vec<DVec3> {
    let (body, p) = (&mut world.bodies[0], &world.particles);
    let p = p.of(&body.range);
    let dt = 1e-6;
    let mut dv = vec![DVec3::ZERO; p.len()];
    body.material.respond(&p, dt, &mut dv);
    dv.iter().zip(p.mass).map(|(dv, m)| *dv * (m / dt)).collect()
}

/// The forces in f64 [N]; those of the fast path where there are none.
pub(super) fn exact_forces(world: &mut World) -> Vec<DVec3> {
    match reference_forces(world) {
        Some(forces) => forces,
        None => forces(world),
    }
}

/// The forces in f64 [N].
pub(super) fn reference_forces(world: &World) -> Option<Vec<DVec3>> {
    let body = &world.bodies[0];
    let p = world.particles.of(&body.range);
    let density = body.material.reference_forces(&p)?;
    Some(density.iter().zip(p.volume).map(|(f, v)| *f * *v).collect())
}

/// Lets the memory flow over `dt` [s] at the present positions.
pub(super) fn flow(world: &mut World, dt: f64) {
    forces(world);
    world.bodies[0].material.flow(dt);
}

/// The elastic energy [J], if there is one.
pub(super) fn energy(world: &mut World) -> Option<f64> {
    let (body, p) = (&mut world.bodies[0], &world.particles);
    body.material.energy(&p.of(&body.range))
}

/// The largest of some vectors; NaN if one is.
pub(super) fn largest(vectors: &[DVec3]) -> f64 {
    vectors.iter().map(|v| v.length()).fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
}

/// The largest difference of two lists of vectors, relative to the largest of the first; NaN if anything is.
pub(super) fn difference(a: &[DVec3], b: &[DVec3]) -> f64 {
    let apart: Vec<DVec3> = a.iter().zip(b).map(|(a, b)| *a - *b).collect();
    let (apart, scale) = (largest(&apart), largest(a));
    if apart == 0.0 { 0.0 } else { apart / scale }
}

/// All columns of a world: scope/name and bytes.
pub(super) type Columns = Vec<(String, Vec<u8>)>;

/// The columns as they are now.
pub(super) fn columns(world: &mut World) -> Columns {
    let mut out = Vec::new();
    world.visit(&mut |scope, column, data| out.push((format!("{scope}/{}", column.name), data.bytes().to_vec())));
    out
}

/// The first column in which two worlds differ.
pub(super) fn first_difference(a: &Columns, b: &Columns) -> Option<String> {
    if a.len() != b.len() {
        return Some(format!("{} columns instead of {}", b.len(), a.len()));
    }
    let different = a.iter().zip(b).find(|(a, b)| a != b);
    different.map(|(a, b)| if a.0 == b.0 { a.0.clone() } else { format!("{} instead of {}", b.0, a.0) })
}
