//! Which law and which criterion a chunk of bonds has: the one of the body, or those of the regions of its two sides.
//!
//! A chunk holds neighbours of one region only, so the choice costs nothing per bond; in a body of one region it is made
//! at compile time.

use std::marker::PhantomData;

use crate::buffer::Buffer;
use crate::column::{Column, Of, Visitor};
use crate::fracture::{Criterion, Opening};
use crate::lane::Lane;
use crate::law::BondLaw;

/// The regions of a body, empty where it has but one.
#[derive(Default)]
pub(super) struct Regions {
    /// Region of every particle.
    pub rows: Buffer<u8>,
    /// Region of the neighbours in every chunk.
    pub chunks: Buffer<u8>,
    /// Strength of the bonds between regions a and b, at a · count + b [1].
    pub strength: Vec<f64>,
}

impl Regions {
    pub fn visit(&mut self, scope: &str, v: &mut Visitor<'_>) {
        v(scope, &Column::frozen("region", "1", Of::Particle), &mut self.rows);
        v(scope, &Column::frozen("neighbour_region", "1", Of::Chunk), &mut self.chunks);
    }

    /// Whether the columns fit a body of `rows` and `chunks` with `count` regions.
    pub fn consistent(&self, rows: usize, chunks: usize, count: usize) -> bool {
        let known = |column: &[u8]| column.iter().all(|&r| usize::from(r) < count);
        self.rows.len() == rows && self.chunks.len() == chunks && known(&self.rows) && known(&self.chunks)
    }
}

/// The laws of a body.
pub(super) struct Laws<'a, T, const M: usize> {
    first: &'a T,
    all: &'a [T],
    regions: &'a Regions,
    /// Whether any of several reads Λ, and ω.
    cos: bool,
    influence: bool,
}

impl<T, const M: usize> Clone for Laws<'_, T, M> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T, const M: usize> Copy for Laws<'_, T, M> {}

impl<'a, T: BondLaw<M>, const M: usize> Laws<'a, T, M> {
    /// `all` has one law, or one per region.
    pub fn new(all: &'a [T], regions: &'a Regions) -> Self {
        let any = |needs: fn(&T) -> bool| T::SEVERAL && all.iter().any(needs);
        let (cos, influence) = (any(T::needs_cos), any(T::needs_influence));
        Self { first: &all[0], all, regions, cos, influence }
    }

    /// The law of row `i`.
    #[inline(always)]
    pub fn own(&self, i: usize) -> &'a T {
        if T::SEVERAL { &self.all[usize::from(self.regions.rows[i])] } else { self.first }
    }

    /// The law of the neighbours in `chunk` of a row whose law is `own`.
    #[inline(always)]
    pub fn other<'b>(&self, own: &'b T, chunk: usize) -> &'b T
    where
        'a: 'b,
    {
        if T::SEVERAL { &self.all[usize::from(self.regions.chunks[chunk])] } else { own }
    }

    /// A row of each law, the first of `rows` for which `fits` holds.
    pub fn examples(&self, rows: usize, fits: impl Fn(usize) -> bool) -> impl Iterator<Item = usize> {
        let mut found = vec![None; self.all.len()];
        for i in 0..rows {
            let region = if T::SEVERAL { usize::from(self.regions.rows[i]) } else { 0 };
            if found[region].is_none() && fits(i) {
                found[region] = Some(i);
                if !found.contains(&None) {
                    break;
                }
            }
        }
        found.into_iter().flatten()
    }

    /// Whether any of them reads [`Bond::cos`](crate::Bond::cos).
    #[inline(always)]
    pub fn needs_cos(&self) -> bool {
        if T::SEVERAL { self.cos } else { self.first.needs_cos() }
    }

    /// Whether any of them reads [`Bond::influence`](crate::Bond::influence).
    #[inline(always)]
    pub fn needs_influence(&self) -> bool {
        if T::SEVERAL { self.influence } else { self.first.needs_influence() }
    }
}

/// The criteria of a body whose laws are `T`.
pub(super) struct Criteria<'a, T, C, const M: usize> {
    first: &'a C,
    all: &'a [C],
    regions: &'a Regions,
    laws: PhantomData<T>,
}

impl<T, C, const M: usize> Clone for Criteria<'_, T, C, M> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T, C, const M: usize> Copy for Criteria<'_, T, C, M> {}

impl<'a, T: BondLaw<M>, C: Criterion, const M: usize> Criteria<'a, T, C, M> {
    /// `all` has one criterion, or one per region.
    pub fn new(all: &'a [C], regions: &'a Regions) -> Self {
        Self { first: &all[0], all, regions, laws: PhantomData }
    }

    /// Criteria of both sides and the strength of the bonds between them, where that is more than a single criterion.
    #[inline(always)]
    fn both(&self, i: usize, chunk: usize) -> Result<(&'a C, &'a C, f64), &'a C> {
        if !T::SEVERAL {
            return Err(self.first);
        }
        let [a, b] = [self.regions.rows[i], self.regions.chunks[chunk]].map(usize::from);
        if a == b {
            Err(&self.all[a])
        } else {
            Ok((&self.all[a], &self.all[b], self.regions.strength[a * self.all.len() + b]))
        }
    }

    /// How close to breaking; `sides` are the bonds as measured by the law of either side.
    #[inline(always)]
    pub fn severity<L: Lane>(&self, i: usize, chunk: usize, sides: &[Opening<L>; 2], damage: L) -> L {
        match self.both(i, chunk) {
            Err(one) => one.severity(&sides[0], damage),
            Ok((a, b, strength)) => a.severity(&sides[0], damage).max(b.severity(&sides[1], damage)) / L::of(strength),
        }
    }

    /// Those that may break.
    #[inline(always)]
    pub fn suspects<L: Lane>(&self, i: usize, chunk: usize, sides: &[Opening<L>; 2]) -> L::Mask {
        match self.both(i, chunk) {
            Err(one) => one.suspects(&sides[0]),
            Ok(_) => {
                let at = |damage: f64| self.severity(i, chunk, sides, L::of(damage));
                at(0.0).max(at(1.0)).above(L::of(1.0))
            }
        }
    }
}
