use super::*;

/// The area of a tile whose pixels have these grey values as their mean of four samples.
fn neighborhood(tile: TileRect, [width, height]: [u32; 2], grey: impl Fn([u32; 2]) -> f32) -> Neighborhood {
    let settings = Settings {
        width,
        height,
        ..Settings::default()
    };
    let mut neighborhood = Neighborhood::default();
    for pixel in neighborhood.restart(tile, &settings, 4).each_pixel() {
        let sum = [0.0, grey(pixel) * 4.0, 0.0, 4.0];
        let samples = Samples {
            sum,
            count: 4,
            ..Samples::default()
        };
        neighborhood.set(pixel, samples);
    }
    neighborhood.compare();
    neighborhood
}

fn differs(neighborhood: &Neighborhood, pixel: [u32; 2]) -> bool {
    neighborhood.contrast[neighborhood.index(pixel)] > MAX_CONTRAST
}

#[test]
fn a_step_is_seen_from_all_sides_and_only_there() {
    let size = [20, 9];
    let tiles = [
        [0, 0, 20, 9],
        [3, 2, 5, 4],
        [6, 4, 1, 1],
        [12, 5, 8, 4],
        [0, 8, 20, 1],
    ];
    for [x, y, width, height] in tiles {
        let tile = TileRect { x, y, width, height };
        for step in [[6, 4], [0, 0], [19, 8], [2, 1], [11, 4]] {
            let picture =
                |value: f32| neighborhood(tile, size, move |pixel| if pixel == step { value } else { 0.25 });
            // Squares of 0.5 and a little more or less than 8 levels of 255.
            for (value, is_seen) in [(0.2826, true), (0.2810, false), (0.2157, true), (0.2200, false)] {
                let neighborhood = picture(value);
                for pixel in tile.each_pixel() {
                    let is_near = (0..2).all(|i| pixel[i].abs_diff(step[i]) <= 1);
                    assert_eq!(
                        differs(&neighborhood, pixel),
                        is_near && is_seen,
                        "{pixel:?} {step:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn what_a_screen_cannot_show_is_no_difference() {
    let tile = TileRect {
        x: 1,
        y: 1,
        width: 3,
        height: 3,
    };
    for (a, b, differ) in [(1.0, 9.0, false), (0.0, -3.0, false), (0.0, 0.01, true)] {
        let neighborhood = neighborhood(tile, [5, 5], |[x, _]| if x == 2 { a } else { b });
        assert_eq!(differs(&neighborhood, [2, 2]), differ, "{a} {b}");
    }
}
