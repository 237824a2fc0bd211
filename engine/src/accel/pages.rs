//! Allocates large arrays on pages of 2 MiB.
#![allow(
    unsafe_code,
    reason = "advice on memory has no safe name; see docs/lab-notes.md#large-pages"
)]

/// Smaller arrays, in bytes, hold hardly any whole page: calls of the system against misses of the TLB.
// Tuned: see docs/lab-notes.md#large-pages
#[cfg(target_os = "linux")]
const WORTH_IT: usize = 4 << 20;

/// Returns an empty vector with the capacity `count`, on large pages if the system has some. Growing it further would move
/// it to other pages.
pub(super) fn vec<T>(count: usize) -> Vec<T> {
    let column = Vec::with_capacity(count);
    #[cfg(target_os = "linux")]
    if count * size_of::<T>() >= WORTH_IT {
        /// The largest page of any machine, bytes.
        const PAGE: usize = 1 << 16;
        let start = column.as_ptr() as usize;
        let (first, end) = (
            start.next_multiple_of(PAGE),
            (start + count * size_of::<T>()) / PAGE * PAGE,
        );
        // SAFETY: whole pages of memory that the vector owns; the advice does not change their contents. A refusal does no
        // harm.
        unsafe { libc::madvise(first as *mut libc::c_void, end - first, libc::MADV_HUGEPAGE) };
    }
    column
}
