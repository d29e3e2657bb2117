//! Every registered law keeps its promises.

use fissure_materials::conformance;

#[test]
fn every_registered_law_keeps_its_promises() {
    conformance::check_all(&fissure_materials::registry());
}
