//! The frame loop: tiles to threads, each with its own scratch.

use super::{
    Film, Frame, Mode, OnProgress, Progress, RayCounts, RenderError, Settings, TileTimes, scalar,
    tile::TileScratch,
};
use crate::{
    accel::Bvh,
    scene::{Camera, PixelRays, Scene},
};
use rayon::prelude::*;
use std::{
    ops::ControlFlow,
    sync::atomic::{AtomicBool, AtomicU64, Ordering},
    time::Instant,
};

/// Pixels along a side of a tile.
pub(super) const TILE: u32 = 32;

/// A tile's place in the picture, pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct TileRect {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

/// What all tiles of a frame share.
#[derive(Clone, Copy)]
pub(super) struct FrameContext<'a> {
    pub scene: &'a Scene,
    pub bvh: &'a Bvh,
    pub pixel_rays: PixelRays,
    pub settings: Settings,
}

/// Renders `scene` as `camera` sees it. `bvh` must have been built from `scene`.
///
/// # Errors
/// [`RenderError`]: a size out of its limits, or cancelled by `on_progress`.
pub fn render(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    settings: &Settings,
    on_progress: OnProgress<'_>,
) -> Result<Frame, RenderError> {
    settings.validate()?;
    let run = || render_on_pool(scene, bvh, camera, settings, on_progress);
    match settings.threads {
        None => run(),
        Some(threads) if threads == rayon::current_num_threads() => run(),
        Some(threads) => rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| RenderError::Threads(error.to_string()))?
            .install(run),
    }
}

fn render_on_pool(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    settings: &Settings,
    on_progress: OnProgress<'_>,
) -> Result<Frame, RenderError> {
    let start = Instant::now();
    let &Settings { width, height, .. } = settings;
    let pixel_rays = camera.pixel_rays(width, height, settings.samples_per_axis);
    let context = FrameContext {
        scene,
        bvh,
        pixel_rays,
        settings: *settings,
    };
    if settings.mode == Mode::Scalar {
        bvh.binary(scene);
    }

    let mut film = Film::new(width, height);
    let cancelled = AtomicBool::new(false);
    let pixels_done = AtomicU64::new(0);
    let pixels_total = u64::from(width) * u64::from(height);
    // A band of tile rows is one piece of the film; its tiles are rendered left to right by one thread.
    let (rays, tile_times) = film
        .pixels_mut()
        .par_chunks_mut((width * TILE) as usize)
        .enumerate()
        .map_init(
            || TileScratch::new(bvh),
            |scratch, (band_i, band)| {
                let mut counts = (RayCounts::default(), TileTimes::default());
                let y = band_i as u32 * TILE;
                for x in (0..width).step_by(TILE as usize) {
                    if cancelled.load(Ordering::Relaxed) {
                        break;
                    }
                    let rect = TileRect {
                        x,
                        y,
                        width: TILE.min(width - x),
                        height: TILE.min(height - y),
                    };
                    let tile_counts = match settings.mode {
                        Mode::Packet => scratch.render(&context, rect, band),
                        Mode::Scalar => (scalar::render_tile(&context, rect, band), TileTimes::default()),
                    };
                    counts = (counts.0 + tile_counts.0, counts.1 + tile_counts.1);
                    let pixels = u64::from(rect.width) * u64::from(rect.height);
                    let pixels_done = pixels_done.fetch_add(pixels, Ordering::Relaxed) + pixels;
                    if on_progress(Progress {
                        pixels_done,
                        pixels_total,
                    }) == ControlFlow::Break(())
                    {
                        cancelled.store(true, Ordering::Relaxed);
                    }
                }
                counts
            },
        )
        .reduce(<(RayCounts, TileTimes)>::default, |a, b| (a.0 + b.0, a.1 + b.1));
    if cancelled.into_inner() {
        return Err(RenderError::Cancelled);
    }
    Ok(Frame {
        film,
        rays,
        elapsed: start.elapsed(),
        tile_times,
    })
}
