//! Arbitrary output variables (AOVs): depth, normal, albedo, primitive id and traversal cost of each pixel.
//!
//! They belong to one ray through the centres of the pixel and the lens, because averages of distances or ids would be
//! meaningless. If costs are requested, rays are traced one at a time over the wide BVH in every mode.

use super::{
    Filter, Mode, OnProgress, Pattern, RenderError, Renderer, Settings,
    bands::Bands,
    frame::{FrameContext, TileRect},
    renderer::{TILE, Watch, no_memory},
    sampling::CameraRays,
    tile::generate_rays,
};
use crate::{
    lanes::{F32x8, LANES},
    ray::{HitPacket, InstanceId, PrimitiveId, Ray, SceneHit},
    reference::{
        cost::{self, Cost, Stack},
        shade::{albedo, shading_normal},
    },
    scene::{Camera, Scene, for_each_packet},
    shade::queue::RayQueue,
    trace::Tracer,
};
use rayon::prelude::*;
use std::cell::RefCell;
use thread_local::ThreadLocal;

/// The output variables of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aov {
    /// Distance along the ray from the eye, or from its plane if rays are parallel, scene units; infinite for a miss.
    pub depth: f32,
    /// Unit shading normal on the viewer's side, in world space; 0 for a miss.
    pub normal: [f32; 3],
    /// The unlit colour of the surface, linear RGB (c_d of Blinn-Phong), with the colours of vertices and spheres; 0 for
    /// a miss.
    pub albedo: [f32; 3],
    /// The primitive; [`PrimitiveId::NONE`] for a miss.
    pub primitive: PrimitiveId,
    /// The instance that was hit; [`InstanceId::NONE`] outside of any.
    pub instance: InstanceId,
    /// The traversal cost of the ray; 0 unless requested.
    pub cost: Cost,
}

/// The output variables of all pixels of a picture or its crop.
#[derive(Clone, Debug, PartialEq)]
pub struct Aovs {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Whether the scene has instances.
    pub have_instances: bool,
    /// Row by row, the top row first.
    pub pixels: Vec<Aov>,
}

impl Renderer<'_> {
    /// Computes the output variables of every pixel, on the threads of [`Renderer::render`]. With `costs` it takes
    /// several times as long.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn aovs(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        costs: bool,
        on_progress: OnProgress<'_>,
    ) -> Result<Aovs, RenderError> {
        self.check(settings)?;
        let (scene, bvh) = self.scene();
        let window = settings.window();
        let settings = Settings {
            samples: 1,
            adaptive: false,
            pattern: Pattern::Grid,
            filter: Filter::Box,
            ..*settings
        };
        let context = FrameContext {
            medium: None,
            edges: None,
            scene,
            bvh,
            camera_rays: CameraRays::new(scene, &camera.without_lens(), &settings),
            window,
            settings,
        };
        let watch = Watch::new(window, on_progress);
        let count = window.width() as usize * window.height() as usize;
        let mut pixels = Vec::new();
        pixels.try_reserve_exact(count).map_err(|_| no_memory(window))?;
        pixels.resize(count, Aov::MISS);
        let scratch = ThreadLocal::new();
        self.on_threads(settings.threads, |_| {
            Bands::new(&mut pixels, window.width(), TILE[1])
                .in_turn()
                .for_each(|(y, band)| render_band(&scratch, &context, y, band, costs, &watch));
        })?;
        watch.finish()?;
        Ok(Aovs {
            width: window.width(),
            height: window.height(),
            have_instances: !scene.instances().is_empty(),
            pixels,
        })
    }
}

/// The scratch memory of a thread.
struct AovScratch<'a> {
    tracer: Tracer<'a>,
    rays: RayQueue,
    hits: Vec<HitPacket>,
    stack: Stack,
}

impl<'a> AovScratch<'a> {
    fn new(context: &FrameContext<'a>) -> Self {
        let tracer = Tracer::new(context.bvh).at_level(context.settings.level);
        Self {
            tracer: tracer.of_scene(context.scene),
            rays: RayQueue::default(),
            hits: Vec::new(),
            stack: Stack::default(),
        }
    }

    /// Computes the variables of a tile; `band` has the pixels of its rows.
    fn render_tile(&mut self, context: &FrameContext<'_>, rect: TileRect, band: &mut [Aov], costs: bool) {
        let single_rays = costs || context.settings.mode == Mode::Scalar;
        generate_rays(context, rect, [0, 0], &mut self.rays);
        self.hits.clear();
        self.hits
            .resize(self.rays.rays.packets().len(), HitPacket::miss(F32x8::ZERO));
        if !single_rays {
            let rays = &self.rays.rays;
            self.tracer
                .closest_hit(rays.origins(), rays.packets(), &mut self.hits);
        }
        let mut packets = 0..self.hits.len();
        let stack = &mut self.stack;
        for_each_packet(rect.width, rect.height, |[x, y]| {
            let Some(packet) = packets.next() else {
                return;
            };
            for lane in 0..LANES {
                let (x, y) = (x + lane as u32 % 4, y + lane as u32 / 4);
                if x >= rect.width || y >= rect.height {
                    continue;
                }
                let ray = self.rays.rays.ray(packet, lane);
                let (mut hit, cost) = if single_rays {
                    let (hit, cost) = cost::closest_hit(context.scene, context.bvh, stack, &ray);
                    (hit, if costs { cost } else { Cost::default() })
                } else {
                    (self.tracer.scene_hit(&self.hits, packet, lane), Cost::default())
                };
                if context.scene.shows_back(&ray, &hit) {
                    hit = self.tracer.visible_hit(&ray);
                }
                let pixel = y as usize * context.window.width() as usize + (rect.x + x) as usize;
                let width = context.camera_rays.cone().width(hit.t);
                band[pixel] = Aov::new(context.scene, &ray, &hit, cost, width);
            }
        });
    }
}

/// Computes the variables of the window's rows from `y` on. The scratch memory is not borrowed while progress is
/// reported, because the callback may render on this thread.
fn render_band<'a>(
    scratch: &ThreadLocal<RefCell<AovScratch<'a>>>,
    context: &FrameContext<'a>,
    y: u32,
    band: &mut [Aov],
    costs: bool,
    watch: &Watch<'_>,
) {
    watch.tiles(context.window, y, |rect| {
        scratch
            .get_or(|| RefCell::new(AovScratch::new(context)))
            .borrow_mut()
            .render_tile(context, rect, band, costs);
    });
}

impl Aov {
    const MISS: Self = Self {
        depth: f32::INFINITY,
        normal: [0.0; 3],
        albedo: [0.0; 3],
        primitive: PrimitiveId::NONE,
        instance: InstanceId::NONE,
        cost: Cost {
            nodes: 0,
            primitives: 0,
        },
    };

    fn new(scene: &Scene, ray: &Ray, hit: &SceneHit, cost: Cost, width: f32) -> Self {
        if !hit.is_hit() {
            return Self { cost, ..Self::MISS };
        }
        Self {
            depth: hit.t,
            normal: shading_normal(scene, ray, hit).to_array(),
            albedo: albedo(scene, ray, hit, width),
            primitive: hit.primitive,
            instance: hit.instance,
            cost,
        }
    }
}
