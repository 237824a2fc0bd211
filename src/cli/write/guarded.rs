//! Whole files that a signal stops while they are written.

use crate::{cli::process::Interrupt, whole_file::Temporary};
use std::{
    fs::{self, File},
    io::{self, BufWriter, Write},
    path::Path,
};

/// Writes a file to `path` and replaces an existing one. A signal stops it.
///
/// # Errors
/// What `write` or the disk says; `path` is as before then, and the temporary file is gone.
pub fn write(
    path: &Path,
    interrupt: &Interrupt,
    write: impl FnOnce(&mut BufWriter<Guarded<'_>>) -> io::Result<()>,
) -> io::Result<()> {
    // A link stays, and what it leads to is replaced.
    let target = fs::canonicalize(path);
    let mut temporary = Temporary::beside(target.as_deref().unwrap_or(path))?;
    let guarded = Guarded {
        file: temporary.file(),
        interrupt,
    };
    let mut out = BufWriter::with_capacity(1 << 16, guarded);
    write(&mut out)?;
    out.flush()?;
    drop(out);
    temporary.persist()
}

/// Writes to a file until a signal comes.
pub struct Guarded<'a> {
    file: &'a File,
    interrupt: &'a Interrupt,
}

impl Write for Guarded<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.interrupt.requested() {
            // Not `Interrupted`, after which `write_all` would try again.
            return Err(io::Error::other("stopped by a signal"));
        }
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_appears_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let interrupt = Interrupt::default();
        write(&path, &interrupt, |out| out.write_all(b"old")).unwrap();
        let failed = write(&path, &interrupt, |out| {
            out.write_all(&[0; 1 << 18])?;
            Err(io::Error::other("no more"))
        });
        assert_eq!(failed.unwrap_err().to_string(), "no more");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    #[cfg(unix)]
    fn a_link_stays() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("a"), folder.path().join("b"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink("a", &link).unwrap();
        write(&link, &Interrupt::default(), |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }
}
