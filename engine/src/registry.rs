//! The visible list of materials: a word in a scene file to a built material.

use crate::erased::Part;
use crate::fracture::{Bulk, Criterion, CriticalStretch, EnergyRelease, TensionShear, Unbreakable};
use crate::law::{BondLaw, Surroundings};
use crate::material::Material;
use crate::params::{ParamError, Parameter, Params, Value, hint};
use crate::peridynamic::Peridynamic;

/// What geometry a material is built from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wants {
    /// Particles with families within a horizon.
    Bonds,
    /// Particles with the cells of a lattice.
    Cells,
}

/// Makes a material from the parameters of law and criterion.
pub type Make = fn(&Params, &Params, &Surroundings) -> Result<Box<dyn Material>, ParamError>;
/// Makes a region's share of a material.
type MakePart = fn(&Params, &Params, &Surroundings) -> Result<Part, ParamError>;

/// A criterion registered beside a law.
#[derive(Clone)]
pub struct CriterionEntry {
    /// The word in scene files.
    pub name: &'static str,
    /// One line of help.
    pub summary: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    make: Make,
    pub(crate) part: MakePart,
}

impl CriterionEntry {
    /// A criterion of a material that is no bond law: `make` gets the parameters of the material and of the criterion.
    pub fn whole(name: &'static str, summary: &'static str, parameters: &'static [Parameter], make: Make) -> Self {
        let part: MakePart = |_, _, _| {
            let message = "this material makes whole bodies, and cannot be one of several in a body";
            Err(ParamError::new("law", message.into()))
        };
        Self { name, summary, parameters, make, part }
    }
}

/// A registered material.
#[derive(Clone)]
pub struct Entry {
    /// The word in scene files.
    pub name: &'static str,
    /// One line of help.
    pub summary: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// The geometry it is built from.
    pub wants: Wants,
    /// The fracture criteria it can have.
    pub criteria: Vec<CriterionEntry>,
}

/// All materials that a program knows.
#[derive(Clone, Default)]
pub struct Registry {
    entries: Vec<Entry>,
}

impl Registry {
    /// Adds a bond law with every criterion of the engine. A law of the same name is replaced.
    pub fn bonds<T: BondLaw<M>, const M: usize>(self) -> Self {
        self.pair::<T, Unbreakable, M>()
            .pair::<T, CriticalStretch, M>()
            .pair::<T, EnergyRelease, M>()
            .pair::<T, TensionShear, M>()
    }

    /// Adds a bond law with one criterion, for criteria of your own.
    pub fn pair<T: BondLaw<M>, C: Criterion, const M: usize>(mut self) -> Self {
        let criterion = CriterionEntry {
            name: C::NAME,
            summary: C::SUMMARY,
            parameters: C::PARAMETERS,
            make: |law, criterion, at| {
                let (law, criterion) = read::<T, C, M>(law, criterion, at)?;
                Ok(Box::new(Peridynamic::new(law, criterion, at.horizon)))
            },
            part: |law, criterion, at| {
                let (law, criterion) = read::<T, C, M>(law, criterion, at)?;
                Ok(Part::new(law, criterion))
            },
        };
        let entry = match self.entries.iter().position(|e| e.name == T::NAME) {
            Some(k) => &mut self.entries[k],
            None => {
                self.entries.push(Entry {
                    name: T::NAME,
                    summary: T::SUMMARY,
                    parameters: T::PARAMETERS,
                    wants: Wants::Bonds,
                    criteria: Vec::new(),
                });
                self.entries.last_mut().expect("just pushed")
            }
        };
        entry.criteria.retain(|c| c.name != C::NAME);
        entry.criteria.push(criterion);
        self
    }

    /// Adds a material that is no bond law, with its criteria. One of the same name is replaced.
    pub fn whole(
        mut self,
        name: &'static str,
        summary: &'static str,
        parameters: &'static [Parameter],
        wants: Wants,
        criteria: Vec<CriterionEntry>,
    ) -> Self {
        self.entries.retain(|e| e.name != name);
        self.entries.push(Entry { name, summary, parameters, wants, criteria });
        self
    }

    /// All entries, in order of registration.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Those that are built from [bonds](Wants::Bonds), in order of registration.
    pub fn bond_laws(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter().filter(|e| e.wants == Wants::Bonds)
    }

    /// The entry called `name`.
    ///
    /// # Errors
    /// Unknown name: the nearest known one, or all.
    pub fn entry(&self, name: &str) -> Result<&Entry, ParamError> {
        let names: Vec<&str> = self.entries.iter().map(|e| e.name).collect();
        let unknown = || ParamError::new("law", format!("no material is called `{name}`{}", hint(name, &names)));
        self.entries.iter().find(|e| e.name == name).ok_or_else(unknown)
    }

    /// The law and the criterion beside it.
    pub(crate) fn find(&self, law: &str, criterion: &str) -> Result<(&Entry, &CriterionEntry), ParamError> {
        let entry = self.entry(law)?;
        let names: Vec<&str> = entry.criteria.iter().map(|c| c.name).collect();
        let unknown =
            || ParamError::new("criterion", format!("no criterion is called `{criterion}`{}", hint(criterion, &names)));
        let fracture = entry.criteria.iter().find(|c| c.name == criterion).ok_or_else(unknown)?;
        Ok((entry, fracture))
    }

    /// Makes the material `law` with fracture `criterion` from the values that a scene gives.
    ///
    /// # Errors
    /// Unknown names or keys, missing values, values out of range.
    pub fn make(
        &self,
        law: (&str, Vec<(String, Value)>),
        criterion: (&str, Vec<(String, Value)>),
        at: &Surroundings,
    ) -> Result<Box<dyn Material>, ParamError> {
        let (entry, fracture) = self.find(law.0, criterion.0)?;
        let law = Params::new(entry.parameters.to_vec(), law.1)?;
        let criterion = Params::new(fracture.parameters.to_vec(), criterion.1)?;
        (fracture.make)(&law, &criterion, at)
    }
}

fn read<T: BondLaw<M>, C: Criterion, const M: usize>(
    law: &Params,
    criterion: &Params,
    at: &Surroundings,
) -> Result<(T, C), ParamError> {
    let law = T::from_params(law, at)?;
    let criterion = C::from_params(criterion, at, &Bulk::of(&law, at.horizon))?;
    Ok((law, criterion))
}
