//! Which region each particle of a body is in, and the material that the regions make.

use std::path::Path;

use fissure_engine::{Material, Registry, Surroundings};
use fissure_meshing::distance::Distance;
use glam::DVec3;
use rayon::prelude::*;

use super::Fault;
use crate::mesh::{Mesh, read};
use crate::scene::{Body, Scene, SceneError, Where};

/// The region of every particle, 0 for the rest of the body; none at all for a body without regions. `labels` has the
/// label of each particle's tetrahedron, or is empty.
pub(super) fn assign(body: &Body, points: &[DVec3], labels: &[i64]) -> Result<Vec<u8>, Fault> {
    if body.parts.is_empty() {
        return Ok(Vec::new());
    }
    let mut regions = vec![0u8; points.len()];
    for (k, part) in body.parts.iter().enumerate() {
        let fail = |message: String| Fault::of("region")(format!("region `{}`: {message}", part.name));
        let inside: Vec<bool> = match &part.place {
            Where::Space(space) => points.iter().map(|x| space.contains(*x)).collect(),
            Where::Label(_) if labels.is_empty() => {
                return Err(fail(
                    "the mesh has no labels (it is no file of tetrahedra, or has none); use `box`, `ball` or `nearest`"
                        .into(),
                ));
            }
            Where::Label(label) => labels.iter().map(|l| l == label).collect(),
            Where::Nearest { to, than, .. } => {
                let [to, than] = [surface(body, to).map_err(fail)?, surface(body, than).map_err(fail)?];
                let signed = |d: &Distance, x: DVec3| if d.inside(x) { -d.distance(x) } else { d.distance(x) };
                points.par_iter().map(|&x| signed(&to, x) < signed(&than, x)).collect()
            }
        };
        if !inside.contains(&true) {
            let mut known = labels.to_vec();
            known.sort_unstable();
            known.dedup();
            let cure = match &part.place {
                Where::Label(_) => format!("the labels of the mesh are {known:?}"),
                _ => "move or enlarge it".into(),
            };
            return Err(fail(format!("it holds no particle; {cure}")));
        }
        regions.iter_mut().zip(inside).filter(|(_, inside)| *inside).for_each(|(region, _)| *region = k as u8 + 1);
    }
    Ok(regions)
}

fn surface(body: &Body, path: &Path) -> Result<Distance, String> {
    match read(path).map_err(|e| e.to_string())? {
        Mesh::Surface(mut mesh) => {
            mesh.vertices.iter_mut().for_each(|v| *v = body.placement.place(*v));
            Ok(Distance::new(&mesh))
        }
        Mesh::Solid(_) => Err(format!("{} has tetrahedra; `nearest` and `than` want closed surfaces", path.display())),
    }
}

/// Density of a region [kg/m³].
pub(super) fn density(body: &Body, region: u8) -> f64 {
    if region == 0 { body.density } else { body.parts[usize::from(region) - 1].density }
}

/// The material of `body`, with the region of every particle (none where a checkpoint has them).
pub(super) fn material(
    scene: &Scene,
    body: &Body,
    registry: &Registry,
    regions: Vec<u8>,
    at: &Surroundings,
) -> Result<Box<dyn Material>, SceneError> {
    if body.parts.is_empty() {
        return registry
            .make((&body.law.name, body.law.values()), (&body.criterion.name, body.criterion.values()), at)
            .map_err(|e| scene.blame(&body.name, &e));
    }
    let own = std::iter::once((&body.law, &body.criterion));
    let parts: Vec<_> = own
        .chain(body.parts.iter().map(|p| (&p.law, &p.criterion)))
        .map(|(law, criterion)| ((law.name.as_str(), law.values()), (criterion.name.as_str(), criterion.values())))
        .collect();
    registry.several(&parts, &body.interface, regions, at).map_err(|(k, e)| match k {
        0 => scene.blame(&body.name, &e),
        _ => scene.blame_part(&body.name, k - 1, &e),
    })
}
