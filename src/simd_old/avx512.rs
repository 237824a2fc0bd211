//! Sixteen lanes by AVX-512 intrinsics, and thirty-two as two registers.
//!
//! `wide` has sixteen lanes as well, but chooses instructions at compile time; these are chosen at run time.
// Measured: docs/lab-notes.md#avx512
#![allow(clippy::wildcard_imports, reason = "intrinsics have a prefix of their own")]

use super::{
    F32x8,
    lanes::{Column, LANE_BITS, LaneMask, Lanes, REGISTER_LANES, TriangleLanes, WideColumn},
    pair::{Half, Pair},
};
use std::{
    arch::x86_64::*,
    ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub},
};

/// Returns whether this CPU and its system run the instructions here, and the build rounds as they do.
#[must_use]
pub fn is_available() -> bool {
    crate::math::FUSED
        && is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512bw")
}

/// Sixteen `f32` in one register. Use it only in code that runs after [`is_available`] and is compiled with these
/// features; elsewhere it is slow.
#[derive(Clone, Copy, Debug)]
pub struct F32x16(__m512);

/// Sixteen truth values in a mask register.
#[derive(Clone, Copy, Debug)]
pub struct Mask16(__mmask16);

impl BitAnd for Mask16 {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, b: Self) -> Self {
        Self(self.0 & b.0)
    }
}

impl BitOr for Mask16 {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, b: Self) -> Self {
        Self(self.0 | b.0)
    }
}

impl LaneMask for Mask16 {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(bits as u16)
    }
}

/// Intrinsics on the registers of the arguments.
macro_rules! avx512 {
    ($result:ident, $($call:tt)*) => {
        // SAFETY: all values are made in kernels that are entered after `is_available`.
        $result(unsafe { $($call)* })
    };
}

macro_rules! operator {
    ($trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for F32x16 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                avx512!(Self, $intrinsic(self.0, b.0))
            }
        }
    };
}
operator!(Add, add, _mm512_add_ps);
operator!(Sub, sub, _mm512_sub_ps);
operator!(Mul, mul, _mm512_mul_ps);
operator!(Div, div, _mm512_div_ps);

impl Neg for F32x16 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.turn(Self::splat(-0.0))
    }
}

/// Both halves of a register.
#[inline(always)]
fn halves(a: F32x16) -> [F32x8; 2] {
    // SAFETY: as for the operators.
    let halves: [__m256; 2] = unsafe { [_mm512_castps512_ps256(a.0), _mm512_extractf32x8_ps::<1>(a.0)] };
    halves.map(bytemuck::cast)
}

/// Reduces the lanes of two vectors to half by `$reduce` and joins the results, by 128 bits, or lane by lane within
/// each 128 bits as `$shuffle` picks them by `$low` and `$high`.
macro_rules! halved {
    ($reduce:ident, $shuffle:ident, $low:literal, $high:literal, $a:expr, $b:expr) => {{
        let (a, b) = ($a, $b);
        let low = avx512!(F32x16, $shuffle::<$low>(a.0, b.0));
        let high = avx512!(F32x16, $shuffle::<$high>(a.0, b.0));
        low.$reduce(high)
    }};
}

/// Lane i: all lanes of `$rows[i]` reduced to one, with half of the shuffles of a transpose.
// Tuned: see docs/lab-notes.md#row-reductions
macro_rules! of_each {
    ($reduce:ident, $rows:expr) => {{
        // Rows i, i + 4, i + 8 and i + 12, for in the end each of these is in another 128 bits.
        let mut fours = [Self::splat(0.0); 4];
        for (i, four) in fours.iter_mut().enumerate() {
            let (a, b) = (
                halved!(
                    $reduce,
                    _mm512_shuffle_f32x4,
                    0b01_00_01_00,
                    0b11_10_11_10,
                    $rows[i],
                    $rows[i + 4]
                ),
                halved!(
                    $reduce,
                    _mm512_shuffle_f32x4,
                    0b01_00_01_00,
                    0b11_10_11_10,
                    $rows[i + 8],
                    $rows[i + 12]
                ),
            );
            *four = halved!($reduce, _mm512_shuffle_f32x4, 0b10_00_10_00, 0b11_01_11_01, a, b);
        }
        let [a, b, c, d] = fours;
        let (a, b) = (
            halved!($reduce, _mm512_shuffle_ps, 0b01_00_01_00, 0b11_10_11_10, a, b),
            halved!($reduce, _mm512_shuffle_ps, 0b01_00_01_00, 0b11_10_11_10, c, d),
        );
        halved!($reduce, _mm512_shuffle_ps, 0b10_00_10_00, 0b11_01_11_01, a, b)
    }};
}

