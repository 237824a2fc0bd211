//! Batched Whitted shading: each pass is one function over a queue, eight lanes at a time.
//!
//! The order of passes, for one sample of all pixels of a tile: [`queue::sort`] files hits by material (misses
//! take the background), [`surface::gather`] turns each material's hits into surface packets, [`shadow::pass`]
//! traces a run of occlusion rays for each light, and the passes of [`material`] turn light into colour and push
//! mirrored rays into the next queue. No recursion, no branch on the material within a lane.
//!
//! Packets stay what they are as long as most of their lanes have the same fate: rays that follow from
//! neighbours are neighbours, eight packets a block of pixels, and colours are added eight at a time.
//!
//! All arithmetic here has its scalar twin in [`reference::shade`](crate::reference::shade): the same
//! operations in the same order.

pub mod material;
pub mod queue;
pub mod shadow;
pub mod surface;

use crate::{
    math,
    ray::{HitPacket, PrimitiveId},
    scene::Scene,
    simd::{F32x8, LANES, Mask8, equal_lanes, is_run, mul_add, splat},
    trace::Tracer,
};
use material::{Light8, OneLight};
use queue::{HitQueue, RayQueue};
use std::time::{Duration, Instant};
use surface::SurfacePacket;

/// Secondary rays start off the surface by this share of the primitive's largest absolute coordinate: 32 half-ulps,
/// three times the rounding error of a point on it. More would move shadows and mirror images where scenes are far from
/// the origin: 128 changed four times as many pixels of one that is 10,000 away. (After Wächter and Binder, *A Fast and
/// Robust Method for Avoiding Self-Intersection*, Ray Tracing Gems ch. 6, 2019; scaled by the primitive instead of the
/// point, so that scenes of any scale and place behave alike.)
pub const SURFACE_OFFSET: f32 = 32.0 / (1 << 24) as f32;

/// Shadow rays end further off the surface by this share of the light's distance, the rounding error of a
/// plane as seen from there: 32 half-ulps.
pub const LIGHT_OFFSET: f32 = 32.0 / (1 << 24) as f32;

/// What to shade with.
#[derive(Clone, Copy, Debug)]
pub struct ShadeSettings {
    /// A ray of this level returns the background; camera rays are level 0.
    pub max_depth: u32,
    /// Whether lights are tested for being hidden.
    pub shadows: bool,
    /// Whether camera rays that hit nothing bring no colour, and [`TileColors::alpha`] is wanted.
    pub transparent: bool,
}

/// The memory of shading one tile, reused from tile to tile.
#[derive(Debug, Default)]
pub struct Shader {
    hits: Vec<HitPacket>,
    by_material: HitQueue,
    surfaces: Vec<SurfacePacket>,
    light: Vec<Light8>,
    arriving: shadow::Arriving,
    shadow: shadow::Scratch,
    next: RayQueue,
    /// Occlusion rays traced so far.
    pub shadow_rays: u64,
    /// Mirrored rays traced so far.
    pub reflection_rays: u64,
    /// Time spent in the tracer so far.
    pub tracing: Duration,
}

/// The colours of one sample of each pixel of a tile, linear RGB, in the order of the camera's packets: pixel `i`
/// is lane `i % 8` of packet `i / 8`.
#[derive(Debug, Default)]
pub struct TileColors {
    /// One column a channel, for each camera packet.
    pub packets: Vec<[F32x8; 3]>,
    /// 1 for camera rays that hit something, else 0; empty where nobody asked for it.
    pub alpha: Vec<F32x8>,
}

impl TileColors {
    /// Makes room for `packets` camera packets, whose colours may be anything, and forgets `alpha`.
    pub fn resize(&mut self, packets: usize) {
        self.packets.resize(packets, [F32x8::ZERO; 3]);
        self.alpha.clear();
    }

    /// Adds the colours of `other`, pixel by pixel.
    pub fn add_all(&mut self, other: &Self) {
        for (sums, colors) in self.packets.iter_mut().zip(&other.packets) {
            for (sum, &color) in sums.iter_mut().zip(colors) {
                *sum += color;
            }
        }
        for (sum, &alpha8) in self.alpha.iter_mut().zip(&other.alpha) {
            *sum += alpha8;
        }
    }

    /// The first colours of camera packet `p`: black but for the lanes in `bits`.
    #[inline(always)]
    fn put(&mut self, p: usize, bits: u32, color: [F32x8; 3]) {
        let seen = Mask8::from_bits(bits);
        self.packets[p] = color.map(|color8| seen.select(color8, F32x8::ZERO));
    }

    /// Adds weight x colour to the pixels of the lanes in `bits`.
    #[inline(always)]
    fn add(&mut self, bits: u32, pixel: &[u32; LANES], weight: F32x8, color: [F32x8; 3]) {
        let first = pixel[0];
        // What comes of a camera packet most often still has its lanes; then nothing moves between lanes.
        if first.is_multiple_of(LANES as u32) && is_run(pixel, first) {
            let added = Mask8::from_bits(bits);
            for (sum, color8) in self.packets[first as usize / LANES].iter_mut().zip(color) {
                // Other lanes add 0. (A choice between sums became a masked store: shading of matte.scn took 4 %
                // longer.)
                *sum = mul_add(weight, added.select(color8, F32x8::ZERO), *sum);
            }
        } else {
            self.scatter(bits, pixel, weight, color);
        }
    }

