//! Batched Whitted shading: each pass is one function over a queue, eight lanes at a time.
//!
//! ```text
//! ray queue -> trace -> queue::sort      hits by material; misses take the background
//!    ^                  surface::gather  hits -> surface packets
//!    |                  tint::gather     their colours, if the scene has any
//!    |                  texture::pass    and textures
//!    |                  gather           one run of occlusion rays per light
//!    +---- mirrored --- material::color  light -> colours of the tile
//!    +---- branches --- glass::pass      reflected and refracted rays
//!                       blend::pass      rays that continue behind half-transparent surfaces
//! ```
//!
//! The scalar version, with the same operations in the same order, is [`reference::shade`](crate::reference::shade).

mod blend;
mod draw;
mod edges;
mod environment;
mod found;
mod gather;
mod glass;
mod light;
pub mod material;
pub mod queue;
pub mod shadow;
mod soft;
pub mod surface;
mod texture;
mod through;
mod tint;

use crate::{
    lanes::{F32x8, LANES},
    ray::{HitPacket, PrimitiveId},
    scene::{EdgeLines, Material, MaterialId, RayCone, Scene, SurfaceTextures},
    simd::{EightLanes, Lanes, Level, Simd, at_level},
    sobol,
    trace::Tracer,
};
pub(crate) use draw::disc;
use found::Found;
use material::{Light8, Points};
use queue::RayQueue;
use std::time::Duration;

/// Offset of secondary rays off the surface, as a share of the primitive's largest absolute coordinate: 32 half-ulps,
/// three times the rounding error of a point on it. After Wächter and Binder, *Ray Tracing Gems* ch. 6, 2019, who scale
/// by the point; scaling by the primitive treats scenes of any size and position alike.
// Tuned: see docs/lab-notes.md#surface-offset
pub const SURFACE_OFFSET: f32 = 32.0 / (1 << 24) as f32;

/// Additional offset of the shadow rays of point lights, as a share of the light's distance: 32 half-ulps, the rounding error of a plane
/// seen from the light, where shadow rays start.
pub const LIGHT_OFFSET: f32 = 32.0 / (1 << 24) as f32;

/// The settings of shading.
#[derive(Clone, Copy, Debug)]
pub struct ShadeSettings<'a> {
    /// Maximum ray depth; 1 disables reflections and refraction. Rays beyond it return the background. Half-transparent
    /// surfaces do not count.
    pub max_depth: u32,
    /// Whether to trace shadow and ambient occlusion rays.
    pub shadows: bool,
    /// The index of the sample in its pixel, which seeds random directions.
    pub sample: u32,
    /// The width of camera rays, which selects mipmap levels.
    pub cone: RayCone,
    /// Whether camera rays that hit nothing stay black, and [`TileColors::alpha`] is filled.
    pub transparent: bool,
    /// The tinted glass that camera rays start in.
    pub medium: Option<MaterialId>,
    /// The edges to draw over what camera rays hit.
    pub edges: Option<&'a EdgeLines>,
}

/// The scratch memory of shading a tile, reused from tile to tile.
#[derive(Debug, Default)]
pub struct Shader {
    found: Found,
    light: Vec<Light8>,
    /// The ambient light at each surface; empty if nothing blocks it.
    ambient: Vec<F32x8>,
    arriving: shadow::Arriving,
    shadow: shadow::Scratch,
    /// The tinted glass that each surface packet is seen in; empty if none is in any.
    media: Vec<[Option<MaterialId>; LANES]>,
    next: RayQueue,
    /// Indices of the first random points of the tile's pixels, by packet.
    first_points: Vec<[u32; LANES]>,
    /// The rays of each depth in scenes where rays branch.
    branches: Vec<glass::Depth>,
    /// The transmittance of camera rays that start in tinted glass, by channel; empty for others.
    passed: Vec<[F32x8; 3]>,
    /// The shares of camera rays that edges cover.
    covers: Vec<F32x8>,
    /// Ambient occlusion rays traced since [`Shader::reset_counts`].
    pub ambient_rays: u64,
    /// Shadow rays traced since [`Shader::reset_counts`].
    pub shadow_rays: u64,
    /// Reflection and refraction rays traced since [`Shader::reset_counts`].
    pub reflection_rays: u64,
    /// Time spent in the tracer since [`Shader::reset_counts`].
    pub tracing: Duration,
}

