//! What the pixels of a picture hold, and where its samples lie.

use super::values;
use crate::{
    cli::{CliError, plan::PictureOptions, write::AovKind},
    render::{Crop, Filter, Pattern, Settings, Transfer},
};
use clap::{Args, ValueEnum};

/// What the pixels hold.
#[derive(Args, Debug)]
#[command(next_help_heading = "Picture")]
pub struct PictureArgs {
    /// Render only columns x0 to x1 and rows y0 to y1, x1 and y1 not included, with the same pixels as in the whole picture;
    /// row 0 is at the top
    #[arg(long, value_name = "x0,y0,x1,y1", value_parser = values::crop)]
    pub crop: Option<Crop>,

    /// Also write AOVs of the ray through each pixel's centre: to files named after the picture (a.png: a.depth.png), or
    /// as layers of an EXR picture
    #[arg(id = "aov", long, value_name = "WHAT", value_enum, value_delimiter = ',')]
    pub aovs: Vec<AovKind>,

    /// Encode bytes with the sRGB curve, as screens expect
    #[arg(long, conflicts_with = "linear")]
    pub srgb: bool,

    /// Write linear values, without gamma (the default, except with --style studio or clay)
    #[arg(long)]
    pub linear: bool,

    /// What is behind the scene
    #[arg(long, value_enum, default_value_t = BackgroundArg::Scene)]
    pub background: BackgroundArg,
}

/// Samples of the soft styles: grain is hardly seen.
const SOFT_SAMPLES: u32 = 16;

/// Where the samples of a pixel lie.
#[derive(Args, Debug)]
#[command(next_help_heading = "Samples")]
pub struct SampleArgs {
    /// Samples per pixel [default: 1; 16 with --style studio or clay]
    #[arg(long, value_name = "N", value_parser = values::whole::<{ u32::MAX }>)]
    pub samples: Option<u32>,

    /// How the samples of a pixel are placed [default: grid for a square number of samples (1, 4, 9, 16, ...), else sobol]
    #[arg(long, value_enum)]
    pub pattern: Option<Pattern>,

    /// How samples are weighted by their distance from the pixel's centre [default: box; tent with --style studio or clay]
    #[arg(long, value_enum)]
    pub filter: Option<Filter>,
}

/// What camera rays that hit nothing return.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BackgroundArg {
    /// The scene's background
    Scene,
    /// Alpha 0 (mirrors still show the scene's background)
    Transparent,
}

impl PictureArgs {
    /// As plain values. `is_srgb`: by itself, because of a soft style.
    pub fn options(&self, is_srgb: bool) -> PictureOptions {
        PictureOptions {
            transfer: if self.srgb || is_srgb && !self.linear {
                Transfer::Srgb
            } else {
                Transfer::Linear
            },
            transparent: self.background == BackgroundArg::Transparent,
            aovs: self.aovs.clone(),
        }
    }

    /// Puts the crop into settings that have the size of the picture.
    ///
    /// # Errors
    /// [`CliError::Usage`] if it is not within the picture.
    pub fn apply(&self, settings: &mut Settings) -> Result<(), CliError> {
        let (width, height) = (settings.width, settings.height);
        if let Some(crop) = self.crop.filter(|crop| crop.x1 > width || crop.y1 > height) {
            return Err(CliError::Usage(format!(
                "--crop {crop} is not within the picture of {width}x{height}: expected at most 0,0,{width},{height}"
            )));
        }
        settings.crop = self.crop;
        Ok(())
    }
}

impl SampleArgs {
    /// Puts the samples into the settings; `is_soft`: of a mesh in one of the soft styles.
    ///
    /// # Errors
    /// [`CliError::Usage`] if the number does not suit the pattern that was asked for.
    pub fn apply(&self, settings: &mut Settings, is_soft: bool) -> Result<(), CliError> {
        let samples = self.samples.unwrap_or(if is_soft { SOFT_SAMPLES } else { 1 });
        let side = samples.isqrt();
        let is_square = side * side == samples;
        if let Some(pattern @ (Pattern::Grid | Pattern::Stratified)) = self.pattern
            && !is_square
        {
            let [below, above] = [side, side + 1].map(|side| u64::from(side) * u64::from(side));
            let name = pattern.to_possible_value();
            return Err(CliError::Usage(format!(
                "--pattern {} needs a square number of samples: use --samples {below} or {above}, or --pattern sobol \
                 for {samples}",
                name.as_ref().map_or("", |name| name.get_name())
            )));
        }
        settings.samples = samples;
        settings.pattern = self
            .pattern
            .unwrap_or(if is_square { Pattern::Grid } else { Pattern::Sobol });
        let filter = if is_soft { Filter::Tent } else { Filter::Box };
        settings.filter = self.filter.unwrap_or(filter);
        Ok(())
    }
}
