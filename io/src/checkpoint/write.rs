//! Writing a checkpoint file: one pass, nothing held but a header, complete or absent.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use fissure_engine::buffer::AnyBuffer;
use fissure_engine::column::{Column, Life};
use tempfile::NamedTempFile;
use xxhash_rust::xxh3::{Xxh3, xxh3_64};

use super::format::{
    ALIGN, About, HEADER_LIMIT, Header, Note, PREAMBLE, Preamble, Row, VERSION, dtype_code, life_code, of_code,
};
use super::{CheckpointError, Columns, label};

/// Temporary files end like this and start with a dot and the final name.
pub(crate) const TEMPORARY: &str = ".partial";
/// Bytes hashed and written at a time: stays in the cache in between.
const CHUNK: usize = 1 << 20;

/// A file that was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// Where it is.
    pub path: PathBuf,
    /// Its length in bytes.
    pub bytes: u64,
    /// Its fingerprint: the hash of its header, which holds the hash of each column.
    pub fingerprint: u64,
}

/// Writes the columns of one life to `path`, replacing what is there. `frozen` is the fingerprint of the frozen file
/// that live columns belong to, and 0 for frozen ones. Columns are streamed; memory does not grow with them.
///
/// # Errors
/// If the system refuses (nothing is left behind then, and an old file stays), or if two columns share a name.
pub fn write(
    path: impl AsRef<Path>,
    life: Life,
    frozen: u64,
    about: &About,
    columns: &mut dyn Columns,
) -> Result<Written, CheckpointError> {
    stage(path.as_ref(), life, frozen, about, columns)?.commit()
}

/// As [`write`] up to the rename.
pub(crate) fn stage(
    path: &Path,
    life: Life,
    frozen: u64,
    about: &About,
    columns: &mut dyn Columns,
) -> Result<Staged, CheckpointError> {
    let mut writer = Writer::begin(path)?;
    let mut rows = Vec::new();
    let mut names = BTreeSet::new();
    let mut trouble = None;
    columns.visit(&mut |scope, column, buffer| {
        if column.life != life || trouble.is_some() {
            return;
        }
        if !names.insert((scope.to_owned(), column.name)) {
            let column = label(scope, column.name);
            trouble = Some(CheckpointError::Duplicate { path: path.to_owned(), column });
            return;
        }
        match writer.section(scope, column, buffer) {
            Ok(row) => rows.push(row),
            Err(e) => trouble = Some(e),
        }
    });
    if let Some(e) = trouble {
        return Err(e);
    }
    let notes = about.notes.iter().map(|(key, value)| Note { key: key.clone(), value: value.clone() }).collect();
    let header = Header {
        step: about.step,
        time: about.time,
        frozen,
        scene: about.scene.clone(),
        program: about.program.clone(),
        notes,
        sections: rows,
    };
    writer.finish(life, &header)
}

struct Writer {
    path: PathBuf,
    file: NamedTempFile,
    position: u64,
}

impl Writer {
    fn begin(path: &Path) -> Result<Self, CheckpointError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let prefix = format!(".{name}.");
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(TEMPORARY);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(std::fs::Permissions::from_mode(0o666)); // the umask takes its part
        }
        let file = builder.tempfile_in(folder(path)).map_err(|e| {
            // The reason without the temporary name that tempfile adds to it.
            CheckpointError::io("write", path)(e.kind().into())
        })?;
        // Tells the cleaner of another process that somebody is at it. Where locks are not known, nobody cleans
        // while a run is on anyway.
        let _ = file.as_file().try_lock();
        let mut writer = Self { path: path.to_owned(), file, position: 0 };
        writer.put(&[0; PREAMBLE as usize])?;
        Ok(writer)
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), CheckpointError> {
        self.file.as_file_mut().write_all(bytes).map_err(CheckpointError::io("write", &self.path))?;
        self.position += bytes.len() as u64;
        Ok(())
    }

    fn section(&mut self, scope: &str, column: &Column, buffer: &dyn AnyBuffer) -> Result<Row, CheckpointError> {
        let named = [scope, column.name, column.unit].iter().all(|s| !s.contains(char::is_control));
        if column.name.is_empty() || !named {
            let what =
                format!("column {:?} has no name or one that does not print; rename it", label(scope, column.name));
            return Err(CheckpointError::Unfit { path: self.path.clone(), what });
        }
        let bytes = buffer.bytes();
        let offset = self.position;
        let mut hash = Xxh3::new();
        for chunk in bytes.chunks(CHUNK) {
            hash.update(chunk);
            self.put(chunk)?;
        }
        let fill = self.position.next_multiple_of(ALIGN) - self.position;
        self.put(&[0; ALIGN as usize][..fill as usize])?;
        Ok(Row {
            scope: scope.to_owned(),
            name: column.name.to_owned(),
            unit: column.unit.to_owned(),
            count: buffer.count() as u64,
            offset,
            length: bytes.len() as u64,
            checksum: hash.digest(),
            width: buffer.width() as u32,
            dtype: dtype_code(buffer.dtype()),
            of: of_code(column.of),
            life: life_code(column.life),
            zero: 0,
        })
    }

    fn finish(mut self, life: Life, header: &Header) -> Result<Staged, CheckpointError> {
        let unfit = |what| CheckpointError::Unfit { path: self.path.clone(), what };
        let archive = rkyv::to_bytes::<rkyv::rancor::Error>(header)
            .map_err(|e| unfit(format!("its header cannot be archived ({e}); shorten the scene")))?;
        if archive.len() as u64 > HEADER_LIMIT {
            return Err(unfit(format!("its header would take {} bytes; shorten the scene", archive.len())));
        }
        let fingerprint = xxh3_64(&archive);
        let preamble = Preamble {
            version: VERSION,
            kind: life_code(life).into(),
            file_length: self.position + archive.len() as u64,
            header_offset: self.position,
            header_length: archive.len() as u64,
            header_checksum: fingerprint,
        };
        self.put(&archive)?;
        let failed = CheckpointError::io("write", &self.path);
        let file = self.file.as_file_mut();
        file.seek(SeekFrom::Start(0))
            .and_then(|_| file.write_all(&preamble.to_bytes()))
            .and_then(|()| file.sync_all())
            .map_err(failed)?;
        let written = Written { path: self.path, bytes: self.position, fingerprint };
        Ok(Staged { file: self.file, written })
    }
}

/// A file that is complete and on the disk, still under its temporary name. Dropping it removes it.
pub(crate) struct Staged {
    file: NamedTempFile,
    written: Written,
}

impl Staged {
    /// Gives the file its name.
    pub fn commit(self) -> Result<Written, CheckpointError> {
        let path = &self.written.path;
        self.file.persist(path).map_err(|e| CheckpointError::io("write", path)(e.error))?;
        sync_folder(folder(path))?;
        Ok(self.written)
    }
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Makes renames and removals in a folder last through a power cut. Only Unix has a way to.
fn sync_folder(dir: &Path) -> Result<(), CheckpointError> {
    if cfg!(unix) {
        File::open(dir).and_then(|d| d.sync_all()).map_err(CheckpointError::io("sync", dir))?;
    }
    Ok(())
}
