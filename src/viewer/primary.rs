//! Pictures that need only camera rays (preview, normals, cost), and the full picture by brute force.

use super::{
    first_hits::{BAND, FirstHits},
    request::{Look, Style},
    surface,
    timeline::Model,
};
use crate::{
    heat::heat,
    ray::{Ray, SceneHit, T_MAX},
    reference::{
        brute,
        bvh::OverScene,
        cost::{self, Stack},
        first_hit_at, medium_at,
        shade::{Intersect, Limits, PixelSample, SecondaryRays, radiance_at, shading_normal},
    },
    render::{
        ByteFilm, CameraRays, FrameStats, Mode, OnProgress, Progress, RayCounts, RenderError, Settings,
        TileTimes, Transfer, bands::Bands, nearest_byte,
    },
    scene::{Camera, EdgeLines, RayCone, Scene},
    simd::{Level, Portable, at_level},
};
use rayon::prelude::*;
use std::{
    ops::ControlFlow,
    sync::atomic::{AtomicBool, AtomicU64, Ordering},
    time::Instant,
};

/// Shared by all bands.
struct Frame<'a> {
    model: &'a Model,
    style: &'a Style,
    settings: &'a Settings,
    rays: CameraRays,
    limits: Limits,
    edges: Option<EdgeLines>,
    stop: &'a (dyn Fn() -> bool + Sync),
}

/// The memory of a thread.
struct Scratch<'a> {
    first_hits: FirstHits<'a>,
    sums: Vec<[f32; 3]>,
    todo: Stack,
}

/// Renders into `film`, which has the size of the settings.
///
/// # Errors
/// [`RenderError::Cancelled`] if `on_progress` returns `Break`. It is called after every pixel of brute force, else
/// after every band.
pub fn render(
    model: &Model,
    camera: &Camera,
    style: &Style,
    settings: &Settings,
    film: &mut ByteFilm,
    on_progress: OnProgress<'_>,
) -> Result<FrameStats, RenderError> {
    let start = Instant::now();
    let (width, height) = (film.width(), film.height());
    let pixels_total = u64::from(width) * u64::from(height);
    let pixels_done = AtomicU64::new(0);
    let cancelled = AtomicBool::new(false);
    let report = |pixels: u64| {
        let pixels_done = pixels_done.fetch_add(pixels, Ordering::Relaxed) + pixels;
        let progress = Progress {
            pixels_done,
            pixels_total,
        };
        if on_progress(progress) == ControlFlow::Break(()) {
            cancelled.store(true, Ordering::Relaxed);
        }
        cancelled.load(Ordering::Relaxed)
    };
    let stop = &|| report(0);
    let (scene, view) = (&model.scene, camera.view());
    let eye = (scene.relative(view.eye), view.target - view.eye);
    let every = &mut EveryPrimitive { scene, stop };
    let rays = CameraRays::new(scene, camera, settings);
    let frame = Frame {
        model,
        style,
        settings,
        rays,
        edges: rays.edges(settings),
        limits: Limits {
            max_depth: settings.max_depth,
            shadows: settings.shadows,
            transparent: false,
            medium: medium_at(settings.level, scene, &mut |ray| every.closest_hit(ray), eye),
        },
        stop,
    };
    if !style.brute && style.look != Look::Cost && settings.mode == Mode::Scalar {
        model.bvh.binary(&model.scene);
    }
    let secondary = Bands::new(film.pixels_mut(), width, BAND)
        .in_turn()
        .map_init(
            || Scratch::new(model, settings.level),
            |scratch, (y, band)| {
                let mut counts = RayCounts::default();
                if !cancelled.load(Ordering::Relaxed) {
                    let traced = scratch.band(&frame, y, band);
                    counts.shadow = traced.shadow;
                    counts.ambient = traced.ambient;
                    counts.reflection = traced.reflection;
                    report(band.len() as u64);
                }
                counts
            },
        )
        .reduce(RayCounts::default, |a, b| a + b);
    if cancelled.into_inner() {
        return Err(RenderError::Cancelled);
    }
    Ok(FrameStats {
        rays: RayCounts {
            camera: pixels_total * u64::from(settings.samples),
            ..secondary
        },
        elapsed: start.elapsed(),
        tile_times: TileTimes::default(),
    })
}

