//! Exports that are written while a run goes on.

use fissure_io::export::{self, About, ExportError, Format, Shot, Stream};
use fissure_io::scene::Scene;

use crate::export::{convert, home};
use crate::{Error, RunFolder};

/// What `output.export` asks for.
#[derive(Default)]
pub(super) struct Streams {
    open: Vec<Box<dyn Stream>>,
    /// Whether tetrahedra are wanted.
    pub tets: bool,
}

impl Streams {
    /// Begins, or goes on with, the exports; frames before `from` stay.
    pub fn open(formats: &[Format], folder: &RunFolder, about: &About, from: u32) -> Result<Self, ExportError> {
        let mut streams = Self { open: Vec::new(), tets: formats.contains(&Format::Vtu) };
        for &format in formats {
            streams.open.extend(export::open(format, &home(folder, format), about, from)?);
        }
        Ok(streams)
    }

    /// Writes a frame, and what lists it.
    pub fn frame(&mut self, shot: &Shot<'_>) -> Result<(), ExportError> {
        self.open.iter_mut().try_for_each(|stream| stream.frame(shot).and_then(|()| stream.index()))
    }
}

/// Writes what can only be written of a whole run.
pub(super) fn whole(scene: &Scene, folder: &RunFolder) -> Result<(), Error> {
    if scene.output.export.contains(&Format::Glb) {
        convert(folder, scene, Format::Glb, None)?;
    }
    Ok(())
}
