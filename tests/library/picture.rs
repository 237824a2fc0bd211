//! What becomes of the camera's rays: tiles of a picture put together are the whole picture, in both modes.

use octray::{
    accel::Bvh,
    format,
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
    path::Path,
    sync::atomic::{AtomicBool, Ordering},
    thread,
    time::{Duration, Instant},
};

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
    Camera::classic_view(3).expect("views are 1 to 6")
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
    for samples in [1, 4] {
        let settings = Settings {
            samples,
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
            samples: 4,
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

/// Whoever is told of progress may let the thread do other work, such as the bands that are left.
#[test]
fn variables_while_whoever_is_told_yields() {
    let scene = reflections();
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
    // The other thread takes nothing before the first band's thread has.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build();
    let (is_busy, has_yielded) = (AtomicBool::new(false), AtomicBool::new(false));
    let start = Instant::now();
    let wait_for = |flag: &AtomicBool| {
        while !flag.load(Ordering::Relaxed) && start.elapsed() < Duration::from_secs(20) {
            thread::yield_now();
        }
    };
    let one_that_yields = || {
        wait_for(&is_busy);
        find(&|_| {
            rayon::yield_now();
            has_yielded.store(true, Ordering::Relaxed);
            ControlFlow::Continue(())
        })
    };
    let one_that_waits = || {
        is_busy.store(true, Ordering::Relaxed);
        wait_for(&has_yielded);
    };
    let both = || rayon::join(one_that_yields, one_that_waits);
    let (busy, ()) = pool.expect("threads").install(both);
    assert_eq!(quiet, busy);
}

#[test]
fn pieces_have_the_same_variables() {
    let scene = reflections();
    let bvh = Bvh::build(&scene);
    let aovs = |settings: &Settings, costs: bool| {
        let aovs =
            Renderer::new(&scene, &bvh).aovs(&camera(), settings, costs, &|_| ControlFlow::Continue(()));
        aovs.unwrap_or_else(|error| panic!("{error}"))
    };
    let whole = aovs(&settings(), true);
    // Packets, single rays that are counted and single rays that are not find the same.
    let without_costs = |aovs: &Aovs| -> Vec<Aov> {
        let free = |pixel: &Aov| Aov {
            cost: Cost::default(),
            ..*pixel
        };
        aovs.pixels.iter().map(free).collect()
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
        check_piece(&whole.pixels, &aovs(&settings, true).pixels, crop, "aovs");
        check_piece(
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
fn variables_are_those_of_every_other_traversal() {
    for seed in 0..20 {
        let mut random = Random::new(seed, 0);
        let scene = scenes::small(&mut random, 200).expect("a scene");
        let bvh = Bvh::build(&scene);
        for _ in 0..200 {
            let ray = rays::ray(&mut random, &scene);
            let (hit, cost) = cost::closest_hit(&scene, &bvh, &mut Stack::default(), &ray);
            let expected = brute::closest_hit(&scene, &ray);
            assert_eq!(
                (hit.primitive, hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits()),
                (
                    expected.primitive,
                    expected.t.to_bits(),
                    expected.u.to_bits(),
                    expected.v.to_bits()
                ),
                "seed {seed}: {ray:?}"
            );
            assert!(cost.primitives as usize <= scene.primitive_count());
        }
    }
}

#[test]
fn transparency_agrees_in_both_modes() {
    let scene = reflections();
    let bvh = Bvh::build(&scene);
    for samples in [1, 9] {
        let settings = Settings {
            samples,
            ..settings()
        };
        let film = check_pieces::<[f32; 4]>(&scene, &bvh, &settings);
        let opaque = self::film::<[f32; 3]>(&scene, &bvh, &settings);
        let (mut partly, mut nothing) = (0, 0);
        for (&[r, g, b, alpha], opaque) in film.pixels().iter().zip(opaque.pixels()) {
            assert!((0.0..=1.0).contains(&alpha));
            if alpha == 1.0 {
                assert_eq!([r, g, b], *opaque);
            } else if alpha == 0.0 {
                nothing += 1;
                assert_eq!([r, g, b], [0.0; 3]);
            } else {
                partly += 1;
                // Over the scene's white background it is the opaque picture.
                for (c, opaque) in [r, g, b].iter().zip(opaque) {
                    assert!((c + (1.0 - alpha) - opaque).abs() < 1e-5);
                }
            }
        }
        assert!(nothing > 100);
        assert_eq!(partly > 0, samples > 1);
        let bytes = film.to_bytes(Transfer::Linear);
        let whole = |(_, pixel): &(&[u8; 4], &[f32; 4])| pixel[3] == 1.0;
        for (bytes, pixel) in bytes.as_chunks::<4>().0.iter().zip(film.pixels()).filter(whole) {
            assert_eq!(*bytes, pixel.map(|c| (c.clamp(0.0, 1.0) * 255.0) as u8));
        }
    }
}
