//! Our law keeps its promises.

#[test]
fn stiffening() {
    fissure_materials::conformance::check(&my_material::registry(), "stiffening");
}
