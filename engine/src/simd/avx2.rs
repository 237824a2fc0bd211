//! Eight lanes in one register, by AVX2 and FMA.
#![allow(clippy::wildcard_imports, reason = "intrinsics have a prefix of their own")]
#![allow(
    unsafe_code,
    reason = "intrinsics of an instruction set that is found at run time, behind its token"
)]

mod eight;
mod sort;

use super::{
    Column, EightLanes, LaneMask, Lanes, Pair, REGISTER_LANES, Simd, TriangleLanes, pair::reduced_rows,
};
use crate::lanes::{F32x8, LANES};
use std::{
    arch::x86_64::*,
    fmt::Debug,
    ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub},
};

/// The token of AVX2 and FMA, and what else came with them (x86-64-v3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Avx2(());

impl Avx2 {
    /// Returns the token if this CPU and its system have the instructions.
    pub(super) fn detected() -> Option<Self> {
        let is_there = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("f16c")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        is_there.then_some(Self(()))
    }
}

/// A token that proves AVX2 and FMA.
///
/// # Safety
/// A value exists only where the CPU has these instructions.
pub unsafe trait HasAvx2: Copy + Debug + Send + Sync + 'static + Simd<V8 = V8<Self>> {
    /// The tables of [`EightLanes::picked8`], by places from 0 to 15, a lane each.
    fn picked16(self, low: __m256, high: __m256, places: __m256i) -> __m256;
}

// SAFETY: `detected` makes the only ones.
unsafe impl HasAvx2 for Avx2 {
    #[inline(always)]
    fn picked16(self, low: __m256, high: __m256, places: __m256i) -> __m256 {
        // SAFETY: `self` proves the instructions.
        unsafe {
            // `permutevar` goes by the three lowest bits, `blendv` by the highest.
            let low = _mm256_permutevar8x32_ps(low, places);
            let high = _mm256_permutevar8x32_ps(high, places);
            _mm256_blendv_ps(low, high, _mm256_castsi256_ps(_mm256_slli_epi32::<28>(places)))
        }
    }
}

impl Simd for Avx2 {
    type V8 = V8<Self>;
    type V16 = Pair<V8<Self>>;

    #[inline(always)]
    fn call<R>(self, f: impl FnOnce() -> R) -> R {
        #[target_feature(enable = "avx2,fma,f16c,bmi1,bmi2,lzcnt,popcnt")]
        fn inner<R>(f: impl FnOnce() -> R) -> R {
            f()
        }
        // SAFETY: `self` proves the instructions.
        unsafe { inner(f) }
    }
    #[inline(always)]
    fn mul_add(self, a: f32, b: f32, c: f32) -> f32 {
        mul_add(self, a, b, c)
    }
}

/// Returns `a * b + c`, rounded once.
#[inline(always)]
pub(super) fn mul_add<T: HasAvx2>(_: T, a: f32, b: f32, c: f32) -> f32 {
    // SAFETY: the token proves the instructions.
    unsafe { _mm_cvtss_f32(_mm_fmadd_ss(_mm_set_ss(a), _mm_set_ss(b), _mm_set_ss(c))) }
}

/// Eight lanes, and a token of the level at which they are used.
#[derive(Clone, Copy, Debug)]
pub struct V8<T>(__m256, T);

/// Eight truth values: all bits of a lane set, or none.
#[derive(Clone, Copy, Debug)]
pub struct Mask8<T>(__m256, T);

/// Intrinsics on the registers of vectors, with the token of one of them.
macro_rules! avx2 {
    ($result:ident, $token:expr, $($call:tt)*) => {
        // SAFETY: the token proves the instructions.
        $result(unsafe { $($call)* }, $token)
    };
}
use avx2;

macro_rules! operator {
    ($trait:ident, $method:ident, $of:ident, $intrinsic:ident) => {
        impl<T: HasAvx2> $trait for $of<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                avx2!(Self, self.1, $intrinsic(self.0, b.0))
            }
        }
    };
}
operator!(Add, add, V8, _mm256_add_ps);
operator!(Sub, sub, V8, _mm256_sub_ps);
operator!(Mul, mul, V8, _mm256_mul_ps);
operator!(Div, div, V8, _mm256_div_ps);
operator!(BitAnd, bitand, Mask8, _mm256_and_ps);
operator!(BitOr, bitor, Mask8, _mm256_or_ps);

impl<T: HasAvx2> Mul<f32> for V8<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: f32) -> Self {
        self * self.all(b)
    }
}

impl<T: HasAvx2> Neg for V8<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.flip_signs(self.all(-0.0))
    }
}

impl<T: HasAvx2> Not for Mask8<T> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        avx2!(
            Self,
            self.1,
            _mm256_xor_ps(self.0, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))
        )
    }
}

impl<T: HasAvx2> LaneMask for Mask8<T> {
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: the token proves the instructions.
        unsafe { _mm256_movemask_ps(self.0) }.cast_unsigned()
    }
}

