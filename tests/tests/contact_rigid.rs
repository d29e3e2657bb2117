//! Contact of rigid things with each other: what rests stays, edges that cross are felt, momentum is kept, restarts are exact.

use std::f64::consts::FRAC_PI_2;

use fissure_engine::contact::Mesh;
use fissure_engine::{Collider, Shape, World};
use fissure_tests::columns;
use fissure_tests::grains::{G, ball, momentum, steps, world};
use glam::{DQuat, DVec3};

fn free(name: &str, shape: Shape, position: DVec3, orientation: DQuat) -> Collider {
    let c = Collider::free(name, shape, 1000.0, position, orientation).unwrap();
    Collider { restitution: 0.0, ..c }
}

fn slab(name: &str, half: DVec3, position: DVec3, angle: f64) -> Collider {
    free(name, Shape::Box { half }, position, DQuat::from_rotation_y(angle))
}

fn ground() -> Collider {
    Collider { restitution: 0.0, ..Collider::plane("ground", DVec3::Y, 0.0) }
}

/// The fastest of the free colliders, with what their spin moves [m/s].
fn fastest(w: &World) -> f64 {
    let free = w.colliders.iter().filter(|c| c.is_free());
    free.map(|c| c.velocity.length() + c.spin().length() * c.shape.radius()).fold(0.0, f64::max)
}

#[test]
fn a_stack_stays_where_it_was_put() {
    let mut world = world(G);
    world.dt = 1e-3;
    world.colliders.push(ground());
    for k in 0..6 {
        let wide = 0.2 - 0.02 * f64::from(k);
        let place = DVec3::new(0.01 * f64::from(k % 2), 0.05 + 0.1 * f64::from(k) + 1e-4, 0.0);
        world.colliders.push(slab(&format!("box {k}"), DVec3::new(wide, 0.05, wide), place, 0.3 * f64::from(k)));
    }
    steps(&mut world, 2000);
    let places: Vec<DVec3> = world.colliders.iter().map(|c| c.position).collect();
    steps(&mut world, 3000);
    let crept = world.colliders.iter().zip(&places).map(|(c, p)| c.position.distance(*p)).fold(0.0, f64::max);
    let top = &world.colliders[6];
    println!("crept {crept:.1e} m, {:.1e} m/s, top at {}", fastest(&world), top.position);
    // measured 7e-20 m and 5e-18 m/s
    assert!(crept < 1e-12 && fastest(&world) < 1e-12, "{crept:e} m, {:e} m/s", fastest(&world));
    assert!((top.position.y - 0.55).abs() < 1e-3, "the top is at {}", top.position);
}

/// Corners do not help here: a plank across another, a capsule across an edge, a lying cylinder on a narrow beam.
#[test]
fn what_crosses_another_rests_on_it() {
    let lying = DQuat::from_rotation_x(FRAC_PI_2);
    let cases = [
        // measured 1e-17, 2e-4 and 5e-4 m/s: nothing hinders the round ones from rolling
        (Shape::Box { half: DVec3::new(0.05, 0.05, 0.5) }, DQuat::IDENTITY, 1e-12),
        (Shape::Capsule { half: 0.5, radius: 0.05 }, lying, 2e-3),
        (Shape::Cylinder { half: 0.5, radius: 0.05 }, lying, 5e-3),
    ];
    for (shape, orientation, slow) in cases {
        let mut world = world(G);
        let name = shape.name();
        world.dt = 1e-3;
        world.colliders.push(ground());
        world.colliders.push(slab("below", DVec3::new(0.5, 0.05, 0.05), DVec3::Y * 0.05, 0.0));
        world.colliders.push(free("above", shape, DVec3::Y * 0.16, orientation));
        steps(&mut world, 3000);
        let above = &world.colliders[2];
        println!("{name}: {} {:.1e} m/s", above.position, fastest(&world));
        assert!((above.position.y - 0.15).abs() < 1e-3, "{name} is at {}", above.position);
        assert!(fastest(&world) < slow, "{name}: {:e} m/s", fastest(&world));
    }
}

#[test]
fn a_box_on_a_slope_slides_where_friction_ends() {
    for (friction, holds) in [(0.55, true), (0.45, false)] {
        let mut world = world(G);
        world.dt = 1e-3;
        let turn = DQuat::from_rotation_z(0.5_f64.atan()); // slides below 0.5
        let slope = Shape::Box { half: DVec3::new(5.0, 0.1, 1.0) };
        world.colliders.push(Collider { friction, orientation: turn, ..Collider::new("slope", slope) });
        let above = free("box", Shape::Box { half: DVec3::splat(0.1) }, turn * (DVec3::Y * 0.2), turn);
        world.colliders.push(Collider { friction, ..above });
        steps(&mut world, 1000);
        let way = world.colliders[1].position.distance(turn * (DVec3::Y * 0.2));
        // g (sin a - mu cos a) t²/2
        let want = if holds { 0.0 } else { 9.81 * (0.5 - friction) / 1.25_f64.sqrt() / 2.0 };
        println!("friction {friction}: {way:.3e} m of {want:.3e}");
        assert!((way - want).abs() < 2e-3, "{friction}: {way} instead of {want}");
    }
}

