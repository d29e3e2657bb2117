//! A run folder as the page sees it.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;

use fissure_io::picture::ColourMode;
use fissure_io::scene::Scene;
use serde_json::{Value, json};

use super::pack::{Pack, Precision};
use crate::render::view;
use crate::{Error, RunFolder};

/// A run that is shown.
pub(super) struct Shown {
    folder: RunFolder,
    scene: Scene,
    name: String,
    /// Times of the frames met so far [s]: a resumed run writes the same frames again.
    times: Mutex<BTreeMap<u32, f64>>,
}

/// All that the page asks again and again while a run goes on.
pub(super) fn listing(runs: &[Shown]) -> Result<String, Error> {
    let runs = runs.iter().map(Shown::listing).collect::<Result<Vec<_>, _>>()?;
    Ok(json!({ "version": env!("CARGO_PKG_VERSION"), "runs": runs }).to_string())
}

impl Shown {
    /// The run in the folder `dir`.
    pub fn open(dir: &Path) -> Result<Self, Error> {
        let folder = RunFolder::open(dir)?;
        let scene = Scene::load(&folder.scene(), &[])?;
        let whole = dir.canonicalize().unwrap_or_else(|_| dir.into());
        let name = whole.file_name().map_or_else(|| "run".into(), |n| n.to_string_lossy().into_owned());
        Ok(Self { folder, scene, name, times: Mutex::default() })
    }

    /// The numbers of the frames that are there.
    pub fn numbers(&self) -> Result<Vec<u32>, Error> {
        Ok(self.folder.frames().numbers()?)
    }

    /// The numbers of the frames that have particles.
    pub fn particle_numbers(&self) -> Result<Vec<u32>, Error> {
        Ok(self.folder.particles().numbers()?)
    }

    /// `listing` with frames `numbers` only.
    pub fn only(&self, mut listing: Value, numbers: &[u32]) -> Value {
        let kept = |key: &str| -> Vec<Value> {
            let all = |key: &str| listing[key].as_array().into_iter().flatten();
            let shown = all("frames").map(|n| n.as_u64().is_some_and(|n| numbers.contains(&(n as u32))));
            all(key).zip(shown).filter(|(_, shown)| *shown).map(|(value, _)| value.clone()).collect()
        };
        let (times, frames) = (kept("times"), kept("frames"));
        listing["times"] = times.into();
        listing["frames"] = frames.into();
        listing
    }

    /// What the page is told before any frame: title, colours, ground, which frames there are and when they are.
    pub fn listing(&self) -> Result<Value, Error> {
        let frames = self.folder.frames();
        let numbers = frames.numbers()?;
        let mut times = self.times.lock().unwrap_or_else(|broken| broken.into_inner());
        for &number in &numbers {
            if let std::collections::btree_map::Entry::Vacant(unknown) = times.entry(number) {
                unknown.insert(frames.time(number)?);
            }
        }
        let look = view(&self.scene);
        let colouring = match look.mode {
            ColourMode::Material => "material",
            ColourMode::Damage => "damage",
            ColourMode::Stretch => "stretch",
            ColourMode::Speed => "speed",
            ColourMode::Piece => "piece",
        };
        Ok(json!({
            "name": self.name,
            "title": self.scene.title,
            "duration": self.scene.duration,
            "every": self.scene.output.frame_every,
            "ground": look.ground,
            "camera": look.camera.map(|c| json!({ "eye": c.eye, "target": c.target, "opening": c.opening })),
            "colouring": colouring,
            "outside": look.palette.outside,
            "crack": look.palette.crack,
            "times": numbers.iter().map(|n| times[n]).collect::<Vec<_>>(),
            "frames": numbers,
            "particles": self.folder.particles().numbers()?,
        }))
    }

    /// The series of the run, as text; empty while there is none.
    pub fn series(&self) -> Result<String, Error> {
        let path = self.folder.series();
        match std::fs::read_to_string(&path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                Err(Error::Usage(format!("{} cannot be read ({e})", path.display())))
            }
            read => Ok(read.unwrap_or_default()),
        }
    }

    /// The surfaces of frame `number`, and what its colliders look like.
    pub fn frame(&self, number: u32, precision: Precision) -> Result<Pack, Error> {
        let frame = self.folder.frames().read(number)?;
        let mut pack = Pack::new(number, frame.time, precision);
        pack.surface(&frame)?;
        let colliders = self.folder.colliders();
        if colliders.path(number).is_file() {
            pack.colliders(&colliders.read(number)?)?;
        }
        Ok(pack)
    }

    /// The particles of frame `number`.
    pub fn particles(&self, number: u32, precision: Precision) -> Result<Pack, Error> {
        let points = self.folder.particles().read_particles(number)?;
        let mut pack = Pack::new(number, points.time, precision);
        pack.particles(&points)?;
        Ok(pack)
    }
}
