//! The standard laws against numbers of other programs: Peridigm's two-point and bond-breaking tests, and the energy of a
//! bond-based lattice. All with influence 1, no surface correction, velocity Verlet.

use fissure_engine::{Bond, BondLaw, Params, Surroundings, Value, World};
use fissure_materials::Pmb;
use fissure_tests::given::{Given, lane_forces, reference_forces};
use glam::{DMat3, DVec3};

fn moduli(kappa: f64, mu: f64) -> [(&'static str, Value); 2] {
    [("bulk_modulus", Value::Number(kappa)), ("shear_modulus", Value::Number(mu))]
}

/// Velocity in step with the positions: the mean of those half a step before and after.
fn velocities(world: &mut World) -> Vec<DVec3> {
    let (dt, force) = (world.dt, lane_forces(world));
    let p = &world.particles;
    (0..p.len()).map(|i| p.velocity[i] + force[i] * (0.5 * dt * p.volume[i] / p.mass[i])).collect()
}

/// Peridigm's Compression_2x1x1 at its start.
fn two_points() -> World {
    let points = [DVec3::ZERO, DVec3::X * 2.0];
    let law = moduli(130e9, 78e9);
    let mut world = Given {
        points: &points,
        volume: 2.0,
        density: 7800.0,
        spacing: 2.0,
        horizon: 2.0,
        law: ("lps", &law),
        criterion: ("none", &[]),
    }
    .world();
    world.particles.velocity.copy_from_slice(&[DVec3::X, DVec3::NEG_X]);
    world.dt = 1e-5;
    world
}

#[test]
fn two_points_fly_together_as_in_peridigm_to_ten_digits() {
    // the law in f64 lanes, and a velocity Verlet of this test's own
    let mut world = two_points();
    let mut force = reference_forces(&world);
    for _ in 0..5 {
        let (dt, p) = (world.dt, &mut world.particles);
        let kick: Vec<f64> = p.volume.iter().zip(p.mass.iter()).map(|(v, m)| 0.5 * dt * v / m).collect();
        for i in 0..2 {
            p.velocity[i] += force[i] * kick[i];
            let v = p.velocity[i];
            p.position[i] += v * dt;
        }
        force = reference_forces(&world);
        for i in 0..2 {
            world.particles.velocity[i] += force[i] * kick[i];
        }
    }
    let (x, v) = (&world.particles.position, &world.particles.velocity);
    let e = x[1].x - x[0].x - 2.0;
    let errors = [
        ("displacement", -e / 2.0 / 4.704698050625e-05 - 1.0),
        ("velocity", v[0].x / 0.818066190245 - 1.0),
        ("force", force[0].x / -5.50449671923e7 - 1.0),
        ("dilatation", 1.5 * e / -1.41140941519e-4 - 1.0),
    ];
    for (what, error) in errors {
        println!("{what}: {error:.1e}");
        assert!(error.abs() < 1e-10, "{what}: {error:e}"); // measured 3e-13 to 3e-12
    }
}

#[test]
fn two_points_fly_together_as_in_peridigm() {
    let mut world = two_points();
    (0..5).for_each(|_| world.step().unwrap());
    let off = |got: f64, want: f64| (got / want - 1.0).abs();
    let p = &world.particles;
    let u = p.position[0].x - (p.position[0].x + p.position[1].x) / 2.0 + 1.0;
    let theta = 1.5 * (p.position[1].x - p.position[0].x - 2.0); // 3/m · ω|ξ|e V
    let errors = [
        ("displacement", off(u, 4.704698050625e-05)),
        ("dilatation", off(theta, -1.41140941519e-4)),
        ("force", off(reference_forces(&world)[0].x, -5.50449671923e7)),
        ("velocity", off(velocities(&mut world)[0].x, 0.818066190245)),
        ("energy", off(world.energies().elastic / 2.0, 2589.6994985)),
    ];
    for (what, error) in errors {
        println!("{what}: {error:.1e}");
        assert!(error < 2e-7, "{what}: {error:e}"); // measured 5e-9 to 1.6e-8: steps are made with f32 bonds
    }
}

#[test]
fn a_bond_breaks_between_peridigms_two_speeds() {
    // Peridigm, BondBreakingInitialVelocity: two pairs along y, the second a hair faster
    let points = [DVec3::ZERO, DVec3::Y, DVec3::X * 1.05, DVec3::new(1.05, 1.0, 0.0)];
    let law = moduli(130e9, 60e9);
    let mut world = Given {
        points: &points,
        volume: 1.05,
        density: 7800.0,
        spacing: 1.0,
        horizon: 1.0,
        law: ("lps", &law),
        criterion: ("critical_stretch", &[("critical_stretch", Value::Number(0.02))]),
    }
    .world();
    for (v, speed) in world.particles.velocity.iter_mut().zip([-244.939, 244.939, -244.959, 244.959]) {
        *v = DVec3::Y * speed;
    }
    world.dt = 1e-8;
    (0..8000).for_each(|_| world.step().unwrap());
    assert_eq!(world.particles.damage[..], [0.0, 0.0, 1.0, 1.0]);
    let v = velocities(&mut world);
    let p = &world.particles;
    // we break a bond after the force of its step, Peridigm before: one kick more, 18 κ e/ρ · dt at e = 0.02 m
    let kick = 18.0 * 130e9 * 0.02 / 7800.0 * world.dt;
    for (i, way, speed, kick) in [(1, 0.0092532866243, -92.8500214354, 0.0), (3, 0.0100363007491, 2.2350085741, kick)] {
        let late = (way - 0.01) * kick / speed; // the way lost by being slower since then
        let u = (p.position[i].y - p.position[i - 1].y - 1.0) / 2.0;
        println!("pair {i}: way off by {:.1e}, speed by {:.1e}", (u + late) / way - 1.0, v[i].y + kick - speed);
        assert!(((u + late) / way - 1.0).abs() < 1e-6 && (v[i].y + kick - speed).abs() < 5e-5);
    }
}

#[test]
fn energy_of_a_bond_based_lattice() {
    // an interior point with 122 neighbours: horizon 3.015 spacings, strain 0.1
    let horizon = 3.015;
    let at = Surroundings { horizon, spacing: 1.0 };
    let given = vec![("bulk_modulus".to_string(), Value::Number(1.0))];
    let law = Pmb::from_params(&Params::new(Pmb::PARAMETERS.to_vec(), given).unwrap(), &at).unwrap();
    let mut bonds = Vec::new();
    for k in 0..343 {
        let xi = DVec3::new((k / 49) as f64 - 3.0, (k / 7 % 7) as f64 - 3.0, (k % 7) as f64 - 3.0);
        if xi.length() > 0.0 && xi.length() <= horizon {
            bonds.push(xi);
        }
    }
    assert_eq!(bonds.len(), 122);
    let density = |f: DMat3| -> f64 {
        let bond = |xi: &DVec3| {
            let (rest, ext) = (xi.length(), (f * *xi).length() - xi.length());
            law.bond_energy(&Bond { ext, ..Bond::at_rest(rest, 1.0, 1.0) }, [])
        };
        bonds.iter().map(bond).sum()
    };
    let (mu, e) = (3.0 / 5.0, 0.1); // κ = 1 and ν = 1/4: λ = μ
    let cases = [
        ("isotropic", DMat3::from_diagonal(DVec3::splat(1.0 + e)), 4.5 * e * e, 0.09871),
        ("shear", DMat3::from_cols(DVec3::X, DVec3::new(e, 1.0, 0.0), DVec3::Z), 0.5 * mu * e * e, 0.19599),
        ("uniaxial", DMat3::from_diagonal(DVec3::new(1.0 + e, 1.0, 1.0)), 1.5 * mu * e * e, 0.06795),
    ];
    for (what, f, classical, want) in cases {
        let got = density(f) / classical - 1.0;
        println!("{what}: {:+.4} % against {:+.3} %", 100.0 * got, 100.0 * want);
        assert!((got - want).abs() < 1e-5, "{what}: {got}"); // measured below 5e-6,: the digits that are printed
    }
}
