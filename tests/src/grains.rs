//! What tests of contact are made of: loose grains, small bodies, momentum with that of rigid things.

use fissure_engine::{BodyInput, Collider, Shape, Surroundings, Value, World};
use glam::{DQuat, DVec3};

use crate::naive_families;

/// Gravity [m/s²].
pub const G: DVec3 = DVec3::new(0.0, -9.81, 0.0);

/// A free ball of density 2000 kg/m³.
pub fn ball(radius: f64, position: DVec3, velocity: DVec3) -> Collider {
    let ball = Collider::free("ball", Shape::Ball { radius }, 2000.0, position, DQuat::IDENTITY).unwrap();
    Collider { velocity, ..ball }
}

/// Linear and angular momentum of particles and free colliders, and the sums of their parts' lengths.
pub fn momentum(w: &World) -> (DVec3, DVec3, f64, f64) {
    let p = &w.particles;
    let mut parts: Vec<(DVec3, DVec3)> = (0..p.len())
        .map(|i| {
            let linear = p.velocity[i] * p.mass[i];
            (linear, p.position[i].cross(linear))
        })
        .collect();
    for c in w.colliders.iter().filter(|c| c.is_free()) {
        let linear = c.velocity * c.mass();
        parts.push((linear, c.position.cross(linear) + c.angular_momentum));
    }
    let sum = |f: fn(&(DVec3, DVec3)) -> DVec3| parts.iter().map(f).sum::<DVec3>();
    let size = |f: fn(&(DVec3, DVec3)) -> DVec3| parts.iter().map(|p| f(p).length()).sum::<f64>();
    (sum(|p| p.0), sum(|p| p.1), size(|p| p.0), size(|p| p.1))
}

/// So many steps.
///
/// # Panics
/// If one fails.
pub fn steps(world: &mut World, n: usize) {
    (0..n).for_each(|_| world.step().unwrap());
}

/// Nothing yet, in steps of 0.1 ms.
pub fn world(gravity: DVec3) -> World {
    let mut world = World::default();
    (world.gravity, world.dt) = (gravity, 1e-4);
    world
}

/// Particles without bonds to each other, one body each: what meets is contact and nothing else.
pub fn grains(places: &[(DVec3, DVec3)], diameter: f64) -> World {
    let mut world = world(DVec3::ZERO);
    for (k, &(x, velocity)) in places.iter().enumerate() {
        add(&mut world, &format!("grain {k}"), &[x], diameter, velocity);
    }
    world
}

/// A body of cubes of edge `spacing` [m] at `points`.
pub fn add(world: &mut World, name: &str, points: &[DVec3], spacing: f64, velocity: DVec3) {
    add_breaking(world, name, points, spacing, velocity, None);
}

/// The same, with a critical stretch.
pub fn add_breaking(
    world: &mut World,
    name: &str,
    points: &[DVec3],
    spacing: f64,
    velocity: DVec3,
    critical_stretch: Option<f64>,
) {
    let at = Surroundings { horizon: 2.6 * spacing, spacing };
    let law = vec![("bulk_modulus".into(), Value::Number(1e6)), ("shear_modulus".into(), Value::Number(4e5))];
    let fracture = match critical_stretch {
        Some(s) => ("critical_stretch", vec![("critical_stretch".into(), Value::Number(s))]),
        None => ("none", vec![]),
    };
    let material = fissure_materials::registry().make(("isotropic", law), fracture, &at).unwrap();
    let input = BodyInput {
        name,
        points,
        volumes: &vec![spacing.powi(3); points.len()],
        ids: &(0..points.len() as u32).collect::<Vec<_>>(),
        density: 1000.0,
        spacing,
        horizon: at.horizon,
        velocity,
        spin: DVec3::ZERO,
        neighbourhood: naive_families(points, at.horizon).into(),
    };
    world.add(input, material).unwrap();
}

/// Points of a block, x slowest.
pub fn lattice(n: [usize; 3], spacing: f64, corner: DVec3) -> Vec<DVec3> {
    let cell = |k: usize| DVec3::new((k / (n[1] * n[2])) as f64, (k / n[2] % n[1]) as f64, (k % n[2]) as f64);
    (0..n.iter().product()).map(|k| corner + cell(k) * spacing).collect()
}
