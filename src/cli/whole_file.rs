//! Files that appear whole or not at all: written beside their place under another name, then moved there.

use std::{
    fs::{File, Permissions},
    io::{self, BufWriter, Write},
    path::Path,
};
use tempfile::NamedTempFile;

/// Writes a file of its own making to `path`, in place of one that is there.
///
/// # Errors
/// What `write` or the disk says; `path` is as before then, and the temporary file is gone.
pub fn write(path: &Path, write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> io::Result<()> {
    let mut file = temporary_in(folder_of(path))?;
    let mut out = BufWriter::with_capacity(1 << 16, file.as_file_mut());
    write(&mut out)?;
    out.flush()?;
    drop(out);
    persist(file, path)
}

/// Gives a finished temporary file its name.
///
/// There is no `fsync`: a picture can be rendered again, and waiting for the disk takes longer than most.
pub fn persist(file: NamedTempFile, path: &Path) -> io::Result<()> {
    file.persist(path).map(drop).map_err(|error| error.error)
}

/// A temporary file with the permissions of any new file: what the process's umask leaves of 0666.
pub fn temporary_in(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".octray-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(Permissions::from_mode(0o666));
    }
    // The error would name the temporary file, which means nothing to anybody: keep its kind alone.
    builder
        .tempfile_in(folder)
        .map_err(|error| match error.raw_os_error() {
            Some(code) => io::Error::from_raw_os_error(code),
            None => io::Error::from(error.kind()),
        })
}

/// The folder of a file, "." for a bare name.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}
