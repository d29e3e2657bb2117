//! The scenes of the lattice, run short: what their headers say must be seen is there.

use std::collections::BTreeMap;

use fissure_io::frames::Frame;
use fissure_io::simulation::Simulation;
use fissure_tests::scene::{build, run};
use glam::{DVec3, Vec3};

/// Every edge of the surface has two triangles, one each way, by the ids of copies that the frame keeps apart.
fn assert_closed(frame: &Frame, what: &str) {
    fissure_tests::scene::assert_closed(frame, what);
    assert!(frame.positions.iter().flatten().all(|x| x.is_finite()), "{what}: not finite");
    for t in &frame.triangles {
        let inside = t.map(|v| frame.inside[v as usize]);
        let piece = t.map(|v| frame.piece[v as usize]);
        assert!(inside[0] == inside[1] && inside[1] == inside[2], "{what}: a triangle is inside and outside");
        assert!(piece[0] == piece[1] && piece[1] == piece[2], "{what}: a triangle of two pieces");
    }
}

fn pieces(frame: &Frame) -> usize {
    frame.piece.iter().max().map_or(0, |p| *p as usize + 1)
}

/// Area [m²] and mean share along the axis that it is nearest to of the normals of crack faces.
fn crack(frame: &Frame) -> (f64, f64) {
    let (mut area, mut along) = (0.0, 0.0);
    for t in frame.triangles.iter().filter(|t| frame.inside[t[0] as usize] == 1) {
        let [a, b, c] = t.map(|v| Vec3::from(frame.positions[v as usize]).as_dvec3());
        let across = (b - a).cross(c - a) / 2.0;
        area += across.length();
        along += across.abs().max_element();
    }
    (area, along / area)
}

fn nodes(simulation: &Simulation, k: usize) -> usize {
    simulation.world.bodies[k].material.nodes().expect("a lattice").nodes()
}

#[test]
fn a_sphere_breaks_into_closed_halves_raw_fitted_and_noisy() {
    let mut found = BTreeMap::new();
    for kind in ["raw", "fitted", "noisy"] {
        let look = format!("body.sphere.crack_faces.kind={kind}");
        let mut simulation = build("lattice/sphere", &["body.sphere.cells=600", &look]);
        let start = simulation.frame(0);
        assert_closed(&start, kind);
        assert!(start.inside.iter().all(|&i| i == 0) && pieces(&start) == 1);
        for k in 1..=6 {
            run(&mut simulation, 0.1 * f64::from(k));
            assert_closed(&simulation.frame(k), kind);
        }
        let frame = simulation.frame(7);
        assert!(pieces(&frame) >= 2, "{kind}: it is whole");
        let outside = frame.triangles.iter().filter(|t| frame.inside[t[0] as usize] == 0).count();
        println!("{kind}: {} pieces, crack {:?}, {outside} triangles outside", pieces(&frame), crack(&frame));
        found.insert(kind, crack(&frame));
    }
    // both halves show the disc that was between them, once each
    let discs = 2.0 * std::f64::consts::PI * 0.5 * 0.5;
    for kind in ["fitted", "noisy"] {
        assert!((0.8..3.0).contains(&(found[kind].0 / discs)), "{kind}: {:?}", found[kind]); // measured
    }
    assert!(found["raw"].0 > found["fitted"].0, "bricks end beyond the surface");
}

#[test]
fn a_figure_that_hangs_by_its_head_tears_and_the_rest_falls() {
    let mut simulation = build("lattice/hung", &["body.figure.cells=700"]);
    let cells = nodes(&simulation, 0);
    let (mut least, mut last) = (cells, 0);
    for k in 1..=12 {
        run(&mut simulation, 0.1 * f64::from(k));
        least = least.min(nodes(&simulation, 0));
        let frame = simulation.frame(k);
        assert_closed(&frame, "hung");
        assert!(pieces(&frame) >= last, "pieces do not join again");
        last = pieces(&frame);
    }
    println!("{cells} cells, {least} nodes at the least, {last} pieces");
    assert!(2 * least < cells, "{least} nodes of {cells} cells"); // measured
    assert!(last >= 2, "nothing tore");
    let p = &simulation.world.particles;
    let lowest = p.position.iter().map(|x| x.y).fold(f64::INFINITY, f64::min);
    assert!(lowest < -0.5, "the rest fell to {lowest}"); // measured
}

#[test]
fn a_dropped_glob_stays_whole_and_its_surface_never_jumps() {
    let mut simulation = build("lattice/dropped", &["body.glob.cells=600"]);
    let (mut before, mut levels, mut changes, mut worst) = (simulation.frame(0), nodes(&simulation, 0), 0, 0.0f64);
    while simulation.world.time < 1.2 {
        simulation.step().unwrap();
        let frame = simulation.frame(0);
        assert_eq!(pieces(&frame), 1);
        if nodes(&simulation, 0) != levels {
            levels = nodes(&simulation, 0);
            changes += 1;
        }
        // how far a vertex is from where its velocity takes it, in steps of the fastest
        let dt = simulation.world.dt;
        let fastest = frame.velocity.iter().map(|v| Vec3::from(*v).length()).fold(0.0f32, f32::max);
        for (k, v) in frame.velocity.iter().enumerate() {
            let moved = (Vec3::from(frame.positions[k]) - Vec3::from(before.positions[k])).as_dvec3();
            let jump = (moved - Vec3::from(*v).as_dvec3() * dt).length() / dt;
            worst = worst.max(jump / f64::from(fastest).max(1.0));
        }
        before = frame;
    }
    println!("{changes} changes of level, largest jump {worst:.3} of the fastest speed");
    assert!(changes > 0, "no node split or merged"); // measured
    assert!(worst < 1.0, "the surface jumps: {worst}"); // measured
    let middle: DVec3 =
        simulation.world.particles.position.iter().sum::<DVec3>() / simulation.world.particles.len() as f64;
    assert!(middle.y > 0.1 && middle.y < 0.8, "{middle}");
}

#[test]
fn nodes_merge_again_after_a_tear() {
    let mut simulation = build("lattice/merging", &["body.bar.cells=1500"]);
    let mut counts = Vec::new();
    for k in 1..=30 {
        run(&mut simulation, 0.05 * f64::from(k));
        counts.push(nodes(&simulation, 0));
    }
    let frame = simulation.frame(0);
    assert_closed(&frame, "merging");
    println!("nodes {counts:?}, {} pieces", pieces(&frame));
    let most = *counts.iter().max().unwrap();
    assert!(pieces(&frame) >= 2, "nothing tore");
    assert!(4 * counts[29] < 3 * most, "{} nodes at the end, {most} at the most", counts[29]); // measured
}

#[test]
fn elephants_fall_on_a_ball_and_stay_closed() {
    let cells: Vec<String> = (1..=5).map(|k| format!("body.0{k}.cells=120")).collect();
    let cells: Vec<&str> = cells.iter().map(String::as_str).collect();
    let mut simulation = build("lattice/elephants_05", &cells);
    for k in 1..=8 {
        run(&mut simulation, 0.1 * f64::from(k));
        assert_closed(&simulation.frame(k), "elephants");
    }
    let p = &simulation.world.particles;
    let lowest = p.position.iter().map(|x| x.y).fold(f64::INFINITY, f64::min);
    assert!(lowest > -0.1, "through the ground: {lowest}"); // measured
}
