//! Tests of `screen`.

use super::*;

#[test]
fn pictures_are_enlarged() {
    let mut film = ByteFilm::black(2, 1);
    film.pixels_mut()[0] = [1, 2, 3];
    film.pixels_mut()[1] = [255, 0, 16];
    let mut pixels = Vec::new();
    spread(&film, [2, 1], &mut pixels);
    assert_eq!(pixels, [0x01_0203, 0xff_0010]);
    spread(&film, [4, 2], &mut pixels);
    assert_eq!(pixels[..4], [0x01_0203, 0x01_0203, 0xff_0010, 0xff_0010]);
    assert_eq!(pixels[..4], pixels[4..]);
}

#[test]
fn text_stays_in_the_picture() {
    for [width, height] in [[1, 1], [5, 40], [300, 20]] {
        let mut pixels = vec![0x00ff_ffff; (width * height) as usize];
        let mut canvas = Canvas {
            pixels: &mut pixels,
            width,
            height,
        };
        let lines = ["a long line with \u{e4} and \u{1f600}".to_owned(), "x".repeat(99)];
        let below = panel(&mut canvas, [2, 2], &lines, 0x00ff_0000, 2);
        assert!(below <= height as usize);
        panel(&mut canvas, [0, below], &lines, 0, 1);
    }
}

#[test]
fn long_lines_are_wrapped() {
    assert_eq!(wrap("0123456789\n\nab", 8), ["01234567", "89", "", "ab"]);
    let text = "beside it: cow";
    assert_eq!(wrap(text, 10), ["beside it:", "cow"]);
    assert_eq!(wrap(text, 9), ["beside", "it: cow"]);
    assert_eq!(wrap(text, 14), [text]);
    // A word that begins early is cut rather than leave most of a line empty.
    assert_eq!(wrap("ab 0123456789", 8), ["ab 01234", "56789"]);
}
