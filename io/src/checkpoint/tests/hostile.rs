//! Damaged, foreign and malicious files: one sentence each, never a panic or a wrong answer.

use std::io::{Seek, SeekFrom, Write};

use xxhash_rust::xxh3::xxh3_64;

use super::super::CheckpointError;
use super::super::format::{Header, Preamble, Row};
use super::*;

/// A small live file's bytes, and a place to put changed ones.
fn small() -> (tempfile::TempDir, PathBuf, Vec<u8>) {
    let dir = tempfile::tempdir().unwrap();
    let (_, live) = pair(dir.path(), &mut thing(3));
    let bytes = std::fs::read(&live).unwrap();
    (dir, live, bytes)
}

/// Writes `bytes` over a part of the file in place. Replacing thousands of files would wait for the disk.
fn overwrite(path: &Path, at: usize, bytes: &[u8]) {
    let mut file = std::fs::OpenOptions::new().write(true).open(path).unwrap();
    file.seek(SeekFrom::Start(at as u64)).unwrap();
    file.write_all(bytes).unwrap();
}

/// One sentence that names the file and goes on after a semicolon with the cure.
fn is_clear(e: &CheckpointError, path: &Path) -> bool {
    let text = e.to_string();
    text.contains(&format!("`{}`", path.display())) && text.contains("; ") && !text.contains('\n')
}

#[test]
fn every_truncation_is_found_by_opening() {
    let (_dir, path, bytes) = small();
    let file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
    for length in (0..bytes.len()).rev() {
        file.set_len(length as u64).unwrap();
        let e = Opened::open(&path).unwrap_err();
        assert!(matches!(e, CheckpointError::Truncated { found, .. } if found == length as u64), "{length}: {e}");
        assert!(is_clear(&e, &path), "{e}");
    }
    std::fs::write(&path, [&bytes[..], &[0]].concat()).unwrap();
    let e = Opened::open(&path).unwrap_err().to_string();
    assert!(e.contains("1 bytes follow its end"), "{e}");
}

#[test]
fn every_flipped_bit_is_found() {
    let (_dir, path, bytes) = small();
    // All of them, not a sample: the file has some 3 kB.
    for bit in 0..8 * bytes.len() {
        let at = bit / 8;
        overwrite(&path, at, &[bytes[at] ^ (1 << (bit % 8))]);
        let e = open_all(&path).expect_err(&format!("bit {bit} of {} went unseen", 8 * bytes.len()));
        assert!(is_clear(&e, &path), "{e}");
        overwrite(&path, at, &bytes[at..=at]);
    }
}

/// Columns of one type and length, whose bytes change places: the table still fits.
#[test]
fn swapped_sections_are_found() {
    let dir = tempfile::tempdir().unwrap();
    let (path, _) = pair(dir.path(), &mut thing(3)); // its neighbours and triangles have as many bytes
    let bytes = std::fs::read(&path).unwrap();
    let places: Vec<(usize, usize)> =
        Opened::open(&path).unwrap().sections().iter().map(|s| (s.offset, s.len())).collect();
    let mut swapped = 0;
    for (i, &(a, length)) in places.iter().enumerate() {
        for &(b, _) in places[i + 1..].iter().filter(|p| p.1 == length && length > 0) {
            let mut forged = bytes.clone();
            forged[a..a + length].copy_from_slice(&bytes[b..b + length]);
            forged[b..b + length].copy_from_slice(&bytes[a..a + length]);
            overwrite(&path, 0, &forged);
            let e = open_all(&path).expect_err("nobody noticed");
            assert!(e.to_string().contains("the checksum of column") && is_clear(&e, &path), "{e}");
            swapped += 1;
        }
    }
    assert!(swapped > 0, "no two are of a length");
}

