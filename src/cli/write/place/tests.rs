//! Tests of `place`.

use super::*;

const PLACE: Place = Place {
    crop: Crop {
        x0: 30,
        y0: 0,
        x1: 61,
        y1: 19,
    },
    whole: [61, 43],
    samples: 16,
    adaptive: true,
    shows: Shows::Colors(Transfer::Linear),
};

#[test]
fn places_are_read_as_they_are_written() {
    let text = PLACE.to_string();
    assert_eq!(text, "30,0,61,19 of 61x43, samples auto:16, linear");
    for (shows, text) in [
        (Shows::Colors(Transfer::Linear), "linear"),
        (Shows::Colors(Transfer::Srgb), "sRGB"),
        (Shows::Albedo(Transfer::Srgb), "sRGB albedo"),
        (Shows::Z(0.001), "z 0.001"),
        (Shows::Aov(AovKind::Normal), "normal"),
    ] {
        let place = PLACE.showing(shows);
        assert_eq!(
            place.to_string(),
            format!("30,0,61,19 of 61x43, samples auto:16, {text}")
        );
        assert_eq!(Place::parse(&place.to_string()), Some(place));
    }
    for wrong in [
        "",
        "30,0,61,19 of 61x43",
        "30,0,61,19 of 61x43, samples 1",
        "30,0,62,19 of 61x43, samples 1, sRGB",
        "30,0,30,19 of 61x43, samples 1, sRGB",
        "30,0,61 of 61x43, samples 1, sRGB",
        "30,0,61,19,5 of 61x43, samples 1, sRGB",
        "30,0,61,19 of 61, samples 1, sRGB",
        "30,0,61,19 of 61x43, samples auto, sRGB",
        "30,0,61,19 of 61x43, samples 1, sky",
        "30,0,61,19 of 61x43, samples 1, z, 1",
    ] {
        assert_eq!(Place::parse(wrong), None, "{wrong}");
    }
}

#[test]
fn any_bytes_are_looked_at() {
    let mut random = fastrand::Rng::new();
    for _ in 0..256 {
        let bytes: Vec<u8> = (0..random.usize(..100)).map(|_| random.u8(..)).collect();
        let length = random.u32(..);
        println!("{bytes:?}, {length}");
        let png = [&length.to_be_bytes()[..], b"tEXtCrop\0", &bytes].concat();
        let exr = [b"octrayCrop\0string\0", &length.to_le_bytes()[..], &bytes].concat();
        for (format, bytes) in [
            (Format::Png, png),
            (Format::Exr, exr),
            (Format::Ppm, bytes.clone()),
            (Format::Qoi, bytes),
        ] {
            assert_eq!(Place::find(format, &bytes, &bytes), None);
        }
    }
}
