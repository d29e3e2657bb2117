//! A bounding volume hierarchy over triangle boxes, in f64 so that no box has to be rounded outwards.
//!
//! Halves the triangles at the median of the box centres along the longest axis, so it has depth log₂ n for any mesh;
//! a sweep along one axis was as fast on bunnies but quadratic on long strips, and obvhs keeps its boxes in f32.

use glam::DVec3;

use crate::TriMesh;

const LEAF: usize = 4;

/// An axis-aligned box.
#[derive(Clone, Copy)]
pub(super) struct Aabb {
    lo: DVec3,
    hi: DVec3,
}

impl Aabb {
    const EMPTY: Self = Self { lo: DVec3::INFINITY, hi: DVec3::NEG_INFINITY };

    fn join(self, o: Self) -> Self {
        Self { lo: self.lo.min(o.lo), hi: self.hi.max(o.hi) }
    }

    fn meets(&self, o: &Self) -> bool {
        self.lo.cmple(o.hi).all() && o.lo.cmple(self.hi).all()
    }
}

struct Node {
    aabb: Aabb,
    /// Leaf: first entry of `order` and count; inner node: index of the second child (the first follows) and 0.
    first: u32,
    count: u32,
}

/// The hierarchy over some triangles of a mesh.
pub(super) struct Bvh {
    nodes: Vec<Node>,
    order: Vec<u32>,
    boxes: Vec<Aabb>,
}

impl Bvh {
    /// Over the triangles `of` of the mesh.
    pub(super) fn new(mesh: &TriMesh, of: Vec<u32>) -> Self {
        let boxes = (0..mesh.triangles.len())
            .map(|t| {
                let [a, b, c] = mesh.corners(t);
                Aabb { lo: a.min(b).min(c), hi: a.max(b).max(c) }
            })
            .collect();
        let mut bvh = Self { nodes: Vec::with_capacity(of.len()), order: of, boxes };
        bvh.split(0, bvh.order.len());
        bvh
    }

    fn split(&mut self, start: usize, end: usize) {
        let boxes = &self.boxes;
        let aabb = self.order[start..end].iter().fold(Aabb::EMPTY, |all, &t| all.join(boxes[t as usize]));
        let node = self.nodes.len();
        self.nodes.push(Node { aabb, first: start as u32, count: (end - start) as u32 });
        if end - start <= LEAF {
            return;
        }
        let size = aabb.hi - aabb.lo;
        let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
        let middle = start + (end - start) / 2;
        let centre = |t: u32| boxes[t as usize].lo[axis] + boxes[t as usize].hi[axis];
        self.order[start..end]
            .select_nth_unstable_by(middle - start, |&s, &t| centre(s).total_cmp(&centre(t)).then(s.cmp(&t)));
        self.split(start, middle);
        self.nodes[node].first = self.nodes.len() as u32;
        self.nodes[node].count = 0;
        self.split(middle, end);
    }

    /// Calls `visit` for each triangle whose box meets the box of triangle `t`, itself included, in no given order.
    pub(super) fn for_each_near(&self, t: usize, mut visit: impl FnMut(u32)) {
        let query = self.boxes[t];
        let mut stack = vec![0_usize];
        while let Some(n) = stack.pop() {
            let node = &self.nodes[n];
            if !node.aabb.meets(&query) {
                continue;
            }
            if node.count == 0 && node.first != 0 {
                stack.extend([n + 1, node.first as usize]);
            } else {
                let leaf = &self.order[node.first as usize..(node.first + node.count) as usize];
                leaf.iter().filter(|&&s| self.boxes[s as usize].meets(&query)).for_each(|&s| visit(s));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_same_pairs_as_all_against_all() {
        let mesh = crate::shapes::cylinder(0.3, 2.0, 37).unwrap();
        let n = mesh.triangles.len();
        let bvh = Bvh::new(&mesh, (0..n as u32).collect());
        let mut pairs = 0;
        for t in 0..n {
            let mut found = Vec::new();
            bvh.for_each_near(t, |s| found.push(s));
            found.sort_unstable();
            let expected: Vec<u32> = (0..n).filter(|&s| bvh.boxes[s].meets(&bvh.boxes[t])).map(|s| s as u32).collect();
            assert_eq!(found, expected);
            pairs += found.len();
        }
        assert!(pairs > 4 * n && pairs < n * n, "{pairs} pairs of {n} triangles");
    }
}
