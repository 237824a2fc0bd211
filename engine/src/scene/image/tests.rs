use super::*;

/// A picture of two rows: black, white; red, and green of half alpha.
fn four() -> Image {
    let pixels = vec![[0, 0, 0, 255], [255; 4], [255, 0, 0, 255], [0, 255, 0, 128]];
    Image::new([2, 2], pixels).expect("an image")
}

fn clamped() -> Texture {
    Texture {
        wrap: [Wrap::Clamp; 2],
        ..Texture::default()
    }
}

fn near(found: [f32; 4], expected: [f32; 4]) -> bool {
    found
        .iter()
        .zip(expected)
        .all(|(found, expected)| (found - expected).abs() < 1e-6)
}

#[test]
fn texels_are_at_their_centres_and_rows_begin_at_the_top() {
    let image = four();
    let half = 128.0 / 255.0;
    for (uv, expected) in [
        ([0.25, 0.25], [0.0, 0.0, 0.0, 1.0]),
        ([0.75, 0.25], [1.0; 4]),
        ([0.25, 0.75], [1.0, 0.0, 0.0, 1.0]),
        ([0.75, 0.75], [0.0, 1.0, 0.0, half]),
        ([0.5, 0.25], [0.5, 0.5, 0.5, 1.0]),
        ([0.5, 0.5], [0.5, 0.5, 0.25, (3.0 + half) / 4.0]),
        // Beyond the edge.
        ([-3.0, 0.25], [0.0, 0.0, 0.0, 1.0]),
        ([7.0, 9.0], [0.0, 1.0, 0.0, half]),
    ] {
        let found = image.color(clamped(), uv, 0.0);
        assert!(near(found, expected), "{uv:?}: {found:?}");
    }
    let nearest = Texture {
        nearest: true,
        ..clamped()
    };
    assert_eq!(image.color(nearest, [0.49, 0.49], 0.0), [0.0, 0.0, 0.0, 1.0]);
    assert_eq!(image.color(nearest, [0.51, 0.49], 0.0), [1.0; 4]);
    assert_eq!(image.color(nearest, [1.0, 0.0], 0.0), [1.0; 4]);
}

#[test]
fn images_wrap() {
    let image = four();
    let texture = |wrap| Texture {
        wrap: [wrap; 2],
        ..Texture::default()
    };
    let at = |wrap, u: f32| image.color(texture(wrap), [u, 0.25], 0.0)[1];
    for turn in [-2.0, -1.0, 1.0, 5.0] {
        assert_eq!(at(Wrap::Repeat, 0.75 + turn), 1.0);
        assert_eq!(at(Wrap::Repeat, 0.25 + turn), 0.0);
    }
    // Halfway between the last texel and the first one again.
    assert_eq!(at(Wrap::Repeat, 0.0), 0.5);
    assert_eq!(at(Wrap::Repeat, 1.0), 0.5);
    for (u, expected) in [
        (0.25, 0.0),
        (0.75, 1.0),
        (1.25, 1.0),
        (1.75, 0.0),
        (-0.25, 0.0),
        (-0.75, 1.0),
        (2.25, 0.0),
    ] {
        assert_eq!(at(Wrap::Mirror, u), expected, "{u}");
    }
    assert_eq!(at(Wrap::Mirror, 1.0), 1.0);
    for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
        for huge in [1e9, -1e9, -1e-9, 16_777_217.0] {
            let found = image.color(texture(wrap), [huge, huge], 0.5);
            assert!(found.iter().all(|c| (0.0..=1.0).contains(c)), "{wrap:?} {huge}");
        }
    }
}

