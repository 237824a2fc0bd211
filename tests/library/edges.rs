//! Edges of triangles in pictures: against closed forms, what has edges and what has none, and the same in both modes.

use crate::{
    blending::see_through,
    long::rounds,
    sameness::{SHIPPED, Sameness, sized},
    shipped_scene,
};
use glam::{DVec3, Vec3};
use octray::{
    accel::Bvh,
    render::{Edges, Film, MAX_EDGE_WIDTH, Mode, Pattern, Pixel, Renderer, Settings},
    scene::{
        Background, Camera, Distortion, Lens, Material, MaterialId, Projection, Scene, SceneBuilder,
        Transform, TriangleMesh, View,
    },
};
use std::ops::ControlFlow;

/// Width and height of the pictures, pixels.
const SIDE: u32 = 20;
/// Size of a pixel on the plane z = 0 as [`above`] sees it.
const PIXEL: f64 = 0.1;
/// Where that plane has an edge, in pixels right of the picture's left border.
const EDGE: f64 = 9.37;

const WHITE: Material = Material::Silhouette { color: [1.0; 3] };

fn edges(width: f32) -> Edges {
    Edges {
        width,
        color: [0.0; 3],
    }
}

/// Two large triangles in the plane z = 0, and their edge along y at [`EDGE`].
fn halves(offset: f32) -> TriangleMesh {
    let x = ((EDGE - 0.5 * f64::from(SIDE)) * PIXEL) as f32 + offset;
    TriangleMesh {
        x: vec![x, x, x - 100.0, x + 100.0],
        y: vec![-50.0, 50.0, 0.0, 0.0],
        z: vec![0.0; 4],
        triangles: vec![[0, 1, 2], [0, 3, 1]],
        ..TriangleMesh::default()
    }
}

fn builder() -> (SceneBuilder, MaterialId) {
    let mut builder = SceneBuilder::new();
    builder.set_background(Background::constant([0.5; 3])).unwrap();
    let white = builder.add_material(WHITE).unwrap();
    (builder, white)
}

fn scene_of(mesh: TriangleMesh) -> Scene {
    let (mut builder, white) = builder();
    builder.add_mesh(mesh, white).unwrap();
    builder.finish()
}

/// Looks down on z = 0 from the height 10.
fn above(is_ortho: bool, aperture: f64) -> Camera {
    let height = f64::from(SIDE) * PIXEL;
    let fov_degrees = 2.0 * (0.5 * height / 10.0).atan().to_degrees();
    let view = View {
        eye: DVec3::Z * 10.0,
        target: DVec3::ZERO,
        up: DVec3::Y,
        projection: if is_ortho {
            Projection::Orthographic { height }
        } else {
            Projection::Perspective { fov_degrees }
        },
        lens: Lens {
            aperture,
            focus: None,
        },
    };
    Camera::new(&view).unwrap()
}

/// Renders in both modes, which make the same picture.
fn picture<P: Pixel + PartialEq>(scene: &Scene, camera: &Camera, settings: Settings) -> Vec<P> {
    let bvh = Bvh::build(scene);
    let [packet, scalar] = [Mode::Packet, Mode::Scalar].map(|mode| {
        let mut film = Film::<P>::black(1, 1);
        let settings = Settings { mode, ..settings };
        let go_on = &|_| ControlFlow::Continue(());
        let mut renderer = Renderer::new(scene, &bvh);
        renderer.render(camera, &settings, &mut film, go_on).unwrap();
        film.pixels().to_vec()
    });
    assert!(packet == scalar);
    packet
}

fn reds(scene: &Scene, camera: &Camera, settings: Settings) -> Vec<f64> {
    let pixels = picture::<[f32; 3]>(scene, camera, settings);
    pixels.into_iter().map(|[r, ..]| r.into()).collect()
}

/// How much of pixel `column` a line along [`EDGE`] covers.
fn overlap(column: u32, width: f64) -> f64 {
    let (left, right) = (EDGE - 0.5 * width, EDGE + 0.5 * width);
    let column = f64::from(column);
    (right.min(column + 1.0) - left.max(column)).max(0.0)
}

