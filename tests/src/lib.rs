//! Small bodies that the integration tests share.

pub mod bar;
pub mod counting;
pub mod given;
pub mod grains;
pub mod scene;

pub use fissure_engine::noise::noise;
use fissure_engine::{BodyInput, Families, Surroundings, Value, World};
use glam::DVec3;

/// The environment variable with the folder of other people's meshes (`surface/`, `tet/`).
pub const MESHES: &str = "FISSURE_MESHES";

/// The folder of other people's meshes; prints a line and returns `None` where it is not given.
pub fn meshes() -> Option<std::path::PathBuf> {
    let folder = std::env::var_os(MESHES).map(std::path::PathBuf::from);
    if folder.is_none() {
        println!("skipped: {MESHES} is not set");
    }
    folder
}

/// Everybody within `horizon` of everybody: the naive oracle.
pub fn naive_families(points: &[DVec3], horizon: f64) -> Families {
    let mut families = Families { offsets: vec![0], neighbours: Vec::new() };
    for (i, p) in points.iter().enumerate() {
        let near = |j: &usize| *j != i && points[*j].distance_squared(*p) <= horizon * horizon;
        families.neighbours.extend((0..points.len()).filter(near).map(|j| j as u32));
        families.offsets.push(families.neighbours.len() as u32);
    }
    families
}

/// What [`block`] is made of.
#[derive(Clone, Debug)]
pub struct Block {
    /// Particles along each edge.
    pub n: [usize; 3],
    /// Size of the smallest cell [m].
    pub spacing: f64,
    /// Jitter of the particles, in spacings.
    pub jitter: f64,
    /// Law and its parameters.
    pub law: (&'static str, Vec<(&'static str, Value)>),
    /// Critical stretch, if the block breaks.
    pub critical_stretch: Option<f64>,
}

impl Default for Block {
    /// A rubber cube of 8³ particles, 1 m wide, κ = 1 MPa, μ = 0.4 MPa.
    fn default() -> Self {
        let moduli = vec![("bulk_modulus", Value::Number(1e6)), ("shear_modulus", Value::Number(4e5))];
        Self { n: [8; 3], spacing: 0.125, jitter: 0.25, law: ("isotropic", moduli), critical_stretch: None }
    }
}

/// A jittered block of particles, horizon 2.6 spacings, ρ = 1000 kg/m³, at rest, with no gravity, and dt not set.
pub fn block(b: &Block) -> World {
    let [nx, ny, nz] = b.n;
    let points: Vec<DVec3> = (0..nx * ny * nz)
        .map(|k| {
            let cell = DVec3::new((k / (ny * nz)) as f64, (k / nz % ny) as f64, (k % nz) as f64);
            let wiggle = DVec3::new(noise(3 * k as u64), noise(3 * k as u64 + 1), noise(3 * k as u64 + 2));
            (cell + wiggle * b.jitter) * b.spacing
        })
        .collect();
    let horizon = 2.6 * b.spacing;
    let given = |pairs: &[(&str, Value)]| pairs.iter().map(|(k, v)| (k.to_string(), v.clone())).collect::<Vec<_>>();
    let fracture = match b.critical_stretch {
        Some(s) => ("critical_stretch", given(&[("critical_stretch", Value::Number(s))])),
        None => ("none", vec![]),
    };
    let at = Surroundings { horizon, spacing: b.spacing };
    let material = fissure_materials::registry()
        .make((b.law.0, given(&b.law.1)), fracture, &at)
        .expect("the test's parameters are valid");
    let input = BodyInput {
        name: "block",
        points: &points,
        volumes: &vec![b.spacing.powi(3); points.len()],
        ids: &(0..points.len() as u32).collect::<Vec<_>>(),
        density: 1000.0,
        spacing: b.spacing,
        horizon,
        velocity: DVec3::ZERO,
        spin: DVec3::ZERO,
        neighbourhood: naive_families(&points, horizon).into(),
    };
    let mut world = World::default();
    world.add(input, material).expect("volumes are positive");
    world
}

/// All columns of a world as one list of (scope/name, bytes).
pub fn columns(world: &mut World) -> Vec<(String, Vec<u8>)> {
    let mut out = Vec::new();
    world.visit(&mut |scope, column, data| out.push((format!("{scope}/{}", column.name), data.bytes().to_vec())));
    out
}
