//! A step after the first allocates nothing, also while bonds break. Alone in its binary, because it counts.

use fissure_engine::contact::Mesh;
use fissure_engine::{Anchor, Collider, Integrator, Relax, Shape};
use fissure_tests::counting::{Counting, allocations};
use fissure_tests::{Block, block};
use glam::{DQuat, DVec3};

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_step_after_the_first_allocates_nothing() {
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet] {
        let mut world = block(&Block { critical_stretch: Some(0.01), ..Block::default() });
        world.integrator = integrator;
        world.dt = 0.8 * world.stable_dt();
        world.gravity = DVec3::NEG_Y * 9.81;
        world.colliders.push(Collider::plane("ground", DVec3::Y, -0.2));
        let ball = Shape::Ball { radius: 0.2 };
        let ball = Collider::free("ball", ball, 2000.0, DVec3::new(0.4, 1.3, 0.4), DQuat::IDENTITY).unwrap();
        world.colliders.push(Collider { velocity: DVec3::NEG_Y * 12.0, ..ball });
        let corners: Vec<DVec3> =
            (0..8).map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2))).collect();
        let hull = Shape::Mesh(Mesh::hull(&corners).unwrap());
        world.colliders.push(Collider { position: DVec3::new(-1.1, -0.2, 0.0), ..Collider::new("hull", hull) });
        world.particles.velocity.iter_mut().for_each(|v| *v = DVec3::NEG_Y * 4.0);
        assert_eq!(allocations(1, 100, || world.step().unwrap()), 0, "{integrator:?}");
        assert!(world.bond_counts().1 > 1000, "nothing broke");
    }
    // every step an equilibrium of a block that hangs by one side, which moves up
    let mut world = block(&Block::default());
    world.integrator = Integrator::Relax(Relax::default());
    world.dt = 1.0;
    world.gravity = DVec3::NEG_X * 9.81;
    let held: Vec<u32> =
        (0..world.particles.len()).filter(|&i| world.particles.rest[i].x > 0.3).map(|i| i as u32).collect();
    let start: Vec<DVec3> = held.iter().map(|&i| world.particles.position[i as usize]).collect();
    let up = DVec3::X * 1e-3;
    let anchor = Anchor { particles: held.into(), start: start.into(), until: f64::INFINITY, ..Anchor::default() };
    world.anchors = vec![Anchor { velocity: up, ..anchor }];
    assert_eq!(allocations(1, 3, || world.step().unwrap()), 0, "relax");
    assert!(world.relaxed.iterations > 10, "{:?}", world.relaxed);
}
