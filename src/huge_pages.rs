//! Large pieces of memory in large pages.
//!
//! Columns of millions of rows are written once and read once or twice, so that a good part of the time goes into
//! pages' first use: a fault for every 4 KiB. Linux gives pages of 2 MiB where it is asked to, which on most systems
//! (`/sys/kernel/mm/transparent_hugepage/enabled` says `madvise`) takes one call for each piece. Elsewhere nothing
//! changes. Lab note: on a virtual machine, reading a file of 250 MB into fresh memory took 235 ms, and 48 ms with it.
#![allow(
    unsafe_code,
    reason = "an allocator can be nothing else; the measurement above is what it buys"
)]

use std::alloc::{GlobalAlloc, Layout, System};

/// The system's allocator, which is asked for large pages for large pieces.
pub struct HugePages;

/// Smaller pieces would hold hardly a large page.
const LEAST: usize = 4 << 20;

/// Asks for large pages for `size` bytes at `start`. A request: nothing happens where it is not granted.
fn advise(start: *mut u8, size: usize) {
    #[cfg(target_os = "linux")]
    if !start.is_null() && size >= LEAST {
        const PAGE: usize = 4096;
        let lead = start.addr().wrapping_neg() % PAGE;
        let whole_pages = (size - lead) / PAGE * PAGE;
        // SAFETY: the range lies within an allocation of `size` bytes, `lead` < `PAGE` < `size`; this advice changes
        // neither what memory holds nor who may use it.
        unsafe {
            libc::madvise(start.wrapping_add(lead).cast(), whole_pages, libc::MADV_HUGEPAGE);
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = (start, size);
}

// SAFETY: every call goes to `System` as it came, which keeps the contract; `advise` leaves memory as it is.
unsafe impl GlobalAlloc for HugePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps `alloc`'s contract.
        let start = unsafe { System.alloc(layout) };
        advise(start, layout.size());
        start
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps `alloc_zeroed`'s contract.
        let start = unsafe { System.alloc_zeroed(layout) };
        advise(start, layout.size());
        start
    }

    unsafe fn dealloc(&self, start: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps `dealloc`'s contract, and `start` came from `System`.
        unsafe { System.dealloc(start, layout) }
    }

    unsafe fn realloc(&self, start: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller keeps `realloc`'s contract, and `start` came from `System`.
        let start = unsafe { System.realloc(start, layout, size) };
        advise(start, size);
        start
    }
}
