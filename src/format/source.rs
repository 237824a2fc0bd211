//! Sources of bytes: memory, or a file that threads read piece by piece.

use crate::error::in_bytes;
use rayon::prelude::*;
use std::{
    fs::{self, File},
    io::{self, Read},
    path::Path,
};

/// Bytes that several threads read piece by piece.
pub(super) trait Pieces: Sync {
    /// How many bytes there are.
    fn length(&self) -> usize;

    /// How much memory their contents may take, in bytes.
    fn memory(&self) -> u64 {
        u64::MAX
    }

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
    memory: u64,
}

/// Files of this size or more, in bytes, are read by all threads.
const WORTH_THREADS: usize = 4 << 20;
/// How many bytes a thread then reads at a time.
const PIECE: usize = 1 << 20;

impl OpenFile {
    /// Opens a regular file of at most `limit` bytes; `memory` limits it, too, with a message of its own.
    ///
    /// Directories, pipes and devices are refused before they are opened: opening a pipe may wait forever, and a device
    /// may have no end.
    pub(super) fn open(path: &Path, limit: u64, memory: u64) -> io::Result<Self> {
        let kind = fs::metadata(path)?.file_type();
        if kind.is_dir() {
            return Err(io::Error::other("this is a directory, expected a file"));
        }
        if !kind.is_file() {
            return Err(io::Error::other("this is a pipe or a device, expected a file"));
        }
        let file = open_file(path)?;
        let length = file.metadata()?.len();
        if length > memory && length <= limit {
            return Err(io::Error::other(format!(
                "the file has {}, above the memory limit of {}",
                in_bytes(length),
                in_bytes(memory)
            )));
        }
        match usize::try_from(length) {
            Ok(room) if length <= limit => Ok(Self {
                file,
                length: room,
                limit,
                memory,
            }),
            _ => Err(too_large(limit)),
        }
    }

    /// All bytes.
    pub(super) fn read_all(&self) -> io::Result<Vec<u8>> {
        if self.length >= WORTH_THREADS
            && let Some(bytes) = self.read_in_parallel()?
        {
            return Ok(bytes);
        }
        let mut bytes = room_for(self.length)?;
        // The file may have grown or shrunk, and files in /proc claim to be empty.
        let mut reader = (&self.file).take(self.limit + 1);
        if reader.read_to_end(&mut bytes)? as u64 > self.limit {
            return Err(too_large(self.limit));
        }
        Ok(bytes)
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
        std::os::unix::fs::FileExt::read_exact_at(&self.file, bytes, at as u64).ok()
    }

    /// Other systems have one file position for all threads.
    #[cfg(not(unix))]
    fn read_at(&self, _at: usize, _bytes: &mut [u8]) -> Option<()> {
        None
    }
}

impl Pieces for OpenFile {
    fn memory(&self) -> u64 {
        self.memory
    }

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

/// Opens a file so that neither opening nor reading blocks: /proc has regular files that wait for data (`kmsg`), and a
/// pipe may have replaced the file since it was checked.
pub(crate) fn open_file(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    options.read(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK);
    options.open(path)
}

fn room_for(length: usize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length).map_err(io::Error::other)?;
    Ok(bytes)
}

fn too_large(limit: u64) -> io::Error {
    io::Error::other(format!("the file is larger than {}", in_bytes(limit)))
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

    /// All its bytes.
    pub(super) fn into_bytes(self) -> io::Result<Vec<u8>> {
        match self {
            Self::Bytes(bytes) => Ok(bytes),
            Self::File(file) => file.read_all(),
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