/// One sample of every pixel of a tile, linear RGB, in the order of the camera packets: pixel `i` is lane `i % 8` of
/// packet `i / 8`.
#[derive(Debug, Default)]
pub struct TileColors {
    /// Red, green and blue of each camera packet.
    pub packets: Vec<[F32x8; 3]>,
    /// Opacity of what each camera ray hits, 0 if that is nothing; empty unless [`ShadeSettings::transparent`].
    pub alpha: Vec<F32x8>,
}

impl TileColors {
    /// Resizes to `packets` camera packets of unspecified colours, and clears `alpha`.
    pub fn resize(&mut self, packets: usize) {
        self.packets.resize(packets, [F32x8::ZERO; 3]);
        self.alpha.clear();
    }

    /// Adds the colours of `other`, pixel by pixel.
    #[inline(always)]
    pub(crate) fn add_all<S: Simd>(&mut self, simd: S, other: &Self) {
        for (i, sums) in self.packets.iter_mut().enumerate() {
            for (channel, sum) in sums.iter_mut().enumerate() {
                *sum = (simd.load(sum) + simd.load(&other.packets[i][channel])).to8();
            }
        }
        for (i, sum) in self.alpha.iter_mut().enumerate() {
            *sum = (simd.load(sum) + simd.load(&other.alpha[i])).to8();
        }
    }

    /// Multiplies the colours by `factors`.
    #[inline(always)]
    fn tint<S: Simd>(&mut self, simd: S, factors: &[[F32x8; 3]]) {
        for (colors, factors) in self.packets.iter_mut().zip(factors) {
            for (color, factor) in colors.iter_mut().zip(factors) {
                *color = (simd.load(color) * simd.load(factor)).to8();
            }
        }
    }

    /// Sets the colours of camera packet `p`; lanes outside `bits` become black.
    #[inline(always)]
    fn set<S: Simd>(&mut self, simd: S, p: usize, bits: u32, color: [S::V8; 3]) {
        let (mask, black) = (simd.mask(bits), simd.splat(0.0));
        for (to, channel) in self.packets[p].iter_mut().zip(color) {
            *to = S::V8::select(mask, channel, black).to8();
        }
    }

    /// Adds weight x colour to the pixels of the lanes in `bits`.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, bits: u32, pixel: &[u32; LANES], weight: S::V8, color: [S::V8; 3]) {
        let first = pixel[0];
        // Most packets still hold the pixels of one camera packet in lane order.
        if first.is_multiple_of(LANES as u32) && is_run(pixel, first) {
            let added = simd.mask(bits);
            for (sum, channel) in self.packets[first as usize / LANES].iter_mut().zip(color) {
                // Other lanes add 0: selecting between sums would become a masked store.
                // Tuned: see docs/lab-notes.md#tile-colors-add
                let channel = S::V8::select(added, channel, simd.splat(0.0));
                *sum = weight.mul_add(channel, simd.load(sum)).to8();
            }
        } else {
            let [r, g, b] = color;
            self.scatter(simd, bits, pixel, &weight.to8(), &[r.to8(), g.to8(), b.to8()]);
        }
    }

    // Rare, so not inlined; it therefore enters the level again, for fused multiply-adds.
    #[inline(never)]
    fn scatter<S: Simd>(
        &mut self,
        simd: S,
        bits: u32,
        pixel: &[u32; LANES],
        weight: &F32x8,
        color: &[F32x8; 3],
    ) {
        simd.call(
            #[inline(always)]
            || {
                for lane in 0..LANES {
                    if bits >> lane & 1 == 0 {
                        continue;
                    }
                    let (packet, own_lane) = (pixel[lane] as usize / LANES, pixel[lane] as usize % LANES);
                    for (sums, color8) in self.packets[packet].iter_mut().zip(color) {
                        let sum = &mut sums.as_mut_array()[own_lane];
                        *sum = simd.mul_add(weight.as_array()[lane], color8.as_array()[lane], *sum);
                    }
                }
            },
        );
    }
}

/// Whether the numbers are `first`, `first + 1`, ...
#[inline(always)]
fn is_run(numbers: &[u32; LANES], first: u32) -> bool {
    let mut differ = 0;
    for (number, expected) in numbers.iter().zip(first..) {
        differ |= number ^ expected;
    }
    differ == 0
}

impl Shader {
    /// Reserves memory for tiles of `pixels` pixels of `scene`, also in the queue of camera rays.
    pub fn reserve(&mut self, scene: &Scene, pixels: usize, rays: &mut RayQueue) {
        let packets = queue::max_packets(pixels, scene.materials().len());
        rays.reserve(packets);
        self.next.reserve(packets);
        self.found.reserve(scene, pixels, packets);
        self.light.reserve(packets);
        self.arriving.reserve(packets);
        self.shadow.reserve(packets);
        if scene.is_sampled() {
            self.first_points.reserve(pixels.div_ceil(LANES));
            self.ambient.reserve(packets);
            self.shadow.origins.reserve(packets);
        }
    }