    #[inline(never)]
    fn scatter(&mut self, bits: u32, pixel: &[u32; LANES], weight: F32x8, color: [F32x8; 3]) {
        for lane in (0..LANES).filter(|lane| bits >> lane & 1 == 1) {
            let (packet, own_lane) = (pixel[lane] as usize / LANES, pixel[lane] as usize % LANES);
            for (sums, color8) in self.packets[packet].iter_mut().zip(&color) {
                let sum = &mut sums.as_mut_array()[own_lane];
                *sum = math::mul_add(weight.as_array()[lane], color8.as_array()[lane], *sum);
            }
        }
    }
}

impl Shader {
    /// Makes room for tiles of `pixels` pixels of `scene`, here and in the queue that camera rays come in.
    pub fn reserve(&mut self, scene: &Scene, pixels: usize, rays: &mut RayQueue) {
        let packets = queue::most_packets(pixels, scene.materials().len());
        rays.reserve(packets);
        self.next.reserve(packets);
        self.hits.resize(packets, HitPacket::miss(F32x8::ZERO));
        self.surfaces.reserve(packets);
        self.light.reserve(packets);
        self.arriving.reserve(packets);
        self.shadow.reserve(packets);
        self.by_material.reserve(scene.materials().len(), pixels);
    }

    /// Counts of rays and time start at 0 again.
    pub fn reset_counts(&mut self) {
        (self.shadow_rays, self.reflection_rays, self.tracing) = (0, 0, Duration::ZERO);
    }

    /// Traces and shades `rays`, which are camera rays, to at least one level, and what they lead to, and puts their
    /// colours into `colors`. Leaves `rays` empty. (To make colours black first, and to keep pixels and weights of
    /// camera rays, took 10 % of a frame of the course's blinn_phong.scn.)
    pub fn shade(
        &mut self,
        scene: &Scene,
        tracer: &mut Tracer<'_>,
        settings: ShadeSettings,
        rays: &mut RayQueue,
        colors: &mut TileColors,
    ) {
        debug_assert!(
            rays.are_camera_rays() && settings.max_depth > 0,
            "else nothing puts the first colours"
        );
        colors.resize(rays.rays.packets().len());
        for level in 1..=settings.max_depth {
            let packets = rays.rays.packets().len();
            if self.hits.len() < packets {
                self.hits.resize(packets, HitPacket::miss(F32x8::ZERO));
            }
            let hits = &mut self.hits[..packets];
            let start = Instant::now();
            tracer.closest_hit(rays.rays.origins(), rays.rays.packets(), hits);
            self.tracing += start.elapsed();
            let see_through = settings.transparent && level == 1;
            if see_through {
                colors.alpha.extend(hits.iter().map(|hits| {
                    let missed = Mask8::from_bits(equal_lanes(&hits.primitive, PrimitiveId::NONE.0));
                    missed.select(splat(0.0), splat(1.0))
                }));
            }
            queue::sort(scene, rays, hits, see_through, &mut self.by_material, colors);

            surface::gather(scene, rays, hits, &self.by_material, &mut self.surfaces);
            if self.surfaces.is_empty() {
                break;
            }
            self.add_lights(scene, tracer, settings.shadows);

            self.next.restart(None);
            for (material, range) in self.by_material.ranges() {
                let material = &scene.materials()[material.0 as usize];
                let (surfaces, light) = (&self.surfaces[range.clone()], &self.light[range]);
                material::color(scene, material, surfaces, light, colors, &mut self.next);
            }
            if level == settings.max_depth {
                material::end_of_depth(scene, &self.next, colors);
                self.next.restart(None);
            }
            std::mem::swap(rays, &mut self.next);
            self.reflection_rays += rays.active_rays();
            if rays.rays.packets().is_empty() {
                break;
            }
        }
        rays.restart(None);
    }

    fn add_lights(&mut self, scene: &Scene, tracer: &mut Tracer<'_>, shadows: bool) {
        let lights = scene.lights();
        if lights.intensity.is_empty() {
            self.light.clear();
        }
        // What is left of the last time is written over by the first light.
        self.light.resize(self.surfaces.len(), Light8::NONE);
        let lit = self.by_material.lit_surfaces(scene, &self.surfaces);
        for light_i in 0..lights.intensity.len() {
            let (position, power) = (lights.position(light_i), lights.power(light_i));
            let tracer = shadows.then_some(&mut *tracer);
            let (rays, time) = shadow::pass(position, tracer, lit, &mut self.arriving, &mut self.shadow);
            self.shadow_rays += rays;
            self.tracing += time;
            for (material, range) in self.by_material.ranges().take_while(|(_, r)| r.end <= lit.len()) {
                let one = OneLight {
                    power,
                    arriving: &self.arriving.share[range.clone()],
                    toward: &self.arriving.toward[range.clone()],
                };
                let material = &scene.materials()[material.0 as usize];
                let surfaces = &self.surfaces[range.clone()];
                material::add_light(material, one, surfaces, &mut self.light[range], light_i == 0);
            }
        }
    }
}
