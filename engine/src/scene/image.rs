//! Texture images: bytes with mipmaps, and their lookup.

use crate::{error::SceneError, math::srgb};
use std::sync::OnceLock;

/// The largest width and height of an image, pixels.
pub const MAX_IMAGE_SIDE: u32 = 1 << 14;

/// The least number of texels of a level that threads share.
const WORTH_THREADS: usize = 1 << 16;

/// The meaning of an image's bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curve {
    /// Values used unchanged: a byte divided by 255.
    #[default]
    Display,
    /// Encoded by the sRGB curve.
    Srgb,
}

/// An RGBA image with mipmaps: each level has half the width and height of the one before, down to one texel.
#[derive(Clone, Debug)]
pub struct Image {
    levels: Vec<Level>,
    curve: Curve,
    has_alpha: bool,
    has_numbers: bool,
}

/// A texel and its weight.
type Weighted = (u64, [u8; 4]);

/// How texels become one of the next level.
#[derive(Clone, Copy)]
struct Means {
    of_four: fn([[u8; 4]; 4]) -> [u8; 4],
    weighted: fn(&[Weighted]) -> [u8; 4],
}

#[derive(Clone, Debug)]
struct Level {
    width: usize,
    height: usize,
    /// Rows from the top.
    texels: Vec<[u8; 4]>,
}

/// The wrap mode beyond an image's edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The image repeats.
    #[default]
    Repeat,
    /// The image repeats, every other time mirrored.
    Mirror,
    /// The texels of the edge.
    Clamp,
}

/// An image as a surface shows it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Texture {
    /// Index into [`Scene::images`](crate::scene::Scene::images).
    pub image: u32,
    /// Beyond the left and right edges, and beyond the upper and lower ones.
    pub wrap: [Wrap; 2],
    /// Whether magnified texels are squares instead of interpolated.
    pub nearest: bool,
}

impl Image {
    /// Makes an image of its pixels, rows from the top, and computes the mipmaps: means of the linear light of 2x2 texels, or
    /// of three columns or rows where a side is odd, weighted by alpha.
    ///
    /// # Errors
    /// [`SceneError::ImageSize`] if a side is 0 or above [`MAX_IMAGE_SIDE`], [`SceneError::ArrayLength`] or
    /// [`SceneError::NoMemory`].
    pub fn new(size: [u32; 2], pixels: Vec<[u8; 4]>) -> Result<Self, SceneError> {
        Self::with_mipmaps(size, pixels, Means::OF_COLORS)
    }

    /// Makes an image whose bytes are no colours, as those of a [`NormalMap`](super::NormalMap): mipmaps are means of the
    /// bytes, and no curve changes them.
    ///
    /// # Errors
    /// As [`Image::new`].
    pub fn of_numbers(size: [u32; 2], pixels: Vec<[u8; 4]>) -> Result<Self, SceneError> {
        let mut image = Self::with_mipmaps(size, pixels, Means::OF_NUMBERS)?;
        image.has_numbers = true;
        Ok(image)
    }

    fn with_mipmaps(
        [width, height]: [u32; 2],
        pixels: Vec<[u8; 4]>,
        means: Means,
    ) -> Result<Self, SceneError> {
        if ![width, height]
            .iter()
            .all(|side| (1..=MAX_IMAGE_SIDE).contains(side))
        {
            let most = MAX_IMAGE_SIDE;
            return Err(SceneError::ImageSize { width, height, most });
        }
        let (width, height) = (width as usize, height as usize);
        super::builder::expect_length("pixels", pixels.len(), width * height)?;
        let has_alpha = pixels.iter().any(|texel| texel[3] != u8::MAX);
        let mut levels = vec![Level {
            width,
            height,
            texels: pixels,
        }];
        while let Some(last) = levels.last().filter(|level| level.width * level.height > 1) {
            levels.push(last.half(means)?);
        }
        Ok(Self {
            levels,
            curve: Curve::Display,
            has_alpha,
            has_numbers: false,
        })
    }

    /// Returns the means of the bytes of red, green, blue and alpha over all pixels, rounded.
    #[must_use]
    pub fn mean(&self) -> [u8; 4] {
        let texels = &self.levels[0].texels;
        let sums = texels.iter().fold([0_u64; 4], |sums, texel| {
            std::array::from_fn(|channel| sums[channel] + u64::from(texel[channel]))
        });
        let count = texels.len() as u64;
        sums.map(|sum| ((sum + count / 2) / count) as u8)
    }

