//! Families against the naive double loop, on lattices, and clipped.

mod clipped;
pub(crate) mod meshes;

use super::*;
use meshes::random;

fn naive(points: &[DVec3], horizon: f64) -> Vec<Vec<u32>> {
    let near = |i: usize, j: usize| i != j && points[j].distance_squared(points[i]) <= horizon * horizon;
    (0..points.len()).map(|i| (0..points.len() as u32).filter(|&j| near(i, j as usize)).collect()).collect()
}

fn rows(f: &Families) -> Vec<Vec<u32>> {
    (0..f.len()).map(|i| f.row(i).to_vec()).collect()
}

fn cloud(n: usize, seed: u64) -> Vec<DVec3> {
    let coordinate = |i: usize, k: u64| random(seed + 3 * i as u64 + k);
    (0..n).map(|i| DVec3::new(coordinate(i, 0), coordinate(i, 1), coordinate(i, 2))).collect()
}

fn lattice(n: usize, spacing: f64, corner: DVec3) -> Vec<DVec3> {
    let at = |i: usize| DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64);
    (0..n * n * n).map(|i| corner + at(i) * spacing).collect()
}

pub(super) fn assert_symmetric(f: &Families) {
    for i in 0..f.len() {
        assert!(f.row(i).is_sorted_by(|a, b| a < b), "row {i} ascends");
        for &j in f.row(i) {
            assert!(j as usize != i && f.row(j as usize).binary_search(&(i as u32)).is_ok(), "{i} - {j}");
        }
    }
}

#[test]
fn equals_the_naive_double_loop() {
    for (n, horizon) in [(2, 2.0), (300, 0.5), (1500, 0.2), (1500, 3.0)] {
        let points = cloud(n, 7);
        let found = families(&points, horizon, None).unwrap();
        assert_eq!(rows(&found), naive(&points, horizon), "{n} points");
        assert_symmetric(&found);
    }
}

#[test]
fn a_lattice_with_a_horizon_of_exactly_three_spacings_is_symmetric() {
    // Spacing 0.1 and an odd corner: which pairs lie within 0.3 is up to rounding, but both ends must agree.
    for corner in [DVec3::ZERO, DVec3::new(0.37, -11.3, 1.0 / 3.0)] {
        let points = lattice(11, 0.1, corner);
        let found = families(&points, 0.3, None).unwrap();
        assert_symmetric(&found);
        assert_eq!(rows(&found), naive(&points, 0.3));
    }
    // In exact numbers a whole family has 122.
    let found = families(&lattice(9, 0.125, DVec3::ZERO), 0.375, None).unwrap();
    assert_eq!(found.row((4 * 9 + 4) * 9 + 4).len(), 122);
}

#[test]
fn coincident_points_are_neighbours() {
    let found = families(&[DVec3::ONE; 70], 0.1, None).unwrap();
    assert_eq!(found.neighbours.len(), 70 * 69);
    assert_symmetric(&found);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let points = cloud(30_000, 3);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| families(&points, 0.07, None).unwrap_or_else(|e| panic!("{e}")))
    };
    let one = on(1);
    assert!(one.neighbours.len() > 300_000);
    assert!(one == on(3));
}

#[test]
fn bad_input_is_refused_with_a_cure() {
    let mut points = cloud(100, 1);
    assert_eq!(families(&points, -1.0, None), Err(FamilyError::BadHorizon(-1.0)));
    assert!(matches!(families(&points, f64::NAN, None), Err(FamilyError::BadHorizon(_))));
    points[41].y = f64::NAN;
    assert!(matches!(families(&points, 1.0, None), Err(FamilyError::NotFinite { index: 41, .. })));

    let spread = lattice(3, 0.5, DVec3::ZERO);
    let alone = FamilyError::Isolated { count: 27, particles: 27, first: 0, horizon: 0.4, spacing: 0.5 };
    assert_eq!(families(&spread, 0.4, None), Err(alone.clone()));
    let text = alone.to_string();
    assert!(text.contains("27 of 27") && text.contains("5.0000e-1"), "{text}");
    assert!(matches!(
        families(&[DVec3::ZERO], 1.0, None),
        Err(FamilyError::Isolated { count: 1, spacing: f64::INFINITY, .. })
    ));
    assert_eq!(families(&[], 1.0, None).unwrap().offsets, [0]);
}

/// Speed and memory at the size that matters; by hand: `cargo test -p fissure-meshing --release -- --ignored big`.
#[test]
#[ignore = "takes seconds and is worth reading only in a release build"]
fn big_cloud() {
    let n = 300_000;
    let mut points = cloud(n, 5);
    let order = crate::order::morton_order(&points);
    points = order.iter().map(|&i| points[i as usize]).collect();
    let horizon = (172.0 / n as f64 * 3.0 / (4.0 * std::f64::consts::PI)).cbrt();
    for _ in 0..3 {
        let start = std::time::Instant::now();
        let found = families(&points, horizon, None).unwrap();
        let mean = found.neighbours.len() as f64 / n as f64;
        println!("{mean:.0} neighbours, {:.2} s", start.elapsed().as_secs_f64());
        assert!((150.0..172.0).contains(&mean));
        assert_eq!(found.neighbours.capacity(), found.neighbours.len());
    }
}

/// The same for tetrahedra, with and without their clip.
#[test]
#[ignore = "takes seconds and is worth reading only in a release build"]
fn big_mesh() {
    let mesh = crate::shapes::tet_box(DVec3::ONE, [37; 3], 0.3, 1).unwrap();
    let centre = |t: usize| mesh.barycentre(t);
    let order = crate::order::morton_order(&(0..mesh.tets.len()).map(centre).collect::<Vec<_>>());
    let mesh = crate::TetMesh { tets: order.iter().map(|&t| mesh.tets[t as usize]).collect(), ..mesh };
    let points: Vec<DVec3> = (0..mesh.tets.len()).map(|t| mesh.barycentre(t)).collect();
    let clip = Clip::new(&mesh, None).unwrap();
    for clip in [None, Some(&clip)] {
        let start = std::time::Instant::now();
        let found = families(&points, 1.45 * mesh.mean_edge(), clip).unwrap();
        let mean = found.neighbours.len() as f64 / points.len() as f64;
        println!("{mean:.0} neighbours, clipped {}: {:.2} s", clip.is_some(), start.elapsed().as_secs_f64());
        assert!((100.0..200.0).contains(&mean));
        assert_symmetric(&found);
    }
}
