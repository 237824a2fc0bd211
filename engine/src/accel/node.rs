//! The wide node: the boxes of eight children as a structure of arrays, and a word per child (Dammertz, Hanika and Keller,
//! *Shallow Bounding Volume Hierarchies*, 2008, with eight children instead of four).

use crate::{
    lanes::{F32x8, LANES},
    math::Aabb,
};
use glam::Vec3;

/// Kinds of child words; see [`Child`].
const TRIANGLES: u32 = 1 << 30;
const SPHERES: u32 = 2 << 30;
const EMPTY: u32 = 3 << 30;
const KIND: u32 = 3 << 30;

/// A child: an inner node, or a block of 1 to 8 triangles or spheres. Two bits of kind, for a leaf three bits of its
/// count less one, and the index of a node or block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Child(u32);

impl Child {
    /// The [`kind`](Self::kind) of an inner node.
    pub const INNER: usize = 0;
    /// The [`kind`](Self::kind) of a block of triangles.
    pub const TRIANGLES: usize = 1;
    /// The [`kind`](Self::kind) of a block of spheres.
    pub const SPHERES: usize = 2;
    /// The [`kind`](Self::kind) of no child.
    pub const EMPTY: usize = 3;

    /// No child.
    pub const NONE: Self = Self(EMPTY);
    /// The most nodes, and the most blocks of a kind.
    pub const MAX_BLOCKS: usize = 1 << 27;

    /// Creates the word of inner node `index`.
    ///
    /// # Panics
    /// If the index is not below [`MAX_BLOCKS`](Self::MAX_BLOCKS).
    #[must_use]
    pub fn inner(index: usize) -> Self {
        assert!(index < Self::MAX_BLOCKS, "too many nodes");
        Self(index as u32)
    }

    /// Creates the word of block `index` of `count` triangles.
    ///
    /// # Panics
    /// If the index is not below [`MAX_BLOCKS`](Self::MAX_BLOCKS), or the count not from 1 to 8.
    #[must_use]
    pub fn triangles(index: usize, count: usize) -> Self {
        assert!(
            (1..=8).contains(&count) && index < Self::MAX_BLOCKS,
            "too many leaf blocks"
        );
        Self(TRIANGLES | (count as u32 - 1) << 27 | index as u32)
    }

    /// Creates the word of block `index` of `count` spheres.
    ///
    /// # Panics
    /// If the index is not below [`MAX_BLOCKS`](Self::MAX_BLOCKS), or the count not from 1 to 8.
    #[must_use]
    pub fn spheres(index: usize, count: usize) -> Self {
        assert!(
            (1..=8).contains(&count) && index < Self::MAX_BLOCKS,
            "too many leaf blocks"
        );
        Self(SPHERES | (count as u32 - 1) << 27 | index as u32)
    }

    /// Returns the word as a number.
    #[inline(always)]
    #[must_use]
    pub fn bits(self) -> u32 {
        self.0
    }

    /// Creates a word from its [`bits`](Self::bits).
    #[inline(always)]
    #[must_use]
    pub fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// Returns the kind, a number below four.
    #[inline(always)]
    #[must_use]
    pub fn kind(self) -> usize {
        (self.0 >> 30) as usize
    }

    /// Returns whether this is an inner node.
    #[inline(always)]
    #[must_use]
    pub fn is_inner(self) -> bool {
        self.0 & KIND == 0
    }

    /// Returns whether this is a block of triangles.
    #[inline(always)]
    #[must_use]
    pub fn is_triangles(self) -> bool {
        self.0 & KIND == TRIANGLES
    }

    /// Returns the index of the node or block.
    #[inline(always)]
    #[must_use]
    pub fn index(self) -> usize {
        (self.0 & 0x07ff_ffff) as usize
    }

    /// Returns a bit for each primitive of a block.
    #[inline(always)]
    #[must_use]
    pub fn count_bits(self) -> u32 {
        (2 << (self.0 >> 27 & 7)) - 1
    }

    /// Returns the number of primitives of a block.
    #[inline(always)]
    #[must_use]
    pub fn count(self) -> usize {
        (self.0 >> 27 & 7) as usize + 1
    }
}

/// An inner node: the boxes of up to eight children as a structure of arrays, filled from lane 0 on. Empty lanes have
/// finite, inverted boxes; a test that sorts its distances must not rely on that.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Node8 {
    /// Lower bounds by axis, then upper bounds by axis.
    pub planes: [F32x8; 6],
    /// The children.
    pub child: [Child; 8],
    /// The number of children.
    pub count: u32,
}

impl Node8 {
    /// Creates a node of at most eight children and their boxes.
    #[must_use]
    pub fn new(children: &[(Child, Aabb)]) -> Self {
        let mut columns = [[0.0; 8]; 6];
        let mut child = [Child::NONE; 8];
        for lane in 0..8 {
            let mut bounds = Aabb::EMPTY;
            if let Some(&(there, around)) = children.get(lane) {
                (child[lane], bounds) = (there, around);
            }
            let (l, u) = (bounds.lower, bounds.upper);
            let numbers = [l.x, l.y, l.z, u.x, u.y, u.z];
            for (column, number) in columns.iter_mut().zip(numbers) {
                column[lane] = number;
            }
        }
        Self {
            planes: bytemuck::must_cast(columns),
            child,
            count: children.len() as u32,
        }
    }

    /// Returns the box of child `i`: lower and upper corner.
    #[inline(always)]
    #[must_use]
    pub fn corners(&self, i: usize) -> (Vec3, Vec3) {
        // Without `array::map`: see docs/lab-notes.md#array-map
        let [lx, ly, lz, ux, uy, uz] = &self.planes;
        let lane = i % LANES;
        let lower = Vec3::new(lx.as_array()[lane], ly.as_array()[lane], lz.as_array()[lane]);
        let upper = Vec3::new(ux.as_array()[lane], uy.as_array()[lane], uz.as_array()[lane]);
        (lower, upper)
    }

    /// Returns the box around all children.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let child = |i: usize| {
            let (lower, upper) = self.corners(i);
            Aabb { lower, upper }
        };
        (0..self.count as usize).map(child).fold(Aabb::EMPTY, Aabb::union)
    }

    /// Returns a bit for each child.
    #[inline(always)]
    #[must_use]
    pub fn valid_bits(&self) -> u32 {
        (1 << self.count) - 1
    }
}
