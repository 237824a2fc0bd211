//! Reads regular files, from the disk or from the caller.

use super::{
    OpenMesh, alike,
    budget::{Budget, OnRead},
    source::{OpenFile, Opened, open_file, read_on},
};
use crate::error::{LoadError, clip_path, in_bytes, io_reason};
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
    let reader = Counted {
        reader,
        on_read: budget.on_read(),
    };
    if read_on(reader, &mut bytes, limit, budget)? {
        return Ok(bytes);
    }
    let message = format!("the input is larger than {}", in_bytes(limit));
    Err(io::Error::new(io::ErrorKind::FileTooLarge, message))
}

/// A reader that reports how many bytes it gives.
struct Counted<R> {
    reader: R,
    on_read: Option<OnRead>,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.reader.read(buffer)?;
        if let Some(on_read) = &self.on_read {
            on_read(count);
        }
        Ok(count)
    }
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

/// The files on the disk that a mesh names.
pub(super) struct Companions<'a> {
    asked: &'a mut Vec<PathBuf>,
    /// Files whose names differ in case from those in the mesh.
    in_other_case: Vec<PathBuf>,
}

impl<'a> Companions<'a> {
    /// Lists all files that were opened.
    pub(super) fn new(asked: &'a mut Vec<PathBuf>) -> Self {
        Self {
            asked,
            in_other_case: Vec::new(),
        }
    }

    pub(super) fn read(&mut self, path: &Path, budget: &Budget) -> io::Result<Vec<u8>> {
        self.asked.push(path.to_path_buf());
        let read = self::read(path, budget);
        if !matches!(&read, Err(error) if error.kind() == io::ErrorKind::NotFound) {
            return read;
        }
        let Some(other) = alike::in_other_case(path) else {
            return read;
        };
        self.asked.push(other.clone());
        let read = self::read(&other, budget)?;
        self.in_other_case.push(other);
        Ok(read)
    }

    /// Says which names differ in case.
    pub(super) fn note(&self, by: &Path) -> Option<String> {
        let first = self.in_other_case.first()?;
        let files = match self.in_other_case.len() {
            1 => "a file differs in upper and lower case from the name in the mesh".to_owned(),
            count => format!("{count} files differ in upper and lower case from the names in the mesh"),
        };
        Some(format!("{}: {files} (`{}`)", clip_path(by), clip_path(first)))
    }
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
    LoadError::whole_file(path, io_reason(error)).with_kind(error.into())
}

#[cfg(test)]
mod tests;
