//! Sixteen lanes in one register, by AVX-512.
// Measured: docs/lab-notes.md#avx512
#![allow(clippy::wildcard_imports, reason = "intrinsics have a prefix of their own")]
#![allow(
    unsafe_code,
    reason = "intrinsics of an instruction set that is found at run time, behind its token"
)]

use super::{
    Avx2, Column, Eight, EightLanes, LaneMask, Lanes, REGISTER_LANES, Simd, TriangleLanes, WideColumn,
    avx2::{self, HasAvx2, V8},
    pair::Half,
};
use crate::lanes::F32x8;
use std::{
    arch::x86_64::*,
    ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub},
};

/// The token of AVX-512 F, DQ, VL and BW, and of AVX2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Avx512(());

impl Avx512 {
    /// Returns the token if this CPU and its system have the instructions.
    pub(super) fn detected() -> Option<Self> {
        let is_there = Avx2::detected().is_some()
            && is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512bw");
        is_there.then_some(Self(()))
    }
}

// SAFETY: `detected` makes the only ones, where AVX2 is detected, too.
unsafe impl HasAvx2 for Avx512 {
    #[inline(always)]
    fn picked16(self, low: __m256, high: __m256, places: __m256i) -> __m256 {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_permutex2var_ps(low, places, high) }
    }
}

impl Simd for Avx512 {
    type V8 = V8<Self>;
    type V16 = V16;

    #[inline(always)]
    fn call<R>(self, f: impl FnOnce() -> R) -> R {
        #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma,f16c,bmi1,bmi2,lzcnt,popcnt")]
        fn inner<R>(f: impl FnOnce() -> R) -> R {
            f()
        }
        // SAFETY: `self` proves the instructions.
        unsafe { inner(f) }
    }
    #[inline(always)]
    fn mul_add(self, a: f32, b: f32, c: f32) -> f32 {
        avx2::mul_add(self, a, b, c)
    }
}

/// Sixteen lanes.
#[derive(Clone, Copy, Debug)]
pub struct V16(__m512, Avx512);

/// Sixteen truth values in a mask register.
#[derive(Clone, Copy, Debug)]
pub struct Mask16(__mmask16);

impl Not for Mask16 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

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
}

/// Intrinsics on the registers of vectors, with the token.
macro_rules! avx512 {
    ($token:expr, $($call:tt)*) => {
        // SAFETY: the token proves the instructions.
        V16(unsafe { $($call)* }, $token)
    };
}

/// Intrinsics on the registers of vectors, whose tokens prove the instructions.
macro_rules! mask16 {
    ($($call:tt)*) => {
        // SAFETY: the vectors have the token.
        Mask16(unsafe { $($call)* })
    };
}

macro_rules! operator {
    ($trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for V16 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                avx512!(self.1, $intrinsic(self.0, b.0))
            }
        }
    };
}
operator!(Add, add, _mm512_add_ps);
operator!(Sub, sub, _mm512_sub_ps);
operator!(Mul, mul, _mm512_mul_ps);
operator!(Div, div, _mm512_div_ps);

impl Mul<f32> for V16 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: f32) -> Self {
        self * self.all(b)
    }
}

impl Neg for V16 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.flip_signs(self.all(-0.0))
    }
}

/// Both halves of a register.
#[inline(always)]
fn halves(a: V16) -> [V8<Avx512>; 2] {
    // SAFETY: the token proves the instructions.
    let [low, high] = unsafe { [_mm512_castps512_ps256(a.0), _mm512_extractf32x8_ps::<1>(a.0)] };
    [V8::of_register(a.1, low), V8::of_register(a.1, high)]
}

/// Reduces the lanes of two vectors to half by `$reduce` and joins the results, by 128 bits, or lane by lane within
/// each 128 bits as `$shuffle` picks them by `$low` and `$high`.
macro_rules! halved {
    ($reduce:ident, $shuffle:ident, $low:literal, $high:literal, $a:expr, $b:expr) => {{
        let (a, b) = ($a, $b);
        let low = avx512!(a.1, $shuffle::<$low>(a.0, b.0));
        let high = avx512!(a.1, $shuffle::<$high>(a.0, b.0));
        low.$reduce(high)
    }};
}

