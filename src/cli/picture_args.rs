//! Which part of a picture is rendered, and into what.

use super::{CliError, aov::AovArg};
use crate::render::{Crop, Filter, Pattern, Settings, Transfer};
use clap::{Args, ValueEnum};

/// What becomes of the camera's rays.
#[derive(Args, Debug)]
#[command(next_help_heading = "Picture")]
pub struct PictureArgs {
    /// Render a part of the picture, exactly as it is in the whole: columns x0 to x1 and rows y0 to y1, x1 and y1
    /// not included; row 0 is on top
    #[arg(long, value_name = "x0,y0,x1,y1", value_parser = crop)]
    pub crop: Option<Crop>,

    /// What else to write, of the ray through each pixel's centre: to files beside the picture, named after it
    /// (a.png: a.depth.png), or into it as layers, if it is EXR
    #[arg(id = "aov", long, value_name = "WHAT", value_enum, value_delimiter = ',')]
    pub aovs: Vec<AovArg>,

    /// Encode bytes by the curve of sRGB, as screens expect them
    #[arg(long, conflicts_with = "linear")]
    pub srgb: bool,

    /// Write linear values as they are, 255 times each, the fraction cut off (the default)
    #[arg(long)]
    pub linear: bool,

    /// What is behind everything
    #[arg(long, value_enum, default_value_t = BackgroundArg::Scene)]
    pub background: BackgroundArg,
}

/// Where in its pixel a ray goes.
#[derive(Args, Debug)]
#[command(next_help_heading = "Samples")]
pub struct SampleArgs {
    /// Samples for each pixel: 1, 4, 9, 16 or another square number; any number with --pattern sobol
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), default_value_t = 1)]
    pub samples: u32,

    /// How the samples of a pixel lie
    #[arg(long, value_enum, default_value_t = PatternArg::Grid)]
    pub pattern: PatternArg,

    /// How much a sample counts by its distance from the pixel's centre
    #[arg(long, value_enum, default_value_t = FilterArg::Box)]
    pub filter: FilterArg,
}

/// What camera rays that hit nothing bring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BackgroundArg {
    /// The scene's background
    Scene,
    /// Nothing: alpha 0 (mirrors show the scene's background still)
    Transparent,
}

/// See [`Pattern`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PatternArg {
    /// On a regular grid
    Grid,
    /// Anywhere in the cells of a regular grid
    Stratified,
    /// A scrambled Sobol' sequence, another one in every pixel
    Sobol,
}

/// See [`Filter`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FilterArg {
    /// All of the pixel alike
    Box,
    /// Falls evenly, to 0 at a distance of 1 pixel
    Tent,
    /// A bell, 0 at a distance of 1.5 pixels
    BlackmanHarris,
}

impl PictureArgs {
    /// How channels become bytes.
    pub fn transfer(&self) -> Transfer {
        if self.srgb {
            Transfer::Srgb
        } else {
            Transfer::Linear
        }
    }

    /// Whether the picture has an alpha channel.
    pub fn transparent(&self) -> bool {
        self.background == BackgroundArg::Transparent
    }

    /// Puts the crop into the settings, which have the picture's size already.
    ///
    /// # Errors
    /// [`CliError::Usage`], where it is not within the picture.
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
    /// Puts these options into the settings.
    ///
    /// # Errors
    /// [`CliError::Usage`], where the samples do not fill the pattern.
    pub fn apply(&self, settings: &mut Settings) -> Result<(), CliError> {
        let samples = self.samples;
        let side = samples.isqrt();
        if self.pattern != PatternArg::Sobol && side * side != samples {
            let [below, above] = [side, side + 1].map(|side| u64::from(side) * u64::from(side));
            return Err(CliError::Usage(format!(
                "--samples {samples} does not fill a square grid: expected {below} or {above}, or --pattern sobol, which \
                 takes any number"
            )));
        }
        settings.samples = samples;
        settings.pattern = match self.pattern {
            PatternArg::Grid => Pattern::Grid,
            PatternArg::Stratified => Pattern::Stratified,
            PatternArg::Sobol => Pattern::Sobol,
        };
        settings.filter = match self.filter {
            FilterArg::Box => Filter::Box,
            FilterArg::Tent => Filter::Tent,
            FilterArg::BlackmanHarris => Filter::BlackmanHarris,
        };
        Ok(())
    }
}

/// `x0,y0,x1,y1`; whether it is within the picture is seen later.
pub fn crop(text: &str) -> Result<Crop, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => Ok(Crop { x0, y0, x1, y1 }),
        Some(&[..]) if text.split(',').count() == 4 => Err("expected x0 below x1 and y0 below y1".into()),
        _ => Err("expected four whole numbers x0,y0,x1,y1 in pixels, such as 0,0,256,128".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops() {
        let expected = Crop {
            x0: 1,
            y0: 2,
            x1: 30,
            y1: 4,
        };
        assert_eq!(crop("1, 2,30,4"), Ok(expected));
        assert_eq!(crop(&expected.to_string()), Ok(expected));
        for text in [
            "",
            "1,2,3",
            "1,2,3,4,5",
            "1,2,1,4",
            "1,4,3,4",
            "-1,2,3,4",
            "0.5,0,1,1",
            "5,5,2,2",
        ] {
            assert!(crop(text).is_err(), "{text}");
        }
    }
}
