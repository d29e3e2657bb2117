//! A file is complete or absent: write beside it, flush, rename.

use std::io::{self, Write};
use std::path::Path;

/// Writes `bytes` to `path` so that nobody ever sees half a file: into a temporary file of the same folder, which
/// then takes the name. An existing file is replaced. The name survives a crash of the program; frames and pictures
/// can be made again, so the folder itself is not flushed to disk.
///
/// # Errors
/// Whatever the file system answers; the temporary file is removed.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".writing-");
    // The temporary-file default is private to the user; a frame is meant to be shared as the umask allows.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_data()?;
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}
