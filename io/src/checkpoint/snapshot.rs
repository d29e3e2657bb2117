//! A copy of columns, so that a checkpoint is written behind the run's back: a step waits for one memory copy.

use fissure_engine::buffer::{AnyBuffer, Owner};
use fissure_engine::column::{Column, DType, Life, Visitor};

use super::Columns;

/// Columns as they were at one moment. Send it to a thread and give it to [`Store::write_live`](super::Store), then
/// [`take`](Self::take) the next one into the same memory.
#[derive(Debug, Default)]
pub struct Snapshot {
    columns: Vec<(String, Column, Bytes)>,
}

/// A column's bytes without its type's alignment; writers need no more.
#[derive(Debug)]
struct Bytes {
    dtype: DType,
    width: usize,
    count: usize,
    bytes: Vec<u8>,
}

impl Snapshot {
    /// Copies the columns of one life. Memory of an earlier snapshot is used again: with the same columns of the
    /// same lengths nothing is allocated.
    pub fn take(&mut self, source: &mut dyn Columns, life: Life) {
        let mut at = 0;
        source.visit(&mut |scope, column, buffer| {
            if column.life != life {
                return;
            }
            if at == self.columns.len() {
                let bytes = Bytes { dtype: buffer.dtype(), width: 0, count: 0, bytes: Vec::new() };
                self.columns.push((String::new(), *column, bytes));
            }
            let (to_scope, to_column, to) = &mut self.columns[at];
            to_scope.clear();
            to_scope.push_str(scope);
            *to_column = *column;
            (to.dtype, to.width, to.count) = (buffer.dtype(), buffer.width(), buffer.count());
            to.bytes.clear();
            to.bytes.extend_from_slice(buffer.bytes());
            at += 1;
        });
        self.columns.truncate(at);
    }
}

impl Columns for Snapshot {
    fn visit(&mut self, v: &mut Visitor<'_>) {
        for (scope, column, bytes) in &mut self.columns {
            v(scope, column, bytes);
        }
    }
}

impl AnyBuffer for Bytes {
    fn dtype(&self) -> DType {
        self.dtype
    }
    fn width(&self) -> usize {
        self.width
    }
    fn count(&self) -> usize {
        self.count
    }
    fn bytes(&self) -> &[u8] {
        &self.bytes
    }
    fn set_bytes(&mut self, bytes: &[u8]) -> bool {
        let size = self.dtype.size() * self.width;
        let fits = bytes.len().is_multiple_of(size);
        if fits {
            self.count = bytes.len() / size;
            self.bytes = bytes.to_vec();
        }
        fits
    }
    /// Never: a snapshot is its own memory, it is not restored into.
    unsafe fn set_mapped(&mut self, _: *mut u8, _: usize, _: bool, _: Owner) -> bool {
        false
    }
}
