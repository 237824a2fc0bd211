//! Tests of `picture`.

use super::*;

/// Pixels that show nothing have the colour's bytes, and opaque ones are unchanged.
#[test]
fn a_colour_behind_keeps_its_bytes() {
    for transfer in [Transfer::Linear, Transfer::Srgb] {
        for byte in 0..=255 {
            let color = linear(transfer, [byte; 3]);
            let mut film = Film::<[f32; 4]>::black(3, 1);
            film.pixels_mut().copy_from_slice(&[
                [0.0; 4],
                [0.25, 0.5, 1.0, 1.0],
                [0.1, 0.0, 0.0, 1.0 + 1e-6],
            ]);
            let whole = in_front_of(color, &film).expect("memory for three pixels");
            let bytes = whole.to_bytes(transfer);
            assert_eq!(bytes[..3], [byte; 3], "{transfer:?}");
            let opaque = Film::<[f32; 4]>::to_bytes(&film, transfer);
            assert_eq!(bytes[3..6], opaque[4..7]);
            assert_eq!(whole.pixels()[2], [0.1, 0.0, 0.0]);
        }
    }
}

#[test]
fn backdrops_are_read() {
    for (text, expected) in [
        ("scene", Some(Backdrop::Scene)),
        ("transparent", Some(Backdrop::Transparent)),
        ("white", Some(Backdrop::Color([255; 3]))),
        ("336699", Some(Backdrop::Color([0x33, 0x66, 0x99]))),
        ("#0aF0b1", Some(Backdrop::Color([0x0a, 0xf0, 0xb1]))),
        ("", None),
        ("#", None),
        ("fff", None),
        ("+12345", None),
        ("33669\u{e9}", None),
    ] {
        assert_eq!(text.parse().ok(), expected, "{text}");
    }
}
