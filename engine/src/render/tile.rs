//! Renders a tile: camera rays in packets of 4x2 pixels, traced and shaded sample by sample.

mod refine;

use super::{
    Pixel, RayCounts, TileTimes,
    adaptive::Neighborhood,
    frame::{FrameContext, TileRect},
    sums::{BLOCK, Blocks, Samples, begins_block},
};
use crate::{
    accel::Bvh,
    lanes::{F32x8, LANES, Vec3x8},
    ray::{HitPacket, Origins, Ray, RayPacket, SceneHit, T_MAX},
    scene::{Scene, for_each_packet},
    shade::{ShadeSettings, Shader, TileColors, material::background, queue::RayQueue},
    simd::{EightLanes, Lanes, Level, Portable, Simd, at_level},
    trace::Tracer,
};
use std::time::Instant;

/// Width and height of a packet, pixels.
pub(super) const PACKET: [u32; 2] = [4, 2];
/// Pixels of a packet's row.
pub(super) const ROW: usize = PACKET[0] as usize;

/// The scratch memory of a thread.
#[derive(Debug)]
pub(super) struct TileScratch<'a> {
    tracer: Tracer<'a>,
    shader: Shader,
    rays: RayQueue,
    sample: TileColors,
    sum: TileColors,
    blocks: Blocks,
    /// For adaptive pictures.
    neighborhood: Neighborhood,
    /// The absolute pixels that take more samples.
    refined: Vec<[u32; 2]>,
    /// Packets of camera rays for which there is memory.
    packets: usize,
}

impl<'a> TileScratch<'a> {
    /// Reserves memory for tiles of `width` x `height` pixels.
    pub fn new(scene: &'a Scene, bvh: &'a Bvh, [width, height]: [u32; 2]) -> Self {
        // Adaptive tiles have a ring around them, which whole packets exceed.
        let mut packets = 0;
        for_each_packet(width + 2, height + 2, |_| packets += 1);
        let pixels = packets * LANES;
        let mut scratch = Self {
            tracer: Tracer::new(bvh).of_scene(scene),
            shader: Shader::default(),
            rays: RayQueue::default(),
            sample: TileColors::default(),
            sum: TileColors::default(),
            blocks: Blocks::default(),
            neighborhood: Neighborhood::default(),
            refined: Vec::with_capacity((width * height) as usize),
            packets,
        };
        scratch.shader.reserve(scene, pixels, &mut scratch.rays);
        scratch.neighborhood.reserve([width, height]);
        for colors in [&mut scratch.sample, &mut scratch.sum] {
            colors.resize(packets);
            colors.alpha.reserve(packets);
        }
        scratch
    }

    /// Traces a single ray.
    pub fn closest_hit(&mut self, level: Level, ray: &Ray) -> SceneHit {
        let lane =
            |of: f32, other: f32| F32x8::new(std::array::from_fn(|lane| if lane == 0 { of } else { other }));
        let packet = RayPacket {
            direction: Vec3x8::from_lanes([ray.direction; LANES]),
            t_max: lane(ray.t_max, 0.0),
        };
        let mut hits = [HitPacket::miss(packet.t_max)];
        self.tracer.hold_to(level);
        self.tracer
            .closest_hit(Origins::Shared(ray.origin), &[packet], &mut hits);
        self.tracer.scene_hit(&hits, 0, 0)
    }

    /// Renders a tile into `band`, the rows of the film from `rect.y` on.
    pub fn render<P: Pixel>(
        &mut self,
        context: &FrameContext<'_>,
        rect: TileRect,
        band: &mut [P],
    ) -> (RayCounts, TileTimes) {
        if context.settings.adaptive {
            return self.render_adaptive(context, rect, band);
        }
        let &FrameContext { scene, settings, .. } = context;
        let (may_hit, mut times) = self.begin(context, rect);
        let row_length = context.window.width() as usize;
        match constant_background::<P>(scene) {
            Some(color) if !may_hit => {
                let start = Instant::now();
                fill(color, settings.samples, rect, row_length, band);
                times.film = start.elapsed();
            }
            _ => {
                let tile_start = Instant::now();
                let divisor = self.sum_samples(context, rect, may_hit, P::HAS_ALPHA, &mut times);
                let start = Instant::now();
                at_level!(settings.level, |simd| self
                    .store(simd, rect, divisor, row_length, band));
                times.film = start.elapsed();
                self.end(tile_start, &mut times);
            }
        }
        (self.counts(rect.pixels() * u64::from(settings.samples)), times)
    }

