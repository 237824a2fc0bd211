//! Adaptive tiles: the first samples of all pixels, then more of those that differ from a neighbour.

use super::{TileScratch, constant_background, ends, fill, inside, pixels_of};
use crate::{
    lanes::LANES,
    ray::{RayPacket, T_MAX},
    render::{
        Pixel, RayCounts, TileTimes,
        adaptive::{Grade, Neighborhood},
        frame::{FrameContext, TileRect},
    },
    scene::for_each_packet,
    shade::{TileColors, queue::RayQueue},
    simd::{EightLanes, Lanes, Simd, at_level},
};
use std::{ops::Range, time::Instant};

impl TileScratch<'_> {
    /// Renders a tile of an adaptive picture into `band`, the rows of the film from `rect.y` on.
    pub(super) fn render_adaptive<P: Pixel>(
        &mut self,
        context: &FrameContext<'_>,
        rect: TileRect,
        band: &mut [P],
    ) -> (RayCounts, TileTimes) {
        let row_length = context.window.width() as usize;
        let (settings, first_samples) = (context.settings, context.first_samples());
        let (tile, whole) = (rect.absolute(context.window), context.whole());
        let area = self.neighborhood.restart(tile, &settings, first_samples);
        let (may_hit, mut times) = self.begin(&whole, area);
        let mut camera = area.pixels() * u64::from(first_samples);
        match constant_background::<P>(context.scene) {
            Some(color) if !may_hit => {
                let start = Instant::now();
                fill(color, first_samples, rect, row_length, band);
                times.film = start.elapsed();
            }
            _ => {
                let tile_start = Instant::now();
                self.sum_samples(&whole, area, may_hit, P::HAS_ALPHA, &mut times);
                let start = Instant::now();
                at_level!(settings.level, |simd| self.spread(simd, area, first_samples));
                times.film = start.elapsed();
                for grade in whole.grades() {
                    self.find_refined(tile, grade);
                    camera += self.refine(&whole, first_samples..grade.samples, P::HAS_ALPHA, &mut times);
                }
                let start = Instant::now();
                let neighborhood = &self.neighborhood;
                at_level!(settings.level, |simd| neighborhood
                    .store(simd, tile, rect.x, row_length, band));
                times.film += start.elapsed();
                self.end(tile_start, &mut times);
            }
        }
        (self.counts(camera), times)
    }

    /// Moves the sums of the first samples from packets to pixels, and compares them.
    #[inline(always)]
    fn spread<S: Simd>(&mut self, simd: S, area: TileRect, count: u32) {
        let opaque = simd.splat(count as f32).to8();
        let mut alphas = self.sum.alpha.iter();
        let mut sums = self.sum.packets.iter();
        for_each_packet(
            area.width,
            area.height,
            #[inline(always)]
            |at| {
                let Some([r, g, b]) = sums.next() else { return };
                let alpha = alphas.next().unwrap_or(&opaque);
                self.neighborhood.set_packet(at, [r, g, b, alpha]);
            },
        );
        self.neighborhood.compare();
    }

    /// Lists the pixels of a grade, in the order of packets.
    fn find_refined(&mut self, tile: TileRect, grade: Grade) {
        self.refined.clear();
        for_each_packet(tile.width, tile.height, |[x, y]| {
            let (is_inside, pixels) = (inside(tile, x, y), pixels_of(tile, x, y));
            let pixels = (0..LANES)
                .filter(|lane| is_inside >> lane & 1 == 1)
                .map(|lane| pixels[lane]);
            let neighborhood = &self.neighborhood;
            self.refined
                .extend(pixels.filter(|&pixel| neighborhood.is_of(pixel, grade)));
        });
    }

    /// Adds samples of the listed pixels, and returns how many.
    fn refine(
        &mut self,
        context: &FrameContext<'_>,
        wanted: Range<u32>,
        transparent: bool,
        times: &mut TileTimes,
    ) -> u64 {
        let samples_at_once = (wanted.len() as u32).clamp(1, self.packets as u32);
        let pixels_at_once = self.packets / samples_at_once as usize * LANES;
        let refined = std::mem::take(&mut self.refined);
        for pixels in refined.chunks(pixels_at_once) {
            for sample in wanted.clone().step_by(samples_at_once as usize) {
                let samples = sample..wanted.end.min(sample.saturating_add(samples_at_once));
                self.add_samples(context, (pixels, samples), transparent, times);
            }
            for &pixel in pixels {
                self.neighborhood.average(pixel);
            }
        }
        let count = refined.len() as u64 * wanted.len() as u64;
        self.refined = refined;
        count
    }

    /// Adds some samples of some pixels: one packet per eight pixels and sample, so bundles are narrow.
    fn add_samples(
        &mut self,
        context: &FrameContext<'_>,
        (pixels, samples): (&[[u32; 2]], Range<u32>),
        transparent: bool,
        times: &mut TileTimes,
    ) {
        let start = Instant::now();
        self.rays.restart_camera(context.camera_rays.shared_origin());
        if context.camera_rays.is_distorted() {
            push_distorted(context, pixels, samples.clone(), &mut self.rays);
        } else {
            at_level!(context.settings.level, |simd| push_rays(
                simd,
                context,
                pixels,
                samples.clone(),
                &mut self.rays
            ));
        }
        if context.scene.is_sampled() {
            self.shader.clear_pixels();
            for (pixels, _) in packets(pixels) {
                for sample in samples.clone() {
                    self.shader.push_pixels(pixels, context.settings.samples, sample);
                }
            }
        }
        times.ray_generation += start.elapsed();
        self.shade(context, 0, transparent);
        let (neighborhood, sample) = (&mut self.neighborhood, &self.sample);
        at_level!(context.settings.level, |simd| add_colors(
            simd,
            neighborhood,
            pixels,
            sample,
            samples.len()
        ));
    }
}

