//! Sources of bytes: memory, or a file that threads read piece by piece.

use super::budget::{Budget, OnRead};
use crate::error::in_bytes;
use rayon::prelude::*;
use std::{
    fs::{self, File, Metadata},
    io::{self, Read},
    path::Path,
};

/// Bytes that several threads read piece by piece.
pub(super) trait Pieces: Sync {
    /// How many bytes there are.
    fn length(&self) -> usize;

    /// `length` bytes from `at`, in `buffer` unless they are in memory already. `None` if they cannot be read.
    fn piece<'a>(&'a self, at: usize, length: usize, buffer: &'a mut Vec<u8>) -> Option<&'a [u8]>;
}

impl Pieces for &[u8] {
    fn length(&self) -> usize {
        self.len()
    }

    fn piece<'a>(&'a self, at: usize, length: usize, _buffer: &'a mut Vec<u8>) -> Option<&'a [u8]> {
        self.get(at..at.checked_add(length)?)
    }
}

/// A regular file, not yet read.
pub(super) struct OpenFile {
    file: File,
    length: usize,
    limit: u64,
    on_read: Option<OnRead>,
}

/// Files of this size or more, in bytes, are read by all threads.
const WORTH_THREADS: usize = 4 << 20;
/// How many bytes a thread then reads at a time.
const PIECE: usize = 1 << 20;
/// The most bytes of a file whose size reads as 0, as all sizes in /proc do: some of these have no end.
const MAX_UNSIZED: u64 = 1 << 24;

impl OpenFile {
    /// Opens a regular file of at most `limit` bytes that is no larger than the budget.
    pub(super) fn open(path: &Path, limit: u64, budget: &Budget) -> io::Result<Self> {
        budget.opens(path);
        let file = open_file(path)?;
        let length = file.metadata()?.len();
        if length > budget.limit() && length <= limit {
            let message = format!(
                "the file has {}, above the memory limit of {}",
                in_bytes(length),
                in_bytes(budget.limit())
            );
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
        }
        match usize::try_from(length) {
            Ok(room) if length <= limit => Ok(Self {
                file,
                length: room,
                limit,
                on_read: budget.on_read(),
            }),
            _ => Err(too_large(limit)),
        }
    }

    /// All bytes. Their capacity is taken from the budget.
    pub(super) fn read_all(&self, budget: &Budget) -> io::Result<Vec<u8>> {
        budget.take(self.length)?;
        if self.length >= WORTH_THREADS
            && let Some(bytes) = self.read_in_parallel()?
        {
            return Ok(bytes);
        }
        let mut bytes = room_for(self.length)?;
        // The file may have grown or shrunk.
        if self.length > 0 {
            let is_all = read_on(&self.file, &mut bytes, self.limit, budget)?;
            return if is_all {
                Ok(bytes)
            } else {
                Err(too_large(self.limit))
            };
        }
        if read_on(&self.file, &mut bytes, MAX_UNSIZED, budget)? {
            return Ok(bytes);
        }
        Err(io::Error::other(format!(
            "the file seems empty but has more than {}, expected a file of known size",
            in_bytes(MAX_UNSIZED)
        )))
    }

    /// The bytes that the file had when it was opened. `None` if they cannot be read in parallel.
    fn read_in_parallel(&self) -> io::Result<Option<Vec<u8>>> {
        // Try first: `vec!` would abort the program if memory runs out.
        drop(room_for(self.length)?);
        let mut bytes = vec![0; self.length];
        let pieces = bytes.par_chunks_mut(PIECE).enumerate();
        let read = pieces.try_for_each(|(i, piece)| self.read_at(i * PIECE, piece));
        Ok(read.map(|()| bytes))
    }

    #[cfg(unix)]
    fn read_at(&self, at: usize, bytes: &mut [u8]) -> Option<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, bytes, at as u64).ok()?;
        if let Some(on_read) = &self.on_read {
            on_read(bytes.len());
        }
        Some(())
    }

    /// Other systems have one file position for all threads.
    #[cfg(not(unix))]
    fn read_at(&self, _at: usize, _bytes: &mut [u8]) -> Option<()> {
        None
    }
}

