//! Adaptive sampling: which pixels take how many samples, and that they have the values of as many.

use crate::shipped_scene;
use glam::{DVec3, Vec3};
use octray::{
    accel::Bvh,
    render::{Filter, Frame, Mode, Pattern, RenderError, Settings, render},
    scene::{Camera, Material, Scene, SceneBuilder, TriangleMesh},
};
use std::ops::ControlFlow;

fn settings(samples: u32, adaptive: bool) -> Settings {
    Settings {
        width: 70,
        height: 37,
        samples,
        adaptive,
        pattern: Pattern::Sobol,
        ..Settings::default()
    }
}

fn frame(scene: &Scene, camera: &Camera, settings: &Settings) -> Frame {
    frame_of(scene, &Bvh::build(scene), camera, settings)
}

fn frame_of(scene: &Scene, bvh: &Bvh, camera: &Camera, settings: &Settings) -> Frame {
    render(scene, bvh, camera, settings, &|_| ControlFlow::Continue(())).expect("it renders")
}

fn above(height: f64) -> Camera {
    Camera::look_at(DVec3::Z * height, DVec3::ZERO, DVec3::Y, 30.0).expect("a camera")
}

/// A square at z = 0 of 400x400 vertices, each with a colour of its own.
fn carpet(color: impl FnMut(u32) -> [f32; 3]) -> Scene {
    const SIDE: u32 = 400;
    let at = |i: u32| i as f32 / (SIDE - 1) as f32 - 0.5;
    let mesh = TriangleMesh {
        x: (0..SIDE * SIDE).map(|i| at(i % SIDE)).collect(),
        y: (0..SIDE * SIDE).map(|i| at(i / SIDE)).collect(),
        z: vec![0.0; (SIDE * SIDE) as usize],
        normals: Vec::new(),
        colors: (0..SIDE * SIDE).map(color).collect(),
        uvs: Vec::new(),
        tangents: Vec::new(),
        triangles: (0..SIDE * (SIDE - 1))
            .filter(|i| i % SIDE < SIDE - 1)
            .flat_map(|i| [[i, i + 1, i + SIDE + 1], [i, i + SIDE + 1, i + SIDE]])
            .collect(),
    };
    let mut builder = SceneBuilder::new();
    let material = builder
        .add_material(Material::Silhouette { color: [1.0; 3] })
        .unwrap();
    builder.add_mesh(mesh, material).unwrap();
    builder.finish()
}

#[test]
fn a_flat_picture_takes_the_first_sample_only() {
    // As white as the background around it.
    let scene = carpet(|_| [1.0; 3]);
    let bvh = Bvh::build(&scene);
    for mode in [Mode::Packet, Mode::Scalar] {
        let settings = Settings {
            width: 100,
            height: 16,
            mode,
            ..settings(16, true)
        };
        let frame = frame_of(&scene, &bvh, &above(1.0), &settings);
        // One tile, around which there is nothing.
        assert_eq!(frame.rays.camera, 1600);
        // Interpolated colours round.
        let is_plain = |pixel: &[f32; 3]| pixel.iter().all(|channel| (channel - 1.0).abs() < 1e-6);
        assert!(frame.film.pixels().iter().all(is_plain));
    }
}

#[test]
fn where_everything_differs_it_is_every_sample() {
    let mut random = fastrand::Rng::with_seed(1);
    let scene = carpet(|_| [(); 3].map(|()| random.f32()));
    let bvh = Bvh::build(&scene);
    for (width, samples, filter) in [
        (70, 16, Filter::Box),
        (70, 5, Filter::Tent),
        (13, 300, Filter::Box),
    ] {
        let picture = |adaptive| {
            let settings = Settings {
                width,
                filter,
                ..settings(samples, adaptive)
            };
            frame_of(&scene, &bvh, &above(1.5), &settings).film
        };
        assert!(picture(true) == picture(false), "{samples} {filter:?}");
    }
}

/// From 256 samples on, sums of blocks are kept.
#[test]
fn many_samples_are_the_same_in_both_modes() {
    let scene = shipped_scene("evening");
    let camera = Camera::classic_view(1).expect("views are 1 to 6");
    for adaptive in [false, true] {
        let [packet, scalar] = [Mode::Packet, Mode::Scalar].map(|mode| {
            let settings = Settings {
                width: 9,
                height: 5,
                mode,
                ..settings(600, adaptive)
            };
            frame(&scene, &camera, &settings).film
        });
        assert!(packet == scalar, "adaptive: {adaptive}");
    }
}

