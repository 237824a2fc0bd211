//! A file mapped into memory, to compare reading with.
#![allow(
    unsafe_code,
    reason = "the comparison needs what octray itself does without: a mapped file that shrinks ends the program"
)]

use std::{fs::File, os::fd::AsRawFd, path::Path, ptr, slice};

pub struct Map {
    start: *mut libc::c_void,
    length: usize,
}

impl Map {
    /// A file of at least one byte.
    pub fn of(path: &Path) -> Self {
        let file = File::open(path).expect("the file opens");
        let length = file.metadata().expect("the file has a length").len() as usize;
        // SAFETY: a new mapping, at a place of the system's choice, read only and private.
        let start = unsafe {
            libc::mmap(
                ptr::null_mut(),
                length,
                libc::PROT_READ,
                libc::MAP_PRIVATE,
                file.as_raw_fd(),
                0,
            )
        };
        assert_ne!(start, libc::MAP_FAILED, "the file is mapped");
        Self { start, length }
    }

    pub fn bytes(&self) -> &[u8] {
        // SAFETY: `length` bytes are mapped for as long as `self` lives, and nobody else has the file, which is in a
        // temporary folder of this process.
        unsafe { slice::from_raw_parts(self.start.cast(), self.length) }
    }
}

impl Drop for Map {
    fn drop(&mut self) {
        // SAFETY: the mapping of `of`, unmapped once.
        unsafe { libc::munmap(self.start, self.length) };
    }
}
