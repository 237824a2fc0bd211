//! The renderer of successive frames: it keeps the threads and their scratch memory.

use super::{
    Crop, Film, FrameStats, Mode, OnProgress, Pixel, Progress, RayCounts, RenderError, Settings, TileTimes,
    bands::Bands,
    frame::{FrameContext, TileRect},
    sampling::CameraRays,
    scalar,
    tile::TileScratch,
};
use crate::{
    accel::Bvh,
    ray::Ray,
    reference::medium_at,
    scene::{Camera, MaterialId, Scene},
};
use rayon::{ThreadPool, ThreadPoolBuilder, prelude::*};
use std::{
    cell::RefCell,
    ops::ControlFlow,
    sync::atomic::{AtomicBool, AtomicU64, Ordering},
    time::Instant,
};
use thread_local::ThreadLocal;

/// Width and height of a tile, pixels. A thread takes a band of tiles, whole rows of the film, so low tiles balance the
/// load.
pub(super) const TILE: [u32; 2] = [128, 16];

/// Renders frames of one scene and keeps its threads and their queues.
///
/// Frames allocate nothing once each thread has rendered a tile, except that the queues may grow with many materials or
/// levels, and that rayon allocates about once in sixty frames.
///
/// ```
/// # use octray_engine as octray;
/// use octray::{accel::Bvh, render::{Film, Renderer, Settings}, scene::{Camera, SceneBuilder}};
/// use std::ops::ControlFlow;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let scene = SceneBuilder::new().finish();
/// let bvh = Bvh::build(&scene);
/// let settings = Settings { width: 64, height: 64, ..Settings::default() };
/// let mut renderer = Renderer::new(&scene, &bvh);
/// let mut film = Film::new(64, 64);
/// for view in 1..=6 {
///     let camera = Camera::classic_view(view).ok_or("there are six viewpoints")?;
///     let stats = renderer.render(&camera, &settings, &mut film, &|_| ControlFlow::Continue(()))?;
///     assert_eq!(stats.rays.camera, 64 * 64);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Renderer<'a> {
    scene: &'a Scene,
    bvh: &'a Bvh,
    /// Threads, if the last frame requested another number than the current pool has.
    pool: Option<ThreadPool>,
    /// Borrowed for one tile at a time, because the progress callback may render on the same thread.
    scratch: ThreadLocal<RefCell<TileScratch<'a>>>,
}

impl<'a> Renderer<'a> {
    /// Makes a renderer of `scene`; `bvh` must have been built from it. The first frame starts the threads.
    #[must_use]
    pub fn new(scene: &'a Scene, bvh: &'a Bvh) -> Self {
        Self {
            scene,
            bvh,
            pool: None,
            scratch: ThreadLocal::new(),
        }
    }

    /// Renders a frame into `film`, which is resized to the picture or its crop; every pixel is written.
    ///
    /// Runs on the current rayon pool, or on its own pool if `settings` request another number of threads. After
    /// [`RenderError::Cancelled`] the film has the finished pixels, and the others are unchanged.
    ///
    /// # Errors
    /// [`RenderError`] if a setting is out of range, `bvh` was built from another scene, memory or threads are lacking, or
    /// `on_progress` returns `Break`.
    pub fn render<P: Pixel>(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        film: &mut Film<P>,
        on_progress: OnProgress<'_>,
    ) -> Result<FrameStats, RenderError> {
        self.check(settings)?;
        let start = Instant::now();
        let window = settings.window();
        film.try_resize(window.width(), window.height())
            .map_err(|_| no_memory(window))?;
        let rendered = self.on_threads(settings.threads, |this| {
            this.bands(camera, settings, film, on_progress)
        })?;
        let (rays, tile_times) = rendered?;
        Ok(FrameStats {
            rays,
            elapsed: start.elapsed(),
            tile_times,
        })
    }

    /// Checks the settings, and that scene and hierarchy belong together.
    pub(super) fn check(&self, settings: &Settings) -> Result<(), RenderError> {
        if !self.bvh.is_of(self.scene) {
            return Err(RenderError::OtherScene);
        }
        settings.validate()
    }

    pub(super) fn scene(&self) -> (&'a Scene, &'a Bvh) {
        (self.scene, self.bvh)
    }

    /// Does `work` on a pool of `threads` threads, kept for the next frame, or on the current pool.
    pub(super) fn on_threads<T: Send>(
        &mut self,
        threads: Option<usize>,
        work: impl FnOnce(&Self) -> T + Send,
    ) -> Result<T, RenderError> {
        self.pool = self.pool_for(threads)?;
        Ok(match &self.pool {
            Some(pool) => pool.install(|| work(self)),
            None => work(self),
        })
    }

