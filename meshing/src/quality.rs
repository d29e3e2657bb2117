//! How good a tetrahedral mesh is: angles, edges, volume, and the distance to the surface it was made from.

use crate::distance::Distance;
use crate::tetmesh::{FACES, TetMesh};
use crate::tetrahedralise::Solid;
use glam::DVec3;
use rayon::prelude::*;

/// A largest distance and where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// In element sizes.
    pub sizes: f64,
    /// The place [m].
    pub at: DVec3,
}

/// What there is to say about a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Number of tetrahedra.
    pub tets: usize,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of boundary triangles.
    pub boundary_triangles: usize,
    /// Smallest dihedral angle [degrees].
    pub min_dihedral: f64,
    /// Largest dihedral angle [degrees].
    pub max_dihedral: f64,
    /// Dihedral angles (six per tetrahedron) in 18 bins of 10 degrees.
    pub histogram: [usize; 18],
    /// Mean edge length [m].
    pub mean_edge: f64,
    /// Volume [m³].
    pub volume: f64,
    /// Volume divided by that of the input, where the input has one.
    pub volume_ratio: Option<f64>,
    /// The element size [m] that deviations are given in; 0 if they were not measured.
    pub size: f64,
    /// Farthest point of the input's surface from the mesh's boundary.
    pub surface_to_mesh: Deviation,
    /// Farthest point of the mesh's boundary from the input's surface.
    pub mesh_to_surface: Deviation,
    /// ⟨x⁴+y⁴+z⁴⟩ of the inner face normals divided by 3/5, minus 1: 0 without preferred axes, −1/6 for the {110} planes
    /// of a lattice, 2/3 for faces along the axes.
    pub cubic: f64,
    /// Euler characteristic of the boundary: 2 for each part without holes, 2 less for each hole through it.
    pub euler: i64,
    /// What the caller should know, one sentence each.
    pub warnings: Vec<String>,
}

/// The six dihedral angles of a tetrahedron [degrees].
pub fn dihedral_angles(corners: [DVec3; 4]) -> [f64; 6] {
    let n = FACES.map(|f| {
        let [a, b, c] = f.map(|k| corners[k]);
        (b - a).cross(c - a)
    });
    [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]].map(|[i, j]| 180.0 - n[i].angle_between(n[j]).to_degrees())
}

/// Boundary triangles of a mesh, wound outwards, in the order of their tetrahedra.
pub fn boundary(mesh: &TetMesh) -> Vec<[u32; 3]> {
    let face = |n: u32| FACES[n as usize % 4].map(|k| mesh.tets[n as usize / 4][k]);
    let mut all: Vec<([u32; 3], u32)> = (0..4 * mesh.tets.len() as u32)
        .into_par_iter()
        .map(|n| {
            let mut key = face(n);
            key.sort_unstable();
            (key, n)
        })
        .collect();
    all.par_sort_unstable();
    let mut single: Vec<u32> = all.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1).map(|s| s[0].1).collect();
    single.sort_unstable();
    single.into_iter().map(face).collect()
}

/// Vertices − edges + triangles of a closed surface.
pub fn euler(triangles: &[[u32; 3]]) -> i64 {
    let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices.len() as i64 - triangles.len() as i64 / 2
}

impl Report {
    /// Measures a mesh by itself.
    pub fn of(mesh: &TetMesh) -> Self {
        Self::inner(mesh, &boundary(mesh))
    }

    fn inner(mesh: &TetMesh, outer: &[[u32; 3]]) -> Self {
        let mut report = Self {
            tets: mesh.tets.len(),
            vertices: mesh.vertices.len(),
            boundary_triangles: outer.len(),
            min_dihedral: if mesh.tets.is_empty() { 0.0 } else { 180.0 },
            mean_edge: mesh.mean_edge(),
            euler: euler(outer),
            ..Self::default()
        };
        let (mut quartic, mut count) = (0.0, 0.0);
        let quartic_of = |[a, b, c]: [DVec3; 3]| {
            let n = (b - a).cross(c - a).normalize_or_zero();
            (n * n).length_squared()
        };
        for t in 0..mesh.tets.len() {
            let corners = mesh.corners(t);
            report.volume += mesh.volume(t);
            for angle in dihedral_angles(corners) {
                report.min_dihedral = report.min_dihedral.min(angle);
                report.max_dihedral = report.max_dihedral.max(angle);
                report.histogram[((angle / 10.0) as usize).min(17)] += 1;
            }
            for f in FACES {
                quartic += quartic_of(f.map(|k| corners[k]));
                count += 1.0;
            }
        }
        for f in outer {
            quartic -= quartic_of(f.map(|v| mesh.vertices[v as usize]));
            count -= 1.0;
        }
        report.cubic = if count > 0.0 { quartic / count / 0.6 - 1.0 } else { 0.0 };
        report
    }

    /// Measures a mesh against the solid it stands for; deviations in element sizes of `size` [m].
    pub fn against(mesh: &TetMesh, solid: &dyn Solid, size: f64) -> Self {
        let outer = boundary(mesh);
        let mut report = Self::inner(mesh, &outer);
        report.size = size;
        report.volume_ratio = solid.volume().map(|v| report.volume / v);
        let outer: Vec<[DVec3; 3]> = outer.into_iter().map(|f| f.map(|v| mesh.vertices[v as usize])).collect();
        let farthest = |points: Vec<DVec3>, distance: &(dyn Fn(DVec3) -> f64 + Sync)| {
            let all: Vec<f64> = points.par_iter().map(|&p| distance(p)).collect();
            let worst = (0..all.len()).max_by(|&i, &j| all[i].total_cmp(&all[j]).then(j.cmp(&i)));
            worst.map_or(Deviation::default(), |i| Deviation { sizes: all[i] / size, at: points[i] })
        };
        let on_mesh = outer
            .iter()
            .flat_map(|&[a, b, c]| [(a + b + c) / 3.0, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, a, b, c])
            .collect();
        report.mesh_to_surface = farthest(on_mesh, &|p| p.distance(solid.project(p)));
        let tree = Distance::of_triangles(outer);
        report.surface_to_mesh =
            farthest(solid.samples(0.2 * size).into_iter().map(|s| s.0).collect(), &|p| tree.distance(p));
        report
    }

    /// The larger of the two deviations, the Hausdorff distance in element sizes.
    pub fn hausdorff(&self) -> Deviation {
        let (a, b) = (self.surface_to_mesh, self.mesh_to_surface);
        if a.sizes > b.sizes { a } else { b }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one() -> TetMesh {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        TetMesh { vertices, tets: vec![[0, 1, 2, 3]] }
    }

    #[test]
    fn a_corner_of_a_cube_has_known_angles() {
        let report = Report::of(&one());
        assert!((report.min_dihedral - (1.0f64 / 3.0f64.sqrt()).acos().to_degrees()).abs() < 1e-12);
        assert!((report.max_dihedral - 90.0).abs() < 1e-12);
        assert_eq!((report.histogram[5], report.histogram.iter().sum::<usize>()), (3, 6));
        assert_eq!((report.boundary_triangles, report.euler), (4, 2));
        assert!((report.volume - 1.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn boundary_faces_point_outwards() {
        let mesh = one();
        let inner = mesh.barycentre(0);
        for f in boundary(&mesh) {
            let [a, b, c] = f.map(|v| mesh.vertices[v as usize]);
            assert!((b - a).cross(c - a).dot(a - inner) > 0.0);
        }
    }

    #[test]
    fn nothing_gives_an_empty_report() {
        assert_eq!(Report::of(&TetMesh::default()), Report::default());
    }
}
