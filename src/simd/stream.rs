//! Non-temporal stores, for memory that is read only much later: the cache neither fetches what will be overwritten nor
//! evicts other memory. Write whole cache lines at once, or they go to memory piece by piece.
#![allow(
    unsafe_code,
    reason = "these stores have no safe name; see docs/lab-notes.md#streamed-hits"
)]

use super::{F32x8, lanes::Column};

/// Whether the build has non-temporal stores; ordinary ones stand in otherwise.
pub const IS_KNOWN: bool = cfg!(all(target_arch = "x86_64", target_feature = "avx"));

/// Writes a cache line by two non-temporal stores.
///
/// # Safety
/// The same thread calls [`finish`] before anything else reads or writes `to`.
#[inline(always)]
pub unsafe fn by_halves(low: F32x8, high: F32x8, to: &mut Column) {
    for (half, to) in [low, high].into_iter().zip(to.halves_mut()) {
        #[cfg(all(target_arch = "x86_64", target_feature = "avx"))]
        // SAFETY: the build has AVX, `to` lies at a multiple of its 32 bytes, and the caller sees to the rest.
        unsafe {
            std::arch::x86_64::_mm256_stream_ps(std::ptr::from_mut(to).cast(), bytemuck::cast(half));
        }
        #[cfg(not(all(target_arch = "x86_64", target_feature = "avx")))]
        {
            *to = half;
        }
    }
}

/// Orders what this thread wrote past the caches before whatever it reads and writes later, as other threads see it
/// too.
pub fn finish() {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: every x86-64 CPU has this instruction.
    unsafe {
        std::arch::x86_64::_mm_sfence();
    }
}