impl TriangleLanes for F32x16 {
    #[inline(always)]
    fn picked8(from: &Column, places: u32) -> F32x8 {
        let [low, high] = *from.halves();
        let (low, high): (__m256, __m256) = (bytemuck::cast(low), bytemuck::cast(high));
        // SAFETY: as for the operators: only kernels that are entered after `is_available` call this.
        let picked: __m256 = unsafe {
            let shifts = _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28);
            let places = _mm256_srlv_epi32(_mm256_set1_epi32(places.cast_signed()), shifts);
            _mm256_permutex2var_ps(low, places, high)
        };
        bytemuck::cast(picked)
    }
    #[inline(always)]
    fn picked([low, high]: [&Column; 2], [low_places, high_places]: [u32; 2]) -> Self {
        // SAFETY: as for the operators; a column is 64 bytes at an address that is a multiple of 64.
        avx512!(Self, {
            let shifts = _mm512_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28, 0, 4, 8, 12, 16, 20, 24, 28);
            let words = _mm512_set1_epi32(low_places.cast_signed());
            let words = _mm512_mask_set1_epi32(words, 0xff00, high_places.cast_signed());
            // Four bits each, and a fifth for the second table: (words and 15) or 16.
            let second = _mm512_setr_epi32(0, 0, 0, 0, 0, 0, 0, 0, 16, 16, 16, 16, 16, 16, 16, 16);
            let places = _mm512_srlv_epi32(words, shifts);
            let places = _mm512_ternarylogic_epi32::<0xea>(places, _mm512_set1_epi32(15), second);
            let (low, high) = (_mm512_load_ps(low.0.as_ptr()), _mm512_load_ps(high.0.as_ptr()));
            _mm512_permutex2var_ps(low, places, high)
        })
    }
    #[inline(always)]
    fn least_of_each(rows: &[Self; REGISTER_LANES]) -> Self {
        of_each!(min, rows)
    }
    #[inline(always)]
    fn largest_of_each(rows: &[Self; REGISTER_LANES]) -> Self {
        of_each!(max, rows)
    }
}

/// Thirty-two lanes as two registers: packets of 32 rays with a shared origin. 512 rays pass nodes and leaves
/// together, and each broadcast serves twice as many.
// Tuned: see docs/lab-notes.md#packets-of-32
pub type F32x16x2 = Pair<F32x16>;

impl Half for F32x16 {
    type Whole = WideColumn;

    #[inline(always)]
    fn load_both(WideColumn([low, high]): &WideColumn) -> [Self; 2] {
        [Self::load(low), Self::load(high)]
    }
    #[inline(always)]
    fn store_both([low, high]: [Self; 2], WideColumn([to_low, to_high]): &mut WideColumn) {
        low.store(to_low);
        high.store(to_high);
    }
    #[inline(always)]
    fn fold_both_min([low, high]: [Self; 2]) -> Self {
        low.min(high)
    }
    #[inline(always)]
    fn fold_both_max([low, high]: [Self; 2]) -> Self {
        low.max(high)
    }
}

impl Lanes for F32x16 {
    type Mask = Mask16;
    type Memory = Column;
    type Packets = Self;
    type Triangles = Self;
    const COUNT: usize = 16;

