//! Tests of comparisons: known motions against known references.

use std::fs;
use std::path::Path;

use fissure_materials::registry;
use glam::DMat3;

use super::*;

const BAR: &str = "
duration = 1.0
gravity = [0, 0, 0]
dt = 0.1
[body.bar]
shape = { kind = 'beam', length = 0.4, width = 0.1 }
size = 0.05
translate = [0, 2, 0]
density = 1000
[body.bar.material]
law = 'isotropic'
bulk_modulus = 1e6
shear_modulus = 4e5
";

/// A bar about (0, 2, 0) with references whose files lie in `folder`.
fn bar(folder: &Path, compares: &str) -> Result<(Comparison, Simulation), String> {
    let scene = Scene::parse(&format!("{BAR}{compares}"), &folder.join("bar.toml"), &[]).map_err(|e| e.to_string())?;
    let mut simulation = Simulation::build(&scene, &registry(), &mut |_| ()).map_err(|e| e.to_string())?;
    let comparison = Comparison::new(&scene, folder, &mut simulation).map_err(|e| e.to_string())?;
    Ok((comparison, simulation))
}

/// Moves every particle from X to X + (F − 1)(X − centre) + `shift`.
fn deform(simulation: &mut Simulation, f: DMat3, shift: DVec3) {
    let body = &simulation.world.bodies[0];
    for i in body.range.clone() {
        let rest = body.origin + simulation.world.particles.rest[i].as_dvec3();
        simulation.world.particles.position[i] = f * (rest - DVec3::Y * 2.0) + DVec3::Y * 2.0 + shift;
    }
}

const FIELD: &str = "X, Y, Z, ux, uy, uz\n-0.19, 0, 0, -0.019, 0, 0\n0.19, 0.04, 0, 0.019, 0, 0\n0, 0, 0.05, 0, 0, 0\n";

#[test]
fn a_uniform_stretch_is_found_at_every_place() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("f.csv"), FIELD).unwrap();
    let compares = "[[compare]]\nlabel = 'bar'\nfield = 'f.csv'\ntranslate = [0, 2, 0]\nat = 0.5\n\
        [[compare]]\nlabel = 'end'\ndisplacement = 0.02\npoint = [0.2, 2, 0]\nalong = [2, 0, 0]\nat = 0.5\n";
    let (mut comparison, mut simulation) = bar(folder.path(), compares).unwrap();
    let f = DMat3::from_diagonal(DVec3::new(1.1, 1.0, 1.0));
    comparison.sample(&mut simulation);
    assert_eq!(comparison.table(), [], "nothing is due at the start");
    deform(&mut simulation, f, DVec3::ZERO);
    simulation.world.time = 0.5;
    comparison.sample(&mut simulation);
    deform(&mut simulation, f, DVec3::X);
    simulation.world.time = 1.0;
    comparison.sample(&mut simulation);
    let rows = comparison.table();
    let names: Vec<&str> = rows.iter().map(|r| r.what.as_str()).collect();
    assert_eq!(names, ["bar: position, largest", "bar: position, mean", "end [m]"]);
    // rest positions are f32
    assert!(rows.iter().all(|r| r.error.abs() < 1e-5), "{rows:?}");
    assert!(rows[2].ours.is_some_and(|u| (u - 0.02).abs() < 1e-7) && rows[2].reference == Some(0.02), "{rows:?}");
    let figure = comparison.figure().expect("a field");
    assert_eq!(figure.panels.len(), 1, "a number has no panel");
    assert_eq!(figure.panels[0].curves.last().unwrap().points.len(), 3);
}

#[test]
fn a_wrong_position_counts_over_the_diagonal() {
    let folder = tempfile::tempdir().unwrap();
    // the sideways component is left out and says nothing
    fs::write(folder.path().join("t.csv"), "t,ux,uz\n0,0,0\n0.5,0.1,0\n1,0,0.2\n").unwrap();
    let compares = "[[compare]]\nlabel = 'middle'\ntrack = 't.csv'\npoint = [0, 2, 0]\n";
    let (mut comparison, mut simulation) = bar(folder.path(), compares).unwrap();
    for (time, shift) in [(0.0, DVec3::ZERO), (0.5, DVec3::new(0.1, 5.0, 0.01)), (1.0, DVec3::new(0.0, -3.0, 0.25))] {
        simulation.world.time = time;
        deform(&mut simulation, DMat3::IDENTITY, shift);
        comparison.sample(&mut simulation);
    }
    let rows = comparison.table();
    let diagonal = (0.4f64 * 0.4 + 0.1 * 0.1 + 0.1 * 0.1).sqrt();
    let want = [0.05 / diagonal, 0.02 / diagonal, 0.25 / 0.2 - 1.0, 0.0];
    for (row, want) in rows.iter().zip(want) {
        assert!((row.error - want).abs() < 1e-5, "{row:?}, not {want}");
    }
    assert_eq!(rows[3].ours, Some(1.0), "{:?}", rows[3]);
    let names: Vec<String> = comparison.figure().unwrap().panels[0].curves.iter().map(|c| c.name.clone()).collect();
    assert_eq!(names, ["ux reference", "ux ours", "uz reference", "uz ours"]);
}

