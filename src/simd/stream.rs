//! Writing past the caches (non-temporal stores): for what is only read much later. A cache would first fetch the memory
//! that is to be overwritten, and give up other memory for it.
//!
//! Whole cache lines want to be written at once, or they go to memory piece by piece.
#![allow(
    unsafe_code,
    reason = "these stores have no safe name; a single core of a Xeon writes long columns of answers 2.5 times as fast"
)]

use super::{F32x8, lanes::Column};

/// Whether the build has such stores; without them the others stand in.
pub const IS_KNOWN: bool = cfg!(all(target_arch = "x86_64", target_feature = "avx"));

/// Writes a cache line by two such stores.
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

/// What this thread wrote past the caches comes before whatever it reads and writes after this, as other threads see it,
/// too.
pub fn finish() {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: every x86-64 CPU has this instruction.
    unsafe {
        std::arch::x86_64::_mm_sfence();
    }
}
