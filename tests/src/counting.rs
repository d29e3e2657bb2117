//! An allocator that counts. A program whose tests count has one test only: others would be counted with it.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// The system's allocator, counting; to be a program's `#[global_allocator]`.
pub struct Counting;

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

/// How many allocations `steps` calls of `step` make on two threads, after `first` calls that are not counted.
pub fn allocations(first: usize, steps: usize, mut step: impl FnMut() + Send) -> usize {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("two threads start");
    // a worker thread that starts late would be counted
    pool.broadcast(|_| ());
    pool.install(|| {
        (0..first).for_each(|_| step());
        let before = ALLOCATIONS.load(Ordering::SeqCst);
        (0..steps).for_each(|_| step());
        ALLOCATIONS.load(Ordering::SeqCst) - before
    })
}
