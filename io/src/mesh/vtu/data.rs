//! The numbers of one `DataArray`. Binary data is, after base64 if any,
//!
//! ```text
//! plain   length in bytes | data
//! zlib    number of blocks | bytes of a block | bytes of a shorter last block, or 0 | packed bytes of each | blocks
//! ```
//!
//! Base64 writers encode these parts one by one (VTK and meshio the zlib header) or together, so padding may stand in
//! the middle. Nothing is allocated from a length before as many bytes were seen.

use super::File;
use crate::mesh::cursor::Cursor;
use crate::mesh::error::{MeshError, Place, Problem};
use crate::mesh::scalar::Scalar;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;
use std::borrow::Cow;
use std::io::Read;

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Raw,
    Base64,
}

/// An array that is still encoded.
pub(super) enum Numbers<'a> {
    Text { file: &'a File<'a>, what: String, scalar: Scalar, text: &'a [u8], place: Place },
    Binary { file: &'a File<'a>, what: String, scalar: Scalar, source: &'a [u8], encoding: Encoding, place: Place },
}

impl Numbers<'_> {
    /// Exactly `n` real numbers.
    pub(super) fn reals(&self, n: usize) -> Result<Vec<f64>, MeshError> {
        self.values(n, |at, scalar, what| at.reals(scalar, n, what))
    }

    /// Exactly `n` integers.
    pub(super) fn ints(&self, n: usize) -> Result<Vec<i64>, MeshError> {
        self.values(n, |at, scalar, what| {
            if scalar.is_float() && at.endian.is_none() {
                return Ok(at.reals(scalar, n, what)?.into_iter().map(|v| v as i64).collect());
            }
            at.ints(scalar, n, what)
        })
    }

    fn values<T>(
        &self,
        n: usize,
        read: impl Fn(&mut Cursor, Scalar, &str) -> Result<T, MeshError>,
    ) -> Result<T, MeshError> {
        match self {
            Self::Text { file, what, scalar, text, place } => {
                read(&mut Cursor::decoded(file.path, text, None, *place), *scalar, what)
            }
            Self::Binary { file, what, scalar, source, encoding, place } => {
                let fail = |problem| MeshError::content(file.path, *place, problem);
                let bytes = file.unpack(source, *encoding, what, n * scalar.size()).map_err(fail)?;
                if bytes.len() != n * scalar.size() {
                    let found = (bytes.len() / scalar.size()) as u64;
                    return Err(fail(Problem::Length { what: what.clone(), expected: n as u64, found }));
                }
                read(&mut Cursor::decoded(file.path, &bytes, Some(file.endian), *place), *scalar, what)
            }
        }
    }
}

/// The first `need` bytes of `source`, decoded.
fn prefix<'a>(source: &'a [u8], encoding: Encoding, need: usize) -> Option<Cow<'a, [u8]>> {
    if encoding == Encoding::Raw {
        return source.get(..need).map(Cow::Borrowed);
    }
    let mut out = Vec::new();
    let mut quads = Vec::new();
    let mut characters = source.iter().copied().filter(|c| !c.is_ascii_whitespace());
    while out.len() < need {
        quads.clear();
        // Up to the next padding or to what is needed.
        while quads.len() / 4 * 3 < need - out.len() && quads.last() != Some(&b'=') {
            let before = quads.len();
            quads.extend(characters.by_ref().take(4));
            if quads.len() < before + 4 {
                return None;
            }
        }
        STANDARD.decode_vec(&quads, &mut out).ok()?;
    }
    out.truncate(need);
    Some(Cow::Owned(out))
}

impl File<'_> {
    /// The bytes of an array; packed ones only if their announced size is the `expected` one, so that a small file
    /// cannot unpack without end.
    fn unpack<'s>(
        &self,
        source: &'s [u8],
        encoding: Encoding,
        what: &str,
        expected: usize,
    ) -> Result<Cow<'s, [u8]>, Problem> {
        let truncated = || Problem::Truncated { what: format!("the data of {what}") };
        let size = self.header.size();
        let get = |need: usize| prefix(source, encoding, need).ok_or_else(truncated);
        let number = |bytes: &[u8], k: usize| self.header.int(&bytes[k * size..], self.endian);
        let first = number(&get(size)?, 0);
        // A length that does not fit the source would be refused by `prefix` too, but only after decoding it all.
        let first = usize::try_from(first).ok().filter(|&n| n <= source.len()).ok_or_else(truncated)?;
        if !self.zlib {
            return Ok(match get(size + first)? {
                Cow::Borrowed(all) => Cow::Borrowed(&all[size..]),
                Cow::Owned(mut all) => Cow::Owned(all.split_off(size)),
            });
        }
        if first == 0 {
            return Ok(Cow::Borrowed(&[]));
        }
        let header = get(size * first.saturating_add(3))?;
        let [block, short] = [number(&header, 1), number(&header, 2)].map(|n| n as u64);
        let last = if short == 0 { block } else { short };
        let announced = block.saturating_mul(first as u64 - 1).saturating_add(last);
        if announced != expected as u64 {
            let what = format!("{what} (in bytes)");
            return Err(Problem::Length { what, expected: expected as u64, found: announced });
        }
        let mut packed = Vec::with_capacity(first);
        let mut end = header.len();
        for k in 0..first {
            let length = usize::try_from(number(&header, 3 + k)).ok().filter(|&n| n <= source.len());
            let start = end;
            end += length.ok_or_else(truncated)?;
            packed.push(start..end);
        }
        let all = get(end)?;
        let mut out = Vec::new();
        for (k, range) in packed.into_iter().enumerate() {
            let length = if k + 1 == first { last } else { block };
            let before = out.len();
            // One byte more than announced shows a block that is too long.
            let result = ZlibDecoder::new(&all[range]).take(length.saturating_add(1)).read_to_end(&mut out);
            if let Err(e) = result {
                return Err(Problem::Unexpected {
                    expected: format!("zlib data in block {k} of {what}"),
                    found: e.to_string(),
                });
            }
            let found = (out.len() - before) as u64;
            if found != length {
                return Err(Problem::Length { what: format!("block {k} of {what}"), expected: length, found });
            }
        }
        Ok(Cow::Owned(out))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_may_be_padded_in_the_middle_and_broken_over_lines() {
        let joined = prefix(b"AQID\n BAUG", Encoding::Base64, 5).unwrap();
        assert_eq!(&joined[..], [1, 2, 3, 4, 5]);
        let split = prefix(b"AQ==AgM=BAUG", Encoding::Base64, 6).unwrap();
        assert_eq!(&split[..], [1, 2, 3, 4, 5, 6]);
        assert!(prefix(b"AQID", Encoding::Base64, 4).is_none());
        assert!(prefix(b"A!ID", Encoding::Base64, 3).is_none());
    }
}
