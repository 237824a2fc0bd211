//! Sixteen lanes as two vectors of eight, for CPUs without AVX-512.
//!
//! As numbers of packets, a lane a packet: bundles of sixteen packets of eight, in place of eight. (Zen 5, held to AVX2:
//! camera rays +11 to +33 %, shadow rays +13 to +28 %, mirror rays 0 to +6 %. SSE2: +4 to +8, +9 to +14, -2 to +5 %.)
//!
//! As rays: packets of sixteen, where they share their origin and a register [holds eight](IS_FAST): half as much is
//! done at once as with AVX-512, but nodes and leaves are passed by 256 rays together, in place of 128. (Held to AVX2:
//! camera rays +4 to +23 % more, shadow rays +5 to +19 %. Rays with their own origins: interior and terrain -7 %. SSE2:
//! small scenes +2 to +16 %, large ones -12 to -18 %.)

use super::{
    F32x8, Mask8,
    lanes::{Column, LaneMask, Lanes, MOST_LANES},
    stream,
};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// Whether packets of sixteen pay: a register of this build holds eight lanes.
pub const IS_FAST: bool = cfg!(target_feature = "avx");

/// Lanes 0 to 7, then 8 to 15.
#[derive(Clone, Copy, Debug)]
pub struct F32x8x2([F32x8; 2]);

/// A truth value for each lane of [`F32x8x2`].
#[derive(Clone, Copy, Debug)]
pub struct Mask8x2([Mask8; 2]);

impl F32x8x2 {
    #[inline(always)]
    fn of(self, f: impl Fn(F32x8) -> F32x8) -> Self {
        let [low, high] = self.0;
        Self([f(low), f(high)])
    }

    #[inline(always)]
    fn with(self, b: Self, f: impl Fn(F32x8, F32x8) -> F32x8) -> Self {
        let ([low, high], [b_low, b_high]) = (self.0, b.0);
        Self([f(low, b_low), f(high, b_high)])
    }

    #[inline(always)]
    fn with_both(self, b: Self, c: Self, f: impl Fn(F32x8, F32x8, F32x8) -> F32x8) -> Self {
        let ([low, high], [b_low, b_high], [c_low, c_high]) = (self.0, b.0, c.0);
        Self([f(low, b_low, c_low), f(high, b_high, c_high)])
    }

    #[inline(always)]
    fn compared(self, b: Self, f: impl Fn(F32x8, F32x8) -> Mask8) -> Mask8x2 {
        let ([low, high], [b_low, b_high]) = (self.0, b.0);
        Mask8x2([f(low, b_low), f(high, b_high)])
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $of:ty) => {
        impl $trait for $of {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                let ([low, high], [b_low, b_high]) = (self.0, b.0);
                Self([low.$method(b_low), high.$method(b_high)])
            }
        }
    };
}
operator!(Add, add, F32x8x2);
operator!(Sub, sub, F32x8x2);
operator!(Mul, mul, F32x8x2);
operator!(Div, div, F32x8x2);
operator!(BitAnd, bitand, Mask8x2);
operator!(BitOr, bitor, Mask8x2);

impl Neg for F32x8x2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.of(Neg::neg)
    }
}

impl LaneMask for Mask8x2 {
    #[inline(always)]
    fn bits(self) -> u32 {
        let [low, high] = self.0;
        low.bits() | high.bits() << 8
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self([Mask8::from_bits(bits), Mask8::from_bits(bits >> 8)])
    }
}

/// Each row folded to eight lanes.
#[inline(always)]
fn folded(rows: &[F32x8x2; MOST_LANES], fold: impl Fn(F32x8x2) -> F32x8) -> [F32x8; MOST_LANES] {
    let mut folded = [F32x8::ZERO; MOST_LANES];
    for (to, row) in folded.iter_mut().zip(rows) {
        *to = fold(*row);
    }
    folded
}

impl Lanes for F32x8x2 {
    type Mask = Mask8x2;
    type Packets = Self;
    const COUNT: usize = 16;

    #[inline(always)]
    fn splat(a: f32) -> Self {
        Self([super::splat(a); 2])
    }
    #[inline(always)]
    fn load(from: &Column) -> Self {
        Self(*from.halves())
    }
    #[inline(always)]
    fn join(low: F32x8, high: F32x8) -> Self {
        Self([low, high])
    }
    #[inline(always)]
    fn picked8(from: &Column, places: u32) -> F32x8 {
        super::picked8(from, places)
    }
    #[inline(always)]
    fn picked([low, high]: [&Column; 2], [low_places, high_places]: [u32; 2]) -> Self {
        Self([super::picked8(low, low_places), super::picked8(high, high_places)])
    }
    #[inline(always)]
    fn store(self, to: &mut Column) {
        *to.halves_mut() = self.0;
    }
    #[inline(always)]
    #[allow(unsafe_code, reason = "as in the trait")]
    unsafe fn stream(low: F32x8, high: F32x8, to: &mut Column) {
        // SAFETY: as for this.
        unsafe { stream::by_halves(low, high, to) }
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self.with_both(b, c, super::mul_add)
    }
    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        self.with_both(b, c, super::mul_sub)
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        self.with(b, super::min)
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        self.with(b, super::max)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.of(Lanes::abs)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.of(Lanes::sqrt)
    }
    #[inline(always)]
    fn sign(self) -> Self {
        self.of(Lanes::sign)
    }
    #[inline(always)]
    fn sign_bits(self) -> u32 {
        let [low, high] = self.0;
        low.sign_bits() | high.sign_bits() << 8
    }
    #[inline(always)]
    fn turn(self, sign: Self) -> Self {
        self.with(sign, Lanes::turn)
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Mask8x2 {
        self.compared(b, super::lt)
    }
    #[inline(always)]
    fn le(self, b: Self) -> Mask8x2 {
        self.compared(b, super::le)
    }
    #[inline(always)]
    fn gt(self, b: Self) -> Mask8x2 {
        self.compared(b, super::gt)
    }
    #[inline(always)]
    fn ge(self, b: Self) -> Mask8x2 {
        self.compared(b, super::ge)
    }
    #[inline(always)]
    fn select(mask: Mask8x2, if_true: Self, if_false: Self) -> Self {
        let [low, high] = mask.0;
        let ([true_low, true_high], [false_low, false_high]) = (if_true.0, if_false.0);
        Self([
            low.select(true_low, false_low),
            high.select(true_high, false_high),
        ])
    }
    #[inline(always)]
    fn fold_min(self) -> F32x8 {
        let [low, high] = self.0;
        super::min(low, high)
    }
    #[inline(always)]
    fn fold_max(self) -> F32x8 {
        let [low, high] = self.0;
        super::max(low, high)
    }
    #[inline(always)]
    fn least_of_each(rows: &[Self; MOST_LANES]) -> Self {
        F32x8::least_of_each(&folded(rows, Self::fold_min))
    }
    #[inline(always)]
    fn largest_of_each(rows: &[Self; MOST_LANES]) -> Self {
        F32x8::largest_of_each(&folded(rows, Self::fold_max))
    }
    #[inline(always)]
    fn largest(self) -> f32 {
        self.fold_max().largest()
    }
    #[inline(always)]
    fn push_nearest_last(stack: &mut [u64; 8], near: F32x8, children: &[u32; 8], chosen: u32) -> usize {
        F32x8::push_nearest_last(stack, near, children, chosen)
    }
}
