//! Temporary: arithmetic on memory, until everything goes by levels.
#![allow(missing_docs, reason = "temporary")]
use crate::lanes::{F32x8, Vec3x8};
use std::ops::*;
use wide::f32x8;
#[inline(always)]
fn w(a: F32x8) -> f32x8 {
    bytemuck::must_cast(a)
}
#[inline(always)]
fn m(a: f32x8) -> F32x8 {
    bytemuck::must_cast(a)
}
macro_rules! binary { ($($trait:ident $method:ident),*) => { $(impl $trait for F32x8 { type Output = Self;
    #[inline(always)] fn $method(self, b: Self) -> Self { m(w(self).$method(w(b))) } })* } }
binary!(Add add, Sub sub, Mul mul, Div div, BitAnd bitand, BitOr bitor, BitXor bitxor);
macro_rules! assign { ($($trait:ident $method:ident $op:tt),*) => { $(impl $trait for F32x8 {
    #[inline(always)] fn $method(&mut self, b: Self) { *self = *self $op b; } })* } }
assign!(AddAssign add_assign +, SubAssign sub_assign -, MulAssign mul_assign *);
impl Neg for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        m(-w(self))
    }
}
impl Not for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        m(!w(self))
    }
}
macro_rules! methods { ($($name:ident($($b:ident),*)),*) => { impl F32x8 { $(#[inline(always)] pub fn $name(self, $($b: Self),*) -> Self { m(w(self).$name($(w($b)),*)) })* } } }
methods!(
    abs(),
    sqrt(),
    fast_max(b),
    fast_min(b),
    simd_lt(b),
    simd_le(b),
    simd_gt(b),
    simd_ge(b),
    simd_eq(b),
    select(a, b),
    mul_add(b, c),
    mul_sub(b, c)
);
impl F32x8 {
    #[inline(always)]
    pub fn to_bitmask(self) -> u32 {
        w(self).to_bitmask()
    }
    #[inline(always)]
    pub fn reduce_add(self) -> f32 {
        w(self).reduce_add()
    }
    #[inline(always)]
    pub fn fast_trunc_int(self) -> wide::i32x8 {
        w(self).fast_trunc_int()
    }
    #[inline(always)]
    pub fn transpose(rows: [Self; 8]) -> [Self; 8] {
        f32x8::transpose(rows.map(w)).map(m)
    }
}
