//! Timing of whole frames.

use crate::{
    accel::Bvh,
    render::{ByteFilm, Mode, OnProgress, RayCounts, RenderError, Renderer, Settings, TileTimes},
    scene::{Camera, Scene},
};
use std::{ops::ControlFlow, time::Duration};

/// The times of frames with a number of threads, without writing files.
#[derive(Clone, Copy, Debug)]
pub struct FrameTimes {
    /// Number of threads.
    pub threads: usize,
    /// Wall-clock time of the median frame.
    pub frame: Duration,
    /// Time by stage of the median frame, summed over the threads.
    pub tiles: TileTimes,
    /// (slowest - fastest) / median.
    pub spread: f64,
    /// Rays of one frame.
    pub rays: RayCounts,
}

/// Times `repeat` frames with each number of threads, alternating, after a warm-up frame each.
///
/// # Errors
/// [`RenderError`] if a setting is out of range.
pub fn frame_times(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    settings: &Settings,
    threads: &[usize],
    repeat: usize,
) -> Result<Vec<FrameTimes>, RenderError> {
    let silent: OnProgress<'_> = &|_| ControlFlow::Continue(());
    let mut renderers: Vec<Renderer<'_>> = threads.iter().map(|_| Renderer::new(scene, bvh)).collect();
    let mut film = ByteFilm::black(settings.width, settings.height);
    let mut frames = vec![Vec::new(); threads.len()];
    for round in 0..=repeat.max(1) {
        for ((renderer, frames), &threads) in renderers.iter_mut().zip(&mut frames).zip(threads) {
            let settings = Settings {
                threads: Some(threads),
                mode: Mode::Packet,
                ..*settings
            };
            let stats = renderer.render(camera, &settings, &mut film, silent)?;
            if round > 0 {
                frames.push(stats);
            }
        }
    }
    Ok(threads
        .iter()
        .zip(frames)
        .map(|(&threads, mut frames)| {
            frames.sort_by_key(|frame| frame.elapsed);
            let median = frames[frames.len() / 2];
            let slowest = frames[frames.len() - 1].elapsed;
            let range = slowest.saturating_sub(frames[0].elapsed);
            FrameTimes {
                threads,
                frame: median.elapsed,
                tiles: median.tile_times,
                spread: range.as_secs_f64() / median.elapsed.as_secs_f64().max(1e-9),
                rays: median.rays,
            }
        })
        .collect())
}
