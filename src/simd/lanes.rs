//! Vectors whose lanes are rays, or triangles: eight or sixteen, the latter in one register where the CPU has AVX-512,
//! else in [two](super::pair). Kernels generic over [`Lanes`] are compiled for each, and those that suit the CPU are
//! chosen when the program runs.
//!
//! A lane's arithmetic does not depend on how many lanes there are: all give the same bits.

use super::{
    F32x8, LANES, Mask8, Vec3x8, ge, gt, le, lt, max, min, mul_add, mul_sub, pair::F32x8x2, splat, stream,
};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// The most lanes that a [`Lanes`] has.
pub const MOST_LANES: usize = 16;

/// Memory for one vector of either width; the narrower one uses the first eight places.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct Column(pub [f32; MOST_LANES]);

impl Column {
    /// The same number in all places.
    #[inline(always)]
    #[must_use]
    pub fn splat(a: f32) -> Self {
        Self([a; MOST_LANES])
    }

    /// Places 0 to 7, then 8 to 15. (A cast of the numbers alone asks at each load whether they lie at a multiple of 32:
    /// kernels of eight lanes 1 to 4 % slower.)
    #[inline(always)]
    #[must_use]
    pub fn halves(&self) -> &[F32x8; 2] {
        bytemuck::must_cast_ref(self)
    }

    /// Places 0 to 7, then 8 to 15.
    #[inline(always)]
    pub fn halves_mut(&mut self) -> &mut [F32x8; 2] {
        bytemuck::must_cast_mut(self)
    }
}

/// One truth value a lane.
pub trait LaneMask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> {
    /// A bit a lane, lane 0 the lowest.
    fn bits(self) -> u32;
    /// The mask with the lanes of `bits`.
    fn from_bits(bits: u32) -> Self;
}

/// Eight or sixteen `f32`. Operations are those of the functions of the same names in [`simd`](super), lane by lane.
#[expect(
    missing_docs,
    reason = "each is what its name says, and its twin in `simd` says more"
)]
pub trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    type Mask: LaneMask;
    /// As many lanes as a bundle has packets: [`MOST_LANES`].
    type Packets: Lanes<Packets = Self::Packets>;
    /// How many lanes.
    const COUNT: usize;

    #[must_use]
    fn splat(a: f32) -> Self;
    #[must_use]
    fn load(from: &Column) -> Self;
    /// Lanes 0 to 7 and, where there are sixteen, 8 to 15. (Not by way of a [`Column`]: a load of what two stores have
    /// written waits for both.)
    #[must_use]
    fn join(low: F32x8, high: F32x8) -> Self;
    /// Lane i: the place of `from` that bits 4 i to 4 i + 3 of `places` tell.
    #[must_use]
    fn picked8(from: &Column, places: u32) -> F32x8;
    /// [`picked8`](Self::picked8) from the first column and, where there are sixteen lanes, from the second one.
    #[must_use]
    fn picked(from: [&Column; 2], places: [u32; 2]) -> Self;
    fn store(self, to: &mut Column);
    /// Writes a cache line, places 0 to 7 and 8 to 15, to memory and leaves it in no cache; see [`stream`].
    ///
    /// # Safety
    /// The same thread calls [`stream::finish`] before anything else reads or writes `to`.
    #[allow(unsafe_code, reason = "this order is the caller's to keep")]
    unsafe fn stream(low: F32x8, high: F32x8, to: &mut Column);
    #[must_use]
    fn mul_add(self, b: Self, c: Self) -> Self;
    #[must_use]
    fn mul_sub(self, b: Self, c: Self) -> Self;
    #[must_use]
    fn min(self, b: Self) -> Self;
    #[must_use]
    fn max(self, b: Self) -> Self;
    #[must_use]
    fn abs(self) -> Self;
    #[must_use]
    fn sqrt(self) -> Self;
    /// The sign bits alone.
    #[must_use]
    fn sign(self) -> Self;
    /// The sign bits, a bit a lane.
    fn sign_bits(self) -> u32;
    /// Signs turned where `sign` has one.
    #[must_use]
    fn turn(self, sign: Self) -> Self;
    fn lt(self, b: Self) -> Self::Mask;
    fn le(self, b: Self) -> Self::Mask;
    fn gt(self, b: Self) -> Self::Mask;
    fn ge(self, b: Self) -> Self::Mask;
    /// `if_true` where set, else `if_false`.
    #[must_use]
    fn select(mask: Self::Mask, if_true: Self, if_false: Self) -> Self;
    /// The smaller of lane i and lane i + 8, for sixteen lanes.
    fn fold_min(self) -> F32x8;
    /// The larger of lane i and lane i + 8, for sixteen lanes.
    fn fold_max(self) -> F32x8;
    /// Lane i: the smallest lane of row i; none may be NaN.
    #[must_use]
    fn least_of_each(rows: &[Self; MOST_LANES]) -> Self::Packets;
    /// Lane i: the largest lane of row i; none may be NaN.
    #[must_use]
    fn largest_of_each(rows: &[Self; MOST_LANES]) -> Self::Packets;
    /// The largest lane; none may be NaN.
    fn largest(self) -> f32;
    /// Writes those of eight [`entry`]s of which `chosen` has a bit to the start of `stack`, nearest last, and answers
    /// how many they are. What follows them in its first eight places is undefined.
    fn push_nearest_last(stack: &mut [u64; 8], near: F32x8, children: &[u32; 8], chosen: u32) -> usize;
}

