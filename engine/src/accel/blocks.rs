//! Leaf blocks of triangles, in one of two layouts.
//!
//!   whole:    8 x 3 corners, 8 ids                       5 cache lines
//!   indexed:  12 vertices, 8 x 3 indices of 4 bits, 8 ids   3 cache lines; large meshes only
//!
//! After Benthin, Wald, Woop and Áfra, *Compressed-Leaf Bounding Volume Hierarchies*, 2018. Differs: vertices keep
//! all their bits, so both layouts give the same hits.
// Tuned: see docs/lab-notes.md#indexed-blocks

use crate::{
    geometry::{IndexedBlock, TriangleBlock},
    lanes::LANES,
    scene::Scene,
    simd::{Simd, TriangleLanes, Vec3Lanes},
};
use glam::Vec3;

/// Selects how triangles are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// Each with its own corners: [`TriangleBlock`].
    #[default]
    Whole,
    /// As indices into the block's vertices: [`IndexedBlock`].
    Indexed,
}

/// Triangles from which on blocks are indexed (160 MB of whole blocks).
// Tuned: see docs/lab-notes.md#indexed-blocks
const LARGE: usize = 4_000_000;

impl Layout {
    /// Returns the layout for a scene, the same on any machine: indexed if there are too many triangles for any
    /// cache, and no more vertices than triangles.
    #[must_use]
    pub fn for_scene(scene: &Scene) -> Self {
        Self::suiting(scene.triangles().corners.len(), scene.vertices().x.len())
    }

    pub(super) fn suiting(triangles: usize, vertices: usize) -> Self {
        if triangles >= LARGE && vertices <= triangles {
            Self::Indexed
        } else {
            Self::Whole
        }
    }

    /// Returns "whole" or "indexed".
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Whole => "whole",
            Self::Indexed => "indexed",
        }
    }
}

/// The leaf blocks of triangles, indexed by [`Child::index`](super::Child::index).
#[derive(Clone, Debug)]
pub enum TriangleBlocks {
    /// See [`Layout::Whole`].
    Whole(Vec<TriangleBlock>),
    /// See [`Layout::Indexed`].
    Indexed(Vec<IndexedBlock>),
}

impl TriangleBlocks {
    /// None.
    pub(super) fn none(layout: Layout) -> Self {
        match layout {
            Layout::Whole => Self::Whole(Vec::new()),
            Layout::Indexed => Self::Indexed(Vec::new()),
        }
    }

    /// Returns the number of blocks.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Whole(blocks) => blocks.len(),
            Self::Indexed(blocks) => blocks.len(),
        }
    }

    /// Returns whether there are no blocks.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns their size in memory, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match self {
            Self::Whole(blocks) => size_of_val(&blocks[..]),
            Self::Indexed(blocks) => size_of_val(&blocks[..]),
        }
    }

    /// Returns the ids of block `i`; [`PrimitiveId::NONE`](crate::ray::PrimitiveId::NONE) after the last.
    ///
    /// # Panics
    /// If there is no such block.
    #[must_use]
    pub fn ids(&self, i: usize) -> [u32; LANES] {
        match self {
            Self::Whole(blocks) => blocks[i].id,
            Self::Indexed(blocks) => std::array::from_fn(|lane| blocks[i].id(lane)),
        }
    }

    /// Returns the id of triangle `lane` of block `i`, as the raw value of [`PrimitiveId`](crate::ray::PrimitiveId).
    #[inline(always)]
    pub(crate) fn id(&self, [i, lane]: [usize; 2]) -> u32 {
        match self {
            Self::Whole(blocks) => blocks[i].id[lane % LANES],
            Self::Indexed(blocks) => blocks[i].id(lane),
        }
    }

    /// Returns the corners of triangle `lane` of block `i`.
    pub(crate) fn triangle(&self, [i, lane]: [usize; 2]) -> [Vec3; 3] {
        match self {
            Self::Whole(blocks) => blocks[i].triangle(lane),
            Self::Indexed(blocks) => blocks[i].triangle(lane),
        }
    }

    /// Returns block `i`, unpacked into `room` if it is indexed.
    #[inline(always)]
    pub(crate) fn whole<'a, S: Simd>(
        &'a self,
        simd: S,
        i: usize,
        room: &'a mut Option<TriangleBlock>,
    ) -> &'a TriangleBlock {
        match self {
            Self::Whole(blocks) => &blocks[i],
            Self::Indexed(blocks) => {
                let block = &blocks[i];
                room.insert(simd.call(
                    #[inline(always)]
                    || block.whole(simd),
                ))
            }
        }
    }

    /// Returns first, second and third corners: of two blocks in vectors of sixteen lanes, else of the first.
    #[inline(always)]
    pub(crate) fn corners<V: TriangleLanes>(
        &self,
        simd: V::Simd,
        [low, high]: [usize; 2],
    ) -> [Vec3Lanes<V>; 3] {
        match self {
            Self::Whole(blocks) => TriangleBlock::corners(simd, [&blocks[low], &blocks[high]]),
            Self::Indexed(blocks) => {
                let two = [&blocks[low], &blocks[high]];
                simd.call(
                    #[inline(always)]
                    || IndexedBlock::corners(simd, two),
                )
            }
        }
    }
}

#[cfg(test)]
mod tests;
