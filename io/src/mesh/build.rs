//! What every reader must check, once: vertices that are places in space, indices that exist, tetrahedra with volume.

use super::LabelledTets;
use super::cursor::Cursor;
use super::error::{MeshError, Problem};
use fissure_meshing::{TetMesh, TriMesh};
use glam::DVec3;
use std::collections::HashMap;

/// Largest coordinate: the sixth power of a length still fits a double with room to spare.
const FARTHEST: f64 = 1e100;

/// A vertex, if its coordinates are numbers that volumes can be made of.
pub(super) fn vertex(at: &Cursor, number: i64, [x, y, z]: [f64; 3]) -> Result<DVec3, MeshError> {
    match [x, y, z].into_iter().find(|c| c.is_nan() || c.abs() > FARTHEST) {
        None => Ok(DVec3::new(x, y, z)),
        Some(c) => Err(at.fail(Problem::NotFinite { vertex: number, value: format!("{c:?}") })),
    }
}

/// Collects tetrahedra. Errors name the place where the cursor handed in stands.
#[derive(Default)]
pub(super) struct TetBuilder {
    mesh: TetMesh,
    numbers: Numbers,
}

impl TetBuilder {
    /// Adds the vertex that the file calls `number`.
    pub(super) fn vertex(&mut self, at: &Cursor, number: i64, p: [f64; 3]) -> Result<(), MeshError> {
        let p = vertex(at, number, p)?;
        let index = u32::try_from(self.mesh.vertices.len()).ok().filter(|&i| i < u32::MAX);
        let index = index.ok_or_else(|| at.fail(Problem::TooLarge))?;
        if !self.numbers.add(number, index) {
            return Err(at.fail(Problem::RepeatedVertex { vertex: number }));
        }
        self.mesh.vertices.push(p);
        Ok(())
    }

    /// Number of vertices so far.
    pub(super) fn vertices(&self) -> usize {
        self.mesh.vertices.len()
    }

    /// Adds a tetrahedron of the vertices called `corners`, turned to positive volume; `name` says what the file calls
    /// it.
    pub(super) fn tet(&mut self, at: &Cursor, corners: [i64; 4], name: impl Fn() -> String) -> Result<(), MeshError> {
        let mut tet = [0; 4];
        for (index, &number) in tet.iter_mut().zip(&corners) {
            *index = self
                .numbers
                .index(number)
                .ok_or_else(|| at.fail(Problem::NoSuchVertex { element: name(), vertex: number }))?;
        }
        let [a, b, c, d] = tet.map(|v| self.mesh.vertices[v as usize]);
        let (u, v, w) = (b - a, c - a, d - a);
        let six_volumes = u.dot(v.cross(w));
        // Below a few roundings of the three edges the sign is noise.
        let noise = 8.0 * f64::EPSILON * u.length() * v.length() * w.length();
        if six_volumes.abs() <= noise {
            return Err(at.fail(Problem::NoVolume { element: name() }));
        }
        if six_volumes < 0.0 {
            tet.swap(2, 3);
        }
        self.mesh.tets.push(tet);
        Ok(())
    }

    /// The mesh without the vertices that no tetrahedron uses. `labels` are one per tetrahedron or none; if all are 0
    /// they say nothing and are dropped.
    pub(super) fn finish(self, at: &Cursor, mut labels: Vec<i64>) -> Result<LabelledTets, MeshError> {
        let TetMesh { vertices, mut tets } = self.mesh;
        if tets.is_empty() {
            return Err(MeshError::content(
                at.path(),
                super::Place::Whole,
                Problem::Empty { what: "linear or quadratic tetrahedra" },
            ));
        }
        let mut new = vec![u32::MAX; vertices.len()];
        for &v in tets.iter().flatten() {
            new[v as usize] = 0;
        }
        let mut kept = Vec::with_capacity(vertices.len());
        for (v, new) in new.iter_mut().enumerate().filter(|(_, new)| **new == 0) {
            *new = kept.len() as u32;
            kept.push(vertices[v]);
        }
        tets.iter_mut().flatten().for_each(|v| *v = new[*v as usize]);
        if labels.iter().all(|&l| l == 0) {
            labels.clear();
        }
        Ok(LabelledTets { mesh: TetMesh { vertices: kept, tets }, labels })
    }
}

/// From the vertex numbers of a file to indices. Numbers that count up by one, the usual case, need no table.
#[derive(Default)]
struct Numbers {
    first: i64,
    run: u32,
    others: HashMap<i64, u32>,
}

impl Numbers {
    /// False if the number is taken. Indices come in order.
    fn add(&mut self, number: i64, index: u32) -> bool {
        if index == 0 {
            self.first = number;
        }
        if self.index(number).is_some() {
            return false;
        }
        if self.others.is_empty() && number.checked_sub(self.first) == Some(i64::from(index)) {
            self.run = index + 1;
        } else {
            self.others.insert(number, index);
        }
        true
    }

    fn index(&self, number: i64) -> Option<u32> {
        match number.checked_sub(self.first) {
            Some(i) if (0..i64::from(self.run)).contains(&i) => Some(i as u32),
            _ => self.others.get(&number).copied(),
        }
    }
}

/// Collects triangles from polygons.
#[derive(Default)]
pub(super) struct TriBuilder {
    pub(super) mesh: TriMesh,
}

impl TriBuilder {
    /// Adds the vertex that the file calls `number`.
    pub(super) fn vertex(&mut self, at: &Cursor, number: i64, p: [f64; 3]) -> Result<(), MeshError> {
        if self.mesh.vertices.len() >= u32::MAX as usize {
            return Err(at.fail(Problem::TooLarge));
        }
        self.mesh.vertices.push(vertex(at, number, p)?);
        Ok(())
    }

    /// Adds a polygon as a fan around its first corner. `base` is the number of the first vertex in the file (0 or 1).
    /// Triangles with a corner twice cover nothing, and their neighbours close without them: they are left out.
    pub(super) fn polygon(
        &mut self,
        at: &Cursor,
        corners: &[i64],
        base: i64,
        name: impl Fn() -> String,
    ) -> Result<(), MeshError> {
        if corners.len() < 3 {
            return Err(at.fail(Problem::FewCorners { element: name(), corners: corners.len() }));
        }
        let count = self.mesh.vertices.len();
        let index = |number: i64| match number.checked_sub(base).and_then(|i| u32::try_from(i).ok()) {
            Some(i) if (i as usize) < count => Ok(i),
            _ => Err(at.fail(Problem::NoSuchVertex { element: name(), vertex: number })),
        };
        let first = index(corners[0])?;
        let mut last = index(corners[1])?;
        for &corner in &corners[2..] {
            let next = index(corner)?;
            if first != last && last != next && next != first {
                self.mesh.triangles.push([first, last, next]);
            }
            last = next;
        }
        Ok(())
    }

    pub(super) fn finish(self, at: &Cursor) -> Result<TriMesh, MeshError> {
        if self.mesh.triangles.is_empty() {
            return Err(MeshError::content(at.path(), super::Place::Whole, Problem::Empty { what: "triangles" }));
        }
        Ok(self.mesh)
    }
}
