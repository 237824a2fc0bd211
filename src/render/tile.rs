//! Renders a tile: camera rays in packets of 4x2 pixels, traced and shaded sample by sample.

use super::{
    Pixel, RayCounts, TileTimes,
    frame::{FrameContext, TileRect},
};
use crate::{
    accel::Bvh,
    ray::{RayPacket, T_MAX},
    scene::{Scene, for_each_packet},
    shade::{ShadeSettings, Shader, TileColors, material::background, queue::RayQueue},
    simd_old::{F32x8, LANES, Mask8, Vec3x8, splat},
    trace::Tracer,
};
use std::time::Instant;

/// Width and height of a packet, pixels.
const PACKET: [u32; 2] = [4, 2];
/// Pixels of a packet's row.
const ROW: usize = PACKET[0] as usize;

/// The scratch memory of a thread.
#[derive(Debug)]
pub(super) struct TileScratch<'a> {
    tracer: Tracer<'a>,
    shader: Shader,
    rays: RayQueue,
    sample: TileColors,
    sum: TileColors,
}

impl<'a> TileScratch<'a> {
    /// Reserves memory for tiles of `width` x `height` pixels.
    pub fn new(scene: &Scene, bvh: &'a Bvh, [width, height]: [u32; 2]) -> Self {
        let pixels = (width * height) as usize;
        let mut scratch = Self {
            tracer: Tracer::new(bvh),
            shader: Shader::default(),
            rays: RayQueue::default(),
            sample: TileColors::default(),
            sum: TileColors::default(),
        };
        scratch.shader.reserve(scene, pixels, &mut scratch.rays);
        scratch.sample.resize(pixels / LANES);
        scratch.sum.resize(pixels / LANES);
        scratch.sample.alpha.reserve(pixels / LANES);
        scratch.sum.alpha.reserve(pixels / LANES);
        scratch
    }

    /// Renders a tile into `band`, the rows of the film from `rect.y` on.
    pub fn render<P: Pixel>(
        &mut self,
        context: &FrameContext<'_>,
        rect: TileRect,
        band: &mut [P],
    ) -> (RayCounts, TileTimes) {
        let &FrameContext { scene, settings, .. } = context;
        let start = Instant::now();
        self.shader.reset_counts();
        let may_hit = self.may_hit(context, rect);
        let mut times = TileTimes {
            tracing: start.elapsed(),
            ..TileTimes::default()
        };
        let row_length = context.window.width() as usize;
        match constant_background::<P>(scene) {
            Some(color) if !may_hit => {
                let start = Instant::now();
                fill(color, settings.samples, rect, row_length, band);
                times.film = start.elapsed();
            }
            _ => self.render_samples(context, rect, may_hit, band, &mut times),
        }
        let counts = RayCounts {
            camera: u64::from(rect.width * rect.height) * u64::from(settings.samples),
            shadow: self.shader.shadow_rays,
            reflection: self.shader.reflection_rays,
        };
        (counts, times)
    }

    /// Returns whether camera rays of the tile may hit anything.
    // Tuned: see docs/lab-notes.md#empty-tiles
    fn may_hit(&self, context: &FrameContext<'_>, rect: TileRect) -> bool {
        let first = [context.window.x0 + rect.x, context.window.y0 + rect.y];
        let corners = context.camera_rays.corners(first, [rect.width, rect.height]);
        self.tracer.may_hit(context.camera_rays.eye(), corners)
    }

    fn render_samples<P: Pixel>(
        &mut self,
        context: &FrameContext<'_>,
        rect: TileRect,
        may_hit: bool,
        band: &mut [P],
        times: &mut TileTimes,
    ) {
        let &FrameContext { scene, settings, .. } = context;
        let shade = ShadeSettings {
            max_depth: settings.max_depth,
            shadows: settings.shadows,
            transparent: P::HAS_ALPHA,
        };
        let row_length = context.window.width() as usize;
        let tile_start = Instant::now();
        for sample in context.camera_rays.samples() {
            if may_hit {
                let start = Instant::now();
                generate_rays(context, rect, sample, &mut self.rays);
                times.ray_generation += start.elapsed();
                self.shader
                    .shade(scene, &mut self.tracer, shade, &mut self.rays, &mut self.sample);
            } else {
                shade_background(context, rect, sample, &mut self.sample);
            }
            if sample == [0, 0] {
                std::mem::swap(&mut self.sum, &mut self.sample);
            } else {
                self.sum.add_all(&self.sample);
            }
        }
        let start = Instant::now();
        self.store(rect, settings.samples, row_length, band);
        times.film = start.elapsed();
        times.shading = tile_start
            .elapsed()
            .saturating_sub(times.ray_generation + self.shader.tracing + times.film);
        times.tracing += self.shader.tracing;
    }

