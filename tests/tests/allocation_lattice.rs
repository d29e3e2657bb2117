//! A step of a lattice whose nodes do not change allocates nothing. Alone in its program, because it counts.

use fissure_tests::counting::{Counting, allocations};
use glam::DVec3;

#[path = "../../materials/tests/lattice/body.rs"]
#[allow(dead_code, reason = "the tests of the law use more of it")]
mod body;

use body::{METHODS, Solid, number, vector, word};

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_step_without_a_change_of_nodes_allocates_nothing() {
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
            let counted = allocations(3, 20, || world.step().unwrap());
            assert_eq!(counted, 0, "{method} with {} nodes", world.particles.len());
        }
    }
}
