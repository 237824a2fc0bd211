//! EXR files with more channels than colours, which the image crate does not write.

use crate::render::{Film, Pixel};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};
use std::io::Cursor;

/// A channel by its full name, such as `normal.X`, row by row.
pub struct Channel {
    pub name: &'static str,
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
/// What the exr crate says.
pub fn write<const N: usize>(
    film: &Film<[f32; N]>,
    names: [&'static str; N],
    layers: &[Channel],
    to: &mut Cursor<Vec<u8>>,
) -> exr::error::UnitResult
where
    [f32; N]: Pixel,
{
    let color = names.iter().enumerate().map(|(i, &name)| {
        let values = film.pixels().iter().map(|pixel| pixel[i]).collect();
        AnyChannel::new(name, FlatSamples::F32(values))
    });
    let others = layers.iter().map(|channel| {
        let values = match &channel.values {
            Values::Floats(values) => FlatSamples::F32(values.clone()),
            Values::Whole(values) => FlatSamples::U32(values.clone()),
        };
        AnyChannel::new(channel.name, values)
    });
    let layer = Layer::new(
        (film.width() as usize, film.height() as usize),
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(color.chain(others).collect()),
    );
    Image::from_layer(layer).write().to_buffered(to)
}
