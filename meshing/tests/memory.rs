//! Finding families takes little more memory than the families themselves. Alone in its binary, because it counts.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};

use fissure_meshing::TetMesh;
use fissure_meshing::family::{Clip, families};
use fissure_meshing::order::morton_order;
use fissure_meshing::shapes::tet_box;
use glam::DVec3;

struct Counting;

static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: passes everything on to the system's allocator; growing goes through these two.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        PEAK.fetch_max(HELD.fetch_add(layout.size(), SeqCst) + layout.size(), SeqCst);
        // SAFETY: passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), SeqCst);
        // SAFETY: passed on.
        unsafe { System.dealloc(ptr, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn the_peak_is_at_most_a_third_above_the_result() {
    let mesh = tet_box(DVec3::ONE, [18; 3], 0.3, 1).unwrap();
    let order = morton_order(&(0..mesh.tets.len()).map(|t| mesh.barycentre(t)).collect::<Vec<_>>());
    let mesh = TetMesh { tets: order.iter().map(|&t| mesh.tets[t as usize]).collect(), ..mesh };
    let points: Vec<DVec3> = (0..mesh.tets.len()).map(|t| mesh.barycentre(t)).collect();
    let before = HELD.load(SeqCst);
    PEAK.store(before, SeqCst);
    let found = families(&points, 1.45 * mesh.mean_edge(), None).unwrap();
    let (peak, result) = (PEAK.load(SeqCst) - before, HELD.load(SeqCst) - before);
    assert!(found.neighbours.len() > 140 * points.len());
    let share = peak as f64 / result as f64;
    println!("{share:.3} of {result} bytes");
    assert!(share < 1.3); // measured NUMBER

    // what the clip itself keeps of the mesh is counted too, and so are the bonds that it takes away
    let clip = Clip::new(&mesh, None).unwrap();
    let before = HELD.load(SeqCst);
    PEAK.store(before, SeqCst);
    let found = families(&points, 1.45 * mesh.mean_edge(), Some(&clip)).unwrap();
    let share = (PEAK.load(SeqCst) - before) as f64 / (4 * found.neighbours.len()) as f64;
    println!("clipped {share:.3}");
    assert!(share < 1.4); // measured NUMBER
}
