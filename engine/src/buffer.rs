//! The storage behind every column: a plain vector, or a slice of a mapped file.
//!
//! A restart hands mapped memory to the engine without copying it: frozen columns map shared and read-only, live
//! ones copy-on-write. Both look like a slice from here on, and nothing else in the engine knows the difference.
//!
//! This is the only file of the engine with `unsafe` for storage; its invariants are stated at `Mapped`.
//! Miri finds nothing in it, nor in the gathering of `peridynamic/pose.rs`; it knows no mapped files, so not in `io`'s checkpoints:
//! `cargo +nightly miri test -p fissure-engine --lib -- buffer pose` (components `miri` and `rust-src`).

use std::any::Any;
use std::fmt;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use bytemuck::Pod;

use crate::column::DType;

/// A plain number type that a column may hold, with its name in files.
pub trait Element: Pod + Send + Sync + fmt::Debug + PartialEq + 'static {
    /// How files and messages call this type.
    const DTYPE: DType;
    /// Numbers per element: 1, or 3 for a vector.
    const WIDTH: usize;
}

macro_rules! element {
    ($($type:ty => $dtype:ident, $width:literal;)*) => {
        $(impl Element for $type {
            const DTYPE: DType = DType::$dtype;
            const WIDTH: usize = $width;
        })*
    };
}
element! {
    u8 => U8, 1; u32 => U32, 1; u64 => U64, 1; f32 => F32, 1; f64 => F64, 1;
    [u32; 3] => U32, 3; [u32; 4] => U32, 4; [f32; 4] => F32, 4; glam::Vec3 => F32, 3; glam::DVec3 => F64, 3;
}

/// Memory that outlives the slices taken from it: in practice a memory map.
pub type Owner = Arc<dyn Any + Send + Sync>;

/// Mapped memory. Invariants, promised by the caller of [`Buffer::from_shared`] and [`Buffer::from_private`]: `ptr`
/// is aligned for `T` and valid for `len` elements for as long as `owner` lives, the bytes do not change behind our
/// back, and if `writable` nobody else reads or writes them.
struct Mapped<T> {
    ptr: *mut T,
    len: usize,
    writable: bool,
    _owner: Owner,
}

enum Storage<T> {
    Owned(Vec<T>),
    Mapped(Mapped<T>),
}

/// A column's elements. Reads and writes like a slice; growing or replacing goes through [`Buffer::set`].
pub struct Buffer<T> {
    storage: Storage<T>,
}

// SAFETY: `Mapped` is an exclusive or read-only view of memory owned by a `Send + Sync` owner, and `T` is plain data.
unsafe impl<T: Send> Send for Buffer<T> {}
// SAFETY: as above; shared access only reads.
unsafe impl<T: Sync> Sync for Buffer<T> {}

impl<T: Element> Buffer<T> {
    /// A buffer of its own memory.
    pub fn new(values: Vec<T>) -> Self {
        Self { storage: Storage::Owned(values) }
    }

    /// Read-only mapped memory; the first write copies it into memory of its own.
    ///
    /// # Safety
    /// `ptr` must be aligned for `T` and valid for reads of `len` elements while `owner` lives, and nothing may
    /// change those bytes meanwhile.
    pub unsafe fn from_shared(ptr: *const T, len: usize, owner: Owner) -> Self {
        Self { storage: Storage::Mapped(Mapped { ptr: ptr.cast_mut(), len, writable: false, _owner: owner }) }
    }

    /// Private (copy-on-write) mapped memory, written in place.
    ///
    /// # Safety
    /// As [`Buffer::from_shared`], and `ptr` must be valid for writes with nobody else holding a view of it.
    pub unsafe fn from_private(ptr: *mut T, len: usize, owner: Owner) -> Self {
        Self { storage: Storage::Mapped(Mapped { ptr, len, writable: true, _owner: owner }) }
    }

    /// Replaces all elements.
    pub fn set(&mut self, values: Vec<T>) {
        self.storage = Storage::Owned(values);
    }

    /// The vector behind the column, for growing it; mapped memory is copied first.
    pub fn to_mut(&mut self) -> &mut Vec<T> {
        if let Storage::Mapped(_) = self.storage {
            self.storage = Storage::Owned(self.to_vec());
        }
        match &mut self.storage {
            Storage::Owned(values) => values,
            Storage::Mapped(_) => unreachable!("just made owned"),
        }
    }

    /// Whether the elements lie in a mapped file.
    pub fn is_mapped(&self) -> bool {
        matches!(self.storage, Storage::Mapped(_))
    }
}

