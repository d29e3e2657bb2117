//! What can be hit: the triangles of the frames in a bounding volume hierarchy, and the ground.
//!
//! Positions are taken relative to the middle of the bodies and divided by their size, in f64, before they become f32
//! again: bodies far from the origin keep their shape, and all distances of the light are of order one.

use std::time::Duration;

use glam::{DVec3, Vec3A};
use obvhs::{
    BvhBuildParams,
    cwbvh::{CwBvh, builder::build_cwbvh_from_tris},
    ray::{Ray, RayHit},
    triangle::Triangle,
};

use super::{Camera, ColourMode, View, camera::finite, colour};
use crate::frames::Frame;

/// How world positions become scene positions.
pub(super) struct Place {
    origin: DVec3,
    per_metre: f64,
}

impl Place {
    /// A world position in scene units.
    pub fn inside(&self, p: DVec3) -> Vec3A {
        ((p - self.origin) * self.per_metre).as_vec3a()
    }

    /// The middle of the bodies and half the diagonal of the box that holds all but a few of their vertices.
    fn around(frames: &[&Frame], view: &View, camera: &Camera) -> Self {
        let points: Vec<DVec3> = frames.iter().flat_map(|f| f.positions.iter()).filter_map(finite).collect();
        let ground = view.ground.filter(|y| y.is_finite()).unwrap_or(0.0);
        if points.is_empty() {
            let target = DVec3::from(camera.target);
            return Self { origin: DVec3::new(target.x, ground, target.z), per_metre: 1.0 };
        }
        let trim = points.len() / 500;
        let range = |axis: usize| {
            let mut values: Vec<f64> = points.iter().map(|p| p[axis]).collect();
            let high = values.len() - 1 - trim;
            let low = *values.select_nth_unstable_by(trim, f64::total_cmp).1;
            (low, *values.select_nth_unstable_by(high, f64::total_cmp).1)
        };
        let (x, y, z) = (range(0), range(1), range(2));
        let half = DVec3::new(x.1 - x.0, y.1 - y.0, z.1 - z.0) / 2.0;
        let radius = half.length();
        let radius = if radius > 0.0 { radius } else { 1.0 };
        Self { origin: DVec3::new(x.0 + half.x, y.0 + half.y, z.0 + half.z), per_metre: 1.0 / radius }
    }
}

/// A triangle as it is shaded.
pub(super) struct Face {
    pub corners: [Vec3A; 3],
    /// Vertex normals; all three the face normal where the frame has none.
    pub normals: [Vec3A; 3],
    /// Linear colour at the corners.
    pub colours: [Vec3A; 3],
    /// The unit normal of the plane.
    pub plane: Vec3A,
    /// On a crack face.
    pub crack: bool,
}

/// The nearest thing along a ray.
pub(super) enum Hit<'a> {
    /// A body: the face, the weights of its corners, the distance.
    Body(&'a Face, [f32; 3], f32),
    /// The ground at a distance.
    Ground(f32),
    /// Nothing.
    Sky,
}

/// Bodies and ground in scene units.
pub(super) struct Scene {
    pub place: Place,
    /// Height of the ground in scene units.
    pub ground: Option<f32>,
    faces: Vec<Face>,
    /// The same triangles in the order of the hierarchy's leaves.
    leaves: Vec<Triangle>,
    bvh: Option<CwBvh>,
}

impl Scene {
    pub fn new(frames: &[&Frame], view: &View, camera: &Camera) -> Self {
        let place = Place::around(frames, view, camera);
        let painter = Painter::new(frames, view);
        let mut faces = Vec::new();
        for frame in frames {
            faces.extend(frame.triangles.iter().filter_map(|t| face(frame, t, &place, &painter)));
        }
        let triangles: Vec<Triangle> = faces
            .iter()
            .map(|f| {
                let [a, b, c] = f.corners.map(|p| p.to_array());
                Triangle { v0: a.into(), v1: b.into(), v2: c.into() }
            })
            .collect();
        let bvh = (!triangles.is_empty())
            .then(|| build_cwbvh_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default()));
        let leaves = bvh.iter().flat_map(|b| &b.primitive_indices).map(|&k| triangles[k as usize]).collect();
        let ground = view.ground.filter(|y| y.is_finite()).map(|y| ((y - place.origin.y) * place.per_metre) as f32);
        Self { place, ground, faces, leaves, bvh }
    }

    /// What a ray meets first. `direction` has length one.
    pub fn trace(&self, origin: Vec3A, direction: Vec3A) -> Hit<'_> {
        let ground = self.ground.map_or(f32::INFINITY, |y| {
            let t = (y - origin.y) / direction.y;
            if origin.y > y && direction.y < 0.0 && t.is_finite() { t } else { f32::INFINITY }
        });
        if let Some(bvh) = &self.bvh {
            let ray = Ray::new(origin.to_array().into(), direction.to_array().into(), 0.0, ground.min(1e30));
            let mut hit = RayHit::none();
            if bvh.ray_traverse(ray, &mut hit, |ray, k| self.leaves[k].intersect(ray)) {
                let face = &self.faces[bvh.primitive_indices[hit.primitive_id as usize] as usize];
                return Hit::Body(face, face.weights(origin + direction * hit.t), hit.t);
            }
        }
        if ground.is_finite() { Hit::Ground(ground) } else { Hit::Sky }
    }

    /// Whether nothing of the bodies lies within `reach` along a ray. The ground hides nothing.
    pub fn open(&self, origin: Vec3A, direction: Vec3A, reach: f32) -> bool {
        self.bvh.as_ref().is_none_or(|bvh| {
            let ray = Ray::new(origin.to_array().into(), direction.to_array().into(), 0.0, reach);
            bvh.ray_traverse_miss(ray, |ray, k| self.leaves[k].intersect(ray))
        })
    }
}

