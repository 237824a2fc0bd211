//! What the pixels of a picture hold, and where its samples lie.

use super::{choices::Choice, values};
use crate::{
    cli::{
        CliError,
        plan::{Backdrop, PictureOptions, Style},
        write::{AovKind, Z_STEP},
    },
    render::{Crop, Edges, Filter, Pattern, Settings, Transfer},
};
use clap::{Args, ValueEnum};

/// What the pixels hold.
#[derive(Args, Debug)]
#[command(next_help_heading = "Picture")]
pub struct PictureArgs {
    /// Render only columns x0 to x1 and rows y0 to y1, excluding x1 and y1, with the same pixels as in the whole picture; row 0
    /// is at the top
    #[arg(long, value_name = "x0,y0,x1,y1", value_parser = values::crop)]
    pub crop: Option<Crop>,

    /// Also write AOVs of the ray through each pixel's centre: to files named after the picture (a.png: a.depth.png), or
    /// as layers of an EXR picture
    #[arg(id = "aov", long, value_name = "WHAT", value_enum, value_delimiter = ',')]
    pub aovs: Vec<AovKind>,

    /// Depth step of --aov z in PNG files, scene units; the farthest depth is 65535 steps [default: 0.001]
    #[arg(long, value_name = "UNITS", value_parser = values::step)]
    pub z_step: Option<f64>,

    #[command(flatten)]
    pub transfer: TransferArgs,

    /// What is behind everything: the scene's background (scene), nothing (transparent, alpha 0), or a colour (white, black
    /// or six hexadecimal digits, such as 336699). Mirrors and glass still show the scene's background [default: scene]
    #[arg(long, value_name = "COLOR")]
    pub background: Option<Backdrop>,

    #[command(flatten)]
    pub edges: EdgeArgs,

    /// Draw the colours of --color-by and their numbers over the right side of the picture, which needs at least 160x120
    /// pixels
    #[arg(long, requires = "color_by")]
    pub color_bar: bool,
}

/// The edges of triangles.
#[derive(Args, Debug)]
#[command(next_help_heading = "Picture")]
pub struct EdgeArgs {
    /// Draw the edges of triangles over what is seen directly, as lines of this width in pixels, 1 if none is given. Where
    /// triangles are only a few pixels high, edges are faint
    #[arg(
        long,
        value_name = "WIDTH",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "1",
        value_parser = values::edge_width
    )]
    pub edges: Option<f32>,

    /// Colour of the edges: white, black or six hexadecimal digits, such as 336699 [default: nearly black]
    #[arg(long, value_name = "COLOR", value_parser = values::color, requires = "edges")]
    pub edge_color: Option<[u8; 3]>,
}

/// How linear channels become bytes.
#[derive(Args, Debug)]
#[command(next_help_heading = "Picture")]
pub struct TransferArgs {
    /// Encode bytes with the sRGB curve, as screens expect (the default for meshes, unless --style plain)
    #[arg(long, conflicts_with = "linear")]
    pub srgb: bool,

    /// Write linear values, without gamma (the default for scenes, and for meshes with --style plain)
    #[arg(long)]
    pub linear: bool,
}

/// How a mesh is lit.
#[derive(Args, Debug)]
#[command(next_help_heading = "Meshes")]
pub struct StyleArgs {
    /// How a mesh is lit, with defaults for --samples, --filter and --srgb [default: studio]
    #[arg(long, value_enum)]
    pub style: Option<Style>,
}

/// The most samples of `auto`, and of the soft styles, whose noise is then hardly visible.
const MANY_SAMPLES: u32 = 16;

/// Samples of a picture if no option says so: of a mesh in one of the soft styles, or of anything else.
pub fn usual_samples(is_soft: bool) -> u32 {
    if is_soft { MANY_SAMPLES } else { 1 }
}

/// Samples per pixel.
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
    /// Samples per pixel. auto takes at most 16 and auto:N at most N, fewer where a pixel looks like its neighbours. It may miss
    /// details thinner than a pixel, seldom from auto:64 on. [default: 1; auto for meshes, unless --style plain]
    #[arg(long, value_name = "N", value_parser = Samples::parse)]
    pub samples: Option<Samples>,

    /// How the samples of a pixel are placed [default: grid for a square number of samples (1, 4, 9, 16, ...), sobol for
    /// others and for auto]
    #[arg(long, value_enum)]
    pub pattern: Option<Choice<Pattern>>,

    /// How samples are weighted by their distance from the pixel's centre [default: box; tent for meshes,
    /// unless --style plain]
    #[arg(long, value_enum)]
    pub filter: Option<Choice<Filter>>,
}

impl TransferArgs {
    /// `is_srgb`: by itself, because of a soft style.
    pub fn transfer(&self, is_srgb: bool) -> Transfer {
        if self.srgb || is_srgb && !self.linear {
            Transfer::Srgb
        } else {
            Transfer::Linear
        }
    }
}

