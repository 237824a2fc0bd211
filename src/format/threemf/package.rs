//! The parts of a 3MF file, which is a ZIP archive. Nothing is unpacked to disk: names of parts are looked up in the
//! archive and are never paths of files.
//!
//! rawzip finds the entries without allocating; a part takes its bytes from the budget as it is inflated.
//!
//! Format: *Open Packaging Conventions*, ECMA-376 part 2.

use crate::{
    error::{LoadError, in_bytes},
    format::{
        budget::Budget,
        files::{self, MAX_BYTES},
        mesh::ZIP,
        place::TextFault,
        source::read_on,
    },
};
use flate2::bufread::DeflateDecoder;
use percent_encoding::percent_decode_str;
use rawzip::{CompressionMethod, ZipArchive, ZipArchiveEntryWayfinder, ZipSliceArchive};
use std::{
    collections::HashMap,
    fmt,
    io::{self, ErrorKind, Read},
    path::{Path, PathBuf},
};

/// Memory of an entry besides its name, bytes: the map may be half empty.
const ENTRY_BYTES: usize = 192;

/// The most bytes that DEFLATE expands one byte to.
const MAX_RATIO: u64 = 1032;

/// The most that a large part may expand each byte to. The XML of smooth and of flat grids expands by 8 to 11.
const MOST_RATIO: u64 = 200;

/// A part of at most this size may expand more, bytes.
const LARGE: u64 = 64 << 20;

/// An archive whose parts are read on request.
pub(super) struct Package<'a> {
    path: &'a Path,
    archive: ZipSliceArchive<&'a [u8]>,
    budget: &'a Budget,
    /// The size of the archive, bytes.
    size: usize,
    /// Entries by the [`key`] of their name.
    entries: HashMap<String, Entry>,
    /// The total size of the parts read so far, bytes.
    read: u64,
    /// The limit of `read`: what the archive can inflate to once. Parts that are read again or overlap count again.
    most: u64,
}

struct Entry {
    /// As written in the archive.
    name: Box<str>,
    place: ZipArchiveEntryWayfinder,
    method: CompressionMethod,
    is_encrypted: bool,
}

impl<'a> Package<'a> {
    /// Finds the parts of the archive at `path`.
    pub(super) fn new(bytes: &'a [u8], path: &'a Path, budget: &'a Budget) -> Result<Self, LoadError> {
        let refused = |message: String| LoadError::whole_file(path, message);
        if bytes.is_empty() {
            return Err(refused("the file is empty, expected a 3MF mesh".into()));
        }
        let archive = ZipArchive::from_slice(bytes).map_err(|_| {
            refused(if bytes.starts_with(ZIP) {
                "the ZIP archive has no end: the file is cut short or broken".into()
            } else {
                "this is not a ZIP archive, expected a 3MF mesh".into()
            })
        })?;
        let mut package = Self {
            path,
            archive,
            budget,
            size: bytes.len(),
            entries: HashMap::new(),
            read: 0,
            most: MAX_BYTES.min((bytes.len() as u64).saturating_mul(MAX_RATIO)),
        };
        package.find_entries()?;
        Ok(package)
    }

    fn find_entries(&mut self) -> Result<(), LoadError> {
        let broken = |error| {
            LoadError::whole_file(
                self.path,
                format!("the directory of the ZIP archive is broken: {error}"),
            )
        };
        let mut entries = self.archive.entries();
        while let Some(entry) = entries.next_entry().map_err(broken)? {
            let name = entry.file_path();
            // A byte that is not UTF-8 becomes three, in both copies of the name.
            let taken = self.budget.take(ENTRY_BYTES + 6 * name.len());
            taken.map_err(|error| error.into_error(self.path))?;
            let name = String::from_utf8_lossy(name.as_bytes());
            let place = Entry {
                name: name.trim_start_matches(['/', '\\']).into(),
                place: entry.wayfinder(),
                method: entry.compression_method(),
                is_encrypted: entry.flags().is_encrypted(),
            };
            self.entries.insert(key(&name), place);
        }
        Ok(())
    }

