//! Where cells are, as bits: how many lie in a cube, and in which cubes nothing is missing.

use fissure_engine::lattice::WHOLE;

use super::cells::Finest;

/// One bit for each place in the box of the cells, rows along x.
pub struct Presence {
    low: [u32; 3],
    size: [usize; 3],
    /// Words of 64 places per row.
    words: usize,
    bits: Vec<u64>,
}

impl Presence {
    /// Of all cells.
    pub fn new(finest: &Finest) -> Self {
        let (low, size) = finest.extent();
        let words = size[0].div_ceil(64);
        let mut bits = vec![0u64; words * size[1] * size[2]];
        for index in finest.index.iter() {
            let [x, y, z]: [usize; 3] = std::array::from_fn(|a| (index[a] - low[a]) as usize);
            bits[(z * size[1] + y) * words + x / 64] |= 1 << (x % 64);
        }
        Self { low, size, words, bits }
    }

    /// How many cells there are in the cube of half-width `w` around a place.
    pub fn around(&self, index: [u32; 3], w: u32) -> usize {
        let range = |a: usize| {
            let at = (index[a] - self.low[a]) as usize;
            at.saturating_sub(w as usize)..(at + w as usize + 1).min(self.size[a])
        };
        let (xs, ys, zs) = (range(0), range(1), range(2));
        let mut count = 0;
        for row in zs.flat_map(|z| ys.clone().map(move |y| z * self.size[1] + y)) {
            for word in xs.start / 64..=(xs.end - 1) / 64 {
                let from = xs.start.max(word * 64) - word * 64;
                let to = xs.end.min(word * 64 + 64) - word * 64;
                let mask = (u64::MAX >> (64 - (to - from))) << from;
                count += (self.bits[row * self.words + word] & mask).count_ones() as usize;
            }
        }
        count
    }
}

/// Which cells have all neighbours over `w` links, linked among each other: the region of such a cell is its cube.
pub fn inner(finest: &Finest, w: u32) -> Vec<bool> {
    let mut inner: Vec<bool> = finest.links.iter().map(|&l| l == WHOLE).collect();
    for _ in 1..w {
        let deeper = (0..finest.len()).map(|c| inner[c] && finest.linked(c).all(|(_, other)| inner[other]));
        inner = deeper.collect();
    }
    inner
}
