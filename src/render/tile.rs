//! One tile: camera rays in packets of 4x2 pixels, traced and shaded sample by sample.

use super::{
    RayCounts, TileTimes,
    frame::{FrameContext, TileRect},
};
use crate::{
    accel::Bvh,
    ray::{RayPacket, T_MAX},
    shade::{ShadeSettings, Shader, TileColors, queue::RayQueue},
    simd::{F32x8, LANES, Mask8, Vec3x8, splat},
    trace::Tracer,
};
use std::time::Instant;

/// Pixels of a bundle's side: eight packets of 4x2 pixels.
const BLOCK: u32 = 8;
/// Pixels of a packet.
const PACKET: [u32; 2] = [4, 2];

/// A thread's memory for rendering tiles.
#[derive(Debug)]
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
        let tile_start = Instant::now();
        let pixels = rect.width * rect.height;
        let n = settings.samples_per_axis;
        self.shader.reset_counts();
        let mut times = TileTimes::default();
        for sample in (0..n).flat_map(|row| (0..n).map(move |column| [column, row])) {
            let start = Instant::now();
            fill(context, rect, sample, &mut self.rays);
            times.ray_generation += start.elapsed();
            self.sample.reset(self.rays.packets.len());
            self.shader
                .shade(scene, &mut self.tracer, shade, &mut self.rays, &mut self.sample);
            if sample == [0, 0] {
                std::mem::swap(&mut self.sum, &mut self.sample);
            } else {
                self.sum.add_all(&self.sample);
            }
        }
        self.store(rect, n * n, settings.width as usize, band);
        times.tracing = self.shader.tracing;
        times.shading = tile_start.elapsed() - times.ray_generation - times.tracing;
        let counts = RayCounts {
            camera: u64::from(pixels) * u64::from(n * n),
            shadow: self.shader.shadow_rays,
            reflection: self.shader.reflection_rays,
        };
        (counts, times)
    }

    #[inline(never)]
    /// Averages the samples, and brings packets into rows.
    fn store(&self, rect: TileRect, samples: u32, row_length: usize, band: &mut [[f32; 3]]) {
        let samples8 = splat(samples as f32);
        let mut sums = self.sum.packets.iter();
        for_each_packet(rect, |[x, y]| {
            let Some([r, g, b]) = sums.next() else { return };
            let (r, g, b) = (*r / samples8, *g / samples8, *b / samples8);
            let columns = PACKET[0].min(rect.width - x) as usize;
            for row in 0..PACKET[1].min(rect.height - y) {
                let start = (y + row) as usize * row_length + (rect.x + x) as usize;
                let first_lane = (row * PACKET[0]) as usize;
                let pixels = &mut band[start..start + columns];
                store_row(pixels, first_lane, &r, &g, &b);
            }
        });
    }
}

/// Writes the colours of up to four lanes.
#[inline(always)]
fn store_row(pixels: &mut [[f32; 3]], first_lane: usize, r: &F32x8, g: &F32x8, b: &F32x8) {
    let pixel = |column: usize| {
        let lane = first_lane + column;
        [r.as_array()[lane], g.as_array()[lane], b.as_array()[lane]]
    };
    if let [p0, p1, p2, p3] = pixels {
        (*p0, *p1, *p2, *p3) = (pixel(0), pixel(1), pixel(2), pixel(3));
    } else {
        for (column, to) in pixels.iter_mut().enumerate() {
            *to = pixel(column);
        }
    }
}

/// Calls `visit` with the top left pixel of each of a tile's packets, block by block.
#[inline(always)]
fn for_each_packet(rect: TileRect, mut visit: impl FnMut([u32; 2])) {
    for block_y in (0..rect.height).step_by(BLOCK as usize) {
        for block_x in (0..rect.width).step_by(BLOCK as usize) {
            for packet_i in 0..8 {
                let x = block_x + packet_i % 2 * PACKET[0];
                let y = block_y + packet_i / 2 * PACKET[1];
                if x < rect.width && y < rect.height {
                    visit([x, y]);
                }
            }
        }
    }
}

#[inline(never)]
/// Fills the queue with the camera rays of one sample of all pixels of the tile, block by block.
fn fill(context: &FrameContext<'_>, rect: TileRect, sample: [u32; 2], rays: &mut RayQueue) {
    rays.clear();
    let origin = Vec3x8::splat(context.pixel_rays.eye());
    let mut first = 0;
    for_each_packet(rect, |[x, y]| {
        let packet = RayPacket {
            origin,
            direction: context.pixel_rays.directions8(rect.x + x, rect.y + y, sample),
            t_max: Mask8::from_bits(inside(rect, x, y)).select(splat(T_MAX), splat(0.0)),
        };
        let mut pixel = [0; LANES];
        for (to, i) in pixel.iter_mut().zip(first..) {
            *to = i;
        }
        first += LANES as u32;
        rays.push(packet, pixel, splat(1.0));
    });
}

/// The lanes of a packet whose pixels are in the tile.
#[inline(always)]
fn inside(rect: TileRect, x: u32, y: u32) -> u32 {
    let columns = PACKET[0].min(rect.width - x);
    let row = (1 << columns) - 1;
    if rect.height - y < PACKET[1] {
        row
    } else {
        row | row << PACKET[0]
    }
}
