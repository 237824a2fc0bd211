//! Reading whole files, and only files.

use super::{
    OpenMesh, alike,
    source::{OpenFile, Opened},
};
use crate::error::LoadError;
use std::{
    fs,
    io::{self, Read},
    path::{Component, Path, PathBuf},
};

/// The largest mesh file that is read, bytes. Offsets and counts beyond have no use: ids are 32 bits.
const MAX_BYTES: u64 = 1 << 32;

/// The largest text of a scene, bytes: some twenty million spheres. What is larger is no scene, and to find that
/// out would take its size in memory.
pub(super) const MAX_TEXT_BYTES: u64 = 1 << 29;

/// Where the files come from that a scene names.
pub(super) trait Files {
    /// The text of an included scene file.
    fn text(&mut self, path: &Path) -> io::Result<Vec<u8>>;
    /// A mesh file.
    fn mesh(&mut self, path: &Path) -> io::Result<Opened>;
    /// The bytes of a file that a mesh names.
    fn beside_mesh(&mut self, path: &Path) -> io::Result<Vec<u8>> {
        self.mesh(path)?.into_bytes()
    }
    /// The same name for all paths of one file.
    fn identity(&self, path: &Path) -> PathBuf;
}

/// The disk.
pub(super) struct Disk {
    /// How much memory there is, bytes.
    pub(super) memory: u64,
}

impl Files for Disk {
    fn text(&mut self, path: &Path) -> io::Result<Vec<u8>> {
        read_text(path, self.memory)
    }

    fn mesh(&mut self, path: &Path) -> io::Result<Opened> {
        open(path, self.memory).map(Opened::File)
    }

    /// What cannot be resolved cannot be read either, and is refused then.
    fn identity(&self, path: &Path) -> PathBuf {
        fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf())
    }
}

/// The disk, and a list of all files that were asked for.
pub(super) struct Listed<'a> {
    pub(super) disk: Disk,
    pub(super) asked: &'a mut Vec<PathBuf>,
}

impl Files for Listed<'_> {
    fn text(&mut self, path: &Path) -> io::Result<Vec<u8>> {
        self.asked.push(path.to_path_buf());
        self.disk.text(path)
    }

    fn mesh(&mut self, path: &Path) -> io::Result<Opened> {
        self.asked.push(path.to_path_buf());
        self.disk.mesh(path)
    }

    fn identity(&self, path: &Path) -> PathBuf {
        self.disk.identity(path)
    }
}

/// Files that somebody gives; the disk is not touched.
pub(super) struct Given<'a>(pub(super) OpenMesh<'a>);

impl Files for Given<'_> {
    fn text(&mut self, path: &Path) -> io::Result<Vec<u8>> {
        (self.0)(path)
    }

    fn mesh(&mut self, path: &Path) -> io::Result<Opened> {
        (self.0)(path).map(Opened::Bytes)
    }

    /// `.` within a path does not count.
    fn identity(&self, path: &Path) -> PathBuf {
        path.components()
            .filter(|part| *part != Component::CurDir)
            .collect()
    }
}

/// Reads the text of a scene.
pub(super) fn read_text(path: &Path, memory: u64) -> io::Result<Vec<u8>> {
    let file = OpenFile::open(path, MAX_TEXT_BYTES, memory).map_err(|error| explained(path, error))?;
    file.read_all()
}

/// Reads the text of a scene from what may have no end.
pub(super) fn read_all_text(reader: impl Read) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    if reader.take(MAX_TEXT_BYTES + 1).read_to_end(&mut text)? as u64 > MAX_TEXT_BYTES {
        return Err(io::Error::other(format!(
            "this is larger than {MAX_TEXT_BYTES} bytes"
        )));
    }
    Ok(text)
}

/// Opens a mesh, as [`OpenFile::open`] does.
pub(super) fn open(path: &Path, memory: u64) -> io::Result<OpenFile> {
    OpenFile::open(path, MAX_BYTES, memory).map_err(|error| explained(path, error))
}

/// Refuses what is missing or no file (a folder, a pipe, a device), without reading it.
pub(super) fn check_is_file(path: &Path) -> io::Result<()> {
    open(path, u64::MAX).map(drop)
}

/// Reads a mesh, or what one names.
pub(super) fn read(path: &Path, memory: u64) -> io::Result<Vec<u8>> {
    open(path, memory)?.read_all()
}

/// A missing file with what is there instead, if anything is.
fn explained(path: &Path, error: io::Error) -> io::Error {
    match error.kind() {
        io::ErrorKind::NotFound => match alike::instead_of(path) {
            Some(instead) => io::Error::new(error.kind(), format!("there is no such file; {instead}")),
            None => error,
        },
        _ => error,
    }
}

/// What went wrong with a file, in plain words.
pub(super) fn load_error(path: &Path, error: &io::Error) -> LoadError {
    let message = match error.kind() {
        io::ErrorKind::NotFound if error.get_ref().is_some() => error.to_string(),
        io::ErrorKind::NotFound => "there is no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "the file may not be read: permission denied".to_owned(),
        io::ErrorKind::OutOfMemory => "the file does not fit into memory".to_owned(),
        _ => error.to_string(),
    };
    LoadError::whole_file(path, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(path: &str) -> String {
        let path = Path::new(path);
        read(path, u64::MAX).map_or_else(
            |error| load_error(path, &error).to_string(),
            |_| "read".to_owned(),
        )
    }

    #[test]
    fn only_files_are_read() {
        assert_eq!(
            message("/no/such.scn"),
            "/no/such.scn: there is no such file; there is no folder /no either"
        );
        assert_eq!(
            message("no_such_file.scn"),
            "no_such_file.scn: there is no such file"
        );
        assert_eq!(message("."), ".: this is a folder, expected a file");
        if cfg!(unix) {
            assert_eq!(
                message("/dev/zero"),
                "/dev/zero: this is a pipe or a device, expected a file"
            );
        }
        assert!(message("a\0b").starts_with("a\\u{0}b: "));
    }
}