#[test]
fn a_line_covers_pixels_by_its_width() {
    let scene = scene_of(halves(0.0));
    for (is_ortho, aperture) in [(false, 0.0), (true, 0.0), (false, 0.5), (true, 0.5)] {
        let camera = above(is_ortho, aperture);
        for width in [0.3, 1.0, 2.5] {
            for (samples, pattern) in [(1, Pattern::Grid), (16, Pattern::Grid), (256, Pattern::Sobol)] {
                let settings = Settings {
                    pattern,
                    edges: Some(edges(width)),
                    ..sized(SIDE, SIDE, samples)
                };
                let row = &reds(&scene, &camera, settings)[7 * SIDE as usize..][..SIDE as usize];
                for (column, found) in (0..).zip(row) {
                    let expected = 1.0 - overlap(column, width.into());
                    let tolerance = if pattern == Pattern::Sobol { 0.07 } else { 1e-4 };
                    assert!(
                        (found - expected).abs() < tolerance,
                        "{is_ortho} {aperture} {width} {samples}: {found}, not {expected} in column {column}"
                    );
                }
            }
        }
    }
}

/// Across a line, the darkness of all pixels adds up to its width, whatever the projection.
#[test]
fn lines_are_as_wide_in_distorted_and_slanted_pictures() {
    let radial = |k1| Distortion::Perspective {
        radial: [k1, 0.0, 0.0, 0.0],
        divisor: [0.0; 3],
        tangential: [0.0; 2],
    };
    let fisheye = Distortion::Fisheye {
        radial: [0.1, 0.0, 0.0, 0.0],
    };
    let wide = |eye| Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 50.0).unwrap();
    for x in [-1.6_f32, 0.0, 0.5, 1.8] {
        for (eye, distortion) in [
            (DVec3::Z * 2.0, None),
            (DVec3::Z * 2.0, Some(radial(0.15))),
            (DVec3::Z * 2.0, Some(radial(-0.05))),
            (DVec3::Z * 2.0, Some(fisheye)),
            (DVec3::new(0.3, 0.0, 2.0), None),
            (DVec3::new(0.3, 0.0, 2.0), Some(fisheye)),
        ] {
            let camera = wide(eye).with_distortion(distortion).unwrap();
            let settings = Settings {
                edges: Some(edges(2.0)),
                ..sized(121, 41, 16)
            };
            let all = reds(&scene_of(halves(x)), &camera, settings);
            let dark: f64 = all[20 * 121..21 * 121].iter().map(|red| 1.0 - red).sum();
            assert!((dark - 2.0).abs() < 0.02, "{x} {eye} {distortion:?}: {dark}");
        }
    }
}

#[test]
fn triangles_behind_the_eye_have_edges() {
    let floor = |side: f32| TriangleMesh {
        x: vec![-side, side, side, -side],
        y: vec![-side, side, -side, side],
        z: vec![0.0; 4],
        triangles: vec![[0, 1, 2], [0, 3, 1]],
        ..TriangleMesh::default()
    };
    let (eye, target) = (DVec3::new(1.0, -1.0, 1.6), DVec3::new(6.0, 5.0, 0.0));
    let camera = Camera::look_at(eye, target, DVec3::Z, 45.0).unwrap();
    let settings = Settings {
        edges: Some(edges(2.0)),
        ..sized(64, 48, 4)
    };
    let [near, far] =
        [20.0, 1000.0].map(|side| reds(&scene_of(floor(side)), &camera, settings)[24 * 64..].to_vec());
    assert!(near.iter().any(|red| *red < 0.01));
    for (near, far) in near.iter().zip(&far) {
        assert!((near - far).abs() < 1e-3, "{near} {far}");
    }
}

