//! The bytes are those of the module's page, now and in files written earlier.

use xxhash_rust::xxh3::xxh3_64;

use super::*;

/// A live file of version 1, written when the format was made. It must stay readable.
const VERSION_1: &[u8] = include_bytes!("version1.fis");

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
}

fn string_at(header: &[u8], at: usize) -> &str {
    let first = &header[at..at + 16];
    let bytes = if first[0] & 0xc0 == 0x80 {
        let raw = u64_at(header, at);
        let length = (raw & 0x3f) | ((raw & !0xff) >> 2);
        let start = at.wrapping_add_signed(u64_at(header, at + 8) as i64 as isize);
        &header[start..start + length as usize]
    } else {
        &first[..first.iter().position(|b| *b == 0xff).unwrap_or(16)]
    };
    std::str::from_utf8(bytes).unwrap()
}

fn table_at(header: &[u8], at: usize) -> (usize, usize) {
    (at.wrapping_add_signed(u64_at(header, at) as i64 as isize), u64_at(header, at + 8) as usize)
}

/// Reads a file as the page describes it, with nothing of the module.
#[test]
fn a_reader_made_from_the_page_finds_every_column() {
    let dir = tempfile::tempdir().unwrap();
    let mut original = thing(5);
    let (frozen, live) = pair(dir.path(), &mut original);
    let opened = [Opened::open(&frozen).unwrap(), Opened::open(&live).unwrap()];
    for (file, kind, frozen) in [(&opened[0], 1, 0), (&opened[1], 2, opened[0].fingerprint())] {
        let bytes = std::fs::read(file.path()).unwrap();
        assert_eq!(bytes[..8], [0x89, 0x46, 0x49, 0x53, 0x0d, 0x0a, 0x1a, 0x0a]);
        assert_eq!(bytes[8..16], [1, 0, 0, 0, kind, 0, 0, 0]);
        assert_eq!(u64_at(&bytes, 16), bytes.len() as u64);
        let header = &bytes[u64_at(&bytes, 24) as usize..];
        assert_eq!(u64_at(&bytes, 32), header.len() as u64);
        assert_eq!(u64_at(&bytes, 40), xxh3_64(header));
        assert_eq!(u64_at(&bytes, 48), 0);
        assert_eq!(u64_at(&bytes, 56), xxh3_64(&bytes[..56]));

        let root = header.len() - 88;
        let about = file.about();
        assert_eq!((u64_at(header, root), u64_at(header, root + 8)), (about.step, about.time.to_bits()));
        assert_eq!(u64_at(header, root + 16), frozen);
        assert_eq!((string_at(header, root + 24), string_at(header, root + 40)), (&*about.scene, &*about.program));
        let (note, notes) = table_at(header, root + 56);
        assert_eq!(
            (notes, string_at(header, note), string_at(header, note + 16)),
            (1, "forced", "gravity: -9.81 was -9.8")
        );

        let (table, count) = table_at(header, root + 72);
        assert_eq!(count, file.sections().len());
        for (i, (section, data)) in file.iter().enumerate() {
            let row = table + 88 * i;
            assert_eq!(string_at(header, row), section.scope);
            assert_eq!(string_at(header, row + 16), section.name);
            assert_eq!(string_at(header, row + 32), section.unit);
            assert_eq!(u64_at(header, row + 48), section.count as u64);
            let (offset, length) = (u64_at(header, row + 56) as usize, u64_at(header, row + 64) as usize);
            assert_eq!((offset % 64, &bytes[offset..offset + length]), (0, data));
            assert_eq!(u64_at(header, row + 72), xxh3_64(data));
            assert_eq!(header[row + 80..row + 84], (section.width as u32).to_le_bytes());
            let dtypes = ["u8", "u32", "u64", "f32", "f64"];
            assert_eq!(dtypes[header[row + 84] as usize - 1], section.dtype.name());
            assert_eq!((header[row + 86], header[row + 87]), (kind, 0));
        }
    }
}

#[test]
fn the_same_data_gives_the_stored_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let (_, live) = pair(dir.path(), &mut thing(3));
    assert!(std::fs::read(&live).unwrap() == VERSION_1, "the format changed: raise VERSION and keep reading this one");
}

#[test]
fn a_stored_file_of_version_1_reads() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("old.fis");
    std::fs::write(&path, VERSION_1).unwrap();
    let old = open_all(&path).unwrap();
    assert_eq!(*old.about(), about(7));
    assert_eq!(old.column::<DVec3>("vase", "position").unwrap(), &thing(3).position[..]);
    assert_eq!(old.column::<u64>("", "seed").unwrap(), &[u64::MAX - 1]);
}
