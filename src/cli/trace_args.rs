//! How rays are traced and shaded: arguments of `render` and `view`.

use super::value::Size;
use crate::{
    accel::BuildQuality,
    classic,
    render::{Mode, RenderError, Settings},
};
use clap::{Args, ValueEnum};

/// How rays are traced and shaded.
#[derive(Args, Debug)]
pub struct TraceArgs {
    /// How many threads render [default: as many as the machine has]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096), help_heading = "Rendering")]
    pub threads: Option<u32>,

    /// Which code traces the rays; both make the same picture
    #[arg(long, value_enum, default_value_t = ModeArg::Packet, help_heading = "Rendering")]
    pub mode: ModeArg,

    /// How much time building the BVH may take; the picture is the same
    #[arg(long, value_enum, value_name = "QUALITY", default_value_t = BuildArg::Auto, help_heading = "Rendering")]
    pub build: BuildArg,

    /// Let light through everything
    #[arg(long, help_heading = "Rendering")]
    pub no_shadows: bool,

    /// A ray of this level returns the background, so 1 traces camera rays only
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), default_value_t = classic::MAX_DEPTH, help_heading = "Rendering")]
    pub max_depth: u32,
}

impl TraceArgs {
    /// The settings for pictures of that size, of one sample a pixel.
    pub fn settings(&self, size: Size) -> Result<Settings, RenderError> {
        let settings = Settings {
            width: size.width,
            height: size.height,
            max_depth: self.max_depth,
            shadows: !self.no_shadows,
            mode: match self.mode {
                ModeArg::Packet => Mode::Packet,
                ModeArg::Scalar => Mode::Scalar,
            },
            threads: self.threads.map(|threads| threads as usize),
            ..Settings::default()
        };
        settings.validate()?;
        Ok(settings)
    }
}

/// See [`Mode`](crate::render::Mode).
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ModeArg {
    /// SIMD packets, batched shading
    Packet,
    /// One ray at a time
    Scalar,
}

/// See [`BuildQuality`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BuildArg {
    /// Fast where few rays are to come for many primitives, else best
    Auto,
    /// The BVH that is built soonest
    Fast,
    /// The BVH that is traced fastest
    Best,
    /// A BVH divided as PLOC does it, to compare with best: 300 bytes a primitive while it is built, not 100, which
    /// --max-memory does not count
    Ploc,
}

impl BuildArg {
    /// What is built over so many primitives for so many rays.
    pub fn quality(self, rays: f64, primitives: usize) -> BuildQuality {
        match self {
            Self::Auto => BuildQuality::for_rays(rays, primitives),
            Self::Fast => BuildQuality::Fast,
            Self::Best => BuildQuality::Best,
            Self::Ploc => BuildQuality::Ploc,
        }
    }
}
