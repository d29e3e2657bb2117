//! One winding for each connected piece of surface.
//!
//! Triangles joined by an edge with exactly two triangles belong to one piece, and the two must run along their edge in
//! opposite directions. A union-find with parity remembers for each triangle whether it must be turned relative to the
//! first triangle of its piece; a contradiction means that the piece is one-sided.

use glam::DVec3;

use super::edges::Edges;
use crate::TriMesh;

/// Pieces and what was turned.
pub(super) struct Winding {
    /// Piece of each triangle, numbered by first triangle.
    pub piece: Vec<u32>,
    /// Number of pieces.
    pub pieces: usize,
    /// Number of triangles turned to agree with the majority of their piece.
    pub turned: usize,
    /// Middle of the first edge where front and back meet, if any piece is one-sided.
    pub one_sided: Option<DVec3>,
}

/// Turns triangles so that each piece is wound consistently, as most of its triangles were.
pub(super) fn unify(mesh: &mut TriMesh, edges: &Edges) -> Winding {
    let mut forest = Forest((0..mesh.triangles.len() as u32).map(|t| (t, false)).collect());
    let mut one_sided = None;
    for sides in edges.iter() {
        let [s, t] = sides else { continue };
        let opposed = s.forward == t.forward;
        if !forest.join(s.triangle, t.triangle, opposed) && one_sided.is_none() {
            let [u, v] = s.edge.map(|v| mesh.vertices[v as usize]);
            one_sided = Some((u + v) / 2.0);
        }
    }
    let n = mesh.triangles.len();
    let mut piece = vec![u32::MAX; n];
    let mut votes: Vec<[usize; 2]> = Vec::new();
    let roots: Vec<(u32, bool)> = (0..n as u32).map(|t| forest.find(t)).collect();
    for (t, &(root, turned)) in roots.iter().enumerate() {
        if root as usize == t {
            piece[t] = votes.len() as u32;
            votes.push([0, 0]);
        }
        piece[t] = piece[root as usize];
        votes[piece[t] as usize][usize::from(turned)] += 1;
    }
    let mut turned = 0;
    for (t, &(_, differs)) in roots.iter().enumerate() {
        let [with_first, against] = votes[piece[t] as usize];
        if differs != (against > with_first) {
            mesh.triangles[t].swap(1, 2);
            turned += 1;
        }
    }
    Winding { piece, pieces: votes.len(), turned, one_sided }
}

/// Parent of each triangle and whether it is wound against its parent. Roots are the smallest of their tree, so a root
/// comes before all others in index order.
struct Forest(Vec<(u32, bool)>);

impl Forest {
    fn find(&mut self, t: u32) -> (u32, bool) {
        let (mut root, mut parity) = (t, false);
        while self.0[root as usize].0 != root {
            parity ^= self.0[root as usize].1;
            root = self.0[root as usize].0;
        }
        let found = (root, parity);
        let mut at = t;
        while at != root {
            let (next, step) = self.0[at as usize];
            self.0[at as usize] = (root, parity);
            parity ^= step;
            at = next;
        }
        found
    }

    /// Joins two trees; `false` if both were one tree already and this contradicts it.
    fn join(&mut self, s: u32, t: u32, opposed: bool) -> bool {
        let ((r, p), (q, o)) = (self.find(s), self.find(t));
        if r == q {
            return (p ^ o) == opposed;
        }
        let (low, high) = (r.min(q), r.max(q));
        self.0[high as usize] = (low, p ^ o ^ opposed);
        true
    }
}
