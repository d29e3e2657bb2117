//! The run folder and what is where in it.
//!
//! ```text
//! scene.toml               the scene with all overrides in it
//! run.log                  what was said
//! frozen.fis               what never changes: rest positions, bonds, meshes
//! checkpoint_00001234.fis  the state at a step; the newest few are kept
//! frames/frame_0000.ply    the surfaces
//! colliders/frame_0000.ply those of the colliders, if the scene has any but planes
//! particles/frame_0000.ply the particles, unless `output.particles` is off
//! usd, vtu, ply, obj, pov  exports, each in a folder of its own, and run.glb
//! series.csv               what was measured at each frame
//! last.png                 the last frame
//! preview/frame_0000.png   small pictures, with `--preview`
//! compare.png              ours against references, if the scene has `[[compare]]` with curves or fields
//! compare_1.csv            ours, in the form of the reference; energies.csv too, where their sum is compared
//! reference_1.csv          the reference
//! ```

use std::fs;
use std::path::{Path, PathBuf};

use fissure_io::atomic::write_atomically;
use fissure_io::checkpoint::{FROZEN, Store};
use fissure_io::frames::FrameFolder;
use fissure_io::scene::Scene;

use crate::Error;

/// A folder that holds one run.
pub struct RunFolder {
    dir: PathBuf,
    /// Folders that were made for it, innermost first.
    made: Vec<PathBuf>,
}

impl RunFolder {
    /// Makes the folder for a new run, and tries whether it can be written, before anything slow is done.
    ///
    /// # Errors
    /// A folder that holds a run already, or cannot be written.
    pub fn create(dir: &Path) -> Result<Self, Error> {
        if occupied(dir) {
            return Err(Error::Occupied(dir.into()));
        }
        let missing = dir.ancestors().take_while(|d| !d.as_os_str().is_empty() && !d.exists());
        let folder = Self { dir: dir.into(), made: missing.map(Path::to_path_buf).collect() };
        let probe = dir.join(".probe.tmp");
        let tried =
            fs::create_dir_all(dir).and_then(|()| fs::write(&probe, b"")).and_then(|()| fs::remove_file(&probe));
        match tried {
            Ok(()) => Ok(folder),
            Err(error) => {
                folder.give_up();
                Err(Error::write(dir)(error))
            }
        }
    }

    /// The folder of a run that was begun.
    ///
    /// # Errors
    /// No run there.
    pub fn open(dir: &Path) -> Result<Self, Error> {
        if !dir.join("scene.toml").is_file() {
            return Err(Error::NoRun(dir.into()));
        }
        Ok(Self { dir: dir.into(), made: Vec::new() })
    }

    /// Where a scene runs if it is not said: `runs/NAME`, or `runs/NAME-2` and so on if that holds a run.
    pub fn default_for(scene: &Path) -> PathBuf {
        let name = scene.file_stem().map_or_else(|| "run".into(), |s| s.to_string_lossy().into_owned());
        let numbered = (2..).map(|k| Path::new("runs").join(format!("{name}-{k}")));
        let mut candidates = std::iter::once(Path::new("runs").join(&name)).chain(numbered);
        candidates.find(|dir| !occupied(dir)).expect("some number is free")
    }

    /// Removes the folders that were made for a run that did not come about, unless something is in them.
    pub(crate) fn give_up(self) {
        for dir in &self.made {
            // a folder with something in it is not removed, and that is meant
            let _ = fs::remove_dir(dir);
        }
    }

    /// The folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// The scene as it runs.
    pub fn scene(&self) -> PathBuf {
        self.dir.join("scene.toml")
    }

    /// The log.
    pub fn log(&self) -> PathBuf {
        self.dir.join("run.log")
    }

    /// The picture of the last frame.
    pub fn picture(&self) -> PathBuf {
        self.dir.join("last.png")
    }

    /// The small picture of frame `number`.
    pub fn preview(&self, number: u32) -> PathBuf {
        self.dir.join("preview").join(format!("frame_{number:04}.png"))
    }

    /// The plot of ours against references.
    pub fn comparison(&self) -> PathBuf {
        self.dir.join("compare.png")
    }

    /// What was measured at each frame.
    pub fn series(&self) -> PathBuf {
        self.dir.join("series.csv")
    }

    /// The frames.
    pub fn frames(&self) -> FrameFolder {
        FrameFolder::new(self.dir.join("frames"))
    }

    /// The particles of the frames.
    pub fn particles(&self) -> FrameFolder {
        FrameFolder::new(self.dir.join("particles"))
    }

    /// The frames of the colliders.
    pub fn colliders(&self) -> FrameFolder {
        FrameFolder::new(self.dir.join("colliders"))
    }

    /// The checkpoints.
    ///
    /// # Errors
    /// A folder that cannot be read or written.
    pub fn store(&self, keep: u32) -> Result<Store, Error> {
        Ok(Store::create(&self.dir)?.keep(keep as usize))
    }

    /// Writes the scene into the folder.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub(crate) fn keep_scene(&self, scene: &Scene) -> Result<(), Error> {
        write_atomically(&self.scene(), scene.text().as_bytes()).map_err(Error::write(self.scene()))
    }
}

fn occupied(dir: &Path) -> bool {
    ["scene.toml", FROZEN, "frames"].iter().any(|name| dir.join(name).exists())
}
