//! Which particle and which bond slot of the second file is which of the first.

use std::collections::HashMap;
use std::ops::Range;

use super::side::{CHUNK, Side};

/// Particles of two files that lie in another order, matched by body and id.
pub(super) struct Matching {
    /// For every particle of the first file its place in the second.
    particle: Vec<u32>,
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

    /// Tells `see` every particle of a body, or of all: its element in the columns of both files. Says how many they are.
    pub fn particles(&self, bodies: Option<[&Range<usize>; 2]>, see: &mut dyn FnMut([u64; 2])) -> usize {
        let all = 0..self.particle.len();
        let [a, b] = bodies.unwrap_or([&all, &all]);
        a.clone().enumerate().for_each(|(k, i)| see([k as u64, u64::from(self.particle[i]) - b.start as u64]));
        a.len()
    }

    /// Tells `see` every bond of a body, as its slots in both files. Only a row is held at a time: all pairs together would
    /// be several times the column. Says no, perhaps after some of them, where the files have other bonds.
    pub fn bonds(
        &self,
        sides: [&Side; 2],
        name: &str,
        [a, b]: [&Range<usize>; 2],
        see: &mut dyn FnMut([u64; 2]),
    ) -> Option<()> {
        let scope = format!("bodies/{name}/bonds");
        let [offsets_a, offsets_b] = sides.map(|s| s.column::<u32>(&scope, "offsets"));
        let [near_a, near_b] = sides.map(|s| s.column::<u32>(&scope, "neighbours"));
        let (offsets_a, offsets_b, near_a, near_b) = (offsets_a?, offsets_b?, near_a?, near_b?);
        let slots =
            |offsets: &[u32], i: usize| Some(*offsets.get(i)? as usize * CHUNK..*offsets.get(i + 1)? as usize * CHUNK);
        let mut row = Vec::new();
        for i in 0..a.len() {
            let j = (self.particle[a.start + i] as usize).checked_sub(b.start)?;
            row.clear();
            for slot in slots(offsets_b, j)? {
                let end = *near_b.get(slot)?;
                if end as usize != j {
                    row.push((end, slot as u64)); // padding has the particle itself as neighbour
                }
            }
            row.sort_unstable();
            let mut met = 0;
            for slot in slots(offsets_a, i)? {
                let end = *near_a.get(slot)? as usize;
                if end != i {
                    let there = self.particle.get(a.start + end)?.checked_sub(b.start as u32)?;
                    let at = row.binary_search_by_key(&there, |&(end, _)| end).ok()?;
                    see([slot as u64, row[at].1]);
                    met += 1;
                }
            }
            if met != row.len() {
                return None;
            }
        }
        Some(())
    }
}
