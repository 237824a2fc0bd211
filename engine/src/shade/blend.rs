//! Half-transparent surfaces: their colour is weighted by the opacity, and a ray continues straight on for the rest, as a
//! branch like those of glass.

use super::{
    SURFACE_OFFSET, TileColors,
    found::Found,
    glass::{Branch8, MIN_WEIGHT, to8},
    material::{Points, background},
    queue::RayQueue,
};
use crate::{
    lanes::{F32x8, LANES},
    ray::{RayPacket, T_MAX},
    scene::Scene,
    simd::{EightLanes, LaneMask, Lanes, Simd},
};

/// The most half-transparent surfaces on a path; the next one is opaque.
pub const MAX_LAYERS: u8 = 64;

/// Sets the weights of surfaces to their opacity, and `alpha`, unless it is empty, to that of the rays.
pub(super) fn weigh(scene: &Scene, rays: &RayQueue, found: &mut Found, alpha: &mut [F32x8]) {
    let Found {
        hits,
        by_material,
        surfaces,
        ..
    } = found;
    let mut surfaces = surfaces.iter_mut();
    by_material.for_each_packet(|ray_i| {
        let Some(surface) = surfaces.next() else {
            return;
        };
        for (lane, &i) in ray_i.iter().enumerate() {
            let (p, from) = (i as usize / LANES, i as usize % LANES);
            if surface.active >> lane & 1 == 0 || rays.layers(p, from) >= MAX_LAYERS {
                continue;
            }
            let hit = hits[p].hit(from);
            let opacity = scene.opacity(hit.primitive, [hit.u, hit.v]);
            surface.weight.as_mut_array()[lane] = opacity;
            if let Some(alpha) = alpha.get_mut(p) {
                alpha.as_mut_array()[from] = opacity;
            }
        }
    });
}

/// Queues the rays that continue behind one material's points; those of low weight add the background, unless that is
/// `transparent`. They are multiplied by `base`, the material's base colour, with its tints.
#[inline(always)]
pub(super) fn pass<S: Simd>(
    simd: S,
    scene: &Scene,
    (points, base): (Points<'_>, Option<[f32; 3]>),
    rays: &RayQueue,
    transparent: bool,
    colors: &mut TileColors,
    next: &mut RayQueue,
) {
    for (i, s) in points.surfaces.iter().enumerate() {
        let share = simd.splat(1.0) - simd.load(&s.weight);
        let from = Branch8::gather(rays, &s.pixel);
        let mut tint = base.unwrap_or([1.0; 3]).map(|channel| simd.splat(channel));
        if let (Some(_), Some(own)) = (base, points.tints.get(i)) {
            for (tint, own) in tint.iter_mut().zip(own) {
                *tint = *tint * simd.load(own);
            }
        }
        let factor = tint.map(|tint| share * tint);
        let mut weight = factor;
        for (weight, from) in weight.iter_mut().zip(&from.weight) {
            *weight = *weight * simd.load(from);
        }
        let largest = weight[0].max(weight[1]).max(weight[2]);
        let passing = s.active & share.gt(simd.splat(0.0)).bits();
        let traced = passing & largest.ge(simd.splat(MIN_WEIGHT)).bits();
        let shows_nothing = if transparent { from.straight } else { 0 };
        let rest = passing & !traced & !shows_nothing;
        if rest != 0 {
            let mut color = background(simd, scene, &s.direction);
            for (color, tint) in color.iter_mut().zip(tint) {
                *color = *color * tint;
            }
            colors.add(simd, rest, &s.pixel, share, color);
        }
        if traced == 0 {
            continue;
        }
        let offset = simd.load(&s.magnitude) * SURFACE_OFFSET;
        let origin = simd
            .load3(&s.geometric_normal)
            .mul_add(-offset, simd.load3(&s.point));
        let t_max = S::V8::select(simd.mask(traced), simd.splat(T_MAX), simd.splat(0.0)).to8();
        let direction = s.direction;
        next.push_from(origin.to8(), RayPacket { direction, t_max }, s.pixel, share.to8());
        if let Some(&distance) = points.distance.get(i) {
            next.push_travelled(distance);
        }
        next.branches.push(Branch8 {
            factor: to8::<S>(factor),
            weight: to8::<S>(weight),
            layers: from.layers.map(|layers| layers.saturating_add(1)),
            ended: 0,
            ..from
        });
    }
}
