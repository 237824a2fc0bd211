//! Rendering: a scene, its BVH and a camera become a picture. Knows neither terminal nor window.

mod adaptive;
mod aov;
#[doc(hidden)]
pub mod bands;
mod crop;
mod edges;
mod film;
mod frame;
#[cfg(feature = "png")]
mod png;
mod renderer;
mod sampling;
mod scalar;
mod sums;
mod tile;
mod transfer;

pub use crate::reference::cost::Cost;
pub use aov::{Aov, Aovs};
pub use crop::Crop;
pub use edges::{Edges, MAX_EDGE_WIDTH};
#[doc(hidden)]
pub use film::nearest_byte;
pub use film::{ByteFilm, Film, Pixel, quantize};
pub use frame::render;
#[cfg(feature = "png")]
pub use png::{SOFTWARE, write_png};
pub use renderer::Renderer;
#[doc(hidden)]
pub use sampling::CameraRays;
pub use sampling::{Filter, Pattern};
pub use transfer::Transfer;

use crate::{classic, simd::Level};
use std::{fmt, ops::ControlFlow, time::Duration};

pub use crate::scene::MAX_SIDE_SAMPLES;

/// The most pixels of a film.
pub const MAX_PIXELS: u64 = 1 << 28;

/// The largest depth of reflections and refractions.
pub const MAX_DEPTH: u32 = 1000;

/// The most threads: more than any machine has cores.
pub const MAX_THREADS: usize = 4096;

/// The code that traces and shades. All modes make the same bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// SIMD packets, batched shading.
    #[default]
    Packet,
    /// The scalar reference, one ray at a time over the BVH.
    Scalar,
}

/// The settings of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Width of the whole picture, pixels.
    pub width: u32,
    /// Height of the whole picture, pixels.
    pub height: u32,
    /// The part to render, with the same pixels as in the whole picture; `None` for all of it. It is the film's size.
    pub crop: Option<Crop>,
    /// Samples per pixel: a square number, or any number for [`Pattern::Sobol`].
    pub samples: u32,
    /// Whether pixels that look like their neighbours take fewer samples than [`Settings::samples`]; the others keep their
    /// values. Needs [`Pattern::Sobol`], whose first points are spread evenly.
    pub adaptive: bool,
    /// The positions of the samples in a pixel.
    pub pattern: Pattern,
    /// The pixel filter.
    pub filter: Filter,
    /// Maximum ray depth, at least 1: 1 disables reflections and refraction. Rays beyond it return the background.
    pub max_depth: u32,
    /// Whether to trace shadow rays.
    pub shadows: bool,
    /// The edges of triangles, drawn over the picture; `None` for none.
    pub edges: Option<Edges>,
    /// The code that traces and shades.
    pub mode: Mode,
    /// Number of threads; `None` for the current rayon pool.
    pub threads: Option<usize>,
    /// The instruction set, which changes no pixel.
    pub level: Level,
}

impl Default for Settings {
    /// Returns the settings of classic pictures: 512x512, one sample, depth 3, shadows.
    fn default() -> Self {
        Self {
            width: classic::IMAGE_SIZE,
            height: classic::IMAGE_SIZE,
            crop: None,
            samples: 1,
            adaptive: false,
            pattern: Pattern::Grid,
            filter: Filter::Box,
            max_depth: classic::MAX_DEPTH,
            shadows: true,
            edges: None,
            mode: Mode::Packet,
            threads: None,
            level: Level::current(),
        }
    }
}

/// The number of rays of a picture, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// Camera rays, one per sample, including those of tiles that are known to be empty. Adaptive tiles also trace the
    /// pixels around them.
    pub camera: u64,
    /// Shadow rays.
    pub shadow: u64,
    /// Ambient occlusion rays.
    pub ambient: u64,
    /// Reflection rays.
    pub reflection: u64,
}

impl RayCounts {
    /// Returns the sum of all kinds.
    #[must_use]
    pub fn total(self) -> u64 {
        self.camera + self.shadow + self.ambient + self.reflection
    }
}

impl std::ops::Add for RayCounts {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            camera: self.camera + other.camera,
            shadow: self.shadow + other.shadow,
            ambient: self.ambient + other.ambient,
            reflection: self.reflection + other.reflection,
        }
    }
}

/// The time spent in tiles, by stage, summed over the threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileTimes {
    /// Generating camera rays.
    pub ray_generation: Duration,
    /// Tracing rays of all kinds.
    pub tracing: Duration,
    /// Sorting hits, shading, and generating secondary rays; also gradient backgrounds of empty tiles.
    pub shading: Duration,
    /// Converting colours to pixels of the film, and filling empty tiles with a constant background.
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

/// The statistics of a frame.
#[derive(Clone, Copy, Debug)]
pub struct FrameStats {
    /// The number of rays.
    pub rays: RayCounts,
    /// Wall-clock time of rendering.
    pub elapsed: Duration,
    /// Time by stage, in packet mode.
    pub tile_times: TileTimes,
}

/// A finished picture and its statistics.
#[derive(Debug)]
pub struct Frame {
    /// The picture.
    pub film: Film,
    /// The number of rays.
    pub rays: RayCounts,
    /// Wall-clock time of rendering.
    pub elapsed: Duration,
    /// Time by stage, in packet mode.
    pub tile_times: TileTimes,
}

/// The progress of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Pixels finished.
    pub pixels_done: u64,
    /// Pixels to render.
    pub pixels_total: u64,
}

/// The progress callback, called from the render threads after every tile; `Break` cancels the frame.
pub type OnProgress<'a> = &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync);

/// The error of rendering.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RenderError {
    /// A setting is out of range; the text says which and what is expected.
    Limit(String),
    /// The picture does not fit into memory; the text says how large it is.
    Memory(String),
    /// The progress callback returned `Break`.
    Cancelled,
    /// The threads could not be started.
    Threads(String),
    /// The hierarchy was built from another scene, or from this one before it moved: see
    /// [`Bvh::follow`](crate::accel::Bvh::follow).
    OtherScene,
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Limit(what) | Self::Memory(what) => write!(f, "{what}"),
            Self::Cancelled => write!(f, "cancelled"),
            Self::OtherScene => write!(
                f,
                "the BVH was built from another scene, or before this one moved"
            ),
            Self::Threads(why) => write!(f, "cannot start the render threads: {why}"),
        }
    }
}

impl std::error::Error for RenderError {}

impl Settings {
    /// Returns the rectangle to render: the crop, or the whole picture.
    #[must_use]
    pub fn window(&self) -> Crop {
        self.crop.unwrap_or(Crop {
            x0: 0,
            y0: 0,
            x1: self.width,
            y1: self.height,
        })
    }

    /// Checks all settings.
    ///
    /// # Errors
    /// [`RenderError::Limit`] if one is out of range.
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
                "{samples} samples for each pixel: expected a square number, or the pattern sobol"
            ));
        }
        if self.adaptive && self.pattern != Pattern::Sobol {
            return limit("adaptive sampling: expected the pattern sobol".into());
        }
        if !(1..=MAX_DEPTH).contains(&self.max_depth) {
            return limit(format!("depth {}: expected 1 to {MAX_DEPTH}", self.max_depth));
        }
        if let Some(edges) = self.edges {
            edges.check()?;
        }
        match self.threads {
            Some(threads) if !(1..=MAX_THREADS).contains(&threads) => {
                limit(format!("{threads} threads: expected 1 to {MAX_THREADS}"))
            }
            _ => Ok(()),
        }
    }
}
