//! Leaf blocks of triangles, in one of two layouts. (After Benthin, Wald, Woop and Áfra, *Compressed-Leaf Bounding Volume
//! Hierarchies*, 2018. Differs: vertices keep all their bits, so that both layouts give the same hits.)
//!
//! Lab notes: indexed blocks against whole ones, kernels of both in turn in one run (median of 3 to 7), Zen 5, one thread:
//!
//! | scene | bytes a triangle | build | camera, shadow, mirror rays |
//! |---|---|---|---|
//! | cow, figure | 54 and 51 to 36 and 34 | +14 % (figure) | -6 %, 0 %, -2 to +2 % |
//! | interior, 370,000 | 50.5 to 39.4 | +25 % | -1 %, -3 %, -1 % |
//! | terrain, 1,000,000 | 49.3 to 32.1 | +16 % | 0 %, +1 %, -1 % |
//! | blobs, 1,000,000 | 52.1 to 34.0 | +18 % | +4 %, +3 %, -3 % |
//! | blobs, 10,000,000 | 51.7 to 33.6 | -10 to -14 % (two threads: -3 %) | +1 %, +1 %, -1 to -4 % |
//!
//! So what is saved in waiting for memory goes into unpacking, until a scene is far larger than the caches; then the memory
//! itself is what is gained, and the time to write it: from a file to a picture ten million triangles take 1.28 s in place
//! of 1.51, and 703 MB in place of 897. With vectors of eight lanes, where a vertex takes two permutations and a selection,
//! and bundles of 64 rays, their rays were 3, 3 and 7 % slower; the sooner build outweighs that for some ten million of them.
//!
//! Quantised nodes would save 2 to 3 bytes a triangle: nodes take 5 to 8 of them.

use crate::{
    geometry::{IndexedBlock, SphereBlock, TriangleBlock, TriangleLeaf as _},
    scene::Scene,
    simd::LANES,
};

/// How triangles are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// Each with its corners: [`TriangleBlock`].
    #[default]
    Whole,
    /// Those of a block with the vertices that they share: [`IndexedBlock`].
    Indexed,
}

/// From so many triangles on (160 MB of whole blocks) vertices are shared.
const LARGE: usize = 4_000_000;

impl Layout {
    /// What suits a scene, on any machine: vertices are shared where there are too many triangles for any cache, and no more
    /// vertices than triangles.
    #[must_use]
    pub fn for_scene(scene: &Scene) -> Self {
        Self::suiting(scene.triangles().corners.len(), scene.vertices().x.len())
    }

    fn suiting(triangles: usize, vertices: usize) -> Self {
        if triangles >= LARGE && vertices <= triangles {
            Self::Indexed
        } else {
            Self::Whole
        }
    }

    /// "whole" or "indexed".
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Whole => "whole",
            Self::Indexed => "indexed",
        }
    }
}

/// The leaf blocks of triangles, numbered as [`Child::index`](super::Child::index) has it.
#[derive(Debug)]
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

    /// How many.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Whole(blocks) => blocks.len(),
            Self::Indexed(blocks) => blocks.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Their size in memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match self {
            Self::Whole(blocks) => size_of_val(&blocks[..]),
            Self::Indexed(blocks) => size_of_val(&blocks[..]),
        }
    }

    /// The ids of block `i`; [`PrimitiveId::NONE`](crate::ray::PrimitiveId::NONE) behind the last.
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
}

/// All leaf blocks, those of triangles as they are stored: what kernels are compiled for.
#[derive(Debug)]
pub struct LeafBlocks<'a, B> {
    /// By [`Child::index`](super::Child::index).
    pub triangles: &'a [B],
    /// As the triangles.
    pub spheres: &'a [SphereBlock],
}

impl<B> Clone for LeafBlocks<'_, B> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<B> Copy for LeafBlocks<'_, B> {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_are_shared_in_large_meshes() {
        assert_eq!(Layout::suiting(LARGE, LARGE / 2), Layout::Indexed);
        assert_eq!(Layout::suiting(LARGE, LARGE), Layout::Indexed);
        assert_eq!(Layout::suiting(LARGE - 1, LARGE / 2), Layout::Whole);
        assert_eq!(Layout::suiting(LARGE, 3 * LARGE), Layout::Whole);
    }
}