    /// The memory budget of the load.
    pub(super) fn budget(&self) -> &'a Budget {
        self.budget
    }

    /// The path of the archive.
    pub(super) fn path(&self) -> &'a Path {
        self.path
    }

    /// The size of the archive, bytes. What inflates from it may be a thousand times larger, and mostly spaces.
    pub(super) fn size(&self) -> usize {
        self.size
    }

    /// The path that errors show for a part that [`Package::find`] has found.
    pub(super) fn path_of(&self, part: &str) -> PathBuf {
        let name = self.entries.get(part).map_or(part, |entry| &entry.name);
        self.path.join(name)
    }

    /// The key of the part with this name, which may be percent-encoded; `None` if the archive has no such part.
    pub(super) fn find(&self, name: &str) -> Option<String> {
        // The longest name of a ZIP archive, with every byte percent-encoded.
        if name.len() > usize::from(u16::MAX) * 3 {
            return None;
        }
        let decoded = || key(&percent_decode_str(name).decode_utf8_lossy());
        let mut names = std::iter::once(key(name)).chain(std::iter::once_with(decoded));
        names.find(|name| self.entries.contains_key(name))
    }

    /// The alphabetically first key with this ending.
    pub(super) fn find_ending(&self, end: &str) -> Option<String> {
        let names = self.entries.keys().filter(|name| name.ends_with(end));
        names.min().cloned()
    }

    /// Reads a part that [`Package::find`] has found.
    pub(super) fn read(&mut self, part: &str) -> Result<Vec<u8>, LoadError> {
        let path = self.path_of(part);
        let read = self.inflate(part);
        read.map_err(|error| files::load_error(&path, &error))
    }

    fn inflate(&mut self, part: &str) -> io::Result<Vec<u8>> {
        let entry = self.entries.get(part).ok_or(io::ErrorKind::NotFound)?;
        if entry.is_encrypted {
            let message = "the part is encrypted, which octray does not read";
            return Err(io::Error::new(ErrorKind::Unsupported, message));
        }
        let broken = |why: &dyn fmt::Display| {
            io::Error::new(ErrorKind::InvalidData, format!("the part is broken: {why}"))
        };
        let stated = entry.place.uncompressed_size_hint();
        let found = self.archive.get_entry(entry.place);
        let found = found.map_err(|error| broken(&error))?;
        let data = found.data();
        let part: &mut dyn Read = match entry.method {
            CompressionMethod::STORE => &mut { data },
            CompressionMethod::DEFLATE => &mut DeflateDecoder::new(data),
            other => {
                let method = other
                    .name()
                    .map_or_else(|| format!("method {}", other.as_u16()), str::to_owned);
                let message = format!("the part is compressed by {method}, expected DEFLATE");
                return Err(io::Error::new(ErrorKind::Unsupported, message));
            }
        };
        // The stated size may be wrong.
        if stated > (data.len() as u64).saturating_add(1).saturating_mul(MAX_RATIO) {
            let (from, to) = (data.len(), in_bytes(stated));
            return Err(broken(&format_args!("{from} bytes do not inflate to {to}")));
        }
        if stated > LARGE && stated / MOST_RATIO > data.len() as u64 {
            let [from, to] = [data.len() as u64, stated].map(in_bytes);
            let message = format!(
                "the part inflates from {from} to {to}, which no model does: expected at most {MOST_RATIO} times"
            );
            return Err(io::Error::new(ErrorKind::FileTooLarge, message));
        }
        if stated > self.most.saturating_sub(self.read) {
            let most = in_bytes(self.most);
            let message = format!("the parts have more than {most} in total");
            return Err(io::Error::new(ErrorKind::FileTooLarge, message));
        }
        let mut bytes = Vec::new();
        self.budget.reserve(&mut bytes, stated as usize)?;
        let all = read_on(found.verifying_reader(part), &mut bytes, stated, self.budget);
        self.read += bytes.len() as u64;
        let error = match all {
            Ok(true) => return Ok(bytes),
            Ok(false) => format!(
                "it has more than the {} that the archive states",
                in_bytes(stated)
            ),
            Err(error) => error.to_string().to_lowercase(),
        };
        self.budget.give_back(bytes.capacity());
        Err(broken(&error))
    }

    /// The error of a fault in a part. The part is read again to show the line.
    pub(super) fn fault(&mut self, part: &str, fault: TextFault) -> LoadError {
        match self.read(part) {
            Ok(text) => fault.into_error(&text, &self.path_of(part)),
            Err(error) => error,
        }
    }
}

/// Normalises a part's name: case, kind of slash and leading slashes do not distinguish parts.
fn key(name: &str) -> String {
    let name = name.trim_start_matches(['/', '\\']);
    name.replace('\\', "/").to_ascii_lowercase()
}