    /// Resets the counts of rays and the time to 0.
    pub fn reset_counts(&mut self) {
        (self.ambient_rays, self.shadow_rays, self.reflection_rays) = (0, 0, 0);
        self.tracing = Duration::ZERO;
    }

    /// Forgets the last tile's pixels.
    pub fn clear_pixels(&mut self) {
        self.first_points.clear();
    }

    /// Adds the absolute pixels of the next camera packet, column and row, for scenes that [are sampled](Scene::is_sampled).
    /// `samples`: the samples per pixel; `first`: the index of the first one here.
    pub fn push_pixels(&mut self, pixels: [[u32; 2]; LANES], samples: u32, first: u32) {
        self.first_points
            .push(pixels.map(|pixel| sobol::first_point(pixel, samples).wrapping_add(first)));
    }

    /// Traces and shades the camera rays in `rays` and their secondary rays, and writes `colors`. Leaves `rays` empty.
    // Tuned: see docs/lab-notes.md#camera-rays-set-colors
    pub fn shade(
        &mut self,
        scene: &Scene,
        tracer: &mut Tracer<'_>,
        settings: ShadeSettings<'_>,
        rays: &mut RayQueue,
        colors: &mut TileColors,
    ) {
        debug_assert!(
            rays.are_camera_rays() && settings.max_depth > 0,
            "only camera rays set colours, all others add to them"
        );
        if scene.has_glass() || scene.has_blending() {
            self.shade_branches(scene, tracer, settings, rays, colors);
        } else {
            self.shade_paths(scene, tracer, settings, rays, colors);
        }
        rays.restart();
        if let Some(edges) = settings.edges {
            edges::draw(edges, &self.covers, colors);
        }
    }

    /// [`Self::shade`] for scenes whose rays do not branch.
    fn shade_paths(
        &mut self,
        scene: &Scene,
        tracer: &mut Tracer<'_>,
        settings: ShadeSettings<'_>,
        rays: &mut RayQueue,
        colors: &mut TileColors,
    ) {
        colors.resize(rays.rays.packets().len());
        let level = tracer.level();
        for depth in 1..=settings.max_depth {
            self.next.restart();
            self.shade_depth(scene, tracer, (settings, depth), rays, colors);
            if depth == settings.max_depth {
                at_level!(level, |simd| material::background_pass(
                    simd, scene, &self.next, colors
                ));
                self.next.restart();
            }
            std::mem::swap(rays, &mut self.next);
            self.reflection_rays += rays.active_rays();
            if rays.rays.packets().is_empty() {
                break;
            }
        }
    }

