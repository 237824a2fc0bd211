//! What only vectors of eight lanes do: transpose, pick, sort, pack.

use super::{HasAvx2, Mask8, V8, avx2, sort};
use crate::{
    lanes::{F32x8, LANES},
    math,
    simd::{Column, EightLanes, LaneMask, Lanes, lanes},
};
use std::arch::x86_64::*;

/// The first, second, third and fourth lanes of four rows, by 128 bits.
#[inline(always)]
fn transposed4<T: HasAvx2>(a: V8<T>, b: V8<T>, c: V8<T>, d: V8<T>) -> [__m256; 4] {
    // SAFETY: the tokens prove the instructions.
    unsafe {
        let (low, high) = (_mm256_unpacklo_ps(a.0, b.0), _mm256_unpackhi_ps(a.0, b.0));
        let (low_2, high_2) = (_mm256_unpacklo_ps(c.0, d.0), _mm256_unpackhi_ps(c.0, d.0));
        [
            _mm256_shuffle_ps::<0b01_00_01_00>(low, low_2),
            _mm256_shuffle_ps::<0b11_10_11_10>(low, low_2),
            _mm256_shuffle_ps::<0b01_00_01_00>(high, high_2),
            _mm256_shuffle_ps::<0b11_10_11_10>(high, high_2),
        ]
    }
}

impl<T: HasAvx2> EightLanes for V8<T> {
    #[inline(always)]
    fn transposed([a, b, c, d, e, f, g, h]: [Self; LANES]) -> [Self; LANES] {
        let token = a.1;
        let ([a, b, c, d], [e, f, g, h]) = (transposed4(a, b, c, d), transposed4(e, f, g, h));
        [
            avx2!(V8, token, _mm256_permute2f128_ps::<0x20>(a, e)),
            avx2!(V8, token, _mm256_permute2f128_ps::<0x20>(b, f)),
            avx2!(V8, token, _mm256_permute2f128_ps::<0x20>(c, g)),
            avx2!(V8, token, _mm256_permute2f128_ps::<0x20>(d, h)),
            avx2!(V8, token, _mm256_permute2f128_ps::<0x31>(a, e)),
            avx2!(V8, token, _mm256_permute2f128_ps::<0x31>(b, f)),
            avx2!(V8, token, _mm256_permute2f128_ps::<0x31>(c, g)),
            avx2!(V8, token, _mm256_permute2f128_ps::<0x31>(d, h)),
        ]
    }
    #[inline(always)]
    fn load8(simd: T, from: &F32x8) -> Self {
        const { assert!(align_of::<F32x8>() == 32 && size_of::<F32x8>() == 32) }
        // SAFETY: 32 bytes at an address that is a multiple of 32; the token proves the instruction.
        Self(unsafe { _mm256_load_ps(from.as_array().as_ptr()) }, simd)
    }
    #[inline(always)]
    fn to8(self) -> F32x8 {
        bytemuck::must_cast(self.0)
    }
    // Tuned: see docs/lab-notes.md#picked-lanes
    #[inline(always)]
    fn picked8(simd: T, from: &Column, places: u32) -> Self {
        let [low, high] = from.halves();
        let (low, high) = (Self::load8(simd, low), Self::load8(simd, high));
        // SAFETY: the token proves the instructions.
        let places = unsafe {
            let shifts = _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28);
            _mm256_srlv_epi32(_mm256_set1_epi32(places.cast_signed()), shifts)
        };
        Self(simd.picked16(low.0, high.0, places), simd)
    }
    #[inline(always)]
    fn largest_of_eight(self) -> f32 {
        // SAFETY: the token proves the instructions.
        unsafe {
            let four = _mm_max_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
            let two = _mm_max_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_max_ss(two, _mm_movehdup_ps(two)))
        }
    }
    #[inline(always)]
    fn min_everywhere(self) -> Self {
        avx2!(Self, self.1, {
            let four = _mm256_min_ps(self.0, _mm256_permute2f128_ps::<1>(self.0, self.0));
            let two = _mm256_min_ps(four, _mm256_permute_ps::<0b01_00_11_10>(four));
            _mm256_min_ps(two, _mm256_permute_ps::<0b10_11_00_01>(two))
        })
    }
    #[inline(always)]
    fn swap_halves(self) -> Self {
        avx2!(Self, self.1, _mm256_permute2f128_ps::<1>(self.0, self.0))
    }
    #[inline(always)]
    fn same_bits(self, b: Self) -> u32 {
        avx2!(
            Mask8,
            self.1,
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(self.integers(), b.integers()))
        )
        .bits()
    }
    #[inline(always)]
    fn trunc(self) -> [i32; LANES] {
        // SAFETY: the token proves the instruction.
        bytemuck::must_cast(unsafe { _mm256_cvttps_epi32(self.0) })
    }
    #[inline(always)]
    fn byte_pairs([a, b, c]: [Self; 3]) -> [u64; LANES / 2] {
        // SAFETY: the tokens prove the instructions.
        let pairs = unsafe {
            let a = _mm256_cvttps_epi32(a.0);
            let b = _mm256_slli_epi32::<8>(_mm256_cvttps_epi32(b.0));
            let c = _mm256_slli_epi32::<16>(_mm256_cvttps_epi32(c.0));
            let packed = _mm256_or_si256(_mm256_or_si256(a, b), c);
            let first = _mm256_and_si256(packed, _mm256_set1_epi64x(0xff_ffff));
            let second = _mm256_slli_epi64::<24>(_mm256_srli_epi64::<32>(packed));
            _mm256_or_si256(first, second)
        };
        bytemuck::must_cast(pairs)
    }
    #[inline(always)]
    fn scale_to_one(self) -> Self {
        avx2!(Self, self.1, {
            let exponent = _mm256_and_si256(self.integers(), _mm256_set1_epi32(math::EXPONENT as i32));
            _mm256_castsi256_ps(_mm256_sub_epi32(_mm256_set1_epi32(254 << 23), exponent))
        })
    }
    // Tuned: see docs/lab-notes.md#sorting-eight
    #[inline(always)]
    fn nearest_last(self, chosen: u32) -> ([u32; LANES], usize) {
        // SAFETY: the token proves the instructions.
        let sorted = unsafe {
            let numbers = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
            let lane_bits = _mm256_set1_epi32(lanes::LANE_BITS.cast_signed());
            let entries = _mm256_or_si256(_mm256_andnot_si256(lane_bits, self.integers()), numbers);
            // Those not chosen are 0, the least entry, and come last.
            let chosen = _mm256_castps_si256(Self::mask(self.1, chosen).0);
            sort::sorted_down(_mm256_and_si256(entries, chosen))
        };
        (bytemuck::must_cast(sorted), (chosen & 0xff).count_ones() as usize)
    }
}
