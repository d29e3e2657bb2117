//! Handing an open checkpoint to a run, without copying: frozen columns shared, live ones copy-on-write.

use std::sync::Arc;

use fissure_engine::buffer::{AnyBuffer, Owner};
use fissure_engine::column::{Column, Life};
use memmap2::MmapOptions;

use super::format::type_name;
use super::{CheckpointError, Columns, Opened, label};

impl Opened {
    /// Maps every column of this live file and of its `frozen` file into `target`. The checksums of both are
    /// verified first, unless that was done or they are [trusted](Self::trust). The target's columns keep the maps
    /// alive; writing to a live one changes neither file.
    ///
    /// # Errors
    /// If the files do not belong together or are damaged, or if columns and target do not match one to one in name,
    /// type and unit; only [late](Column::late) columns may be missing. The target is unchanged then.
    pub fn restore(&self, target: &mut dyn Columns, frozen: &Opened) -> Result<(), CheckpointError> {
        self.belongs_to(frozen)?;
        let mut check = Matching::new(self, frozen);
        visit(target, &mut |scope, column, buffer| check.section(scope, column, buffer).map(|_| ()))?;
        check.all_used()?;
        frozen.verify_once()?;
        self.verify_once()?;

        // SAFETY: the map is private; the file's own bytes do not change (see the module).
        let map = unsafe { MmapOptions::new().len(self.map.len()).map_copy(&self.file) };
        let mut map = map.map_err(CheckpointError::io("map", &self.path))?;
        let live_start = map.as_mut_ptr();
        let live_owner: Owner = Arc::new(map);
        let frozen_start = frozen.map.as_ptr().cast_mut();
        let frozen_owner: Owner = frozen.map.clone();

        let mut place = Matching::new(self, frozen);
        visit(target, &mut |scope, column, buffer| {
            let Some((file, at)) = place.section(scope, column, buffer)? else { return Ok(()) };
            let section = &file.sections()[at];
            let (start, private, owner) = match column.life {
                Life::Frozen => (frozen_start, false, frozen_owner.clone()),
                Life::Live => (live_start, true, live_owner.clone()),
            };
            // SAFETY: the table was checked against the length of the map, so the section lies inside it. `place`
            // gives each section once and sections don't overlap, so nobody else has a view of the private bytes.
            let fits = unsafe { buffer.set_mapped(start.add(section.offset), section.length, private, owner) };
            if fits { Ok(()) } else { Err(place.wrong_type(scope, column, buffer, file, at)) }
        })
    }
}

type See<'s> = dyn FnMut(&str, &Column, &mut dyn AnyBuffer) -> Result<(), CheckpointError> + 's;

/// Visits until the first error.
fn visit(target: &mut dyn Columns, see: &mut See<'_>) -> Result<(), CheckpointError> {
    let mut result = Ok(());
    target.visit(&mut |scope, column, buffer| {
        if result.is_ok() {
            result = see(scope, column, buffer);
        }
    });
    result
}

/// Pairs a target's columns with the sections of two files, each once.
struct Matching<'f> {
    live: &'f Opened,
    frozen: &'f Opened,
    live_used: Vec<bool>,
    frozen_used: Vec<bool>,
}

impl<'f> Matching<'f> {
    fn new(live: &'f Opened, frozen: &'f Opened) -> Self {
        let unused = |file: &Opened| vec![false; file.sections().len()];
        Self { live, frozen, live_used: unused(live), frozen_used: unused(frozen) }
    }

    /// The file and section of a column; none where an earlier version did without it.
    fn section(
        &mut self,
        scope: &str,
        column: &Column,
        buffer: &dyn AnyBuffer,
    ) -> Result<Option<(&'f Opened, usize)>, CheckpointError> {
        let (file, used) = match column.life {
            Life::Frozen => (self.frozen, &mut self.frozen_used),
            Life::Live => (self.live, &mut self.live_used),
        };
        let at = match file.find(scope, column.name) {
            Err(CheckpointError::NoColumn { .. }) if column.late => return Ok(None),
            found => found?,
        };
        if std::mem::replace(&mut used[at], true) {
            return Err(CheckpointError::Duplicate { path: file.path.clone(), column: label(scope, column.name) });
        }
        let section = &file.sections()[at];
        if (section.dtype, section.width, section.unit.as_str()) != (buffer.dtype(), buffer.width(), column.unit) {
            return Err(self.wrong_type(scope, column, buffer, file, at));
        }
        Ok(Some((file, at)))
    }

    fn wrong_type(
        &self,
        scope: &str,
        column: &Column,
        buffer: &dyn AnyBuffer,
        file: &Opened,
        at: usize,
    ) -> CheckpointError {
        let section = &file.sections()[at];
        CheckpointError::WrongType {
            path: file.path.clone(),
            column: label(scope, column.name),
            expected: type_name(buffer.dtype(), buffer.width(), column.unit),
            found: type_name(section.dtype, section.width, &section.unit),
        }
    }

    /// Refuses sections that no column asked for.
    fn all_used(&self) -> Result<(), CheckpointError> {
        for (file, used) in [(self.frozen, &self.frozen_used), (self.live, &self.live_used)] {
            if let Some(at) = used.iter().position(|used| !used) {
                let column = file.sections()[at].label();
                return Err(CheckpointError::Unused { path: file.path.clone(), column });
            }
        }
        Ok(())
    }
}
