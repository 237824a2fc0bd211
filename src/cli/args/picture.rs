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

    /// Write linear values, without gamma (the default for scenes and plain meshes)
    #[arg(long)]
    pub linear: bool,

    /// What is behind the scene
    #[arg(long, value_enum, default_value_t = BackgroundArg::Scene)]
    pub background: BackgroundArg,
}

/// Samples of the soft styles, whose grain is hardly seen then, and the most of `auto`.
const MANY_SAMPLES: u32 = 16;

/// How many samples a pixel takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    Exactly(u32),
    /// At most this many, fewer where neighbours look alike.
    Auto(u32),
}

/// Where the samples of a pixel lie.
#[derive(Args, Debug)]
#[command(next_help_heading = "Samples")]
pub struct SampleArgs {
    /// Samples per pixel; auto takes up to 16, and auto:N up to N, fewer in pixels that look like their neighbours
    /// [default: 1; auto for meshes that are not plain]
    #[arg(long, value_name = "N", value_parser = Samples::parse)]
    pub samples: Option<Samples>,

    /// How the samples of a pixel are placed [default: grid for a square number of samples (1, 4, 9, 16, ...), sobol for
    /// others and for auto]
    #[arg(long, value_enum)]
    pub pattern: Option<Pattern>,

    /// How samples are weighted by their distance from the pixel's centre [default: box; tent for meshes that are not plain]
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

impl Samples {
    /// A whole number, `auto` or `auto:N`.
    fn parse(text: &str) -> Result<Self, String> {
        let whole = values::whole::<{ u32::MAX }>;
        match text.strip_prefix("auto") {
            Some("") => Ok(Self::Auto(MANY_SAMPLES)),
            Some(most) => match most.strip_prefix(':') {
                Some(most) => whole(most).map(Self::Auto),
                None => Err("expected a whole number, auto or auto:N".into()),
            },
            None => whole(text)
                .map(Self::Exactly)
                .map_err(|expected| format!("{expected}, or auto")),
        }
    }
}

impl SampleArgs {
    /// Puts the samples into the settings; `is_soft`: of a mesh in one of the soft styles.
    ///
    /// # Errors
    /// [`CliError::Usage`] if the number does not suit the pattern that was asked for.
    pub fn apply(&self, settings: &mut Settings, is_soft: bool) -> Result<(), CliError> {
        let regular = self.pattern.filter(|&pattern| pattern != Pattern::Sobol);
        let samples = self.samples.unwrap_or(match (is_soft, regular) {
            (false, _) => Samples::Exactly(1),
            (true, None) => Samples::Auto(MANY_SAMPLES),
            (true, Some(_)) => Samples::Exactly(MANY_SAMPLES),
        });
        (settings.samples, settings.pattern) = match samples {
            Samples::Exactly(samples) => (samples, self.pattern_of(samples)?),
            Samples::Auto(most) => {
                if let Some(pattern) = regular {
                    return Err(CliError::Usage(format!(
                        "--pattern {} needs the same samples in every pixel: use a number with --samples, or --pattern sobol \
                         for auto",
                        name_of(pattern)
                    )));
                }
                (most, Pattern::Sobol)
            }
        };
        settings.adaptive = matches!(samples, Samples::Auto(_));
        let filter = if is_soft { Filter::Tent } else { Filter::Box };
        settings.filter = self.filter.unwrap_or(filter);
        Ok(())
    }

    /// Returns the pattern of a number of samples.
    fn pattern_of(&self, samples: u32) -> Result<Pattern, CliError> {
        let side = samples.isqrt();
        let is_square = side * side == samples;
        match self.pattern {
            Some(pattern @ (Pattern::Grid | Pattern::Stratified)) if !is_square => {
                let [below, above] = [side, side + 1].map(|side| u64::from(side) * u64::from(side));
                Err(CliError::Usage(format!(
                    "--pattern {} needs a square number of samples: use --samples {below} or {above}, or --pattern sobol \
                     for {samples}",
                    name_of(pattern)
                )))
            }
            Some(pattern) => Ok(pattern),
            None if is_square => Ok(Pattern::Grid),
            None => Ok(Pattern::Sobol),
        }
    }
}

/// Returns a pattern's name on the command line.
fn name_of(pattern: Pattern) -> String {
    let value = pattern.to_possible_value();
    value.map_or(String::new(), |value| value.get_name().to_owned())
}
