//! `fissure export`: a run, or a checkpoint, for other programs.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use fissure_io::atomic::write_atomically_with;
use fissure_io::checkpoint::{self, ExportFormat, FROZEN, Opened};
use fissure_io::export::{self, About, Format, Shot, glb};
use fissure_io::fragments::Table;
use fissure_io::frames::{Frame, FrameError, FrameFolder};
use fissure_io::picture::Camera;
use fissure_io::scene::Scene;
use glam::DVec3;

use crate::args::ExportArgs;
use crate::render::view;
use crate::say::{counted, say};
use crate::view::html;
use crate::{Error, RunFolder};

pub(crate) fn command(options: &ExportArgs) -> Result<ExitCode, Error> {
    let ExportArgs { path, to, out, fragments, every, no_particles } = options;
    match (path.is_dir(), to.as_deref()) {
        (false, _) if *fragments => Err(Error::Usage(format!(
            "--fragments are those of a whole run; give its folder instead of {}",
            path.display()
        ))),
        (false, to) => columns(path, to.unwrap_or("csv"), out.clone()),
        (true, None) if !fragments => Err(Error::Usage(format!(
            "{} is a folder; say with --to what its run becomes, or --fragments, or give one of its checkpoints (.fis)",
            path.display()
        ))),
        (true, Some("html")) => page(path, *every, !no_particles, out.as_deref()),
        (true, to) => {
            let folder = RunFolder::open(path)?;
            if *fragments {
                table(&folder, out.as_deref())?;
            }
            to.map_or(Ok(()), |to| run(&folder, to, out.as_deref()))?;
            Ok(ExitCode::SUCCESS)
        }
    }
}

/// A checkpoint.
fn columns(path: &Path, to: &str, out: Option<PathBuf>) -> Result<ExitCode, Error> {
    let Some(&(format, _)) = ExportFormat::ALL.iter().find(|(_, name)| *name == to) else {
        let message = format!("{to} is made of a whole run; give its folder instead of {}", path.display());
        return Err(Error::Usage(message));
    };
    let beside = match format {
        ExportFormat::Npy => path.with_extension(""),
        ExportFormat::Csv | ExportFormat::Vtu => path.with_extension(to),
    };
    let out = out.unwrap_or(beside);
    let files = checkpoint::export(path, format, &out)?;
    match format {
        ExportFormat::Npy => say!("{}: {}", out.display(), counted(files.len(), "column")),
        ExportFormat::Csv | ExportFormat::Vtu => say!("{}", out.display()),
    }
    Ok(ExitCode::SUCCESS)
}

/// The page of `fissure view` as a file.
fn page(dir: &Path, every: u32, particles: bool, out: Option<&Path>) -> Result<ExitCode, Error> {
    let out = out.map_or_else(|| dir.join("run.html"), Path::to_path_buf);
    let (frames, bytes) = html::write(dir, every as usize, particles, &out)?;
    say!("{}: {}, {:.1} MB", out.display(), counted(frames, "frame"), bytes as f64 / 1e6);
    Ok(ExitCode::SUCCESS)
}

/// The frames of a run in another format.
fn run(folder: &RunFolder, to: &str, out: Option<&Path>) -> Result<(), Error> {
    let Some(format) = Format::named(to) else {
        let message = format!(
            "{to} is made of a checkpoint; give one of {}, or --fragments for a table of the run",
            folder.dir().display()
        );
        return Err(Error::Usage(message));
    };
    let scene = Scene::load(&folder.scene(), &[])?;
    let frames = convert(folder, &scene, format, out)?;
    let place = out.map_or_else(|| home(folder, format), Path::to_path_buf);
    say!("{}: {}", place.display(), counted(frames, "frame"));
    if format == Format::Vtu && !place.join("tets.pvd").exists() {
        say!("without tetrahedra, which only a run itself can write: output.export = [\"vtu\"] in its scene");
    }
    Ok(())
}

/// Where a run keeps what it exports.
pub(crate) fn home(folder: &RunFolder, format: Format) -> PathBuf {
    match format {
        Format::Glb => folder.dir().join("run.glb"),
        _ => folder.dir().join(format.name()),
    }
}

/// What the run of `scene` says of itself, with `interval` [s] from frame to frame.
pub(crate) fn about(scene: &Scene, interval: f64) -> About {
    let bodies = scene.bodies.iter().map(|body| body.name.clone()).collect();
    About { title: scene.title.clone(), interval, bodies, view: view(scene) }
}