    /// Traces and shades the rays of one depth, and queues the next ones.
    fn shade_depth(
        &mut self,
        scene: &Scene,
        tracer: &mut Tracer<'_>,
        (settings, depth): (ShadeSettings<'_>, u32),
        rays: &mut RayQueue,
        colors: &mut TileColors,
    ) {
        let level = tracer.level();
        self.tracing += self.found.trace(tracer, rays);
        let transparent = settings.transparent && (depth == 1 || scene.has_blending());
        self.found.passes_backs = true;
        self.found
            .gather(scene, (tracer, settings.cone), (rays, transparent), colors);
        if let Some(edges) = settings.edges
            && depth == 1
        {
            edges::cover(edges, scene, rays, &self.found, &mut self.covers);
        }
        if !rays.branches.is_empty() {
            glass::absorb(scene, rays, self.found.hits_of(rays));
        } else if let Some(medium) = settings.medium {
            let material = &scene.materials()[medium.0 as usize];
            glass::passed(material, self.found.hits_of(rays), &mut self.passed);
        }
        if transparent {
            let hits = self.found.hits_of(rays);
            at_level!(level, |simd| coverage(simd, hits, &mut colors.alpha));
        }
        if scene.has_blending() {
            blend::weigh(scene, rays, &mut self.found, &mut colors.alpha);
        }
        if !self.found.surfaces.is_empty() {
            glass::media_of(rays, &self.found.surfaces, &mut self.media);
            self.add_lights(scene, tracer, settings, depth - 1);
            self.color(scene, (level, transparent), rays, colors);
        }
    }

    /// Runs the passes of all materials.
    fn color(
        &mut self,
        scene: &Scene,
        (level, transparent): (Level, bool),
        rays: &RayQueue,
        colors: &mut TileColors,
    ) {
        for (id, range) in self.found.by_material.ranges() {
            let textures = scene.textures(id).unwrap_or(&SurfaceTextures::NONE);
            let material = &scene.materials()[id.0 as usize];
            let points = Points {
                surfaces: &self.found.surfaces[range.clone()],
                light: &self.light[range.clone()],
                tints: self.found.tints.get(range.clone()).unwrap_or_default(),
                speculars: match textures.specular_map {
                    Some(_) => &self.found.textured.specular[range.clone()],
                    None => &[],
                },
                ambient: self.ambient.get(range.clone()).unwrap_or_default(),
                distance: self
                    .found
                    .textured
                    .distance
                    .get(range.clone())
                    .unwrap_or_default(),
            };
            at_level!(level, |simd| material::color(
                simd,
                scene,
                material,
                points,
                colors,
                &mut self.next
            ));
            if textures.emits() {
                let (surfaces, light) = (points.surfaces, &self.found.textured.emitted[range]);
                at_level!(level, |simd| material::emission(simd, surfaces, light, colors));
            }
            if let Material::Glass { index, .. } = *material {
                at_level!(level, |simd| glass::pass(
                    simd,
                    scene,
                    (id, index),
                    points,
                    rays,
                    colors,
                    &mut self.next
                ));
            } else if self.next.sets_colors() {
                glass::branch_mirrored(rays, &mut self.next);
            }
            if let Some(opacity) = textures.opacity {
                let next = &mut self.next;
                let base = opacity.is_tinted.then(|| material.base_color());
                at_level!(level, |simd| blend::pass(
                    simd,
                    scene,
                    (points, base),
                    rays,
                    transparent,
                    colors,
                    next
                ));
            }
        }
    }

    /// [`Self::shade`] for scenes with glass or blending, whose rays branch.
    ///
    /// A pixel then has several rays at a depth, in an order that depends on its neighbours. So each ray has its own colour, and
    /// from the last depth up the colours of branches are added to those of their parents in a fixed order: refracted or
    /// straight branches, then reflected ones, whatever packets they are in.
    fn shade_branches(
        &mut self,
        scene: &Scene,
        tracer: &mut Tracer<'_>,
        settings: ShadeSettings<'_>,
        rays: &mut RayQueue,
        colors: &mut TileColors,
    ) {
        let level = tracer.level();
        let mut depths = std::mem::take(&mut self.branches);
        depths.resize_with(depths.len().max(1), Default::default);
        depths[0].swap(rays, colors, &mut self.first_points);
        depths[0].rays.medium = settings.medium;
        let mut last = 0;
        for i in 0.. {
            depths.resize_with(depths.len().max(i + 2), Default::default);
            let [own, next] = &mut depths[i..i + 2] else { break };
            own.colors.resize(own.rays.rays.packets().len());
            std::mem::swap(&mut self.first_points, &mut own.first_points);
            self.next.restart_branches();
            let depth = i as u32 + 1;
            self.shade_depth(scene, tracer, (settings, depth), &mut own.rays, &mut own.colors);
            at_level!(level, |simd| own.add_ended(simd, scene));
            std::mem::swap(&mut self.first_points, &mut own.first_points);
            std::mem::swap(&mut self.next, &mut next.rays);
            if next.rays.rays.packets().is_empty() {
                break;
            }
            last = i + 1;
            let traced = next.end(depth, settings.max_depth);
            if traced == 0 {
                at_level!(level, |simd| next.set_background(simd, scene));
                break;
            }
            self.reflection_rays += traced;
            next.take_first_points(&own.first_points);
        }
        for i in (1..=last).rev() {
            if let [own, next] = &mut depths[i - 1..=i] {
                at_level!(level, |simd| next.add_to(simd, &mut own.colors));
            }
        }
        depths[0].swap(rays, colors, &mut self.first_points);
        if settings.medium.is_some() {
            at_level!(level, |simd| colors.tint(simd, &self.passed));
        }
        self.branches = depths;
    }
}

/// Appends 1 for each ray that hit something, else 0.
#[inline(always)]
fn coverage<S: Simd>(simd: S, hits: &[HitPacket], alpha: &mut Vec<F32x8>) {
    for hits in hits {
        let missed = simd.mask(S::V8::equal_lanes(simd, &hits.primitive, PrimitiveId::NONE.0));
        alpha.push(S::V8::select(missed, simd.splat(0.0), simd.splat(1.0)).to8());
    }
}
