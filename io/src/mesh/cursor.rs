//! A place in the bytes of a mesh file, from which words, lines, and text or binary numbers are read.
//!
//! Gmsh and VTK files start as text and go on as text or binary with the same fields; one cursor for both lets
//! each format describe its fields once. No count of a header is believed before it is held against the bytes left.
//! Line numbers are counted only when an error needs one.

use super::error::{MeshError, Place, Problem};
use super::scalar::{Endian, Scalar};
use std::path::Path;
use std::str::FromStr;

#[derive(Clone)]
pub(super) struct Cursor<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
    /// Start of what was read last: the place that errors name.
    mark: usize,
    /// Byte order of the numbers; `None` while they are text.
    pub(super) endian: Option<Endian>,
    /// The place that errors name instead, for bytes that are not the file's own (decoded arrays).
    fixed: Option<Place>,
}

impl<'a> Cursor<'a> {
    /// At the start of a file, reading text.
    pub(super) fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        Self { path, bytes, at: 0, mark: 0, endian: None, fixed: None }
    }

    /// At the start of numbers decoded from something at `place` of the file.
    pub(super) fn decoded(path: &'a Path, bytes: &'a [u8], endian: Option<Endian>, place: Place) -> Self {
        Self { path, bytes, at: 0, mark: 0, endian, fixed: Some(place) }
    }

    /// The file, for errors about the whole of it.
    pub(super) fn path(&self) -> &'a Path {
        self.path
    }

    /// Start of what was read last, to come back to with [`Self::marked`].
    pub(super) fn mark(&self) -> usize {
        self.mark
    }

    /// A cursor whose errors name the place `mark`.
    pub(super) fn marked(&self, mark: usize) -> Self {
        Self { mark, ..self.clone() }
    }

    /// The place of what was read last.
    pub(super) fn place(&self) -> Place {
        match (self.fixed, self.endian) {
            (Some(place), _) => place,
            (None, Some(_)) => Place::Byte(self.mark as u64),
            (None, None) => {
                Place::Line(1 + self.bytes[..self.mark].iter().map(|&c| u64::from(c == b'\n')).sum::<u64>())
            }
        }
    }

    pub(super) fn fail(&self, problem: Problem) -> MeshError {
        MeshError::content(self.path, self.place(), problem)
    }

    pub(super) fn unexpected(&self, expected: &str, found: &[u8]) -> MeshError {
        self.fail(Problem::Unexpected { expected: expected.into(), found: shorten(found) })
    }

    pub(super) fn truncated(&self, what: &str) -> MeshError {
        self.fail(Problem::Truncated { what: what.into() })
    }

    /// Bytes not yet read.
    pub(super) fn left(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// The next line without its end; `None` at the end of the file.
    pub(super) fn line(&mut self) -> Option<&'a [u8]> {
        let rest = self.left();
        if rest.is_empty() {
            return None;
        }
        self.mark = self.at;
        let end = rest.iter().position(|&c| c == b'\n');
        self.at += end.map_or(rest.len(), |e| e + 1);
        let line = &rest[..end.unwrap_or(rest.len())];
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    /// The next line that is not blank, without white space around it.
    pub(super) fn full_line(&mut self) -> Option<&'a [u8]> {
        loop {
            let line = self.line()?.trim_ascii();
            if !line.is_empty() {
                return Some(line);
            }
        }
    }

    /// The next word between white space; `what` names the thing being read, should the file end first.
    pub(super) fn word(&mut self, what: &str) -> Result<&'a [u8], MeshError> {
        let rest = self.left();
        let Some(start) = rest.iter().position(|c| !c.is_ascii_whitespace()) else {
            return Err(self.truncated(what));
        };
        let rest = &rest[start..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.mark = self.at + start;
        self.at = self.mark + end;
        Ok(&rest[..end])
    }

    /// The next `n` bytes.
    pub(super) fn take(&mut self, n: usize, what: &str) -> Result<&'a [u8], MeshError> {
        self.mark = self.at;
        let Some(taken) = self.left().get(..n) else { return Err(self.truncated(what)) };
        self.at += n;
        Ok(taken)
    }

    /// Skips `n` bytes, or to the end of the file.
    pub(super) fn skip(&mut self, n: usize) {
        self.at = self.bytes.len().min(self.at.saturating_add(n));
        self.mark = self.at;
    }

    /// Skips to the first `needle` from here on; false, staying here, if there is none.
    pub(super) fn skip_to(&mut self, needle: &[u8]) -> bool {
        let Some(found) = find(self.left(), needle) else { return false };
        self.skip(found);
        true
    }

    /// A number written as the next word.
    pub(super) fn parse<T: FromStr>(&mut self, what: &str) -> Result<T, MeshError> {
        let word = self.word(what)?;
        number(word).ok_or_else(|| self.unexpected(what, word))
    }

    /// The count `n` as a length, if so many things of at least `bytes_each` bytes can follow.
    pub(super) fn count(&self, n: u64, bytes_each: usize, what: &str) -> Result<usize, MeshError> {
        // The last word of a text needs no space after it: hence the one byte more.
        match usize::try_from(n).ok().filter(|n| {
            n.checked_mul(bytes_each).is_some_and(|need| need <= self.left().len().saturating_add(bytes_each))
        }) {
            Some(n) => Ok(n),
            None => Err(self.fail(Problem::TooMany { count: n, what: what.into() })),
        }
    }

    /// One integer: a word, or a binary number of type `scalar`.
    pub(super) fn int(&mut self, scalar: Scalar, what: &str) -> Result<i64, MeshError> {
        match self.endian {
            None => self.parse(what),
            Some(endian) => Ok(scalar.int(self.take(scalar.size(), what)?, endian)),
        }
    }

    /// One integer that counts things of at least `text` bytes each as words, `binary` bytes otherwise.
    pub(super) fn counted(&mut self, scalar: Scalar, each: [usize; 2], what: &str) -> Result<usize, MeshError> {
        let n = self.int(scalar, what)?;
        let each = if self.endian.is_none() { each[0] } else { each[1] };
        match u64::try_from(n) {
            Ok(n) => self.count(n, each, what),
            Err(_) => Err(self.unexpected(&format!("the number of {what}"), n.to_string().as_bytes())),
        }
    }

    /// One real number: a word, or a binary number of type `scalar`.
    pub(super) fn real(&mut self, scalar: Scalar, what: &str) -> Result<f64, MeshError> {
        match self.endian {
            None => self.parse(what),
            Some(endian) => Ok(scalar.real(self.take(scalar.size(), what)?, endian)),
        }
    }

    /// `n` integers.
    pub(super) fn ints(&mut self, scalar: Scalar, n: usize, what: &str) -> Result<Vec<i64>, MeshError> {
        match self.endian {
            None => (0..self.count(n as u64, 2, what)?).map(|_| self.parse(what)).collect(),
            Some(endian) => {
                let bytes = self.take(self.count(n as u64, scalar.size(), what)? * scalar.size(), what)?;
                Ok(bytes.chunks_exact(scalar.size()).map(|b| scalar.int(b, endian)).collect())
            }
        }
    }

    /// `n` real numbers.
    pub(super) fn reals(&mut self, scalar: Scalar, n: usize, what: &str) -> Result<Vec<f64>, MeshError> {
        match self.endian {
            None => (0..self.count(n as u64, 2, what)?).map(|_| self.parse(what)).collect(),
            Some(endian) => {
                let bytes = self.take(self.count(n as u64, scalar.size(), what)? * scalar.size(), what)?;
                Ok(bytes.chunks_exact(scalar.size()).map(|b| scalar.real(b, endian)).collect())
            }
        }
    }
}

/// The number that a word spells.
pub(super) fn number<T: FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Position of the first `needle` in `hay`.
pub(super) fn find(hay: &[u8], needle: &[u8]) -> Option<usize> {
    let first = *needle.first()?;
    let mut from = 0;
    while let Some(step) = hay[from..].iter().position(|&c| c == first) {
        from += step;
        if hay[from..].starts_with(needle) {
            return Some(from);
        }
        from += 1;
    }
    None
}

/// At most 40 printable characters of `bytes` for an error message.
pub(super) fn shorten(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]);
    let mut out: String = text.chars().take(40).map(|c| if c.is_control() { '?' } else { c }).collect();
    if text.chars().count() > 40 {
        out.push('…');
    }
    out
}