/// A distance not below 0 and a number, so that entries sort as their distances.
#[inline(always)]
#[must_use]
pub fn entry(near: f32, child: u32) -> u64 {
    u64::from(near.to_bits()) << 32 | u64::from(child)
}

/// What [`entry`] was made of.
#[inline(always)]
#[must_use]
pub fn unpack(entry: u64) -> (f32, u32) {
    (f32::from_bits((entry >> 32) as u32), entry as u32)
}

impl LaneMask for Mask8 {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.bits()
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self::from_bits(bits)
    }
}

impl Lanes for F32x8 {
    type Mask = Mask8;
    type Packets = F32x8x2;
    const COUNT: usize = 8;

    #[inline(always)]
    fn splat(a: f32) -> Self {
        splat(a)
    }
    #[inline(always)]
    fn load(from: &Column) -> Self {
        from.halves()[0]
    }
    #[inline(always)]
    fn join(low: F32x8, _: F32x8) -> Self {
        low
    }
    #[inline(always)]
    fn picked8(from: &Column, places: u32) -> F32x8 {
        super::picked8(from, places)
    }
    #[inline(always)]
    fn picked([from, _]: [&Column; 2], [places, _]: [u32; 2]) -> Self {
        Self::picked8(from, places)
    }
    #[inline(always)]
    fn store(self, to: &mut Column) {
        to.halves_mut()[0] = self;
    }
    #[inline(always)]
    #[allow(unsafe_code, reason = "as in the trait")]
    unsafe fn stream(low: F32x8, high: F32x8, to: &mut Column) {
        // SAFETY: as for this.
        unsafe { stream::by_halves(low, high, to) }
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        mul_add(self, b, c)
    }
    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        mul_sub(self, b, c)
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        min(self, b)
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        max(self, b)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn sign(self) -> Self {
        self & splat(-0.0)
    }
    #[inline(always)]
    fn sign_bits(self) -> u32 {
        self.to_bitmask()
    }
    #[inline(always)]
    fn turn(self, sign: Self) -> Self {
        self ^ sign
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Mask8 {
        lt(self, b)
    }
    #[inline(always)]
    fn le(self, b: Self) -> Mask8 {
        le(self, b)
    }
    #[inline(always)]
    fn gt(self, b: Self) -> Mask8 {
        gt(self, b)
    }
    #[inline(always)]
    fn ge(self, b: Self) -> Mask8 {
        ge(self, b)
    }
    #[inline(always)]
    fn select(mask: Mask8, if_true: Self, if_false: Self) -> Self {
        mask.select(if_true, if_false)
    }
    #[inline(always)]
    fn fold_min(self) -> F32x8 {
        self
    }
    #[inline(always)]
    fn fold_max(self) -> F32x8 {
        self
    }
    #[inline(always)]
    fn least_of_each(rows: &[Self; MOST_LANES]) -> F32x8x2 {
        of_each(rows, min)
    }
    #[inline(always)]
    fn largest_of_each(rows: &[Self; MOST_LANES]) -> F32x8x2 {
        of_each(rows, max)
    }
    #[inline(always)]
    fn largest(self) -> f32 {
        let [a, b]: [wide::f32x4; 2] = bytemuck::cast(self);
        let four = a.fast_max(b).to_array();
        let of = |a: f32, b: f32| if a > b { a } else { b };
        of(of(four[0], four[1]), of(four[2], four[3]))
    }
    #[inline(always)]
    fn push_nearest_last(stack: &mut [u64; 8], near: F32x8, children: &[u32; 8], chosen: u32) -> usize {
        let near = near.to_array();
        let (mut count, mut left) = (0, chosen & 0xff);
        while left != 0 {
            let c = left.trailing_zeros() as usize;
            left &= left - 1;
            let new = entry(near[c % 8], children[c % 8]);
            let mut at = count;
            while at > 0 && stack[(at - 1) % 8] < new {
                stack[at % 8] = stack[(at - 1) % 8];
                at -= 1;
            }
            stack[at % 8] = new;
            count += 1;
        }
        count
    }
}

/// Lane i: all lanes of row i reduced to one.
#[inline(always)]
fn of_each(rows: &[F32x8; MOST_LANES], reduce: impl Fn(F32x8, F32x8) -> F32x8) -> F32x8x2 {
    let mut halves = [[F32x8::ZERO; LANES]; 2];
    for (i, row) in rows.iter().enumerate() {
        halves[i / LANES][i % LANES] = *row;
    }
    let [low, high] = halves;
    let of_eight = |rows| F32x8::transpose(rows).into_iter().reduce(&reduce);
    F32x8x2::join(
        of_eight(low).unwrap_or_default(),
        of_eight(high).unwrap_or_default(),
    )
}

/// A vector a lane, a column an axis.
#[derive(Clone, Copy, Debug)]
pub struct Vec3Lanes<V> {
    /// First components.
    pub x: V,
    /// Second components.
    pub y: V,
    /// Third components.
    pub z: V,
}

impl<V> From<[V; 3]> for Vec3Lanes<V> {
    #[inline(always)]
    fn from([x, y, z]: [V; 3]) -> Self {
        Self { x, y, z }
    }
}

impl<V: Lanes> Vec3Lanes<V> {
    /// From memory.
    #[inline(always)]
    #[must_use]
    pub fn load(from: &[Column; 3]) -> Self {
        let [x, y, z] = [V::load(&from[0]), V::load(&from[1]), V::load(&from[2])];
        Self { x, y, z }
    }

