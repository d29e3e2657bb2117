//! Table 1 of Chen et al.: what must be seen of figures, jello, bunny and sheet (Figs. 3, 8, 14, 16, 17), coarse and short.

use fissure_io::simulation::Simulation;
use fissure_tests::meshes;
use fissure_tests::scene::{assert_closed, bonded_pieces, build, crack_faces, displacements, fragments, run};
use glam::{DVec2, DVec3};

/// What makes a scene take the mesh `name`, which is not part of the project, if it is there.
fn foreign(body: &str, name: &str) -> Option<String> {
    meshes().map(|folder| format!("body.{body}.mesh={}", folder.join("surface").join(name).display()))
}

/// The largest stretch of a bond of the first body.
fn largest_stretch(simulation: &Simulation) -> f64 {
    let p = &simulation.world.particles;
    let bonds = simulation.world.bodies[0].material.bonds().expect("a body of bonds");
    let stretch = |i: usize, j: usize| {
        p.position[i].distance(p.position[j]) / p.rest[i].as_dvec3().distance(p.rest[j].as_dvec3()) - 1.0
    };
    let rows = 0..bonds.rows();
    rows.flat_map(|i| bonds.slots(i).map(move |k| stretch(i, bonds.neighbours[k] as usize))).fold(0.0, f64::max)
}

fn springs_back(mesh: &str) {
    let mut s = build("fig03_armadillo", &[mesh, "body.figure.tets=3000"]);
    let total = |s: &mut Simulation| {
        let e = s.world.energies();
        e.kinetic + e.elastic + e.gravity
    };
    // how far the back is behind its place
    let back = |s: &Simulation| {
        let (u, held) = (displacements(s, 0), &s.world.anchors[4].particles);
        held.iter().map(|&i| u[i as usize].1.z).sum::<f64>() / held.len() as f64
    };
    run(&mut s, 0.05);
    let (drawn, stretch, start) = (back(&s), largest_stretch(&s), total(&mut s));
    let mut foremost = f64::INFINITY;
    while s.world.time < 0.06 {
        s.step().unwrap_or_else(|e| panic!("{e}"));
        foremost = foremost.min(back(&s));
    }
    let drift = total(&mut s) / start - 1.0;
    // measured: stretch 1.7, springs to -0.29 m, energy -3e-3; the armadillo 1.9, -0.29 m, -5e-3
    println!("drawn {drawn:.3} m, stretch {stretch:.2}, springs to {foremost:.3} m, energy {drift:+.1e}");
    assert!((drawn - 0.2).abs() < 1e-9 && stretch > 0.5, "{drawn} {stretch}");
    assert!(foremost < -0.4 * drawn, "{foremost}");
    assert!(drift.abs() < 0.03, "{drift}");
    assert_eq!((s.world.bond_counts().1, fragments(&s).len()), (0, 1), "something tore");
}

#[test]
fn figure_3_limbs_stretch_far_and_the_body_springs_past_its_place() {
    springs_back("body.figure.mesh=assets/figure.ply");
}

#[test]
#[ignore = "the armadillo has finer limbs; 15 s"]
fn figure_3_of_the_armadillo() {
    foreign("figure", "armadillo_2.5k.ply").into_iter().for_each(|mesh| springs_back(&mesh));
}

fn is_torn(mesh: &str) {
    let mut s = build("fig14_torn", &[mesh, "body.figure.tets=3000"]);
    let (mut torn, mut first_break) = (Vec::new(), 0.0);
    while s.world.time < 0.08 {
        s.step().unwrap_or_else(|e| panic!("{e}"));
        if first_break == 0.0 && s.world.bond_counts().1 > 0 {
            first_break = s.world.time;
        }
        if s.world.step.is_multiple_of(20) {
            // limbs on the piece that most particles are on, and the others
            let (piece, count) = bonded_pieces(&s, 0);
            let trunk = (0..count as u32).max_by_key(|p| piece.iter().filter(|q| *q == p).count());
            let off = s.world.anchors.iter().filter(|a| Some(piece[a.particles[0] as usize]) != trunk).count();
            if off > torn.len() {
                torn.resize(off, s.world.time);
            }
        }
    }
    // measured: 0.012; 0.030, 0.031, 0.064 s; the armadillo 0.011; 0.027, 0.034, 0.034 s
    println!("first bond at {first_break:.4} s, limbs off at {torn:.4?} s");
    assert!(torn.len() >= 2, "{} limbs are off", torn.len());
    assert!(torn[0] > first_break + 0.001, "torn at once, not progressively: {first_break} {torn:?}");
    assert!(torn[0] < torn[torn.len() - 1], "all at once: {torn:?}");
    assert_closed(&s.frame(1), "torn figure");
}

#[test]
fn figure_14_limbs_tear_off_one_after_another() {
    is_torn("body.figure.mesh=assets/figure.ply");
}

#[test]
#[ignore = "the armadillo has finer limbs; 20 s"]
fn figure_14_of_the_armadillo() {
    foreign("figure", "armadillo_2.5k.ply").into_iter().for_each(|mesh| is_torn(&mesh));
}

