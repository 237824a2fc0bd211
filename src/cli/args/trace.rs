//! How rays are traced and shaded: arguments of `render` and `view`.

use super::{
    choices::Choice,
    limits::ThreadsArgs,
    values::{self, Size},
};
use crate::{
    classic,
    cli::plan::Build,
    render::{Mode, RenderError, Settings},
};
use clap::Args;

/// How rays are traced and shaded.
#[derive(Args, Debug)]
#[command(next_help_heading = "Rendering")]
pub struct TraceArgs {
    #[command(flatten)]
    pub threads: ThreadsArgs,

    /// Which code traces rays; the picture is the same
    #[arg(long, value_enum, default_value_t = Choice(Mode::Packet))]
    pub mode: Choice<Mode>,

    /// How much time building the BVH may take; the picture is the same
    #[arg(long, value_enum, value_name = "QUALITY", default_value_t = Build::Auto)]
    pub build: Build,

    /// Disable shadows
    #[arg(long)]
    pub no_shadows: bool,

    /// Maximum ray depth; 1 disables reflections and refraction
    #[arg(long, value_name = "N", value_parser = values::whole::<1000>, default_value_t = classic::MAX_DEPTH)]
    pub max_depth: u32,
}

impl TraceArgs {
    /// The settings for pictures of that size, with one sample per pixel.
    ///
    /// # Errors
    /// [`RenderError`] if the size is not allowed.
    pub fn settings(&self, size: Size) -> Result<Settings, RenderError> {
        let settings = Settings {
            width: size.width,
            height: size.height,
            max_depth: self.max_depth,
            shadows: !self.no_shadows,
            mode: self.mode.0,
            threads: self.threads.count().map(|threads| threads as usize),
            ..Settings::default()
        };
        settings.validate()?;
        Ok(settings)
    }
}
