//! A step after the first allocates nothing, also while bonds break. Alone in its binary, because it counts.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use fissure_engine::contact::Mesh;
use fissure_engine::{Collider, Shape};
use fissure_tests::{Block, block};
use glam::{DQuat, DVec3};

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: passes everything on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::SeqCst);
        // SAFETY: passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        // SAFETY: passed on.
        unsafe { System.dealloc(ptr, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_step_after_the_first_allocates_nothing() {
    let mut world = block(&Block { critical_stretch: Some(0.01), ..Block::default() });
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
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    // a worker thread that starts late would be counted
    pool.broadcast(|_| ());
    pool.install(|| {
        world.step().unwrap();
        let before = ALLOCATIONS.load(Ordering::SeqCst);
        for _ in 0..100 {
            world.step().unwrap();
        }
        assert_eq!(ALLOCATIONS.load(Ordering::SeqCst) - before, 0);
    });
    assert!(world.bond_counts().1 > 1000, "nothing broke");
}
