//! Bodies of several materials: regions with a law and a criterion each, and how strong the bonds between them are.
//!
//! A bond between two regions carries half of the force that each law asks for, as every bond does from its two sides; its
//! influence is the mean of both laws'. It breaks where the more severe of both criteria says so, at a share of that: the
//! strength of the interface. All laws of a body share the horizon. Surfaces are compensated
//! ([`BondLaw::compensates_surface`](crate::BondLaw::compensates_surface)) if every law asks for it: the factor belongs to the
//! whole body's geometry.

use crate::erased::{AnyCriterion, AnyLaw, MOST_MEMORY, Part};
use crate::law::Surroundings;
use crate::material::Material;
use crate::params::{ParamError, Params, Value};
use crate::peridynamic::Peridynamic;
use crate::registry::Registry;

/// A name with the values that a scene gives.
pub type Chosen<'a> = (&'a str, Vec<(String, Value)>);

/// How strong the bonds between regions are: 1 as the weaker of the two materials, 0.2 a fifth of it. Above 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Interface {
    /// Between any two regions [1].
    pub strength: f64,
    /// Between these two instead [1].
    pub pairs: Vec<(usize, usize, f64)>,
}

impl Default for Interface {
    fn default() -> Self {
        Self { strength: 1.0, pairs: Vec::new() }
    }
}

impl Interface {
    /// Strength at a · count + b.
    fn table(&self, count: usize) -> Vec<f64> {
        let mut table = vec![self.strength; count * count];
        for &(a, b, strength) in &self.pairs {
            (table[a * count + b], table[b * count + a]) = (strength, strength);
        }
        table
    }
}

impl Registry {
    /// Makes the material of a body in regions: law and criterion of each, and the region of every particle (none for a
    /// body that is restored: the columns have it).
    ///
    /// # Errors
    /// As [`make`](Self::make), with the number of the region concerned.
    ///
    /// # Panics
    /// If there is no region, a particle is in one that does not exist, or the interface names one.
    pub fn several(
        &self,
        parts: &[(Chosen<'_>, Chosen<'_>)],
        interface: &Interface,
        regions: Vec<u8>,
        at: &Surroundings,
    ) -> Result<Box<dyn Material>, (usize, ParamError)> {
        assert!(regions.iter().all(|&r| usize::from(r) < parts.len()), "a particle is in a region that does not exist");
        let strength = interface.table(parts.len());
        let make = |(k, (law, criterion)): (usize, &(Chosen<'_>, Chosen<'_>))| {
            let (entry, fracture) = self.find(law.0, criterion.0).map_err(|e| (k, e))?;
            let params = Params::new(entry.parameters.to_vec(), law.1.clone()).map_err(|e| (k, e))?;
            let limits = Params::new(fracture.parameters.to_vec(), criterion.1.clone()).map_err(|e| (k, e))?;
            (fracture.part)(&params, &limits, at).map_err(|e| (k, e))
        };
        let parts = parts.iter().enumerate().map(make).collect::<Result<Vec<Part>, _>>()?;
        let memory = parts.iter().map(|p| p.law.memory()).enumerate().max_by_key(|(_, m)| *m);
        let h = at.horizon;
        let family = parts.iter().any(|p| p.law.counts_as_a_family());
        Ok(match (memory.expect("a body has a region"), family) {
            ((_, 0), false) => several::<0, false>(parts, strength, regions, h),
            ((_, 1), false) => several::<1, false>(parts, strength, regions, h),
            ((_, 2), false) => several::<2, false>(parts, strength, regions, h),
            ((_, 3..=MOST_MEMORY), false) => several::<MOST_MEMORY, false>(parts, strength, regions, h),
            ((_, 0..=1), true) => several::<1, true>(parts, strength, regions, h),
            ((_, 2..=MOST_MEMORY), true) => several::<MOST_MEMORY, true>(parts, strength, regions, h),
            ((k, m), _) => {
                let message = format!(
                    "a law that remembers {m} numbers per bond cannot be in a body of several regions; at most {MOST_MEMORY}"
                );
                return Err((k, ParamError::new("law", message)));
            }
        })
    }
}

fn several<const M: usize, const FAMILY: bool>(
    parts: Vec<Part>,
    strength: Vec<f64>,
    regions: Vec<u8>,
    horizon: f64,
) -> Box<dyn Material> {
    let (laws, criteria) = parts.into_iter().map(|p| (AnyLaw::<M, FAMILY>(p.law), AnyCriterion(p.criterion))).unzip();
    Box::new(Peridynamic::<AnyLaw<M, FAMILY>, AnyCriterion, M>::several(laws, criteria, strength, regions, horizon))
}
