//! Finds the image that a mesh names. An absolute path usually belongs to the machine that wrote the mesh, while the image
//! is next to the mesh.

use super::{super::left_out::counted, reason};
use crate::{
    error::{clip, clip_path},
    format::{OpenMesh, files},
};
use std::{
    io,
    path::{Path, PathBuf},
};

/// The path of `name` in the folder of the file `by`. Windows writes backslashes.
pub(in crate::format) fn joined(by: &Path, name: &str) -> PathBuf {
    by.parent().unwrap_or(Path::new("")).join(name.replace('\\', "/"))
}

/// The last component of an absolute path, of Unix or Windows.
pub(in crate::format) fn last_of_absolute(name: &str) -> Option<&str> {
    let is_absolute = match name.as_bytes() {
        [b'/' | b'\\', ..] => true,
        [drive, b':', b'/' | b'\\', ..] => drive.is_ascii_alphabetic(),
        _ => false,
    };
    let last = name.rsplit(['/', '\\']).next()?;
    (is_absolute && !matches!(last, "" | "." | "..")).then_some(last)
}

/// Reads images beside the mesh `by` that the mesh names by absolute paths.
pub(super) struct Beside<'a> {
    by: &'a Path,
    first: Option<String>,
    count: usize,
}

impl<'a> Beside<'a> {
    pub(super) fn new(by: &'a Path) -> Self {
        Self {
            by,
            first: None,
            count: 0,
        }
    }

    /// Reads an image that could not be read at its path: `file`, which the mesh calls
    /// `name` if that is an absolute path. The error is a sentence.
    pub(super) fn read(
        &mut self,
        (name, file, error): (Option<&str>, &Path, &io::Error),
        open: OpenMesh<'_>,
    ) -> Result<Vec<u8>, String> {
        use io::ErrorKind::{NotADirectory, NotFound};
        let failed = |file: &Path, error: &io::Error| Err(reason(&files::load_error(file, error)));
        let is_missing = |error: &io::Error| matches!(error.kind(), NotFound | NotADirectory);
        let name = name.filter(|_| is_missing(error));
        let Some((name, last)) = name.and_then(|name| Some((name, last_of_absolute(name)?))) else {
            return failed(file, error);
        };
        let beside = joined(self.by, last);
        match open(&beside) {
            Ok(bytes) => {
                self.first.get_or_insert_with(|| clip(name));
                self.count += 1;
                Ok(bytes)
            }
            Err(error) if is_missing(&error) => Err(format!(
                "that is an absolute path of another machine, and there is no `{last}` beside the mesh"
            )),
            Err(error) => failed(&beside, &error),
        }
    }

    /// Says what was found.
    pub(super) fn note(self) -> Option<String> {
        let textures = counted(self.count, "texture has", "textures have");
        Some(format!(
            "{}: {textures} an absolute path of another machine (`{}`): taken from beside the mesh",
            clip_path(self.by),
            self.first?
        ))
    }
}
