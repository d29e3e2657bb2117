//! Rows in parallel: halving a body's rows until a block is small, with the columns that are written halved along.
//!
//! Rayon's iterators cut slices of equal length; a row's chunks have not. Halving by `join` needs no list of slices, so
//! a step allocates nothing.

use std::ops::Range;

/// Rows that one task works through; small enough to balance, large enough to forget the splitting.
const BLOCK: usize = 64;

/// What a block writes: halved with the rows.
pub(super) trait Halves: Sized + Send {
    /// The parts of rows `rows.start .. mid` and `mid .. rows.end`.
    fn halve(self, rows: &Range<usize>, mid: usize) -> (Self, Self);
}

/// Calls `run` with every block of rows and its part of `work`.
pub(super) fn in_blocks<W: Halves>(rows: Range<usize>, work: W, run: &(impl Fn(Range<usize>, W) + Sync)) {
    if rows.len() <= BLOCK {
        run(rows, work);
        return;
    }
    let mid = rows.start + (rows.len() / 2).next_multiple_of(BLOCK);
    let (first, second) = work.halve(&rows, mid);
    rayon::join(|| in_blocks(rows.start..mid, first, run), || in_blocks(mid..rows.end, second, run));
}

/// One element per row.
impl<T: Send> Halves for &mut [T] {
    fn halve(self, rows: &Range<usize>, mid: usize) -> (Self, Self) {
        self.split_at_mut(mid - rows.start)
    }
}

/// `PER` elements per chunk of the rows.
pub(super) struct PerChunk<'a, T, const PER: usize> {
    /// The elements of the rows.
    pub values: &'a mut [T],
    /// The offsets of all rows.
    pub offsets: &'a [u32],
}

impl<T: Send, const PER: usize> Halves for PerChunk<'_, T, PER> {
    fn halve(self, rows: &Range<usize>, mid: usize) -> (Self, Self) {
        let chunks = (self.offsets[mid] - self.offsets[rows.start]) as usize;
        let (a, b) = self.values.split_at_mut(chunks * PER);
        (Self { values: a, ..self }, Self { values: b, ..self })
    }
}

impl<A: Halves, B: Halves> Halves for (A, B) {
    fn halve(self, rows: &Range<usize>, mid: usize) -> (Self, Self) {
        let (a, b) = (self.0.halve(rows, mid), self.1.halve(rows, mid));
        ((a.0, b.0), (a.1, b.1))
    }
}

impl<W: Halves, const N: usize> Halves for [W; N] {
    fn halve(self, rows: &Range<usize>, mid: usize) -> (Self, Self) {
        let mut second = [const { None }; N];
        let mut k = 0;
        let first = self.map(|w| {
            let (a, b) = w.halve(rows, mid);
            second[k] = Some(b);
            k += 1;
            a
        });
        (first, second.map(|b| b.expect("one for each")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_and_its_chunks_are_visited_once() {
        let offsets: Vec<u32> = (0..=1000)
            .map(|i| i * (i % 3))
            .scan(0, |s, x| {
                *s += x % 5;
                Some(*s)
            })
            .collect();
        let base = offsets[0];
        let offsets: Vec<u32> = offsets.iter().map(|o| o - base).collect();
        let mut rows = vec![0u32; 1000];
        let mut chunks = vec![0u32; 2 * offsets[1000] as usize];
        let work = (&mut rows[..], [PerChunk::<_, 2> { values: &mut chunks, offsets: &offsets }]);
        in_blocks(0..1000, work, &|range, (rows, [chunks])| {
            assert_eq!(rows.len(), range.len());
            assert_eq!(chunks.values.len(), 2 * (offsets[range.end] - offsets[range.start]) as usize);
            for (row, i) in rows.iter_mut().zip(range.clone()) {
                *row += i as u32 + 1;
            }
            chunks.values.iter_mut().for_each(|c| *c += 1);
        });
        assert!(rows.iter().enumerate().all(|(i, &r)| r == i as u32 + 1));
        assert!(chunks.iter().all(|&c| c == 1));
    }
}
