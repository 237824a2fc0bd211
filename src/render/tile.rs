//! One tile: camera rays in packets of 4x2 pixels, traced and shaded sample by sample.

use super::{
    RayCounts, TileTimes,
    frame::{FrameContext, TileRect},
};
use crate::{
    accel::Bvh,
    ray::{RayPacket, T_MAX},
    shade::{ShadeSettings, Shader, TileColors, queue::RayQueue},
    simd::{LANES, Mask8, Vec3x8, splat},
    trace::Tracer,
};
use std::time::Instant;

/// Pixels of a bundle's side: eight packets of 4x2 pixels.
const BLOCK: u32 = 8;
/// Pixels of a packet.
const PACKET: [u32; 2] = [4, 2];

/// A thread's memory for rendering tiles.
pub(super) struct TileScratch<'a> {
    tracer: Tracer<'a>,
    shader: Shader,
    rays: RayQueue,
    sample: TileColors,
    sum: TileColors,
}

impl<'a> TileScratch<'a> {
    pub fn new(bvh: &'a Bvh) -> Self {
        Self {
            tracer: Tracer::new(bvh),
            shader: Shader::default(),
            rays: RayQueue::default(),
            sample: TileColors::default(),
            sum: TileColors::default(),
        }
    }

    /// Renders the tile into its columns of `band`, the rows of the picture from `rect.y` on.
    pub fn render(
        &mut self,
        context: &FrameContext<'_>,
        rect: TileRect,
        band: &mut [[f32; 3]],
    ) -> (RayCounts, TileTimes) {
        let &FrameContext { scene, settings, .. } = context;
        let shade = ShadeSettings {
            max_depth: settings.max_depth,
            shadows: settings.shadows,
        };
        let pixels = rect.width * rect.height;
        let n = settings.samples_per_axis;
        self.shader.reset_counts();
        let mut times = TileTimes::default();
        self.sum.reset(pixels as usize);
        for sample in (0..n).flat_map(|row| (0..n).map(move |column| [column, row])) {
            self.sample.reset(pixels as usize);
            let start = Instant::now();
            fill(context, rect, sample, &mut self.rays);
            times.ray_generation += start.elapsed();
            self.shader
                .shade(scene, &mut self.tracer, shade, &mut self.rays, &mut self.sample);
            self.sum.add_all(&self.sample);
        }
        let samples = (n * n) as f32;
        let rows = band.chunks_exact_mut(settings.width as usize);
        for (row, y) in rows.zip(0..rect.height) {
            for (pixel, x) in row[rect.x as usize..][..rect.width as usize].iter_mut().zip(0..) {
                *pixel = self
                    .sum
                    .pixel((y * rect.width + x) as usize)
                    .map(|sum| sum / samples);
            }
        }
        times.tracing = self.shader.tracing;
        let counts = RayCounts {
            camera: u64::from(pixels) * u64::from(n * n),
            shadow: self.shader.shadow_rays,
            reflection: self.shader.reflection_rays,
        };
        (counts, times)
    }
}

/// Fills the queue with the camera rays of one sample of all pixels of the tile, block by block.
fn fill(context: &FrameContext<'_>, rect: TileRect, sample: [u32; 2], rays: &mut RayQueue) {
    rays.clear();
    for block_y in (0..rect.height).step_by(BLOCK as usize) {
        for block_x in (0..rect.width).step_by(BLOCK as usize) {
            for packet_i in 0..8 {
                let x = block_x + packet_i % 2 * PACKET[0];
                let y = block_y + packet_i / 2 * PACKET[1];
                if x < rect.width && y < rect.height {
                    push_packet(context, rect, [x, y], sample, rays);
                }
            }
        }
    }
}

/// Pushes the packet whose top left pixel is (`x`, `y`) of the tile.
fn push_packet(
    context: &FrameContext<'_>,
    rect: TileRect,
    [x, y]: [u32; 2],
    sample: [u32; 2],
    rays: &mut RayQueue,
) {
    let mut active = 0;
    let mut pixel = [0; LANES];
    for (lane, pixel) in pixel.iter_mut().enumerate() {
        let (px, py) = (x + lane as u32 % PACKET[0], y + lane as u32 / PACKET[0]);
        if px < rect.width && py < rect.height {
            active |= 1 << lane;
            *pixel = py * rect.width + px;
        }
    }
    let packet = RayPacket {
        origin: Vec3x8::splat(context.pixel_rays.eye()),
        direction: context.pixel_rays.directions8(rect.x + x, rect.y + y, sample),
        t_max: Mask8::from_bits(active).select(splat(T_MAX), splat(0.0)),
    };
    rays.push(packet, pixel, splat(1.0));
}
