use super::*;
use crate::{
    accel::Bvh,
    scene::{Material, Scene, SceneBuilder},
    viewer::timeline::Timeline,
};
use glam::Vec3;
use std::{ops::ControlFlow, sync::Arc};

const SIZE: [u32; 2] = [96, 64];

/// A ball on a floor, in soft light with ambient occlusion.
fn soft_scene() -> Scene {
    let mut builder = SceneBuilder::new();
    builder.set_ambient(0.3).unwrap();
    builder.set_ambient_reach(Some(1.0)).unwrap();
    builder
        .add_sphere_light(Vec3::new(6.0, -6.0, 8.0), 2.0, 0.6, [1.0; 3])
        .unwrap();
    let mut matte = |color| builder.add_material(Material::Matte { color }).unwrap();
    let (red, grey) = (matte([0.9, 0.1, 0.1]), matte([0.7; 3]));
    builder.add_sphere(Vec3::new(0.0, 0.0, 0.5), 0.5, red).unwrap();
    for far in [3.0, -3.0] {
        let corners = [
            Vec3::new(far, far, 0.0),
            Vec3::new(-far, far, 0.0),
            Vec3::new(far, -far, 0.0),
        ];
        builder.add_triangle(corners, grey).unwrap();
    }
    builder.finish()
}

fn request(timeline: &Arc<Timeline>, transfer: Transfer) -> Request {
    let mut request = Request::of_view(timeline, 1);
    request.style.settings.samples = 256;
    request.style.transfer = transfer;
    request.size = SIZE;
    request
}

/// The mean of all differences of bytes, with their signs and without.
fn differences(a: &ByteFilm, b: &ByteFilm) -> [f64; 2] {
    let bytes = |film: &ByteFilm| film.pixels().as_flattened().to_vec();
    let pairs = bytes(a).into_iter().zip(bytes(b));
    let differences: Vec<f64> = pairs.map(|(a, b)| f64::from(a) - f64::from(b)).collect();
    let mean = |sum: f64| sum / differences.len() as f64;
    [
        mean(differences.iter().sum()),
        mean(differences.iter().map(|d| d.abs()).sum()),
    ]
}

#[test]
fn denoised_pictures_are_as_bright_as_those_at_rest_and_have_little_noise() {
    let scene = soft_scene();
    let bvh = Bvh::build(&scene);
    let timeline = Arc::new(Timeline::new(Model::new(scene, bvh)));
    let model = timeline.now();
    let go_on = &|_| ControlFlow::Continue(());
    let mut painter = Painter::new(&model);
    for transfer in [Transfer::Linear, Transfer::Srgb] {
        let request = request(&timeline, transfer);
        painter.trace(&request, SIZE, 256, go_on).unwrap();
        let rest = painter.film.clone();
        for (samples, most_left) in [(1, 0.5), (4, 0.7), (16, 1.0)] {
            painter.trace(&request, SIZE, samples, go_on).unwrap();
            let noise = differences(&painter.film, &rest);
            let stats = painter.trace_denoised(&request, SIZE, samples, go_on).unwrap();
            let left = differences(&painter.film, &rest);
            assert!(left[0].abs() < 0.5, "{samples}: {left:?}");
            assert!(left[1] < most_left * noise[1], "{samples}: {left:?} of {noise:?}");
            assert_eq!(stats.rays.camera, u64::from(SIZE[0] * SIZE[1] * samples));
            // The sky is as it was.
            assert_eq!(painter.film.pixels()[0], rest.pixels()[0]);
        }
    }
}

#[test]
fn hard_light_has_no_noise_to_remove() {
    let mut builder = SceneBuilder::new();
    let matte = builder.classic_material(1).unwrap();
    builder.add_sphere(Vec3::new(0.0, 0.0, 0.5), 0.5, matte).unwrap();
    let scene = builder.finish();
    let bvh = Bvh::build(&scene);
    let timeline = Arc::new(Timeline::new(Model::new(scene, bvh)));
    let model = timeline.now();
    let request = request(&timeline, Transfer::Srgb);
    let mut painter = Painter::new(&model);
    assert!(!painter.denoises(&request));
    let go_on = &|_| ControlFlow::Continue(());
    painter.trace_denoised(&request, SIZE, 1, go_on).unwrap();
    let moving = painter.film.clone();
    painter.trace(&request, SIZE, 1, go_on).unwrap();
    assert_eq!(painter.film, moving);
}
