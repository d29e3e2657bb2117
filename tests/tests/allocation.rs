//! A step after the first allocates nothing, also while bonds break. Alone in its binary, because it counts.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use fissure_engine::{Anchor, Ground, Integrator, Relax, World};
use fissure_tests::{Block, block};
use glam::DVec3;

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

fn allocations_after_the_first_step(world: &mut World, steps: usize) -> usize {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    // a worker thread that starts late would be counted
    pool.broadcast(|_| ());
    pool.install(|| {
        world.step().unwrap();
        let before = ALLOCATIONS.load(Ordering::SeqCst);
        (0..steps).for_each(|_| world.step().unwrap());
        ALLOCATIONS.load(Ordering::SeqCst) - before
    })
}

#[test]
fn a_step_after_the_first_allocates_nothing() {
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet] {
        let mut world = block(&Block { critical_stretch: Some(0.01), ..Block::default() });
        world.integrator = integrator;
        world.dt = 0.8 * world.stable_dt();
        world.gravity = DVec3::NEG_Y * 9.81;
        world.ground = Some(Ground { height: -0.2, ..Ground::default() });
        world.particles.velocity.iter_mut().for_each(|v| *v = DVec3::NEG_Y * 4.0);
        assert_eq!(allocations_after_the_first_step(&mut world, 100), 0, "{integrator:?}");
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
    assert_eq!(allocations_after_the_first_step(&mut world, 3), 0, "relax");
    assert!(world.relaxed.iterations > 10, "{:?}", world.relaxed);
}
