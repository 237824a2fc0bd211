use crate::format::{budget::Budget, environment::decode};
use std::path::Path;

/// A picture of the grey values 1 to 6 of 128, in the order of the file.
fn decoded(head: &str, size: &str) -> Result<([u32; 2], Vec<u8>), String> {
    let mut file = format!("{head}\n\n{size}\n").into_bytes();
    file.extend((1..=6).flat_map(|value| [value, value + 1, value, 128]));
    let decoded = decode(&file, Path::new("a"), &Budget::unlimited());
    let (size, texels) = decoded.map_err(|reason| reason.message)?;
    Ok((
        size,
        texels.iter().map(|texel| (texel[0] * 256.0) as u8).collect(),
    ))
}

#[test]
fn heads_and_orientations() {
    for head in [
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe",
        "#?RGBE\n# a comment\nFORMAT=32-bit_rle_rgbe\n\tEXPOSURE=2",
        "#?RGBE",
    ] {
        for (line, size, expected) in [
            ("-Y 2 +X 3", [3, 2], [1, 2, 3, 4, 5, 6]),
            ("-Y 2 -X 3", [3, 2], [3, 2, 1, 6, 5, 4]),
            ("+Y 2 +X 3", [3, 2], [4, 5, 6, 1, 2, 3]),
            ("+Y 2 -X 3", [3, 2], [6, 5, 4, 3, 2, 1]),
            ("+X 3 -Y 2", [3, 2], [1, 3, 5, 2, 4, 6]),
            ("+X 3 +Y 2", [3, 2], [2, 4, 6, 1, 3, 5]),
            ("-X 3 -Y 2", [3, 2], [5, 3, 1, 6, 4, 2]),
            ("-X 3 +Y 2", [3, 2], [6, 4, 2, 5, 3, 1]),
        ] {
            let found = decoded(head, line).expect("a picture");
            assert_eq!(found, (size, expected.to_vec()), "{head} {line}");
        }
    }
}

/// The values are those before it; lines that begin with a tab are about other pictures.
#[test]
fn exposure_is_divided_out() {
    let head = "#?RADIANCE\nEXPOSURE= 0.5\nEXPOSURE=0.5\nCOLORCORR=0.5 8 1\n\tEXPOSURE=7";
    for end in ["\n", "\r\n"] {
        let head = format!("{head}\n\n-Y 1 +X 1\n").replace('\n', end);
        let file = [head.as_bytes(), &[16, 16, 16, 128]].concat();
        let (_, texels) = decode(&file, Path::new("a"), &Budget::unlimited()).expect("a picture");
        assert_eq!(texels, [[0.5, 0.03125, 0.25]]);
    }
}

#[test]
fn what_is_not_read_is_said() {
    let size = "-Y 2 +X 3";
    for (head, size, expected) in [
        (
            "#?RADIANCE\nFORMAT=32-bit_rle_xyze",
            size,
            "its colours are XYZ, expected RGB; Radiance's `ra_xyze -r` converts it",
        ),
        (
            "#?RGBE\nFORMAT=spectral",
            size,
            "its format is `spectral`, expected `32-bit_rle_rgbe`",
        ),
        (
            "#?PICTURE",
            size,
            "it begins neither with `#?RADIANCE` nor with `#?RGBE`",
        ),
        (
            "#?RGBE\nEXPOSURE=0",
            size,
            "its EXPOSURE is `0`, expected a number above 0",
        ),
        (
            "#?RGBE\nCOLORCORR=1 nan 1",
            size,
            "its COLORCORR is `1 nan 1`, expected three numbers above 0",
        ),
        (
            "#?RGBE\nEXPOSURE=1e38\nEXPOSURE=1e38",
            size,
            "its EXPOSURE and COLORCORR multiply to a number that is too small or too large",
        ),
        (
            "#?RGBE",
            "-Y 2 +Y 3",
            "the line of its size is `-Y 2 +Y 3`, expected for example `-Y 512 +X 1024`",
        ),
        (
            "#?RGBE",
            "-Y 0 +X 3",
            "it has 3x0 pixels, expected 1x1 to 16384x16384",
        ),
    ] {
        assert_eq!(decoded(head, size).expect_err("refused"), expected);
    }
    let endless = decode(b"#?RGBE\nEXPOSURE=1\n", Path::new("a"), &Budget::unlimited());
    let expected = "its header has no end within 65536 bytes";
    assert_eq!(endless.expect_err("refused").message, expected);
}
