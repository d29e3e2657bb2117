//! Which tetrahedra lie around each vertex.

/// Compressed rows from vertices to their tetrahedra.
#[derive(Clone, Debug, Default)]
pub struct Stars {
    offsets: Vec<u32>,
    tets: Vec<u32>,
}

impl Stars {
    /// Those of tetrahedra whose vertices are all below `vertices`.
    pub fn of(vertices: usize, tets: &[[u32; 4]]) -> Self {
        let mut stars = Self::default();
        stars.fill(vertices, tets);
        stars
    }

    /// The same in place: allocates only if there is more than ever before.
    pub fn fill(&mut self, vertices: usize, tets: &[[u32; 4]]) {
        let Self { offsets, tets: around } = self;
        offsets.clear();
        offsets.resize(vertices + 2, 0);
        for &v in tets.iter().flatten() {
            offsets[v as usize + 2] += 1;
        }
        for v in 2..vertices + 2 {
            offsets[v] += offsets[v - 1];
        }
        around.resize(4 * tets.len(), 0);
        for (t, tet) in tets.iter().enumerate() {
            for &v in tet {
                let next = &mut offsets[v as usize + 1]; // the end of v's row, when all are in
                around[*next as usize] = t as u32;
                *next += 1;
            }
        }
        offsets.pop();
    }

    /// The tetrahedra of vertex `v`, ascending.
    pub fn around(&self, v: u32) -> &[u32] {
        &self.tets[self.offsets[v as usize] as usize..self.offsets[v as usize + 1] as usize]
    }

    /// Where the rows begin and the last one ends, and the rows.
    pub(super) fn into_rows(self) -> (Vec<u32>, Vec<u32>) {
        (self.offsets, self.tets)
    }
}
