//! Differences on the body, as a frame that a picture can be made of.

use fissure_engine::column::Of;
use glam::{DVec3, Vec3};

use super::columns::walk;
use super::order::Matching;
use super::{DiffError, FileDiff, Side, Verdict};
use crate::frames::Frame;

/// Corners and faces of an octahedron.
const CORNERS: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
const FACES: [[u32; 3]; 8] = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];

/// The particles of the first file as small solids, whose damage is how far a column differs there over the largest such
/// difference: of the first column in `diff` that differs and belongs to particles or their bonds. Also says which column
/// that is, and its largest difference. None where no such column differs.
///
/// # Errors
/// A file without positions, or a damaged one.
pub fn frame(a: &Side, b: &Side, diff: &FileDiff) -> Result<Option<(Frame, String, f64)>, DiffError> {
    let of_particles = |s: &&crate::checkpoint::Section| matches!(s.of, Of::Particle | Of::Bond | Of::Chunk);
    let numbers = |label: &str| {
        diff.columns.iter().find_map(|c| match &c.verdict {
            Verdict::Numbers(n) if c.label == label => Some(n.largest),
            _ => None,
        })
    };
    let sections = a.file.sections().iter().filter(of_particles);
    let Some((section, largest)) = sections.filter_map(|s| Some((s, numbers(&s.label())?))).next() else {
        return Ok(None);
    };
    let missing = || DiffError::NoParticles(a.file.path().to_owned());
    let position = a.column::<DVec3>("particles", "position").ok_or_else(missing)?;
    let volume = a.column::<f64>("particles", "volume").ok_or_else(missing)?;
    let other = &b.file.sections()[b.file.find(&section.scope, &section.name)?];
    let mut share = vec![0.0f32; position.len()];
    walk([a, b], [section, other], Matching::new(a, b).as_ref(), &mut |element, d| {
        let seen = a.particle_of(section, element).and_then(|p| share.get_mut(p));
        let part = if d == largest { 1.0 } else { (d / largest) as f32 };
        seen.into_iter().for_each(|s| *s = s.max(part));
    })?;
    let mut frame = Frame { time: a.file.about().time, ..Frame::default() };
    for ((x, v), share) in position.iter().zip(volume).zip(share) {
        let base = frame.positions.len() as u32;
        let size = 0.62 * v.cbrt() as f32; // so that they touch
        for corner in CORNERS {
            frame.positions.push((x.as_vec3() + corner * size).into());
            frame.normals.push(corner.into());
            frame.damage.push(share);
            frame.stretch.push(0.0);
        }
        frame.triangles.extend(FACES.map(|face| face.map(|v| base + v)));
    }
    let n = frame.positions.len();
    frame.velocity = vec![[0.0; 3]; n];
    (frame.inside, frame.piece) = (vec![0; n], vec![0; n]);
    frame.id = (0..n as u32).collect();
    Ok(Some((frame, section.label(), largest)))
}