#[test]
fn bursts_of_noise_are_found() {
    let (_dir, path, bytes) = small();
    let mut random = Random(1);
    for _ in 0..3000 {
        let mut noisy = bytes.clone();
        let (at, length) = (random.below(bytes.len()), 1 + random.below(40));
        for byte in &mut noisy[at..(at + length).min(bytes.len())] {
            *byte = random.below(256) as u8;
        }
        overwrite(&path, 0, &noisy);
        assert!(noisy == bytes || open_all(&path).is_err(), "noise at {at}, {length} bytes");
    }
}

#[test]
fn files_that_are_no_checkpoints_are_named() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("what.fis");
    let text = b"ply\nformat ascii 1.0\n".repeat(20);
    for foreign in [&b"P"[..], b"\x89PNG\r\n\x1a\n", &text, &[0; 4096]] {
        std::fs::write(&path, foreign).unwrap();
        let e = Opened::open(&path).unwrap_err();
        assert!(matches!(e, CheckpointError::Foreign { .. }) && is_clear(&e, &path), "{e}");
    }
    let e = Opened::open(dir.path()).unwrap_err();
    assert!(matches!(e, CheckpointError::NotAFile { .. }) && is_clear(&e, dir.path()), "{e}");
    let gone = dir.path().join("gone.fis");
    let e = Opened::open(&gone).unwrap_err();
    assert!(matches!(e, CheckpointError::Io { .. }) && is_clear(&e, &gone), "{e}");
}

/// Writes a file around changed rows, with all checksums right: what a malicious writer would send.
fn forge(path: &Path, original: &[u8], version: u32, kind: u32, change: &dyn Fn(&mut Vec<Row>)) {
    let at = u64::from_le_bytes(original[24..32].try_into().unwrap()) as usize;
    let mut aligned = rkyv::util::AlignedVec::<16>::new();
    aligned.extend_from_slice(&original[at..]);
    let mut header = rkyv::from_bytes::<Header, rkyv::rancor::Error>(&aligned).unwrap();
    change(&mut header.sections);
    let archive = rkyv::to_bytes::<rkyv::rancor::Error>(&header).unwrap();
    seal(path, &original[..at], &archive, version, kind);
}

/// Puts an archive behind the sections, with the preamble that goes with it.
fn seal(path: &Path, front: &[u8], archive: &[u8], version: u32, kind: u32) {
    let preamble = Preamble {
        version,
        kind,
        file_length: (front.len() + archive.len()) as u64,
        header_offset: front.len() as u64,
        header_length: archive.len() as u64,
        header_checksum: xxh3_64(archive),
    };
    overwrite(path, 0, &[&preamble.to_bytes()[..], &front[64..], archive].concat());
    std::fs::OpenOptions::new().write(true).open(path).unwrap().set_len(preamble.file_length).unwrap();
}

