//! Problems that benchmarks share, with nothing of a file or a mesher in them.

use fissure_engine::{BodyInput, Families, Registry, Value, World};
use glam::{DVec3, IVec3};

/// A cubic lattice of `n`³ particles with everybody within `horizon` spacings, in Morton order. The LAMMPS deck that we
/// compare with simulates the same block: spacing 5e-4 m, ρ = 2200 kg/m³.
pub fn lattice(n: i32, horizon: f64) -> World {
    lattice_of(&fissure_materials::registry(), "isotropic", n, horizon)
}

/// As [`lattice`], with the law `law` of `registry` (κ = μ = 14.9 GPa) and a critical stretch that nothing reaches.
pub fn lattice_of(registry: &Registry, law: &str, n: i32, horizon: f64) -> World {
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
    let number = |name: &str, value: f64| (name.to_string(), Value::Number(value));
    let material = registry
        .make(
            (law, vec![number("bulk_modulus", 14.9e9), number("shear_modulus", 14.9e9)]),
            ("critical_stretch", vec![number("critical_stretch", 0.5)]),
            &fissure_engine::Surroundings { horizon: horizon * SPACING, spacing: SPACING },
        )
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
