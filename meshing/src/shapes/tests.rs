//! placeholder
#[test]
fn dump() {
    let m = super::vase(0.3, 0.012, 56).unwrap();
    println!("{} {:?}", m.triangles.len(), crate::surface::check(&m));
    let p = super::vase_profile(0.3, 0.012, 0.0095).unwrap();
    std::fs::write("/tmp/vase_profile.txt", p.iter().map(|p| format!("{} {}\n", p.0, p.1)).collect::<String>())
        .unwrap();
}
