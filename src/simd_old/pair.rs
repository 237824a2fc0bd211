//! Twice as many lanes, as two vectors: sixteen for CPUs without AVX-512, thirty-two (`avx512::F32x16x2`) with it.
//!
//! Sixteen lanes serve as packet numbers (bundles of sixteen packets) and, where a register [holds eight](IS_FAST),
//! as rays that share their origin: more rays pass each node and leaf together.
// Tuned: see docs/lab-notes.md#pairs-of-vectors

use super::{
    F32x8,
    lanes::{Column, LaneMask, Lanes, Memory, REGISTER_LANES, TriangleLanes},
};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// Whether packets of sixteen rays pay as two eights: a register of this build holds eight lanes.
pub const IS_FAST: bool = cfg!(target_feature = "avx");

/// A vector that pairs are made of: [`F32x8`], or `avx512::F32x16`.
pub trait Half: Lanes<Memory = Column> {
    /// Memory for two.
    type Whole: Memory;
    /// Loads the lower lanes, then the upper ones.
    fn load_both(from: &Self::Whole) -> [Self; 2];
    /// Stores the lower lanes, then the upper ones.
    fn store_both(both: [Self; 2], to: &mut Self::Whole);
    /// Does [`Lanes::fold_min_to_16`] of the two.
    fn fold_both_min(both: [Self; 2]) -> Self::Packets;
    /// Does [`Lanes::fold_max_to_16`] of the two.
    fn fold_both_max(both: [Self; 2]) -> Self::Packets;
}

/// The lower lanes, then the upper ones.
#[derive(Clone, Copy, Debug)]
pub struct Pair<H>([H; 2]);

/// A truth value for each lane of a [`Pair`].
#[derive(Clone, Copy, Debug)]
pub struct PairMask<H: Lanes>([H::Mask; 2]);

/// Sixteen lanes.
pub type F32x8x2 = Pair<F32x8>;

impl Half for F32x8 {
    type Whole = Column;

    #[inline(always)]
    fn load_both(from: &Column) -> [Self; 2] {
        *from.halves()
    }
    #[inline(always)]
    fn store_both(both: [Self; 2], to: &mut Column) {
        *to.halves_mut() = both;
    }
    #[inline(always)]
    fn fold_both_min(both: [Self; 2]) -> F32x8x2 {
        Pair(both)
    }
    #[inline(always)]
    fn fold_both_max(both: [Self; 2]) -> F32x8x2 {
        Pair(both)
    }
}

impl<H: Half> Pair<H> {
    #[inline(always)]
    fn of(self, f: impl Fn(H) -> H) -> Self {
        let [low, high] = self.0;
        Self([f(low), f(high)])
    }

    #[inline(always)]
    fn with(self, b: Self, f: impl Fn(H, H) -> H) -> Self {
        let ([low, high], [b_low, b_high]) = (self.0, b.0);
        Self([f(low, b_low), f(high, b_high)])
    }

    #[inline(always)]
    fn with_both(self, b: Self, c: Self, f: impl Fn(H, H, H) -> H) -> Self {
        let ([low, high], [b_low, b_high], [c_low, c_high]) = (self.0, b.0, c.0);
        Self([f(low, b_low, c_low), f(high, b_high, c_high)])
    }

    #[inline(always)]
    fn compared(self, b: Self, f: impl Fn(H, H) -> H::Mask) -> PairMask<H> {
        let ([low, high], [b_low, b_high]) = (self.0, b.0);
        PairMask([f(low, b_low), f(high, b_high)])
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $of:ty) => {
        impl<H: Half> $trait for $of {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                let ([low, high], [b_low, b_high]) = (self.0, b.0);
                Self([low.$method(b_low), high.$method(b_high)])
            }
        }
    };
}
operator!(Add, add, Pair<H>);
operator!(Sub, sub, Pair<H>);
operator!(Mul, mul, Pair<H>);
operator!(Div, div, Pair<H>);
operator!(BitAnd, bitand, PairMask<H>);
operator!(BitOr, bitor, PairMask<H>);

impl<H: Half> Neg for Pair<H> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.of(Neg::neg)
    }
}

impl<H: Half> LaneMask for PairMask<H> {
    #[inline(always)]
    fn bits(self) -> u32 {
        let [low, high] = self.0;
        low.bits() | high.bits() << H::COUNT
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self([H::Mask::from_bits(bits), H::Mask::from_bits(bits >> H::COUNT)])
    }
}

/// Each row folded to eight lanes.
#[inline(always)]
fn folded(rows: &[F32x8x2; REGISTER_LANES], fold: impl Fn(F32x8x2) -> F32x8) -> [F32x8; REGISTER_LANES] {
    let mut folded = [F32x8::ZERO; REGISTER_LANES];
    for (to, row) in folded.iter_mut().zip(rows) {
        *to = fold(*row);
    }
    folded
}

