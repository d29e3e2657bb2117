//! A closed triangle surface as a collider, and convex hulls as such surfaces.

use glam::{DMat3, DVec3};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{ConvexPolyhedron, Shape as Solid, TriMesh, TriMeshFlags};
use parry3d_f64::transformation::try_convex_hull;

use super::shape::{MassProperties, ShapeError};
use crate::buffer::Buffer;

/// A closed surface wound outwards, with the hierarchy that finds its nearest triangle.
#[derive(Debug, Default)]
pub struct Mesh {
    /// Vertices [m]; frozen, so that a restart needs no mesh file.
    pub vertices: Buffer<DVec3>,
    /// Vertices of each triangle.
    pub triangles: Buffer<[u32; 3]>,
    tree: Option<Box<TriMesh>>,
    radius: f64,
}

impl Mesh {
    /// The inside of a closed surface.
    ///
    /// # Errors
    /// An edge without exactly two triangles of opposite direction; no volume.
    pub fn new(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Self, ShapeError> {
        let edges = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
        let mut all: Vec<[u32; 2]> = triangles.iter().flat_map(edges).collect();
        all.sort_unstable();
        let alone = |e: &&[u32; 2]| all.binary_search(&[e[1], e[0]]).is_err();
        let twice = all.windows(2).find(|w| w[0] == w[1]).map(|w| &w[0]);
        if let Some(&[a, b]) = all.iter().find(alone).or(twice) {
            return Err(ShapeError::Open { from: vertices[a as usize], to: vertices[b as usize] });
        }
        let mut mesh = Self { vertices: vertices.into(), triangles: triangles.into(), tree: None, radius: 0.0 };
        let volume = mesh.mass_properties().volume;
        if !(volume > 0.0 && volume.is_finite()) {
            return Err(ShapeError::Flat { volume });
        }
        mesh.prepare();
        Ok(mesh)
    }

    /// The convex hull of `points` [m].
    ///
    /// # Errors
    /// Points that all lie in one plane.
    pub fn hull(points: &[DVec3]) -> Result<Self, ShapeError> {
        let (vertices, triangles) = try_convex_hull(points).map_err(|_| ShapeError::NoHull)?;
        Self::new(vertices, triangles).map_err(|_| ShapeError::NoHull)
    }

    /// Builds the hierarchy, after construction and after a restart.
    pub fn prepare(&mut self) {
        self.radius = self.vertices.iter().map(|v| v.length()).fold(0.0, f64::max);
        let (vertices, triangles) = (self.vertices.to_vec(), self.triangles.to_vec());
        // ORIENTED: without pseudo-normals nothing is inside
        self.tree = TriMesh::with_flags(vertices, triangles, TriMeshFlags::ORIENTED).ok().map(Box::new);
    }

    /// Whether every triangle has vertices that exist.
    pub(super) fn consistent(&self) -> bool {
        let vertices = self.vertices.len() as u32;
        !self.triangles.is_empty() && self.triangles.iter().flatten().all(|&v| v < vertices)
    }

    /// Moves all vertices.
    pub fn shift(&mut self, by: DVec3) {
        self.vertices.iter_mut().for_each(|v| *v += by);
        self.prepare();
    }

    pub(super) fn distance(&self, x: DVec3, reach: f64) -> Option<(f64, DVec3)> {
        let hit = self.tree.as_ref()?.project_local_point_with_max_dist(x, false, reach)?;
        let away = x - hit.point;
        let length = away.length();
        let sign = if hit.is_inside { -1.0 } else { 1.0 };
        // on the surface itself the face decides
        let normal =
            if length > 1e-12 * reach.min(1e3) { away * (sign / length) } else { self.normal(hit.subshape as usize) };
        Some((sign * length, normal))
    }

    /// As parry3d has solids: a convex one as such, since that has larger faces to stand on.
    pub(super) fn solid(&self) -> Option<Box<dyn Solid>> {
        let hull = || ConvexPolyhedron::from_convex_mesh(self.vertices.to_vec(), &self.triangles);
        match self.is_convex().then(hull).flatten() {
            Some(hull) => Some(Box::new(hull)),
            None => Some(self.tree.clone()?),
        }
    }

    /// Whether no edge is a notch.
    fn is_convex(&self) -> bool {
        let edges = |t: &[u32; 3]| [([t[0], t[1]], t[2]), ([t[1], t[2]], t[0]), ([t[2], t[0]], t[1])];
        let mut all: Vec<([u32; 2], u32)> = self.triangles.iter().flat_map(edges).collect();
        all.sort_unstable();
        let at = |v: u32| self.vertices[v as usize];
        all.iter().all(|&([a, b], c)| {
            let across = all.binary_search_by_key(&[b, a], |e| e.0).map(|k| all[k].1);
            let normal = (at(b) - at(a)).cross(at(c) - at(a)).normalize_or_zero();
            across.is_ok_and(|d| (at(d) - at(a)).dot(normal) <= 1e-9 * self.radius)
        })
    }

    fn normal(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.triangles[triangle % self.triangles.len()].map(|v| self.vertices[v as usize]);
        (b - a).cross(c - a).try_normalize().unwrap_or(DVec3::Y)
    }

    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// By the divergence theorem: sums over the tetrahedra from the origin to each triangle.
    pub(super) fn mass_properties(&self) -> MassProperties {
        let (mut volume, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
        let outer = |v: DVec3| DMat3::from_cols(v * v.x, v * v.y, v * v.z);
        for t in self.triangles.iter() {
            let [a, b, c] = t.map(|v| self.vertices[v as usize]);
            let v = a.dot(b.cross(c)) / 6.0;
            let sum = a + b + c;
            volume += v;
            first += sum * (v / 4.0);
            second += (outer(a) + outer(b) + outer(c) + outer(sum)) * (v / 20.0);
        }
        let centre = first / volume;
        let about = second - outer(centre) * volume;
        let trace = about.x_axis.x + about.y_axis.y + about.z_axis.z;
        MassProperties { volume, centre, inertia: DMat3::from_diagonal(DVec3::splat(trace)) - about }
    }
}