/// Adds colours, `per_packet` packets of them for every eight pixels.
#[inline(always)]
fn add_colors<S: Simd>(
    simd: S,
    neighborhood: &mut Neighborhood,
    pixels: &[[u32; 2]],
    colors: &TileColors,
    per_packet: usize,
) {
    for (i, pixels) in pixels.chunks(LANES).enumerate() {
        let at = i * per_packet..(i + 1) * per_packet;
        let alpha = colors.alpha.get(at.clone()).unwrap_or_default();
        neighborhood.add(simd, pixels, &colors.packets[at], alpha);
    }
}

/// Returns pixels eight at a time, and the number in each packet; unused lanes repeat its first pixel.
fn packets(pixels: &[[u32; 2]]) -> impl Iterator<Item = ([[u32; 2]; LANES], usize)> {
    pixels.chunks(LANES).map(|pixels| {
        let packet = std::array::from_fn(|lane| *pixels.get(lane).unwrap_or(&pixels[0]));
        (packet, pixels.len())
    })
}

fn push_distorted(context: &FrameContext<'_>, pixels: &[[u32; 2]], samples: Range<u32>, rays: &mut RayQueue) {
    for (pixels, count) in packets(pixels) {
        let t_max = ends((1 << count) - 1);
        for sample in samples.clone() {
            rays.push(context.camera_rays.distorted(&pixels, [sample, 0], t_max));
        }
    }
}

#[inline(always)]
fn push_rays<S: Simd>(
    simd: S,
    context: &FrameContext<'_>,
    pixels: &[[u32; 2]],
    samples: Range<u32>,
    rays: &mut RayQueue,
) {
    for (pixels, count) in packets(pixels) {
        let is_used = simd.mask((1 << count) - 1);
        let t_max = S::V8::select(is_used, simd.splat(T_MAX), simd.splat(0.0)).to8();
        for sample in samples.clone() {
            if rays.share_origin() {
                let direction = context.camera_rays.directions_of(simd, &pixels, [sample, 0]);
                rays.push(RayPacket { direction, t_max });
            } else {
                let (origin, direction) = context.camera_rays.rays_of(simd, &pixels, [sample, 0]);
                rays.push_apart(origin, RayPacket { direction, t_max });
            }
        }
    }
}
