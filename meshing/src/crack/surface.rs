//! The surface of a cracked mesh, for rendering: outside faces and both sides of every separated face.
//!
//! A surface vertex is a mesh vertex, whether it is seen on an outside or on a crack face, and a group of faces around
//! it that share a normal. Groups are found in the rest shape, so that shading does not flicker as the body moves.

use glam::DVec3;
use rayon::prelude::*;

use super::{CrackMesh, SEPARATED};
use crate::tetmesh::FACES;

/// Largest angles [rad] between two faces along an edge that are shaded as one smooth surface, at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothing {
    /// Among outside faces; π smooths over every edge.
    pub outside: f64,
    /// Among crack faces.
    pub inside: f64,
}

impl Default for Smoothing {
    /// The outside up to 50°, so that a box keeps its edges; crack faces up to 30°: most are shaded flat, as broken stone
    /// looks.
    fn default() -> Self {
        Self { outside: 50f64.to_radians(), inside: 30f64.to_radians() }
    }
}

/// Triangles over vertices of their own; a mesh vertex may stand behind several of these.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// The mesh vertex behind each surface vertex.
    pub vertices: Vec<u32>,
    /// For each surface vertex 0 if its faces were outside from the start, 1 if they are crack faces. All corners of a
    /// triangle agree.
    pub inside: Vec<u8>,
    /// Surface vertices of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The tetrahedron behind each triangle.
    pub tets: Vec<u32>,
}

/// One corner of one triangle, ordered by what it may share with others.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Corner {
    vertex: u32,
    inside: u8,
    triangle: u32,
    local: u8,
}

impl CrackMesh {
    /// The current surface with the default smoothing.
    pub fn surface(&self) -> Surface {
        self.surface_with(Smoothing::default())
    }

    /// The current surface: faces that never had a neighbour, and separated ones.
    pub fn surface_with(&self, smoothing: Smoothing) -> Surface {
        let (mut triangles, mut tets, mut inner) = (Vec::new(), Vec::new(), Vec::new());
        for t in 0..self.tets.len() {
            for (k, face) in FACES.iter().enumerate() {
                let outside = self.neighbours[t][k] == super::NONE;
                if outside || self.status(t, k) == SEPARATED {
                    triangles.push(face.map(|v| self.tets[t][v]));
                    tets.push(t as u32);
                    inner.push(u8::from(!outside));
                }
            }
        }
        let normals: Vec<DVec3> = triangles
            .par_iter()
            .map(|tri| {
                let [a, b, c] = tri.map(|v| self.rest_position(v));
                (b - a).cross(c - a).normalize_or_zero()
            })
            .collect();
        shaded(triangles, tets, &inner, &normals, smoothing)
    }
}

/// Triangles over mesh vertices as a [`Surface`]: those that meet in a vertex, are both `inner` or both not, and whose
/// `normals` at rest differ by no more than `smoothing` allows, share a surface vertex there. `tets` are behind them.
pub(crate) fn shaded(
    triangles: Vec<[u32; 3]>,
    tets: Vec<u32>,
    inner: &[u8],
    normals: &[DVec3],
    smoothing: Smoothing,
) -> Surface {
    let mut corners: Vec<Corner> = (0..3 * triangles.len())
        .into_par_iter()
        .map(|c| {
            let (t, k) = (c / 3, c % 3);
            Corner { vertex: triangles[t][k], inside: inner[t], triangle: t as u32, local: k as u8 }
        })
        .collect();
    corners.par_sort_unstable();

    let mut out = Surface { triangles: triangles.clone(), tets, ..Surface::default() };
    let mut group: Vec<u32> = Vec::new();
    for fan in corners.chunk_by(|a, b| (a.vertex, a.inside) == (b.vertex, b.inside)) {
        let angle = if fan[0].inside == 1 { smoothing.inside } else { smoothing.outside };
        let smooth = |a: &Corner, b: &Corner| {
            let (s, t) = (triangles[a.triangle as usize], triangles[b.triangle as usize]);
            let edge = s.iter().any(|v| *v != a.vertex && t.contains(v));
            edge && normals[a.triangle as usize].dot(normals[b.triangle as usize]) >= angle.cos()
        };
        group.clear();
        if angle >= std::f64::consts::PI {
            group.resize(fan.len(), 0);
        } else {
            group.extend(0..fan.len() as u32);
            for b in 1..fan.len() {
                for a in 0..b {
                    let (from, to) = (group[a].max(group[b]), group[a].min(group[b]));
                    if from != to && smooth(&fan[a], &fan[b]) {
                        group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
                    }
                }
            }
        }
        for leader in 0..fan.len() as u32 {
            let number = out.vertices.len() as u32;
            for (corner, _) in fan.iter().zip(&group).filter(|(_, g)| **g == leader) {
                out.triangles[corner.triangle as usize][corner.local as usize] = number;
                if out.vertices.len() as u32 == number {
                    out.vertices.push(corner.vertex);
                    out.inside.push(corner.inside);
                }
            }
            if angle >= std::f64::consts::PI {
                break;
            }
        }
    }
    out
}