impl<T: Element> Deref for Buffer<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        match &self.storage {
            Storage::Owned(values) => values,
            // SAFETY: the invariants of `Mapped`.
            Storage::Mapped(m) => unsafe { std::slice::from_raw_parts(m.ptr, m.len) },
        }
    }
}

impl<T: Element> DerefMut for Buffer<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        if let Storage::Mapped(Mapped { writable: false, .. }) = &self.storage {
            self.to_mut();
        }
        match &mut self.storage {
            Storage::Owned(values) => values,
            // SAFETY: the invariants of `Mapped`; `writable` was checked above.
            Storage::Mapped(m) => unsafe { std::slice::from_raw_parts_mut(m.ptr, m.len) },
        }
    }
}

impl<T: Element> Default for Buffer<T> {
    fn default() -> Self {
        Self::new(Vec::new())
    }
}

impl<T: Element> From<Vec<T>> for Buffer<T> {
    fn from(values: Vec<T>) -> Self {
        Self::new(values)
    }
}

impl<T: Element> Clone for Buffer<T> {
    /// Always a copy in memory of its own.
    fn clone(&self) -> Self {
        Self::new(self.to_vec())
    }
}

impl<T: Element> fmt::Debug for Buffer<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

/// A [`Buffer`] whose element type is known at run time only: what savers, loaders and differs work on.
pub trait AnyBuffer {
    /// The number type of the elements.
    fn dtype(&self) -> DType;
    /// Numbers per element.
    fn width(&self) -> usize;
    /// Number of elements.
    fn count(&self) -> usize;
    /// The elements as bytes, in the machine's order (files are little-endian; so are all our targets).
    fn bytes(&self) -> &[u8];
    /// Replaces the elements by a copy of `bytes`. False if the length is no multiple of the element size.
    fn set_bytes(&mut self, bytes: &[u8]) -> bool;
    /// Replaces the elements by mapped memory, shared (copied on first write) or private (written in place).
    /// False, and nothing changes, if pointer or length do not fit the element type.
    ///
    /// # Safety
    /// As [`Buffer::from_shared`] or, with `private`, [`Buffer::from_private`], for `len` bytes at `ptr`.
    unsafe fn set_mapped(&mut self, ptr: *mut u8, len: usize, private: bool, owner: Owner) -> bool;
}

impl<T: Element> AnyBuffer for Buffer<T> {
    fn dtype(&self) -> DType {
        T::DTYPE
    }
    fn width(&self) -> usize {
        T::WIDTH
    }
    fn count(&self) -> usize {
        self.len()
    }
    fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(self)
    }
    fn set_bytes(&mut self, bytes: &[u8]) -> bool {
        let size = size_of::<T>();
        if !bytes.len().is_multiple_of(size) {
            return false;
        }
        let mut values = vec![T::zeroed(); bytes.len() / size];
        bytemuck::cast_slice_mut(&mut values).copy_from_slice(bytes);
        self.set(values);
        true
    }
    unsafe fn set_mapped(&mut self, ptr: *mut u8, len: usize, private: bool, owner: Owner) -> bool {
        let size = size_of::<T>();
        if !len.is_multiple_of(size) || !(ptr as usize).is_multiple_of(align_of::<T>()) {
            return false;
        }
        // SAFETY: passed on from the caller; alignment and length were just checked.
        *self = unsafe {
            if private {
                Self::from_private(ptr.cast(), len / size, owner)
            } else {
                Self::from_shared(ptr.cast(), len / size, owner)
            }
        };
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_memory_is_copied_on_the_first_write() {
        let owner = Arc::new(vec![1.0f64, 2.0, 3.0]);
        // SAFETY: the vector lives in `owner` and is never written.
        let mut shared = unsafe { Buffer::from_shared(owner.as_ptr(), 3, owner.clone()) };
        assert!(shared.is_mapped());
        shared[1] = 5.0;
        assert!(!shared.is_mapped());
        assert_eq!((&shared[..], &owner[..]), (&[1.0, 5.0, 3.0][..], &[1.0, 2.0, 3.0][..]));
    }

    #[test]
    fn wrong_lengths_are_refused() {
        let mut b = Buffer::new(vec![1u32, 2]);
        assert!(!b.set_bytes(&[0; 7]));
        assert_eq!(&b[..], &[1, 2]);
        assert!(b.set_bytes(&[1, 0, 0, 0]));
        assert_eq!(&b[..], &[1]);
    }
}
