//! Meshes that other people made, from the folder in `FISSURE_MESHES` (`surface/`, `tet/`); skipped without it.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::workshop::{Workshop, open_edges};

/// A fall at 6 m/s from just above the ground; two frames after the first. The meshes are about 1 m large.
fn scene(mesh: &Path, tets: usize, every: f64) -> String {
    let mesh = mesh.display();
    format!(
        "duration = {}\n[body.it]\nmesh = '{mesh}'\ntets = {tets}\ntranslate = [0, 0.05, 0]\ndensity = 1000\n\
         velocity = [0, -6, 0]\n[body.it.material]\nlaw = 'isotropic'\nbulk_modulus = 3e5\nshear_modulus = 2e5\n\
         [body.it.fracture]\ncritical_stretch = 0.03\n[ground]\n[output]\nframe_every = {every}\n[output.picture]\nwidth = 64\nheight = 48\n",
        2.0 * every
    )
}

fn folder(kind: &str) -> Option<PathBuf> {
    let Some(root) = std::env::var_os("FISSURE_MESHES") else {
        println!("skipped: FISSURE_MESHES names no folder of meshes");
        return None;
    };
    Some(Path::new(&root).join(kind))
}

/// The files of a folder that `wanted` likes, sorted.
fn files(folder: &Path, wanted: impl Fn(&str) -> bool) -> Vec<PathBuf> {
    let names = crate::workshop::names(folder);
    let found: Vec<PathBuf> = names.iter().filter(|n| wanted(n)).map(|n| folder.join(n)).collect();
    assert!(!found.is_empty(), "no meshes in {}", folder.display());
    found
}

/// Runs each with three frames, each `every` seconds: energies stay finite, the surface closed.
fn run_each(meshes: &[PathBuf], tets: usize, every: f64) {
    let shop = Workshop::new();
    for (k, mesh) in meshes.iter().enumerate() {
        let name = mesh.file_name().unwrap().to_string_lossy();
        shop.put("scene.toml", scene(mesh, tets, every));
        let run = format!("r{k}");
        let answer = shop.good(&["run", "scene.toml", "--out", &run, "--json"]);
        let events: Vec<Value> = answer.out.lines().map(|l| serde_json::from_str(l).expect(l)).collect();
        let frames: Vec<&Value> = events.iter().filter(|e| e["event"] == "frame").collect();
        assert_eq!(frames.len(), 3, "{name}: {answer}");
        for frame in &frames {
            for key in ["kinetic", "elastic", "gravity"] {
                assert!(frame[key].as_f64().is_some_and(f64::is_finite), "{name}: {key} of {frame}");
            }
        }
        // what a body may gain in so short a time is far less than it brings along
        let total = |f: &Value| ["kinetic", "elastic", "gravity"].iter().map(|k| f[*k].as_f64().unwrap()).sum::<f64>();
        assert!(total(frames[2]) <= 1.01 * total(frames[0]), "{name}: {} from {}", frames[2], frames[0]);
        for number in 0..3 {
            assert_eq!(open_edges(&shop.frame(&run, number)), 0, "{name}: frame {number} is closed");
        }
        println!("{name}: {}", frames[2]);
    }
}

const FORMATS: [&str; 5] = [".node", ".msh", ".vtu", ".vtk", ".ele"];

#[test]
fn surfaces() {
    let Some(folder) = folder("surface") else { return };
    run_each(&files(&folder, |n| n.ends_with(".ply")), 4000, 0.02);
}

#[test]
fn small_tetrahedra_in_every_format() {
    let Some(folder) = folder("tet") else { return };
    let small = ["sphere_5k", "spot_5k", "bar_9k", "bear_newton_4k", "bunny_12k_ftetwild"];
    let wanted = |n: &str| small.iter().any(|s| n.starts_with(s)) && FORMATS[..4].iter().any(|f| n.ends_with(f));
    run_each(&files(&folder, wanted), 1, 0.02);
}

/// The same tetrahedra from another format are the same run, as far as the format keeps the coordinates.
#[test]
fn the_format_does_not_matter() {
    let Some(folder) = folder("tet") else { return };
    let shop = Workshop::new();
    let mut seen = Vec::new();
    for (k, name) in
        ["sphere_5k.node", "sphere_5k.msh", "sphere_5k.v41.msh", "sphere_5k.vtu", "sphere_5k.vtk"].iter().enumerate()
    {
        shop.put("scene.toml", scene(&folder.join(name), 1, 0.02));
        shop.good(&["run", "scene.toml", "--out", &format!("r{k}"), "--quiet"]);
        let frame = shop.frame(&format!("r{k}"), 1);
        seen.push((frame.positions.len(), frame.triangles.len(), frame.piece.iter().max().copied()));
    }
    assert!(seen.iter().all(|s| *s == seen[0]), "{seen:?}");
}

#[test]
#[ignore = "minutes: the large meshes of other people"]
fn large_tetrahedra() {
    let Some(folder) = folder("tet") else { return };
    run_each(&files(&folder, |n| FORMATS[..4].iter().any(|f| n.ends_with(f)) && n.contains("0k")), 1, 0.01);
}

#[test]
#[ignore = "minutes: surfaces at the default resolution"]
fn surfaces_at_20000_tetrahedra() {
    let Some(folder) = folder("surface") else { return };
    run_each(&files(&folder, |n| n.ends_with(".ply")), 20_000, 0.04);
}
