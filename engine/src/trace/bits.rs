//! Small loops of the kernels, without closures and iterator adaptors: when those are not inlined, they do not inherit
//! the kernel's instruction set.

/// The set bits of a mask, lowest first.
#[inline(always)]
pub(super) fn bits(mask: u32) -> Bits {
    Bits(u64::from(mask))
}

/// As [`bits`].
#[inline(always)]
pub(super) fn bits64(mask: u64) -> Bits {
    Bits(mask)
}

/// See [`bits`].
pub(super) struct Bits(u64);

impl Iterator for Bits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let lowest = self.0.trailing_zeros() as usize;
        self.0 &= self.0 - 1;
        Some(lowest)
    }
}

/// Part `i` of a slice that is divided into parts of `size`; empty beyond its end. (Chunks that are zipped are not always
/// inlined.)
#[inline(always)]
pub(super) fn part<T>(all: &[T], i: usize, size: usize) -> &[T] {
    &all[(i * size).min(all.len())..((i + 1) * size).min(all.len())]
}

/// The axis of the largest number, the last of equal ones.
#[inline(always)]
pub(super) fn largest_axis(numbers: [f32; 3]) -> usize {
    let last = if numbers[2] >= numbers[1] { 2 } else { 1 };
    if numbers[last] >= numbers[0] { last } else { 0 }
}
