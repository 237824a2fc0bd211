//! Sorts eight numbers without a branch.

use std::arch::x86_64::{
    __m256i, _mm256_blend_epi32, _mm256_max_epu32, _mm256_min_epu32, _mm256_permutevar8x32_epi32,
    _mm256_setr_epi32,
};

/// Sorts eight numbers, largest first, with Batcher's odd-even merge sort: six rounds without a branch.
///
/// # Safety
/// The CPU has AVX2.
#[inline(always)]
pub(super) unsafe fn sorted_down(mut x: __m256i) -> __m256i {
    /// One round: lanes of `$partner` that are exchanged with the others; `$lower` takes the smaller of two.
    macro_rules! round {
        ($partner:expr, $lower:literal) => {
            // SAFETY: the caller's.
            x = unsafe {
                let [a, b, c, d, e, f, g, h]: [i32; 8] = $partner;
                let other = _mm256_permutevar8x32_epi32(x, _mm256_setr_epi32(a, b, c, d, e, f, g, h));
                _mm256_blend_epi32::<$lower>(_mm256_max_epu32(x, other), _mm256_min_epu32(x, other))
            };
        };
    }
    round!([1, 0, 3, 2, 5, 4, 7, 6], 0b1010_1010);
    round!([2, 3, 0, 1, 6, 7, 4, 5], 0b1100_1100);
    round!([0, 2, 1, 3, 4, 6, 5, 7], 0b0100_0100);
    round!([4, 5, 6, 7, 0, 1, 2, 3], 0b1111_0000);
    round!([0, 1, 4, 5, 2, 3, 6, 7], 0b0011_0000);
    round!([0, 2, 1, 4, 3, 6, 5, 7], 0b0101_0100);
    x
}
