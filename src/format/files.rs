//! Reads regular files, from the disk or from the caller.

use super::{
    OpenMesh, alike,
    budget::Budget,
    source::{OpenFile, Opened, open_file, read_on},
};
use crate::error::{LoadError, in_bytes, io_reason};
use std::{
    fs,
    io::{self, Read},
    path::{Component, Path, PathBuf},
};

/// The largest mesh file, in bytes. Ids have 32 bits, so a larger one would hold too much.
pub(super) const MAX_BYTES: u64 = 1 << 32;

/// The largest text of a scene, in bytes: some twenty million spheres. Anything larger is hardly a scene.
pub(super) const MAX_TEXT_BYTES: u64 = 1 << 29;

/// The source of the files that a scene names. Bytes that are read are taken from the budget.
pub(super) trait Files {
    /// The text of an included scene file.
    fn text(&mut self, path: &Path, budget: &Budget) -> io::Result<Vec<u8>>;
    /// A mesh file, or a file that a mesh names.
    fn mesh(&mut self, path: &Path, budget: &Budget) -> io::Result<Opened>;
    /// The same name for all paths of one file.
    fn identity(&self, path: &Path) -> PathBuf;
}

/// The disk, and a list of all files that were opened.
pub(super) struct Disk<'a> {
    pub(super) asked: &'a mut Vec<PathBuf>,
}

impl Files for Disk<'_> {
    fn text(&mut self, path: &Path, budget: &Budget) -> io::Result<Vec<u8>> {
        self.asked.push(path.to_path_buf());
        read_text(path, budget)
    }

    fn mesh(&mut self, path: &Path, budget: &Budget) -> io::Result<Opened> {
        self.asked.push(path.to_path_buf());
        open(path, budget).map(Opened::File)
    }

    /// A path that cannot be resolved is refused when it is read.
    fn identity(&self, path: &Path) -> PathBuf {
        fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf())
    }
}

/// Files that the caller provides.
pub(super) struct Given<'a>(pub(super) OpenMesh<'a>);

impl Files for Given<'_> {
    fn text(&mut self, path: &Path, budget: &Budget) -> io::Result<Vec<u8>> {
        taken((self.0)(path)?, budget)
    }

    fn mesh(&mut self, path: &Path, budget: &Budget) -> io::Result<Opened> {
        taken((self.0)(path)?, budget).map(Opened::Bytes)
    }

    /// Drops `.` components.
    fn identity(&self, path: &Path) -> PathBuf {
        path.components()
            .filter(|part| *part != Component::CurDir)
            .collect()
    }
}

fn taken(bytes: Vec<u8>, budget: &Budget) -> io::Result<Vec<u8>> {
    budget.take(bytes.capacity())?;
    Ok(bytes)
}

/// Reads the text of a scene.
pub(super) fn read_text(path: &Path, budget: &Budget) -> io::Result<Vec<u8>> {
    let file =
        OpenFile::open(path, MAX_TEXT_BYTES, budget).map_err(|error| explained(path, error, budget))?;
    file.read_all(budget)
}

/// Reads at most `limit` bytes from a reader, which may be endless.
pub(super) fn read_all(reader: impl Read, limit: u64, budget: &Budget) -> io::Result<Vec<u8>> {
    let limit = limit.min(budget.left());
    let mut bytes = Vec::new();
    if read_on(reader, &mut bytes, limit, budget)? {
        return Ok(bytes);
    }
    Err(io::Error::other(format!(
        "the input is larger than {}",
        in_bytes(limit)
    )))
}

/// Opens a mesh, as [`OpenFile::open`] does.
pub(super) fn open(path: &Path, budget: &Budget) -> io::Result<OpenFile> {
    OpenFile::open(path, MAX_BYTES, budget).map_err(|error| explained(path, error, budget))
}

/// Refuses a path that is missing or not a regular file, without reading it.
pub(super) fn check_is_file(path: &Path) -> io::Result<()> {
    let opened = open_file(path).map(drop);
    opened.map_err(|error| explained(path, error, &Budget::unlimited()))
}

/// Reads a mesh, or a file that a mesh names.
pub(super) fn read(path: &Path, budget: &Budget) -> io::Result<Vec<u8>> {
    open(path, budget)?.read_all(budget)
}

/// Adds suggestions to the error about a missing file.
fn explained(path: &Path, error: io::Error, budget: &Budget) -> io::Error {
    match error.kind() {
        io::ErrorKind::NotFound if budget.may_suggest() => match alike::instead_of(path) {
            Some(instead) => io::Error::new(error.kind(), format!("file not found; {instead}")),
            None => error,
        },
        _ => error,
    }
}

/// The error about a file that cannot be read.
pub(super) fn load_error(path: &Path, error: &io::Error) -> LoadError {
    LoadError::whole_file(path, io_reason(error))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(path: &str) -> String {
        let path = Path::new(path);
        read(path, &Budget::unlimited()).map_or_else(
            |error| load_error(path, &error).to_string(),
            |_| "read".to_owned(),
        )
    }

    #[test]
    fn only_files_are_read() {
        assert_eq!(
            message("/no/such.scn"),
            "/no/such.scn: file not found; directory `/no` does not exist"
        );
        assert_eq!(message("no_such_file.scn"), "no_such_file.scn: file not found");
        assert_eq!(message("."), ".: this is a directory, expected a file");
        if cfg!(unix) {
            assert_eq!(
                message("/dev/zero"),
                "/dev/zero: this is a pipe or a device, expected a file"
            );
        }
        assert!(message("a\0b").starts_with("a\\u{0}b: "));
    }
}
