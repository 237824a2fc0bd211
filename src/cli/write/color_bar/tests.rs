use super::*;

fn bar(range: [f64; 2], size: [u32; 2]) -> ColorBar<'static> {
    ColorBar {
        name: "a name that has many more letters than the picture has room for",
        map: ColorMap::default(),
        range,
        size,
    }
}

#[test]
fn numbers_have_the_digits_of_their_step() {
    for (range, expected) in [
        ([0.0, 1.0], ["0", "0.25", "0.50", "0.75", "1.00"]),
        ([0.0, 5.0], ["0", "1.25", "2.50", "3.75", "5.00"]),
        ([0.0, 50.0], ["0", "12.5", "25.0", "37.5", "50.0"]),
        ([-200.0, 200.0], ["-200", "-100", "0", "100", "200"]),
        // They grow upwards.
        ([10.0, 0.0], ["0", "2.5", "5.0", "7.5", "10.0"]),
        (
            [5e6, 5e6 + 4.0],
            ["5000000.0", "5000001.0", "5000002.0", "5000003.0", "5000004.0"],
        ),
        ([0.0, 1e-9], ["0", "2.5e-10", "5.0e-10", "7.5e-10", "1.00e-9"]),
        ([0.0, 4e30], ["0", "1.0e30", "2.0e30", "3.0e30", "4.0e30"]),
    ] {
        let found = bar(range, SMALLEST).labels();
        let found: Vec<&str> = found.iter().map(|(_, label)| &**label).collect();
        assert_eq!(found, expected);
    }
    let one = bar([7.0; 2], SMALLEST).labels();
    assert_eq!(one, [(0.5, "7.0000".to_owned())]);
}

#[test]
fn every_bar_is_inside_of_its_picture() {
    let ends = [
        -f64::MAX,
        -1.234_567_89e-300,
        -98_765.432_1,
        0.0,
        5e-324,
        0.1,
        12_345_678.9,
        f64::MAX,
    ];
    for size in [SMALLEST, [160, 4000], [4000, 120], [800, 800], [1920, 1080]] {
        for range in ends.into_iter().flat_map(|low| ends.map(|high| [low, high])) {
            bar(range, size).draw(&mut |[x, y], _| assert!(x < size[0] && y < size[1], "{range:?} {size:?}"));
        }
    }
}

#[test]
fn the_first_color_belongs_to_the_smaller_number_unless_the_range_is_reversed() {
    let colors = ColorMap::default()
        .colors()
        .map(|color| color.map(|channel| (channel * 255.0).round() as u8));
    for (range, top, bottom) in [([0.0, 1.0], 255, 0), ([1.0, 0.0], 0, 255)] {
        let mut rows: [Vec<u32>; 2] = Default::default();
        bar(range, [200, 1000]).draw(&mut |[_, y], color| {
            for (rows, which) in rows.iter_mut().zip([top, bottom]) {
                if color == colors[which] {
                    rows.push(y);
                }
            }
        });
        assert!(
            rows[0].iter().max() < rows[1].iter().min() && !rows[0].is_empty(),
            "{rows:?}"
        );
    }
}
