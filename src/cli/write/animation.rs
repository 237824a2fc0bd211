//! Animations: all frames of a turntable in one file. GIF by the image crate, animated PNG by the png crate, and Y4M, which video
//! encoders read from a pipe: a line of text and the planes of each frame, so no crate is needed.

use super::{
    encode::Format,
    mark::{GIF_END, Y4M_COMMENT},
    output::{Opened, Output},
    palette,
    picture::Picture,
};
use crate::{cli::CliError, render::SOFTWARE};
use image::{
    Delay, DynamicImage, Frame, RgbImage,
    codecs::gif::{GifEncoder, Repeat},
};
use std::{cell::RefCell, io, rc::Rc};

/// How well the gif crate chooses palettes, from 1 (best) to 30 (fastest).
const GIF_SPEED: i32 = 10;

/// Below this number of pixels, octray chooses the palette.
const SMALL_GIF: u64 = 50_000;

/// An animation that is being written, frame by frame. Its file appears when it is finished.
pub struct Animation<'a> {
    output: &'a Output,
    opened: Opened,
    encoder: Encoder,
    written: Buffer,
}

/// What encoders write into: it is moved on after each frame.
#[derive(Clone, Default)]
struct Buffer(Rc<RefCell<Vec<u8>>>);

enum Encoder {
    /// With the number of frames per second and of frames so far.
    Gif(Box<GifEncoder<Buffer>>, u32, u32),
    Png(Box<png::Writer<Buffer>>),
    Y4m,
}

impl io::Write for Buffer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn failed(error: impl std::fmt::Display) -> CliError {
    CliError::Failed(format!("cannot encode the animation: {error}"))
}

impl<'a> Animation<'a> {
    /// Begins an animation of a number of frames, `fps` of them a second.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn begin(
        output: &'a Output,
        size: [u32; 2],
        (frames, fps): (u32, u32),
        has_alpha: bool,
    ) -> Result<Self, CliError> {
        let written = Buffer::default();
        let encoder = match output.format() {
            Format::Gif => {
                let mut encoder = GifEncoder::new_with_speed(written.clone(), GIF_SPEED);
                encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
                Encoder::Gif(Box::new(encoder), fps, 0)
            }
            Format::Apng => {
                let fps = u16::try_from(fps).unwrap_or(u16::MAX);
                let writer = png_writer(written.clone(), size, (frames, fps), has_alpha);
                Encoder::Png(Box::new(writer.map_err(failed)?))
            }
            _ => {
                let [width, height] = size;
                let header = format!("YUV4MPEG2 W{width} H{height} F{fps}:1 Ip A1:1 C444{Y4M_COMMENT}");
                written.0.borrow_mut().extend(header.into_bytes());
                Encoder::Y4m
            }
        };
        let opened = output.open()?;
        Ok(Self {
            output,
            opened,
            encoder,
            written,
        })
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn add(&mut self, picture: &Picture) -> Result<(), CliError> {
        let [width, height] = picture.size();
        let bytes = picture.bytes();
        match &mut self.encoder {
            Encoder::Gif(encoder, fps, count) => {
                let mut bytes = bytes.into_owned();
                if u64::from(width) * u64::from(height) < SMALL_GIF {
                    palette::reduce(&mut bytes);
                }
                let image = RgbImage::from_raw(width, height, bytes);
                let image = image.ok_or_else(|| failed("a frame has another size"))?;
                let image = DynamicImage::from(image).into_rgba8();
                let delay = Delay::from_numer_denom_ms(10 * hundredths(*count, *fps), 1);
                encoder
                    .encode_frame(Frame::from_parts(image, 0, 0, delay))
                    .map_err(failed)?;
                *count += 1;
            }
            Encoder::Png(writer) => writer.write_image_data(&bytes).map_err(failed)?,
            Encoder::Y4m => add_y4m(&bytes, &mut self.written.0.borrow_mut()),
        }
        self.move_on()
    }

    /// Ends the animation.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn finish(mut self) -> Result<(), CliError> {
        match std::mem::replace(&mut self.encoder, Encoder::Y4m) {
            Encoder::Gif(encoder, ..) => {
                // Its last byte is written when it is dropped: the end, which the mark has, too.
                drop(encoder);
                let mut written = self.written.0.borrow_mut();
                written.pop();
                written.extend(GIF_END);
            }
            Encoder::Png(writer) => writer.finish().map_err(failed)?,
            Encoder::Y4m => {}
        }
        self.move_on()?;
        self.output.close(self.opened)
    }

    fn move_on(&mut self) -> Result<(), CliError> {
        let bytes = std::mem::take(&mut *self.written.0.borrow_mut());
        self.output.append(&mut self.opened, &bytes)
    }
}

/// How long a frame of a GIF is shown, in hundredths of a second, the format's unit: rounded so that the whole animation has the
/// right length.
fn hundredths(frame: u32, fps: u32) -> u32 {
    let end = |frame: u32| (frame * 100 + fps / 2) / fps;
    end(frame + 1) - end(frame)
}

fn png_writer(
    to: Buffer,
    [width, height]: [u32; 2],
    (frames, fps): (u32, u16),
    has_alpha: bool,
) -> Result<png::Writer<Buffer>, png::EncodingError> {
    let mut encoder = png::Encoder::new(to, width, height);
    encoder.set_color(if has_alpha {
        png::ColorType::Rgba
    } else {
        png::ColorType::Rgb
    });
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Paeth);
    encoder.add_text_chunk("Software".into(), SOFTWARE.into())?;
    encoder.set_animated(frames, 0)?;
    encoder.set_frame_delay(1, fps)?;
    encoder.write_header()
}

/// A frame in Y'CbCr by BT.601 with 16 to 235 and 240, as readers assume without a word about it; not subsampled.
fn add_y4m(rgb: &[u8], to: &mut Vec<u8>) {
    to.extend(b"FRAME\n");
    let (pixels, _) = rgb.as_chunks::<3>();
    for (weights, base) in [
        ([65.481, 128.553, 24.966], 16.0),
        ([-37.797, -74.203, 112.0], 128.0),
        ([112.0, -93.786, -18.214], 128.0),
    ] {
        to.extend(pixels.iter().map(|pixel| {
            let parts = pixel
                .iter()
                .zip(weights)
                .map(|(&channel, weight): (_, f32)| f32::from(channel) * weight);
            (base + parts.sum::<f32>() / 255.0).round() as u8
        }));
    }
}

#[cfg(test)]
mod tests;
