//! The program's allocator: the system's, with a limit on the bytes in use and large pages for large pieces.
//!
//! Rust aborts when an allocation fails. This process ends with an error message instead, also when it reaches its limit:
//! no file can make a decoder use up the machine's memory.
//!
//! Arrays of millions of rows are written once and read once or twice, so that page faults take a good part of the time.
//! Linux provides pages of 2 MiB on request. Other systems are unaffected.
// Tuned: see docs/lab-notes.md#huge-pages
#![allow(unsafe_code, reason = "an allocator can be nothing else")]

use octray::cli::{MemoryRefusal, out_of_memory};
use std::{
    alloc::{GlobalAlloc, Layout, System},
    sync::atomic::{AtomicUsize, Ordering},
};

/// The system's allocator, limited.
pub struct Limited {
    /// Bytes in use.
    used: AtomicUsize,
    /// Most bytes in use.
    limit: AtomicUsize,
}

impl Limited {
    /// Without a limit at first.
    pub const fn new() -> Self {
        Self {
            used: AtomicUsize::new(0),
            limit: AtomicUsize::new(usize::MAX),
        }
    }

    /// Ends the process when it uses more than `bytes` from now on.
    pub fn set_limit(&self, bytes: u64) {
        self.limit
            .store(usize::try_from(bytes).unwrap_or(usize::MAX), Ordering::Relaxed);
    }

    fn take(&self, bytes: usize) {
        let used = self.used.fetch_add(bytes, Ordering::Relaxed).wrapping_add(bytes);
        if used > self.limit.load(Ordering::Relaxed) {
            // Reporting the error allocates little, if anything.
            self.set_limit(u64::MAX);
            out_of_memory(MemoryRefusal::Limit);
        }
    }

    fn give_back(&self, bytes: usize) {
        self.used.fetch_sub(bytes, Ordering::Relaxed);
    }
}

/// Bytes that an allocation of `size` takes in glibc: with a header of 8 bytes, rounded up to 16, at least 32.
fn rounded(size: usize) -> usize {
    (size.saturating_add(8 + 15) & !15).max(32)
}

/// Smaller allocations would contain hardly any large page.
const LEAST: usize = 4 << 20;

/// Requests large pages for `size` bytes at `start`. If the system does not grant them, nothing changes.
fn advise(start: *mut u8, size: usize) {
    #[cfg(target_os = "linux")]
    if !start.is_null() && size >= LEAST {
        // SAFETY: reads a constant of the system.
        let page = usize::try_from(unsafe { libc::sysconf(libc::_SC_PAGESIZE) }).unwrap_or(1 << 16);
        // All pages that hold a part of it: advice for the middle alone would split the mapping, and `mremap` moves only
        // whole ones.
        let lead = start.addr() % page;
        let length = (lead + size).next_multiple_of(page);
        // SAFETY: each page of the range holds a part of an allocation, so all are mapped; this advice changes neither what
        // memory holds nor who may use it.
        unsafe {
            libc::madvise(start.wrapping_sub(lead).cast(), length, libc::MADV_HUGEPAGE);
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = (start, size);
}

/// Ends the process if the system has refused memory.
fn given(start: *mut u8, size: usize) -> *mut u8 {
    if start.is_null() {
        out_of_memory(MemoryRefusal::System(size));
    }
    advise(start, size);
    start
}

// SAFETY: every call is passed on to `System`, which keeps the contract; counting and `advise` do not change memory.
unsafe impl GlobalAlloc for Limited {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        self.take(rounded(layout.size()));
        // SAFETY: the caller keeps `alloc`'s contract.
        given(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        self.take(rounded(layout.size()));
        // SAFETY: the caller keeps `alloc_zeroed`'s contract.
        given(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn dealloc(&self, start: *mut u8, layout: Layout) {
        self.give_back(rounded(layout.size()));
        // SAFETY: the caller keeps `dealloc`'s contract, and `start` came from `System`.
        unsafe { System.dealloc(start, layout) }
    }

    unsafe fn realloc(&self, start: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // `mremap` grows large allocations without a copy.
        let (old, new) = (rounded(layout.size()), rounded(size));
        if new > old {
            self.take(new - old);
        } else {
            self.give_back(old - new);
        }
        // SAFETY: the caller keeps `realloc`'s contract, and `start` came from `System`.
        given(unsafe { System.realloc(start, layout, size) }, size)
    }
}
