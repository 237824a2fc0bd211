//! Tests of `compare`.

use super::*;

#[test]
fn a_pixel_counts_once_and_beyond_the_tolerance() {
    let levels = [
        [2.0, 2.5, 0.0, 0.0],
        [2.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 9.0],
        [0.0; 4],
    ];
    let figures = Figures::new(4, false, 2.0, |i| levels[i]);
    assert_eq!((figures.pixels, figures.differing, figures.largest), (4, 2, 9.0));
    assert_eq!(figures.mean, 15.5 / 16.0);
    assert_eq!(Figures::new(2, true, 2.0, |i| levels[i]).mean, 6.5 / 6.0);
}

#[test]
fn nan_differs() {
    let figures = Figures::new(1, true, 255.0, |_| distances([f32::NAN; 4], [0.0; 4]));
    assert_eq!(figures.differing, 1);
}

#[test]
fn hidden_colours_are_equal() {
    let (white, black) = ([255.0, 255.0, 255.0, 0.0], [0.0; 4]);
    assert_eq!(seen_distances(white, black, false), [0.0; 4]);
    let faint = [0.0, 0.0, 0.0, 1.0];
    assert_eq!(seen_distances(white, faint, false), [255.0, 255.0, 255.0, 1.0]);
    assert_eq!(seen_distances(white, black, true), distances(white, black));
}
