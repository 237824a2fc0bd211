//! The portable level: the instructions that the build was compiled for, by `wide`. The only module that uses it.

use super::{
    Column, EightLanes, LaneMask, Lanes, Pair, REGISTER_LANES, Simd, TriangleLanes, lanes, pair::reduced_rows,
};
use crate::{
    lanes::{F32x8, LANES},
    math::{self, fused},
};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};
use wide::f32x8;

/// The token of the instructions that every CPU of the build has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Portable;

impl Simd for Portable {
    type V8 = V8;
    type V16 = Pair<V8>;

    #[inline(always)]
    fn call<R>(self, f: impl FnOnce() -> R) -> R {
        // A separate function, as at other levels: without optimisation it does not enlarge the caller's stack frame.
        fn inner<R>(f: impl FnOnce() -> R) -> R {
            f()
        }
        inner(f)
    }
    #[inline(always)]
    fn mul_add(self, a: f32, b: f32, c: f32) -> f32 {
        fused::mul_add(a, b, c)
    }
}

/// Eight lanes.
#[derive(Clone, Copy, Debug)]
pub struct V8(f32x8);

/// Not inlined, because it is some hundred instructions and used everywhere in tracing and shading.
#[inline(never)]
fn fused_by_lane(a: f32x8, b: f32x8, c: f32x8) -> f32x8 {
    let (a, b, c) = (a.to_array(), b.to_array(), c.to_array());
    let mut sums = [0.0; LANES];
    for (i, sum) in sums.iter_mut().enumerate() {
        *sum = fused::emulated(a[i], b[i], c[i]);
    }
    f32x8::new(sums)
}

/// Eight truth values: all bits of a lane set, or none.
#[derive(Clone, Copy, Debug)]
pub struct Mask8(f32x8);

macro_rules! operator {
    ($trait:ident, $method:ident, $of:ident) => {
        impl $trait for $of {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                Self(self.0.$method(b.0))
            }
        }
    };
}
operator!(Add, add, V8);
operator!(Sub, sub, V8);
operator!(Mul, mul, V8);
operator!(Div, div, V8);
operator!(BitAnd, bitand, Mask8);
operator!(BitOr, bitor, Mask8);

impl Mul<f32> for V8 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, b: f32) -> Self {
        Self(self.0 * f32x8::splat(b))
    }
}

impl Neg for V8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Not for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl LaneMask for Mask8 {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.to_bitmask()
    }
}

/// The lanes as memory holds them, and back.
#[inline(always)]
fn memory(a: f32x8) -> F32x8 {
    bytemuck::must_cast(a)
}

impl Lanes for V8 {
    type Simd = Portable;
    type Mask = Mask8;
    type Memory = Column;
    type Packets = Pair<Self>;
    type Triangles = Self;
    const COUNT: usize = LANES;

