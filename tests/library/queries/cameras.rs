//! The rays of cameras hit what pictures show.

use super::cube;
use glam::{DVec3, Vec3};
use octray::{
    Geometry, Hit, PrimitiveId, QueryError,
    accel::Bvh,
    render::{Renderer, Settings},
    scene::{
        Camera, Distortion, FitView, ImagePlane, Lens, MaterialId, PlacedMesh, Projection, Scene,
        SceneBuilder, TriangleMesh, View,
    },
};
use std::ops::ControlFlow;

const SIZE: [u32; 2] = [97, 64];

fn scene_of(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Scene {
    let axis = |axis: usize| positions.iter().map(|position| position[axis]).collect();
    let mut builder = SceneBuilder::new();
    let mesh = TriangleMesh {
        x: axis(0),
        y: axis(1),
        z: axis(2),
        triangles: triangles.to_vec(),
        ..TriangleMesh::default()
    };
    builder.add_mesh(mesh, MaterialId(0)).expect("a mesh");
    builder.finish()
}

/// A ball with dents that hide each other.
fn waves(at: Vec3) -> Vec3 {
    let bend = (5.0 * at.x).sin() + (4.0 * at.y).cos() * (3.0 * at.z).sin();
    at.normalize() * (1.0 + 0.2 * bend)
}

/// Cameras of every kind that look at `target` from 4 to the side.
fn cameras(target: DVec3) -> Vec<Camera> {
    let view = View {
        eye: target + DVec3::new(2.9, 1.7, 2.1),
        target,
        up: DVec3::Z,
        projection: Projection::Perspective { fov_degrees: 40.0 },
        lens: Lens::PINHOLE,
    };
    let parallel = View {
        projection: Projection::Orthographic { height: 2.5 },
        ..view
    };
    let lens = Lens {
        aperture: 0.1,
        focus: None,
    };
    let plane = ImagePlane {
        principal_offset: [0.1, -0.05],
        pixel_aspect: 1.25,
    };
    let barrel = Distortion::Perspective {
        radial: [-0.2, 0.03, 0.0, 0.0],
        divisor: [0.0; 3],
        tangential: [0.01, -0.02],
    };
    let fisheye = Distortion::Fisheye {
        radial: [0.05, -0.01, 0.0, 0.0],
    };
    let [pinhole, parallel] = [view, parallel].map(|view| Camera::new(&view).expect("a camera"));
    let with_lens = Camera::new(&View { lens, ..view }).expect("a camera");
    let on_plane = |camera: Camera| camera.with_image_plane(plane).expect("a plane");
    let distorted = |camera: Camera, by| camera.with_distortion(Some(by)).expect("a distortion");
    vec![
        pinhole,
        parallel,
        with_lens,
        on_plane(pinhole),
        on_plane(parallel),
        distorted(pinhole, barrel),
        distorted(on_plane(pinhole), fisheye),
    ]
}

/// The ids of a picture, and those of queries along the camera's rays.
fn ids(positions: &[[f32; 3]], triangles: &[[u32; 3]], camera: &Camera) -> [Vec<PrimitiveId>; 2] {
    let [width, height] = SIZE;
    let scene = scene_of(positions, triangles);
    let settings = Settings {
        width,
        height,
        ..Settings::default()
    };
    let bvh = Bvh::build(&scene);
    let aovs = Renderer::new(&scene, &bvh).aovs(camera, &settings, false, &|_| ControlFlow::Continue(()));
    let shown = aovs
        .expect("AOVs")
        .pixels
        .iter()
        .map(|pixel| pixel.primitive)
        .collect();
    let geometry = Geometry::from_triangles(positions, triangles).expect("a geometry");
    let rays = camera
        .rays_around(scene.origin().as_dvec3(), width, height)
        .expect("rays");
    let mut hits = vec![Hit::default(); rays.directions.len()];
    geometry.closest_hits(rays.rays(), &mut hits);
    [shown, hits.iter().map(|hit| hit.primitive).collect()]
}

#[test]
fn they_are_those_of_a_picture_at_zero() {
    let (scene, [width, height]) = (scene_of(&[], &[]), SIZE);
    for (i, camera) in cameras(DVec3::new(0.1, 0.2, 0.3)).iter().enumerate() {
        let rays = camera.rays(width, height).expect("rays");
        let pixels = camera.without_lens().pixel_rays(&scene, width, height, 1);
        let is_parallel = matches!(camera.view().projection, Projection::Orthographic { .. });
        assert_eq!(
            rays.origins.len(),
            if is_parallel { rays.directions.len() } else { 1 }
        );
        assert_eq!(rays.rays().len(), (width * height) as usize);
        for (pixel, &direction) in rays.directions.iter().enumerate() {
            let ray = pixels.ray(pixel as u32 % width, pixel as u32 / width, [0; 2]);
            let origin = rays.origins[if is_parallel { pixel } else { 0 }];
            assert_eq!(
                (origin.as_vec3(), direction),
                (ray.origin, ray.direction),
                "camera {i}, pixel {pixel}"
            );
        }
    }
}

#[test]
fn they_hit_what_pictures_show() {
    let (positions, triangles) = cube(24, waves);
    for (i, camera) in cameras(DVec3::ZERO).iter().enumerate() {
        let [shown, hit] = ids(&positions, &triangles, camera);
        assert!(
            shown.iter().filter(|&&id| id != PrimitiveId::NONE).count() > 500,
            "camera {i}"
        );
        assert_eq!(shown, hit, "camera {i}");
    }
}

#[test]
fn they_hit_what_pictures_show_far_from_zero() {
    let (positions, triangles) = cube(24, waves);
    let far = Vec3::new(4096.0, 0.0, -8192.0);
    let positions: Vec<_> = positions
        .iter()
        .map(|&p| (Vec3::from(p) + far).to_array())
        .collect();
    for (i, camera) in cameras(far.as_dvec3()).iter().enumerate() {
        let [shown, hit] = ids(&positions, &triangles, camera);
        let differ = shown.iter().zip(&hit).filter(|(shown, hit)| shown != hit).count();
        assert_eq!(differ, 0, "camera {i}");
    }
}

#[test]
fn pixels_that_see_nothing_hit_nothing() {
    let (positions, triangles) = cube(4, |at| at * 100.0);
    let geometry = Geometry::from_triangles(&positions, &triangles).expect("a geometry");
    let camera = Camera::look_at(DVec3::ZERO, DVec3::X, DVec3::Z, 100.0).expect("a camera");
    let folded = Distortion::Perspective {
        radial: [-0.5, 0.0, 0.0, 0.0],
        divisor: [0.0; 3],
        tangential: [0.0; 2],
    };
    let camera = camera.with_distortion(Some(folded)).expect("a distortion");
    let rays = camera.rays(32, 32).expect("rays");
    let mut hits = vec![Hit::default(); 32 * 32];
    geometry.closest_hits(rays.rays(), &mut hits);
    for (hit, direction) in hits.iter().zip(&rays.directions) {
        assert_eq!(hit.is_hit(), *direction != Vec3::ZERO);
    }
    let blind = rays
        .directions
        .iter()
        .filter(|&&direction| direction == Vec3::ZERO)
        .count();
    assert!((1..32 * 32).contains(&blind), "{blind}");
}

#[test]
fn sizes_are_checked() {
    for camera in cameras(DVec3::ZERO) {
        for [width, height] in [[0, 0], [0, 7], [7, 0], [u32::MAX, 0]] {
            if let Ok(rays) = camera.rays(width, height) {
                assert!(rays.rays().is_empty() && rays.origins.len() == 1);
            }
        }
        for [width, height] in [[u32::MAX, 1], [1, (1 << 23) + 1]] {
            let error = camera.rays(width, height).expect_err("too many pixels");
            assert_eq!(
                error.to_string(),
                "too many pixels along a side, at most 8388608 are supported"
            );
        }
        let all = camera.rays(1 << 23, 1 << 23);
        assert!(matches!(all, Err(QueryError::NoMemory { .. })));
        assert_eq!(camera.rays(1, 1).expect("a ray").directions.len(), 1);
    }
}

#[test]
fn rows_are_those_of_the_whole_picture() {
    let middle = DVec3::new(100.0, -20.0, 3.0);
    for camera in cameras(middle) {
        let whole = camera.rays_around(middle, 37, 20).expect("rays");
        let mut parts = (Vec::new(), Vec::new());
        for top in (0..20).step_by(7) {
            let rays = camera.rays_of_rows(middle, [37, 20], top..top + 7).expect("rays");
            parts.0.extend(rays.origins);
            parts.1.extend(rays.directions);
        }
        if whole.origins.len() == 1 {
            parts.0.truncate(1);
        }
        assert_eq!(parts, (whole.origins, whole.directions));
        assert!(
            camera
                .rays_of_rows(middle, [37, 20], 20..30)
                .expect("rays")
                .directions
                .is_empty()
        );
    }
}

#[test]
fn up_vectors_have_any_length() {
    let view = View {
        eye: DVec3::new(3.0, 2.0, 1.0),
        target: DVec3::ZERO,
        up: DVec3::new(1.0, 1.0, 1.0),
        projection: Projection::DEFAULT,
        lens: Lens::PINHOLE,
    };
    let near = |a: DVec3, b: DVec3| (a - b).length() < 1e-9;
    let sight = |view: &View| {
        Camera::new(view)
            .expect("a camera")
            .rays(2, 2)
            .expect("rays")
            .directions
    };
    let fitted = |up| {
        let view = FitView {
            towards_viewer: view.eye * up,
            up: DVec3::Y * up,
            fov_degrees: Some(40.0),
            aspect: 1.0,
        };
        let mesh = TriangleMesh {
            x: vec![1.0, 2.0],
            y: vec![0.0, 3.0],
            z: vec![2.0, 0.0],
            ..TriangleMesh::default()
        };
        let meshes = [PlacedMesh::in_place(&mesh)];
        view.fit_turning_around(&meshes, 0.0).expect("a fit").eye
    };
    for length in [f64::MAX, 1e300, 1e100, 1e-160, 1e-300, 5e-324] {
        let long = View {
            up: view.up * length,
            ..view
        };
        let difference = sight(&long)
            .into_iter()
            .zip(sight(&view))
            .map(|(a, b)| (a - b).length());
        assert!(difference.fold(0.0, f32::max) < 1e-6, "{length:e}");
        let length = length.clamp(1e-300, 1e300);
        assert!(near(fitted(length), fitted(1.0)), "{length:e}");
    }
    assert!(
        Camera::new(&View {
            up: DVec3::ZERO,
            ..view
        })
        .is_err()
    );
}