/// With point lights, a pixel has the value of one sample, of a quarter, of half or of all of them.
#[test]
fn pixels_have_the_samples_of_a_grade() {
    let camera = Camera::classic_view(1).expect("views are 1 to 6");
    for name in ["reflections", "hall_of_mirrors", "evening"] {
        let scene = shipped_scene(name);
        let picture = |samples, adaptive| frame(&scene, &camera, &settings(samples, adaptive));
        let grades = [1, 4, 8, 16].map(|samples| picture(samples, false));
        let adaptive = picture(16, true);
        let mut counts = [0; 4];
        for (i, pixel) in adaptive.film.pixels().iter().enumerate() {
            let grade = grades.iter().position(|grade| grade.film.pixels()[i] == *pixel);
            counts[grade.expect(name)] += 1;
        }
        assert!(counts.iter().all(|&count| count > 20), "{name}: {counts:?}");
        assert!(adaptive.rays.camera < grades[3].rays.camera / 2, "{name}");
    }
}

/// Soft light takes four samples everywhere, so up to four are those of any picture.
#[test]
fn soft_light_has_four_first_samples() {
    let scene = shipped_scene("soft");
    let camera = Camera::classic_view(1).expect("views are 1 to 6");
    for samples in [1, 3, 4] {
        let [all, adaptive] =
            [false, true].map(|adaptive| frame(&scene, &camera, &settings(samples, adaptive)));
        assert!(all.film == adaptive.film, "{samples}");
    }
    let [all, adaptive] = [false, true].map(|adaptive| frame(&scene, &camera, &settings(16, adaptive)));
    let same = all.film.pixels().iter().zip(adaptive.film.pixels());
    let same = same.filter(|(all, adaptive)| all == adaptive).count();
    assert!(same > 500 && same < 70 * 37 - 100, "{same}");
    let worst = all.film.pixels().iter().zip(adaptive.film.pixels());
    let worst = worst
        .map(|(&all, &adaptive)| Vec3::from(all).distance(adaptive.into()))
        .fold(0.0, f32::max);
    assert!(worst < 0.1, "{worst}");
}

#[test]
fn other_patterns_are_refused() {
    let scene = shipped_scene("soft");
    let bvh = Bvh::build(&scene);
    for pattern in [Pattern::Grid, Pattern::Stratified] {
        let settings = Settings {
            pattern,
            ..settings(16, true)
        };
        let error = render(&scene, &bvh, &above(1.0), &settings, &|_| {
            ControlFlow::Continue(())
        });
        let expected = RenderError::Limit("adaptive sampling: expected the pattern sobol".into());
        assert_eq!(error.err(), Some(expected));
    }
}

/// A wire a quarter of a pixel wide is whole with 64 samples: four first ones do not miss it along three pixels.
#[test]
fn thin_wires_are_whole_with_many_samples() {
    let mut builder = SceneBuilder::new();
    let black = builder
        .add_material(Material::Silhouette { color: [0.0; 3] })
        .unwrap();
    // 37 pixels are 2 tan(15 degrees) high in the plane z = 0.
    let pixel = 2.0 * 15.0_f32.to_radians().tan() / 37.0;
    let corner = |x: f32, y: f32| Vec3::new(x, 0.07 * x + y * pixel, 0.0);
    let [a, b, c, d] = [
        corner(-1.0, 0.0),
        corner(1.0, 0.0),
        corner(1.0, 0.25),
        corner(-1.0, 0.25),
    ];
    builder.add_triangle([a, b, c], black).unwrap();
    builder.add_triangle([a, c, d], black).unwrap();
    let scene = builder.finish();
    let lit_columns = |samples, mode| {
        let settings = Settings {
            mode,
            ..settings(samples, true)
        };
        let film = frame(&scene, &above(1.0), &settings).film;
        let rows: Vec<_> = film.pixels().chunks_exact(70).collect();
        let shows = |column: &usize| {
            let missing: f32 = rows.iter().map(|row| 1.0 - row[*column][0]).sum();
            missing > 0.1
        };
        (0..70).filter(shows).count()
    };
    for mode in [Mode::Packet, Mode::Scalar] {
        assert!(lit_columns(16, mode) < 60);
        assert_eq!(lit_columns(64, mode), 70);
        assert_eq!(lit_columns(256, mode), 70);
    }
}
