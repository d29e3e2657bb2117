//! `fissure render`: frames of a run as pictures, or as a film.

use std::path::Path;
use std::process::ExitCode;

use fissure_io::atomic::write_atomically;
use fissure_io::frames::Frame;
use fissure_io::picture::{Camera, ColourMode, Film, FilmFormat, View, render};
use fissure_io::scene::{Colouring, Scene};

use crate::args::RenderArgs;
use crate::say::{counted, say};
use crate::{Error, RunFolder};

pub(crate) fn command(options: &RenderArgs) -> Result<ExitCode, Error> {
    let folder = RunFolder::open(&options.dir)?;
    let scene = Scene::load(&folder.scene(), &[])?;
    let numbers = folder.frames().numbers()?;
    let Some(&last) = numbers.last() else {
        let dir = options.dir.display();
        return Err(Error::Usage(format!("{dir} has no frames yet; let the run reach its first frame")));
    };
    let mut view = view(&scene);
    if let Some(colour) = &options.color {
        view.mode = mode(colour);
    }
    if let Some(size) = &options.size {
        let sides =
            size.split_once(['x', 'X', '×']).and_then(|(w, h)| Some((w.trim().parse().ok()?, h.trim().parse().ok()?)));
        (view.width, view.height) =
            sides.ok_or_else(|| Error::Usage(format!("--size {size} is no size; give one like 640x360")))?;
    }
    let film = match (&options.film, options.gif) {
        (None, true) => Some(options.dir.join("film.gif")),
        (film, _) => film.clone(),
    };
    if options.all || film.is_some() {
        hold(&mut view, &folder, &numbers)?;
        let chosen: Vec<u32> = numbers.into_iter().step_by(options.every as usize).collect();
        return match film {
            Some(path) => {
                make_film(&folder, &chosen, &view, &path, options.fps.unwrap_or(1.0 / scene.output.frame_every))
            }
            None => {
                let out = options.out.clone().unwrap_or_else(|| options.dir.join("pictures"));
                std::fs::create_dir_all(&out).map_err(Error::write(&out))?;
                for number in &chosen {
                    picture(&whole_frame(&folder, *number)?, &view, &out.join(format!("frame_{number:04}.png")))?;
                }
                say!("{}: {}", out.display(), counted(chosen.len(), "picture"));
                Ok(ExitCode::SUCCESS)
            }
        };
    }
    let number = options.frame.unwrap_or(last);
    let frame = whole_frame(&folder, number)?;
    let path = options.out.clone().unwrap_or_else(|| options.dir.join(format!("frame_{number:04}.png")));
    picture(&frame, &view, &path)?;
    say!("{}", path.display());
    Ok(ExitCode::SUCCESS)
}

/// Draws the frames `numbers` into the file `path`.
fn make_film(folder: &RunFolder, numbers: &[u32], view: &View, path: &Path, fps: f64) -> Result<ExitCode, Error> {
    let format = match path.extension().and_then(|e| e.to_str()) {
        Some("gif") => FilmFormat::Gif,
        Some("png" | "apng") => FilmFormat::Apng,
        _ => return Err(Error::Usage(format!("{} is no film; let it end in .gif or .png", path.display()))),
    };
    if !(fps > 0.0 && fps.is_finite()) {
        return Err(Error::Usage(format!("--fps {fps} must be above 0")));
    }
    let mut film = Film::new(format, (view.width, view.height), fps.min(FASTEST))?;
    for number in numbers {
        film.add(&render(&[&whole_frame(folder, *number)?], view)?)?;
    }
    write_atomically(path, &film.finish()?).map_err(Error::write(path))?;
    say!("{}: {}", path.display(), counted(numbers.len(), "picture"));
    Ok(ExitCode::SUCCESS)
}

/// Pictures per second that programs show in time.
const FASTEST: f64 = 50.0;

/// Keeps camera and scale of speeds through a film: such that the first, the middle and the last of the frames fit.
fn hold(view: &mut View, folder: &RunFolder, numbers: &[u32]) -> Result<(), Error> {
    let shown: Vec<Frame> = [0, numbers.len() / 2, numbers.len() - 1]
        .iter()
        .map(|&k| whole_frame(folder, numbers[k]))
        .collect::<Result<_, _>>()?;
    let frames: Vec<&Frame> = shown.iter().collect();
    if view.camera.is_none() {
        view.camera = Some(Camera::framing(&frames, view, f64::from(view.width) / f64::from(view.height)));
    }
    let speeds = frames.iter().flat_map(|f| &f.velocity).map(|v| v.iter().map(|c| c * c).sum::<f32>().sqrt());
    view.speed_range = Some(speeds.filter(|s| s.is_finite()).fold(0.0, f32::max)).filter(|s| *s > 0.0);
    Ok(())
}

/// Draws the small picture of frame `number`, from where the first frame is seen well.
pub(crate) fn preview(folder: &RunFolder, scene: &Scene, number: u32) -> Result<(), Error> {
    let mut view = view(scene);
    view.height = (PREVIEW * view.height).div_ceil(view.width).max(1);
    view.width = PREVIEW;
    hold(&mut view, folder, &[*folder.frames().numbers()?.first().unwrap_or(&number)])?;
    let path = folder.preview(number);
    if let Some(parent) = path.parent() {
        std::fs::create_dir_all(parent).map_err(Error::write(parent))?;
    }
    picture(&whole_frame(folder, number)?, &view, &path)
}

/// Width of small pictures (pixels).
const PREVIEW: u32 = 480;

fn mode(word: &str) -> ColourMode {
    match word {
        "damage" => ColourMode::Damage,
        "stretch" => ColourMode::Stretch,
        "speed" => ColourMode::Speed,
        "piece" => ColourMode::Piece,
        _ => ColourMode::Material,
    }
}

/// How the scene wants to be seen.
pub(crate) fn view(scene: &Scene) -> View {
    let p = &scene.output.picture;
    let mut view = View { width: p.width, height: p.height, ..View::default() };
    view.ground = scene.ground.map(|g| g.height);
    view.mode = match p.colouring {
        Colouring::Material => ColourMode::Material,
        Colouring::Damage => ColourMode::Damage,
        Colouring::Stretch => ColourMode::Stretch,
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
        frame.stretch.extend(more.stretch);
    }
    Ok(frame)
}

/// Draws `frame` into the file `path`.
pub(crate) fn picture(frame: &Frame, view: &View, path: &std::path::Path) -> Result<(), Error> {
    render(&[frame], view)?.write_png(path)?;
    Ok(())
}
