//! The integrators: velocity Verlet against closed forms, relaxation against statics, and what holding takes.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use fissure_engine::material::Geometry;
use fissure_engine::particles::BodyParticles;
use fissure_engine::{
    Anchor, BodyInput, BuildError, Families, Integrator, Material, Relax, StepError, Value, Visitor, World,
};
use fissure_tests::{Block, block, columns};
use glam::DVec3;

/// Every particle on a spring of its own to where it started, k/m = 1/s².
struct Springs {
    home: Vec<DVec3>,
    /// Fails at this evaluation.
    fails: u32,
}

static EVALUATIONS: AtomicU32 = AtomicU32::new(0);

impl Material for Springs {
    fn build(&mut self, g: Geometry<'_>) -> Result<(), BuildError> {
        self.home = g.particles.position.to_vec();
        Ok(())
    }
    fn stable_dt(&self, _: &BodyParticles<'_>) -> f64 {
        2.0
    }
    fn respond(&mut self, p: &BodyParticles<'_>, dt: f64, dv: &mut [DVec3]) {
        let number = EVALUATIONS.fetch_add(1, Ordering::Relaxed) + 1;
        for i in 0..p.len() {
            dv[i] += (self.home[i] - p.position[i]) * if number == self.fails { f64::NAN } else { dt };
        }
    }
    fn visit(&mut self, _: &str, _: &mut Visitor<'_>) {}
}

/// Two particles of 1 kg at ±X on springs, the first moving at 1 m/s along Y.
fn springs(fails: u32) -> World {
    let mut world = World::default();
    world.integrator = Integrator::VelocityVerlet;
    let input = BodyInput {
        name: "springs",
        points: &[DVec3::NEG_X, DVec3::X],
        volumes: &[1.0; 2],
        ids: &[0, 1],
        density: 1.0,
        spacing: 1.0,
        horizon: 1.0,
        velocity: DVec3::ZERO,
        spin: DVec3::ZERO,
        neighbourhood: Families { offsets: vec![0; 3], neighbours: vec![] }.into(),
    };
    world.add(input, Box::new(Springs { home: vec![], fails })).expect("a body");
    world.particles.velocity[0] = DVec3::Y;
    world
}

#[test]
fn verlet_follows_an_oscillator_to_second_order_with_one_evaluation_a_step() {
    let mut errors = Vec::new();
    for steps in [100, 200] {
        let mut world = springs(0);
        world.dt = 2.0 / f64::from(steps);
        let before = EVALUATIONS.load(Ordering::Relaxed);
        (0..steps).for_each(|_| world.step().unwrap());
        // other tests of this file use springs too, but not as often
        assert!(EVALUATIONS.load(Ordering::Relaxed) - before < steps + 20);
        let (y, v) = (world.particles.position[0].y, world.particles.velocity[0].y);
        errors.push((y - 2f64.sin()).abs().max((v - 2f64.cos()).abs()));
    }
    // measured 5.4e-5 and 1.3e-5; symplectic Euler's velocities, half a step early, would be wrong by 9e-3
    assert!(errors[0] < 1e-4 && errors[1] < 0.26 * errors[0], "{errors:?}");
}

#[test]
fn a_failing_verlet_step_changes_nothing() {
    for _ in 0..3 {
        let mut world = springs(0);
        world.dt = 0.1;
        (0..5).for_each(|_| world.step().unwrap());
        let before = columns(&mut world);
        world.gravity = DVec3::X * f64::INFINITY;
        let error = world.step().unwrap_err();
        assert!(matches!(error, StepError::NotFinite { step: 5, .. }), "{error}");
        world.gravity = DVec3::ZERO;
        assert_eq!(before, columns(&mut world));
    }
}

/// A rubber block in motion, whose total energy moves between kinetic, elastic and gravity.
fn thrown(integrator: Integrator) -> World {
    let mut world = block(&Block { n: [6; 3], ..Block::default() });
    world.integrator = integrator;
    world.gravity = DVec3::NEG_Z * 9.81;
    world.dt = 0.3 * world.stable_dt();
    for i in 0..world.particles.len() {
        let x = world.particles.rest[i].as_dvec3();
        world.particles.velocity[i] = DVec3::new(x.x - 0.5 * x.y, 0.3 * x.z - x.y, 0.5 * x.x);
    }
    world
}

#[test]
fn verlet_keeps_the_energy_that_is_reported() {
    let total = |w: &mut World| {
        let e = w.energies();
        e.kinetic + e.elastic + e.gravity
    };
    let swing = |shorter: u32| {
        let mut world = thrown(Integrator::VelocityVerlet);
        world.dt /= f64::from(shorter);
        let (first, moving) = (total(&mut world), world.energies().kinetic);
        let mut worst = 0.0f64;
        for _ in 0..500 * shorter {
            world.step().unwrap();
            worst = worst.max((total(&mut world) - first).abs() / moving);
        }
        worst
    };
    let worst = [1, 2].map(swing);
    println!("energy within {:.1e} and {:.1e} of the kinetic energy at the start", worst[0], worst[1]);
    // measured 7.8e-3 at 0.3 of the stable step, of second order
    assert!(worst[0] < 1e-2 && worst[1] < 0.3 * worst[0], "{worst:?}");
}

#[test]
fn verlet_goes_on_to_the_same_bits_after_a_restart() {
    let mut straight = thrown(Integrator::VelocityVerlet);
    (0..20).for_each(|_| straight.step().unwrap());
    let saved = columns(&mut straight);
    assert!(saved.iter().any(|(name, _)| name == "particles/acceleration"));
    let mut fresh = thrown(Integrator::VelocityVerlet);
    let mut k = 0;
    fresh.visit(&mut |_, _, data| {
        assert!(data.set_bytes(&saved[k].1), "{}", saved[k].0);
        k += 1;
    });
    (0..20).for_each(|_| (straight.step().unwrap(), fresh.step().unwrap()).0);
    assert_eq!(columns(&mut straight), columns(&mut fresh));
    // saving before the first step changes nothing either
    let mut looked = thrown(Integrator::VelocityVerlet);
    let _ = columns(&mut looked);
    (0..40).for_each(|_| looked.step().unwrap());
    assert_eq!(columns(&mut looked), columns(&mut fresh));
}

/// The particles of `world` at rest positions that `choose`, as an anchor.
fn anchor(world: &World, name: &str, choose: impl Fn(DVec3) -> bool) -> Anchor {
    let inside = |i: &usize| choose(world.particles.rest[*i].as_dvec3());
    let held: Vec<usize> = (0..world.particles.len()).filter(inside).collect();
    Anchor {
        name: name.into(),
        particles: held.iter().map(|&i| i as u32).collect::<Vec<_>>().into(),
        start: held.iter().map(|&i| world.particles.position[i]).collect::<Vec<_>>().into(),
        until: f64::INFINITY,
        ..Anchor::default()
    }
}

#[test]
fn turning_a_mass_takes_its_centripetal_force() {
    let mut world = springs(0);
    world.dt = 0.01;
    let spun = Anchor { spin: DVec3::Z * 3.0, centre: DVec3::Y, ..anchor(&world, "spun", |x| x.x > 0.0) };
    world.anchors.push(spun);
    world.step().unwrap();
    let reaction = &world.reactions()[0];
    let arm = world.particles.position[1] - DVec3::Y;
    // m ω² r towards the centre, and the spring
    let want = arm * -9.0 - (DVec3::X - world.particles.position[1]);
    assert!(reaction.force.distance(want) < 1e-12, "{} instead of {want}", reaction.force);
    assert!((reaction.torque - arm.cross(want)).length() < 1e-12);
    assert!((reaction.torque_about(DVec3::Y + DVec3::Z) - (arm - DVec3::Z).cross(want)).length() < 1e-12);
    // velocities are those of the motion at this very time
    assert!(world.particles.velocity[1].distance(DVec3::Z.cross(arm) * 3.0) < 1e-12);
}

/// A bar of 16 × 4 × 4 particles, held at both ends, the right one moving by `pull` [m] in 1 s.
fn stretched(pull: f64, critical: Option<f64>, law: (&'static str, Vec<(&'static str, Value)>)) -> World {
    let mut world = block(&Block { n: [16, 4, 4], critical_stretch: critical, law, ..Block::default() });
    let left = anchor(&world, "left", |x| x.x < -0.7);
    let right = Anchor { velocity: DVec3::X * pull, ..anchor(&world, "right", |x| x.x > 0.7) };
    world.anchors = vec![left, right];
    world.integrator = Integrator::Relax(Relax::default());
    world.dt = 0.25;
    world
}

