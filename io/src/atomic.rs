//! A file is complete or absent: write beside it, flush, rename. For meshes, frames, pictures and scenes; checkpoints have
//! a stricter writer of their own (`checkpoint/write.rs`).

use std::io::{self, BufWriter, Write};
use std::path::Path;

/// How the names of unfinished files begin.
const UNFINISHED: &str = ".writing-";

/// Removes what killed writers left in `folder`; only for who knows that no writer is alive there. A folder that is not
/// there has nothing to remove, and a file that cannot be removed does no harm.
pub fn sweep(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_name().to_string_lossy().starts_with(UNFINISHED) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Writes `bytes` to `path` so that nobody ever sees half a file; see [`write_atomically_with`].
///
/// # Errors
/// Whatever the file system answers; the temporary file is removed.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_atomically_with(path, |out| out.write_all(bytes))
}

/// Writes what `content` writes into a temporary file of the same folder, which then takes the name `path`. An existing
/// file is replaced. The data is on the disk before the name is; the folder itself is not flushed, for what is written
/// this way can be made again.
///
/// # Errors
/// Whatever the file system or `content` answers; the temporary file is removed.
pub fn write_atomically_with(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(UNFINISHED);
    // The temporary-file default is private to the user; what we write is meant to be shared as the umask allows.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut out = BufWriter::with_capacity(1 << 16, builder.tempfile_in(folder)?);
    content(&mut out)?;
    let file = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.as_file().sync_data()?;
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}
