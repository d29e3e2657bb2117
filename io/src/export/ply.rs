//! PLY with the properties of frames and `red`, `green`, `blue`: outside and inside have the colours of the picture, because
//! colours are all that VTK keeps of a PLY file.

use std::path::PathBuf;

use super::{About, ExportError, Shot, Stream, colours, name, write};
use crate::frames::ply as frames;

pub(super) struct Ply {
    pub dir: PathBuf,
    pub about: About,
}

impl Stream for Ply {
    fn frame(&mut self, shot: &Shot<'_>) -> Result<(), ExportError> {
        let frame = shot.surface;
        let [outside, inside, _] = colours(&self.about).map(|c| c.map(|x| (x * 255.0).round() as u8));
        let colour = |v: usize| if frame.inside[v] != 0 { inside } else { outside };
        let bytes = frames::coloured(frame, &colour)?;
        write(&self.dir.join(name(frame.number, "ply")), |out| out.write_all(&bytes))
    }
}
