//! Names of fragments that last: the largest part of a fragment that splits keeps its id, the others get new ones.

use fissure_engine::buffer::Buffer;
use fissure_engine::column::{Column, Of, Visitor};

use super::Embedded;

/// Which fragment each tetrahedron or finest cell belongs to. Ids are numbered through all bodies: a whole body has its own
/// number, what breaks off gets the next one, and none is used twice.
#[derive(Default)]
pub(super) struct Pieces {
    /// For each body the id of each of its tetrahedra or cells.
    of: Vec<Buffer<u32>>,
    /// The next id; one element.
    next: Buffer<u32>,
}

/// A fragment as it is now.
#[derive(Clone, Copy)]
struct Part {
    mass: f64,
    first: usize,
    before: u32,
}

impl Pieces {
    /// Every body in one piece, with so many tetrahedra or cells.
    pub fn new(counts: impl IntoIterator<Item = usize>) -> Self {
        let of: Vec<_> = counts.into_iter().zip(0..).map(|(n, body)| vec![body; n].into()).collect();
        Self { next: vec![of.len() as u32].into(), of }
    }

    /// Of each tetrahedron or cell of body `k`, the id of its fragment as of the last update.
    pub fn of(&self, k: usize) -> &[u32] {
        &self.of[k]
    }

    /// Names the `count` fragments of body `k`, where `fragment` has the present one of each tetrahedron or cell and `mass` its
    /// mass [kg]. Of what had one id the heaviest keeps it, of equals the one with the lowest cell.
    pub fn update(&mut self, k: usize, fragment: &[u32], count: usize, mass: &[f64]) {
        let piece = self.of[k].to_mut();
        let mut parts = vec![Part { mass: 0.0, first: usize::MAX, before: 0 }; count];
        for (cell, (&f, &m)) in fragment.iter().zip(mass).enumerate() {
            let part = &mut parts[f as usize];
            if part.first == usize::MAX {
                (part.first, part.before) = (cell, piece[cell]);
            }
            part.mass += m;
        }
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_unstable_by(|&a, &b| {
            let (a, b) = (&parts[a], &parts[b]);
            a.before.cmp(&b.before).then(b.mass.total_cmp(&a.mass)).then(a.first.cmp(&b.first))
        });
        let mut id: Vec<u32> = parts.iter().map(|part| part.before).collect();
        let mut rest: Vec<usize> = Vec::new();
        for of_one in order.chunk_by(|&a, &b| parts[a].before == parts[b].before) {
            rest.extend(&of_one[1..]);
        }
        rest.sort_unstable_by_key(|&f| parts[f].first);
        let next = &mut self.next.to_mut()[0];
        for f in rest {
            id[f] = *next;
            *next += 1;
        }
        piece.iter_mut().zip(fragment).for_each(|(piece, &f)| *piece = id[f as usize]);
    }

    /// Whether restored columns fit the bodies.
    pub fn consistent(&self, meshes: &[Embedded]) -> bool {
        let counts = || meshes.iter().map(Embedded::cells_or_tets);
        // every id was given to somebody
        let most = counts().sum::<usize>().max(meshes.len());
        let known = |next: u32| self.of.iter().all(|of| of.iter().all(|&id| id < next));
        self.of.iter().map(|of| of.len()).eq(counts())
            && matches!(self.next[..], [next] if next as usize <= most && known(next))
    }

    /// Shows the columns of the bodies `names`.
    pub fn visit<'n>(&mut self, names: impl Iterator<Item = &'n str>, v: &mut Visitor<'_>) {
        for (name, of) in names.zip(&mut self.of) {
            v(&format!("bodies/{name}/fragments"), &PIECE, of);
        }
        v(SCOPE, &Column::live(NEXT, "1", Of::Thing), &mut self.next);
    }
}

/// Where the next id is; older checkpoints do not have it.
pub(super) const SCOPE: &str = "fragments";
pub(super) const NEXT: &str = "next_piece";
const PIECE: Column = Column::live("piece", "1", Of::Thing);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_heaviest_part_keeps_the_id_and_no_id_comes_twice() {
        let mut pieces = Pieces::new([6, 2]);
        assert_eq!((pieces.of(0), pieces.of(1)), (&[0; 6][..], &[1; 2][..]));
        let mass = [1.0, 1.0, 1.0, 1.0, 1.0, 4.0];
        pieces.update(0, &[0; 6], 1, &mass);
        assert_eq!(pieces.of(0), [0; 6]);
        // the last cell alone outweighs the first two, but not the middle
        pieces.update(0, &[2, 2, 0, 0, 0, 1], 3, &[1.0, 1.0, 2.0, 2.0, 2.0, 4.0]);
        assert_eq!(pieces.of(0), [2, 2, 0, 0, 0, 3]);
        // equal parts: the one with the lowest cell keeps it; numbering of the fragments does not matter
        pieces.update(1, &[1, 0], 2, &[1.0, 1.0]);
        assert_eq!(pieces.of(1), [1, 4]);
        pieces.update(0, &[3, 1, 2, 0, 0, 4], 5, &mass);
        assert_eq!(pieces.of(0), [2, 5, 6, 0, 0, 3]);
        let before = pieces.of(0).to_vec();
        pieces.update(0, &[3, 1, 2, 0, 0, 4], 5, &mass);
        assert_eq!(pieces.of(0), before, "nothing split, nothing changes");
    }
}