#[test]
fn instances_have_the_edges_of_the_placed_mesh() {
    let placed = Transform::IDENTITY
        .then_scale(DVec3::new(0.2, -3.0, 1.5))
        .then_rotate(DVec3::new(1.0, 2.0, -0.5), 70.0)
        .then_translate(DVec3::new(5.0, -2.0, 1.0));
    // Its inverse, step by step.
    let back = Transform::IDENTITY
        .then_translate(DVec3::new(-5.0, 2.0, -1.0))
        .then_rotate(DVec3::new(1.0, 2.0, -0.5), -70.0)
        .then_scale(DVec3::new(5.0, -1.0 / 3.0, 1.0 / 1.5));
    let mut moved = halves(0.0);
    back.apply(&mut moved);
    let (mut builder, white) = builder();
    let prototype = builder.add_prototype(|builder| builder.add_mesh(moved, white));
    builder.add_instance(prototype.unwrap(), &placed).unwrap();
    let instance = builder.finish();
    for is_ortho in [false, true] {
        let settings = Settings {
            edges: Some(edges(2.5)),
            ..sized(SIDE, SIDE, 4)
        };
        let [found, expected] =
            [&instance, &scene_of(halves(0.0))].map(|scene| reds(scene, &above(is_ortho, 0.0), settings));
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-3, "{found}, not {expected}");
        }
    }
}

/// Asserts that a scene looks the same with edges.
#[track_caller]
fn assert_no_edges(builder: SceneBuilder, camera: &Camera) {
    let scene = builder.finish();
    let [without, with] = [None, Some(edges(9.0))].map(|edges| {
        let settings = Settings {
            edges,
            ..sized(SIDE, SIDE, 4)
        };
        reds(&scene, camera, settings)
    });
    assert!(without.iter().any(|red| *red != without[0]));
    assert!(without == with);
}

#[test]
fn mirrored_triangles_spheres_planes_and_marked_meshes_have_none() {
    // A mirror that ends beyond the picture shows triangles behind the camera.
    let (mut mirror, white) = builder();
    let material = Material::Reflection {
        color: [1.0; 3],
        mirror_share: 0.9,
    };
    let glossy = mirror.add_material(material).unwrap();
    let mut sheet = halves(0.0);
    sheet.triangles.truncate(1);
    sheet.x = sheet.x.iter().map(|x| x + 30.0).collect();
    mirror.add_mesh(sheet, glossy).unwrap();
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| corner + Vec3::Z * 15.0);
    mirror.add_triangle(corners, white).unwrap();
    assert_no_edges(mirror, &above(false, 0.0));

    let (mut sphere, white) = builder();
    sphere.add_sphere(Vec3::ZERO, 0.7, white).unwrap();
    assert_no_edges(sphere, &above(false, 0.0));

    let (mut plane, white) = builder();
    plane.add_plane(Vec3::ZERO, Vec3::Z, white).unwrap();
    let level = Camera::look_at(DVec3::Z, DVec3::new(1.0, 0.0, 1.0), DVec3::Z, 60.0).unwrap();
    assert_no_edges(plane, &level);

    let (mut marked, white) = builder();
    let mut sheet = halves(0.0);
    sheet.triangles.truncate(1);
    marked.add_mesh_without_edges(sheet, white).unwrap();
    let far = Vec3::splat(-80.0);
    marked
        .add_triangle([far, far + Vec3::X, far + Vec3::Y], white)
        .unwrap();
    assert_no_edges(marked, &above(false, 0.0));
}

#[test]
fn half_transparent_surfaces_are_opaque_at_edges() {
    let mut builder = SceneBuilder::new();
    let pane = see_through(&mut builder, WHITE, 0.25);
    builder.add_mesh(halves(0.0), pane).unwrap();
    let settings = Settings {
        edges: Some(edges(3.0)),
        ..sized(SIDE, SIDE, 1)
    };
    let pixels = picture::<[f32; 4]>(&builder.finish(), &above(false, 0.0), settings);
    for (column, pixel) in (0..).zip(&pixels[..SIDE as usize]) {
        let cover = overlap(column, 3.0) as f32;
        let pane = 0.25 * (1.0 - cover);
        for (found, expected) in pixel.iter().zip([pane, pane, pane, pane + cover]) {
            assert!((found - expected).abs() < 1e-4, "{pixel:?} in column {column}");
        }
    }
}

