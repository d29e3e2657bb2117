//! Problems that benchmarks share, with nothing of a file or a mesher in them.

use fissure_engine::{BodyInput, Families, Parameter, Registry, Surroundings, Value, World};
use glam::{DVec3, IVec3};

/// Values for the keys of laws and criteria: glass-like, and such that nothing yields or breaks.
const VALUES: [(&str, f64); 9] = [
    ("bulk_modulus", 14.9e9),
    ("shear_modulus", 14.9e9),
    ("yield_stress", 14.9e9),
    ("relaxing_share", 0.5),
    ("relaxation_time", 1e-3),
    ("critical_stretch", 0.5),
    ("energy_release_rate", 1e9),
    ("tension_release_rate", 1e9),
    ("shear_release_rate", 1e9),
];

/// What `parameters` ask for, of [`VALUES`]; and an anisotropy that is one.
fn given(parameters: &[Parameter]) -> Vec<(String, Value)> {
    let known = VALUES.iter().map(|&(key, value)| (key, Value::Number(value)));
    let matrix = ("matrix", Value::List(vec![1.0, 1.0, 2.0]));
    let asked = |key: &str| parameters.iter().any(|p| p.name == key);
    known.chain([matrix]).filter(|(key, _)| asked(key)).map(|(key, value)| (key.to_string(), value)).collect()
}

/// A cubic lattice of `n`³ particles with everybody within `horizon` spacings, in Morton order. The LAMMPS deck that we
/// compare with simulates the same block: spacing 5e-4 m, ρ = 2200 kg/m³.
pub fn lattice(n: i32, horizon: f64) -> World {
    lattice_of(&fissure_materials::registry(), "isotropic", "critical_stretch", n, horizon)
}

/// As [`lattice`], with a law and a criterion of `registry`; nothing yields or breaks.
pub fn lattice_of(registry: &Registry, law: &str, criterion: &str, n: i32, horizon: f64) -> World {
    const SPACING: f64 = 5e-4;
    let mut cells: Vec<IVec3> = (0..n * n * n).map(|k| IVec3::new(k / (n * n), k / n % n, k % n)).collect();
    let spread = |x: i32| (0..10).fold(0u32, |m, b| m | ((x as u32 >> b & 1) << (3 * b)));
    cells.sort_unstable_by_key(|c| spread(c.x) << 2 | spread(c.y) << 1 | spread(c.z));
    let mut number = vec![0u32; (n * n * n) as usize];
    let place = |c: IVec3| ((c.x * n + c.y) * n + c.z) as usize;
    cells.iter().enumerate().for_each(|(k, &c)| number[place(c)] = k as u32);
    let reach = horizon as i32 + 1;
    let steps: Vec<IVec3> = (0..(2 * reach + 1).pow(3))
        .map(|k| {
            let w = 2 * reach + 1;
            IVec3::new(k / (w * w), k / w % w, k % w) - reach
        })
        .filter(|s| *s != IVec3::ZERO && s.as_dvec3().length_squared() <= horizon * horizon)
        .collect();
    let mut families = Families { offsets: vec![0], neighbours: Vec::new() };
    for &c in &cells {
        let start = families.neighbours.len();
        let inside = steps.iter().map(|s| c + s).filter(|t| t.min_element() >= 0 && t.max_element() < n);
        families.neighbours.extend(inside.map(|t| number[place(t)]));
        families.neighbours[start..].sort_unstable();
        families.offsets.push(families.neighbours.len() as u32);
    }
    let points: Vec<DVec3> = cells.iter().map(|c| c.as_dvec3() * SPACING).collect();
    let ids: Vec<u32> = (0..points.len() as u32).collect();
    let volumes = vec![SPACING.powi(3); points.len()];
    let entry = registry.entry(law).expect("a registered law");
    let breaks = entry.criteria.iter().find(|c| c.name == criterion).expect("a registered criterion");
    let at = Surroundings { horizon: horizon * SPACING, spacing: SPACING };
    let material = registry
        .make((law, given(entry.parameters)), (criterion, given(breaks.parameters)), &at)
        .expect("valid parameters");
    let mut world = World::default();
    world.dt = 5e-8;
    let input = BodyInput {
        name: "block",
        points: &points,
        volumes: &volumes,
        ids: &ids,
        density: 2200.0,
        spacing: SPACING,
        horizon: horizon * SPACING,
        velocity: DVec3::ZERO,
        spin: DVec3::ZERO,
        families,
    };
    world.add(input, material).expect("volumes are positive");
    // a smooth, small motion, so that no number is trivially zero
    let side = f64::from(n) * SPACING;
    for i in 0..points.len() {
        let w = points[i] * (std::f64::consts::TAU / side);
        world.particles.velocity[i] =
            DVec3::new(w.x.sin() * w.y.cos(), w.y.sin() * w.z.cos(), w.z.sin() * w.x.cos()) * 0.5;
    }
    world
}