    /// Begins a tile: returns whether its camera rays may hit anything, and the time that took.
    fn begin(&mut self, context: &FrameContext<'_>, rect: TileRect) -> (bool, TileTimes) {
        let start = Instant::now();
        self.tracer.hold_to(context.settings.level);
        self.shader.reset_counts();
        let may_hit = self.may_hit(context, rect);
        let times = TileTimes {
            tracing: start.elapsed(),
            ..TileTimes::default()
        };
        (may_hit, times)
    }

    /// Takes the time since `start` that is not in `times` yet.
    fn end(&self, start: Instant, times: &mut TileTimes) {
        times.shading = start
            .elapsed()
            .saturating_sub(times.ray_generation + self.shader.tracing + times.film);
        times.tracing += self.shader.tracing;
    }

    /// Returns the rays of the tile.
    fn counts(&self, camera: u64) -> RayCounts {
        RayCounts {
            camera,
            shadow: self.shader.shadow_rays,
            ambient: self.shader.ambient_rays,
            reflection: self.shader.reflection_rays,
        }
    }

    /// Returns whether camera rays of the tile may hit anything.
    // Tuned: see docs/lab-notes.md#empty-tiles
    fn may_hit(&self, context: &FrameContext<'_>, rect: TileRect) -> bool {
        let first = [context.window.x0 + rect.x, context.window.y0 + rect.y];
        // A cone of rays needs an apex.
        context.camera_rays.shared_origin().is_none_or(|origin| {
            let corners = context.camera_rays.corners(first, [rect.width, rect.height]);
            self.tracer.may_hit(origin, corners)
        })
    }

    /// Sums the samples that every pixel takes. Returns the divisor of the sums.
    fn sum_samples(
        &mut self,
        context: &FrameContext<'_>,
        rect: TileRect,
        may_hit: bool,
        transparent: bool,
        times: &mut TileTimes,
    ) -> u32 {
        let &FrameContext { scene, settings, .. } = context;
        self.blocks.restart();
        if scene.is_sampled() && may_hit {
            self.set_pixels(context, rect);
        }
        let count = context.first_samples();
        let samples = context.camera_rays.samples().take(count as usize);
        for (i, sample) in (0..).zip(samples) {
            if may_hit {
                let start = Instant::now();
                generate_rays(context, rect, sample, &mut self.rays);
                times.ray_generation += start.elapsed();
                self.shade(context, context.camera_rays.index(sample), transparent);
            } else {
                let colors = &mut self.sample;
                at_level!(settings.level, |simd| shade_background(
                    simd, context, rect, sample, colors
                ));
            }
            if begins_block(i) {
                self.blocks.add(&self.sum);
            }
            if i.is_multiple_of(BLOCK) {
                std::mem::swap(&mut self.sum, &mut self.sample);
            } else {
                at_level!(settings.level, |simd| self.sum.add_all(simd, &self.sample));
            }
        }
        self.blocks.finish(&mut self.sum, count)
    }

    /// Traces and shades the camera rays of the queue; `sample` is added to the indices of the pixels' first points.
    fn shade(&mut self, context: &FrameContext<'_>, sample: u32, transparent: bool) {
        let settings = ShadeSettings {
            max_depth: context.settings.max_depth,
            shadows: context.settings.shadows,
            sample,
            cone: context.camera_rays.cone(),
            transparent,
            medium: context.medium,
            edges: context.edges.as_ref(),
        };
        let (tracer, rays, colors) = (&mut self.tracer, &mut self.rays, &mut self.sample);
        self.shader.shade(context.scene, tracer, settings, rays, colors);
    }

    /// Sets the pixels of the shader.
    fn set_pixels(&mut self, context: &FrameContext<'_>, rect: TileRect) {
        let samples = context.settings.samples;
        self.shader.clear_pixels();
        for_each_packet(rect.width, rect.height, |[x, y]| {
            let pixels = pixels_of(rect.absolute(context.window), x, y);
            self.shader.push_pixels(pixels, samples, 0);
        });
    }

    /// Averages the samples and writes the packets to the rows of `band`.
    #[inline(always)]
    fn store<S: Simd, P: Pixel>(
        &self,
        simd: S,
        rect: TileRect,
        divisor: u32,
        row_length: usize,
        band: &mut [P],
    ) {
        let is_mean = divisor == 1;
        let divisor = simd.splat(divisor as f32);
        let mut sums = self.sum.packets.iter();
        let mut alphas = self.sum.alpha.iter();
        for_each_packet(
            rect.width,
            rect.height,
            #[inline(always)]
            |[x, y]| {
                let Some([r, g, b]) = sums.next() else { return };
                let mut average = [simd.load(r), simd.load(g), simd.load(b), simd.splat(1.0)];
                // Dividing by 1 changes nothing.
                if !is_mean {
                    for channel in &mut average[..3] {
                        *channel = *channel / divisor;
                    }
                }
                if let Some(alpha) = alphas.next() {
                    average[3] = simd.load(alpha) / divisor;
                }
                let pixels = P::from_lanes(simd, average);
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
            },
        );
    }
}

