//! The place of a crop in its whole picture, which every crop's file records for `octray merge`.
//!
//! PNG has a text chunk for it, PPM a comment, EXR an attribute in addition to its data window. In QOI, BMP and TIFF only the
//! end of the file is skipped by readers, so it follows the picture; FFmpeg complains about it in QOI files, and shows them.

use super::{aov::AovKind, encode::Format};
use crate::render::{Crop, Settings, Transfer};
use std::fmt;

/// The keyword of PNG's text chunk.
pub const PNG_KEYWORD: &str = "Crop";
/// The name of EXR's attribute.
pub const EXR_ATTRIBUTE: &str = "octrayCrop";
const LINEAR: &str = "linear";
const SRGB: &str = "sRGB";

/// What a file shows, so that tiles of different kinds are not merged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shows {
    Colors(Transfer),
    Albedo(Transfer),
    /// Depth; the number is the length of a step, scene units.
    Z(f64),
    /// Another AOV.
    Aov(AovKind),
}

impl Shows {
    fn parse(text: &str) -> Option<Self> {
        if let Some(step) = text.strip_prefix("z ") {
            return step.parse().ok().map(Self::Z);
        }
        Some(match text {
            LINEAR => Self::Colors(Transfer::Linear),
            SRGB => Self::Colors(Transfer::Srgb),
            "linear albedo" => Self::Albedo(Transfer::Linear),
            "sRGB albedo" => Self::Albedo(Transfer::Srgb),
            name => Self::Aov(AovKind::ALL.into_iter().find(|aov| aov.name() == name)?),
        })
    }
}

impl fmt::Display for Shows {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |transfer| match transfer {
            Transfer::Linear => LINEAR,
            Transfer::Srgb => SRGB,
        };
        match *self {
            Self::Colors(transfer) => f.write_str(name(transfer)),
            Self::Albedo(transfer) => write!(f, "{} albedo", name(transfer)),
            Self::Z(step) => write!(f, "z {step}"),
            Self::Aov(aov) => f.write_str(aov.name()),
        }
    }
}

/// A crop's place in its whole picture, how many samples its pixels took, and what they show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    pub crop: Crop,
    /// Width and height of the whole picture, pixels.
    pub whole: [u32; 2],
    /// Samples a pixel, at most if `adaptive`.
    pub samples: u32,
    pub adaptive: bool,
    pub shows: Shows,
}

impl Place {
    /// The place of a picture with these settings; `None` if it is not a crop.
    pub fn of(settings: &Settings, transfer: Transfer) -> Option<Self> {
        Some(Self {
            crop: settings.crop?,
            whole: [settings.width, settings.height],
            samples: settings.samples,
            adaptive: settings.adaptive,
            shows: Shows::Colors(transfer),
        })
    }

    /// The same place of a file that shows something else.
    pub fn showing(self, shows: Shows) -> Self {
        Self { shows, ..self }
    }

    /// As after `--samples`.
    pub fn samples(self) -> String {
        let auto = if self.adaptive { "auto:" } else { "" };
        format!("{auto}{}", self.samples)
    }

    fn parse(text: &str) -> Option<Self> {
        let (place, rest) = text.split_once(", samples ")?;
        let (samples, shows) = rest.split_once(", ")?;
        let (crop, whole) = place.split_once(" of ")?;
        let number = |text: &str| text.parse::<u32>().ok();
        let corners: Option<Vec<u32>> = crop.split(',').map(number).collect();
        let &[x0, y0, x1, y1] = corners?.as_slice() else {
            return None;
        };
        let (width, height) = whole.split_once('x')?;
        let (width, height) = (number(width)?, number(height)?);
        let most = samples.strip_prefix("auto:");
        let place = Self {
            crop: Crop { x0, y0, x1, y1 },
            whole: [width, height],
            samples: number(most.unwrap_or(samples))?,
            adaptive: most.is_some(),
            shows: Shows::parse(shows)?,
        };
        (x0 < x1 && y0 < y1 && x1 <= width && y1 <= height).then_some(place)
    }

    /// Adds the place to a picture's bytes, where the encoder has not written it.
    pub fn add_to(self, format: Format, bytes: &mut Vec<u8>) {
        match format {
            Format::Ppm => {
                let line = bytes
                    .iter()
                    .position(|&byte| byte == b'\n')
                    .map_or(0, |end| end + 1);
                bytes.splice(line..line, format!("# octray crop {self}\n").into_bytes());
            }
            Format::Qoi | Format::Bmp | Format::Tiff => {
                bytes.extend(format!("\noctray crop {self}\n").into_bytes());
            }
            _ => {}
        }
    }

    /// The place that a file says, from its first and last bytes.
    pub fn find(format: Format, head: &[u8], tail: &[u8]) -> Option<Self> {
        let line =
            |bytes: &'static str, text| after(text, bytes.as_bytes())?.split(|&byte| byte == b'\n').next();
        let text = match format {
            Format::Png => png_text(head),
            Format::Exr => exr_text(head),
            Format::Ppm => line("P6\n# octray\n# octray crop ", head),
            Format::Qoi | Format::Bmp | Format::Tiff => line("\noctray crop ", tail),
            Format::Jpeg | Format::Gif | Format::Apng | Format::Y4m => None,
        };
        Self::parse(std::str::from_utf8(text?).ok()?)
    }
}

/// `0,0,256,128 of 512x512, samples 16, sRGB`.
impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.whole;
        let (crop, samples, shows) = (self.crop, self.samples(), self.shows);
        write!(f, "{crop} of {width}x{height}, samples {samples}, {shows}")
    }
}

fn after<'a>(bytes: &'a [u8], mark: &[u8]) -> Option<&'a [u8]> {
    let start = bytes.windows(mark.len()).position(|window| window == mark)?;
    bytes.get(start + mark.len()..)
}

/// The text of a chunk: its length, `tEXt`, keyword, 0 and text.
fn png_text(head: &[u8]) -> Option<&[u8]> {
    let mark = [b"tEXt", PNG_KEYWORD.as_bytes(), b"\0"].concat();
    let start = head.windows(mark.len()).position(|window| window == mark)?;
    let length = *head[..start].last_chunk()?;
    let length = (u32::from_be_bytes(length) as usize).checked_sub(mark.len() - 4)?;
    head[start + mark.len()..].get(..length)
}

/// The text of an attribute: its name, 0, `string`, 0, length and text.
fn exr_text(head: &[u8]) -> Option<&[u8]> {
    let value = after(head, &[EXR_ATTRIBUTE.as_bytes(), b"\0string\0"].concat())?;
    let (&length, text) = value.split_first_chunk()?;
    text.get(..u32::from_le_bytes(length) as usize)
}

#[cfg(test)]
mod tests;
