//! Rows of families cut up for threads, and thinned out.

use std::ops::Range;

use fissure_engine::Families;
use rayon::prelude::*;

/// A bond that is to go.
const GONE: u32 = u32::MAX;

/// The part of `values` that belongs to each run of rows, the row of `i` being `end(i)..end(i + 1)`.
pub(super) fn split<'a>(
    mut values: &'a mut [u32],
    runs: &[Range<usize>],
    end: impl Fn(usize) -> usize,
) -> Vec<(Range<usize>, &'a mut [u32])> {
    let cut = |run: &Range<usize>| {
        let (part, rest) = std::mem::take(&mut values).split_at_mut(end(run.end) - end(run.start));
        values = rest;
        (run.clone(), part)
    };
    runs.iter().map(cut).collect()
}

/// Takes the bonds out of symmetric rows that `keeps` refuses. It is asked once for each bond, from its smaller end, as
/// it may walk far. Rows stay symmetric and ascend; no memory is needed but a number per row.
pub(super) fn retain(families: &mut Families, runs: &[Range<usize>], keeps: impl Fn(usize, usize) -> bool + Sync) {
    let Families { offsets, neighbours } = families;
    let ask = |(run, part): (Range<usize>, &mut [u32])| {
        let base = offsets[run.start];
        let mut lost = false;
        for i in run {
            for j in &mut part[(offsets[i] - base) as usize..(offsets[i + 1] - base) as usize] {
                if *j as usize > i && !keeps(i, *j as usize) {
                    (*j, lost) = (GONE, true);
                }
            }
        }
        lost
    };
    let parts = split(neighbours, runs, |i| offsets[i] as usize);
    if !parts.into_par_iter().map(ask).reduce(|| false, |a, b| a | b) {
        return;
    }
    // The other side: as rows ascend, those that name j do so in the order in which j's own row names them after j.
    let own = |i: usize| &neighbours[offsets[i] as usize..offsets[i + 1] as usize];
    let first = |i: usize| offsets[i] + own(i).partition_point(|&j| (j as usize) < i) as u32;
    let mut next: Vec<u32> = (0..offsets.len() - 1).into_par_iter().map(first).collect();
    for i in 0..next.len() {
        for k in offsets[i] as usize..next[i] as usize {
            let j = neighbours[k] as usize;
            if neighbours[next[j] as usize] == GONE {
                neighbours[k] = GONE;
            }
            next[j] += 1;
        }
    }
    let (mut end, mut start) = (0, 0);
    for i in 0..next.len() {
        let stop = offsets[i + 1] as usize;
        for k in start..stop {
            neighbours[end] = neighbours[k];
            end += usize::from(neighbours[k] != GONE);
        }
        (start, offsets[i + 1]) = (stop, end as u32);
    }
    neighbours.truncate(end);
    neighbours.shrink_to_fit();
}
