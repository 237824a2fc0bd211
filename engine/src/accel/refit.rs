//! Refits a BVH to moved vertices: rewrites leaf blocks and boxes and keeps the tree (Wald, Boulos and Shirley, *Ray
//! Tracing Deformable Scenes Using Dynamic Bounding Volume Hierarchies*, 2007).

use super::{Bvh, Child, Node8, TriangleBlocks, boxes};
use crate::{
    geometry::{SphereBlock, TriangleBlock, padded},
    math::Aabb,
    ray::PrimitiveId,
    scene::Scene,
};
use glam::Vec3;
use rayon::prelude::*;

impl Bvh {
    /// Whether it can be refitted to the current vertices of its scene: not if triangles have lost or gained an area, several
    /// are equal, or blocks are indexed.
    pub(crate) fn may_refit(&self, scene: &Scene) -> bool {
        matches!(self.triangle_blocks, TriangleBlocks::Whole(_))
            && self.repeats.is_empty()
            && self.degenerate == scene.degenerate_triangles()
    }

    /// Refits to the current vertices of its scene. Returns false, with the BVH unusable, if a new one must be built.
    #[must_use]
    pub(crate) fn refit(&mut self, scene: &Scene) -> bool {
        if !self.may_refit(scene) {
            return false;
        }
        let TriangleBlocks::Whole(blocks) = &mut self.triangle_blocks else {
            return false;
        };
        let have_areas = blocks.par_iter_mut().map(|block| move_block(block, scene));
        if !have_areas.reduce(|| true, |a, b| a & b) {
            return false;
        }
        self.sphere_blocks
            .par_iter_mut()
            .for_each(|block| move_spheres(block, scene));
        // A child comes after its parent.
        for i in (0..self.nodes.len()).rev() {
            let node = &self.nodes[i];
            let mut children = [(Child::NONE, Aabb::EMPTY); 8];
            let count = node.count as usize;
            for (to, &child) in children.iter_mut().zip(&node.child).take(count) {
                debug_assert!(!child.is_inner() || child.index() > i);
                *to = (child, self.child_bounds(child));
            }
            self.nodes[i] = Node8::new(&children[..count]);
        }
        self.binary = std::sync::OnceLock::new();
        self.scene = scene.id();
        true
    }

    fn child_bounds(&self, child: Child) -> Aabb {
        let lanes = 0..child.count();
        match &self.triangle_blocks {
            _ if child.is_inner() => self.nodes[child.index()].bounds(),
            TriangleBlocks::Whole(blocks) if child.is_triangles() => {
                let block = &blocks[child.index()];
                lanes.fold(Aabb::EMPTY, |all, lane| {
                    let corners = [&block.v0, &block.v1, &block.v2].map(|corner| corner.lane(lane));
                    all.union(padded(Aabb::around(corners)))
                })
            }
            _ => {
                let block = &self.sphere_blocks[child.index()];
                lanes.fold(Aabb::EMPTY, |all, lane| {
                    let radius = Vec3::splat(block.radius.as_array()[lane]);
                    let center = block.center.lane(lane);
                    all.union(padded(Aabb {
                        lower: center - radius,
                        upper: center + radius,
                    }))
                })
            }
        }
    }
}

/// Reloads the spheres of a block from the scene, whose origin may have moved.
fn move_spheres(block: &mut SphereBlock, scene: &Scene) {
    let first = scene.triangles().corners.len();
    let ids = block.id.iter().take_while(|&&id| id != PrimitiveId::NONE.0);
    let spheres: Vec<_> = ids
        .map(|&id| {
            let i = id as usize - first;
            (
                PrimitiveId(id),
                scene.spheres().center(i),
                scene.spheres().radius[i],
            )
        })
        .collect();
    *block = SphereBlock::new(&spheres);
}

/// Reloads the corners of a block's triangles from the scene; returns whether all have an area.
fn move_block(block: &mut TriangleBlock, scene: &Scene) -> bool {
    let mut triangles = [(PrimitiveId::NONE, [Vec3::ZERO; 3]); 8];
    let count = block
        .id
        .iter()
        .take_while(|&&id| id != PrimitiveId::NONE.0)
        .count();
    let mut have_areas = true;
    for (to, &id) in triangles.iter_mut().zip(&block.id).take(count) {
        *to = (PrimitiveId(id), boxes::corners(scene, id as usize));
        have_areas &= scene.has_area(id as usize);
    }
    *block = TriangleBlock::new(&triangles[..count]);
    have_areas
}
