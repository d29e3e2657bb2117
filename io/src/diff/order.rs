//! Which particle and which bond slot of the second file is which of the first.

use std::collections::HashMap;
use std::ops::Range;

use super::side::{CHUNK, Side};

/// Particles of two files that lie in another order, matched by body and id.
pub(super) struct Matching {
    /// For every particle of the first file its place in the second.
    particle: Vec<u32>,
}

/// How the elements of a column of the second file are found from those of the first.
pub(super) enum Elements {
    /// The element's place in the second column.
    Map(Vec<u64>),
    /// Pairs of slots that hold the same bond; padding is in none.
    Slots(Vec<[u64; 2]>),
}

impl Matching {
    /// None if the order is the same, unknown, or the particles are others.
    pub fn new(a: &Side, b: &Side) -> Option<Self> {
        let [of_a, of_b] = [a, b].map(|s| s.column::<u32>("particles", "id"));
        let (of_a, of_b) = (of_a?, of_b?);
        if of_a == of_b || of_a.len() != of_b.len() || a.bodies().len() != b.bodies().len() {
            return None;
        }
        let mut particle = vec![0; of_a.len()];
        for (name, range) in a.bodies() {
            let (_, other) = b.bodies().iter().find(|(n, r)| n == name && r.len() == range.len())?;
            let places: HashMap<u32, u32> =
                other.clone().map(|j| Some((*of_b.get(j)?, j as u32))).collect::<Option<_>>()?;
            for i in range.clone() {
                *particle.get_mut(i)? = *places.get(of_a.get(i)?)?;
            }
        }
        Some(Self { particle })
    }

    /// Elements per particle of a body, or of all.
    pub fn particles(&self, range: Option<[&Range<usize>; 2]>) -> Elements {
        match range {
            None => Elements::Map(self.particle.iter().map(|&j| j.into()).collect()),
            Some([a, b]) => {
                let local = |i: usize| u64::from(self.particle[i]) - b.start as u64;
                Elements::Map(a.clone().map(local).collect())
            }
        }
    }

    /// The slots of the bonds of a body, where both files have the same bonds.
    pub fn bonds(&self, sides: [&Side; 2], name: &str, [a, b]: [&Range<usize>; 2]) -> Option<Elements> {
        let scope = format!("bodies/{name}/bonds");
        let get = |s: &'_ Side| {
            Some((s.column::<u32>(&scope, "offsets")?.to_vec(), s.column::<u32>(&scope, "neighbours")?.to_vec()))
        };
        let ((offsets_a, near_a), (offsets_b, near_b)) = (get(sides[0])?, get(sides[1])?);
        let slots =
            |offsets: &[u32], i: usize| Some(*offsets.get(i)? as usize * CHUNK..*offsets.get(i + 1)? as usize * CHUNK);
        let (mut pairs, mut row) = (Vec::new(), Vec::new());
        for i in 0..a.len() {
            let j = (self.particle[a.start + i] as usize).checked_sub(b.start)?;
            row.clear();
            for slot in slots(&offsets_b, j)? {
                let end = *near_b.get(slot)?;
                if end as usize != j {
                    row.push((end, slot as u64)); // padding has the particle itself as neighbour
                }
            }
            row.sort_unstable();
            let before = pairs.len();
            for slot in slots(&offsets_a, i)? {
                let end = *near_a.get(slot)? as usize;
                if end != i {
                    let there = self.particle.get(a.start + end)?.checked_sub(b.start as u32)?;
                    let at = row.binary_search_by_key(&there, |&(end, _)| end).ok()?;
                    pairs.push([slot as u64, row[at].1]);
                }
            }
            if pairs.len() - before != row.len() {
                return None;
            }
        }
        Some(Elements::Slots(pairs))
    }
}
