//! The closest hits of camera rays, in packets of 4x2 pixels.

use super::timeline::Model;
use crate::{
    lanes::{F32x8, LANES},
    ray::{HitPacket, Ray, RayPacket, RayPackets, SceneHit, T_MAX},
    render::CameraRays,
    scene::Scene,
    simd::{Level, Simd, at_level},
    trace::Tracer,
};

/// Rows of a band, a thread's piece of work: those of a packet.
pub const BAND: u32 = 2;
/// Pixels of a packet's row.
const ROW: usize = 4;

/// Traces camera rays band by band.
pub struct FirstHits<'a> {
    scene: &'a Scene,
    tracer: Tracer<'a>,
    packets: RayPackets,
    hits: Vec<HitPacket>,
}

impl<'a> FirstHits<'a> {
    /// Traces rays of this scene.
    pub fn new(model: &'a Model, level: Level) -> Self {
        Self {
            scene: &model.scene,
            tracer: Tracer::new(&model.bvh).at_level(level).of_scene(&model.scene),
            packets: RayPackets::default(),
            hits: Vec::new(),
        }
    }

    /// Traces one sample of all pixels of a band of `width` x `rows` pixels from row `y` on. Passes each pixel's index in the
    /// band, its ray and its hit to `take`.
    pub fn trace(
        &mut self,
        rays: &CameraRays,
        [width, rows]: [usize; 2],
        y: u32,
        sample: [u32; 2],
        take: &mut dyn FnMut(usize, &Ray, &SceneHit),
    ) {
        let packets = &mut self.packets;
        packets.restart(rays.shared_origin());
        at_level!(self.tracer.level(), |simd| push_packets(
            simd,
            rays,
            [width, rows],
            y,
            sample,
            packets
        ));
        let (packets, hits) = (&self.packets, &mut self.hits);
        let count = packets.packets().len();
        hits.clear();
        hits.resize(count, HitPacket::miss(F32x8::ZERO));
        self.tracer
            .closest_hit(packets.origins(), packets.packets(), hits);
        for packet_i in 0..count {
            for lane in 0..LANES {
                let (column, row) = (packet_i * ROW + lane % ROW, lane / ROW);
                if row < rows && column < width {
                    let ray = packets.ray(packet_i, lane);
                    let mut hit = self.tracer.scene_hit(&self.hits, packet_i, lane);
                    if self.scene.shows_back(&ray, &hit) {
                        hit = self.tracer.visible_hit(&ray);
                    }
                    take(row * width + column, &ray, &hit);
                }
            }
        }
    }
}

/// Adds the packets of one sample of the `rows` rows from `y` on.
#[inline(always)]
fn push_packets<S: Simd>(
    simd: S,
    rays: &CameraRays,
    [width, rows]: [usize; 2],
    y: u32,
    sample: [u32; 2],
    packets: &mut RayPackets,
) {
    for x in (0..width).step_by(ROW) {
        let mut t_max = [0.0; LANES];
        for (lane, t_max) in t_max.iter_mut().enumerate() {
            if lane / ROW < rows && x + lane % ROW < width {
                *t_max = T_MAX;
            }
        }
        let (pixel, t_max) = ([x as u32, y], t_max.into());
        if rays.is_distorted() {
            let pixels =
                std::array::from_fn(|lane| [pixel[0] + (lane % ROW) as u32, y + (lane / ROW) as u32]);
            packets.push(rays.distorted(&pixels, sample, t_max));
        } else if rays.shared_origin().is_some() {
            let direction = rays.directions8(simd, pixel, sample);
            packets.push(RayPacket { direction, t_max });
        } else {
            let (origin, direction) = rays.rays8(simd, pixel, sample);
            packets.push_from(origin, RayPacket { direction, t_max });
        }
    }
}