    /// Averages the samples and writes the packets to the rows of `band`.
    #[inline(never)]
    fn store<P: Pixel>(&self, rect: TileRect, samples: u32, row_length: usize, band: &mut [P]) {
        let samples8 = splat(samples as f32);
        let mut sums = self.sum.packets.iter();
        let mut alphas = self.sum.alpha.iter();
        for_each_packet(rect.width, rect.height, |[x, y]| {
            let Some(&sum) = sums.next() else { return };
            let alpha8 = alphas.next().map_or(splat(1.0), |&alpha8| alpha8 / samples8);
            // Dividing by 1 changes nothing.
            let average = if samples == 1 {
                sum
            } else {
                sum.map(|c| c / samples8)
            };
            let pixels = P::from_lanes(&average, &alpha8);
            let start = y as usize * row_length + (rect.x + x) as usize;
            let columns = ROW.min((rect.width - x) as usize);
            let (rows, _) = pixels.as_chunks::<ROW>();
            let rows = rows.iter().take((rect.height - y) as usize);
            for (from, start) in rows.zip((start..).step_by(row_length)) {
                match band[start..start + columns].first_chunk_mut::<ROW>() {
                    Some(to) => *to = *from,
                    None => store_part(from, &mut band[start..start + columns]),
                }
            }
        });
    }
}

/// Stores a partial row at the film's right edge. A cold function, else all rows are copied by calls of `memmove`.
// Tuned: see docs/lab-notes.md#store-part
#[cold]
fn store_part<P: Pixel>(from: &[P; ROW], to: &mut [P]) {
    to.copy_from_slice(&from[..to.len()]);
}

/// Fills the queue with the camera rays of one sample of every pixel of the tile.
#[inline(never)]
pub(super) fn generate_rays(
    context: &FrameContext<'_>,
    rect: TileRect,
    sample: [u32; 2],
    rays: &mut RayQueue,
) {
    rays.restart(Some(context.camera_rays.eye()));
    let (left, top) = (context.window.x0 + rect.x, context.window.y0 + rect.y);
    for_each_packet(rect.width, rect.height, |[x, y]| {
        let packet = RayPacket {
            direction: context.camera_rays.directions8(left + x, top + y, sample),
            t_max: Mask8::from_bits(inside(rect, x, y)).select(splat(T_MAX), splat(0.0)),
        };
        rays.push(packet);
    });
}

/// Returns the RGBA of all camera rays that hit nothing, if it is the same in all directions.
fn constant_background<P: Pixel>(scene: &Scene) -> Option<[F32x8; 4]> {
    if P::HAS_ALPHA {
        return Some([splat(0.0); 4]);
    }
    if !scene.background().is_constant() {
        return None;
    }
    let [r, g, b] = background(scene, &Vec3x8::ZERO);
    Some([r, g, b, splat(1.0)])
}

/// Fills the tile with the average of `samples` samples of one colour, summed as other samples are.
fn fill<P: Pixel>(color: [F32x8; 4], samples: u32, rect: TileRect, row_length: usize, band: &mut [P]) {
    let average = color.map(|c| (1..samples).fold(c, |sum, _| sum + c) / splat(samples as f32));
    let [r, g, b, alpha] = average;
    let pixels = P::from_lanes(&[r, g, b], &alpha);
    for row in band.chunks_mut(row_length).take(rect.height as usize) {
        let (eights, rest) = row[rect.x as usize..][..rect.width as usize].as_chunks_mut::<LANES>();
        eights.fill(pixels);
        rest.copy_from_slice(&pixels[..rest.len()]);
    }
}

/// Computes one sample of every pixel of an empty tile under a gradient background.
#[inline(never)]
fn shade_background(context: &FrameContext<'_>, rect: TileRect, sample: [u32; 2], colors: &mut TileColors) {
    colors.resize(0);
    let (left, top) = (context.window.x0 + rect.x, context.window.y0 + rect.y);
    for_each_packet(rect.width, rect.height, |[x, y]| {
        let direction = context.camera_rays.directions8(left + x, top + y, sample);
        colors.packets.push(background(context.scene, &direction));
    });
}

/// Returns the lanes of a packet whose pixels are in the tile, a bit each.
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