    #[inline(always)]
    fn simd(self) -> Portable {
        Portable
    }
    #[inline(always)]
    fn splat(_: Portable, a: f32) -> Self {
        Self(f32x8::splat(a))
    }
    #[inline(always)]
    fn mask(_: Portable, bits: u32) -> Mask8 {
        let lane_bit8 = wide::i32x8::new([1, 2, 4, 8, 16, 32, 64, 128]);
        let set8 = (wide::i32x8::splat(bits.cast_signed()) & lane_bit8).simd_eq(lane_bit8);
        Mask8(bytemuck::cast(set8))
    }
    #[inline(always)]
    fn load(simd: Portable, from: &Column) -> Self {
        Self::load8(simd, &from.halves()[0])
    }
    #[inline(always)]
    fn of_eights(simd: Portable, [eight, ..]: [&F32x8; 4]) -> Self {
        Self::load8(simd, eight)
    }
    #[inline(always)]
    fn store(self, to: &mut Column) {
        to.halves_mut()[0] = self.to8();
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        if fused::IS_COMPILED_IN {
            return Self(self.0.mul_add(b.0, c.0));
        }
        Self(fused_by_lane(self.0, b.0, c.0))
    }
    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        self.mul_add(b, -c)
    }
    #[inline(always)]
    fn mul_add_approx(self, b: Self, c: Self) -> Self {
        if fused::IS_COMPILED_IN {
            self.mul_add(b, c)
        } else {
            self * b + c
        }
    }
    #[inline(always)]
    fn mul_sub_approx(self, b: Self, c: Self) -> Self {
        if fused::IS_COMPILED_IN {
            self.mul_sub(b, c)
        } else {
            self * b - c
        }
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        if cfg!(target_arch = "x86_64") {
            Self(self.0.fast_min(b.0))
        } else {
            Self::select(self.lt(b), self, b)
        }
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        if cfg!(target_arch = "x86_64") {
            Self(self.0.fast_max(b.0))
        } else {
            Self::select(self.gt(b), self, b)
        }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    #[inline(always)]
    fn sign(self) -> Self {
        Self(self.0 & f32x8::splat(-0.0))
    }
    #[inline(always)]
    fn sign_bits(self) -> u32 {
        self.0.to_bitmask()
    }
    #[inline(always)]
    fn flip_signs(self, sign: Self) -> Self {
        Self(self.0 ^ sign.0)
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Mask8 {
        Mask8(self.0.simd_lt(b.0))
    }
    #[inline(always)]
    fn le(self, b: Self) -> Mask8 {
        Mask8(self.0.simd_le(b.0))
    }
    #[inline(always)]
    fn gt(self, b: Self) -> Mask8 {
        Mask8(self.0.simd_gt(b.0))
    }
    #[inline(always)]
    fn ge(self, b: Self) -> Mask8 {
        Mask8(self.0.simd_ge(b.0))
    }
    #[inline(always)]
    fn eq(self, b: Self) -> Mask8 {
        Mask8(self.0.simd_eq(b.0))
    }
    #[inline(always)]
    fn not_lt(self, b: Self, lanes: Mask8) -> Mask8 {
        lanes & !self.lt(b)
    }
    #[inline(always)]
    fn not_gt(self, b: Self, lanes: Mask8) -> Mask8 {
        lanes & !self.gt(b)
    }
    #[inline(always)]
    fn select(mask: Mask8, if_true: Self, if_false: Self) -> Self {
        Self(mask.0.select(if_true.0, if_false.0))
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

impl TriangleLanes for V8 {
    #[inline(always)]
    fn picked(simd: Portable, [from, _]: [&Column; 2], [places, _]: [u32; 2]) -> Self {
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

impl EightLanes for V8 {
    #[inline(always)]
    fn transposed(rows: [Self; LANES]) -> [Self; LANES] {
        let [a, b, c, d, e, f, g, h] = rows;
        let [a, b, c, d, e, f, g, h] = f32x8::transpose([a.0, b.0, c.0, d.0, e.0, f.0, g.0, h.0]);
        [V8(a), V8(b), V8(c), V8(d), V8(e), V8(f), V8(g), V8(h)]
    }
    #[inline(always)]
    fn load8(_: Portable, from: &F32x8) -> Self {
        Self(bytemuck::must_cast(*from))
    }
    #[inline(always)]
    fn to8(self) -> F32x8 {
        memory(self.0)
    }
    #[inline(always)]
    fn picked8(simd: Portable, from: &Column, places: u32) -> Self {
        let place = |i: u32| from.0[(places >> (4 * i)) as usize & 15];
        let lanes = [
            place(0),
            place(1),
            place(2),
            place(3),
            place(4),
            place(5),
            place(6),
            place(7),
        ];
        Self::load8(simd, &F32x8::new(lanes))
    }
    #[inline(always)]
    fn largest_of_eight(self) -> f32 {
        let [a, b]: [wide::f32x4; 2] = bytemuck::cast(self.0);
        let [a, b, c, d] = a.fast_max(b).to_array();
        math::max(math::max(a, b), math::max(c, d))
    }
    #[inline(always)]
    fn min_everywhere(self) -> Self {
        let [low, high]: [wide::f32x4; 2] = bytemuck::cast(self.0);
        let [a, b, c, d] = low.fast_min(high).to_array();
        self.all(math::min(math::min(a, b), math::min(c, d)))
    }
    #[inline(always)]
    fn swap_halves(self) -> Self {
        let [low, high]: [wide::f32x4; 2] = bytemuck::cast(self.0);
        Self(bytemuck::cast([high, low]))
    }
    #[inline(always)]
    fn same_bits(self, b: Self) -> u32 {
        let [a, b]: [wide::u32x8; 2] = [bytemuck::cast(self.0), bytemuck::cast(b.0)];
        bytemuck::cast::<_, f32x8>(a.simd_eq(b)).to_bitmask()
    }
    #[inline(always)]
    fn trunc(self) -> [i32; LANES] {
        self.0.fast_trunc_int().to_array()
    }
    #[inline(always)]
    fn byte_pairs([a, b, c]: [Self; 3]) -> [u64; LANES / 2] {
        let [a, b, c]: [wide::u32x8; 3] = [
            bytemuck::cast(a.0.fast_trunc_int()),
            bytemuck::cast(b.0.fast_trunc_int()),
            bytemuck::cast(c.0.fast_trunc_int()),
        ];
        let packed: wide::u32x8 = a | (b << 8_u32) | (c << 16_u32);
        let mut pairs: wide::u64x4 = bytemuck::cast(packed);
        if cfg!(target_endian = "big") {
            pairs = (pairs << 32_u32) | (pairs >> 32_u32);
        }
        let second = (pairs >> 32_u32) << 24_u32;
        ((pairs & wide::u64x4::splat(0xff_ffff)) | second).to_array()
    }
    #[inline(always)]
    fn scale_to_one(self) -> Self {
        let bits: wide::u32x8 = bytemuck::cast(self.0);
        let one_less = wide::u32x8::splat(254 << 23) - (bits & wide::u32x8::splat(math::EXPONENT));
        Self(bytemuck::cast(one_less))
    }
    #[inline(always)]
    fn nearest_last(self, chosen: u32) -> ([u32; LANES], usize) {
        lanes::nearest_last(self.0.to_array(), chosen)
    }
}
