//! Runs for other programs: one file per format, fed frame by frame, during a run or from its folder afterwards.
//!
//! | format | folder | for |
//! |---|---|---|
//! | `usd` | `stage.usda`, `clips/frame_0000.usda` … | Blender, Houdini, Omniverse: value clips, with velocities for motion blur |
//! | `vtu` | `surface.pvd`, `particles.pvd`, `tets.pvd` and a folder each | ParaView, pyvista, meshio |
//! | `ply` | `frame_0000.ply` … | what reads colours: outside and inside are coloured |
//! | `obj` | `frame_0000.obj` … and `fissure.mtl` | a group per fragment, two materials |
//! | `pov` | `frame_0000.pov` …, `look.inc` | POV-Ray |
//! | `glb` | one file | game engines: a node per fragment with its rigid motion ([`glb`]) |
//!
//! A stream that is opened at a frame keeps the frames before it and forgets the later ones, so a resumed run ends with the
//! files of one that was never stopped.

pub mod glb;
mod obj;
mod ply;
mod pov;
#[cfg(test)]
mod tests;
mod usd;
mod vtu;

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::atomic::write_atomically_with;
use crate::frames::{Frame, FrameError, ParticleFrame, TetFrame};
use crate::picture::View;

/// What a run can be exported to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A USD stage with value clips.
    Usd,
    /// VTK's unstructured grids with a PVD for the times.
    Vtu,
    /// PLY with colours.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// Binary glTF, the whole run in one file.
    Glb,
    /// POV-Ray scenes.
    Pov,
}

impl Format {
    /// All formats with their names, which are those of their folders too.
    pub const ALL: [(Self, &'static str); 6] = [
        (Self::Usd, "usd"),
        (Self::Vtu, "vtu"),
        (Self::Ply, "ply"),
        (Self::Obj, "obj"),
        (Self::Glb, "glb"),
        (Self::Pov, "pov"),
    ];

    /// The format called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, n)| *n == name).map(|(format, _)| *format)
    }

    /// The name.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(format, _)| *format == self).expect("ALL is complete").1
    }
}

/// What a run says of itself.
#[derive(Clone, Debug, Default)]
pub struct About {
    /// Title of the scene.
    pub title: String,
    /// Simulated time from frame to frame [s].
    pub interval: f64,
    /// Names of the bodies.
    pub bodies: Vec<String>,
    /// Camera, ground and colours of its picture.
    pub view: View,
}

impl About {
    /// Frames per second, whole where it is nearly.
    pub fn rate(&self) -> f64 {
        let rate = 1.0 / self.interval;
        if (rate - rate.round()).abs() < 1e-6 * rate { rate.round() } else { rate }
    }
}

/// One frame of a run, with what there is of it.
#[derive(Clone, Copy, Debug)]
pub struct Shot<'a> {
    /// The surface of all bodies.
    pub surface: &'a Frame,
    /// The rigid things.
    pub colliders: Option<&'a Frame>,
    /// The particles.
    pub particles: Option<&'a ParticleFrame>,
    /// The tetrahedra.
    pub tets: Option<&'a TetFrame>,
}

/// Takes a run frame by frame.
pub trait Stream {
    /// Writes the files of one frame.
    ///
    /// # Errors
    /// What the system says.
    fn frame(&mut self, shot: &Shot<'_>) -> Result<(), ExportError>;

    /// Writes what lists the frames until now, so that they can be opened.
    ///
    /// # Errors
    /// What the system says.
    fn index(&mut self) -> Result<(), ExportError> {
        Ok(())
    }
}

/// Begins, or goes on with, an export into the folder `dir`. Frames before `from` stay. `None` for [`Format::Glb`], which
/// has no stream: see [`glb::write`].
///
/// # Errors
/// A folder that cannot be made or read.
pub fn open(format: Format, dir: &Path, about: &About, from: u32) -> Result<Option<Box<dyn Stream>>, ExportError> {
    if format == Format::Glb {
        return Ok(None);
    }
    make(dir)?;
    let (dir, about) = (dir.to_owned(), about.clone());
    Ok(Some(match format {
        Format::Usd => Box::new(usd::Usd::open(dir, about, from)?),
        Format::Vtu => Box::new(vtu::Vtu::open(dir, from)?),
        Format::Ply => Box::new(ply::Ply { dir, about }),
        Format::Obj => Box::new(obj::Obj { dir, about }),
        Format::Pov => Box::new(pov::Pov { dir, about }),
        Format::Glb => return Ok(None),
    }))
}

/// Why an export failed.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The file system said no.
    #[error("cannot {action} {}: {source}; check that the folder exists, is writable and has room", path.display())]
    Io {
        /// What was tried: "write", "read" or "create".
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A frame that is damaged or does not fit together.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Something that the format needs is not there.
    #[error("{0}")]
    Missing(String),
}

impl ExportError {
    fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io { action, path: path.into(), source }
    }
}

fn make(dir: &Path) -> Result<(), ExportError> {
    fs::create_dir_all(dir).map_err(ExportError::io("create", dir))
}

fn write(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), ExportError> {
    write_atomically_with(path, content).map_err(ExportError::io("write", path))
}

/// `frame_0012.obj`: four digits, more from frame 10 000 on.
fn name(number: u32, extension: &str) -> String {
    format!("frame_{number:04}.{extension}")
}

/// Numbers below `from` of the frames in `dir`, ascending.
fn kept(dir: &Path, extension: &str, from: u32) -> Result<Vec<u32>, ExportError> {
    let mut numbers = Vec::new();
    for entry in fs::read_dir(dir).map_err(ExportError::io("read", dir))? {
        let found = entry.map_err(ExportError::io("read", dir))?.file_name();
        let digits = found.to_str().and_then(|n| n.strip_prefix("frame_")?.strip_suffix(extension)?.strip_suffix('.'));
        let number = digits.and_then(|d| d.parse().ok()).filter(|&n| n < from && *found == *name(n, extension));
        numbers.extend(number);
    }
    numbers.sort_unstable();
    Ok(numbers)
}

/// Whether triangle `t` is on a crack face: all its vertices are.
fn inside(frame: &Frame, t: &[u32; 3]) -> bool {
    t.iter().all(|&v| frame.inside[v as usize] != 0)
}

/// Outside and inside colour as a colour picker shows them, and that of rigid things.
fn colours(about: &About) -> [[f32; 3]; 3] {
    [about.view.palette.outside, about.view.palette.crack, [0.42, 0.45, 0.5]]
}
