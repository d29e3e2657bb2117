//! `fissure info`: what is in a scene, mesh, checkpoint, frame or run folder.

use std::path::Path;
use std::process::ExitCode;

use fissure_engine::Registry;
use fissure_io::checkpoint::summary;
use fissure_io::mesh::{Mesh, read};
use fissure_io::scene::{Scene, Source};
use fissure_meshing::quality::Report;

use crate::mesh::print_quality;
use crate::{Error, RunFolder};

pub(crate) fn command(path: &Path, registry: &Registry) -> Result<ExitCode, Error> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if path.is_dir() {
        run_folder(path)?;
    } else if extension == "toml" {
        scene(path, registry)?;
    } else if extension == "fis" {
        let file = summary(path)?;
        print!("{file}");
        if !file.intact() {
            return Err(Error::Usage(format!("{} is damaged: see the columns marked above", path.display())));
        }
    } else {
        mesh(path)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn scene(path: &Path, registry: &Registry) -> Result<(), Error> {
    let scene = Scene::load(path, &[])?;
    scene.check(registry)?;
    println!("{}", scene.title);
    println!("{} s, a frame each {:.4e} s", scene.duration, scene.output.frame_every);
    for body in &scene.bodies {
        let from = match &body.source {
            Source::Mesh { written, .. } => written.clone(),
            Source::Shape(shape) => format!("{shape:?}"),
        };
        println!("body {}: {from}, {} with {}", body.name, body.law.name, body.criterion.name);
    }
    Ok(())
}

fn run_folder(path: &Path) -> Result<(), Error> {
    let folder = RunFolder::open(path)?;
    let scene = Scene::load(&folder.scene(), &[])?;
    println!("{}", scene.title);
    let frames = folder.frames().numbers()?;
    println!("{} frames", frames.len());
    for (step, file) in folder.store(0)?.checkpoints()? {
        println!("checkpoint of step {step}: {}", file.display());
    }
    Ok(())
}

fn mesh(path: &Path) -> Result<(), Error> {
    match read(path)? {
        Mesh::Surface(surface) => {
            println!(
                "{} vertices, {} triangles, area {:.6e} m², volume {:.6e} m³",
                surface.vertices.len(),
                surface.triangles.len(),
                surface.area(),
                surface.volume()
            );
            if let Some((low, high)) = surface.bounds() {
                println!("from {low} to {high} m");
            }
            let findings = fissure_meshing::surface::check(&surface);
            if findings.is_clean() {
                println!("closed, wound outwards, without self-intersection");
            } else {
                match fissure_meshing::surface::prepare(surface, Default::default()) {
                    Ok((_, repairs)) => repairs.iter().for_each(|r| println!("to be repaired: {r}")),
                    Err(error) => println!("as a solid: {error}"),
                }
            }
        }
        Mesh::Solid(tets) => {
            print_quality(&Report::of(&tets.mesh));
            if let Some((low, high)) = tets.mesh.bounds() {
                println!("from {low} to {high} m");
            }
        }
    }
    Ok(())
}
