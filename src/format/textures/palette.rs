//! TIFF images with a palette of 256 colours. Their decoder knows no palettes, so it reads the indices as grey, from a copy of
//! the file that says so.
//!
//! Format: *TIFF Revision 6.0*, Adobe, 1992, "Palette-color Images".

use image::{DynamicImage, Rgb, RgbImage};

/// How pixels are shown (`PhotometricInterpretation`), and the palette (`ColorMap`).
const INTERPRETATION: u16 = 262;
const COLOR_MAP: u16 = 320;
/// Values of the first.
const GREY: u8 = 1;
const PALETTE: u16 = 3;
/// The type of 16-bit numbers.
const SHORT: u16 = 3;
/// All reds, then all greens, then all blues.
const NUMBERS: usize = 3 * 256;

/// The palette of a file.
#[derive(Clone, Copy)]
pub(super) struct Palette {
    colors: [[u8; 3]; 256],
    /// The byte of the file that says that it has one.
    said_at: usize,
}

impl Palette {
    /// The palette of a TIFF file; `None` if its first picture has none of 256 colours.
    pub(super) fn of_tiff(bytes: &[u8]) -> Option<Self> {
        let is_little = bytes.starts_with(b"II*\0");
        if !is_little && !bytes.starts_with(b"MM\0*") {
            return None;
        }
        let short = |at: usize| {
            let [a, b] = *bytes.get(at..)?.first_chunk()?;
            Some(u16::from_le_bytes(if is_little { [a, b] } else { [b, a] }))
        };
        let long = |at: usize| {
            let [a, b] = [short(at)?, short(at.checked_add(2)?)?].map(usize::from);
            Some(if is_little { a | b << 16 } else { a << 16 | b })
        };
        // An entry has a tag, a type, a count, and the numbers or their place.
        let directory = long(4)?;
        let first = directory.checked_add(2)?;
        let entries = (0..usize::from(short(directory)?)).map_while(|i| first.checked_add(12 * i));
        let find = |tag| entries.clone().find(|&at| short(at) == Some(tag));
        let (interpretation, map) = (find(INTERPRETATION)? + 8, find(COLOR_MAP)?);
        let is_read = short(map + 2)? == SHORT && long(map + 4)? == NUMBERS;
        if !is_read || short(interpretation)? != PALETTE {
            return None;
        }
        let at = long(map + 8)?;
        let numbers = (0..NUMBERS).map(|i| short(at.checked_add(2 * i)?));
        let numbers: Vec<u16> = numbers.collect::<Option<_>>()?;
        // Some programs write 8 bits.
        let shift = if numbers.iter().all(|&number| number < 256) {
            0
        } else {
            8
        };
        let color = |i: usize| [i, i + 256, i + 512].map(|i| (numbers[i] >> shift) as u8);
        Some(Self {
            colors: std::array::from_fn(color),
            said_at: interpretation + usize::from(!is_little),
        })
    }

    /// The file with indices that are called grey.
    pub(super) fn as_grey(&self, bytes: &[u8]) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        if let Some(said) = bytes.get_mut(self.said_at) {
            *said = GREY;
        }
        bytes
    }

    /// The colours of indices.
    pub(super) fn colors(&self, indices: DynamicImage) -> DynamicImage {
        let DynamicImage::ImageLuma8(indices) = indices else {
            return indices;
        };
        let color = |x, y| Rgb(self.colors[usize::from(indices.get_pixel(x, y).0[0])]);
        RgbImage::from_fn(indices.width(), indices.height(), color).into()
    }
}