#[test]
fn figure_8_the_bullet_passes_and_leaves_rugged_surfaces() {
    let mut s = build("fig08_jello", &["body.jello.tets=6000"]);
    run(&mut s, 0.011);
    let faces: Vec<_> = crack_faces(&s, 0).into_iter().filter(|f| f.open).collect();
    let area: f64 = faces.iter().map(|f| f.area).sum();
    let directions = faces.iter().map(|f| f.normal * f.normal * f.area).sum::<DVec3>() / area;
    let (fragments, bullet) = (fragments(&s), &s.world.colliders[1]);
    let places = (bullet.position.x, bullet.velocity.x);
    // measured: 0.32 m, 45 m/s; 0.30 m²; 0.27, 0.37, 0.36; 43 fragments, the largest 96 %
    println!("bullet {places:.3?}, cracks {area:.3} m², n² {directions:.2}, {} {fragments:?}", fragments.len());
    assert!(bullet.position.x > 0.29 && bullet.velocity.x > 30.0, "the bullet is stuck at {places:?}");
    // the smooth wall of its channel would be 0.11 m², on both sides of a cut 0.05 m² for its outline
    assert!(area > 0.2, "cracks of {area} m²");
    assert!(directions.min_element() > 0.15, "cracks in one direction: {directions}");
    assert!(fragments.len() > 15 && fragments[0] as f64 > 0.9 * s.world.particles.len() as f64, "{fragments:?}");
    assert_closed(&s.frame(1), "jello");
}

fn breaks_again(mesh: &str) {
    const WINDOW: f64 = 0.03; // [s]
    let mut s = build("bunny", &[mesh, "body.bunny.tets=4000"]);
    let mass: f64 = s.world.particles.mass.iter().sum();
    let speed = |s: &Simulation| {
        let p = &s.world.particles;
        (0..p.len()).map(|i| p.velocity[i].y * p.mass[i]).sum::<f64>() / mass
    };
    // of each window: bonds broken in it, share of the weight that the ground bore, fragments at its end
    let mut windows = Vec::new();
    while s.world.time < 0.69 {
        let (broken, fall, start) = (s.world.bond_counts().1, speed(&s), s.world.time);
        run(&mut s, start + WINDOW);
        let borne = 1.0 + (speed(&s) - fall) / (s.world.time - start) / 9.81;
        windows.push(((s.world.bond_counts().1 - broken) / 2, borne, fragments(&s).len()));
    }
    // pieces fly where least breaks, and land where most breaks after that
    let lull = (5..17).min_by_key(|&k| windows[k].0).expect("a range");
    let again = (lull + 1..windows.len()).max_by_key(|&k| windows[k].0).expect("windows after the lull");
    // measured: 39 bonds, 1.1 and 120 bonds, 1.8, 236 fragments and 239 at the end; the bunny 105 bonds, 1.1 and 342
    // bonds, 1.6, 224 fragments and more than 233. Roundings move these by tens of bonds
    println!("lull {lull} {:.2?}, again {again} {:.2?}", windows[lull], windows[again]);
    assert!(windows[again].0 as f64 > 1.5 * windows[lull].0 as f64, "no second fracture: {windows:?}");
    assert!(windows[again].1 > windows[lull].1 + 0.2, "it breaks where nothing lands: {windows:?}");
    assert!(windows[windows.len() - 1].2 >= windows[lull].2 + 2, "no new fragments: {windows:?}");
}

#[test]
fn figure_16_the_pieces_break_again_where_they_land() {
    breaks_again("body.bunny.mesh=assets/figure.ply");
}

#[test]
fn figure_16_of_the_bunny() {
    foreign("bunny", "bunny_5k.ply").into_iter().for_each(|mesh| breaks_again(&mesh));
}

#[test]
fn figure_17_cracks_start_at_the_cuts_and_part_the_sheet() {
    // thicker, so that few elements will do
    let mut s = build("fig17_sheet", &["body.sheet.tets=6000", "body.sheet.shape.thickness=0.08"]);
    let tips =
        [(-0.12, 0.3), (0.12, -0.3), (0.12, 0.12), (0.18, 0.28), (-0.18, -0.28), (-0.12, -0.12)].map(DVec2::from);
    let farthest = |s: &Simulation| {
        let places = displacements(s, 0).into_iter().zip(s.world.particles.damage.iter());
        let damaged = places.filter(|(_, damage)| **damage > 0.0).map(|((x, _), _)| x.truncate());
        damaged.map(|x| tips.iter().map(|t| t.distance(x)).fold(f64::INFINITY, f64::min)).fold(0.0, f64::max)
    };
    run(&mut s, 0.012);
    let (started, broken) = (farthest(&s) / s.world.bodies[0].horizon, s.world.bond_counts().1 / 2);
    run(&mut s, 0.06);
    let (piece, _) = bonded_pieces(&s, 0);
    let sides = [0, 1].map(|a| piece[s.world.anchors[a].particles[0] as usize]);
    // measured: 717 bonds within 1.4 horizons
    println!("at first {broken} broken bonds within {started:.1} horizons; then {:?}", s.world.bond_counts());
    assert!(broken > 300 && started < 2.0, "{broken} bonds, up to {started} horizons from the ends of the cuts");
    assert!(sides[0] != sides[1], "the sheet holds");
    assert_closed(&s.frame(1), "torn sheet");
}
