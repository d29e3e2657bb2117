//! `fissure info`: what is in a scene, mesh, checkpoint, frame or run folder.

use std::path::Path;
use std::process::ExitCode;

use fissure_engine::Registry;
use fissure_engine::registry::Wants;
use fissure_io::checkpoint::{Opened, Store};
use fissure_io::frames::{self, FrameFolder};
use fissure_io::mesh::{Mesh, READABLE, read};
use fissure_io::scene::{ColliderMotion, Fineness, Scene, Source};
use fissure_meshing::quality::Report;
use glam::DVec3;
use serde_json::{Value, json};

use crate::args::InfoArgs;
use crate::mesh::quality;
use crate::say::{counted, say};
use crate::{Error, RunFolder};

mod checkpoint;

/// What is said of a file: in words, and as JSON.
struct Told {
    words: Vec<String>,
    value: Value,
}

pub(crate) fn command(args: &InfoArgs, registry: &Registry) -> Result<ExitCode, Error> {
    let path = args.file.as_path();
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let checkpoint = !path.is_dir() && extension == "fis";
    if args.scene {
        return if checkpoint { checkpoint::scene(path) } else { Err(no_scene(path)) };
    }
    let mut damaged = None;
    let told = if path.is_dir() {
        folder(path)?
    } else if extension == "toml" {
        scene(path, registry)?
    } else if checkpoint {
        let (told, intact) = checkpoint::told(path)?;
        damaged = (!intact).then(|| format!("{} is damaged: see the columns marked above", path.display()));
        told
    } else if extension == "ply" && is_frame(path) {
        frame(path)?
    } else if READABLE.contains(&extension.as_str()) {
        mesh(path)?
    } else {
        return Err(unknown(path));
    };
    if args.json {
        say!("{}", told.value);
    } else {
        told.words.iter().for_each(|line| say!("{line}"));
    }
    damaged.map_or(Ok(ExitCode::SUCCESS), |sentence| Err(Error::Usage(sentence)))
}

fn no_scene(path: &Path) -> Error {
    Error::Usage(format!("--scene prints the scene that a checkpoint keeps; {} is none (.fis)", path.display()))
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

fn scene(path: &Path, registry: &Registry) -> Result<Told, Error> {
    let scene = Scene::load(path, &[])?;
    scene.check(registry)?;
    let mut words = vec![called(&scene).to_owned()];
    words.push(format!("{} s, a frame each {:.4e} s", scene.duration, scene.output.frame_every));
    let (mut bodies, mut colliders) = (Vec::new(), Vec::new());
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
        words.push(format!("body {}: {from}{cells}, {} with {}", body.name, body.law.name, body.criterion.name));
        let part = |name: &str, law: &str, criterion: &str| json!({ "name": name, "law": law, "fracture": criterion });
        for p in &body.parts {
            words.push(format!("  region {}: {} with {}", p.name, p.law.name, p.criterion.name));
        }
        let mut value = part(&body.name, &body.law.name, &body.criterion.name);
        value["source"] = json!(from);
        value["regions"] = body.parts.iter().map(|p| part(&p.name, &p.law.name, &p.criterion.name)).collect();
        bodies.push(value);
    }
    for c in &scene.colliders {
        let motion = match &c.motion {
            ColliderMotion::Fixed => "fixed",
            ColliderMotion::Keyframes(_) => "moved along keyframes",
            ColliderMotion::Free { .. } => "free",
        };
        words.push(format!("collider {}: {:?}, {motion}", c.name, c.shape));
        colliders.push(json!({ "name": c.name, "shape": format!("{:?}", c.shape), "motion": motion }));
    }
    let value = json!({
        "kind": "scene", "title": called(&scene), "duration": scene.duration, "frame_every": scene.output.frame_every,
        "bodies": bodies, "colliders": colliders,
    });
    Ok(Told { words, value })
}

/// The title of a scene, or its file if it has none.
pub(crate) fn called(scene: &Scene) -> &str {
    if scene.title.is_empty() { scene.file() } else { &scene.title }
}

/// A run folder, or the folder of its frames.
fn folder(path: &Path) -> Result<Told, Error> {
    let numbers = FrameFolder::new(path).numbers()?;
    if let Some(&last) = numbers.last() {
        let last = FrameFolder::new(path).path(last).display().to_string();
        let words = vec![format!("{}, the last is {last}", counted(numbers.len(), "frame"))];
        return Ok(Told { words, value: json!({ "kind": "frames", "frames": numbers.len(), "last": last }) });
    }
    let folder = RunFolder::open(path)?;
    let scene = Scene::load(&folder.scene(), &[])?;
    let frames = folder.frames().numbers()?.len();
    let mut words = vec![called(&scene).to_owned(), counted(frames, "frame")];
    let mut checkpoints = Vec::new();
    for (step, file) in Store::listing(path)? {
        // one that does not open is told by `fissure verify`
        let time = Opened::open(&file).ok().map(|opened| opened.about().time);
        let at = time.map_or("which does not open".into(), |t| format!("{t:.6} s of {} s", scene.duration));
        words.push(format!("checkpoint of step {step}, {at}: {}", file.display()));
        checkpoints.push(json!({ "step": step, "time": time, "file": file.display().to_string() }));
    }
    let value = json!({
        "kind": "run", "title": called(&scene), "duration": scene.duration, "frames": frames, "checkpoints": checkpoints,
    });
    Ok(Told { words, value })
}

