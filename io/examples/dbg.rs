use fissure_io::scene::Scene;
use fissure_io::simulation::Simulation;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let scene = Scene::load(std::path::Path::new(&a[1]), &a[2..]).unwrap();
    let sim = Simulation::build(&scene, &fissure_materials::registry(), &mut |_| ()).unwrap();
    let b = &sim.world.bodies[0];
    let bonds = b.material.bonds().unwrap();
    let p = sim.world.particles.of(&b.range);
    let n = p.len();
    let m: Vec<f64> = (0..n)
        .map(|i| {
            bonds
                .slots(i)
                .map(|k| {
                    let j = bonds.neighbours[k] as usize;
                    bonds.weight[k] as f64 * p.rest[i].as_dvec3().distance_squared(p.rest[j].as_dvec3()) * p.volume[j]
                })
                .sum()
        })
        .collect();
    let mut r: Vec<(f64, usize, f64, f64, u32)> = (0..n)
        .map(|i| {
            let s: f64 = bonds
                .slots(i)
                .map(|k| {
                    let j = bonds.neighbours[k] as usize;
                    bonds.weight[k] as f64 * p.volume[j] * (1.0 / m[i] + 1.0 / m[j])
                })
                .sum();
            let minr =
                bonds.slots(i).map(|k| p.rest[i].distance(p.rest[bonds.neighbours[k] as usize])).fold(9.0f32, f32::min);
            (s * 15.0 * 6e5 / 2400.0, i, m[i], minr as f64, bonds.family[i])
        })
        .collect();
    r.sort_by(|a, b| b.0.total_cmp(&a.0));
    for q in r.iter().take(8) {
        println!(
            "dt~{:.2e} i={} m={:.2e} minr={:.2e} fam={} V={:.2e}",
            (2.0 / q.0).sqrt() * 1.7,
            q.1,
            q.2,
            q.3,
            q.4,
            p.volume[q.1]
        );
    }
    for f in [100, 1000, n / 2] {
        let q = r[f];
        println!(
            "rank {f}: dt~{:.2e} m={:.2e} minr={:.2e} fam={} V={:.2e}",
            (2.0 / q.0).sqrt() * 1.7,
            q.2,
            q.3,
            q.4,
            p.volume[q.1]
        );
    }
    let mut fam: Vec<u32> = bonds.family.to_vec();
    fam.sort();
    println!("family min {} 1% {} med {}", fam[0], fam[n / 100], fam[n / 2]);
    let mut v = p.volume.to_vec();
    v.sort_by(f64::total_cmp);
    println!("V min {:.2e} 1% {:.2e} med {:.2e}", v[0], v[n / 100], v[n / 2]);
}
