//! One of the two files, with the frozen columns that belong to it, and what they say about whose an element is.

use std::ops::Range;
use std::path::Path;

use fissure_engine::buffer::Element;
use fissure_engine::column::{Life, Of};
use glam::DVec3;

use super::{DiffError, Place};
use crate::checkpoint::{CheckpointError, FROZEN, Opened, Section};

/// Bonds of a chunk.
pub(super) const CHUNK: usize = 8;

/// A checkpoint, and the frozen columns of its run if they lie beside it.
#[derive(Debug)]
pub struct Side {
    pub(super) file: Opened,
    frozen: Option<Opened>,
    bodies: Vec<(String, Range<usize>)>,
}

impl Side {
    /// Opens a checkpoint. Beside a live file `frozen.fis` of the same folder is used to say whose its numbers are; without
    /// it they are known by their place in the column only.
    ///
    /// # Errors
    /// A file that is no checkpoint, or a damaged one.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, DiffError> {
        let file = Opened::open(&path)?;
        let beside = path.as_ref().with_file_name(FROZEN);
        let frozen = match file.life() {
            Life::Live if beside.is_file() => Some(Opened::open(beside)?).filter(|f| f.fingerprint() == file.frozen()),
            _ => None,
        };
        let mut side = Self { file, frozen, bodies: Vec::new() };
        let table = side.frozen.as_ref().unwrap_or(&side.file);
        let names = table.sections().iter().filter(|s| s.name == "range");
        let names: Vec<&str> = names.filter_map(|s| s.scope.strip_prefix("bodies/")).collect();
        let range = |name: &str| match side.column::<u64>(&format!("bodies/{name}"), "range") {
            Some([start, end]) => Some((name.to_owned(), *start as usize..*end as usize)),
            _ => None,
        };
        side.bodies = names.into_iter().filter_map(range).collect();
        Ok(side)
    }

    /// A column of the file or of its frozen columns; what is missing or has another type is none.
    pub(super) fn column<T: Element>(&self, scope: &str, name: &str) -> Option<&[T]> {
        let of = |file: &'_ Opened| file.find(scope, name).is_ok();
        let file = [Some(&self.file), self.frozen.as_ref()].into_iter().flatten().find(|f| of(f))?;
        file.column(scope, name).ok()
    }

    /// Bodies with their particles.
    pub(super) fn bodies(&self) -> &[(String, Range<usize>)] {
        &self.bodies
    }

    /// The body that a scope such as `bodies/vase/bonds` belongs to.
    pub(super) fn body_of(&self, scope: &str) -> Option<&(String, Range<usize>)> {
        let rest = scope.strip_prefix("bodies/")?;
        // a name may have a slash in it, so the longest that fits
        let fits = |name: &str| rest.strip_prefix(name).is_some_and(|r| r.is_empty() || r.starts_with('/'));
        self.bodies.iter().filter(|(name, _)| fits(name)).max_by_key(|(name, _)| name.len())
    }

    /// The particle that element `element` of a column belongs to.
    pub(super) fn particle_of(&self, section: &Section, element: u64) -> Option<usize> {
        let element = usize::try_from(element).ok()?;
        let body = self.body_of(&section.scope);
        let start = body.map_or(0, |(_, range)| range.start);
        match section.of {
            Of::Particle | Of::Row => Some(start + element),
            Of::Bond | Of::Chunk => {
                let chunk = if section.of == Of::Bond { element / CHUNK } else { element };
                let offsets = self.column::<u32>(&format!("bodies/{}/bonds", body?.0), "offsets")?;
                let after = offsets.partition_point(|&o| o as usize <= chunk);
                Some(start + after.checked_sub(1)?)
            }
            _ => None,
        }
    }

    /// Where element `element` of a column is.
    pub(super) fn place(&self, section: &Section, element: u64) -> Place {
        let particle = self.particle_of(section, element);
        let holds = |range: &Range<usize>| particle.is_some_and(|p| range.contains(&p));
        let body = self.body_of(&section.scope).or_else(|| self.bodies.iter().find(|(_, range)| holds(range)));
        let get = |i: usize| self.column::<u32>("particles", "id")?.get(i).copied();
        let position = |i: usize| self.column::<DVec3>("particles", "position")?.get(i).copied();
        Place {
            of: section.of,
            element,
            body: body.map(|(name, _)| name.clone()),
            particle: particle.and_then(get),
            position: particle.and_then(position),
        }
    }

    /// The file.
    pub fn file(&self) -> &Opened {
        &self.file
    }

    /// Checks every byte of the frozen columns that places are looked up in.
    pub(super) fn verify_frozen(&self) -> Result<(), CheckpointError> {
        self.frozen.as_ref().map_or(Ok(()), Opened::verify)
    }
}