impl Pieces for OpenFile {
    fn length(&self) -> usize {
        self.length
    }

    fn piece<'a>(&'a self, at: usize, length: usize, buffer: &'a mut Vec<u8>) -> Option<&'a [u8]> {
        if at.checked_add(length)? > self.length {
            return None;
        }
        buffer.resize(length, 0);
        self.read_at(at, buffer)?;
        Some(buffer)
    }
}

/// Opens a regular file; directories, pipes and devices are refused.
///
/// They are refused before they are opened, since opening a device can act on it. What was opened is checked again: the
/// name may mean something else by then. Neither opening nor reading blocks: /proc has regular files that wait for data
/// (`kmsg`).
pub(crate) fn open_file(path: &Path) -> io::Result<File> {
    check_is_file(&fs::metadata(path)?)?;
    let mut options = File::options();
    options.read(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK | libc::O_NOCTTY);
    let file = options.open(path)?;
    check_is_file(&file.metadata()?)?;
    Ok(file)
}

fn check_is_file(metadata: &Metadata) -> io::Result<()> {
    if metadata.is_dir() {
        return Err(io::Error::new(
            io::ErrorKind::IsADirectory,
            "this is a directory, expected a file",
        ));
    }
    if !metadata.is_file() {
        return Err(io::Error::other("this is a pipe or a device, expected a file"));
    }
    Ok(())
}

/// Reads to the end, or until there are more than `limit` bytes, and returns whether this is the end. The capacity of
/// `bytes` is taken from the budget already; what it grows by is taken, too.
pub(super) fn read_on(
    mut reader: impl Read,
    bytes: &mut Vec<u8>,
    limit: u64,
    budget: &Budget,
) -> io::Result<bool> {
    let mut probe = [0; 1024];
    loop {
        let room = bytes.capacity() - bytes.len();
        reader.by_ref().take(room as u64).read_to_end(bytes)?;
        if bytes.len() as u64 > limit {
            return Ok(false);
        }
        if bytes.len() < bytes.capacity() {
            return Ok(true);
        }
        // The end may be here: grow only if it is not.
        let found = loop {
            match reader.read(&mut probe) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                result => break result?,
            }
        };
        if found == 0 {
            return Ok(true);
        }
        if (bytes.len() + found) as u64 > limit {
            return Ok(false);
        }
        budget.reserve(bytes, found)?;
        bytes.extend_from_slice(probe.get(..found).unwrap_or_default());
    }
}

fn room_for(length: usize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let reserved = bytes.try_reserve_exact(length);
    reserved.map_err(|error| io::Error::new(io::ErrorKind::OutOfMemory, error))?;
    Ok(bytes)
}

fn too_large(limit: u64) -> io::Error {
    let message = format!("the file is larger than {}", in_bytes(limit));
    io::Error::new(io::ErrorKind::FileTooLarge, message)
}

/// A mesh file: its bytes, or the open file.
pub(super) enum Opened {
    /// Its bytes.
    Bytes(Vec<u8>),
    /// The file.
    File(OpenFile),
}

impl Opened {
    /// Its size in bytes.
    pub(super) fn length(&self) -> usize {
        match self {
            Self::Bytes(bytes) => bytes.len(),
            Self::File(file) => file.length,
        }
    }

    /// All its bytes. If they are read from a file, their capacity is taken from the budget.
    pub(super) fn into_bytes(self, budget: &Budget) -> io::Result<Vec<u8>> {
        match self {
            Self::Bytes(bytes) => Ok(bytes),
            Self::File(file) => file.read_all(budget),
        }
    }

    /// Its first `most` bytes, or all if there are fewer; empty if they cannot be read.
    pub(super) fn head<'a>(&'a self, most: usize, buffer: &'a mut Vec<u8>) -> &'a [u8] {
        let length = most.min(self.length());
        let head = match self {
            Self::Bytes(bytes) => bytes.get(..length),
            Self::File(file) => file.piece(0, length, buffer),
        };
        head.unwrap_or_default()
    }
}
