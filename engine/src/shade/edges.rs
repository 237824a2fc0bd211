//! Edges of the triangles that camera rays hit first, drawn over the finished colours; the scalar version draws each sample by
//! the same functions.

use super::{TileColors, found::Found, queue::RayQueue};
use crate::{
    lanes::F32x8,
    ray::{InstanceId, PrimitiveId},
    scene::{EdgeLines, Scene, TriangleEdges},
};

/// Sets the shares of camera rays that edges cover, packet by packet.
pub(super) fn cover(
    edges: &EdgeLines,
    scene: &Scene,
    rays: &RayQueue,
    found: &Found,
    covers: &mut Vec<F32x8>,
) {
    covers.clear();
    // Neighbours mostly hit the same triangle. Tuned: see docs/lab-notes.md#edges-of-triangles
    let mut last: Option<((PrimitiveId, InstanceId), Option<TriangleEdges>)> = None;
    covers.extend((0..rays.rays.packets().len()).map(|p| {
        let of_lane = |lane| {
            let (ray, hit) = (rays.rays.ray(p, lane), found.hit(p, lane));
            let id = (hit.primitive, hit.instance);
            if !edges.are_shared() || last.as_ref().is_none_or(|(other, _)| *other != id) {
                last = Some((id, edges.of_hit(scene, &ray, &hit)));
            }
            let found = last.as_ref().and_then(|(_, found)| found.as_ref());
            found.map_or(0.0, |found| edges.cover_by(found, &ray))
        };
        F32x8::new(std::array::from_fn(of_lane))
    }));
}

/// Draws edges over the colours of camera packets.
pub(super) fn draw(edges: &EdgeLines, covers: &[F32x8], colors: &mut TileColors) {
    let mut alphas = colors.alpha.iter_mut();
    for (packet, covers) in colors.packets.iter_mut().zip(covers) {
        let mut alphas = alphas.next().map(F32x8::as_mut_array);
        let [r, g, b] = packet.each_mut().map(F32x8::as_mut_array);
        for (lane, &cover) in covers.as_array().iter().enumerate() {
            let mut opaque = 1.0;
            let alpha = alphas.as_mut().map_or(&mut opaque, |alphas| &mut alphas[lane]);
            [r[lane], g[lane], b[lane], *alpha] = edges.over([r[lane], g[lane], b[lane], *alpha], cover);
        }
    }
}
