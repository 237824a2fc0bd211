//! Allocates large columns on pages of 2 MiB.
#![allow(
    unsafe_code,
    reason = "advice on memory has no safe name; see docs/lab-notes.md#large-pages"
)]

/// Columns smaller than this, in bytes, gain nothing.
#[cfg(target_os = "linux")]
const WORTH_IT: usize = 4 << 20;

/// Returns an empty column with room for `count` elements, on large pages if the system has some. Fill it once: a
/// column that grows moves elsewhere.
pub(super) fn column<T>(count: usize) -> Vec<T> {
    let column = Vec::with_capacity(count);
    #[cfg(target_os = "linux")]
    if count * size_of::<T>() >= WORTH_IT {
        const PAGE: usize = 4096;
        let start = column.as_ptr() as usize;
        let (first, end) = (
            start.next_multiple_of(PAGE),
            (start + count * size_of::<T>()) / PAGE * PAGE,
        );
        // SAFETY: whole pages of memory that the column owns; this advice changes nothing that is in it. A refusal does
        // no harm.
        unsafe { libc::madvise(first as *mut libc::c_void, end - first, libc::MADV_HUGEPAGE) };
    }
    column
}
