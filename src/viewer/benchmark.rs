//! The benchmark: the speed of frames while the camera orbits.

use serde::Serialize;
use std::time::{Duration, Instant};

use super::mailbox::Picture;

/// The version of the report's fields.
pub const SCHEMA: u32 = 1;
/// The time before frames count: threads start, and the budget learns.
const WARM_UP: Duration = Duration::from_millis(500);

/// The figures of an orbit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Frames shown in a second.
    pub fps: f64,
    /// The median time between two frames, milliseconds.
    pub frame_ms_p50: f64,
    /// The time that 99 of 100 frames stay within, milliseconds.
    pub frame_ms_p99: f64,
    /// The share of the frames in which every pixel of the window was traced.
    pub full_quality_share: f64,
    /// Millions of rays per second while tracing and shading.
    pub mrays_per_s: f64,
}

/// Collects frames as they are shown.
#[derive(Clone, Debug)]
pub struct Benchmark {
    length: Duration,
    start: Instant,
    last: Option<Instant>,
    frame_ms: Vec<f64>,
    full: usize,
    rays: u64,
    tracing: Duration,
}

impl Benchmark {
    /// Starts an orbit of this length at `now`.
    #[must_use]
    pub fn new(length: Duration, now: Instant) -> Self {
        Self {
            length,
            start: now,
            last: None,
            frame_ms: Vec::new(),
            full: 0,
            rays: 0,
            tracing: Duration::ZERO,
        }
    }

    /// Takes in a frame that is on the screen.
    pub fn shown(&mut self, picture: &Picture, now: Instant) {
        if now < self.start + WARM_UP {
            return;
        }
        if let Some(last) = self.last.replace(now) {
            self.frame_ms.push((now - last).as_secs_f64() * 1e3);
            self.full += usize::from(picture.full);
            self.rays += picture.rays;
            self.tracing += picture.elapsed;
        }
    }

    /// Whether its time is over and it has figures.
    #[must_use]
    pub fn is_over(&self, now: Instant) -> bool {
        now >= self.start + WARM_UP + self.length && !self.frame_ms.is_empty()
    }

    /// Returns the figures so far, if there are any.
    #[must_use]
    pub fn report(&self) -> Option<Report> {
        if self.frame_ms.is_empty() {
            return None;
        }
        let mut sorted = self.frame_ms.clone();
        sorted.sort_by(f64::total_cmp);
        let quantile = |share: f64| sorted[((sorted.len() - 1) as f64 * share).round() as usize];
        let frames = sorted.len() as f64;
        Some(Report {
            schema: SCHEMA,
            fps: frames / (sorted.iter().sum::<f64>() / 1e3).max(1e-9),
            frame_ms_p50: quantile(0.5),
            frame_ms_p99: quantile(0.99),
            full_quality_share: self.full as f64 / frames,
            mrays_per_s: self.rays as f64 / 1e6 / self.tracing.as_secs_f64().max(1e-9),
        })
    }
}

#[cfg(test)]
mod tests;