impl TriangleLanes for F32x8x2 {
    #[inline(always)]
    fn picked8(from: &Column, places: u32) -> F32x8 {
        super::picked8(from, places)
    }
    #[inline(always)]
    fn picked([low, high]: [&Column; 2], [low_places, high_places]: [u32; 2]) -> Self {
        Self([super::picked8(low, low_places), super::picked8(high, high_places)])
    }
    #[inline(always)]
    fn least_of_each(rows: &[Self; REGISTER_LANES]) -> Self {
        F32x8::least_of_each(&folded(rows, Self::fold_min))
    }
    #[inline(always)]
    fn largest_of_each(rows: &[Self; REGISTER_LANES]) -> Self {
        F32x8::largest_of_each(&folded(rows, Self::fold_max))
    }
}

impl<H: Half> Lanes for Pair<H> {
    type Mask = PairMask<H>;
    type Memory = H::Whole;
    type Packets = H::Packets;
    type Triangles = H::Packets;
    const COUNT: usize = 2 * H::COUNT;

    #[inline(always)]
    fn splat(a: f32) -> Self {
        Self([H::splat(a); 2])
    }
    #[inline(always)]
    fn load(from: &H::Whole) -> Self {
        Self(H::load_both(from))
    }
    #[inline(always)]
    fn of_eights([a, b, c, d]: [F32x8; 4]) -> Self {
        let high = if H::COUNT == 8 { [b, b, b, b] } else { [c, d, c, d] };
        Self([H::of_eights([a, b, a, b]), H::of_eights(high)])
    }
    #[inline(always)]
    fn store(self, to: &mut H::Whole) {
        H::store_both(self.0, to);
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self.with_both(b, c, H::mul_add)
    }
    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        self.with_both(b, c, H::mul_sub)
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        self.with(b, H::min)
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        self.with(b, H::max)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.of(H::abs)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.of(H::sqrt)
    }
    #[inline(always)]
    fn sign(self) -> Self {
        self.of(H::sign)
    }
    #[inline(always)]
    fn sign_bits(self) -> u32 {
        let [low, high] = self.0;
        low.sign_bits() | high.sign_bits() << H::COUNT
    }
    #[inline(always)]
    fn turn(self, sign: Self) -> Self {
        self.with(sign, H::turn)
    }
    #[inline(always)]
    fn lt(self, b: Self) -> PairMask<H> {
        self.compared(b, H::lt)
    }
    #[inline(always)]
    fn le(self, b: Self) -> PairMask<H> {
        self.compared(b, H::le)
    }
    #[inline(always)]
    fn gt(self, b: Self) -> PairMask<H> {
        self.compared(b, H::gt)
    }
    #[inline(always)]
    fn ge(self, b: Self) -> PairMask<H> {
        self.compared(b, H::ge)
    }
    #[inline(always)]
    fn not_lt(self, b: Self, lanes: PairMask<H>) -> PairMask<H> {
        let ([low, high], [b_low, b_high], [lanes_low, lanes_high]) = (self.0, b.0, lanes.0);
        PairMask([low.not_lt(b_low, lanes_low), high.not_lt(b_high, lanes_high)])
    }
    #[inline(always)]
    fn not_gt(self, b: Self, lanes: PairMask<H>) -> PairMask<H> {
        let ([low, high], [b_low, b_high], [lanes_low, lanes_high]) = (self.0, b.0, lanes.0);
        PairMask([low.not_gt(b_low, lanes_low), high.not_gt(b_high, lanes_high)])
    }
    #[inline(always)]
    fn select(mask: PairMask<H>, if_true: Self, if_false: Self) -> Self {
        let [low, high] = mask.0;
        let ([true_low, true_high], [false_low, false_high]) = (if_true.0, if_false.0);
        Self([
            H::select(low, true_low, false_low),
            H::select(high, true_high, false_high),
        ])
    }
    #[inline(always)]
    fn fold_min(self) -> F32x8 {
        let [low, high] = self.0;
        low.min(high).fold_min()
    }
    #[inline(always)]
    fn fold_max(self) -> F32x8 {
        let [low, high] = self.0;
        low.max(high).fold_max()
    }
    #[inline(always)]
    fn fold_min_to_16(self) -> H::Packets {
        H::fold_both_min(self.0)
    }
    #[inline(always)]
    fn fold_max_to_16(self) -> H::Packets {
        H::fold_both_max(self.0)
    }
    #[inline(always)]
    fn largest(self) -> f32 {
        self.fold_max().largest()
    }
    #[inline(always)]
    fn nearest_last(near: F32x8, chosen: u32) -> ([u32; 8], usize) {
        H::nearest_last(near, chosen)
    }
}