/// Stores a partial row at the film's right edge. A cold function, else all rows are copied by calls of `memmove`.
// Tuned: see docs/lab-notes.md#store-part
#[cold]
fn store_part<P: Pixel>(from: &[P; ROW], to: &mut [P]) {
    to.copy_from_slice(&from[..to.len()]);
}

/// Fills the queue with the camera rays of one sample of every pixel of the tile.
pub(super) fn generate_rays(
    context: &FrameContext<'_>,
    rect: TileRect,
    sample: [u32; 2],
    rays: &mut RayQueue,
) {
    rays.restart_camera(context.camera_rays.shared_origin());
    if context.camera_rays.is_distorted() {
        let tile = rect.absolute(context.window);
        for_each_packet(rect.width, rect.height, |[x, y]| {
            let (pixels, t_max) = (pixels_of(tile, x, y), ends(inside(rect, x, y)));
            rays.push(context.camera_rays.distorted(&pixels, sample, t_max));
        });
        return;
    }
    at_level!(context.settings.level, |simd| push_rays(
        simd, context, rect, sample, rays
    ));
}

/// Returns the ends of camera rays, of which those in the lanes `is_used` are traced.
fn ends(is_used: u32) -> F32x8 {
    let end = |lane| if is_used >> lane & 1 == 1 { T_MAX } else { 0.0 };
    F32x8::new(std::array::from_fn(end))
}

#[inline(always)]
fn push_rays<S: Simd>(
    simd: S,
    context: &FrameContext<'_>,
    rect: TileRect,
    sample: [u32; 2],
    rays: &mut RayQueue,
) {
    let (left, top) = (context.window.x0 + rect.x, context.window.y0 + rect.y);
    for_each_packet(
        rect.width,
        rect.height,
        #[inline(always)]
        |[x, y]| {
            let is_inside = simd.mask(inside(rect, x, y));
            let t_max = S::V8::select(is_inside, simd.splat(T_MAX), simd.splat(0.0)).to8();
            let pixel = [left + x, top + y];
            if rays.share_origin() {
                let direction = context.camera_rays.directions8(simd, pixel, sample);
                rays.push(RayPacket { direction, t_max });
            } else {
                let (origin, direction) = context.camera_rays.rays8(simd, pixel, sample);
                rays.push_apart(origin, RayPacket { direction, t_max });
            }
        },
    );
}

/// Returns the RGBA of all camera rays that hit nothing, if it is the same in all directions.
fn constant_background<P: Pixel>(scene: &Scene) -> Option<[f32; 4]> {
    if P::HAS_ALPHA {
        return Some([0.0; 4]);
    }
    if !scene.has_constant_background() {
        return None;
    }
    let [r, g, b] = background(Portable, scene, &Vec3x8::ZERO);
    Some([r.first(), g.first(), b.first(), 1.0])
}

/// Fills the tile with the average of `samples` samples of one colour, summed as other samples are.
fn fill<P: Pixel>(color: [f32; 4], samples: u32, rect: TileRect, row_length: usize, band: &mut [P]) {
    let mut all = Samples::default();
    for _ in 0..samples {
        all.begin();
        all.add(color);
    }
    let pixels = P::from_lanes(Portable, all.mean().map(|c| Portable.splat(c)));
    for row in band.chunks_mut(row_length).take(rect.height as usize) {
        let (eights, rest) = row[rect.x as usize..][..rect.width as usize].as_chunks_mut::<LANES>();
        eights.fill(pixels);
        rest.copy_from_slice(&pixels[..rest.len()]);
    }
}

/// Computes one sample of every pixel of an empty tile under a gradient background.
#[inline(always)]
fn shade_background<S: Simd>(
    simd: S,
    context: &FrameContext<'_>,
    rect: TileRect,
    sample: [u32; 2],
    colors: &mut TileColors,
) {
    colors.resize(0);
    let (left, top) = (context.window.x0 + rect.x, context.window.y0 + rect.y);
    for_each_packet(
        rect.width,
        rect.height,
        #[inline(always)]
        |[x, y]| {
            let direction = context.camera_rays.directions8(simd, [left + x, top + y], sample);
            let [r, g, b] = background(simd, context.scene, &direction);
            colors.packets.push([r.to8(), g.to8(), b.to8()]);
        },
    );
}

/// Returns the pixels of the packet at (`x`, `y`) of a tile.
fn pixels_of(rect: TileRect, x: u32, y: u32) -> [[u32; 2]; LANES] {
    std::array::from_fn(|lane| {
        let (column, row) = (lane % ROW, lane / ROW);
        [rect.x + x + column as u32, rect.y + y + row as u32]
    })
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