impl<T: HasAvx2> V8<T> {
    /// Compares the lanes.
    #[inline(always)]
    fn compared<const HOW: i32>(self, b: Self) -> Mask8<T> {
        avx2!(Mask8, self.1, _mm256_cmp_ps::<HOW>(self.0, b.0))
    }

    /// The lanes as integers.
    #[inline(always)]
    fn integers(self) -> __m256i {
        // SAFETY: the token proves the instructions.
        unsafe { _mm256_castps_si256(self.0) }
    }

    /// The register.
    #[inline(always)]
    pub(super) fn register(self) -> __m256 {
        self.0
    }

    /// Lanes of a register.
    #[inline(always)]
    pub(super) fn of_register(token: T, register: __m256) -> Self {
        Self(register, token)
    }
}

impl<T: HasAvx2> Lanes for V8<T> {
    type Simd = T;
    type Mask = Mask8<T>;
    type Memory = Column;
    type Packets = Pair<Self>;
    type Triangles = Self;
    const COUNT: usize = LANES;

    #[inline(always)]
    fn simd(self) -> T {
        self.1
    }
    #[inline(always)]
    fn splat(simd: T, a: f32) -> Self {
        avx2!(Self, simd, _mm256_set1_ps(a))
    }
    #[inline(always)]
    fn mask(simd: T, bits: u32) -> Mask8<T> {
        avx2!(Mask8, simd, {
            let lane_bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let bits = _mm256_and_si256(_mm256_set1_epi32(bits.cast_signed()), lane_bits);
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(bits, lane_bits))
        })
    }
    #[inline(always)]
    fn load(simd: T, from: &Column) -> Self {
        Self::load8(simd, &from.halves()[0])
    }
    #[inline(always)]
    fn of_eights(simd: T, [eight, ..]: [&F32x8; 4]) -> Self {
        Self::load8(simd, eight)
    }
    #[inline(always)]
    fn store(self, to: &mut Column) {
        to.halves_mut()[0] = self.to8();
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        avx2!(Self, self.1, _mm256_fmadd_ps(self.0, b.0, c.0))
    }
    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        avx2!(Self, self.1, _mm256_fmsub_ps(self.0, b.0, c.0))
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
        avx2!(Self, self.1, _mm256_min_ps(self.0, b.0))
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        avx2!(Self, self.1, _mm256_max_ps(self.0, b.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        avx2!(Self, self.1, _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        avx2!(Self, self.1, _mm256_sqrt_ps(self.0))
    }
    #[inline(always)]
    fn sign(self) -> Self {
        avx2!(Self, self.1, _mm256_and_ps(self.0, _mm256_set1_ps(-0.0)))
    }
    #[inline(always)]
    fn sign_bits(self) -> u32 {
        Mask8(self.0, self.1).bits()
    }
    #[inline(always)]
    fn flip_signs(self, sign: Self) -> Self {
        avx2!(Self, self.1, _mm256_xor_ps(self.0, sign.0))
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Mask8<T> {
        self.compared::<_CMP_LT_OQ>(b)
    }
    #[inline(always)]
    fn le(self, b: Self) -> Mask8<T> {
        self.compared::<_CMP_LE_OQ>(b)
    }
    #[inline(always)]
    fn gt(self, b: Self) -> Mask8<T> {
        self.compared::<_CMP_GT_OQ>(b)
    }
    #[inline(always)]
    fn ge(self, b: Self) -> Mask8<T> {
        self.compared::<_CMP_GE_OQ>(b)
    }
    #[inline(always)]
    fn eq(self, b: Self) -> Mask8<T> {
        self.compared::<_CMP_EQ_OQ>(b)
    }
    #[inline(always)]
    fn not_lt(self, b: Self, lanes: Mask8<T>) -> Mask8<T> {
        lanes & self.compared::<_CMP_NLT_UQ>(b)
    }
    #[inline(always)]
    fn not_gt(self, b: Self, lanes: Mask8<T>) -> Mask8<T> {
        lanes & self.compared::<_CMP_NGT_UQ>(b)
    }
    #[inline(always)]
    fn select(mask: Mask8<T>, if_true: Self, if_false: Self) -> Self {
        avx2!(Self, mask.1, _mm256_blendv_ps(if_false.0, if_true.0, mask.0))
    }
    #[inline(always)]
    fn fold_min(self) -> Self {
        self
    }
    #[inline(always)]
    fn fold_max(self) -> Self {
        self
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

impl<T: HasAvx2> TriangleLanes for V8<T> {
    #[inline(always)]
    fn picked(simd: T, [from, _]: [&Column; 2], [places, _]: [u32; 2]) -> Self {
        Self::picked8(simd, from, places)
    }
    #[inline(always)]
    fn least_of_each(rows: &[Self; REGISTER_LANES]) -> Pair<Self> {
        reduced_rows(rows, Self::min)
    }
    #[inline(always)]
    fn largest_of_each(rows: &[Self; REGISTER_LANES]) -> Pair<Self> {
        reduced_rows(rows, Self::max)
    }
}