/// A square of `count` x `count` cells of two triangles each fills the picture.
fn dense(count: u32) -> Scene {
    let at = |i: u32| 2.4 * (i as f32 / count as f32 - 0.5);
    let side = count + 1;
    scene_of(TriangleMesh {
        x: (0..side * side).map(|i| at(i % side)).collect(),
        y: (0..side * side).map(|i| at(i / side)).collect(),
        z: vec![0.0; (side * side) as usize],
        triangles: (0..side * count)
            .filter(|i| i % side < count)
            .flat_map(|i| [[i, i + 1, i + side + 1], [i, i + side + 1, i + side]])
            .collect(),
        ..TriangleMesh::default()
    })
}

#[test]
fn dense_meshes_do_not_turn_black() {
    for (count, is_clean) in [
        (1, false),
        (2, false),
        (5, false),
        (8, false),
        (24, true),
        (100, true),
    ] {
        let settings = Settings {
            edges: Some(edges(1.0)),
            ..sized(SIDE, SIDE, 16)
        };
        let all = reds(&dense(count), &above(false, 0.0), settings);
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        assert_eq!(mean == 1.0, is_clean, "{count}: {mean}");
        assert!(mean > 0.6, "{count}: {mean}");
    }
}

/// Coordinates and distances of any size make the same picture.
#[test]
fn edges_of_far_and_tiny_triangles_are_smooth() {
    let settings = Settings {
        edges: Some(edges(2.0)),
        ..sized(SIDE, SIDE, 4)
    };
    let expected = reds(&dense(2), &above(false, 0.0), settings);
    for scale in [1e-6, 1e6] {
        let scene = dense(2);
        let (mut builder, white) = builder();
        let scaled = |of: &[f32]| of.iter().map(|x| x * scale).collect();
        let vertices = scene.vertices();
        let mesh = TriangleMesh {
            x: scaled(&vertices.x),
            y: scaled(&vertices.y),
            z: scaled(&vertices.z),
            triangles: scene.triangles().corners.clone(),
            ..TriangleMesh::default()
        };
        builder.add_mesh(mesh, white).unwrap();
        let view = above(false, 0.0).view();
        let eye = view.eye * f64::from(scale);
        let camera = Camera::new(&View { eye, ..view }).unwrap();
        for (found, expected) in reds(&builder.finish(), &camera, settings).iter().zip(&expected) {
            assert!(
                (found - expected).abs() < 1e-3,
                "{scale}: {found}, not {expected}"
            );
        }
    }
}

#[test]
fn both_modes_draw_the_same_edges() {
    for (i, name) in SHIPPED.into_iter().enumerate() {
        let scene = shipped_scene(name);
        let camera = Camera::classic_view(i as u32 % 6 + 1).expect("views are 1 to 6");
        let sameness = Sameness::of(name, &scene);
        let [width, height] = rounds([67, 41], [149, 67]);
        for (samples, adaptive, width_of_edges) in [(1, false, 1.0), (9, true, 2.5)] {
            let settings = Settings {
                adaptive,
                pattern: if adaptive { Pattern::Sobol } else { Pattern::Grid },
                edges: Some(edges(width_of_edges)),
                ..sized(width, height, samples)
            };
            sameness.check(&camera, &settings);
        }
    }
}

#[test]
fn edges_out_of_range_are_refused() {
    let settings = |width, color| Settings {
        edges: Some(Edges { width, color }),
        ..Settings::default()
    };
    let grey = [0.5; 3];
    assert!(settings(MAX_EDGE_WIDTH, grey).validate().is_ok());
    assert!(settings(f32::MIN_POSITIVE, [0.0, 1.0, 0.5]).validate().is_ok());
    for width in [0.0, -1.0, f32::NAN, f32::INFINITY, MAX_EDGE_WIDTH.next_up()] {
        let error = settings(width, grey).validate().unwrap_err().to_string();
        assert!(error.contains("pixels wide"), "{error}");
    }
    for channel in [-0.1, 1.1, f32::NAN] {
        let error = settings(1.0, [0.5, channel, 0.5]).validate().unwrap_err();
        assert!(error.to_string().contains("of the colour"), "{error}");
    }
}
