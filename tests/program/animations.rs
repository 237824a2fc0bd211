//! Animations: all frames of a turntable in one file.

use crate::program::{Folder, shipped_mesh};
use image::{
    AnimationDecoder, ImageResult, RgbImage,
    codecs::{gif::GifDecoder, png::PngDecoder},
};
use std::{fs, io::Cursor};

const SMALL: &str = "--size=24x16";

fn frames<'a>(decoder: impl AnimationDecoder<'a>) -> Vec<RgbImage> {
    let frames: ImageResult<Vec<_>> = decoder.into_frames().collect();
    let frames = frames.expect("frames");
    let rgb = |frame: image::Frame| image::DynamicImage::from(frame.into_buffer()).into_rgb8();
    frames.into_iter().map(rgb).collect()
}

/// The pictures of the frames, one file each.
fn pictures(folder: &Folder, options: &[&str]) -> Vec<RgbImage> {
    let arguments = [&["a.scn", SMALL, "--turntable=5", "-o", "p#.png"], options].concat();
    folder.run(&arguments).succeeded();
    let pictures = (1..=5).map(|i| {
        image::open(folder.path(&format!("p{i}.png")))
            .expect("a picture")
            .into_rgb8()
    });
    pictures.collect()
}

fn largest_difference(a: &RgbImage, b: &RgbImage) -> u8 {
    assert_eq!(a.dimensions(), b.dimensions());
    let pairs = a.as_raw().iter().zip(b.as_raw());
    pairs.map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

#[test]
fn animations_have_the_frames_of_the_turntable() {
    let folder = Folder::new();
    let expected = pictures(&folder, &["--srgb"]);
    for name in ["f.gif", "f.apng", "f.y4m"] {
        let run = folder.run(&["a.scn", SMALL, "--srgb", "--turntable=5", "--fps=10", "-o", name]);
        run.succeeded();
    }
    let bytes = fs::read(folder.path("f.apng")).expect("an animation");
    let decoder = PngDecoder::new(Cursor::new(&bytes)).expect("PNG");
    assert!(decoder.is_apng().expect("PNG"));
    assert_eq!(frames(decoder.apng().expect("an animation")), expected);
    let decoder =
        GifDecoder::new(Cursor::new(fs::read(folder.path("f.gif")).expect("an animation"))).expect("GIF");
    let found = frames(decoder);
    assert_eq!(found.len(), 5);
    for (found, expected) in found.iter().zip(&expected) {
        // A palette of 256 colours.
        assert!(largest_difference(found, expected) <= 24);
    }
    let bytes = fs::read(folder.path("f.y4m")).expect("an animation");
    let header = b"YUV4MPEG2 W24 H16 F10:1 Ip A1:1 C444 Xoctray\n";
    assert!(bytes.starts_with(header));
    let frame = "FRAME\n".len() + 3 * 24 * 16;
    assert_eq!(bytes.len(), header.len() + 5 * frame);
    for (i, expected) in expected.iter().enumerate() {
        let luma = &bytes[header.len() + i * frame + "FRAME\n".len()..][..24 * 16];
        for (&luma, pixel) in luma.iter().zip(expected.pixels()) {
            let [r, g, b] = pixel.0.map(f32::from);
            let expected = 16.0 + (65.481 * r + 128.553 * g + 24.966 * b) / 255.0;
            assert!((f32::from(luma) - expected).abs() < 0.6);
        }
    }
    // In a pipe it is Y4M.
    let run = folder.run(&["a.scn", SMALL, "--srgb", "--turntable=5", "--fps=10", "-o", "-"]);
    assert_eq!(run.succeeded().stdout, bytes);
}

/// GIF's palette is chosen from all pixels of a small picture.
#[test]
fn small_gifs_keep_colours() {
    let folder = Folder::new();
    let vase = shipped_mesh("vase.obj");
    for output in ["f.gif", "p#.png"] {
        let call = [&vase, "--turntable=7", "--size=41x33", "-o", output];
        folder.run(&call).succeeded();
    }
    let bytes = fs::read(folder.path("f.gif")).expect("an animation");
    let found = frames(GifDecoder::new(Cursor::new(bytes)).expect("GIF"));
    for (i, found) in found.iter().enumerate() {
        let picture = image::open(folder.path(&format!("p{}.png", i + 1))).expect("a picture");
        let difference = largest_difference(found, &picture.into_rgb8());
        assert!(difference <= 2, "{i}: {difference}");
    }
    assert_eq!(found.len(), 7);
}

#[test]
fn a_part_of_a_turntable_is_a_film_with_alpha() {
    let folder = Folder::new();
    let arguments = [
        "a.scn",
        SMALL,
        "--turntable=4",
        "--frames=2-3",
        "--background=transparent",
        "-o",
    ];
    folder.run(&[&arguments[..], &["f.apng"]].concat()).succeeded();
    let bytes = fs::read(folder.path("f.apng")).expect("an animation");
    let decoder = PngDecoder::new(Cursor::new(&bytes)).expect("PNG");
    let found = decoder
        .apng()
        .expect("an animation")
        .into_frames()
        .collect::<ImageResult<Vec<_>>>();
    let found = found.expect("frames");
    folder.run(&[&arguments[..], &["p#.png"]].concat()).succeeded();
    for (frame, number) in found.iter().zip(2..) {
        let picture = image::open(folder.path(&format!("p{number}.png"))).expect("a picture");
        assert!(*frame.buffer() == picture.into_rgba8(), "{number}");
    }
    assert_eq!(found.len(), 2);
    // It exists.
    folder
        .run(&[&arguments[..], &["f.apng", "--skip-existing"]].concat())
        .succeeded();
    assert_eq!(fs::read(folder.path("f.apng")).expect("an animation"), bytes);
}

#[test]
fn what_animations_cannot_be_is_refused() {
    let folder = Folder::new();
    for (options, expected) in [
        ("-o f.gif", "--turntable"),
        ("-o f.y4m --turntable 3 --aov depth", "AOV"),
        ("-o f-##.gif --turntable 3", "leave out the #"),
        ("-o f.gif --turntable 3 --compare a.png", "not compared"),
        ("-o f.gif --turntable 3 --background transparent", ".apng"),
        ("-o f.gif --turntable 3 --fps 0", "0"),
        ("-o f.png --fps 3", "--turntable"),
        ("a.scn -o f.gif --turntable 3", "two pictures"),
    ] {
        let mut arguments = vec!["a.scn"];
        arguments.extend(options.split(' '));
        folder.fails(&arguments, 2, expected);
    }
    assert_eq!(folder.names(), ["a.scn"]);
}