impl<'a> Scratch<'a> {
    fn new(model: &'a Model, level: Level) -> Self {
        Self {
            first_hits: FirstHits::new(model, level),
            sums: Vec::new(),
            todo: Stack::default(),
        }
    }

    /// Renders the rows from `y` on into `band`, averaged over all samples.
    fn band(&mut self, frame: &Frame<'_>, y: u32, band: &mut [[u8; 3]]) -> SecondaryRays {
        let (look, settings) = (frame.style.look, frame.settings);
        let mut rays = SecondaryRays::default();
        self.sums.clear();
        self.sums.resize(band.len(), [0.0; 3]);
        for sample in frame.rays.samples() {
            let finished = if look == Look::Full {
                self.add_radiance(frame, y, sample, &mut rays)
            } else {
                self.add_first_hits(frame, y, sample)
            };
            if finished.is_break() {
                return rays;
            }
        }
        let encode = |rgb: [f32; 3]| match look {
            Look::Full | Look::Preview => frame.style.transfer.encode(rgb),
            Look::Normals => rgb.map(nearest_byte),
            Look::Cost => Transfer::Linear.encode(rgb),
        };
        for (pixel, sum) in band.iter_mut().zip(&self.sums) {
            *pixel = encode(sum.map(|c| c / settings.samples as f32));
        }
        rays
    }

    /// Adds a sample of every pixel to the sums, by brute force. `Break` if the frame was stopped.
    fn add_radiance(
        &mut self,
        frame: &Frame<'_>,
        y: u32,
        sample: [u32; 2],
        rays: &mut SecondaryRays,
    ) -> ControlFlow<()> {
        let (settings, scene) = (frame.settings, &frame.model.scene);
        for (i, sum) in self.sums.iter_mut().enumerate() {
            if (frame.stop)() {
                return ControlFlow::Break(());
            }
            let mut intersect = EveryPrimitive {
                scene,
                stop: frame.stop,
            };
            let ray = frame.ray(i, y, sample);
            let sample = PixelSample {
                pixel: frame.pixel(i, y),
                number: frame.rays.index(sample),
                count: settings.samples,
                cone: frame.rays.cone(),
            };
            let from = (ray, sample);
            let (mut color, _) = radiance_at(settings.level, scene, &mut intersect, from, frame.limits, rays);
            if let Some(edges) = &frame.edges {
                let hit = first_hit_at(settings.level, scene, &mut intersect, &ray);
                let [r, g, b] = color;
                let [r, g, b, _] = edges.over([r, g, b, 1.0], edges.cover(scene, &ray, &hit));
                color = [r, g, b];
            }
            add(sum, color);
        }
        ControlFlow::Continue(())
    }