    #[inline(always)]
    fn splat(a: f32) -> Self {
        avx512!(Self, _mm512_set1_ps(a))
    }
    #[inline(always)]
    fn load(from: &Column) -> Self {
        // SAFETY: a column is 64 bytes at an address that is a multiple of 64.
        avx512!(Self, _mm512_load_ps(from.0.as_ptr()))
    }
    #[inline(always)]
    fn of_eights([low, high, ..]: [F32x8; 4]) -> Self {
        let [low, high]: [__m256; 2] = [low, high].map(bytemuck::cast);
        avx512!(Self, _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high))
    }
    #[inline(always)]
    fn store(self, to: &mut Column) {
        // SAFETY: as for `load`.
        unsafe { _mm512_store_ps(to.0.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        avx512!(Self, _mm512_fmadd_ps(self.0, b.0, c.0))
    }
    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        avx512!(Self, _mm512_fmsub_ps(self.0, b.0, c.0))
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        avx512!(Self, _mm512_min_ps(self.0, b.0))
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        avx512!(Self, _mm512_max_ps(self.0, b.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        avx512!(Self, _mm512_abs_ps(self.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        avx512!(Self, _mm512_sqrt_ps(self.0))
    }
    #[inline(always)]
    fn sign(self) -> Self {
        avx512!(Self, _mm512_and_ps(self.0, _mm512_set1_ps(-0.0)))
    }
    #[inline(always)]
    fn sign_bits(self) -> u32 {
        avx512!(Mask16, _mm512_movepi32_mask(_mm512_castps_si512(self.0))).bits()
    }
    #[inline(always)]
    fn turn(self, sign: Self) -> Self {
        avx512!(Self, _mm512_xor_ps(self.0, sign.0))
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Mask16 {
        avx512!(Mask16, _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, b.0))
    }
    #[inline(always)]
    fn le(self, b: Self) -> Mask16 {
        avx512!(Mask16, _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, b.0))
    }
    #[inline(always)]
    fn gt(self, b: Self) -> Mask16 {
        avx512!(Mask16, _mm512_cmp_ps_mask::<_CMP_GT_OQ>(self.0, b.0))
    }
    #[inline(always)]
    fn ge(self, b: Self) -> Mask16 {
        avx512!(Mask16, _mm512_cmp_ps_mask::<_CMP_GE_OQ>(self.0, b.0))
    }
    #[inline(always)]
    fn not_lt(self, b: Self, lanes: Mask16) -> Mask16 {
        avx512!(
            Mask16,
            _mm512_mask_cmp_ps_mask::<_CMP_NLT_UQ>(lanes.0, self.0, b.0)
        )
    }
    #[inline(always)]
    fn not_gt(self, b: Self, lanes: Mask16) -> Mask16 {
        avx512!(
            Mask16,
            _mm512_mask_cmp_ps_mask::<_CMP_NGT_UQ>(lanes.0, self.0, b.0)
        )
    }
    #[inline(always)]
    fn select(mask: Mask16, if_true: Self, if_false: Self) -> Self {
        avx512!(Self, _mm512_mask_blend_ps(mask.0, if_false.0, if_true.0))
    }
    #[inline(always)]
    fn fold_min(self) -> F32x8 {
        let [low, high] = halves(self);
        super::min(low, high)
    }
    #[inline(always)]
    fn fold_max(self) -> F32x8 {
        let [low, high] = halves(self);
        super::max(low, high)
    }
    #[inline(always)]
    fn fold_min_to_16(self) -> Self {
        self
    }
    #[inline(always)]
    fn fold_max_to_16(self) -> Self {
        self
    }
    #[inline(always)]
    fn largest(self) -> f32 {
        self.fold_max().largest()
    }
    #[inline(always)]
    fn nearest_last(near: F32x8, chosen: u32) -> ([u32; 8], usize) {
        // SAFETY: as for the operators.
        let sorted = unsafe {
            let lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
            let lane_bits = _mm256_set1_epi32(LANE_BITS.cast_signed());
            let near = _mm256_andnot_si256(lane_bits, bytemuck::cast(near));
            // Those not chosen are 0, the least entry, and come last.
            sorted_down(_mm256_maskz_or_epi32(chosen as u8, near, lanes))
        };
        (bytemuck::cast(sorted), (chosen & 0xff).count_ones() as usize)
    }
}

/// Sorts eight numbers, largest first, with Batcher's odd-even merge sort: six rounds without a branch.
// Tuned: see docs/lab-notes.md#sorting-eight
#[inline(always)]
unsafe fn sorted_down(mut x: __m256i) -> __m256i {
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