impl Surface {
    /// The mesh vertices of triangle `t`.
    pub fn mesh_triangle(&self, t: usize) -> [u32; 3] {
        self.triangles[t].map(|v| self.vertices[v as usize])
    }

    /// Whether triangle `t` is a crack face (1) or was outside from the start (0).
    pub fn triangle_inside(&self, t: usize) -> u8 {
        self.inside[self.triangles[t][0] as usize]
    }

    /// Unit normals of the surface vertices, where `positions` [m] are those of the mesh vertices: mean of the faces'
    /// normals weighted by their areas; zero where all faces have no area.
    pub fn normals(&self, positions: &[DVec3]) -> Vec<DVec3> {
        let mut sum = vec![DVec3::ZERO; self.vertices.len()];
        for (t, tri) in self.triangles.iter().enumerate() {
            let [a, b, c] = self.mesh_triangle(t).map(|v| positions[v as usize]);
            let area = (b - a).cross(c - a);
            for &v in tri {
                sum[v as usize] += area;
            }
        }
        sum.into_iter().map(DVec3::normalize_or_zero).collect()
    }

    /// How much longer than at rest the surface is at each of its vertices, along the direction in which that is most: λ − 1
    /// with the larger principal stretch λ of each triangle, in the mean of those around a vertex weighted by their areas at
    /// rest. `positions` [m] are those of the mesh vertices, `rest` gives their places at rest [m].
    pub fn stretches(&self, positions: &[DVec3], rest: impl Fn(u32) -> DVec3) -> Vec<f64> {
        let mut sum = vec![(0.0, 0.0); self.vertices.len()];
        for (t, tri) in self.triangles.iter().enumerate() {
            let corners = self.mesh_triangle(t);
            let metric = |[a, b, c]: [DVec3; 3]| {
                let (u, v) = (b - a, c - a);
                [u.dot(u), u.dot(v), v.dot(v)]
            };
            let (then, now) = (metric(corners.map(&rest)), metric(corners.map(|v| positions[v as usize])));
            let (area, det) = (then[0] * then[2] - then[1] * then[1], now[0] * now[2] - now[1] * now[1]);
            if area <= 0.0 {
                continue;
            }
            // λ² are the eigenvalues of the metric now in terms of that at rest
            let half = 0.5 * (then[2] * now[0] - 2.0 * then[1] * now[1] + then[0] * now[2]) / area;
            let stretch = (half + (half * half - det / area).max(0.0).sqrt()).sqrt() - 1.0;
            for &v in tri {
                let (total, weight) = &mut sum[v as usize];
                (*total, *weight) = (*total + area.sqrt() * stretch, *weight + area.sqrt());
            }
        }
        sum.into_iter().map(|(total, weight)| if weight > 0.0 { total / weight } else { 0.0 }).collect()
    }
}
