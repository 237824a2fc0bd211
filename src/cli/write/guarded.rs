//! Whole files that a signal stops while they are written.

use crate::{cli::process::Interrupt, whole_file::Temporary};
use std::{
    fs::File,
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
    let mut temporary = Temporary::beside(path)?;
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
    use std::fs;

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
}
