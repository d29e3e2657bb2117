//! The isotropic law against closed forms: stiffness, energy, the stable step, objectivity.

use fissure_engine::{Value, World};
use fissure_tests::{Block, block};
use glam::{DMat3, DVec3};

const KAPPA: f64 = 1e6;
const MU: f64 = 4e5;

fn deform(world: &mut World, f: DMat3) {
    for i in 0..world.particles.len() {
        world.particles.position[i] = f * world.particles.rest[i].as_dvec3();
    }
}

fn forces(world: &World) -> Vec<DVec3> {
    let p = world.particles.of(&(0..world.particles.len()));
    let density = world.bodies[0].material.reference_forces(&p).unwrap();
    density.iter().zip(p.volume).map(|(f, v)| *f * *v).collect()
}

/// Traction [Pa] through the plane x = 0 of a homogeneously strained block.
fn traction(world: &World, n: usize, spacing: f64) -> DVec3 {
    let pull: DVec3 =
        forces(world).iter().zip(&world.particles.rest[..]).filter(|(_, x)| x.x < 0.0).map(|(f, _)| *f).sum();
    // what is left of the plane is held back by the right half, and both halves by nothing else
    pull / (n as f64 * spacing).powi(2)
}

fn as_written(kappa: f64, mu: f64) -> Vec<(&'static str, Value)> {
    vec![
        ("bulk_modulus", Value::Number(kappa)),
        ("shear_modulus", Value::Number(mu)),
        ("formulation", Value::Word("as_written".into())),
    ]
}

#[test]
fn a_strained_block_pulls_with_its_moduli() {
    // uniaxial strain: σ = (κ + 4μ/3) ε; simple shear: τ = μ γ
    let strain = 1e-3;
    let mut errors = Vec::new();
    for n in [8, 16] {
        let spacing = 1.0 / n as f64;
        let mut world = block(&Block { n: [n; 3], spacing, jitter: 0.2, ..Block::default() });
        deform(&mut world, DMat3::from_diagonal(DVec3::new(1.0 + strain, 1.0, 1.0)));
        let axial = traction(&world, n, spacing).x / ((KAPPA + 4.0 / 3.0 * MU) * strain) - 1.0;
        deform(&mut world, DMat3::from_cols(DVec3::new(1.0, strain, 0.0), DVec3::Y, DVec3::Z));
        let shear = traction(&world, n, spacing).y / (MU * strain) - 1.0;
        println!("{n} across: stress {:+.2} %, shear {:+.2} %", 100.0 * axial, 100.0 * shear);
        errors.push(axial.abs().max(shear.abs()));
    }
    // measured .068 and .030; without the surface treatment .166 and .080. An affine strain is stiffer than the relaxed
    // one that the treatment aims at (see the comparison with finite elements).
    assert!(errors[0] < 0.075 && errors[1] < 0.035 && errors[1] < 0.6 * errors[0], "{errors:?}");
}

#[test]
fn force_is_minus_the_gradient_of_the_energy() {
    let mut world = block(&Block { n: [5; 3], spacing: 0.2, ..Block::default() });
    let shape = DMat3::from_cols(DVec3::new(1.1, 0.1, 0.0), DVec3::new(-0.05, 0.9, 0.0), DVec3::new(0.0, 0.2, 1.0));
    deform(&mut world, shape);
    let force = forces(&world);
    let largest = force.iter().map(|f| f.length()).fold(0.0, f64::max);
    for i in [0, 31, 62, 124] {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let mut energy = |h: f64| {
                let home = world.particles.position[i];
                world.particles.position[i] = home + axis * h;
                let e = world.energies().elastic;
                world.particles.position[i] = home;
                e
            };
            let h = 1e-3;
            let slope = (energy(h) - energy(-h)) / (2.0 * h);
            let error = (slope + force[i].dot(axis)).abs() / largest;
            assert!(error < 1e-3, "particle {i}: {error:e}"); // measured below 1e-4: f32 energies are differenced
        }
    }
}

#[test]
fn energy_is_kept_and_the_predicted_step_is_the_limit() {
    let start = || {
        let mut world = block(&Block::default());
        for i in 0..world.particles.len() {
            let x = world.particles.rest[i].as_dvec3();
            world.particles.velocity[i] = DVec3::new(x.x, -x.y, 0.5 * x.x) * 0.2;
        }
        world
    };
    let mut world = start();
    world.dt = 0.3 * world.stable_dt();
    // symplectic Euler is leapfrog: with the product of the velocities half a step before and after, the sum is constant
    // for linear forces
    let total = |w: &mut World| {
        let before: Vec<DVec3> = w.particles.velocity.to_vec();
        let elastic = w.energies().elastic;
        w.step().unwrap();
        let kinetic: f64 =
            (0..before.len()).map(|i| 0.5 * w.particles.mass[i] * before[i].dot(w.particles.velocity[i])).sum();
        elastic + kinetic
    };
    let first = total(&mut world);
    (0..2000).for_each(|_| world.step().unwrap());
    let drift = total(&mut world) / first - 1.0;
    println!("energy drift after 2000 steps {drift:+.2e}");
    assert!(drift.abs() < 1e-4, "{drift:e}"); // measured -1.8e-5, falling with the square of the amplitude

    let blows_up = |factor: f64| {
        let mut world = start();
        world.dt = factor * world.stable_dt();
        (0..2000).any(|_| world.step().is_err())
    };
    assert!(!blows_up(1.0), "the stable step should be stable");
    assert!(blows_up(1.3), "1.3 times the stable step should blow up and be caught");
}

#[test]
fn the_default_is_objective_and_as_written_is_not() {
    // as written, K_eff = 5μ/3 + (κ − 5μ/3)((1 + 2 cos φ)/3)² (PHYSICS, item 1): the response to a dilatation that was
    // applied before a turn by φ
    let (kappa, mu) = (9.7e6, 1e6);
    let response = |law: Vec<(&'static str, Value)>, degrees: f64| {
        let n = 12;
        let mut world =
            block(&Block { n: [n; 3], spacing: 1.0 / 12.0, jitter: 0.0, law: ("isotropic", law), ..Block::default() });
        let turn = DMat3::from_rotation_z(f64::to_radians(degrees));
        deform(&mut world, turn * DMat3::from_diagonal(DVec3::splat(1.001)));
        // the pull on the half that was at x < 0, turned back
        let pull = turn.transpose() * traction(&world, n, 1.0 / 12.0);
        pull.x / (3.0 * kappa * 1e-3)
    };
    let default = || vec![("bulk_modulus", Value::Number(kappa)), ("shear_modulus", Value::Number(mu))];
    let (upright, turned) = (response(default(), 0.0), response(default(), 90.0));
    println!("default: {upright:.4} upright, {turned:.4} turned");
    assert!((upright / turned - 1.0).abs() < 1e-9); // both 1.0262: an affine strain is stiff at surfaces

    let written = response(as_written(kappa, mu), 90.0) / response(as_written(kappa, mu), 0.0);
    let predicted = (5.0 / 3.0 * mu + (kappa - 5.0 / 3.0 * mu) / 9.0) / kappa;
    println!("as written: turned/upright {written:.3}, predicted in the bulk {predicted:.3}");
    assert!((written - predicted).abs() < 0.05, "{written} {predicted}"); // measured .233 against .264 in the bulk
}