/// Lane i: all lanes of `$rows[i]` reduced to one, with half of the shuffles of a transpose.
// Tuned: see docs/lab-notes.md#row-reductions
macro_rules! of_each {
    ($reduce:ident, $rows:expr) => {{
        // Rows i, i + 4, i + 8 and i + 12, which end up in different 128-bit parts.
        let mut fours = [$rows[0]; 4];
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

impl TriangleLanes for V16 {
    #[inline(always)]
    fn picked(simd: Avx512, [low, high]: [&Column; 2], [low_places, high_places]: [u32; 2]) -> Self {
        let (low, high) = (Self::load(simd, low).0, Self::load(simd, high).0);
        avx512!(simd, {
            let shifts = _mm512_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28, 0, 4, 8, 12, 16, 20, 24, 28);
            let words = _mm512_set1_epi32(low_places.cast_signed());
            let words = _mm512_mask_set1_epi32(words, 0xff00, high_places.cast_signed());
            // Four bits each, and a fifth for the second table: (words and 15) or 16.
            let second = _mm512_setr_epi32(0, 0, 0, 0, 0, 0, 0, 0, 16, 16, 16, 16, 16, 16, 16, 16);
            let places = _mm512_srlv_epi32(words, shifts);
            let places = _mm512_ternarylogic_epi32::<0xea>(places, _mm512_set1_epi32(15), second);
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

impl Half for V16 {
    type Whole = WideColumn;

    #[inline(always)]
    fn load_both(simd: Avx512, WideColumn([low, high]): &WideColumn) -> [Self; 2] {
        [Self::load(simd, low), Self::load(simd, high)]
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

impl Lanes for V16 {
    type Simd = Avx512;
    type Mask = Mask16;
    type Memory = Column;
    type Packets = Self;
    type Triangles = Self;
    const COUNT: usize = REGISTER_LANES;

    #[inline(always)]
    fn simd(self) -> Avx512 {
        self.1
    }
    #[inline(always)]
    fn splat(simd: Avx512, a: f32) -> Self {
        avx512!(simd, _mm512_set1_ps(a))
    }
    #[inline(always)]
    fn mask(_: Avx512, bits: u32) -> Mask16 {
        Mask16(bits as u16)
    }
    #[inline(always)]
    fn load(simd: Avx512, from: &Column) -> Self {
        const { assert!(align_of::<Column>() == 64 && size_of::<Column>() == 64) }
        // SAFETY: 64 bytes at an address that is a multiple of 64; the token proves the instruction.
        Self(unsafe { _mm512_load_ps(from.0.as_ptr()) }, simd)
    }
    #[inline(always)]
    fn of_eights(simd: Avx512, [low, high, ..]: [&F32x8; 4]) -> Self {
        let (low, high) = (V8::load8(simd, low).register(), V8::load8(simd, high).register());
        avx512!(simd, _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high))
    }
    #[inline(always)]
    fn store(self, to: &mut Column) {
        const { assert!(align_of::<Column>() == 64 && size_of::<Column>() == 64) }
        // SAFETY: as for `load`.
        unsafe { _mm512_store_ps(to.0.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        avx512!(self.1, _mm512_fmadd_ps(self.0, b.0, c.0))
    }
    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        avx512!(self.1, _mm512_fmsub_ps(self.0, b.0, c.0))
    }
    #[inline(always)]
    fn mul_add_approx(self, b: Self, c: Self) -> Self {
        self.mul_add(b, c)
    }
    #[inline(always)]
    fn mul_sub_approx(self, b: Self, c: Self) -> Self {
        self.mul_sub(b, c)
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        avx512!(self.1, _mm512_min_ps(self.0, b.0))
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        avx512!(self.1, _mm512_max_ps(self.0, b.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        avx512!(self.1, _mm512_abs_ps(self.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        avx512!(self.1, _mm512_sqrt_ps(self.0))
    }
    #[inline(always)]
    fn sign(self) -> Self {
        avx512!(self.1, _mm512_and_ps(self.0, _mm512_set1_ps(-0.0)))
    }
    #[inline(always)]
    fn sign_bits(self) -> u32 {
        mask16!(_mm512_movepi32_mask(_mm512_castps_si512(self.0))).bits()
    }
    #[inline(always)]
    fn flip_signs(self, sign: Self) -> Self {
        avx512!(self.1, _mm512_xor_ps(self.0, sign.0))
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Mask16 {
        mask16!(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, b.0))
    }
    #[inline(always)]
    fn le(self, b: Self) -> Mask16 {
        mask16!(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, b.0))
    }
    #[inline(always)]
    fn gt(self, b: Self) -> Mask16 {
        mask16!(_mm512_cmp_ps_mask::<_CMP_GT_OQ>(self.0, b.0))
    }
    #[inline(always)]
    fn ge(self, b: Self) -> Mask16 {
        mask16!(_mm512_cmp_ps_mask::<_CMP_GE_OQ>(self.0, b.0))
    }
    #[inline(always)]
    fn eq(self, b: Self) -> Mask16 {
        mask16!(_mm512_cmp_ps_mask::<_CMP_EQ_OQ>(self.0, b.0))
    }
    #[inline(always)]
    fn not_lt(self, b: Self, lanes: Mask16) -> Mask16 {
        mask16!(_mm512_mask_cmp_ps_mask::<_CMP_NLT_UQ>(lanes.0, self.0, b.0))
    }
    #[inline(always)]
    fn not_gt(self, b: Self, lanes: Mask16) -> Mask16 {
        mask16!(_mm512_mask_cmp_ps_mask::<_CMP_NGT_UQ>(lanes.0, self.0, b.0))
    }
    #[inline(always)]
    fn select(mask: Mask16, if_true: Self, if_false: Self) -> Self {
        avx512!(if_true.1, _mm512_mask_blend_ps(mask.0, if_false.0, if_true.0))
    }
    #[inline(always)]
    fn fold_min(self) -> Eight<Self> {
        let [low, high] = halves(self);
        low.min(high)
    }
    #[inline(always)]
    fn fold_max(self) -> Eight<Self> {
        let [low, high] = halves(self);
        low.max(high)
    }
    #[inline(always)]
    fn fold_min_to_16(self) -> Self {
        self
    }
    #[inline(always)]
    fn fold_max_to_16(self) -> Self {
        self
    }
}