#[test]
fn mipmaps_are_means_of_light() {
    let black_and_white = Image::new([4, 4], [[[0, 0, 0, 255], [255; 4]]; 8].concat());
    let mut image = black_and_white.expect("an image");
    image.set_curve(Curve::Srgb);
    for lod in [1.0, 1.7, 2.0, 9.0, f32::INFINITY] {
        let found = image.color(clamped(), [0.3, 0.6], lod)[0];
        assert!((found - 0.5).abs() < 0.004, "{lod}: {found}");
    }
    // Between two levels: of the texel's own colour and the mean.
    let found = image.color(clamped(), [0.125, 0.125], 0.25)[0];
    assert!((found - 0.125).abs() < 0.001, "{found}");
    assert_eq!(image.color(clamped(), [0.125, 0.125], f32::NAN)[0], 0.0);
    assert_eq!(image.color(clamped(), [0.125, 0.125], f32::NEG_INFINITY)[0], 0.0);
    // What is transparent has no colour.
    let image = Image::new([2, 1], vec![[255, 0, 0, 255], [0, 0, 255, 0]]).expect("an image");
    assert!(near(
        image.color(clamped(), [0.5; 2], 1.0),
        [1.0, 0.0, 0.0, 128.0 / 255.0]
    ));
}

#[test]
fn bytes_survive_their_light() {
    for byte in 0..=u8::MAX {
        assert_eq!(display(whole_light()[usize::from(byte)]), byte);
    }
}

#[test]
fn sides_and_lengths_are_checked() {
    for size in [[0, 1], [1, 0], [MAX_IMAGE_SIDE + 1, 1]] {
        assert!(matches!(
            Image::new(size, Vec::new()),
            Err(SceneError::ImageSize { .. })
        ));
    }
    assert!(matches!(
        Image::new([2, 2], vec![[0; 4]; 3]),
        Err(SceneError::ArrayLength { .. })
    ));
    let odd = Image::new([5, 3], vec![[9; 4]; 15]).expect("an image");
    assert_eq!(
        odd.levels
            .iter()
            .map(|level| (level.width, level.height))
            .collect::<Vec<_>>(),
        [(5, 3), (2, 1), (1, 1)]
    );
}

/// Whether a texel of a picture of this size is white.
type Pattern = fn(u32, u32, [u32; 2]) -> bool;

#[test]
fn mipmaps_of_odd_sides_keep_the_mean() {
    for size in [[255, 255], [1000, 4], [7, 3], [1, 31], [127, 64], [3, 3]] {
        let [width, height] = size;
        // Of the last column or row alone, and of half the picture.
        let pictures: [Pattern; 4] = [
            |x, _, [width, _]| x == width - 1,
            |_, y, [_, height]| y == height - 1,
            |x, _, _| x % 2 == 1,
            |x, _, [width, _]| x >= width / 2,
        ];
        for (number, picture) in pictures.into_iter().enumerate() {
            let pixels: Vec<_> = (0..width * height)
                .map(|i| {
                    if picture(i % width, i / width, size) {
                        [255; 4]
                    } else {
                        [0, 0, 0, 255]
                    }
                })
                .collect();
            let share = pixels.iter().filter(|texel| texel[0] > 0).count() as f32 / pixels.len() as f32;
            let mut image = Image::new(size, pixels.clone()).expect("an image");
            image.set_curve(Curve::Srgb);
            let numbers = Image::of_numbers(size, pixels).expect("an image");
            for (image, near) in [(&image, 0.02), (&numbers, 0.015)] {
                let found = image.color(clamped(), [0.5; 2], 99.0);
                assert!(
                    (found[0] - share).abs() < near,
                    "{size:?} {number}: {found:?} for {share}"
                );
                assert_eq!(found[3], 1.0);
            }
        }
    }
}

#[test]
fn odd_sides_share_their_texels_by_area() {
    let pixels: Vec<_> = [0, 50, 100, 150, 200].map(|grey| [grey, 0, 0, 255]).to_vec();
    let image = Image::of_numbers([5, 1], pixels).expect("an image");
    // (2 0 + 2 50 + 1 100) / 5 and (1 100 + 2 150 + 2 200) / 5.
    assert_eq!(
        image.levels[1]
            .texels
            .iter()
            .map(|texel| texel[0])
            .collect::<Vec<_>>(),
        [40, 160]
    );
    // What is transparent has no colour there, either.
    let pixels = vec![[255, 0, 0, 255], [0, 0, 255, 0], [0, 0, 255, 0]];
    let image = Image::new([3, 1], pixels).expect("an image");
    assert_eq!(image.levels[1].texels, [[255, 0, 0, 85]]);
    let clear = Image::new([3, 1], vec![[90, 0, 0, 0]; 3]).expect("an image");
    assert_eq!(clear.levels[1].texels, [[90, 0, 0, 0]]);
}