impl Face {
    /// Weights of the corners at `p` on the plane; they sum to one and none is negative.
    fn weights(&self, p: Vec3A) -> [f32; 3] {
        let [a, b, c] = self.corners;
        let opposite = |q: Vec3A, r: Vec3A| (q - p).cross(r - p).dot(self.plane).max(0.0);
        let (u, v, w) = (opposite(b, c), opposite(c, a), opposite(a, b));
        let sum = u + v + w;
        if sum > 0.0 { [u / sum, v / sum, w / sum] } else { [1.0, 0.0, 0.0] }
    }
}

/// A triangle of `frame` made ready; `None` if it is broken or has no area.
fn face(frame: &Frame, corners: &[u32; 3], place: &Place, painter: &Painter) -> Option<Face> {
    let [i, j, k] = corners.map(|v| v as usize);
    let at = |v: usize| frame.positions.get(v).and_then(finite).map(|p| place.inside(p));
    let points = [at(i)?, at(j)?, at(k)?];
    // Squares of anything beyond 1e15 sizes away overflow in the hierarchy; nothing there can be seen.
    if points.iter().any(|p| p.abs().max_element() > 1e15) {
        return None;
    }
    let plane = (points[1] - points[0]).cross(points[2] - points[0]).try_normalize()?;
    let crack = [i, j, k].iter().all(|&v| frame.inside.get(v).is_some_and(|&x| x != 0));
    let normal = |v: usize| {
        let given = frame.normals.get(v).and_then(|&n| Vec3A::from(n).try_normalize()).unwrap_or(plane);
        // A normal that looks to the other side of its own triangle would shade black.
        if given.dot(plane) > 0.1 { given } else { plane }
    };
    let normals = [normal(i), normal(j), normal(k)];
    let colours = [i, j, k].map(|v| painter.paint(frame, v, crack));
    Some(Face { corners: points, normals, colours, plane, crack })
}

/// Colours of vertices by the view's mode.
struct Painter {
    mode: ColourMode,
    outside: Vec3A,
    crack: Vec3A,
    fastest: f32,
    /// The stretch of the last colour.
    longest: f32,
}

impl Painter {
    fn new(frames: &[&Frame], view: &View) -> Self {
        let speeds = frames.iter().flat_map(|f| f.velocity.iter()).map(|&v| Vec3A::from(v).length());
        let fastest = view.speed_range.unwrap_or_else(|| speeds.filter(|s| s.is_finite()).fold(0.0, f32::max));
        let longest = view.stretch_range.unwrap_or_else(|| most_stretches(frames));
        Self {
            mode: view.mode,
            outside: colour::linear(view.palette.outside),
            crack: colour::linear(view.palette.crack),
            fastest: fastest.max(1e-12),
            longest: longest.max(1e-12),
        }
    }

    fn paint(&self, frame: &Frame, v: usize, crack: bool) -> Vec3A {
        let dim = if crack { 0.7 } else { 1.0 };
        let value = |column: &[f32]| column.get(v).copied().unwrap_or(0.0);
        match self.mode {
            ColourMode::Material if crack => self.crack,
            ColourMode::Material => self.outside,
            ColourMode::Damage => colour::damage(value(&frame.damage)),
            ColourMode::Stretch => colour::stretch(value(&frame.stretch) / self.longest),
            ColourMode::Speed => {
                let v = frame.velocity.get(v).map_or(0.0, |&v| Vec3A::from(v).length());
                colour::speed(v / self.fastest)
            }
            ColourMode::Piece => colour::piece(frame.piece.get(v).copied().unwrap_or(0)) * dim,
        }
    }
}

/// What 99 of 100 vertices do not exceed in stretch, either way.
pub(super) fn most_stretches(frames: &[&Frame]) -> f32 {
    let sizes = frames.iter().flat_map(|f| &f.stretch).map(|s| s.abs()).filter(|s| s.is_finite());
    let mut sizes: Vec<f32> = sizes.collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let rank = (sizes.len() - 1) * 99 / 100;
    *sizes.select_nth_unstable_by(rank, f32::total_cmp).1
}