impl EdgeArgs {
    /// The edges of a picture with that transfer, whose bytes show the colour.
    pub fn edges(&self, transfer: Transfer) -> Option<Edges> {
        let usual = Edges::default();
        Some(Edges {
            width: self.edges?,
            color: self
                .edge_color
                .map_or(usual.color, |color| transfer.decode(color)),
        })
    }
}

impl StyleArgs {
    /// The style of meshes.
    pub fn style(&self) -> Style {
        self.style.unwrap_or(Style::Studio)
    }
}

impl PictureArgs {
    /// As plain values. `is_srgb`: by itself, because of a soft style; not if the file `is_exr`.
    pub fn options(&self, is_srgb: bool, is_exr: bool) -> PictureOptions {
        PictureOptions {
            transfer: self.transfer.transfer(is_srgb && !is_exr),
            byte_transfer: self.transfer.transfer(is_srgb),
            backdrop: self.background.unwrap_or_default(),
            aovs: self.aovs.clone(),
            z_step: self.z_step.unwrap_or(Z_STEP),
            has_color_bar: self.color_bar,
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
                Some(most) => whole(most)
                    .map(Self::Auto)
                    .map_err(|expected| format!("{expected}, such as auto:64")),
                None => Err("expected a whole number, auto or auto:N".into()),
            },
            None => whole(text)
                .map(Self::Exactly)
                .map_err(|expected| format!("{expected}, or auto")),
        }
    }
}

impl SampleArgs {
    /// Puts the samples into the settings: `usual` ones if no option says so. `is_soft`: of a mesh in one of the soft
    /// styles, whose pixels take fewer where that suits the pattern.
    ///
    /// # Errors
    /// [`CliError::Usage`] if the number does not suit the pattern that was asked for.
    pub fn apply(&self, settings: &mut Settings, is_soft: bool, usual: u32) -> Result<(), CliError> {
        let regular = self.pattern.filter(|&Choice(pattern)| pattern != Pattern::Sobol);
        let samples = self.samples.unwrap_or(match (is_soft, regular) {
            (true, None) => Samples::Auto(usual),
            _ => Samples::Exactly(usual),
        });
        (settings.samples, settings.pattern) = match samples {
            Samples::Exactly(samples) => (samples, self.pattern_of(samples)?),
            Samples::Auto(most) => {
                if let Some(pattern) = regular {
                    return Err(CliError::Usage(format!(
                        "--pattern {} needs the same samples in every pixel: use a number with --samples, or --pattern sobol \
                         for auto",
                        name_of(&pattern)
                    )));
                }
                (most, Pattern::Sobol)
            }
        };
        settings.adaptive = matches!(samples, Samples::Auto(_));
        settings.filter = self.filter.map_or(usual_filter(is_soft), |Choice(filter)| filter);
        Ok(())
    }

    /// Returns the pattern of a number of samples.
    fn pattern_of(&self, samples: u32) -> Result<Pattern, CliError> {
        let side = samples.isqrt();
        let is_square = side * side == samples;
        match self.pattern {
            Some(pattern @ Choice(Pattern::Grid | Pattern::Stratified)) if !is_square => {
                let [below, above] = [side, side + 1].map(|side| u64::from(side) * u64::from(side));
                Err(CliError::Usage(format!(
                    "--pattern {} needs a square number of samples: use --samples {below} or {above}, or --pattern sobol \
                     for {samples}",
                    name_of(&pattern)
                )))
            }
            Some(Choice(pattern)) => Ok(pattern),
            None => Ok(usual_pattern(samples)),
        }
    }
}

pub(super) fn usual_pattern(samples: u32) -> Pattern {
    if samples.isqrt().pow(2) == samples {
        Pattern::Grid
    } else {
        Pattern::Sobol
    }
}

pub(super) fn usual_filter(is_soft: bool) -> Filter {
    if is_soft { Filter::Tent } else { Filter::Box }
}

/// Returns a value's name on the command line.
pub(super) fn name_of(value: &impl ValueEnum) -> String {
    let value = value.to_possible_value();
    value.map_or(String::new(), |value| value.get_name().to_owned())
}

/// Returns how `octray render` makes a picture of a scene, or of a mesh in one of the soft styles, with the value of `--samples`
/// and with `--srgb` or `--linear`.
///
/// # Errors
/// [`CliError::Usage`] if that is not a value of `--samples`.
pub fn look(
    mut settings: Settings,
    is_soft: bool,
    samples: Option<&str>,
    srgb: Option<bool>,
) -> Result<(Settings, Transfer), CliError> {
    let wrong = |expected| CliError::Usage(format!("samples: {expected}"));
    let sampling = SampleArgs {
        samples: samples.map(Samples::parse).transpose().map_err(wrong)?,
        pattern: None,
        filter: None,
    };
    sampling.apply(&mut settings, is_soft, usual_samples(is_soft))?;
    let transfer = TransferArgs {
        srgb: srgb == Some(true),
        linear: srgb == Some(false),
    };
    Ok((settings, transfer.transfer(is_soft)))
}