    /// Returns width and height, pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        let level = &self.levels[0];
        [level.width as u32, level.height as u32]
    }

    /// Returns whether any pixel is not opaque.
    #[must_use]
    pub fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    /// Returns the memory of an image of this size with its mipmaps, bytes.
    #[must_use]
    pub fn bytes([width, height]: [u32; 2]) -> usize {
        (width as usize * height as usize).saturating_mul(16) / 3 + 64
    }

    /// Returns whether the image was made by [`Image::of_numbers`].
    #[must_use]
    pub fn has_numbers(&self) -> bool {
        self.has_numbers
    }

    /// Sets the meaning of the bytes. Numbers stay what they are.
    pub fn set_curve(&mut self, curve: Curve) {
        if !self.has_numbers {
            self.curve = curve;
        }
    }

    /// Returns red, green, blue and alpha at texture coordinates, filtered trilinearly. `lod` is the binary logarithm of the
    /// footprint's size in texels of the first level.
    #[must_use]
    pub(super) fn color(&self, texture: Texture, uv: [f32; 2], lod: f32) -> [f32; 4] {
        let last = self.levels.len() - 1;
        // A NaN becomes 0.
        let lod = lod.max(0.0).min(last as f32);
        let (below, share) = (lod as usize, lod - lod.floor());
        if texture.nearest && lod == 0.0 {
            return self.nearest(texture, uv);
        }
        let first = self.bilinear(texture, uv, below);
        if share == 0.0 {
            return first;
        }
        let second = self.bilinear(texture, uv, below + 1);
        std::array::from_fn(|i| first[i] + (second[i] - first[i]) * share)
    }

    fn nearest(&self, texture: Texture, uv: [f32; 2]) -> [f32; 4] {
        let level = &self.levels[0];
        let [x, _] = position(uv[0], level.width, texture.wrap[0]);
        let [y, _] = position(uv[1], level.height, texture.wrap[1]);
        let column = wrapped((x + 0.5).floor(), level.width, texture.wrap[0]);
        let row = wrapped((y + 0.5).floor(), level.height, texture.wrap[1]);
        self.texel(level, column, row)
    }

    fn bilinear(&self, texture: Texture, uv: [f32; 2], level: usize) -> [f32; 4] {
        let level = &self.levels[level.min(self.levels.len() - 1)];
        let [x, across] = position(uv[0], level.width, texture.wrap[0]);
        let [y, down] = position(uv[1], level.height, texture.wrap[1]);
        let columns = [0.0, 1.0].map(|step| wrapped(x.floor() + step, level.width, texture.wrap[0]));
        let rows = [0.0, 1.0].map(|step| wrapped(y.floor() + step, level.height, texture.wrap[1]));
        let [upper, lower] = rows.map(|row| {
            let [left, right] = columns.map(|column| self.texel(level, column, row));
            std::array::from_fn::<f32, 4, _>(|i| left[i] + (right[i] - left[i]) * across)
        });
        std::array::from_fn(|i| upper[i] + (lower[i] - upper[i]) * down)
    }

    fn texel(&self, level: &Level, column: usize, row: usize) -> [f32; 4] {
        let [r, g, b, a] = level.texels[row * level.width + column];
        let color = |byte: u8| match self.curve {
            Curve::Display => f32::from(byte) / 255.0,
            Curve::Srgb => light()[usize::from(byte)],
        };
        [color(r), color(g), color(b), f32::from(a) / 255.0]
    }
}

/// Returns the position of a texture coordinate among the centres of `count` texels, and its fraction.
fn position(coordinate: f32, count: usize, wrap: Wrap) -> [f32; 2] {
    let within = match wrap {
        Wrap::Repeat => coordinate - coordinate.floor(),
        Wrap::Mirror => {
            let pair = coordinate * 0.5;
            let pair = (pair - pair.floor()) * 2.0;
            if pair > 1.0 { 2.0 - pair } else { pair }
        }
        Wrap::Clamp => coordinate.clamp(0.0, 1.0),
    };
    let at = within * count as f32 - 0.5;
    [at, at - at.floor()]
}

/// Returns a texel's index, which may be one beyond either edge.
fn wrapped(index: f32, count: usize, wrap: Wrap) -> usize {
    let (index, count) = (index as isize, count as isize);
    let within = match wrap {
        Wrap::Repeat => index.rem_euclid(count),
        Wrap::Mirror | Wrap::Clamp => index.clamp(0, count - 1),
    };
    within as usize
}

/// The light of each byte by the sRGB curve.
fn light() -> &'static [f32; 256] {
    static LIGHT: OnceLock<[f32; 256]> = OnceLock::new();
    LIGHT.get_or_init(|| std::array::from_fn(|byte| srgb::decode(byte as f64 / 255.0) as f32))
}

/// The light of each byte in 65535ths.
fn whole_light() -> &'static [u32; 256] {
    static LIGHT: OnceLock<[u32; 256]> = OnceLock::new();
    LIGHT.get_or_init(|| std::array::from_fn(|byte| (light()[byte] * 65535.0 + 0.5) as u32))
}

/// Step of the table of display values, in 65535ths of light: less than half the step between dark bytes.
const STEP: u32 = 8;

/// The display byte of light in 65535ths.
fn display(light: u32) -> u8 {
    static DISPLAY: OnceLock<Vec<u8>> = OnceLock::new();
    let table = DISPLAY.get_or_init(|| {
        let byte = |step: u32| {
            let middle = f64::from(step * STEP + STEP / 2) / 65535.0;
            (srgb::encode(middle.min(1.0)) * 255.0 + 0.5) as u8
        };
        (0..=65535 / STEP).map(byte).collect()
    });
    table[(light / STEP).min(65535 / STEP) as usize]
}

mod mipmaps;
#[cfg(test)]
mod tests;
