//! The assumed width of ray bundles: cameras are not known when the BVH is built.

use super::{boxes::Box8, tree::PARALLEL};
use crate::simd::Simd;
use rayon::prelude::*;

/// SAH weight = area + scene area / 4096, which models a bundle of 256 rays of a million.
// Tuned: see docs/lab-notes.md#bundle-footprint
const SCENE_IN_FOOTPRINTS: f32 = 4096.0;

/// The area added to boxes. The scene's area is that of the box around all centres, which large ground triangles do
/// not enlarge, or the sum over all primitives if that is less, as in a mostly empty scene; but not if `nodes_are_full`, which
/// saves memory.
// Measured: see docs/lab-notes.md#bundle-footprint
pub(super) fn footprint<S: Simd>(simd: S, boxes: &[Box8], nodes_are_full: bool) -> f32 {
    let of_part = |boxes: &[Box8]| {
        simd.call(
            #[inline(always)]
            || {
                let mut area = 0.0;
                for b in boxes {
                    area += b.half_area_without_id(simd);
                }
                (Box8::around_centers(simd, boxes), area)
            },
        )
    };
    // Summed part by part, in one order for any number of threads.
    let parts: Vec<(Box8, f32)> = boxes.par_chunks(PARALLEL / 2).map(of_part).collect();
    let (mut centers, mut area) = (Box8::EMPTY, 0.0);
    for (centers_of_part, area_of_part) in parts {
        centers = centers.union(simd, centers_of_part);
        area += area_of_part;
    }
    // A center is at twice its coordinates.
    let of_scene = centers.half_area(simd) / 4.0;
    let area = if nodes_are_full {
        of_scene
    } else {
        area.min(of_scene)
    };
    area / SCENE_IN_FOOTPRINTS
}
