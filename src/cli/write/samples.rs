//! The samples of tiles, copied to their places and encoded as `octray render` encodes a picture.

use super::{
    encode::Format,
    exr_layers::{Channel, Values},
    picture::{Picture, Pixels},
};
use crate::{
    cli::CliError,
    render::{Crop, Film},
};
use exr::{
    meta::MetaData,
    prelude::{FlatSamples, ReadChannels, ReadLayers},
};
use image::{ImageError, ImageResult};
use std::io::{self, Cursor};

/// The samples of a tile or of the picture.
pub enum Samples {
    /// Grey, grey of 16 bits, RGB or RGBA: 1 to 4 bytes per pixel.
    Bytes(Vec<u8>, usize),
    Exr(Vec<Plane>),
}

/// A channel of an EXR file as bits, row by row.
pub struct Plane {
    name: String,
    is_float: bool,
    bits: Vec<u32>,
}

/// The channels of an EXR file that should have this size.
///
/// # Errors
/// [`ImageError`].
pub fn read_exr(bytes: &[u8], size: [usize; 2]) -> ImageResult<Vec<Plane>> {
    let broken = |error: exr::error::Error| ImageError::IoError(io::Error::other(error.to_string()));
    let meta = MetaData::read_from_buffered(bytes, false).map_err(broken)?;
    let [header] = meta.headers.as_slice() else {
        return Err(changed());
    };
    if [header.layer_size.0, header.layer_size.1] != size {
        return Err(changed());
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(broken)?;
    let planes = image.layer_data.channel_data.list.into_iter().map(|channel| {
        let (is_float, bits): (bool, Vec<u32>) = match channel.sample_data {
            FlatSamples::F32(values) => (true, values.into_iter().map(f32::to_bits).collect()),
            FlatSamples::U32(values) => (false, values),
            FlatSamples::F16(_) => return Err(changed()),
        };
        if bits.len() != size[0] * size[1] {
            return Err(changed());
        }
        Ok(Plane {
            name: channel.name.to_string(),
            is_float,
            bits,
        })
    });
    planes.collect()
}

/// Marks the crop's pixels in a picture of this width.
pub fn cover(covered: &mut [bool], width: u32, crop: Crop) {
    for y in crop.y0..crop.y1 {
        covered[row(width, crop, y)].fill(true);
    }
}

/// The pixels of a crop's row.
fn row(width: u32, crop: Crop, y: u32) -> std::ops::Range<usize> {
    let start = y as usize * width as usize;
    start + crop.x0 as usize..start + crop.x1 as usize
}

/// Copies a tile's samples to their place in the whole picture. Where pixels are covered already, returns the first that
/// differs.
fn paste<T: Copy + PartialEq>(
    (whole, width): (&mut [T], u32),
    tile: &[T],
    depth: usize,
    crop: Crop,
    covered: &[bool],
) -> Option<[u32; 2]> {
    let rows = tile.chunks_exact(crop.width() as usize * depth);
    for (y, from) in (crop.y0..crop.y1).zip(rows) {
        let range = row(width, crop, y);
        let covered = &covered[range.clone()];
        let to = &mut whole[range.start * depth..range.end * depth];
        if covered.contains(&true) {
            let pixels = to.chunks_exact(depth).zip(from.chunks_exact(depth)).zip(covered);
            let mut pixels = pixels.map(|((to, from), &covered)| covered && to != from);
            if let Some(x) = pixels.position(|differs| differs) {
                return Some([crop.x0 + x as u32, y]);
            }
        }
        to.copy_from_slice(from);
    }
    None
}

impl Samples {
    /// The channels in words.
    pub fn kind(&self) -> String {
        match self {
            Self::Bytes(_, 1) => "grey".into(),
            Self::Bytes(_, 2) => "grey of 16 bits".into(),
            Self::Bytes(_, 3) => "RGB".into(),
            Self::Bytes(..) => "RGBA".into(),
            Self::Exr(planes) => {
                let names = planes.iter().map(|plane| {
                    let whole = if plane.is_float { "" } else { " (whole numbers)" };
                    format!("{}{whole}", crate::error::clip(&plane.name))
                });
                names.collect::<Vec<_>>().join(", ")
            }
        }
    }

    /// Bytes of a pixel.
    pub fn pixel_bytes(&self) -> u64 {
        match self {
            Self::Bytes(_, depth) => *depth as u64,
            Self::Exr(planes) => 4 * planes.len() as u64,
        }
    }

    /// Samples of the same kind for `count` pixels.
    pub fn black(&self, count: usize) -> Self {
        match self {
            Self::Bytes(_, depth) => Self::Bytes(vec![0; count * depth], *depth),
            Self::Exr(planes) => {
                let black = planes.iter().map(|plane| Plane {
                    name: plane.name.clone(),
                    is_float: plane.is_float,
                    bits: vec![0; count],
                });
                Self::Exr(black.collect())
            }
        }
    }

    /// Copies a tile to its place. Where pixels are covered already, returns the first that differs.
    pub fn paste(&mut self, tile: &Self, width: u32, crop: Crop, covered: &[bool]) -> Option<[u32; 2]> {
        match (self, tile) {
            (Self::Bytes(whole, depth), Self::Bytes(tile, _)) => {
                paste((whole, width), tile, *depth, crop, covered)
            }
            (Self::Exr(whole), Self::Exr(tile)) => {
                let mut planes = whole.iter_mut().zip(tile);
                planes.find_map(|(whole, tile)| paste((&mut whole.bits, width), &tile.bits, 1, crop, covered))
            }
            _ => None,
        }
    }

    /// The picture's file.
    ///
    /// # Errors
    /// [`CliError::Failed`].
    pub fn encode(self, format: Format, size: [u32; 2]) -> Result<Vec<u8>, CliError> {
        match self {
            Self::Bytes(bytes, depth) => format.encode_whole(&bytes, size, depth),
            Self::Exr(planes) => format.encode(&mut exr_picture(planes, size)?),
        }
    }
}

/// The file is not the one that octray wrote.
pub fn changed() -> ImageError {
    ImageError::IoError(io::Error::other(
        "its pixels do not match the tile that it claims to be",
    ))
}

/// A picture of the channels R, G, B and perhaps A; the others are its layers.
fn exr_picture(planes: Vec<Plane>, [width, height]: [u32; 2]) -> Result<Picture, CliError> {
    let (colors, others): (Vec<Plane>, Vec<Plane>) = planes
        .into_iter()
        .partition(|plane| plane.is_float && ["R", "G", "B", "A"].contains(&plane.name.as_str()));
    let color = |name: &str| colors.iter().find(|plane| plane.name == name);
    let (Some(red), Some(green), Some(blue)) = (color("R"), color("G"), color("B")) else {
        let why = "the tiles have no channels R, G and B: they are not pictures of octray render";
        return Err(CliError::Failed(why.into()));
    };
    let rgb = |i: usize| [red, green, blue].map(|plane| f32::from_bits(plane.bits[i]));
    let pixels = if let Some(alpha) = color("A") {
        let mut film = Film::<[f32; 4]>::black(width, height);
        for (i, pixel) in film.pixels_mut().iter_mut().enumerate() {
            let [r, g, b] = rgb(i);
            *pixel = [r, g, b, f32::from_bits(alpha.bits[i])];
        }
        Pixels::Transparent(film)
    } else {
        let mut film = Film::new(width, height);
        for (i, pixel) in film.pixels_mut().iter_mut().enumerate() {
            *pixel = rgb(i);
        }
        Pixels::Linear(film)
    };
    drop(colors);
    let layers = others.into_iter().map(|plane| Channel {
        name: plane.name.into(),
        values: if plane.is_float {
            Values::Floats(plane.bits.into_iter().map(f32::from_bits).collect())
        } else {
            Values::Whole(plane.bits)
        },
    });
    Ok(Picture {
        layers: layers.collect(),
        ..Picture::from(pixels)
    })
}

#[cfg(test)]
mod tests;
