//! From a scene, its BVH and a camera to a picture. Knows no terminal and no window.

mod aov;
pub(crate) mod bands;
mod crop;
mod film;
mod frame;
mod renderer;
mod sampling;
mod scalar;
mod tile;
mod transfer;

pub use aov::{Aov, Aovs};
pub use crop::Crop;
pub use film::{ByteFilm, Film, Pixel, quantize};
pub use frame::render;
pub use renderer::Renderer;
pub use sampling::{Filter, Pattern};
pub use transfer::Transfer;

use crate::classic;
use std::{fmt, ops::ControlFlow, time::Duration};

/// The largest width or height of a picture, pixels, times the samples along a side of a pixel: sample
/// offsets are whole numbers that must be exact in `f32`.
pub const MAX_SIDE_SAMPLES: u32 = 1 << 23;

/// The most pixels of a picture.
pub const MAX_PIXELS: u64 = 1 << 28;

/// Which code traces the rays. Both make the same bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// SIMD packets, batched shading.
    #[default]
    Packet,
    /// The scalar reference, one ray at a time over the BVH.
    Scalar,
}

/// How to render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Pixels of the whole picture across.
    pub width: u32,
    /// Pixels of the whole picture down.
    pub height: u32,
    /// The part of the picture to render, exactly as it is in the whole; `None` for all of it. The film has the
    /// part's size.
    pub crop: Option<Crop>,
    /// Samples of a pixel: a square number, but for [`Pattern::Sobol`], which takes any.
    pub samples: u32,
    /// How they lie.
    pub pattern: Pattern,
    /// How much each counts.
    pub filter: Filter,
    /// A ray of this level returns the background; camera rays are level 0.
    pub max_depth: u32,
    /// Whether lights are tested for being hidden.
    pub shadows: bool,
    /// Which code traces the rays.
    pub mode: Mode,
    /// How many threads; `None` for as many as the machine has.
    pub threads: Option<usize>,
}

impl Default for Settings {
    /// The course's picture: 512x512, one sample, three levels, shadows.
    fn default() -> Self {
        Self {
            width: classic::IMAGE_SIZE,
            height: classic::IMAGE_SIZE,
            crop: None,
            samples: 1,
            pattern: Pattern::Grid,
            filter: Filter::Box,
            max_depth: classic::MAX_DEPTH,
            shadows: true,
            mode: Mode::Packet,
            threads: None,
        }
    }
}

/// Rays of a picture, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// Rays from the eye, one for each sample of a pixel: those too that are known to hit nothing before they are made.
    pub camera: u64,
    /// Rays between a light and a surface.
    pub shadow: u64,
    /// Mirrored rays.
    pub reflection: u64,
}

impl RayCounts {
    /// All kinds together.
    #[must_use]
    pub fn total(self) -> u64 {
        self.camera + self.shadow + self.reflection
    }
}

impl std::ops::Add for RayCounts {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            camera: self.camera + other.camera,
            shadow: self.shadow + other.shadow,
            reflection: self.reflection + other.reflection,
        }
    }
}

/// Time spent in tiles, summed over the threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileTimes {
    /// Making camera rays.
    pub ray_generation: Duration,
    /// Tracing rays of all kinds.
    pub tracing: Duration,
    /// Everything between: sorting hits, shading, making secondary rays; and the background of tiles without anything else,
    /// where it has several colours.
    pub shading: Duration,
    /// Turning colours into pixels of the film, and filling what shows one colour only.
    pub film: Duration,
}

impl std::ops::Add for TileTimes {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            ray_generation: self.ray_generation + other.ray_generation,
            tracing: self.tracing + other.tracing,
            shading: self.shading + other.shading,
            film: self.film + other.film,
        }
    }
}

/// What a frame took.
#[derive(Clone, Copy, Debug)]
pub struct FrameStats {
    /// Rays traced.
    pub rays: RayCounts,
    /// Wall-clock time of the rendering alone.
    pub elapsed: Duration,
    /// Time within tiles by what it was for, in packet mode.
    pub tile_times: TileTimes,
}

/// A finished picture and what it took.
#[derive(Debug)]
pub struct Frame {
    /// The picture.
    pub film: Film,
    /// Rays traced.
    pub rays: RayCounts,
    /// Wall-clock time of the rendering alone.
    pub elapsed: Duration,
    /// Time within tiles by what it was for, in packet mode.
    pub tile_times: TileTimes,
}

/// Where the rendering stands, as the progress callback sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Pixels finished.
    pub pixels_done: u64,
    /// Pixels to render in all.
    pub pixels_total: u64,
}

/// Called from the render threads after every tile; `Break` stops the rendering.
pub type OnProgress<'a> = &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync);

/// Why there is no picture.
#[derive(Debug, PartialEq, Eq)]
pub enum RenderError {
    /// Width, height or samples are 0 or too large; the text says which and what would do.
    Limit(String),
    /// The progress callback said `Break`.
    Cancelled,
    /// The threads could not be started.
    Threads(String),
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Limit(what) => write!(f, "{what}"),
            Self::Cancelled => write!(f, "cancelled"),
            Self::Threads(why) => write!(f, "cannot start the render threads: {why}"),
        }
    }
}

impl std::error::Error for RenderError {}

impl Settings {
    /// The pixels that are rendered: the crop, or the whole picture.
    #[must_use]
    pub fn window(&self) -> Crop {
        self.crop.unwrap_or(Crop {
            x0: 0,
            y0: 0,
            x1: self.width,
            y1: self.height,
        })
    }

    /// Checks the sizes against the limits above.
    ///
    /// # Errors
    /// [`RenderError::Limit`].
    pub fn validate(&self) -> Result<(), RenderError> {
        let limit = |what: String| Err(RenderError::Limit(what));
        let &Self {
            width,
            height,
            samples,
            ..
        } = self;
        if width == 0 || height == 0 {
            return limit(format!("a picture of {width}x{height} has no pixels"));
        }
        let window = self.window();
        if window.x0 >= window.x1 || window.y0 >= window.y1 {
            return limit(format!("the crop {window} has no pixels"));
        }
        if window.x1 > width || window.y1 > height {
            return limit(format!(
                "the crop {window} is not within the picture of {width}x{height}"
            ));
        }
        if u64::from(window.width()) * u64::from(window.height()) > MAX_PIXELS {
            return limit(format!(
                "a picture of {}x{} has more than {MAX_PIXELS} pixels",
                window.width(),
                window.height()
            ));
        }
        let n = samples.isqrt();
        if samples == 1 && width.max(height) > MAX_SIDE_SAMPLES {
            return limit(format!(
                "a picture of {width}x{height}: expected at most {MAX_SIDE_SAMPLES} pixels along a side"
            ));
        }
        if n == 0 || u64::from(width.max(height)) * u64::from(n) > u64::from(MAX_SIDE_SAMPLES) {
            return limit(format!(
                "{samples} samples for each pixel of a picture of {width}x{height}: expected 1 or more, and at most \
                 {MAX_SIDE_SAMPLES} samples along a side of the picture"
            ));
        }
        if self.pattern != Pattern::Sobol && n * n != samples {
            return limit(format!(
                "{samples} samples for each pixel do not fill a square grid, which all patterns but Sobol' have"
            ));
        }
        if self.max_depth == 0 || self.threads == Some(0) {
            return limit("the depth and the number of threads must be at least 1".into());
        }
        Ok(())
    }
}
