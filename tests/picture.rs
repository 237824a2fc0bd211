//! What becomes of the camera's rays: tiles of a picture put together are the whole picture, in both modes.

use octray::{
    accel::Bvh,
    format,
    render::{Crop, Film, Filter, Mode, Pattern, Pixel, Renderer, Settings},
    scene::{Camera, Scene},
};
use std::{fmt::Debug, ops::ControlFlow, path::Path};

/// Neither tiles nor packets fit into it.
const SIZE: [u32; 2] = [157, 61];
/// Where it is cut: rows and columns of one pixel too.
const COLUMNS: [u32; 6] = [0, 1, 6, 40, 150, 157];
const ROWS: [u32; 5] = [0, 3, 4, 35, 61];

fn reflections() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/reflections.scn");
    format::load(&path).unwrap_or_else(|error| panic!("{error}"))
}

fn camera() -> Camera {
    Camera::course_view(3).expect("views are 1 to 6")
}

fn settings() -> Settings {
    Settings {
        width: SIZE[0],
        height: SIZE[1],
        ..Settings::default()
    }
}

/// All pieces of the picture.
fn crops() -> impl Iterator<Item = Crop> {
    ROWS.windows(2).flat_map(|rows| {
        COLUMNS.windows(2).map(|columns| Crop {
            x0: columns[0],
            y0: rows[0],
            x1: columns[1],
            y1: rows[1],
        })
    })
}

/// Expects `piece` to be what `whole` is at `crop`.
fn check_piece<P: Copy + PartialEq + Debug>(whole: &[P], piece: &[P], crop: Crop, what: &str) {
    let rows = piece.chunks(crop.width() as usize);
    assert_eq!(rows.len(), crop.height() as usize, "{what}: {crop}");
    for (row, y) in rows.zip(crop.y0..) {
        let start = (y * SIZE[0] + crop.x0) as usize;
        assert_eq!(row, &whole[start..][..row.len()], "{what}: {crop}, row {y}");
    }
}

fn film<P: Pixel>(scene: &Scene, bvh: &Bvh, settings: &Settings) -> Film<P> {
    let mut film = Film::black(1, 1);
    Renderer::new(scene, bvh)
        .render(&camera(), settings, &mut film, &|_| ControlFlow::Continue(()))
        .unwrap_or_else(|error| panic!("{error}"));
    film
}

/// The picture, after its pieces were compared with it in both modes.
fn check_pieces<P: Pixel + PartialEq + Debug>(scene: &Scene, bvh: &Bvh, settings: &Settings) -> Film<P> {
    let whole = film::<P>(scene, bvh, settings);
    for mode in [Mode::Packet, Mode::Scalar] {
        for crop in crops() {
            let settings = Settings {
                crop: Some(crop),
                mode,
                ..*settings
            };
            let piece = film::<P>(scene, bvh, &settings);
            let what = format!("{settings:?}");
            check_piece(whole.pixels(), piece.pixels(), crop, &what);
        }
    }
    whole
}

#[test]
fn pieces_are_the_whole() {
    let scene = reflections();
    let bvh = Bvh::build(&scene);
    for samples_per_axis in [1, 2] {
        let settings = Settings {
            samples_per_axis,
            ..settings()
        };
        let floats = check_pieces::<[f32; 3]>(&scene, &bvh, &settings);
        let bytes = check_pieces::<[u8; 3]>(&scene, &bvh, &settings);
        assert_eq!(floats.to_rgb8(), bytes.pixels().as_flattened());
    }
}

#[test]
fn pieces_are_the_whole_with_every_pattern_and_filter() {
    let scene = reflections();
    let bvh = Bvh::build(&scene);
    for (pattern, filter) in [
        (Pattern::Grid, Filter::Tent),
        (Pattern::Stratified, Filter::Box),
        (Pattern::Sobol, Filter::BlackmanHarris),
    ] {
        let settings = Settings {
            samples_per_axis: 2,
            pattern,
            filter,
            ..settings()
        };
        check_pieces::<[f32; 3]>(&scene, &bvh, &settings);
    }
}

#[test]
fn many_samples_agree_whatever_their_pattern() {
    let scene = reflections();
    let bvh = Bvh::build(&scene);
    for filter in [Filter::Box, Filter::Tent, Filter::BlackmanHarris] {
        let picture = |pattern| {
            let settings = Settings {
                samples_per_axis: 8,
                pattern,
                filter,
                ..settings()
            };
            film::<[f32; 3]>(&scene, &bvh, &settings)
        };
        let grid = picture(Pattern::Grid);
        for pattern in [Pattern::Stratified, Pattern::Sobol] {
            let other = picture(pattern);
            let channels = grid
                .pixels()
                .as_flattened()
                .iter()
                .zip(other.pixels().as_flattened());
            let largest = channels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(largest < 0.12, "{filter:?}, {pattern:?}: {largest}");
        }
    }
}

#[test]
fn crops_without_pixels_or_outside_are_refused() {
    for (crop, words) in [
        ([3, 3, 3, 5], "no pixels"),
        ([5, 3, 3, 5], "no pixels"),
        ([0, 0, 158, 5], "within"),
    ] {
        let [x0, y0, x1, y1] = crop;
        let settings = Settings {
            crop: Some(Crop { x0, y0, x1, y1 }),
            ..settings()
        };
        let error = settings.validate().unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}
