//! Textures, ray by ray: factors of base colours and highlights, emitted light, occlusion and normals. Only scenes with
//! textures run this pass.

use super::{
    queue::{HitQueue, RayQueue},
    surface::SurfacePacket,
    tint::Tint8,
};
use crate::{
    lanes::{F32x8, LANES},
    ray::{HitPacket, InstanceId, SceneHit},
    scene::{RayCone, Scene, TexturePoint},
};

/// Values other than the tint that depend on textures, for each surface packet.
#[derive(Debug, Default)]
pub(super) struct Textured {
    /// Emitted light, or 0.
    pub emitted: Vec<Tint8>,
    /// Factors of the highlight's colour.
    pub specular: Vec<Tint8>,
    /// Lengths of the paths from the camera, scene units.
    pub distance: Vec<F32x8>,
    /// Factors of ambient light and of the environment; 1 for the packets after the last one.
    pub occlusion: Vec<F32x8>,
}

impl Textured {
    /// Reserves memory for this many surface packets.
    pub fn reserve(&mut self, packets: usize) {
        self.emitted.reserve(packets);
        self.specular.reserve(packets);
        self.distance.reserve(packets);
        self.occlusion.reserve(packets);
    }

    pub fn clear(&mut self) {
        self.emitted.clear();
        self.specular.clear();
        self.distance.clear();
        self.occlusion.clear();
    }
}

/// Multiplies the tints (white by default), applies normal maps, and fills `textured`. `cone` is that of the paths from the
/// camera.
pub(super) fn pass(
    scene: &Scene,
    (rays, hits, instances): (&RayQueue, &[HitPacket], &[[u32; LANES]]),
    (by_material, surfaces): (&HitQueue, &mut [SurfacePacket]),
    cone: RayCone,
    tints: &mut Vec<Tint8>,
    textured: &mut Textured,
) {
    textured.clear();
    tints.resize(surfaces.len(), [F32x8::splat(1.0); 3]);
    let mut packets = surfaces.iter_mut().zip(tints);
    by_material.for_each_packet(|ray_i| {
        let Some((surface, tint)) = packets.next() else {
            return;
        };
        let (mut emitted, mut distance) = ([F32x8::ZERO; 3], F32x8::ZERO);
        let mut specular = [F32x8::ZERO; 3];
        for (lane, &i) in ray_i.iter().enumerate() {
            let (p, from) = (i as usize / LANES, i as usize % LANES);
            let hit = hits[p].hit(from);
            let travelled = rays.travelled(p).as_array()[from] + hit.t;
            distance.as_mut_array()[lane] = travelled;
            if surface.active >> lane & 1 == 0 {
                continue;
            }
            let instance = instances.get(p).map_or(InstanceId::NONE.0, |of| of[from]);
            let point = TexturePoint {
                hit: SceneHit {
                    hit,
                    instance: InstanceId(instance),
                },
                point: surface.point.lane(lane),
                normal: surface.geometric_normal.lane(lane),
                direction: surface.direction.lane(lane),
                width: cone.width(travelled),
            };
            let own = scene.textured(&point);
            for channel in 0..3 {
                tint[channel].as_mut_array()[lane] *= own.base[channel];
                specular[channel].as_mut_array()[lane] = own.specular[channel];
                emitted[channel].as_mut_array()[lane] = own.emitted[channel];
            }
            let textures = scene.textures_of(hit.primitive);
            if let Some(map) = textures.and_then(|all| all.occlusion_map) {
                let packet = textured.emitted.len();
                textured.occlusion.resize(packet + 1, F32x8::splat(1.0));
                textured.occlusion[packet].as_mut_array()[lane] = scene.occlusion(&map, &point);
            }
            if let Some(map) = textures.and_then(|all| all.normal_map) {
                let from_behind = surface.from_behind >> lane & 1 != 0;
                let mapped = scene.mapped_normal(&map, &point, surface.normal.lane(lane), from_behind);
                surface.normal.set(lane, mapped);
            }
        }
        textured.emitted.push(emitted);
        textured.specular.push(specular);
        textured.distance.push(distance);
    });
}