#[test]
fn what_was_taken_is_taken_up_again_and_is_a_reference() {
    let folder = tempfile::tempdir().unwrap();
    // times only: what a first run is given
    fs::write(folder.path().join("t.csv"), "t\n0\n0.5\n1\n").unwrap();
    let compares = "[[compare]]\nlabel = 'middle'\ntrack = 't.csv'\npoint = [0, 2, 0]\n";
    let (mut whole, mut simulation) = bar(folder.path(), compares).unwrap();
    let run = folder.path().join("run");
    fs::create_dir(&run).unwrap();
    for (time, shift) in [(0.0, 0.0), (0.5, 0.125), (1.0, 0.5)] {
        simulation.world.time = time;
        deform(&mut simulation, DMat3::IDENTITY, DVec3::Z * shift);
        whole.sample(&mut simulation);
        whole.sample_energies(&mut simulation);
    }
    whole.save(&run).unwrap();
    assert_eq!(whole.table().len(), 1, "the energy, but no errors without a reference");

    // From a checkpoint at 0.5 s the last row is dropped and taken anew. A checkpoint holds the rotations that the surface was
    // last fitted with, from which the next are sought: another way there would differ in the last digit.
    let (mut there, mut simulation) = bar(folder.path(), compares).unwrap();
    for (time, shift) in [(0.0, 0.0), (0.5, 0.125)] {
        simulation.world.time = time;
        deform(&mut simulation, DMat3::IDENTITY, DVec3::Z * shift);
        there.sample(&mut simulation);
    }
    let (mut again, _) = bar(folder.path(), compares).unwrap();
    again.restore(&run, &simulation);
    assert_eq!(again.items[0].ours.len(), 2);
    simulation.world.time = 1.0;
    deform(&mut simulation, DMat3::IDENTITY, DVec3::Z * 0.5);
    again.sample(&mut simulation);
    again.sample_energies(&mut simulation);
    let files = |c: &Comparison| {
        c.save(&run).unwrap();
        ["compare_1.csv", "energies.csv"].map(|name| fs::read_to_string(run.join(name)).unwrap())
    };
    assert_eq!(files(&again), files(&whole));

    // without the files, what was due counts as missed
    let (mut lost, _) = bar(folder.path(), compares).unwrap();
    lost.restore(&folder.path().join("nowhere"), &simulation);
    assert!(lost.items[0].ours.len() == 3 && lost.items[0].ours.iter().all(|u| u.is_nan()));

    fs::copy(run.join("compare_1.csv"), folder.path().join("t.csv")).unwrap();
    let (mut against, _) = bar(folder.path(), compares).unwrap();
    against.restore(&run, &simulation);
    let rows = against.table();
    assert!(rows[0].what == "middle: position, largest" && rows.iter().take(4).all(|r| r.error == 0.0), "{rows:?}");
}

#[test]
fn bad_references_are_refused_with_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    put("short.csv", "x,y\n1,2\n");
    put("empty.csv", "t,ux\n");
    put("word.csv", "t,ux\n0,0\n1,much\n");
    put("ragged.csv", "t,ux\n0,0\n1\n");
    put("back.csv", "t,ux\n0,0\n0.2,1\n0.1,1\n");
    put("far.csv", "x,y,z\n0,2,0\n3,2,0\n");
    let cases = [
        ("field = 'short.csv'", "short.csv has no column `z`, only x, y; rename one of them"),
        ("field = 'none.csv'", "none.csv cannot be read"),
        ("track = 'empty.csv'\npoint = [0, 2, 0]", "empty.csv has no rows below its headings"),
        ("track = 'word.csv'\npoint = [0, 2, 0]", "word.csv:3: \"much\" is no number"),
        ("track = 'ragged.csv'\npoint = [0, 2, 0]", "ragged.csv cannot be read"),
        ("track = 'back.csv'\npoint = [0, 2, 0]", "`t` must grow from row to row, but row 3 does not"),
        ("field = 'far.csv'", "the place [3, 2, 0] [m] lies outside body `bar`; move it or the body"),
        ("displacement = 1\npoint = [0, 0, 0]\nalong = [1, 0, 0]", "the place [0, 0, 0] [m] lies outside body `bar`"),
    ];
    for (compare, sentence) in cases {
        let refused = bar(folder.path(), &format!("[[compare]]\n{compare}\n")).map(|_| ()).unwrap_err();
        assert!(refused.contains(sentence) && refused.contains("bar.toml:14: "), "{refused}");
        assert_eq!(refused.lines().count(), 1, "{refused}");
    }
}