#[test]
fn tables_that_lie_under_right_checksums_are_refused() {
    let (_dir, path, bytes) = small();
    forge(&path, &bytes, 1, 2, &|_| {});
    open_all(&path).unwrap(); // the forger can write a good file

    type Change = fn(&mut Vec<Row>);
    let lies: &[(Change, &str)] = &[
        (|t| t.swap(0, 1), "says byte"),
        (|t| (t[0].offset, t[1].offset) = (t[1].offset, t[0].offset), "says byte"),
        (|t| t[1].offset = t[0].offset, "says byte 64 where 192 is its place"),
        (|t| t[1].offset += 8, "says byte"),
        (|t| t[1].offset = u64::MAX - 63, "says byte"),
        (|t| drop(t.pop()), "belong to no column"),
        (|t| t.clear(), "belong to no column"),
        (|t| t.push(t[0].clone()), "says byte"),
        (|t| t[0].count += 1, "says 72 bytes for 4 × 3 f64"),
        (|t| (t[0].count, t[0].length) = (u64::MAX / 24, u64::MAX / 24 * 24), "says byte"),
        (|t| (t[0].count, t[0].width) = (u64::MAX, u32::MAX), "bytes for"),
        (|t| (t[0].count, t[0].length) = (1 << 40, 24 << 40), "says byte"),
        (|t| t[0].width = 0, "width 0"),
        (|t| (t[0].width, t[0].count, t[0].length) = (0, 5, 0), "width 0"),
        (|t| t[0].dtype = 6, "unknown codes"),
        (|t| t[0].dtype = 4, "says 72 bytes"),
        (|t| t[0].of = 0, "unknown codes"),
        (|t| t[0].life = 1, "does not fit the kind"),
        (|t| t[0].life = 0, "unknown codes"),
        (|t| t[0].zero = 1, "does not fit the kind"),
        (|t| t[0].name = String::new(), "no readable name"),
        (|t| t[0].name = "\u{1b}[2J".into(), "no readable name"),
        (|t| (t[0].scope, t[0].name) = (t[1].scope.clone(), t[1].name.clone()), "two columns `vase/damage`"),
        (|t| t[0].checksum ^= 1, "checksum of column `vase/position`"),
    ];
    for (i, (change, says)) in lies.iter().enumerate() {
        forge(&path, &bytes, 1, 2, change);
        let e = open_all(&path).unwrap_err();
        assert!(e.to_string().contains(says) && is_clear(&e, &path), "lie {i}: {e}");
    }

    forge(&path, &bytes, 7, 2, &|_| {});
    let e = Opened::open(&path).unwrap_err();
    assert!(e.to_string().ends_with("has format version 7 and this program reads up to 1; update fissure"), "{e}");
    for (version, kind, says) in [(0, 2, "version 0"), (1, 3, "says kind 3"), (1, 1, "does not fit the kind")] {
        forge(&path, &bytes, version, kind, &|_| {});
        let e = Opened::open(&path).unwrap_err().to_string();
        assert!(e.contains(says), "{e}");
    }
}

#[test]
fn preambles_that_lie_are_refused() {
    let (_dir, path, bytes) = small();
    let header = u64::from_le_bytes(bytes[24..32].try_into().unwrap());
    let numbers = [0, 1, 63, 64, 65, header - 64, header + 64, bytes.len() as u64, 1 << 40, u64::MAX - 63, u64::MAX];
    for field in [16, 24, 32] {
        for number in numbers {
            let mut forged = bytes.clone();
            forged[field..field + 8].copy_from_slice(&number.to_le_bytes());
            if forged == bytes {
                continue;
            }
            let checksum = xxh3_64(&forged[..56]);
            forged[56..64].copy_from_slice(&checksum.to_le_bytes());
            std::fs::write(&path, &forged).unwrap();
            let e = Opened::open(&path).expect_err("a lie was believed");
            assert!(is_clear(&e, &path), "{e}");
        }
    }
}

/// The archive itself is attacked: random bytes under a right checksum. Any answer but a panic will do; a file that
/// still opens must be whole enough to read every column.
#[test]
fn archives_that_lie_under_right_checksums_are_survived() {
    let (_dir, path, bytes) = small();
    let at = u64::from_le_bytes(bytes[24..32].try_into().unwrap()) as usize;
    let mut random = Random(2);
    let (mut refused, mut opened) = (0, 0);
    for round in 0..6000 {
        let mut archive = bytes[at..].to_vec();
        for _ in 0..1 + random.below(4) {
            let spot = random.below(archive.len());
            let bits = if round % 2 == 0 { 1 << random.below(8) } else { random.below(256) as u8 };
            archive[spot] ^= bits;
        }
        if round % 7 == 0 {
            archive.truncate(random.below(archive.len()));
        }
        seal(&path, &bytes[..at], &archive, 1, 2);
        match Opened::open(&path) {
            Err(e) => {
                assert!(is_clear(&e, &path), "{e}");
                refused += 1;
            }
            Ok(file) => {
                assert!(file.iter().map(|(section, data)| data.len() - section.len()).all(|rest| rest == 0));
                let _ = (file.verify(), super::super::summary(&path).unwrap().to_string());
                opened += 1;
            }
        }
    }
    assert!(refused > 1000 && opened > 1000, "one-sided attack: {refused} refused, {opened} opened");
}
