//! Crops joined together are the whole picture, in both modes, for colours, AOVs and alpha.

use crate::shipped_scene;
use octray::{
    accel::Bvh,
    ray::SceneHit,
    reference::{
        brute,
        cost::{self, Cost, Stack},
    },
    render::{
        Aov, Aovs, Crop, Film, Filter, Mode, Pattern, Pixel, Progress, RenderError, Renderer, Settings,
        Transfer,
    },
    scene::{Camera, Scene},
    verify::{Random, rays, scenes},
};
use std::{
    fmt::Debug,
    ops::ControlFlow,
    sync::atomic::{AtomicBool, Ordering},
    thread,
    time::{Duration, Instant},
};

/// No multiple of a tile or packet.
const SIZE: [u32; 2] = [157, 61];
/// Where the picture is cut, into single rows and columns too.
const COLUMNS: [u32; 6] = [0, 1, 6, 40, 150, 157];
const ROWS: [u32; 5] = [0, 3, 4, 35, 61];

fn camera() -> Camera {
    Camera::classic_view(3).expect("views are 1 to 6")
}

fn settings() -> Settings {
    Settings {
        width: SIZE[0],
        height: SIZE[1],
        ..Settings::default()
    }
}

/// Crops that cover the picture.
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

/// Expects `piece` to equal `whole` at `crop`.
fn check_crop<P: Copy + PartialEq + Debug>(whole: &[P], piece: &[P], crop: Crop, what: &str) {
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

/// Returns the picture after comparing its crops with it in both modes.
fn check_crops<P: Pixel + PartialEq + Debug>(scene: &Scene, bvh: &Bvh, settings: &Settings) -> Film<P> {
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
            check_crop(whole.pixels(), piece.pixels(), crop, &what);
        }
    }
    whole
}

#[test]
fn crops_equal_the_picture() {
    let scene = shipped_scene("reflections");
    let bvh = Bvh::build(&scene);
    for samples in [1, 4] {
        let settings = Settings {
            samples,
            ..settings()
        };
        let floats = check_crops::<[f32; 3]>(&scene, &bvh, &settings);
        let bytes = check_crops::<[u8; 3]>(&scene, &bvh, &settings);
        assert_eq!(floats.to_rgb8(), bytes.pixels().as_flattened());
    }
}

#[test]
fn crops_equal_the_picture_with_every_pattern_and_filter() {
    let scene = shipped_scene("reflections");
    let bvh = Bvh::build(&scene);
    for (pattern, filter) in [
        (Pattern::Grid, Filter::Tent),
        (Pattern::Stratified, Filter::Box),
        (Pattern::Sobol, Filter::BlackmanHarris),
    ] {
        let settings = Settings {
            samples: 4,
            pattern,
            filter,
            ..settings()
        };
        check_crops::<[f32; 3]>(&scene, &bvh, &settings);
    }
}

#[test]
fn crops_equal_the_adaptive_picture() {
    for name in ["reflections", "soft", "evening"] {
        let scene = shipped_scene(name);
        let bvh = Bvh::build(&scene);
        let settings = Settings {
            samples: 9,
            adaptive: true,
            pattern: Pattern::Sobol,
            filter: Filter::Tent,
            ..settings()
        };
        check_crops::<[f32; 3]>(&scene, &bvh, &settings);
        check_crops::<[f32; 4]>(&scene, &bvh, &settings);
        check_crops::<[u8; 3]>(&scene, &bvh, &settings);
    }
}

