//! Asking memory for a node or block before it is visited.
#![allow(
    unsafe_code,
    reason = "prefetching has no safe name; a quarter of the time of camera rays on a million triangles was waiting for \
              the first number of a leaf block"
)]

use super::{Bvh, Child};

impl Bvh {
    /// Asks for `child`'s memory, which will be visited soon.
    #[inline(always)]
    pub fn prefetch(&self, child: Child) {
        if child.is_inner() {
            lines(self.nodes(), child.index());
        } else if child.is_triangles() {
            lines(self.triangle_blocks(), child.index());
        } else {
            lines(self.sphere_blocks(), child.index());
        }
    }
}

#[inline(always)]
fn lines<T>(of: &[T], index: usize) {
    if let Some(element) = of.get(index) {
        prefetch(element);
    }
}

/// Asks for all cache lines of `element`.
#[inline(always)]
pub fn prefetch<T>(element: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let start = std::ptr::from_ref(element).cast::<i8>();
        for offset in (0..size_of::<T>()).step_by(64) {
            // SAFETY: the addresses are within `element`, and a prefetch reads nothing.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(offset)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = element;
}