    /// Returns the last frame's pool if it has `threads` threads, else a new one; `None` for the current pool.
    fn pool_for(&mut self, threads: Option<usize>) -> Result<Option<ThreadPool>, RenderError> {
        let Some(threads) = threads else {
            return Ok(None);
        };
        match self.pool.take() {
            Some(pool) if pool.current_num_threads() == threads => Ok(Some(pool)),
            _ if rayon::current_num_threads() == threads => Ok(None),
            _ => ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .map(Some)
                .map_err(|error| RenderError::Threads(error.to_string())),
        }
    }

    /// Returns the tinted glass that the eye of a camera is in.
    fn medium_of(&self, camera: &Camera, settings: &Settings) -> Option<MaterialId> {
        if !self.scene.has_glass() {
            return None;
        }
        let view = camera.view();
        let eye = self.scene.relative(view.eye);
        let mut scratch = self.scratch().borrow_mut();
        let mut closest_hit = |ray: &Ray| scratch.closest_hit(settings.level, ray);
        medium_at(
            settings.level,
            self.scene,
            &mut closest_hit,
            (eye, view.target - view.eye),
        )
    }

    /// The scratch memory of this thread.
    fn scratch(&self) -> &RefCell<TileScratch<'a>> {
        self.scratch
            .get_or(|| RefCell::new(TileScratch::new(self.scene, self.bvh, TILE)))
    }

    fn bands<P: Pixel>(
        &self,
        camera: &Camera,
        settings: &Settings,
        film: &mut Film<P>,
        on_progress: OnProgress<'_>,
    ) -> Result<(RayCounts, TileTimes), RenderError> {
        let window = settings.window();
        let camera_rays = CameraRays::new(self.scene, camera, settings);
        let context = FrameContext {
            scene: self.scene,
            bvh: self.bvh,
            camera_rays,
            edges: camera_rays.edges(settings),
            medium: self.medium_of(camera, settings),
            window,
            settings: *settings,
        };
        if settings.mode == Mode::Scalar {
            self.bvh.binary(self.scene);
        }
        let watch = Watch::new(window, on_progress);
        let counts = Bands::new(film.pixels_mut(), window.width(), TILE[1])
            .in_turn()
            .map(|(y, band)| self.band(&context, y, band, &watch))
            .reduce(<_>::default, |a, b| (a.0 + b.0, a.1 + b.1));
        watch.finish()?;
        Ok(counts)
    }

    /// Renders one band, the film's rows from `y` on, tile by tile.
    fn band<P: Pixel>(
        &self,
        context: &FrameContext<'_>,
        y: u32,
        band: &mut [P],
        watch: &Watch<'_>,
    ) -> (RayCounts, TileTimes) {
        let mut counts = (RayCounts::default(), TileTimes::default());
        watch.tiles(context.window, y, |rect| {
            let tile_counts = match context.settings.mode {
                Mode::Packet => self.scratch().borrow_mut().render(context, rect, band),
                Mode::Scalar => (scalar::render_tile(context, rect, band), TileTimes::default()),
            };
            counts = (counts.0 + tile_counts.0, counts.1 + tile_counts.1);
        });
        counts
    }
}

/// The error about a picture that does not fit into memory.
pub(super) fn no_memory(window: Crop) -> RenderError {
    RenderError::Memory(format!(
        "a picture of {}x{} does not fit into memory",
        window.width(),
        window.height()
    ))
}

/// The progress and the cancellation of a frame.
pub(super) struct Watch<'a> {
    on_progress: OnProgress<'a>,
    cancelled: AtomicBool,
    pixels_done: AtomicU64,
    pixels_total: u64,
}

impl<'a> Watch<'a> {
    pub fn new(window: Crop, on_progress: OnProgress<'a>) -> Self {
        Self {
            on_progress,
            cancelled: AtomicBool::new(false),
            pixels_done: AtomicU64::new(0),
            pixels_total: u64::from(window.width()) * u64::from(window.height()),
        }
    }

    /// Calls `render` with the tiles of a band, the window's rows from `y` on, until the frame is cancelled.
    pub fn tiles(&self, window: Crop, y: u32, mut render: impl FnMut(TileRect)) {
        let (width, height) = (window.width(), window.height());
        for x in (0..width).step_by(TILE[0] as usize) {
            if self.cancelled.load(Ordering::Relaxed) {
                return;
            }
            let rect = TileRect {
                x,
                y,
                width: TILE[0].min(width - x),
                height: TILE[1].min(height - y),
            };
            render(rect);
            self.done(u64::from(rect.width) * u64::from(rect.height));
        }
    }

    /// # Errors
    /// [`RenderError::Cancelled`].
    pub fn finish(self) -> Result<(), RenderError> {
        if self.cancelled.into_inner() {
            return Err(RenderError::Cancelled);
        }
        Ok(())
    }

    /// Reports finished pixels.
    fn done(&self, pixels: u64) {
        let progress = Progress {
            pixels_done: self.pixels_done.fetch_add(pixels, Ordering::Relaxed) + pixels,
            pixels_total: self.pixels_total,
        };
        if (self.on_progress)(progress) == ControlFlow::Break(()) {
            self.cancelled.store(true, Ordering::Relaxed);
        }
    }
}
