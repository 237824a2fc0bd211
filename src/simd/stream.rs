//! Writing past the caches (non-temporal stores): for what is only read much later. A cache would first fetch the memory
//! that is to be overwritten, and give up other memory for it.
//!
//! Whole cache lines want to be written at once, or they go to memory piece by piece.
#![allow(
    unsafe_code,
    reason = "these stores have no safe name; a single core of a Xeon writes long columns of answers 2.5 times as fast"
)]

use super::lanes::Column;

/// Writes a cache line by two such stores, where the build has them. [`finish`] comes before other threads are told of it.
#[inline(always)]
pub fn by_halves(line: Column, to: &mut Column) {
    #[cfg(all(target_arch = "x86_64", target_feature = "avx"))]
    for (&half, to) in line.halves().iter().zip(to.halves_mut()) {
        // SAFETY: the build has AVX, and `to` lies at a multiple of its 32 bytes.
        unsafe {
            std::arch::x86_64::_mm256_stream_ps(std::ptr::from_mut(to).cast(), bytemuck::cast(half));
        }
    }
    #[cfg(not(all(target_arch = "x86_64", target_feature = "avx")))]
    {
        *to = line;
    }
}

/// What was written past the caches is in memory before whatever is stored after this, as other threads see it.
pub fn finish() {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: every x86-64 CPU has this instruction.
    unsafe {
        std::arch::x86_64::_mm_sfence();
    }
}
