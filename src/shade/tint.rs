//! Tints: the colours that vertices and spheres give to hits, a packet of them beside each surface packet. Only scenes
//! that have such colours run this pass.

use super::queue::{HitQueue, PacketLanes, RayIndex};
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::{HitPacket, PrimitiveId},
    scene::{Primitive, Scene},
    simd::{EightLanes, Lanes, Simd, Vec3Eight, Vec3Lanes},
};
use glam::Vec3;

/// The factors of a material's base colour at eight points: red, green and blue.
pub type Tint8 = [F32x8; 3];

/// What a tint depends on, for eight hits.
struct Hits8 {
    primitive: [u32; LANES],
    u: F32x8,
    v: F32x8,
}

impl Hits8 {
    /// Copies the lanes `bits` of a packet; the others repeat the first of these.
    #[inline(always)]
    fn in_place(hits: &HitPacket, bits: u32) -> Self {
        let mut copied = Self {
            primitive: hits.primitive,
            u: hits.u,
            v: hits.v,
        };
        let first = bits.trailing_zeros() as usize % LANES;
        for lane in 0..LANES {
            if bits >> lane & 1 == 0 {
                copied.set(lane, hits, first);
            }
        }
        copied
    }

    /// Gathers up to eight hits of any packets; the last one is repeated.
    #[inline(always)]
    fn gather(hits: &[HitPacket], ray_i: &[RayIndex]) -> Self {
        let mut gathered = Self {
            primitive: [0; LANES],
            u: F32x8::ZERO,
            v: F32x8::ZERO,
        };
        for lane in 0..LANES {
            let i = ray_i[lane.min(ray_i.len() - 1)] as usize;
            gathered.set(lane, &hits[i / LANES], i % LANES);
        }
        gathered
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, hits: &HitPacket, from: usize) {
        self.primitive[lane] = hits.primitive[from];
        self.u.as_mut_array()[lane] = hits.u.as_array()[from];
        self.v.as_mut_array()[lane] = hits.v.as_array()[from];
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
    for (_, bucket) in by_material.buckets() {
        for &PacketLanes { packet, bits } in &bucket.in_place {
            let hits8 = Hits8::in_place(&hits[packet as usize], bits);
            tints.push(tint(simd, scene, &hits8));
        }
        for chunk in bucket.compacted.chunks(LANES) {
            tints.push(tint(simd, scene, &Hits8::gather(hits, chunk)));
        }
    }
}

// Not inlined, for it is called twice, so it enters the level by itself.
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

/// Colour `i`, white if there are none.
#[inline(always)]
fn color_of(colors: &[[f32; 3]], i: usize) -> Vec3 {
    colors.get(i).map_or(Vec3::ONE, |&color| Vec3::from_array(color))
}
