//! Twice as many lanes, as two vectors: sixteen without AVX-512, thirty-two with it.
//!
//! They hold values per packet (bundles of sixteen packets), or rays with a shared origin, so that more rays pass each node
//! and leaf together.
// Tuned: see docs/lab-notes.md#pairs-of-vectors

use super::{Column, Eight, EightLanes, LaneMask, Lanes, Memory, REGISTER_LANES, TriangleLanes};
use crate::lanes::{F32x8, LANES};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// A vector that pairs are made of.
pub trait Half: Lanes<Memory = Column> {
    /// Memory for two.
    type Whole: Memory;
    /// Loads the lower lanes, then the upper ones.
    fn load_both(simd: Self::Simd, from: &Self::Whole) -> [Self; 2];
    /// Stores the lower lanes, then the upper ones.
    fn store_both(both: [Self; 2], to: &mut Self::Whole);
    /// [`Lanes::fold_min_to_16`] of the two.
    fn fold_both_min(both: [Self; 2]) -> Self::Packets;
    /// [`Lanes::fold_max_to_16`] of the two.
    fn fold_both_max(both: [Self; 2]) -> Self::Packets;
}

impl<V: EightLanes> Half for V {
    type Whole = Column;

    #[inline(always)]
    fn load_both(simd: V::Simd, from: &Column) -> [Self; 2] {
        let [low, high] = from.halves();
        [Self::load8(simd, low), Self::load8(simd, high)]
    }
    #[inline(always)]
    fn store_both([low, high]: [Self; 2], to: &mut Column) {
        *to.halves_mut() = [low.to8(), high.to8()];
    }
    #[inline(always)]
    fn fold_both_min(both: [Self; 2]) -> Pair<Self> {
        Pair(both)
    }
    #[inline(always)]
    fn fold_both_max(both: [Self; 2]) -> Pair<Self> {
        Pair(both)
    }
}

/// The lower lanes, then the upper ones.
#[derive(Clone, Copy, Debug)]
pub struct Pair<H>(pub(super) [H; 2]);

/// A truth value for each lane of a [`Pair`].
#[derive(Clone, Copy, Debug)]
pub struct PairMask<H: Lanes>([H::Mask; 2]);

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

impl<H: Half> Mul<f32> for Pair<H> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: f32) -> Self {
        let [low, high] = self.0;
        Self([low * b, high * b])
    }
}

impl<H: Half> Not for PairMask<H> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        let [low, high] = self.0;
        Self([!low, !high])
    }
}

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
}

/// Returns in lane i all lanes of row i reduced to one, by columns of eight rows.
#[inline(always)]
pub(super) fn reduced_rows<V: EightLanes>(rows: &[V; REGISTER_LANES], of: impl Fn(V, V) -> V) -> Pair<V> {
    let mut halves = [rows[0]; 2];
    for (half, rows) in halves.iter_mut().zip(rows.as_chunks::<LANES>().0) {
        let [a, b, c, d, e, f, g, h] = V::transposed(*rows);
        *half = of(of(of(a, b), of(c, d)), of(of(e, f), of(g, h)));
    }
    Pair(halves)
}

impl<V: EightLanes> TriangleLanes for Pair<V> {
    #[inline(always)]
    fn picked(simd: V::Simd, [low, high]: [&Column; 2], [low_places, high_places]: [u32; 2]) -> Self {
        Self([
            V::picked8(simd, low, low_places),
            V::picked8(simd, high, high_places),
        ])
    }
    #[inline(always)]
    fn least_of_each(rows: &[Self; REGISTER_LANES]) -> Self {
        let mut folded = [rows[0].0[0]; REGISTER_LANES];
        for (to, Pair([low, high])) in folded.iter_mut().zip(rows) {
            *to = low.min(*high);
        }
        V::least_of_each(&folded)
    }
    #[inline(always)]
    fn largest_of_each(rows: &[Self; REGISTER_LANES]) -> Self {
        let mut folded = [rows[0].0[0]; REGISTER_LANES];
        for (to, Pair([low, high])) in folded.iter_mut().zip(rows) {
            *to = low.max(*high);
        }
        V::largest_of_each(&folded)
    }
}

impl<H: Half> Lanes for Pair<H> {
    type Simd = H::Simd;
    type Mask = PairMask<H>;
    type Memory = H::Whole;
    type Packets = H::Packets;
    type Triangles = H::Packets;
    const COUNT: usize = 2 * H::COUNT;

    #[inline(always)]
    fn simd(self) -> H::Simd {
        self.0[0].simd()
    }
    #[inline(always)]
    fn splat(simd: H::Simd, a: f32) -> Self {
        Self([H::splat(simd, a); 2])
    }
    #[inline(always)]
    fn mask(simd: H::Simd, bits: u32) -> PairMask<H> {
        PairMask([H::mask(simd, bits), H::mask(simd, bits >> H::COUNT)])
    }
    #[inline(always)]
    fn load(simd: H::Simd, from: &H::Whole) -> Self {
        Self(H::load_both(simd, from))
    }
    #[inline(always)]
    fn of_eights(simd: H::Simd, [a, b, c, d]: [&F32x8; 4]) -> Self {
        let high = if H::COUNT == 8 { [b, b, b, b] } else { [c, d, c, d] };
        Self([H::of_eights(simd, [a, b, a, b]), H::of_eights(simd, high)])
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
    fn mul_add_approx(self, b: Self, c: Self) -> Self {
        self.with_both(b, c, H::mul_add_approx)
    }
    #[inline(always)]
    fn mul_sub_approx(self, b: Self, c: Self) -> Self {
        self.with_both(b, c, H::mul_sub_approx)
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
    fn flip_signs(self, sign: Self) -> Self {
        self.with(sign, H::flip_signs)
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
    fn eq(self, b: Self) -> PairMask<H> {
        self.compared(b, H::eq)
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
    fn fold_min(self) -> Eight<Self> {
        let [low, high] = self.0;
        low.min(high).fold_min()
    }
    #[inline(always)]
    fn fold_max(self) -> Eight<Self> {
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
}
