//! Run 2N equals run N, restart, run N: every column and the frame, bit for bit, for every law, with contact and a free
//! rigid body, while bonds break, on other threads after the restart.

use std::path::Path;

use fissure_engine::column::Visitor;
use fissure_io::checkpoint::{About, Columns, Store};
use fissure_io::frames::to_bytes;
use fissure_io::scene::Scene;
use fissure_io::simulation::Simulation;
use fissure_materials::registry;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// Two soft boxes over the ground, one above the other, and a ball that is shot at them.
const SCENE: &str = "
duration = 1.0
gravity = [0, -9.81, 0]
integrator = 'INTEGRATOR'
[body.low]
shape = { kind = 'box', size = [0.1, 0.08, 0.1] }
tets = 400
translate = [0, 0.042, 0]
density = 1000
velocity = [0, -2, 0]
material = { LAW }
fracture = { FRACTURE }
[body.high]
shape = { kind = 'box', size = [0.06, 0.06, 0.06] }
tets = 200
translate = [0, 0.118, 0]
rotate = { axis = [1, 2, 3], degrees = 20 }
density = 1200
velocity = [0, -4, 0]
spin = [3, 0, 5]
material = { LAW }
fracture = { FRACTURE }
[ground]
[[collider]]
name = 'ball'
shape = { kind = 'ball', radius = 0.02 }
motion = 'free'
density = 4000
position = [0.08, 0.06, 0]
velocity = [-8, 0, 0]
";

/// Every law with parameters at which something happens within fifty steps.
const LAWS: [(&str, &str); 8] = [
    ("isotropic", "bulk_modulus = 5e5, shear_modulus = 3e5"),
    ("plastic", "bulk_modulus = 5e5, shear_modulus = 3e5, yield_stretch = 0.005"),
    ("anisotropic", "bulk_modulus = 5e5, shear_modulus = 3e5, matrix = [[1, 0, 0], [0, 2, 0], [0, 0, 1]]"),
    (
        "anisotropic_plastic",
        "bulk_modulus = 5e5, shear_modulus = 3e5, yield_stretch = 0.005, matrix = [[1, 0, 0], [0, 2, 0], [0, 0, 1]], field = 'cylindrical'",
    ),
    ("viscoelastic", "bulk_modulus = 5e5, shear_modulus = 3e5, relaxing_share = 0.5, relaxation_time = 0.01"),
    ("lps", "bulk_modulus = 5e5, shear_modulus = 3e5"),
    ("mitchell", "bulk_modulus = 5e5, shear_modulus = 3e5, yield_stress = 2e3"),
    ("pmb", "bulk_modulus = 5e5"),
];

const FRACTURES: [&str; 2] = [
    "criterion = 'critical_stretch', critical_stretch = 0.02, alpha = 0.5",
    "criterion = 'energy_release', energy_release_rate = 5.0",
];

fn scene(law: usize, fracture: usize, integrator: &str) -> Scene {
    let (name, parameters) = LAWS[law];
    let text = SCENE
        .replace("LAW", &format!("law = '{name}', {parameters}"))
        .replace("FRACTURE", FRACTURES[fracture])
        .replace("INTEGRATOR", integrator);
    Scene::parse(&text, Path::new("restart.toml"), &[]).unwrap()
}

fn run(simulation: &mut Simulation, steps: u64, threads: usize) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        for _ in 0..steps {
            simulation.step().unwrap();
        }
    });
}

/// All columns by name, and the frame.
fn bytes(simulation: &mut Simulation) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    let mut see = |scope: &str, column: &fissure_engine::Column, buffer: &mut dyn fissure_engine::buffer::AnyBuffer| {
        all.push((format!("{scope}/{}", column.name), buffer.bytes().to_vec()));
    };
    let visitor: &mut Visitor<'_> = &mut see;
    simulation.visit(visitor);
    all.push(("frame".into(), to_bytes(&simulation.frame(7)).unwrap()));
    all.push(("particles".into(), simulation.particle_frame(7).to_bytes().unwrap()));
    all
}

#[derive(Clone, Debug)]
struct Drawn {
    law: usize,
    fracture: usize,
    verlet: bool,
    before: u64,
    after: u64,
    threads: [usize; 3],
}

fn drawn() -> impl Strategy<Value = Drawn> {
    (0..LAWS.len(), 0..FRACTURES.len(), any::<bool>(), 1..60u64, 1..40u64, [1..3usize, 1..3usize, 1..3usize]).prop_map(
        |(law, fracture, verlet, before, after, threads)| Drawn { law, fracture, verlet, before, after, threads },
    )
}

