//! Tests of `overlay`.

use super::*;

#[test]
fn text_has_twelve_points_where_it_fits() {
    // Pixels of a letter of messages and of the help, on usual and on high-resolution screens.
    for (scale_factor, size, pixels) in [
        (1.0, [512, 512], [16, 16]),
        (1.0, [3840, 2160], [16, 16]),
        (1.25, [800, 800], [24, 24]),
        (1.5, [1000, 900], [24, 24]),
        (2.0, [1100, 1000], [32, 32]),
        (3.0, [3840, 2160], [48, 48]),
        // Too small for large letters.
        (1.0, [768, 432], [16, 8]),
        (2.0, [512, 512], [16, 16]),
        (3.0, [512, 512], [24, 16]),
        (1.0, [200, 150], [8, 8]),
        (3.0, [200, 150], [24, 8]),
        (0.5, [200, 150], [8, 8]),
    ] {
        let found = [text_scale(size, scale_factor), help_scale(size, scale_factor)].map(|scale| 8 * scale);
        assert_eq!(found, pixels, "{scale_factor} {size:?}");
    }
}

#[test]
fn the_help_and_a_message_fit_into_the_default_window() {
    let mut pixels = vec![0x00ff_ffff; 512 * 512];
    let mut canvas = Canvas {
        pixels: &mut pixels,
        width: 512,
        height: 512,
    };
    let overlay = Overlay {
        help: true,
        message: Some("a message of thirty letters..."),
        ..Overlay::default()
    };
    draw(&mut canvas, 1.0, &overlay);
    let white = pixels.chunks(512).rev().position(|row| row[300] != 0x00ff_ffff);
    assert!(white.is_some_and(|rows| rows < 8), "{white:?}");
}