    /// To memory.
    #[inline(always)]
    pub fn store(self, to: &mut [Column; 3]) {
        let [x, y, z] = to;
        self.x.store(x);
        self.y.store(y);
        self.z.store(z);
    }

    /// All lanes the same.
    #[inline(always)]
    #[must_use]
    pub fn splat(v: glam::Vec3) -> Self {
        let [x, y, z] = [V::splat(v.x), V::splat(v.y), V::splat(v.z)];
        Self { x, y, z }
    }

    /// Lanes 0 to 7 and, where there are sixteen, 8 to 15.
    #[inline(always)]
    #[must_use]
    pub fn join(low: Vec3x8, high: Vec3x8) -> Self {
        Self {
            x: V::join(low.x, high.x),
            y: V::join(low.y, high.y),
            z: V::join(low.z, high.z),
        }
    }

    /// The smaller components.
    #[inline(always)]
    #[must_use]
    pub fn min(self, b: Self) -> Self {
        Self {
            x: self.x.min(b.x),
            y: self.y.min(b.y),
            z: self.z.min(b.z),
        }
    }

    /// The larger components.
    #[inline(always)]
    #[must_use]
    pub fn max(self, b: Self) -> Self {
        Self {
            x: self.x.max(b.x),
            y: self.y.max(b.y),
            z: self.z.max(b.z),
        }
    }