/// Writes all frames of the run to `out`, or to where runs keep it. How many there were.
pub(crate) fn convert(folder: &RunFolder, scene: &Scene, format: Format, out: Option<&Path>) -> Result<usize, Error> {
    let numbers = numbers(folder)?;
    let (first, last) = (folder.frames().read(numbers[0])?, folder.frames().read(numbers[numbers.len() - 1])?);
    let interval = match last.number - first.number {
        0 => scene.output.frame_every,
        n => (last.time - first.time) / f64::from(n),
    };
    let mut about = about(scene, interval);
    let view = &mut about.view;
    if view.camera.is_none() {
        let aspect = f64::from(view.width) / f64::from(view.height);
        view.camera = Some(Camera::framing(&[&first, &last], view, aspect));
    }
    let out = out.map_or_else(|| home(folder, format), Path::to_path_buf);
    let Some(mut stream) = export::open(format, &out, &about, 0)? else {
        let particles = |number| Ok(folder.particles().read_particles(number)?);
        let colliders = |number| Ok(there(&folder.colliders(), number)?);
        needs_particles(folder, &numbers)?;
        let rest = rest(folder, &about)?;
        let frames =
            glb::Run { numbers: &numbers, last: &last, rest: &rest, particles: &particles, colliders: &colliders };
        glb::write(&out, &about, &frames)?;
        return Ok(numbers.len());
    };
    for &number in &numbers {
        let surface = folder.frames().read(number)?;
        let colliders = there(&folder.colliders(), number)?;
        let particles = match folder.particles().path(number).is_file() {
            true => Some(folder.particles().read_particles(number)?),
            false => None,
        };
        let (colliders, particles) = (colliders.as_ref(), particles.as_ref());
        stream.frame(&Shot { surface: &surface, colliders, particles, tets: None })?;
    }
    stream.index()?;
    Ok(numbers.len())
}

/// Where the vertices of each body are at rest [m]; none of lattices.
fn rest(folder: &RunFolder, about: &About) -> Result<Vec<Option<Vec<DVec3>>>, Error> {
    let frozen = Opened::open(folder.dir().join(FROZEN))?;
    frozen.verify()?;
    let of = |name: &String| frozen.column(&format!("bodies/{name}/mesh"), "rest_vertex").ok();
    Ok(about.bodies.iter().map(|name| of(name).map(<[DVec3]>::to_vec)).collect())
}

/// The fragments of a run as a table.
fn table(folder: &RunFolder, out: Option<&Path>) -> Result<(), Error> {
    let scene = Scene::load(&folder.scene(), &[])?;
    let bodies = about(&scene, scene.output.frame_every).bodies;
    let numbers = numbers(folder)?;
    needs_particles(folder, &numbers)?;
    let out = out.map_or_else(|| folder.dir().join("fragments.csv"), Path::to_path_buf);
    let (mut last, mut unread) = (0, Ok(()));
    let written = write_atomically_with(&out, |file| {
        let mut table = Table::begin(file)?;
        for &number in &numbers {
            match folder.particles().read_particles(number) {
                Ok(frame) => last = table.add(&frame, &bodies)?,
                Err(error) => {
                    unread = Err(error);
                    return Err(std::io::Error::other("unread"));
                }
            }
        }
        table.end()
    });
    unread?;
    written.map_err(Error::write(&out))?;
    say!("{}: {}, {} at last", out.display(), counted(numbers.len(), "frame"), counted(last, "fragment"));
    Ok(())
}

/// The frames that there are; at least one.
fn numbers(folder: &RunFolder) -> Result<Vec<u32>, Error> {
    let numbers = folder.frames().numbers()?;
    if numbers.is_empty() {
        let message = format!("{} has no frames yet; let the run reach its first frame", folder.dir().display());
        return Err(Error::Usage(message));
    }
    Ok(numbers)
}

fn needs_particles(folder: &RunFolder, numbers: &[u32]) -> Result<(), Error> {
    let particles = folder.particles();
    match numbers.iter().find(|&&number| !particles.path(number).is_file()) {
        None => Ok(()),
        Some(number) => Err(Error::Usage(format!(
            "fragments are found by their particles, and {} is not there; run the scene with output.particles = \"on\"",
            particles.path(*number).display()
        ))),
    }
}

fn there(folder: &FrameFolder, number: u32) -> Result<Option<Frame>, FrameError> {
    if folder.path(number).is_file() { folder.read(number).map(Some) } else { Ok(None) }
}
