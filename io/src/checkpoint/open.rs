//! An open checkpoint: its table checked, its columns slices of a map.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use fissure_engine::buffer::Element;
use fissure_engine::column::Life;
use memmap2::Mmap;
use xxhash_rust::xxh3::{Xxh3, xxh3_64};

use super::format::{ALIGN, About, Header, PREAMBLE, Preamble, Section, life_name, life_of, sections, type_name};
use super::{CheckpointError, label};

/// Bytes read at a time by [`Opened::stream`]; a multiple of every number's size.
const CHUNK: usize = 1 << 20;

/// A checkpoint file, mapped. Opening reads its ends only; [`verify`](Self::verify) reads all of it.
#[derive(Debug)]
pub struct Opened {
    pub(crate) path: PathBuf,
    pub(crate) file: File,
    pub(crate) map: Arc<Mmap>,
    life: Life,
    frozen: u64,
    fingerprint: u64,
    about: About,
    sections: Vec<Section>,
    /// Positions in `sections`, ordered by scope and name.
    order: Vec<usize>,
    verified: AtomicBool,
}

impl Opened {
    /// Opens and checks preamble, header and table, but not yet the columns' checksums. Takes the same time for any
    /// file size.
    ///
    /// # Errors
    /// If the file cannot be read, is no checkpoint, is of a later version, cut short, or its header is damaged.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, CheckpointError> {
        let path = path.as_ref().to_owned();
        // Asked by name first: opening a pipe would wait for its writer.
        if !path.metadata().map_err(CheckpointError::io("open", &path))?.is_file() {
            return Err(CheckpointError::NotAFile { path });
        }
        let file = File::open(&path).map_err(CheckpointError::io("open", &path))?;
        let length = file.metadata().map_err(CheckpointError::io("open", &path))?.len();
        if length == 0 {
            return Err(CheckpointError::Truncated { path, found: 0, expected: PREAMBLE });
        }
        // SAFETY: nothing of ours changes a finished file in place, and its readers are told (see the module).
        let map = unsafe { Mmap::map(&file) }.map_err(CheckpointError::io("map", &path))?;
        let length = map.len() as u64;
        let preamble = Preamble::read(&path, &map[..map.len().min(PREAMBLE as usize)], length)?;
        let archive = &map[preamble.header_offset as usize..]; // `read` checked that it ends with the file
        if xxh3_64(archive) != preamble.header_checksum {
            return Err(CheckpointError::damaged(&path, "the checksum of its header does not match"));
        }
        let header: Header = rkyv::from_bytes::<Header, rkyv::rancor::Error>(archive)
            .map_err(|_| CheckpointError::damaged(&path, "its header cannot be read as an archive"))?;
        let life = life_of(preamble.kind).expect("`read` checked the kind");
        let sections = sections(&path, header.sections, preamble.kind, preamble.header_offset)?;
        let mut order: Vec<usize> = (0..sections.len()).collect();
        let key = |i: &usize| (sections[*i].scope.as_str(), sections[*i].name.as_str());
        order.sort_by(|a, b| key(a).cmp(&key(b)));
        if let Some(pair) = order.windows(2).find(|pair| key(&pair[0]) == key(&pair[1])) {
            let column = sections[pair[0]].label();
            return Err(CheckpointError::damaged(&path, format!("it has two columns `{column}`")));
        }
        Ok(Self {
            path,
            file,
            map: Arc::new(map),
            life,
            frozen: header.frozen,
            fingerprint: preamble.header_checksum,
            about: About {
                step: header.step,
                time: header.time,
                scene: header.scene,
                program: header.program,
                notes: header.notes.into_iter().map(|note| (note.key, note.value)).collect(),
            },
            sections,
            order,
            verified: AtomicBool::new(false),
        })
    }

    /// Takes the columns as they are, so that a restore does not check their sums.
    pub fn trust(self) -> Self {
        self.verified.store(true, Ordering::Relaxed);
        self
    }

    /// Checks every column against its checksum, and the bytes between them. Reads the whole file through a buffer
    /// of 1 MiB, so the memory of this process does not grow.
    ///
    /// # Errors
    /// If a byte is not what was written, or the file cannot be read.
    pub fn verify(&self) -> Result<(), CheckpointError> {
        let mut chunk = Vec::new();
        for section in &self.sections {
            let mut hash = Xxh3::new();
            self.stream(section, &mut chunk, &mut |bytes| hash.update(bytes))?;
            self.check_sum(section, hash.digest())?;
        }
        self.verified.store(true, Ordering::Relaxed);
        Ok(())
    }

    /// Verifies unless that was done, or the file is trusted.
    pub(crate) fn verify_once(&self) -> Result<(), CheckpointError> {
        if self.verified.load(Ordering::Relaxed) { Ok(()) } else { self.verify() }
    }

    /// Compares a section's hash, and looks at the zeros behind it.
    pub(crate) fn check_sum(&self, section: &Section, hash: u64) -> Result<(), CheckpointError> {
        let end = section.offset + section.length;
        let what = if hash != section.checksum {
            format!("the checksum of column `{}` does not match", section.label())
        } else if self.map[end..end.next_multiple_of(ALIGN as usize)].iter().any(|byte| *byte != 0) {
            format!("the bytes behind column `{}` are not zero", section.label())
        } else {
            return Ok(());
        };
        Err(CheckpointError::damaged(&self.path, what))
    }

    /// Reads a section's bytes piece by piece from the file, not through the map. All pieces but the last are
    /// 1 MiB; `chunk` is the buffer, kept by the caller.
    pub(crate) fn stream(
        &self,
        section: &Section,
        chunk: &mut Vec<u64>,
        see: &mut dyn FnMut(&[u8]),
    ) -> Result<(), CheckpointError> {
        chunk.resize(CHUNK / 8, 0); // u64 for the alignment of any number
        let mut done = 0;
        while done < section.length {
            let piece = &mut bytemuck::cast_slice_mut::<u64, u8>(chunk)[..CHUNK.min(section.length - done)];
            self.piece(section, done, piece)?;
            see(piece);
            done += piece.len();
        }
        Ok(())
    }

    /// The largest number of a `u32` column; 0 of an empty one. Reads the file, not the map.
    pub(crate) fn largest(&self, scope: &str, name: &str) -> Result<u32, CheckpointError> {
        let section = &self.sections[self.find(scope, name)?];
        let (mut chunk, mut most) = (Vec::new(), 0);
        self.stream(section, &mut chunk, &mut |bytes| {
            most = bytemuck::cast_slice::<u8, u32>(bytes).iter().fold(most, |m, &x| m.max(x));
        })?;
        Ok(most)
    }

    /// Reads a section's bytes from its byte `done` on, as many as `piece` has room for.
    pub(crate) fn piece(&self, section: &Section, done: usize, piece: &mut [u8]) -> Result<(), CheckpointError> {
        self.read_at(section.offset + done, piece).map_err(CheckpointError::io("read", &self.path))
    }

    #[cfg(unix)]
    fn read_at(&self, offset: usize, piece: &mut [u8]) -> std::io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, piece, offset as u64)
    }

    #[cfg(not(unix))]
    fn read_at(&self, offset: usize, piece: &mut [u8]) -> std::io::Result<()> {
        piece.copy_from_slice(&self.map[offset..offset + piece.len()]);
        Ok(())
    }

    /// The elements of a column, as they lie in the map.
    ///
    /// # Errors
    /// If there is no such column, or its numbers are not `T`.
    pub fn column<T: Element>(&self, scope: &str, name: &str) -> Result<&[T], CheckpointError> {
        let section = &self.sections[self.find(scope, name)?];
        if (section.dtype, section.width) != (T::DTYPE, T::WIDTH) {
            return Err(CheckpointError::WrongType {
                path: self.path.clone(),
                column: section.label(),
                expected: type_name(T::DTYPE, T::WIDTH, &section.unit),
                found: type_name(section.dtype, section.width, &section.unit),
            });
        }
        bytemuck::try_cast_slice(self.bytes_of(section)).map_err(|e| {
            CheckpointError::damaged(&self.path, format!("column `{}` does not fit its type ({e})", section.label()))
        })
    }

    /// Every column with its bytes, in file order.
    pub fn iter(&self) -> impl Iterator<Item = (&Section, &[u8])> {
        self.sections.iter().map(|section| (section, self.bytes_of(section)))
    }

    /// The table of columns, in file order.
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// Where a column stands in the table.
    pub(crate) fn find(&self, scope: &str, name: &str) -> Result<usize, CheckpointError> {
        let key = |i: &usize| (self.sections[*i].scope.as_str(), self.sections[*i].name.as_str());
        match self.order.binary_search_by(|i| key(i).cmp(&(scope, name))) {
            Ok(at) => Ok(self.order[at]),
            Err(_) => Err(CheckpointError::NoColumn { path: self.path.clone(), column: label(scope, name) }),
        }
    }

    pub(crate) fn bytes_of(&self, section: &Section) -> &[u8] {
        &self.map[section.offset..section.offset + section.length]
    }

    /// What the file says of itself: step, time, scene, program.
    pub fn about(&self) -> &About {
        &self.about
    }

    /// The file's name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Length of the file in bytes.
    pub fn file_length(&self) -> usize {
        self.map.len()
    }

    /// Which columns it holds.
    pub fn life(&self) -> Life {
        self.life
    }

    /// Hash of the header, and through its checksums of everything in the file.
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// The fingerprint of the frozen file that a live file belongs to; 0 in a frozen file.
    pub fn frozen(&self) -> u64 {
        self.frozen
    }

    /// Refuses a file of the other kind.
    pub(crate) fn expect_life(&self, life: Life) -> Result<(), CheckpointError> {
        if self.life == life {
            return Ok(());
        }
        let (expected, found) = (life_name(life), life_name(self.life));
        Err(CheckpointError::WrongKind { path: self.path.clone(), expected, found })
    }

    /// Refuses a frozen file that is not the one of this live file.
    ///
    /// # Errors
    /// Files of the wrong kind, or of two runs.
    pub fn belongs_to(&self, frozen: &Opened) -> Result<(), CheckpointError> {
        self.expect_life(Life::Live)?;
        frozen.expect_life(Life::Frozen)?;
        if self.frozen == frozen.fingerprint {
            return Ok(());
        }
        Err(CheckpointError::OtherRun {
            live: self.path.clone(),
            frozen: frozen.path.clone(),
            expected: self.frozen,
            found: frozen.fingerprint,
        })
    }
}