    /// The largest absolute component.
    #[inline(always)]
    #[must_use]
    pub fn max_abs(self) -> V {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }

    /// Signs turned where `sign` has one.
    #[inline(always)]
    #[must_use]
    pub fn turn(self, sign: V) -> Self {
        Self {
            x: self.x.turn(sign),
            y: self.y.turn(sign),
            z: self.z.turn(sign),
        }
    }

    /// Twin of [`math::dot`](crate::math::dot).
    #[inline(always)]
    #[must_use]
    pub fn dot(self, b: Self) -> V {
        self.x.mul_add(b.x, self.y.mul_add(b.y, self.z * b.z))
    }

    /// Twin of [`math::cross`](crate::math::cross).
    #[inline(always)]
    #[must_use]
    pub fn cross(self, b: Self) -> Self {
        Self {
            x: self.y.mul_sub(b.z, self.z * b.y),
            y: self.z.mul_sub(b.x, self.x * b.z),
            z: self.x.mul_sub(b.y, self.y * b.x),
        }
    }
}

impl<V: Lanes> Add for Vec3Lanes<V> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self {
            x: self.x + b.x,
            y: self.y + b.y,
            z: self.z + b.z,
        }
    }
}

impl<V: Lanes> Sub for Vec3Lanes<V> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self {
            x: self.x - b.x,
            y: self.y - b.y,
            z: self.z - b.z,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[cfg(target_arch = "x86_64")]
    use crate::simd::avx512;

    fn each_row_is_reduced<V: Lanes>() {
        let mut random = fastrand::Rng::with_seed(7);
        for _ in 0..1000 {
            let numbers = [(); MOST_LANES].map(|()| Column([(); MOST_LANES].map(|()| random.f32() - 0.5)));
            let rows = numbers.each_ref().map(V::load);
            let [mut least, mut largest] = [Column::splat(0.0); 2];
            V::least_of_each(&rows).store(&mut least);
            V::largest_of_each(&rows).store(&mut largest);
            for (i, row) in numbers.iter().enumerate() {
                let row = &row.0[..V::COUNT];
                assert_eq!(
                    least.0[i],
                    row.iter().copied().fold(f32::MAX, f32::min),
                    "row {i}"
                );
                assert_eq!(
                    largest.0[i],
                    row.iter().copied().fold(-f32::MAX, f32::max),
                    "row {i}"
                );
            }
        }
    }

    /// Zeros of both signs among few others, so that some are equal.
    fn column(random: &mut fastrand::Rng) -> Column {
        let numbers = [0.0, -0.0, 1.0, -1.0, 0.3, -0.3, 1e30, -1e-30];
        Column([(); MOST_LANES].map(|()| match random.usize(..16) {
            i if i < numbers.len() => numbers[i],
            _ => random.f32() - 0.5,
        }))
    }

    fn bits_of<V: Lanes>(v: V) -> [u32; MOST_LANES] {
        let mut column = Column::splat(0.0);
        v.store(&mut column);
        column.0.map(f32::to_bits)
    }

