//! Fragments keep their ids: of one that splits the heaviest part keeps it, no id is used twice, and a restart changes none.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use fissure_engine::column::Visitor;
use fissure_io::checkpoint::{About, Columns, Store};
use fissure_io::frames::ParticleFrame;
use fissure_io::scene::Scene;
use fissure_io::simulation::Simulation;
use fissure_materials::registry;

/// Two boxes that break at the ground.
const SCENE: &str = "
duration = 1.0
[body.low]
shape = { kind = 'box', size = [0.1, 0.08, 0.1] }
RESOLUTION
rotate = { axis = [1, 0, 1], degrees = 20 }
translate = [0, 0.08, 0]
density = 1000
velocity = [0, -4, 0]
material = { LAW }
fracture = { critical_stretch = TEAR }
[body.high]
shape = { kind = 'box', size = [0.06, 0.06, 0.06] }
RESOLUTION
translate = [0, 0.2, 0]
density = 1200
velocity = [0, -6, 0]
material = { LAW }
fracture = { critical_stretch = TEAR }
[ground]
";

fn tets() -> Scene {
    parse("tets = 700", "law = 'isotropic', bulk_modulus = 5e5, shear_modulus = 3e5", "0.02", "auto")
}

fn cells() -> Scene {
    parse("cells = 150", "law = 'lattice', stiffness = 0.3", "0.1", "0.001")
}

fn parse(resolution: &str, law: &str, tear: &str, dt: &str) -> Scene {
    let text = SCENE.replace("RESOLUTION", resolution).replace("LAW", law).replace("TEAR", tear);
    let dt = if dt == "auto" { "\"auto\"" } else { dt };
    Scene::parse(&format!("dt = {dt}{text}"), Path::new("pieces.toml"), &[]).unwrap()
}

/// Steps with a frame after every `each`, `frames` times from frame `first` on.
fn play(simulation: &mut Simulation, first: u32, frames: u32, each: u64) -> Vec<ParticleFrame> {
    let frame = |number| {
        for _ in 0..each {
            simulation.step().unwrap();
        }
        let surface = simulation.frame(number);
        let particles = simulation.particle_frame(number);
        let of = |pieces: &[u32]| pieces.iter().copied().collect::<BTreeSet<u32>>();
        let (shown, held) = (of(&surface.piece), of(&particles.piece));
        // a node of a lattice may carry cells that hang together across an edge only, which the surface tells apart
        let bonded = simulation.meshes.iter().all(|m| m.tets().is_some());
        assert!(
            if bonded { shown == held } else { shown.is_superset(&held) },
            "{shown:?} on the surface, {held:?} inside"
        );
        assert_eq!(surface.pieces(), simulation.fragments().1);
        particles
    };
    (first..first + frames).map(frame).collect()
}

/// Mass [kg] and particles of each piece.
fn pieces(frame: &ParticleFrame) -> BTreeMap<u32, (f64, BTreeSet<(u32, u32)>)> {
    let mut all: BTreeMap<u32, (f64, BTreeSet<_>)> = BTreeMap::new();
    for (k, &piece) in frame.piece.iter().enumerate() {
        let (mass, particles) = all.entry(piece).or_default();
        *mass += f64::from(frame.mass[k]);
        particles.insert((frame.body[k], frame.id[k]));
    }
    all
}

/// Checks frame after frame; how many fragments there are at last.
fn follow(frames: &[ParticleFrame]) -> usize {
    for pair in frames.windows(2) {
        let (before, after) = (pieces(&pair[0]), pieces(&pair[1]));
        let born = before.keys().max().unwrap() + 1;
        for (id, (mass, particles)) in &after {
            // the piece that it came from is still there, and no lighter
            let from: Vec<u32> =
                before.iter().filter(|(_, b)| !b.1.is_disjoint(particles)).map(|(id, _)| *id).collect();
            if *id >= born {
                assert_eq!(from.len(), 1, "piece {id} comes from {from:?}");
                assert!(after[&from[0]].0 >= mass * (1.0 - 1e-6), "{id} of {mass} kg left {}", from[0]);
            } else {
                assert!(particles.is_subset(&before[id].1), "piece {id} has grown");
            }
        }
        assert!(before.keys().all(|id| after.contains_key(id)), "an id has gone");
        assert!(after.keys().enumerate().all(|(k, id)| *id == k as u32), "an id was left out");
    }
    pieces(frames.last().unwrap()).len()
}

