//! Sums over particles in parallel, with the same bits on any number of threads and without allocating.

use std::ops::Range;

/// Terms that one task adds up.
const BLOCK: usize = 1024;

/// Σ `term(i)` for `i` in `range`, `N` sums at once. The order of summation follows from the length of the range alone.
pub(crate) fn sum<const N: usize>(range: Range<usize>, term: &(impl Fn(usize) -> [f64; N] + Sync)) -> [f64; N] {
    let add = |a: [f64; N], b: [f64; N]| std::array::from_fn(|k| a[k] + b[k]);
    if range.len() <= BLOCK {
        return range.fold([0.0; N], |sum, i| add(sum, term(i)));
    }
    let middle = range.start + range.len() / 2;
    let (a, b) = rayon::join(|| sum(range.start..middle, term), || sum(middle..range.end, term));
    add(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_term_counts_once_and_threads_change_nothing() {
        let count = sum(3..5003, &|i| [1.0, i as f64]);
        assert_eq!(count, [5000.0, 5000.0 * 5005.0 / 2.0]);
        let rough = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| sum(0..70_001, &|i| [(i as f64).sin() * 1e3 + 0.1])[0].to_bits())
        };
        assert_eq!(rough(1), rough(3));
    }
}
