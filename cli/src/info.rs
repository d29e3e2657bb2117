//! `fissure info`: what is in a scene, mesh, checkpoint, frame or run folder.

use std::path::Path;
use std::process::ExitCode;

use fissure_engine::Registry;
use fissure_engine::registry::Wants;
use fissure_io::checkpoint::summary;
use fissure_io::frames::{self, FrameFolder};
use fissure_io::mesh::{Mesh, READABLE, read};
use fissure_io::scene::{ColliderMotion, Fineness, Scene, Source};
use fissure_meshing::quality::Report;
use glam::DVec3;

use crate::mesh::print_quality;
use crate::say::{counted, say};
use crate::{Error, RunFolder};

pub(crate) fn command(path: &Path, registry: &Registry) -> Result<ExitCode, Error> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if path.is_dir() {
        folder(path)?;
    } else if extension == "toml" {
        scene(path, registry)?;
    } else if extension == "fis" {
        let file = summary(path)?;
        say!("{}", file.to_string().trim_end());
        if !file.intact() {
            return Err(Error::Usage(format!("{} is damaged: see the columns marked above", path.display())));
        }
    } else if extension == "ply" && is_frame(path) {
        frame(path)?;
    } else if READABLE.contains(&extension.as_str()) {
        mesh(path)?;
    } else {
        return Err(unknown(path));
    }
    Ok(ExitCode::SUCCESS)
}

fn unknown(path: &Path) -> Error {
    let path_and = |what: &str| Error::Usage(format!("{}: {what}", path.display()));
    match std::fs::metadata(path) {
        Err(e) => path_and(&format!("cannot be read ({e}); check the path")),
        Ok(_) => path_and(&format!(
            "the extension tells neither a scene (.toml), nor a checkpoint (.fis), nor a mesh or frame (.{})",
            READABLE.join(", .")
        )),
    }
}

fn scene(path: &Path, registry: &Registry) -> Result<(), Error> {
    let scene = Scene::load(path, &[])?;
    scene.check(registry)?;
    say!("{}", called(&scene));
    say!("{} s, a frame each {:.4e} s", scene.duration, scene.output.frame_every);
    for body in &scene.bodies {
        let from = match &body.source {
            Source::Mesh { written, .. } => written.clone(),
            Source::Shape(shape) => format!("{shape:?}"),
        };
        let wants = registry.entry(&body.law.name).map(|entry| entry.wants);
        let cells = match (wants, body.lattice.fineness) {
            (Ok(Wants::Cells), Fineness::Cells(cells)) => format!(", about {cells} cells"),
            (Ok(Wants::Cells), Fineness::Size(size)) => format!(", cells of {size} m"),
            _ => String::new(),
        };
        say!("body {}: {from}{cells}, {} with {}", body.name, body.law.name, body.criterion.name);
        for part in &body.parts {
            say!("  region {}: {} with {}", part.name, part.law.name, part.criterion.name);
        }
    }
    for c in &scene.colliders {
        let motion = match &c.motion {
            ColliderMotion::Fixed => "fixed",
            ColliderMotion::Keyframes(_) => "moved along keyframes",
            ColliderMotion::Free { .. } => "free",
        };
        say!("collider {}: {:?}, {motion}", c.name, c.shape);
    }
    Ok(())
}

/// The title of a scene, or its file if it has none.
pub(crate) fn called(scene: &Scene) -> &str {
    if scene.title.is_empty() { scene.file() } else { &scene.title }
}

/// A run folder, or the folder of its frames.
fn folder(path: &Path) -> Result<(), Error> {
    let frames = FrameFolder::new(path);
    if let Some(&last) = frames.numbers()?.last() {
        say!("{}, the last is {}", counted(frames.numbers()?.len(), "frame"), frames.path(last).display());
        return Ok(());
    }
    let folder = RunFolder::open(path)?;
    let scene = Scene::load(&folder.scene(), &[])?;
    say!("{}", called(&scene));
    say!("{}", counted(folder.frames().numbers()?.len(), "frame"));
    for (step, file) in folder.store(0)?.checkpoints()? {
        say!("checkpoint of step {step}: {}", file.display());
    }
    Ok(())
}

/// Whether a PLY file begins as our frames do.
fn is_frame(path: &Path) -> bool {
    use std::io::Read;
    let mut start = Vec::new();
    let read = std::fs::File::open(path).and_then(|file| file.take(200).read_to_end(&mut start));
    read.is_ok() && String::from_utf8_lossy(&start).contains("\ncomment fissure frame ")
}

fn frame(path: &Path) -> Result<(), Error> {
    let frame = frames::read(path)?;
    say!("frame {}, t = {:.6} s", frame.number, frame.time);
    say!(
        "{} vertices, {} triangles, {}, {} vertices on crack faces",
        frame.positions.len(),
        frame.triangles.len(),
        counted(frame.pieces(), "piece"),
        frame.inside.iter().filter(|&&i| i != 0).count()
    );
    say!("damage up to {:.3}", frame.damage.iter().copied().fold(0.0, f32::max));
    let speed = |v: &[f32; 3]| v.iter().map(|c| c * c).sum::<f32>().sqrt();
    say!("speed up to {:.3} m/s", frame.velocity.iter().map(speed).fold(0.0, f32::max));
    let points = || frame.positions.iter().map(|&p| glam::Vec3::from(p).as_dvec3());
    if let Some(first) = points().next() {
        bounds(points().fold((first, first), |(low, high), p| (low.min(p), high.max(p))));
    }
    Ok(())
}

fn bounds((low, high): (DVec3, DVec3)) {
    // as many decimals as make four digits of the size
    let decimals = (3.0 - (high - low).max_element().log10().floor()).clamp(0.0, 12.0);
    let round = |x: f64| (x * 10_f64.powf(decimals)).round() / 10_f64.powf(decimals) + 0.0; // + 0: no minus zero
    let place = |p: DVec3| format!("({}, {}, {})", round(p.x), round(p.y), round(p.z));
    say!("from {} to {} m", place(low), place(high));
}

fn mesh(path: &Path) -> Result<(), Error> {
    match read(path)? {
        Mesh::Surface(surface) => {
            say!(
                "{} vertices, {} triangles, area {:.6e} m², volume {:.6e} m³",
                surface.vertices.len(),
                surface.triangles.len(),
                surface.area(),
                surface.volume()
            );
            surface.bounds().into_iter().for_each(bounds);
            let findings = fissure_meshing::surface::check(&surface);
            if findings.is_clean() {
                say!("closed, wound outwards, without self-intersection");
            } else {
                match fissure_meshing::surface::prepare(surface, Default::default()) {
                    Ok((_, repairs)) => repairs.iter().for_each(|r| say!("to be repaired: {r}")),
                    Err(error) => say!("as a solid: {error}"),
                }
            }
        }
        Mesh::Solid(tets) => {
            print_quality(&Report::of(&tets.mesh));
            tets.mesh.bounds().into_iter().for_each(bounds);
        }
    }
    Ok(())
}
