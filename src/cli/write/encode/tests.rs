//! Tests of `encode`.

use super::*;

/// The tags of a little-endian TIFF file: number, how many values, and their offset or the only value.
fn tags(file: &[u8]) -> Vec<(u16, u32, usize)> {
    let whole = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
    let half = |at: usize| u16::from_le_bytes(file[at..at + 2].try_into().unwrap());
    let directory = whole(4) as usize;
    assert_eq!(directory % 2, 0, "the directory");
    let places = (0..usize::from(half(directory))).map(|i| directory + 2 + 12 * i);
    let tags = places.map(|at| {
        let bytes = match half(at + 2) {
            1 | 2 => 1,
            3 => 2,
            4 => 4,
            _ => 8,
        };
        let count = whole(at + 4);
        let value = whole(at + 8) as usize;
        assert!(count * bytes <= 4 || value.is_multiple_of(2), "tag {}", half(at));
        (half(at), count, value)
    });
    tags.collect()
}

#[test]
fn tiff_says_what_alpha_is_and_has_even_offsets() {
    // The last has two strips.
    for (size, channels) in [
        ([1, 1], 3),
        ([3, 3], 3),
        ([5, 1], 4),
        ([2, 2], 3),
        ([601, 601], 3),
    ] {
        let bytes: Vec<u8> = (0..size[0] as usize * size[1] as usize * channels)
            .map(|i| i as u8)
            .collect();
        let file = Format::Tiff.encode_whole(&bytes, size, channels).unwrap();
        let tags = tags(&file);
        let alpha = tags.iter().find(|tag| tag.0 == 338);
        let expected = (channels == 4).then_some(&(338, 1, 2));
        assert_eq!(alpha, expected, "{size:?}");
        let read = image::load_from_memory_with_format(&file, ImageFormat::Tiff).unwrap();
        assert_eq!(read.as_bytes(), bytes, "{size:?}");
    }
}
