//! A step of a lattice whose nodes do not change allocates nothing. Alone in its program, because it counts.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;

#[path = "lattice/body.rs"]
#[allow(dead_code)]
mod body;

use body::{METHODS, Solid, number, vector, word};

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
fn a_step_without_a_change_of_nodes_allocates_nothing() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    pool.broadcast(|_| ());
    for method in METHODS {
        for more in [vec![], vec![("passes", number(2.0)), ("damping", number(0.5)), ("yield_strain", number(0.05))]] {
            let mut given =
                vec![("method", word(method)), ("critical_stretch", number(9.0)), ("subdivide_at", number(9.0))];
            given.extend(more);
            given.push(("merge", word("no")));
            let solid = Solid::new([24, 20, 20], |[x, y, _]| x < 12 || y < 9).partial();
            let mut world = solid.world(&given);
            for i in 0..world.particles.len() {
                world.particles.velocity[i] = vector(i, 4) * 0.5 + DVec3::Y * world.particles.rest[i].as_dvec3().x;
            }
            let counted = pool.install(|| {
                (0..3).for_each(|_| world.step().unwrap());
                let before = ALLOCATIONS.load(Ordering::SeqCst);
                (0..20).for_each(|_| world.step().unwrap());
                ALLOCATIONS.load(Ordering::SeqCst) - before
            });
            assert_eq!(counted, 0, "{method} with {} nodes", world.particles.len());
        }
    }
}
