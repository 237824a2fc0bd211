//! EXR files of colours and other channels.
//!
//! The image crate writes only colours, and blocks in the order in which threads finish, so that bytes vary.

use super::place::{EXR_ATTRIBUTE, Place, Shows};
use crate::render::{Film, Pixel, SOFTWARE, Transfer};
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    SpecificChannels, Vec2, WritableImage,
};
use std::{borrow::Cow, io::Cursor};

/// Blocks in increasing order, so that the same picture always gives the same bytes.
const ENCODING: Encoding = Encoding {
    line_order: LineOrder::Increasing,
    ..Encoding::FAST_LOSSLESS
};

/// Writes the film's colours, without [`write`]'s copy of each channel.
///
/// # Errors
/// The exr crate's error.
pub fn write_rgb(film: &Film, place: Option<Place>, to: &mut Cursor<Vec<u8>>) -> exr::error::UnitResult {
    let size @ Vec2(width, _) = size(film);
    let channels = SpecificChannels::rgb(|Vec2(x, y)| {
        let [r, g, b] = film.pixels()[y * width + x];
        (r, g, b)
    });
    Image::from_layer(Layer::new(size, attributes(place), ENCODING, channels))
        .write()
        .to_buffered(to)
}

/// Writes the film's premultiplied colours and alpha.
///
/// # Errors
/// The exr crate's error.
pub fn write_rgba(
    film: &Film<[f32; 4]>,
    place: Option<Place>,
    to: &mut Cursor<Vec<u8>>,
) -> exr::error::UnitResult {
    let size @ Vec2(width, _) = size(film);
    let channels = SpecificChannels::rgba(|Vec2(x, y)| {
        let [r, g, b, alpha] = film.pixels()[y * width + x];
        (r, g, b, alpha)
    });
    Image::from_layer(Layer::new(size, attributes(place), ENCODING, channels))
        .write()
        .to_buffered(to)
}

/// Who wrote the file, and where in the whole picture it lies. The display window is the crop's own, so that viewers show
/// the crop alone.
fn attributes(place: Option<Place>) -> LayerAttributes {
    let mut attributes = LayerAttributes {
        software_name: Some(SOFTWARE.into()),
        ..LayerAttributes::default()
    };
    if let Some(place) = place {
        attributes.layer_position = Vec2(place.crop.x0 as i32, place.crop.y0 as i32);
        // EXR files are linear whatever the transfer.
        let text = place.showing(Shows::Colors(Transfer::Linear)).to_string();
        let text = AttributeValue::Text(text.as_str().into());
        attributes.other.insert(EXR_ATTRIBUTE.into(), text);
    }
    attributes
}

fn size<P: Pixel>(film: &Film<P>) -> Vec2<usize> {
    Vec2(film.width() as usize, film.height() as usize)
}

/// A channel by its full name, such as `normal.X`, row by row.
pub struct Channel {
    pub name: Cow<'static, str>,
    pub values: Values,
}

/// What a channel holds.
pub enum Values {
    Floats(Vec<f32>),
    Whole(Vec<u32>),
}

/// Writes the film's channels, `names` of them, and `layers` beside them.
///
/// # Errors
/// The exr crate's error.
pub fn write<const N: usize>(
    film: &Film<[f32; N]>,
    names: [&'static str; N],
    layers: Vec<Channel>,
    place: Option<Place>,
    to: &mut Cursor<Vec<u8>>,
) -> exr::error::UnitResult
where
    [f32; N]: Pixel,
{
    let color = names.iter().enumerate().map(|(i, &name)| {
        let values = film.pixels().iter().map(|pixel| pixel[i]).collect();
        AnyChannel::new(name, FlatSamples::F32(values))
    });
    let others = layers.into_iter().map(|channel| {
        let values = match channel.values {
            Values::Floats(values) => FlatSamples::F32(values),
            Values::Whole(values) => FlatSamples::U32(values),
        };
        AnyChannel::new(&*channel.name, values)
    });
    let layer = Layer::new(
        size(film),
        attributes(place),
        ENCODING,
        AnyChannels::sort(color.chain(others).collect()),
    );
    Image::from_layer(layer).write().to_buffered(to)
}
