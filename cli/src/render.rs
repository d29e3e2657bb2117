//! `fissure render`: a frame of a run as PNG.

use std::process::ExitCode;

use fissure_io::frames::Frame;
use fissure_io::picture::{Camera, ColourMode, View, render};
use fissure_io::scene::{Colouring, Scene};

use crate::args::RenderArgs;
use crate::say::say;
use crate::{Error, RunFolder};

pub(crate) fn command(options: &RenderArgs) -> Result<ExitCode, Error> {
    let folder = RunFolder::open(&options.dir)?;
    let scene = Scene::load(&folder.scene(), &[])?;
    let number = match options.frame {
        Some(number) => number,
        None => folder.frames().numbers()?.last().copied().ok_or_else(|| {
            Error::Usage(format!("{} has no frames yet; let the run reach its first frame", options.dir.display()))
        })?,
    };
    let frame = whole_frame(&folder, number)?;
    let mut view = view(&scene);
    match options.color.as_deref() {
        Some("material") => view.mode = ColourMode::Material,
        Some("damage") => view.mode = ColourMode::Damage,
        Some("speed") => view.mode = ColourMode::Speed,
        Some("piece") => view.mode = ColourMode::Piece,
        _ => {}
    }
    let path = options.out.clone().unwrap_or_else(|| options.dir.join(format!("frame_{number:04}.png")));
    picture(&frame, &view, &path)?;
    say!("{}", path.display());
    Ok(ExitCode::SUCCESS)
}

/// How the scene wants to be seen.
pub(crate) fn view(scene: &Scene) -> View {
    let p = &scene.output.picture;
    let mut view = View { width: p.width, height: p.height, ..View::default() };
    view.ground = scene.ground.map(|g| g.height);
    view.mode = match p.colouring {
        Colouring::Material => ColourMode::Material,
        Colouring::Damage => ColourMode::Damage,
        Colouring::Speed => ColourMode::Speed,
        Colouring::Piece => ColourMode::Piece,
    };
    if let Some(outside) = p.outside {
        view.palette.outside = outside.map(|c| c as f32);
    }
    if let Some(inside) = p.inside {
        view.palette.crack = inside.map(|c| c as f32);
    }
    if let Some(eye) = p.camera {
        let target = p.target.unwrap_or_default();
        view.camera = Some(Camera { eye: eye.into(), target: target.into(), opening: 28.0 });
    }
    view
}

/// Frame `number` with the colliders as further pieces, never cracked nor damaged.
pub(crate) fn whole_frame(folder: &RunFolder, number: u32) -> Result<Frame, Error> {
    let mut frame = folder.frames().read(number)?;
    if folder.colliders().path(number).is_file() {
        let more = folder.colliders().read(number)?;
        let (vertices, pieces) = (frame.positions.len() as u32, frame.piece.iter().max().map_or(0, |p| p + 1));
        frame.triangles.extend(more.triangles.iter().map(|t| t.map(|v| vertices + v)));
        frame.piece.extend(more.piece.iter().map(|p| pieces + p));
        frame.positions.extend(more.positions);
        frame.normals.extend(more.normals);
        frame.velocity.extend(more.velocity);
        frame.damage.extend(more.damage);
        frame.id.extend(more.id);
        frame.inside.extend(more.inside);
    }
    Ok(frame)
}

/// Draws `frame` into the file `path`.
pub(crate) fn picture(frame: &Frame, view: &View, path: &std::path::Path) -> Result<(), Error> {
    render(&[frame], view)?.write_png(path)?;
    Ok(())
}