    /// Sixteen lanes do what eight do, half by half.
    #[expect(clippy::cognitive_complexity, reason = "one line an operation")]
    fn halves_are_as_eight_lanes<V: Lanes>() {
        let mut random = fastrand::Rng::with_seed(11);
        for _ in 0..2000 {
            let columns = [(); 3].map(|()| column(&mut random));
            let half = |i: usize| columns.each_ref().map(|column| column.halves()[i]);
            macro_rules! same {
                (|$a:ident, $b:ident, $c:ident| $result:expr) => {{
                    let whole = {
                        let [$a, $b, $c] = columns.each_ref().map(V::load);
                        bits_of($result)
                    };
                    for i in 0..2 {
                        let [$a, $b, $c] = half(i);
                        let (of_half, of_whole) = (bits_of($result), &whole[i * 8..][..8]);
                        assert_eq!(&of_half[..8], of_whole, stringify!($result));
                    }
                }};
            }
            macro_rules! same_bits {
                (|$a:ident, $b:ident| $result:expr) => {{
                    let whole = {
                        let [$a, $b, _] = columns.each_ref().map(V::load);
                        $result
                    };
                    let [low, high] = [0, 1].map(|i| {
                        let [$a, $b, _] = half(i);
                        $result
                    });
                    assert_eq!(low | high << 8, whole, stringify!($result));
                }};
            }
            same!(|a, b, _c| a + b);
            same!(|a, b, _c| a - b);
            same!(|a, b, _c| a * b);
            same!(|a, b, _c| a / b);
            same!(|a, _b, _c| -a);
            same!(|a, b, c| Lanes::mul_add(a, b, c));
            same!(|a, b, c| Lanes::mul_sub(a, b, c));
            same!(|a, b, _c| Lanes::min(a, b));
            same!(|a, b, _c| Lanes::max(a, b));
            same!(|a, _b, _c| Lanes::abs(a));
            same!(|a, _b, _c| Lanes::sqrt(Lanes::abs(a)));
            same!(|a, _b, _c| Lanes::sign(a));
            same!(|a, b, _c| Lanes::turn(a, Lanes::sign(b)));
            same!(|a, b, c| Lanes::select(Lanes::lt(a, b), b, c));
            same!(|a, b, c| Lanes::select(Lanes::le(a, b) & Lanes::gt(b, c), b, c));
            same!(|a, b, c| Lanes::select(Lanes::ge(a, b) | Lanes::lt(b, c), b, c));
            same_bits!(|a, b| Lanes::lt(a, b).bits());
            same_bits!(|a, b| Lanes::le(a, b).bits());
            same_bits!(|a, b| Lanes::gt(a, b).bits());
            same_bits!(|a, b| Lanes::ge(a, b).bits());
            same_bits!(|a, _b| Lanes::sign_bits(a));

            let [low, high] = *columns[0].halves();
            let whole = V::load(&columns[0]);
            assert_eq!(bits_of(V::join(low, high)), bits_of(whole));
            assert_eq!(bits_of(whole.fold_min()), bits_of(Lanes::min(low, high)));
            assert_eq!(bits_of(whole.fold_max()), bits_of(Lanes::max(low, high)));
            assert_eq!(whole.largest(), Lanes::max(low, high).largest());
            let places = [random.u32(..), random.u32(..)];
            let picked = bits_of(V::picked([&columns[0], &columns[1]], places));
            for (i, word) in places.into_iter().enumerate() {
                let of_half = F32x8::picked([&columns[i], &columns[i]], [word, word]);
                assert_eq!(&bits_of(of_half)[..8], &picked[i * 8..][..8]);
                assert_eq!(
                    bits_of(V::picked8(&columns[i], word)),
                    bits_of(F32x8::picked8(&columns[i], word))
                );
            }
            let chosen = random.u32(..256);
            let (near, children) = (Lanes::abs(low), [(); 8].map(|()| random.u32(..)));
            let (mut stack, mut expected) = ([0; 8], [0; 8]);
            let count = V::push_nearest_last(&mut stack, near, &children, chosen);
            assert_eq!(
                F32x8::push_nearest_last(&mut expected, near, &children, chosen),
                count
            );
            assert_eq!(stack[..count], expected[..count]);
        }
        for bits in 0..1 << MOST_LANES {
            assert_eq!(V::Mask::from_bits(bits).bits(), bits);
        }
    }

    #[test]
    fn sixteen_lanes_are_as_eight_twice() {
        halves_are_as_eight_lanes::<F32x8x2>();
        #[cfg(target_arch = "x86_64")]
        if avx512::is_available() {
            halves_are_as_eight_lanes::<avx512::F32x16>();
        }
    }

    #[test]
    fn each_row_is_reduced_to_its_lane() {
        each_row_is_reduced::<F32x8>();
        each_row_is_reduced::<F32x8x2>();
        #[cfg(target_arch = "x86_64")]
        if avx512::is_available() {
            each_row_is_reduced::<avx512::F32x16>();
        }
    }
}
