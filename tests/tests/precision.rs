//! DESIGN: bond arithmetic may run in f32 if it starts from differences taken in higher precision. The measure: strain
//! 1e-4, body moved 100 sizes away and turned 1 rad; forces within 1e-5 of the all-f64 reference, relative to the largest.

use fissure_engine::{Material, World};
use fissure_tests::{Block, block, noise};
use glam::{DMat3, DVec3};

/// Largest difference between fast and reference forces, relative to the largest force.
fn error(world: &World, material: &mut dyn Material) -> f64 {
    let p = world.particles.of(&(0..world.particles.len()));
    let reference = material.reference_forces(&p).expect("bond laws have a reference");
    let dt = 1e-4;
    let mut dv = vec![DVec3::ZERO; p.len()];
    material.respond(&p, dt, &mut dv);
    let fast = |i: usize| dv[i] * (p.mass[i] / (p.volume[i] * dt));
    let worst = (0..p.len()).map(|i| fast(i).distance(reference[i])).fold(0.0, f64::max);
    worst / reference.iter().map(|f| f.length()).fold(0.0, f64::max)
}

fn strained(rotation: DMat3, away: DVec3, strain: f64, wiggle: f64) -> World {
    let mut world = block(&Block::default());
    let stretch = DMat3::from_cols(
        DVec3::new(1.0 + strain, 0.4 * strain, 0.0),
        DVec3::new(0.0, 1.0 - 0.3 * strain, 0.2 * strain),
        DVec3::new(0.1 * strain, 0.0, 1.0 + 0.5 * strain),
    );
    for i in 0..world.particles.len() {
        let k = 7 * i as u64;
        let local = DVec3::new(noise(k), noise(k + 1), noise(k + 2)) * wiggle;
        let y = rotation * (stretch * world.particles.rest[i].as_dvec3() + local);
        world.particles.position[i] = y + away;
    }
    world
}

fn measure(mut world: World) -> f64 {
    let mut body = world.bodies.remove(0);
    error(&world, &mut *body.material)
}

#[test]
fn far_away_and_turned_at_strain_1e_4() {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 1.0);
    let away = DVec3::new(70.0, -60.0, 40.0);
    let e = measure(strained(turn, away, 1e-4, 0.0));
    println!("relative force error {e:.2e}");
    assert!(e < 1e-5, "{e:e}"); // measured 1.0e-7
}

#[test]
fn a_fragment_that_left_its_bodys_frame_keeps_to_1e_3() {
    // the frame follows the whole body; here half of it has flown off 20 sizes and turned on its own
    let mut world = block(&Block { n: [16, 6, 6], critical_stretch: Some(0.5), ..Block::default() });
    let mut body = world.bodies.remove(0);
    let turn = DMat3::from_axis_angle(DVec3::Y, 1.0);
    let p = &mut world.particles;
    for i in 0..p.len() {
        let x = p.rest[i].as_dvec3();
        let strained = x + DVec3::new(x.x, -0.3 * x.y, 0.2 * x.x) * 1e-4;
        p.position[i] = if x.x > 0.0 { turn * strained + DVec3::new(20.0, 3.0, 1.0) } else { strained };
    }
    let p = world.particles.of(&(0..world.particles.len()));
    let (mut dv, mut cuts) = (vec![DVec3::ZERO; p.len()], Vec::new());
    body.material.respond(&p, 1e-9, &mut dv);
    body.material.fracture(&mut vec![0.0; p.len()], &mut cuts);
    assert!(cuts.len() > 900, "the halves are still bonded: {} cuts", cuts.len());
    let e = error(&world, &mut *body.material);
    println!("relative force error {e:.2e}");
    assert!(e < 1e-3, "{e:e}"); // measured 3.1e-4: f32 after a turn of its own
}

#[test]
fn a_body_at_rest_feels_nothing() {
    let mut world = block(&Block::default());
    world.dt = 1e-4;
    world.step().unwrap();
    let fastest = world.particles.velocity.iter().map(|v| v.length()).fold(0.0, f64::max);
    assert!(fastest < 1e-13, "{fastest:e} m/s"); // measured 3e-15 m/s: the rounding of f64 positions
}

#[test]
fn large_strain_agrees_too() {
    let turn = DMat3::from_axis_angle(DVec3::Z, 2.0);
    let e = measure(strained(turn, DVec3::X * 3.0, 0.3, 0.01));
    println!("relative force error {e:.2e}");
    assert!(e < 2e-6, "{e:e}"); // measured 1.1e-7
}
