//! Files with right checksums that lie: a small run whose columns are changed at will, saved, restored and stepped.

use std::path::Path;

use fissure_engine::column::Life;
use fissure_engine::{Registry, buffer::AnyBuffer};
use fissure_io::checkpoint::{About, Columns, FROZEN, Latest, Opened, checkpoint_name, write};
use fissure_io::scene::Scene;
use fissure_io::simulation::{Simulation, SimulationError};
use tempfile::TempDir;

use crate::check_message;

const SCENE: &str = r#"
duration = 0.01
dt = 1e-4
[body.a]
mesh = "seeds/vtu/ours.vtu"
density = 1000
[body.a.material]
law = "plastic"
bulk_modulus = 1e6
shear_modulus = 5e5
yield_stretch = 0.01
[body.a.fracture]
criterion = "critical_stretch"
critical_stretch = 0.02
[[anchor]]
body = "a"
box = [[-1, 0.03, -1], [1, 1, 1]]
[[collider]]
shape = { kind = "ball", radius = 0.05 }
position = [0, -0.2, 0]
motion = "free"
density = 1000
[ground]
height = -0.3
"#;

/// A run after a few steps, in files.
pub struct Base {
    scene: Scene,
    registry: Registry,
    honest: TempDir,
    lies: TempDir,
}

impl Base {
    /// Builds and saves it.
    pub fn new() -> Self {
        let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("scene.toml");
        let scene = Scene::parse(SCENE, &place, &[]).expect("a scene");
        let registry = fissure_materials::registry();
        let mut simulation = Simulation::build(&scene, &registry, &mut |_| ()).expect("a world");
        for _ in 0..3 {
            simulation.step().expect("stable");
        }
        let folder = || TempDir::new().expect("a folder");
        let base = Self { scene, registry, honest: folder(), lies: folder() };
        base.save(&mut simulation, &base.honest);
        base
    }

    fn save(&self, simulation: &mut Simulation, to: &TempDir) {
        let at = |name: &str| to.path().join(name);
        let frozen = write(at(FROZEN), Life::Frozen, 0, &About::default(), simulation).expect("room");
        let live = at(&checkpoint_name(0));
        write(live, Life::Live, frozen.fingerprint, &About::default(), simulation).expect("room");
    }

    fn restore(&self, from: &TempDir) -> Result<Simulation, SimulationError> {
        let open = |file: &str| Opened::open(from.path().join(file)).expect("just written");
        let latest = Latest { live: open(&checkpoint_name(0)), frozen: open(FROZEN), skipped: Vec::new() };
        Simulation::restore(&self.scene, &self.registry, &latest)
    }

    /// Changes columns as `data` says, restores, and makes a step and a frame of what is accepted.
    pub fn lie(&self, data: &[u8]) {
        let mut simulation = self.restore(&self.honest).expect("an honest file");
        change(&mut simulation, data);
        self.save(&mut simulation, &self.lies);
        match self.restore(&self.lies) {
            Ok(mut restored) => {
                if restored.step().is_ok() {
                    restored.frame(0);
                }
            }
            Err(error) => check_message(&error),
        }
    }
}

impl Default for Base {
    fn default() -> Self {
        Self::new()
    }
}

/// Each change is a column, a kind, a place, and bytes: what is there is overwritten, cut off, or repeated.
fn change(simulation: &mut Simulation, mut data: &[u8]) {
    while let [column, kind, place @ ..] = data {
        let Some((&[low, high, count], rest)) = place.split_first_chunk::<3>() else { return };
        let (bytes, rest) = rest.split_at(usize::from(count % 32).min(rest.len()));
        data = rest;
        let (mut number, wanted) = (0, usize::from(*column));
        let mut columns = 0;
        simulation.visit(&mut |_, _, _| columns += 1);
        simulation.visit(&mut |_, _, buffer: &mut dyn AnyBuffer| {
            if number == wanted % columns {
                let mut all = buffer.bytes().to_vec();
                let at = usize::from(u16::from_le_bytes([low, high]));
                match kind % 4 {
                    0 if !all.is_empty() => bytes.iter().enumerate().for_each(|(k, b)| {
                        let n = all.len();
                        all[(at + k) % n] = *b;
                    }),
                    1 => all.truncate(at),
                    2 => all.extend_from_within(..at.min(all.len())),
                    _ => all.extend_from_slice(bytes),
                }
                buffer.set_bytes(&all);
            }
            number += 1;
        });
    }
}