#[test]
fn the_heaviest_part_keeps_the_id() {
    let mut simulation = Simulation::build(&tets(), &registry(), &mut |_| ()).unwrap();
    let mut frames = vec![simulation.particle_frame(0)];
    assert_eq!(pieces(&frames[0]).keys().copied().collect::<Vec<_>>(), [0, 1], "a whole body has its own number");
    frames.extend(play(&mut simulation, 1, 12, 15));
    assert!(follow(&frames) > 20); // measured: see the last frame
    let mass: f64 = frames.iter().map(|f| f.mass.iter().map(|m| f64::from(*m)).sum::<f64>()).sum();
    let want = frames.len() as f64 * simulation.world.particles.mass.iter().sum::<f64>();
    assert!((mass / want - 1.0).abs() < 1e-6, "{mass} kg of {want}"); // measured: f32
}

/// Nodes of a lattice split and merge, so only ids are followed.
#[test]
fn lattices_name_their_fragments_too() {
    let mut simulation = Simulation::build(&cells(), &registry(), &mut |_| ()).unwrap();
    let frames = play(&mut simulation, 0, 8, 12);
    for pair in frames.windows(2) {
        let (before, after) = (pieces(&pair[0]), pieces(&pair[1]));
        let gone: Vec<&u32> = before.keys().filter(|id| !after.contains_key(id)).collect();
        assert!(gone.is_empty(), "{gone:?}");
    }
    assert!(pieces(&frames[7]).len() > 2, "nothing tore");
}

/// Shows the columns that checkpoints had before fragments had ids.
struct Older<'s>(&'s mut Simulation);

impl Columns for Older<'_> {
    fn visit(&mut self, v: &mut Visitor<'_>) {
        self.0.visit(&mut |scope, column, buffer| {
            if !scope.ends_with("fragments") {
                v(scope, column, buffer);
            }
        });
    }
}

fn restarted(scene: &Scene, from: &mut dyn Columns) -> Simulation {
    let dir = tempfile::tempdir().unwrap();
    let mut store = Store::create(dir.path()).unwrap();
    store.write_frozen(from, &About::default()).unwrap();
    store.write_live(from, &About::default()).unwrap();
    Simulation::restore(scene, &registry(), &store.latest_complete().unwrap()).unwrap()
}

#[test]
fn a_restart_changes_no_id() {
    for scene in [tets(), cells()] {
        let mut whole = Simulation::build(&scene, &registry(), &mut |_| ()).unwrap();
        let want = play(&mut whole, 0, 10, 12);
        let mut half = Simulation::build(&scene, &registry(), &mut |_| ()).unwrap();
        play(&mut half, 0, 6, 12);
        let mut resumed = restarted(&scene, &mut half);
        assert!(play(&mut resumed, 6, 4, 12) == want[6..], "ids differ after a restart");
        // older files have no ids: fragments are named as a fresh run names them, and lasting from then on
        let mut older = restarted(&scene, &mut Older(&mut half));
        let frames = play(&mut older, 6, 4, 12);
        let sizes = |f: &ParticleFrame| {
            let mut sizes: Vec<usize> = pieces(f).values().map(|p| p.1.len()).collect();
            sizes.sort_unstable();
            sizes
        };
        assert_eq!(sizes(&frames[3]), sizes(&want[9]));
    }
}
