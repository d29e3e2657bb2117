//! Where a picture is taken from, and how to find a place from which all bodies are seen.

use glam::{DVec3, Vec3A};

use super::{PictureError, View, scene::Place};
use crate::frames::Frame;

/// Opening angle of the automatic camera (degrees): a long lens, which keeps upright things upright.
const OPENING: f64 = 28.0;
/// Part of the picture that stays free around the bodies, on every side.
const MARGIN: f64 = 0.14;
/// Pieces with a smaller part of the vertices than this may fly out of the picture: dust must not shrink the rest.
const SPLINTER: f64 = 0.005;
/// Part of the points an automatic camera may lose on each side, so that one splinter that flies off does not shrink
/// the rest to a dot.
const LOST: f64 = 0.002;

/// A pinhole camera; up is +y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where the camera is (m).
    pub eye: [f64; 3],
    /// What is in the middle of the picture (m).
    pub target: [f64; 3],
    /// Angle from the lower to the upper edge, above 0 and below 180 (degrees).
    pub opening: f64,
}

/// The camera in scene units, ready to make rays.
pub(super) struct Lens {
    pub eye: Vec3A,
    pub forward: Vec3A,
    pub right: Vec3A,
    pub up: Vec3A,
    tangents: [f32; 2],
}

impl Camera {
    /// A camera that sees all bodies of `frames` from the azimuth and elevation of `view`, in a picture `aspect` times
    /// as wide as high. Give it the first and the last frame of a run to hold one camera for a film.
    ///
    /// Each point bounds the eye by four planes, one for each edge of the picture; the tightest eye follows from the
    /// four largest bounds in closed form.
    pub fn framing(frames: &[&Frame], view: &View, aspect: f64) -> Self {
        let (azimuth, elevation) = (view.azimuth.to_radians(), view.elevation.clamp(-89.0, 89.0).to_radians());
        let back = DVec3::new(elevation.cos() * azimuth.sin(), elevation.sin(), elevation.cos() * azimuth.cos());
        let back = if back.is_finite() { back } else { DVec3::Z };
        let (right, up) = axes(-back);
        let points: Vec<DVec3> = frames.iter().flat_map(|f| substance(f)).collect();
        if points.is_empty() {
            let target = DVec3::new(0.0, view.ground.filter(|y| y.is_finite()).unwrap_or(0.0) + 0.5, 0.0);
            return Self { eye: (target + 5.0 * back).to_array(), target: target.to_array(), opening: OPENING };
        }
        let half = (OPENING.to_radians() / 2.0).tan() * (1.0 - 2.0 * MARGIN);
        let bound = |axis: DVec3, tangent: f64| {
            let mut values: Vec<f64> = points.iter().map(|&p| p.dot(axis) + tangent * p.dot(back)).collect();
            let rank = values.len() - 1 - (values.len() as f64 * LOST) as usize;
            *values.select_nth_unstable_by(rank, f64::total_cmp).1
        };
        let edges = |axis: DVec3, tangent: f64| (bound(axis, tangent), bound(-axis, tangent));
        let (wide, high) = (half * aspect.max(1e-3), half);
        let ((r0, r1), (u0, u1)) = (edges(right, wide), edges(up, high));
        let depth = ((r0 + r1) / (2.0 * wide)).max((u0 + u1) / (2.0 * high));
        // A single point or a flat thing seen edge-on needs no distance; give it some.
        let middle = points.iter().sum::<DVec3>() / points.len() as f64;
        let extent = points.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        let depth = depth.max(middle.dot(back) + extent.max(1e-6) * 2.0);
        let eye = right * ((r0 - r1) / 2.0) + up * ((u0 - u1) / 2.0) + back * depth;
        let target = eye - back * (depth - middle.dot(back));
        Self { eye: eye.to_array(), target: target.to_array(), opening: OPENING }
    }

    /// The camera itself if it can see.
    pub(super) fn checked(self) -> Result<Self, PictureError> {
        let (eye, target) = (DVec3::from(self.eye), DVec3::from(self.target));
        let apart = eye.is_finite() && target.is_finite() && eye != target;
        if apart && self.opening > 0.0 && self.opening < 180.0 { Ok(self) } else { Err(PictureError::Camera(self)) }
    }

    /// The camera in the units of `place`; `None` so far away that f32 cannot say where.
    pub(super) fn lens(&self, place: &Place, aspect: f64) -> Option<Lens> {
        let eye = place.inside(DVec3::from(self.eye));
        let forward = (DVec3::from(self.target) - DVec3::from(self.eye)).normalize();
        let (right, up) = axes(forward);
        let half = (self.opening.to_radians() / 2.0).tan();
        (eye.abs().max_element() < 1e15).then(|| Lens {
            eye,
            forward: forward.as_vec3a(),
            right: right.as_vec3a(),
            up: up.as_vec3a(),
            tangents: [(half * aspect) as f32, half as f32],
        })
    }
}

/// The points that a camera must see: those of pieces with at least [`SPLINTER`] of the frame's vertices, or all if
/// everything is splinters.
fn substance(frame: &Frame) -> Vec<DVec3> {
    let mut pieces = frame.piece.clone();
    pieces.sort_unstable();
    let least = (frame.positions.len() as f64 * SPLINTER) as usize;
    let large: Vec<u32> =
        pieces.chunk_by(|a, b| a == b).filter(|same| same.len() > least).map(|same| same[0]).collect();
    let kept = |v: &usize| frame.piece.get(*v).is_some_and(|p| large.binary_search(p).is_ok());
    let some: Vec<DVec3> =
        (0..frame.positions.len()).filter(kept).filter_map(|v| finite(&frame.positions[v])).collect();
    if some.is_empty() { frame.positions.iter().filter_map(finite).collect() } else { some }
}

impl Lens {
    /// Unit direction through the picture at `x` (0 left, 1 right) and `y` (0 top, 1 bottom).
    pub fn direction(&self, x: f32, y: f32) -> Vec3A {
        let [wide, high] = self.tangents;
        (self.forward + self.right * (wide * (2.0 * x - 1.0)) + self.up * (high * (1.0 - 2.0 * y))).normalize()
    }
}

/// Right and up for a unit direction.
fn axes(forward: DVec3) -> (DVec3, DVec3) {
    let right = forward.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
    (right, right.cross(forward))
}

/// A position as f64 if all of it is finite.
pub(super) fn finite(p: &[f32; 3]) -> Option<DVec3> {
    p.iter().all(|x| x.is_finite()).then(|| DVec3::from(p.map(f64::from)))
}
