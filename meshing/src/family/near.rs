//! What lies near what: points near a point, points near a triangle, cut triangles near each point.

use glam::DVec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use super::triangle::{crosses, distance};
use super::{FamilyError, MARGIN};

/// The k-d tree of this module.
pub(super) type Tree = ImmutableKdTree<f64, 3>;

/// Particles within `radius` of `center`, with squared distances: all of them, and perhaps some a rounding farther.
pub(super) fn visit_ball(tree: &Tree, center: DVec3, radius: f64, mut visit: impl FnMut(u32, f64)) {
    let reach = radius * radius * (1.0 + MARGIN);
    tree.query(&center.to_array())
        .within::<SquaredEuclidean<f64>>(reach)
        .unsorted()
        .visit(|found| visit(found.item, found.distance));
}

pub(super) fn build_tree(points: &[DVec3]) -> Result<Tree, FamilyError> {
    if let Some(index) = points.iter().position(|p| !p.is_finite()) {
        return Err(FamilyError::NotFinite { index, position: points[index] });
    }
    let arrays: Vec<[f64; 3]> = points.iter().map(|p| p.to_array()).collect();
    Tree::new_from_slice(&arrays).map_err(|e| FamilyError::Tree(e.to_string()))
}

/// Distance from particle `i` to the nearest other one [m].
pub(super) fn nearest(tree: &Tree, points: &[DVec3], i: usize) -> f64 {
    let two = std::num::NonZeroUsize::new(2).expect("2 is not 0");
    let found = tree.query(&points[i].to_array()).nearest_n::<SquaredEuclidean<f64>>(two).execute();
    let other = found.iter().filter(|f| f.item as usize != i).map(|f| f.distance);
    other.fold(f64::INFINITY, f64::min).sqrt()
}

/// Which cut triangles lie near which point: CSR rows.
pub(super) struct Near {
    offsets: Vec<u32>,
    triangles: Vec<u32>,
}

impl Near {
    pub(super) fn new(cuts: &[[DVec3; 3]], tree: &Tree, points: &[DVec3], reach: f64) -> Self {
        if cuts.is_empty() {
            return Self { offsets: Vec::new(), triangles: Vec::new() };
        }
        let mut pairs: Vec<(u32, u32)> = cuts
            .par_iter()
            .enumerate()
            .flat_map_iter(|(c, cut)| {
                let mut near = Vec::new();
                visit_near(cut, tree, points, reach, |p, _| near.push((p, c as u32)));
                near
            })
            .collect();
        pairs.par_sort_unstable();
        let mut offsets = vec![0; points.len() + 1];
        for &(p, _) in &pairs {
            offsets[p as usize + 1] += 1;
        }
        for p in 0..points.len() {
            offsets[p + 1] += offsets[p];
        }
        Self { offsets, triangles: pairs.into_iter().map(|(_, c)| c).collect() }
    }

    /// Whether a cut crosses the segment from point `i` to point `j`, which is no longer than the reach.
    pub(super) fn cut(&self, cuts: &[[DVec3; 3]], points: &[DVec3], i: usize, j: usize) -> bool {
        if cuts.is_empty() {
            return false;
        }
        let near = &self.triangles[self.offsets[i] as usize..self.offsets[i + 1] as usize];
        near.iter().any(|&c| crosses(points[i], points[j], cuts[c as usize]))
    }
}

/// Visits all points within `reach` of the triangle, with their distances.
pub(super) fn visit_near(
    face: &[DVec3; 3],
    tree: &Tree,
    points: &[DVec3],
    reach: f64,
    mut visit: impl FnMut(u32, f64),
) {
    let middle = (face[0] + face[1] + face[2]) / 3.0;
    let radius = face.iter().map(|v| v.distance(middle)).fold(0.0, f64::max);
    visit_ball(tree, middle, radius + reach, |p, _| {
        let d = distance(points[p as usize], *face);
        if d <= reach * (1.0 + 1e-9) {
            visit(p, d);
        }
    });
}