#[test]
fn patterns_agree_at_many_samples() {
    let scene = shipped_scene("reflections");
    let bvh = Bvh::build(&scene);
    for filter in [Filter::Box, Filter::Tent, Filter::BlackmanHarris] {
        let picture = |pattern| {
            let settings = Settings {
                samples: 64,
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
fn empty_and_outside_crops_are_refused() {
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

#[test]
fn depths_and_threads_beyond_reason_are_refused() {
    for (max_depth, threads, expected) in [
        (1001, None, "depth 1001: expected 1 to 1000"),
        (0, None, "depth 0: expected 1 to 1000"),
        (5, Some(usize::MAX), "threads: expected 1 to 4096"),
        (5, Some(0), "0 threads: expected 1 to 4096"),
    ] {
        let settings = Settings {
            max_depth,
            threads,
            ..settings()
        };
        let error = settings.validate().unwrap_err().to_string();
        assert!(error.ends_with(expected), "{error}");
    }
}

#[cfg(feature = "png")]
#[test]
fn png_files_have_the_bytes_of_their_pixels() {
    for (size, count, pixel_bytes) in [
        ([4, 4], 48, 7),
        ([4, 4], 48, 0),
        ([4, 4], 47, 3),
        ([1 << 31; 2], 16, 4),
    ] {
        let written = octray::render::write_png(Vec::new(), size, &vec![0; count], pixel_bytes, &[]);
        assert!(written.is_err(), "{size:?} {pixel_bytes}");
    }
}

/// A progress callback may yield its thread to the remaining bands.
#[test]
fn layers_when_the_progress_callback_yields() {
    let scene = shipped_scene("reflections");
    let bvh = Bvh::build(&scene);
    let settings = Settings {
        threads: Some(2),
        ..settings()
    };
    let find = |on_progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync)| {
        let aovs = Renderer::new(&scene, &bvh).aovs(&camera(), &settings, false, on_progress);
        aovs.unwrap_or_else(|error| panic!("{error}"))
    };
    let quiet = find(&|_| ControlFlow::Continue(()));
    // The second thread takes no band before the first one yields.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build();
    let (is_busy, has_yielded) = (AtomicBool::new(false), AtomicBool::new(false));
    let start = Instant::now();
    let wait_for = |flag: &AtomicBool| {
        while !flag.load(Ordering::Relaxed) && start.elapsed() < Duration::from_secs(20) {
            thread::yield_now();
        }
    };
    let yielding = || {
        wait_for(&is_busy);
        find(&|_| {
            rayon::yield_now();
            has_yielded.store(true, Ordering::Relaxed);
            ControlFlow::Continue(())
        })
    };
    let waiting = || {
        is_busy.store(true, Ordering::Relaxed);
        wait_for(&has_yielded);
    };
    let both = || rayon::join(yielding, waiting);
    let (busy, ()) = pool.expect("threads").install(both);
    assert_eq!(quiet, busy);
}

#[test]
fn crops_have_the_same_layers() {
    let scene = shipped_scene("reflections");
    let bvh = Bvh::build(&scene);
    let aovs = |settings: &Settings, costs: bool| {
        let aovs =
            Renderer::new(&scene, &bvh).aovs(&camera(), settings, costs, &|_| ControlFlow::Continue(()));
        aovs.unwrap_or_else(|error| panic!("{error}"))
    };
    let whole = aovs(&settings(), true);
    // Packets and single rays, counted or not, find the same hits.
    let without_costs = |aovs: &Aovs| -> Vec<Aov> {
        let without_cost = |pixel: &Aov| Aov {
            cost: Cost::default(),
            ..*pixel
        };
        aovs.pixels.iter().map(without_cost).collect()
    };
    let packets = aovs(&settings(), false);
    assert!(packets.pixels == without_costs(&whole));
    let scalar = Settings {
        mode: Mode::Scalar,
        ..settings()
    };
    assert_eq!(aovs(&scalar, false), packets);
    assert_eq!([whole.width, whole.height], SIZE);
    for crop in crops() {
        let settings = Settings {
            crop: Some(crop),
            threads: Some(1),
            mode: Mode::Scalar,
            ..settings()
        };
        check_crop(&whole.pixels, &aovs(&settings, true).pixels, crop, "aovs");
        check_crop(
            &packets.pixels,
            &aovs(
                &Settings {
                    mode: Mode::Packet,
                    ..settings
                },
                false,
            )
            .pixels,
            crop,
            "aovs",
        );
    }
    let (mut hits, mut misses) = (0, 0);
    for pixel in &whole.pixels {
        assert!(pixel.cost.nodes > 0);
        if pixel.depth.is_finite() {
            hits += 1;
            let length = pixel.normal.iter().map(|c| c * c).sum::<f32>();
            assert!((length - 1.0).abs() < 1e-5 && pixel.depth > 0.0 && pixel.cost.primitives > 0);
        } else {
            misses += 1;
            assert_eq!((pixel.normal, pixel.albedo), ([0.0; 3], [0.0; 3]));
        }
    }
    assert!(hits > 100 && misses > 100, "{hits}, {misses}");
    let stopped = Renderer::new(&scene, &bvh).aovs(&camera(), &settings(), true, &|_| ControlFlow::Break(()));
    assert_eq!(stopped, Err(RenderError::Cancelled));
}

#[test]
fn the_counting_traversal_agrees_with_brute_force() {
    for seed in 0..20 {
        let mut random = Random::new(seed, 0);
        let scene = scenes::small(&mut random, 200).expect("a scene");
        let bvh = Bvh::build(&scene);
        for _ in 0..200 {
            let ray = rays::ray(&mut random, &scene);
            let (hit, cost) = cost::closest_hit(&scene, &bvh, &mut Stack::default(), &ray);
            let expected = brute::closest_hit(&scene, &ray);
            let bits = |hit: &SceneHit| [hit.t, hit.u, hit.v].map(f32::to_bits);
            assert_eq!(
                (hit.primitive, hit.instance, bits(&hit)),
                (expected.primitive, expected.instance, bits(&expected)),
                "seed {seed}: {ray:?}"
            );
            // Each instance may test all of its prototype.
            let most = scene.primitive_count() * (1 + scene.instances().len());
            assert!(cost.primitives as usize <= most);
        }
    }
}

#[test]
fn transparent_crops_equal_the_picture() {
    let scene = shipped_scene("reflections");
    let bvh = Bvh::build(&scene);
    for samples in [1, 9] {
        let settings = Settings {
            samples,
            ..settings()
        };
        let film = check_crops::<[f32; 4]>(&scene, &bvh, &settings);
        let opaque = self::film::<[f32; 3]>(&scene, &bvh, &settings);
        let (mut partial, mut empty) = (0, 0);
        for (&[r, g, b, alpha], opaque) in film.pixels().iter().zip(opaque.pixels()) {
            assert!((0.0..=1.0).contains(&alpha));
            if alpha == 1.0 {
                assert_eq!([r, g, b], *opaque);
            } else if alpha == 0.0 {
                empty += 1;
                assert_eq!([r, g, b], [0.0; 3]);
            } else {
                partial += 1;
                // Premultiplied: over the scene's white background it is the opaque picture.
                for (c, opaque) in [r, g, b].iter().zip(opaque) {
                    assert!((c + (1.0 - alpha) - opaque).abs() < 1e-5);
                }
            }
        }
        assert!(empty > 100);
        assert_eq!(partial > 0, samples > 1);
        let bytes = film.to_bytes(Transfer::Linear);
        let whole = |(_, pixel): &(&[u8; 4], &[f32; 4])| pixel[3] == 1.0;
        for (bytes, pixel) in bytes.as_chunks::<4>().0.iter().zip(film.pixels()).filter(whole) {
            assert_eq!(*bytes, pixel.map(|c| (c.clamp(0.0, 1.0) * 255.0) as u8));
        }
    }
}
