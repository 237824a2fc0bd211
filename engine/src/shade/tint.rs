//! Tints: the colours of vertices and spheres at hits, a packet of them for each surface packet. Only scenes with such
//! colours run this pass.

use super::queue::{HitQueue, RayIndex};
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::{HitPacket, PrimitiveId},
    scene::{Primitive, Scene},
    simd::{EightLanes, Lanes, Simd, Vec3Eight, Vec3Lanes},
};
use glam::Vec3;

/// The factors of a material's base colour at eight points: red, green and blue.
pub type Tint8 = [F32x8; 3];

/// The data of eight hits from which tints are computed.
struct Hits8 {
    primitive: [u32; LANES],
    u: F32x8,
    v: F32x8,
}

impl Hits8 {
    #[inline(always)]
    fn gather(hits: &[HitPacket], rays: &[RayIndex; LANES]) -> Self {
        let mut gathered = Self {
            primitive: [0; LANES],
            u: F32x8::ZERO,
            v: F32x8::ZERO,
        };
        for (lane, &ray_i) in rays.iter().enumerate() {
            let (hits, from) = (&hits[ray_i as usize / LANES], ray_i as usize % LANES);
            gathered.primitive[lane] = hits.primitive[from];
            gathered.u.as_mut_array()[lane] = hits.u.as_array()[from];
            gathered.v.as_mut_array()[lane] = hits.v.as_array()[from];
        }
        gathered
    }
}

/// Makes the tints of the sorted hits, in the order of `by_material`: that of the surface packets.
#[inline(always)]
pub(super) fn gather<S: Simd>(
    simd: S,
    scene: &Scene,
    hits: &[HitPacket],
    by_material: &HitQueue,
    tints: &mut Vec<Tint8>,
) {
    tints.clear();
    by_material.for_each_packet(
        #[inline(always)]
        |rays| tints.push(tint(simd, scene, &Hits8::gather(hits, rays))),
    );
}

// Called twice, so not inlined; it therefore enters the level again.
#[inline(never)]
fn tint<S: Simd>(simd: S, scene: &Scene, hits: &Hits8) -> Tint8 {
    simd.call(
        #[inline(always)]
        || {
            let (vertices, spheres) = (scene.vertices(), scene.spheres());
            let mut corners = [Vec3x8::ZERO; 3];
            let mut sphere_bits = 0;
            for (lane, &id) in hits.primitive.iter().enumerate() {
                let colors = match scene.primitive(PrimitiveId(id)) {
                    Primitive::Triangle(i) => {
                        scene.triangles().corners[i].map(|vertex| color_of(&vertices.colors, vertex as usize))
                    }
                    Primitive::Sphere(i) => {
                        sphere_bits |= 1 << lane;
                        [color_of(&spheres.color, i); 3]
                    }
                    Primitive::Plane(_) => [Vec3::ONE; 3],
                };
                for (corner, color) in corners.iter_mut().zip(colors) {
                    corner.set(lane, color);
                }
            }
            let [a, b, c] = &corners;
            let [a, b, c]: [Vec3Eight<S>; 3] = [simd.load3(a), simd.load3(b), simd.load3(c)];
            let (u, v) = (simd.load(&hits.u), simd.load(&hits.v));
            let between = b.mul_add(u, c.mul_add(v, a * (simd.splat(1.0) - u - v)));
            let own = Vec3Lanes::select(simd.mask(sphere_bits), a, between);
            // Rounding may leave the range of the corners.
            let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
            [own.x, own.y, own.z].map(|channel| channel.max(zero).min(one).to8())
        },
    )
}

/// Colour `i`; white without colours.
#[inline(always)]
fn color_of(colors: &[[f32; 3]], i: usize) -> Vec3 {
    colors.get(i).map_or(Vec3::ONE, |&color| Vec3::from_array(color))
}
