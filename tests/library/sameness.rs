//! One scene, one picture: packets or scalar, one thread or two, any size: the same linear colours, bit for bit.

use octray::{
    accel::{BuildQuality, Bvh, Layout},
    format,
    generate::{Kind, Options, generate},
    render::{Film, Mode, Settings, render},
    scene::{Camera, Scene},
};
use std::{
    ops::ControlFlow,
    path::{Path, PathBuf},
};

const SHIPPED: [&str; 6] = [
    "silhouette",
    "matte",
    "blinn_phong",
    "reflections",
    "hall_of_mirrors",
    "evening",
];

/// Width, height, samples of a pixel. Neither multiples of a packet nor of a tile; a single pixel;
/// very wide; several samples.
const SIZES: [(u32, u32, u32); 4] = [(333, 217, 1), (1, 1, 1), (8191, 3, 1), (64, 48, 4)];

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

/// The first pixel that is not the same in both, by its bits.
fn first_difference(a: &Film, b: &Film) -> Option<String> {
    let bits = |pixel: &[f32; 3]| pixel.map(f32::to_bits);
    let (i, (pa, pb)) = a
        .pixels()
        .iter()
        .zip(b.pixels())
        .enumerate()
        .find(|(_, (pa, pb))| bits(pa) != bits(pb))?;
    let (x, y) = (i % a.width() as usize, i / a.width() as usize);
    Some(format!("pixel ({x}, {y}): {pa:?} and {pb:?}"))
}

fn check(name: &str, scene: &Scene, camera: &Camera, basis: &Settings) {
    let bvh = Bvh::build(scene);
    let film = |mode, threads| {
        let settings = Settings {
            mode,
            threads: Some(threads),
            ..*basis
        };
        let frame = render(scene, &bvh, camera, &settings, &|_| ControlFlow::Continue(()));
        frame.unwrap_or_else(|error| panic!("{name}: {error}")).film
    };
    let first = film(Mode::Packet, 1);
    assert_eq!(
        first.pixels().len(),
        basis.width as usize * basis.height as usize,
        "{name}"
    );
    let settings = Settings {
        mode: Mode::Packet,
        threads: Some(1),
        ..*basis
    };
    for (quality, layout) in [
        (BuildQuality::Fast, Layout::Whole),
        (BuildQuality::Best, Layout::Indexed),
        (BuildQuality::Ploc, Layout::Whole),
    ] {
        let other = Bvh::build_as(scene, quality, layout);
        let frame = render(scene, &other, camera, &settings, &|_| ControlFlow::Continue(()));
        let other = frame.unwrap_or_else(|error| panic!("{name}: {error}")).film;
        if let Some(where_) = first_difference(&first, &other) {
            panic!("{name}: the usual build and the {quality:?}, {layout:?} one differ at {where_}");
        }
    }
    for (mode, threads) in [(Mode::Packet, 2), (Mode::Scalar, 1), (Mode::Scalar, 2)] {
        let other = film(mode, threads);
        if let Some(where_) = first_difference(&first, &other) {
            panic!(
                "{name}, {}x{}: packets on 1 thread and {mode:?} on {threads} differ at {where_}",
                basis.width, basis.height
            );
        }
    }
}

fn sized(width: u32, height: u32, samples: u32) -> Settings {
    Settings {
        width,
        height,
        samples,
        ..Settings::default()
    }
}

#[test]
fn shipped_scenes_are_the_same_in_every_mode() {
    for name in SHIPPED {
        let path = scenes().join(format!("{name}.scn"));
        let scene = format::load(&path).unwrap_or_else(|error| panic!("{error:?}"));
        let bvh = Bvh::build(&scene);
        let camera = Camera::classic_view(1).expect("views are 1 to 6");
        let frame = render(&scene, &bvh, &camera, &sized(32, 32, 1), &|_| {
            ControlFlow::Continue(())
        });
        let film = frame.expect("it renders").film;
        assert!(
            film.pixels().iter().any(|pixel| *pixel != film.pixels()[0]),
            "{name}: nothing to compare"
        );
        for (i, (width, height, samples)) in SIZES.into_iter().enumerate() {
            let camera = Camera::classic_view(i as u32 + 1).expect("views are 1 to 6");
            check(name, &scene, &camera, &sized(width, height, samples));
        }
    }
}

#[test]
fn without_shadows_and_with_many_levels_too() {
    let path = scenes().join("hall_of_mirrors.scn");
    let scene = format::load(&path).unwrap_or_else(|error| panic!("{error:?}"));
    let camera = Camera::classic_view(2).expect("views are 1 to 6");
    for (shadows, max_depth) in [(false, 1), (false, 3), (true, 1), (true, 20)] {
        let settings = Settings {
            shadows,
            max_depth,
            ..sized(97, 61, 1)
        };
        check("hall_of_mirrors", &scene, &camera, &settings);
    }
}

#[test]
fn generated_scenes_are_the_same_in_every_mode() {
    for kind in Kind::ALL {
        let count = Some(kind.min_count().max(20_000));
        let generated = generate(kind, Options { seed: 5, count }).expect("a count within its limits");
        let camera = generated.view.camera().expect("a view");
        let scene = generated.into_scene().expect("a scene");
        check(kind.name(), &scene, &camera, &sized(201, 101, 1));
    }
}
