//! Which files a call may replace: none that it reads and, under a name that the user did not type, only octray's own.

use crate::{
    cli::{
        CliError,
        plan::{JsonTarget, is_standard_input},
    },
    error::clip_path,
    format,
    generate::is_generated,
    render::SOFTWARE,
    scene::Scene,
};
use std::{
    collections::HashMap,
    fs::{self, Metadata},
    io::Read,
    path::{Path, PathBuf},
};

/// How octray's JSON begins: with the number of its schema.
const JSON_START: &[u8] = b"{\"schema\":1,\"";

/// The first bytes of a file, in which octray's mark is.
const HEAD_BYTES: u64 = 4096;

/// A file, whatever it is called.
#[cfg(unix)]
pub type Identity = (u64, u64);
#[cfg(not(unix))]
pub type Identity = PathBuf;

/// The regular file at `path`, whose metadata are `found`. Links are followed.
pub fn identity(path: &Path, found: &Metadata) -> Option<Identity> {
    if !found.is_file() {
        return None;
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let _ = path;
        Some((found.dev(), found.ino()))
    }
    #[cfg(not(unix))]
    fs::canonicalize(path).ok()
}

/// The files that a call reads, which it does not replace.
#[derive(Clone, Debug, Default)]
pub struct Inputs(HashMap<Identity, (PathBuf, String)>);

impl Inputs {
    /// Adds a file, called `role` in messages.
    pub fn add(&mut self, path: &Path, role: &str) {
        // Standard input may be a file, too.
        let path = if is_standard_input(path) && cfg!(unix) {
            Path::new("/dev/stdin")
        } else {
            path
        };
        let file = fs::metadata(path).ok().and_then(|found| identity(path, &found));
        if let Some(file) = file {
            self.0
                .entry(file)
                .or_insert_with(|| (path.to_owned(), role.to_owned()));
        }
    }

    /// Adds the files that a scene was loaded from, and its textures.
    pub fn add_scene<'a>(
        &mut self,
        path: &Path,
        files: impl IntoIterator<Item = &'a PathBuf>,
        scene: Option<&'a Scene>,
    ) {
        let role = format!("a file of {}", clip_path(path));
        let textures = scene.into_iter().flat_map(|scene| &scene.sources().textures);
        for file in files.into_iter().chain(textures) {
            self.add(file, &role);
        }
    }

    /// Why nothing can be written to `name`, which now is the file `found`.
    pub fn objection(&self, name: &str, found: &Identity) -> Option<String> {
        let (path, role) = self.0.get(found)?;
        let path = clip_path(path);
        let path = if path == name {
            String::new()
        } else {
            format!(", {path}")
        };
        Some(format!(
            "{name} would replace {role}{path}; write to another file"
        ))
    }

    /// Refuses a file of JSON that would replace one of these.
    ///
    /// # Errors
    /// [`CliError::Failed`].
    pub fn check_json(&self, target: Option<&JsonTarget>) -> Result<(), CliError> {
        let Some(JsonTarget::File(path)) = target else {
            return Ok(());
        };
        let found = fs::metadata(path).ok();
        let found = found.and_then(|found| identity(path, &found));
        match found.and_then(|found| self.objection(&clip_path(path), &found)) {
            Some(objection) => Err(CliError::Failed(objection)),
            None => Ok(()),
        }
    }
}

/// Whether a file exists that octray did not write, judging by its first bytes.
pub fn is_foreign(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| found.is_file()) && !is_own(path)
}

fn is_own(path: &Path) -> bool {
    let mut head = Vec::new();
    let read = format::open_file(path).and_then(|file| file.take(HEAD_BYTES).read_to_end(&mut head));
    read.is_ok()
        && (is_own_png(&head) || is_own_exr(&head) || is_generated(&head) || head.starts_with(JSON_START))
}

/// Looks for the text `Software` in the chunks before the pixels.
fn is_own_png(head: &[u8]) -> bool {
    let Some(mut rest) = head.strip_prefix(b"\x89PNG\r\n\x1a\n") else {
        return false;
    };
    // Each chunk: length, kind, data, checksum.
    while let Some((&length, after)) = rest.split_first_chunk()
        && let Some((kind, after)) = after.split_first_chunk::<4>()
        && let Some((data, after)) = after.split_at_checked(u32::from_be_bytes(length) as usize)
        && kind != b"IDAT"
    {
        if kind == b"tEXt" && data.strip_prefix(b"Software\0") == Some(SOFTWARE.as_bytes()) {
            return true;
        }
        rest = after.get(4..).unwrap_or_default();
    }
    false
}

/// Looks for the attribute `software`: name, type, length, value.
fn is_own_exr(head: &[u8]) -> bool {
    let length = (SOFTWARE.len() as u32).to_le_bytes();
    let attribute = [b"software\0string\0", &length[..], SOFTWARE.as_bytes()].concat();
    head.starts_with(b"\x76\x2f\x31\x01") && head.windows(attribute.len()).any(|bytes| bytes == attribute)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn chunk(kind: &[u8], data: &[u8]) -> Vec<u8> {
        let length = (data.len() as u32).to_be_bytes();
        [&length[..], kind, data, b"sum."].concat()
    }

    fn png(chunks: &[(&[u8], &[u8])]) -> Vec<u8> {
        let chunks = chunks.iter().flat_map(|(kind, data)| chunk(kind, data));
        b"\x89PNG\r\n\x1a\n".iter().copied().chain(chunks).collect()
    }

    #[test]
    fn a_png_says_who_wrote_it_before_its_pixels() {
        let text: (&[u8], &[u8]) = (b"tEXt", b"Software\0octray");
        let header: (&[u8], &[u8]) = (b"IHDR", &[0; 13]);
        assert!(is_own_png(&png(&[header, text])));
        assert!(is_own_png(&png(&[header, (b"tEXt", b"Title\0octray"), text])));
        for chunks in [
            &[header, (b"IDAT", b""), text][..],
            &[header, (b"tEXt", b"Software\0octray2")],
            &[header, (b"tEXt", b"Software\0other")],
            &[header, (b"zTXt", b"Software\0octray")],
        ] {
            assert!(!is_own_png(&png(chunks)), "{chunks:?}");
        }
        let whole = png(&[header, text]);
        // The last four bytes are the checksum.
        for length in 0..whole.len() - 4 {
            assert!(!is_own_png(&whole[..length]), "{length}");
        }
        let endless = [&png(&[header])[..], &[0xff; 4], b"tEXtSoftware\0octray"].concat();
        assert!(!is_own_png(&endless));
    }

    proptest! {
        #[test]
        fn any_bytes_are_looked_at(bytes: Vec<u8>) {
            prop_assert!(!is_own_png(&[b"\x89PNG\r\n\x1a\n", &bytes[..]].concat()));
            prop_assert!(!is_own_exr(&bytes));
        }
    }
}