    /// The same with colours of the nearest hits.
    fn add_first_hits(&mut self, frame: &Frame<'_>, y: u32, sample: [u32; 2]) -> ControlFlow<()> {
        let Style { look, brute, .. } = *frame.style;
        let (settings, model, cone) = (frame.settings, frame.model, frame.rays.cone());
        let scene = &model.scene;
        let color = |ray: &Ray, hit: &SceneHit, cost| color((scene, look), ray, hit, cost, cone);
        let sums = self.sums.iter_mut();
        if brute && look == Look::Cost {
            // Every ray tests every primitive.
            let color = heat_color(scene.primitive_count() as u32);
            sums.for_each(|sum| add(sum, color));
        } else if brute {
            for (i, sum) in sums.enumerate() {
                if (frame.stop)() {
                    return ControlFlow::Break(());
                }
                let ray = frame.ray(i, y, sample);
                add(sum, color(&ray, &brute::closest_hit(scene, &ray), 0));
            }
        } else if look == Look::Cost {
            for (i, sum) in sums.enumerate() {
                let ray = frame.ray(i, y, sample);
                let (hit, cost) = cost::closest_hit(scene, &model.bvh, &mut self.todo, &ray);
                add(sum, color(&ray, &hit, cost.total()));
            }
        } else if settings.mode == Mode::Scalar {
            let mut intersect = OverScene::new(scene, &model.bvh, settings.level);
            for (i, sum) in sums.enumerate() {
                let ray = frame.ray(i, y, sample);
                add(sum, color(&ray, &intersect.closest_hit(&ray), 0));
            }
        } else {
            let width = settings.width as usize;
            let (size, sums) = ([width, self.sums.len() / width], &mut self.sums);
            self.first_hits
                .trace(&frame.rays, size, y, sample, &mut |i, ray, hit| {
                    add(&mut sums[i], color(ray, hit, 0));
                });
        }
        ControlFlow::Continue(())
    }
}

impl Frame<'_> {
    /// Returns the ray through a sample of pixel `i` of the band that begins at row `y`.
    fn ray(&self, i: usize, y: u32, sample: [u32; 2]) -> Ray {
        let pixel = self.pixel(i, y);
        at_level!(self.settings.level, |simd| self.rays.ray(simd, pixel, sample))
    }

    /// Returns the column and row of pixel `i` of that band.
    fn pixel(&self, i: usize, y: u32) -> [u32; 2] {
        let width = self.settings.width;
        [i as u32 % width, y + i as u32 / width]
    }
}

fn add(sum: &mut [f32; 3], color: [f32; 3]) {
    for (sum, c) in sum.iter_mut().zip(color) {
        *sum += c;
    }
}

/// The colour of a cost, in the middle of the interval that becomes its byte.
fn heat_color(tests: u32) -> [f32; 3] {
    heat(tests).map(|byte| (f32::from(byte) + 0.5) / 255.0)
}

fn color((scene, look): (&Scene, Look), ray: &Ray, hit: &SceneHit, tests: u32, cone: RayCone) -> [f32; 3] {
    match look {
        Look::Cost => heat_color(tests),
        Look::Normals if !hit.is_hit() => [0.0; 3],
        Look::Normals => (shading_normal(scene, ray, hit) * 0.5 + 0.5).to_array(),
        _ if !hit.is_hit() => scene.background_color(Portable, ray.direction),
        Look::Preview | Look::Full => surface::preview(scene, ray, hit, cone),
    }
}

/// With more primitives than this, every ray checks whether to stop. With fewer, the check would cost more than the
/// ray.
const MANY: usize = 10_000;

/// Brute force: no acceleration structure.
struct EveryPrimitive<'a> {
    scene: &'a Scene,
    stop: &'a (dyn Fn() -> bool + Sync),
}

impl EveryPrimitive<'_> {
    fn is_stopped(&self) -> bool {
        self.scene.primitive_count() > MANY && (self.stop)()
    }
}

impl Intersect for EveryPrimitive<'_> {
    fn closest_hit(&mut self, ray: &Ray) -> SceneHit {
        if self.is_stopped() {
            return SceneHit::miss(T_MAX);
        }
        brute::closest_hit(self.scene, ray)
    }

    fn opaque_hit(&mut self, ray: &Ray) -> SceneHit {
        brute::opaque_hit(self.scene, ray)
    }

    fn visible_hit(&mut self, ray: &Ray, only_opaque: bool) -> SceneHit {
        brute::visible_hit(self.scene, ray, only_opaque)
    }

    fn occluded(&mut self, ray: &Ray) -> bool {
        self.is_stopped() || brute::occluded(self.scene, ray)
    }
}