/// One of each shape, thrown at each other without gravity.
fn scatter() -> World {
    let mut world = world(DVec3::ZERO);
    let cross = |k: usize| DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64) - 0.5;
    let hull = Mesh::hull(&(0..8).map(|k| cross(k) * DVec3::new(0.3, 0.2, 0.25)).collect::<Vec<_>>()).unwrap();
    // a wedge with a notch: not convex
    let outline = [(-0.2, -0.15), (0.2, -0.15), (0.2, 0.15), (0.0, 0.0), (-0.2, 0.15)];
    let vertices = [-0.1, 0.1].iter().flat_map(|z| outline.iter().map(|(x, y)| DVec3::new(*x, *y, *z))).collect();
    let front = [[0, 1, 3], [1, 2, 3], [0, 3, 4]];
    let back = front.iter().map(|&[a, b, c]: &[u32; 3]| [a, c, b]);
    let sides = (0..5).flat_map(|k: u32| {
        let next = (k + 1) % 5;
        [[k, next, next + 5], [k, next + 5, k + 5]]
    });
    let notched =
        Mesh::new(vertices, back.chain(front.iter().map(|t| t.map(|v| v + 5))).chain(sides).collect()).unwrap();
    let shapes = [
        Shape::Ball { radius: 0.15 },
        Shape::Box { half: DVec3::new(0.1, 0.2, 0.15) },
        Shape::Capsule { half: 0.15, radius: 0.1 },
        Shape::Cylinder { half: 0.15, radius: 0.12 },
        Shape::Mesh(hull),
        Shape::Mesh(notched),
    ];
    for (k, shape) in shapes.into_iter().enumerate() {
        let angle = k as f64;
        let place = DVec3::new(angle.cos(), angle.sin(), 0.2 * (angle * 2.0).sin()) * 0.6;
        let c = free(&format!("thing {k}"), shape, place, DQuat::from_rotation_x(angle));
        world.colliders.push(Collider { velocity: -place * 3.0, ..c }.spun(DVec3::new(angle, 2.0, -angle)));
    }
    world
}

#[test]
fn things_of_all_shapes_keep_their_momentum() {
    let mut world = scatter();
    let before = momentum(&world);
    let start: Vec<DVec3> = world.colliders.iter().map(|c| c.velocity).collect();
    steps(&mut world, 8000);
    let after = momentum(&world);
    let (linear, angular) = ((after.0 - before.0).length() / before.2, (after.1 - before.1).length() / before.3);
    println!("drift {linear:.1e} {angular:.1e}");
    let hit = world.colliders.iter().zip(&start).filter(|(c, v)| c.velocity.distance(**v) > 0.1).count();
    assert_eq!(hit, 6, "something was not hit");
    // measured 9e-16 and 2e-13
    assert!(linear < 5e-14 && angular < 1e-12, "{linear:e} {angular:e}");
}

#[test]
fn they_go_on_to_the_same_bits_after_a_restart() {
    let heap = || {
        let mut world = scatter();
        world.gravity = G;
        world.colliders.push(Collider { position: DVec3::NEG_Y * 0.9, ..ground() });
        world.colliders.push(ball(0.1, DVec3::Y, DVec3::NEG_Y * 3.0));
        world
    };
    let mut one = heap();
    steps(&mut one, 10_000);
    let saved = columns(&mut one);
    let impulses = saved.iter().find(|c| c.0.contains("rigid_impulse")).expect("a column");
    assert!(impulses.1.len() > 3 * 24, "hardly anything touches");
    let mut again = heap();
    let mut next = saved.iter();
    again.visit(&mut |_, _, data| assert!(data.set_bytes(&next.next().unwrap().1)));
    steps(&mut one, 500);
    steps(&mut again, 500);
    for (a, b) in columns(&mut one).iter().zip(columns(&mut again)) {
        assert!(a.0 == b.0 && a.1 == b.1, "{} differs", a.0);
    }
}

#[test]
fn a_fast_one_neither_passes_a_thin_wall_nor_hits_what_it_would_miss() {
    for (height, hits) in [(0.0, true), (0.7, false)] {
        let mut world = world(DVec3::ZERO);
        world.dt = 1e-2;
        world.colliders.push(Collider::new("wall", Shape::Box { half: DVec3::new(1e-3, 0.5, 0.5) }));
        let place = DVec3::new(-1.05, height, 0.0);
        world.colliders.push(slab("bullet", DVec3::splat(0.05), place, 0.4));
        world.colliders[1].velocity = DVec3::X * 800.0;
        steps(&mut world, 3);
        let x = world.colliders[1].position.x;
        assert!((x < 0.0) == hits, "at height {height} it got to {x}");
    }
}
