//! What is to be filled with tetrahedra: the inside of a surface, or a wall around one.

use super::features::Features;
use super::smooth::Random;
use crate::TriMesh;
use crate::distance::Distance;
use crate::quality::euler;
use glam::DVec3;
use rayon::prelude::*;

/// A solid known by its signed distance.
pub trait Solid: Sync {
    /// Signed distance [m], negative inside. Where it is farther than `reach`, only sign and "farther" are promised.
    fn signed_distance(&self, p: DVec3, reach: f64) -> f64;
    /// A point of the boundary near `p`; the closest one if `p` is near the boundary.
    fn project(&self, p: DVec3) -> DVec3;
    /// Smallest and largest corner of a box around the solid.
    fn bounds(&self) -> (DVec3, DVec3);
    /// Sharp edges and corners.
    fn features(&self) -> &Features;
    /// Points on the boundary, none farther than about `spacing` [m] from the next, in a fixed order, with the outward
    /// normal where there is one (else zero).
    fn samples(&self, spacing: f64) -> Vec<(DVec3, DVec3)>;
    /// Volume [m³] where it is known.
    fn volume(&self) -> Option<f64>;
    /// Euler characteristic of the boundary (2 for a ball, 0 for a torus) where it is known.
    fn euler(&self) -> Option<i64>;
    /// Number of separate parts where it is known.
    fn parts(&self) -> Option<usize>;
}

/// The inside of a closed surface.
pub struct Inside<'a> {
    surface: &'a TriMesh,
    tree: Distance,
    features: Features,
    parts: usize,
}

impl<'a> Inside<'a> {
    /// Finds the features that matter for elements of `size` [m].
    pub fn new(surface: &'a TriMesh, size: f64) -> Self {
        Self { surface, tree: Distance::new(surface), features: Features::of(surface, size), parts: parts(surface) }
    }
}

impl Solid for Inside<'_> {
    fn signed_distance(&self, p: DVec3, reach: f64) -> f64 {
        let d = self.tree.closest_within(p, reach).map_or(2.0 * reach, |c| c.distance);
        if self.tree.inside(p) { -d } else { d }
    }

    fn project(&self, p: DVec3) -> DVec3 {
        self.tree.closest(p).map_or(p, |c| c.point)
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        self.surface.bounds().unwrap_or((DVec3::ZERO, DVec3::ZERO))
    }

    fn features(&self) -> &Features {
        &self.features
    }

    fn samples(&self, spacing: f64) -> Vec<(DVec3, DVec3)> {
        let mut out = scatter(self.surface, spacing);
        out.extend(self.surface.vertices.iter().map(|&v| (v, DVec3::ZERO)));
        out
    }

    fn volume(&self) -> Option<f64> {
        Some(self.surface.volume())
    }

    fn euler(&self) -> Option<i64> {
        Some(euler(&self.surface.triangles))
    }

    fn parts(&self) -> Option<usize> {
        Some(self.parts)
    }
}

/// A wall of even thickness around a surface, open or closed: all points within half the thickness of it. Rims are
/// round.
pub struct Shell<'a> {
    surface: &'a TriMesh,
    tree: Distance,
    half: f64,
    features: Features,
}

impl<'a> Shell<'a> {
    /// A wall of `thickness` [m], half of it on each side.
    pub fn new(surface: &'a TriMesh, thickness: f64) -> Self {
        Self { surface, tree: Distance::new(surface), half: thickness / 2.0, features: Features::default() }
    }
}

impl Solid for Shell<'_> {
    fn signed_distance(&self, p: DVec3, reach: f64) -> f64 {
        let far = reach + self.half;
        self.tree.closest_within(p, far).map_or(2.0 * far, |c| c.distance) - self.half
    }

    fn project(&self, p: DVec3) -> DVec3 {
        let mut q = p;
        for _ in 0..6 {
            let Some(c) = self.tree.closest(q) else { return q };
            if (c.distance - self.half).abs() < 1e-9 * self.half {
                break;
            }
            let away = if c.distance > 1e-9 * self.half {
                (q - c.point) / c.distance
            } else {
                let [a, b, d] = self.surface.corners(c.triangle as usize);
                (b - a).cross(d - a).normalize_or(DVec3::Z)
            };
            q = c.point + away * self.half;
        }
        q
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        let (lo, hi) = self.surface.bounds().unwrap_or((DVec3::ZERO, DVec3::ZERO));
        (lo - self.half, hi + self.half)
    }

    fn features(&self) -> &Features {
        &self.features
    }

    fn samples(&self, spacing: f64) -> Vec<(DVec3, DVec3)> {
        let both = |(p, n): (DVec3, DVec3)| [(p + n * self.half, n), (p - n * self.half, -n)];
        let sides: Vec<(DVec3, DVec3)> =
            scatter(self.surface, spacing).into_iter().filter(|s| s.1 != DVec3::ZERO).flat_map(both).collect();
        let keep = |p: &(DVec3, DVec3)| self.signed_distance(p.0, self.half) > -1e-6 * self.half;
        sides.into_par_iter().filter(keep).collect()
    }

    fn volume(&self) -> Option<f64> {
        None
    }

    fn euler(&self) -> Option<i64> {
        None
    }

    fn parts(&self) -> Option<usize> {
        None
    }
}

/// Number of connected pieces of a surface that enclose a positive volume: parts, but not cavities.
fn parts(surface: &TriMesh) -> usize {
    let mut root: Vec<u32> = (0..surface.vertices.len() as u32).collect();
    fn find(root: &mut [u32], mut v: u32) -> u32 {
        while root[v as usize] != v {
            root[v as usize] = root[root[v as usize] as usize];
            v = root[v as usize];
        }
        v
    }
    for t in &surface.triangles {
        for k in 1..3 {
            let (a, b) = (find(&mut root, t[0]), find(&mut root, t[k]));
            root[a.max(b) as usize] = a.min(b);
        }
    }
    let mut volume = vec![0.0; root.len()];
    for t in 0..surface.triangles.len() {
        let [a, b, c] = surface.corners(t);
        volume[find(&mut root, surface.triangles[t][0]) as usize] += a.dot(b.cross(c));
    }
    volume.iter().filter(|v| **v > 0.0).count().max(1)
}

/// Points spread over a surface with their normals: per triangle as many as its area asks for, stratified, at least one.
fn scatter(surface: &TriMesh, spacing: f64) -> Vec<(DVec3, DVec3)> {
    let mut out = Vec::new();
    for t in 0..surface.triangles.len() {
        let [a, b, c] = surface.corners(t);
        let cross = (b - a).cross(c - a);
        let normal = cross.normalize_or_zero();
        let count = (cross.length() / (spacing * spacing)).ceil().clamp(1.0, 1e6) as usize;
        let mut random = Random::of(t as u64, 7);
        let start = random.unit();
        for i in 0..count {
            // a rank-1 lattice (Roberts' R2) on the unit square, folded into the triangle
            let (u, v) =
                ((start + i as f64 * 0.754_877_666_246_693).fract(), (i as f64 * 0.569_840_290_998_053).fract());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            out.push((a + (b - a) * u + (c - a) * v, normal));
        }
        // sharp edges would be missed by points strictly inside
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let pieces = (p.distance(q) / spacing).ceil().clamp(1.0, 1e6) as usize;
            out.extend((1..pieces).map(|i| (p.lerp(q, i as f64 / pieces as f64), DVec3::ZERO)));
        }
    }
    out
}