fn rubber() -> (&'static str, Vec<(&'static str, Value)>) {
    Block::default().law
}

#[test]
fn a_relaxed_bar_is_in_equilibrium_and_two_residuals_agree() {
    let force = |residual: f64| {
        let mut world = stretched(0.05, None, rubber());
        world.gravity = DVec3::NEG_Z;
        world.integrator = Integrator::Relax(Relax { residual, ..Relax::default() });
        (0..4).for_each(|_| world.step().unwrap());
        assert!((world.time - 1.0).abs() < 1e-12 && world.relaxed.residual <= residual);
        println!("residual {residual:e}: {:?}", world.relaxed);
        let weight: f64 = world.particles.mass.iter().sum();
        let [left, right] = &world.reactions()[..] else { panic!("two anchors") };
        (left.force, right.force, weight)
    };
    let (left, right, weight) = force(1e-5);
    let unbalanced = (left + right - DVec3::Z * weight).length() / right.x;
    println!("left {left}, right {right}, unbalanced {unbalanced:.1e}");
    assert!(unbalanced < 1e-4, "{unbalanced:e}");
    let exact = force(1e-7).1;
    let error = (right - exact).length() / exact.length();
    println!("against a residual of 1e-7: {error:.1e}");
    assert!(error < 1e-4, "{error:e}");
}

