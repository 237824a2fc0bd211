//! Arbitrary output variables: what else is known of a pixel besides its colour.
//!
//! They are those of one ray through the pixel's centre, whatever the samples: an average of two distances or ids
//! would be neither's. Rays are traced as a picture's camera rays are; where their cost is asked for, one at a time over
//! the wide hierarchy, in every mode.

use super::{
    Filter, Mode, OnProgress, Pattern, RenderError, Renderer, Settings,
    bands::Bands,
    frame::{FrameContext, TileRect},
    renderer::Watch,
    sampling::CameraRays,
    tile::fill,
};
use crate::{
    accel::Bvh,
    ray::{Hit, HitPacket, PrimitiveId, Ray},
    reference::{
        cost::{self, Cost, Todo},
        shade::shading_normal,
    },
    scene::{Camera, Material, Scene, for_each_packet},
    shade::queue::RayQueue,
    simd::{LANES, splat},
    trace::Tracer,
};
use rayon::prelude::*;
use std::cell::RefCell;
use thread_local::ThreadLocal;

/// Pixels of a tile; a band of tiles is as many rows.
const TILE: [u32; 2] = [128, 16];

/// What the ray through a pixel's centre meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aov {
    /// Distance from the eye along the ray, scene units; infinite where nothing is hit.
    pub depth: f32,
    /// Shading normal, a unit vector on the viewer's side; 0 where nothing is hit.
    pub normal: [f32; 3],
    /// The material's own colour, linear RGB, without light: that of a silhouette, matte or mirror, c_d of
    /// Blinn-Phong; 0 where nothing is hit.
    pub albedo: [f32; 3],
    /// Which primitive; [`PrimitiveId::NONE`] where nothing is hit.
    pub primitive: PrimitiveId,
    /// What the ray costs if it is traced alone; nothing where that was not asked for.
    pub cost: Cost,
}

/// The variables of all pixels of a picture, or of its crop.
#[derive(Clone, Debug, PartialEq)]
pub struct Aovs {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Row by row, row 0 on top.
    pub pixels: Vec<Aov>,
}

impl Renderer<'_> {
    /// Finds the variables of every pixel, on the threads that [`Renderer::render`] uses. `costs`: also what rays cost,
    /// which takes several times as long.
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
        settings.validate()?;
        let (scene, bvh) = self.scene();
        let window = settings.window();
        let settings = Settings {
            samples: 1,
            pattern: Pattern::Grid,
            filter: Filter::Box,
            ..*settings
        };
        let context = FrameContext {
            scene,
            bvh,
            camera_rays: CameraRays::new(scene, camera, &settings),
            window,
            settings,
        };
        let watch = Watch::new(window, on_progress);
        let mut pixels = vec![Aov::NOTHING; window.width() as usize * window.height() as usize];
        let finders = ThreadLocal::new();
        let mut find = || {
            Bands::new(&mut pixels, window.width(), TILE[1])
                .in_turn()
                .for_each(|(y, band)| find_band(&finders, &context, y, band, costs, &watch));
        };
        match self.pool(settings.threads)? {
            Some(pool) => pool.install(find),
            None => find(),
        }
        watch.finish()?;
        Ok(Aovs {
            width: window.width(),
            height: window.height(),
            pixels,
        })
    }
}

/// A thread's memory.
struct Finder<'a> {
    tracer: Tracer<'a>,
    rays: RayQueue,
    hits: Vec<HitPacket>,
    todo: Todo,
}

impl<'a> Finder<'a> {
    fn new(bvh: &'a Bvh) -> Self {
        Self {
            tracer: Tracer::new(bvh),
            rays: RayQueue::default(),
            hits: Vec::new(),
            todo: Todo::default(),
        }
    }

    /// Finds the variables of a tile; `band` has the pixels of its rows.
    fn tile(&mut self, context: &FrameContext<'_>, rect: TileRect, band: &mut [Aov], costs: bool) {
        let one_by_one = costs || context.settings.mode == Mode::Scalar;
        fill(context, rect, [0, 0], &mut self.rays);
        self.hits.clear();
        self.hits
            .resize(self.rays.rays.packets().len(), HitPacket::miss(splat(0.0)));
        if !one_by_one {
            let rays = &self.rays.rays;
            self.tracer
                .closest_hit(rays.origins(), rays.packets(), &mut self.hits);
        }
        let eye = context.camera_rays.eye();
        let mut packets = self.rays.rays.packets().iter().zip(&self.hits);
        let todo = &mut self.todo;
        for_each_packet(rect.width, rect.height, |[x, y]| {
            let Some((rays, hits)) = packets.next() else {
                return;
            };
            for lane in 0..LANES {
                let (x, y) = (x + lane as u32 % 4, y + lane as u32 / 4);
                if x >= rect.width || y >= rect.height {
                    continue;
                }
                let ray = rays.ray(lane, eye);
                let (hit, cost) = if one_by_one {
                    let (hit, cost) = cost::closest_hit(context.scene, context.bvh, todo, &ray);
                    (hit, if costs { cost } else { Cost::default() })
                } else {
                    (hits.hit(lane), Cost::default())
                };
                let pixel = y as usize * context.window.width() as usize + (rect.x + x) as usize;
                band[pixel] = Aov::new(context.scene, &ray, &hit, cost);
            }
        });
    }
}

/// Finds the variables of the window's rows from `y` on. A thread's memory is borrowed for a tile, not while progress is
/// told: whoever is told may let the thread take the bands that are left.
fn find_band<'a>(
    finders: &ThreadLocal<RefCell<Finder<'a>>>,
    context: &FrameContext<'a>,
    y: u32,
    band: &mut [Aov],
    costs: bool,
    watch: &Watch<'_>,
) {
    let (width, height) = (context.window.width(), context.window.height());
    for x in (0..width).step_by(TILE[0] as usize) {
        if watch.is_cancelled() {
            return;
        }
        let rect = TileRect {
            x,
            y,
            width: TILE[0].min(width - x),
            height: TILE[1].min(height - y),
        };
        finders
            .get_or(|| RefCell::new(Finder::new(context.bvh)))
            .borrow_mut()
            .tile(context, rect, band, costs);
        watch.done(u64::from(rect.width) * u64::from(rect.height));
    }
}

impl Aov {
    /// Where nothing is hit.
    const NOTHING: Self = Self {
        depth: f32::INFINITY,
        normal: [0.0; 3],
        albedo: [0.0; 3],
        primitive: PrimitiveId::NONE,
        cost: Cost {
            nodes: 0,
            primitives: 0,
        },
    };

    fn new(scene: &Scene, ray: &Ray, hit: &Hit, cost: Cost) -> Self {
        if !hit.is_hit() {
            return Self {
                cost,
                ..Self::NOTHING
            };
        }
        let material = &scene.materials()[scene.material_of(hit.primitive).0 as usize];
        Self {
            depth: hit.t,
            normal: shading_normal(scene, ray, hit).to_array(),
            albedo: match *material {
                Material::Silhouette { color }
                | Material::Matte { color }
                | Material::Reflection { color, .. } => color,
                Material::BlinnPhong { diffuse, .. } => diffuse,
            },
            primitive: hit.primitive,
            cost,
        }
    }
}