/// Says how many bonds broke.
fn same_bits(d: &Drawn) -> Result<u64, TestCaseError> {
    let scene = scene(d.law, d.fracture, if d.verlet { "velocity_verlet" } else { "symplectic_euler" });
    Ok(goes_on_alike(&scene, d)?.world.bond_counts().1)
}

/// Gives the simulation that was not interrupted.
fn goes_on_alike(scene: &Scene, d: &Drawn) -> Result<Simulation, TestCaseError> {
    let mut whole = Simulation::build(scene, &registry(), &mut |_| ()).unwrap();
    run(&mut whole, d.before + d.after, d.threads[0]);

    let mut half = Simulation::build(scene, &registry(), &mut |_| ()).unwrap();
    run(&mut half, d.before, d.threads[1]);
    let dir = tempfile::tempdir().unwrap();
    let mut store = Store::create(dir.path()).unwrap();
    let about = About { step: half.world.step, time: half.world.time, ..About::default() };
    store.write_frozen(&mut half, &about).unwrap();
    store.write_live(&mut half, &about).unwrap();
    drop(half);
    let mut resumed = Simulation::restore(scene, &registry(), &store.latest_complete().unwrap()).unwrap();
    run(&mut resumed, d.after, d.threads[2]);

    let (want, got) = (bytes(&mut whole), bytes(&mut resumed));
    prop_assert_eq!(want.len(), got.len());
    for (want, got) in want.iter().zip(&got) {
        prop_assert!(want == got, "{} differs", want.0);
    }
    Ok(whole)
}

#[test]
fn every_registered_law_is_tried() {
    let names: Vec<&str> = LAWS.iter().map(|(name, _)| *name).collect();
    let registry = registry();
    let known: Vec<&str> = registry.bond_laws().map(|e| e.name).collect();
    assert!(known.iter().all(|name| names.contains(name)), "{known:?}: give a new law its parameters in LAWS");
}

/// Each law once, through the middle of its breaking.
#[test]
fn each_law_restarts_while_it_breaks() {
    let mut broke = 0;
    for law in 0..LAWS.len() {
        let d = Drawn { law, fracture: law % 2, verlet: false, before: 45, after: 30, threads: [1, 2, 1] };
        let broken = same_bits(&d).unwrap_or_else(|e| panic!("{d:?}: {e}"));
        println!("{}: {broken} broken", LAWS[law].0);
        broke += u32::from(broken > 0);
    }
    assert!(broke >= 6, "{broke} of 8 laws broke"); // measured: all
}

/// Lattices by each method, while they tear at the ground and at each other.
#[test]
fn lattices_restart_while_they_tear() {
    let mut torn = 0;
    let others = ["steinemann", "lsm", "single", "clustered"].map(|method| format!("method = '{method}'"));
    let flowing = "method = 'ohta', yield_strain = 0.05, passes = 2, volume_preserving = 'yes'";
    for (k, told) in
        std::iter::once("method = 'ohta'").chain([flowing]).chain(others.iter().map(String::as_str)).enumerate()
    {
        let text = SCENE
            .replace("duration = 1.0", "duration = 1.0\ndt = 0.002")
            .replace("tets = 400", "cells = 200")
            .replace("tets = 200", "cells = 100\ncrack_faces = { kind = 'fitted' }")
            .replace("LAW", &format!("law = 'lattice', stiffness = 0.3, {told}"))
            .replace("FRACTURE", "critical_stretch = 0.2")
            .replace("INTEGRATOR", "symplectic_euler");
        let scene = Scene::parse(&text, Path::new("lattice.toml"), &[]).unwrap();
        let d = Drawn { law: 0, fracture: 0, verlet: false, before: 25, after: 20, threads: [1, 2, 1 + k % 2] };
        let mut whole = goes_on_alike(&scene, &d).unwrap_or_else(|e| panic!("{told}: {e}"));
        let open = whole.frame(0).inside.iter().filter(|&&i| i == 1).count();
        println!("{told}: {open} vertices on crack faces, {} fragments", whole.fragments().1);
        torn += usize::from(open > 0);
    }
    assert!(torn >= 4, "{torn} of 6 tore"); // measured: all
}

/// Scenes, numbers of steps and of threads as they are drawn; always the same ones.
#[test]
fn any_scene_restarts_anywhere() {
    let config = Config { cases: 12, failure_persistence: None, max_shrink_iters: 4, ..Config::default() };
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[3; 32]);
    let mut runner = TestRunner::new_with_rng(config, rng);
    runner.run(&drawn(), |d| same_bits(&d).map(|_| ())).unwrap();
}