#[test]
fn relaxation_finds_what_damped_motion_comes_to() {
    let mut relaxed = stretched(0.05, None, rubber());
    relaxed.dt = 1.0;
    relaxed.step().unwrap();
    // the same bar held at its final length, and slowed down until it stands
    let mut moving = stretched(0.05, None, rubber());
    moving.integrator = Integrator::VelocityVerlet;
    for anchor in &mut moving.anchors {
        let shift = anchor.velocity;
        anchor.start.to_mut().iter_mut().for_each(|x| *x += shift);
        anchor.velocity = DVec3::ZERO;
        for (k, &i) in anchor.particles.iter().enumerate() {
            moving.particles.position[i as usize] = anchor.start[k];
        }
        anchor.from = -10.0;
    }
    moving.dt = 0.9 * moving.stable_dt();
    for _ in 0..3000 {
        moving.step().unwrap();
        moving.particles.velocity.iter_mut().for_each(|v| *v *= 0.9);
    }
    let (a, b) = (relaxed.reactions()[1].force.x, moving.reactions()[1].force.x);
    println!("relaxed {a} N, damped {b} N");
    assert!((a / b - 1.0).abs() < 1e-4);
}

#[test]
fn relaxing_a_piece_that_nothing_holds_ends_with_a_sentence() {
    let mut world = block(&Block { n: [4; 3], ..Block::default() });
    world.integrator = Integrator::Relax(Relax { iterations: 200, ..Relax::default() });
    world.gravity = DVec3::NEG_Z * 9.81;
    world.dt = 1.0;
    let before = columns(&mut world);
    let error = world.step().unwrap_err();
    assert!(matches!(error, StepError::NoEquilibrium { iterations: 200, .. }), "{error}");
    assert!(error.to_string().contains("is there a piece that nothing holds?"), "{error}");
    assert_eq!(before, columns(&mut world));
    // without gravity there is nothing to do
    world.gravity = DVec3::ZERO;
    world.step().unwrap();
    assert_eq!(world.relaxed.iterations, 1);
}

#[test]
fn an_interrupt_ends_a_relaxation_with_the_state_before() {
    static STOP: AtomicBool = AtomicBool::new(true);
    let mut world = stretched(0.05, None, rubber());
    let before = world.particles.position.to_vec();
    world.interrupt = Some(&STOP);
    assert!(matches!(world.step(), Err(StepError::Interrupted { step: 0, .. })));
    assert_eq!(&before[..], &world.particles.position[..]);
    STOP.store(false, Ordering::Relaxed);
    world.step().unwrap();
}

#[test]
fn pulled_too_far_the_bar_breaks_and_what_is_left_is_at_rest() {
    let mut world = stretched(1.6, Some(0.1), rubber());
    let mut pulls = Vec::new();
    for _ in 0..4 {
        world.step().unwrap();
        pulls.push(world.reactions()[1].force.x);
        println!("{:?}, {} bonds broken, pull {:.1} N", world.relaxed, world.bond_counts().1, pulls[pulls.len() - 1]);
    }
    let torn = world.relaxed;
    assert!(world.bond_counts().1 > 0 && pulls[0] > 1e3, "{pulls:?}");
    // measured 1.1e-6: what is left are quanta of displacement, 4e-9 horizons each
    assert!(pulls[3].abs() < 5e-6 * pulls[0], "torn apart, it pulls with {pulls:?}, {torn:?}");
}

#[test]
fn a_plastic_bar_yields_in_relaxation_and_keeps_its_set() {
    let law = || {
        let mut given = rubber().1;
        given.push(("yield_stretch", Value::Number(0.01)));
        ("plastic", given)
    };
    let mut world = stretched(0.3, None, law());
    world.dt = 0.1;
    let mut pulls = Vec::new();
    for _ in 0..6 {
        world.step().unwrap();
        pulls.push(world.reactions()[1].force.x);
    }
    let elastic = {
        let mut world = stretched(0.3, None, rubber());
        world.dt = 0.6;
        world.step().unwrap();
        world.reactions()[1].force.x
    };
    println!("pulls {pulls:.0?} N, elastic {elastic:.0} N");
    // it yields: the last tenth adds little, and it is far below what elasticity would give
    assert!(pulls[5] < 0.6 * elastic && pulls[5] - pulls[4] < 0.5 * pulls[0], "{pulls:?} {elastic}");
    // back to where it started, it pushes
    world.anchors[1].velocity = DVec3::ZERO;
    world.step().unwrap();
    let back = world.reactions()[1].force.x;
    println!("back at its first length: {back:.0} N");
    assert!(back < -0.1 * pulls[5]);
}
