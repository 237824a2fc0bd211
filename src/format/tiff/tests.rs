//! Tests of `tiff`.

use super::*;
use image::{ImageFormat, ImageReader};
use std::io::Cursor;

/// A file of one row.
struct Row {
    interpretation: u16,
    channels: u16,
    bits: u16,
    format: u16,
    extra: Option<u16>,
    compression: u16,
    is_big: bool,
    samples: Vec<u8>,
}

impl Row {
    fn new(channels: u16, bits: u16, format: u16, samples: Vec<u8>) -> Self {
        Self {
            interpretation: if channels == 1 { 1 } else { 2 },
            channels,
            bits,
            format,
            extra: (channels == 4).then_some(1),
            compression: 1,
            is_big: false,
            samples,
        }
    }

    fn bytes(&self) -> Vec<u8> {
        let width = self.samples.len() / usize::from(self.channels * self.bits / 8);
        let long = if self.is_big { 8 } else { 4 };
        let number = |value: usize, bytes: usize| value.to_le_bytes()[..bytes].to_vec();
        let head: &[u8] = if self.is_big { b"II+\0\x08\0\0\0" } else { b"II*\0" };
        let (pixels, bits) = (head.len() + long, head.len() + long + self.samples.len());
        let directory = bits + 8;
        let mut bytes = [head, &number(directory, long), &self.samples].concat();
        bytes.extend([self.bits; 4].iter().flat_map(|bits| bits.to_le_bytes()));
        let mut entries = vec![
            (256, 4, 1, width),
            (257, 4, 1, 1),
            (258, 3, usize::from(self.channels), bits),
            (259, 3, 1, self.compression.into()),
            (262, 3, 1, self.interpretation.into()),
            (273, 4, 1, pixels),
            (277, 3, 1, self.channels.into()),
            (278, 4, 1, 1),
            (279, 4, 1, self.samples.len()),
        ];
        entries.extend(self.extra.map(|extra| (338, 3, 1, extra.into())));
        // Only some programs write it for unsigned integers.
        entries.extend((self.format != 1).then_some((339, 3, 1, self.format.into())));
        bytes.extend(number(entries.len(), if self.is_big { 8 } else { 2 }));
        for (tag, kind, count, value) in entries {
            bytes.extend([number(tag, 2), number(kind, 2), number(count, long)].concat());
            let is_inside = tag == 258 && count * 2 <= long;
            let inside = [self.bits; 4].map(u16::to_le_bytes);
            bytes.extend(if is_inside {
                let mut all = inside.as_flattened()[..2 * count].to_vec();
                all.resize(long, 0);
                all
            } else {
                number(value, long)
            });
        }
        bytes.extend(number(0, long));
        bytes
    }

    fn fault(&self) -> String {
        let bytes = self.bytes();
        let found = Tiff::of(&bytes).map(|_| "nothing".to_owned());
        let text = found.unwrap_or_else(|text| text);
        text.trim_end_matches(EXPECTED).to_owned()
    }

    fn straight(&self) -> DynamicImage {
        let bytes = self.bytes();
        let tiff = Tiff::of(&bytes).expect("a kind that is read");
        let picture = ImageReader::with_format(Cursor::new(&bytes), ImageFormat::Tiff).decode();
        tiff.straight(picture.expect("a picture"))
    }
}

#[test]
fn kinds_that_are_not_read_are_named() {
    for is_big in [false, true] {
        let said = |row: Row| Row { is_big, ..row }.fault();
        for (channels, bits, format, found) in [
            (3, 32, 1, "RGB of 32-bit integers"),
            (4, 32, 1, "RGB of 32-bit integers"),
            (3, 16, 2, "RGB of 16-bit signed integers"),
            (3, 16, 3, "RGB of 16-bit floats"),
            (3, 64, 3, "RGB of 64-bit floats"),
            (1, 32, 3, "grey of 32-bit floats"),
            (1, 32, 1, "grey of 32-bit integers"),
        ] {
            let row = Row::new(channels, bits, format, vec![0; 64]);
            assert_eq!(said(row), format!("this is a TIFF with {found}, "));
        }
        let other = |interpretation| Row {
            interpretation,
            ..Row::new(3, 8, 1, vec![0; 6])
        };
        assert_eq!(
            said(other(3)),
            "this is a TIFF with a palette of 0 colours, ",
            "{is_big}"
        );
        assert_eq!(
            said(other(8)),
            "this is a TIFF with Lab colours of 8-bit integers, "
        );
        assert_eq!(
            said(other(1)),
            "this is a TIFF with grey in 3 channels of 8-bit integers, "
        );
        for (bits, format) in [(8, 1), (16, 1), (32, 3)] {
            assert_eq!(said(Row::new(3, bits, format, vec![0; 48])), "nothing");
        }
    }
}

#[test]
fn compression_that_is_not_read_is_named() {
    let row = Row {
        compression: 50000,
        ..Row::new(3, 8, 1, vec![0; 6])
    };
    let bytes = row.bytes();
    let error = ImageReader::with_format(Cursor::new(&bytes), ImageFormat::Tiff).decode();
    let said = Tiff::fault(&bytes, &error.expect_err("not read")).expect("a sentence");
    assert!(said.contains("compressed by Zstandard, expected LZW"), "{said}");
}

#[test]
fn premultiplied_colours_become_straight() {
    // Colours without alpha stay, and none is above white.
    let bytes = Row::new(4, 8, 1, vec![25, 50, 100, 100, 9, 8, 7, 0, 255, 1, 0, 2]);
    let straight = [64, 128, 255, 100, 9, 8, 7, 0, 255, 128, 0, 2];
    assert_eq!(bytes.straight().as_bytes(), straight);
    let words = [1000_u16, 500, 3, 2000].map(u16::to_le_bytes).concat();
    let words = Row::new(4, 16, 1, words);
    let straight = [32768_u16, 16384, 98, 2000];
    assert_eq!(words.straight().into_rgba16().into_raw(), straight);
    let floats = [0.5_f32, 1.0, -2.0, 0.25, 3.0, 2.0, 1.0, 0.0];
    let floats = floats.map(f32::to_le_bytes).concat();
    let straight = [2.0, 4.0, -8.0, 0.25, 3.0, 2.0, 1.0, 0.0];
    for (extra, factor) in [(1, 1.0), (2, 0.25)] {
        let row = Row {
            extra: Some(extra),
            ..Row::new(4, 32, 3, floats.clone())
        };
        let found = row.straight().into_rgba32f().into_raw();
        assert_eq!(found[..3], [0, 1, 2].map(|i| factor * straight[i]));
        assert_eq!(found[3..], straight[3..]);
    }
}

/// Whatever the header says, there is an answer.
#[test]
fn broken_headers_are_left_to_the_decoder() {
    for is_big in [false, true] {
        let row = Row {
            is_big,
            ..Row::new(4, 8, 1, vec![1; 8])
        };
        let bytes = row.bytes();
        for i in 0..bytes.len() {
            let _ = Tiff::of(&bytes[..i]).map(|tiff| tiff.readable(&bytes[..i]).len());
            for value in [0, 3, 0x7f, 0xff] {
                let mut bytes = bytes.clone();
                bytes[i] = value;
                let _ = Tiff::of(&bytes).map(|tiff| tiff.readable(&bytes).len());
            }
        }
    }
    assert!(Tiff::of(b"").is_ok_and(|tiff| !tiff.is_premultiplied));
}
