//! Prefetches nodes and blocks before they are visited.
#![allow(
    unsafe_code,
    reason = "prefetching has no safe name; see docs/lab-notes.md#prefetch-nodes"
)]

use super::{Bvh, Child, TriangleBlocks};

/// The address and size of each [kind](Child::kind) of child, to prefetch without a branch on the kind.
#[derive(Debug)]
pub(crate) struct Places([(*const u8, usize); 4]);

impl Bvh {
    /// Creates it for the hierarchy's nodes and blocks.
    #[inline(always)]
    #[must_use]
    pub(crate) fn places(&self) -> Places {
        fn of<T>(column: &[T]) -> (*const u8, usize) {
            (column.as_ptr().cast(), size_of::<T>())
        }
        let triangles = match self.triangle_blocks() {
            TriangleBlocks::Whole(blocks) => of(blocks),
            TriangleBlocks::Indexed(blocks) => of(blocks),
        };
        Places([
            of(self.nodes()),
            triangles,
            of(self.sphere_blocks()),
            of::<u8>(&[]),
        ])
    }
}

impl Places {
    /// Prefetches the memory of `child`, which will be visited soon: as many cache lines as a block of triangles has, whatever
    /// it is.
    // Tuned: see docs/lab-notes.md#prefetch-nodes
    #[inline(always)]
    pub fn prefetch(&self, child: Child) {
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            let ((base, size), (_, of_block)) = (self.0[child.kind()], self.0[1]);
            let start = base.wrapping_add(child.index() * size);
            for offset in [0, 64, 128, 192, of_block - 64] {
                // SAFETY: a prefetch reads nothing and never faults.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(offset).cast()) };
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = (self.0, child);
    }
}

/// Prefetches all cache lines of `element`, which will be used soon.
#[inline(always)]
pub fn prefetch<T>(element: &T) {
    #[cfg(target_arch = "x86_64")]
    all_lines::<T, { std::arch::x86_64::_MM_HINT_T0 }>(element);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = element;
}

/// Prefetches all cache lines of `element` into the L2 cache, for later use.
// Tuned: see docs/lab-notes.md#prefetch-rays
#[inline(always)]
pub fn prefetch_for_later<T>(element: &T) {
    #[cfg(target_arch = "x86_64")]
    all_lines::<T, { std::arch::x86_64::_MM_HINT_T1 }>(element);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = element;
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn all_lines<T, const HINT: i32>(element: &T) {
    let start = std::ptr::from_ref(element).cast::<i8>();
    for offset in (0..size_of::<T>()).step_by(64) {
        // SAFETY: the addresses are within `element`, and a prefetch reads nothing.
        unsafe { std::arch::x86_64::_mm_prefetch::<HINT>(start.add(offset)) };
    }
}