/// Whether a PLY file begins as our frames do.
fn is_frame(path: &Path) -> bool {
    use std::io::Read;
    let mut start = Vec::new();
    let read = std::fs::File::open(path).and_then(|file| file.take(200).read_to_end(&mut start));
    read.is_ok() && String::from_utf8_lossy(&start).contains("\ncomment fissure frame ")
}

fn frame(path: &Path) -> Result<Told, Error> {
    let frame = frames::read(path)?;
    let (vertices, triangles, pieces) = (frame.positions.len(), frame.triangles.len(), frame.pieces());
    let inside = frame.inside.iter().filter(|&&i| i != 0).count();
    let damage = frame.damage.iter().copied().fold(0.0, f32::max);
    let speed = |v: &[f32; 3]| v.iter().map(|c| c * c).sum::<f32>().sqrt();
    let speed = frame.velocity.iter().map(speed).fold(0.0, f32::max);
    let points = || frame.positions.iter().map(|&p| glam::Vec3::from(p).as_dvec3());
    let box_ = points().next().map(|first| points().fold((first, first), |(low, high), p| (low.min(p), high.max(p))));
    let mut words = vec![
        format!("frame {}, t = {:.6} s", frame.number, frame.time),
        format!(
            "{vertices} vertices, {triangles} triangles, {}, {inside} vertices on crack faces",
            counted(pieces, "piece")
        ),
        format!("damage up to {damage:.3}"),
        format!("speed up to {speed:.3} m/s"),
    ];
    words.extend(box_.map(bounds));
    let value = json!({
        "kind": "frame", "frame": frame.number, "time": frame.time, "vertices": vertices, "triangles": triangles,
        "pieces": pieces, "on_crack_faces": inside, "damage": damage, "speed": speed, "bounds": box_.map(corners),
    });
    Ok(Told { words, value })
}

fn corners((low, high): (DVec3, DVec3)) -> [[f64; 3]; 2] {
    [low.to_array(), high.to_array()]
}

fn bounds((low, high): (DVec3, DVec3)) -> String {
    // as many decimals as make four digits of the size
    let decimals = (3.0 - (high - low).max_element().log10().floor()).clamp(0.0, 12.0);
    let round = |x: f64| (x * 10_f64.powf(decimals)).round() / 10_f64.powf(decimals) + 0.0; // + 0: no minus zero
    let place = |p: DVec3| format!("({}, {}, {})", round(p.x), round(p.y), round(p.z));
    format!("from {} to {} m", place(low), place(high))
}

fn mesh(path: &Path) -> Result<Told, Error> {
    let (mut words, state, mut value, box_) = match read(path)? {
        Mesh::Surface(surface) => {
            let (vertices, triangles) = (surface.vertices.len(), surface.triangles.len());
            let (area, volume, box_) = (surface.area(), surface.volume(), surface.bounds());
            let words =
                vec![format!("{vertices} vertices, {triangles} triangles, area {area:.6e} m², volume {volume:.6e} m³")];
            let clean = fissure_meshing::surface::check(&surface).is_clean();
            let findings: Vec<String> = match clean {
                true => Vec::new(),
                false => match fissure_meshing::surface::prepare(surface, Default::default()) {
                    Ok((_, repairs)) => repairs.iter().map(|r| format!("to be repaired: {r}")).collect(),
                    Err(error) => vec![format!("as a solid: {error}")],
                },
            };
            let value = json!({
                "kind": "surface", "vertices": vertices, "triangles": triangles, "area": area, "volume": volume,
                "findings": findings,
            });
            let fine = "closed, wound outwards, without self-intersection";
            let state = if clean { vec![fine.to_owned()] } else { findings };
            (words, state, value, box_)
        }
        Mesh::Solid(tets) => {
            let report = Report::of(&tets.mesh);
            let value = json!({
                "kind": "tetrahedra", "tets": report.tets, "vertices": report.vertices, "volume": report.volume,
                "dihedral_angles": [report.min_dihedral, report.max_dihedral],
            });
            (quality(&report), Vec::new(), value, tets.mesh.bounds())
        }
    };
    words.extend(box_.map(bounds));
    value["bounds"] = json!(box_.map(corners));
    words.extend(state);
    Ok(Told { words, value })
}
