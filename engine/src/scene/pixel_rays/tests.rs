use super::*;
use crate::scene::{Camera, CameraError, ImagePlane, Lens, Projection, SceneBuilder, View};
use glam::DVec3;

/// An image plane.
fn plane(right: f64, down: f64, pixel_aspect: f64) -> ImagePlane {
    ImagePlane {
        principal_offset: [right, down],
        pixel_aspect,
    }
}

/// Slopes of a direction: right and up per unit forward of a camera with a centred image plane.
fn slopes(rays: &PixelRays, direction: Vec3) -> [f64; 2] {
    let along = |axis: Vec3| direction.as_dvec3().dot(axis.as_dvec3());
    [along(rays.right), along(rays.up)].map(|slope| slope / along(rays.forward))
}

#[test]
fn corners_are_around_all_rays() {
    let scene = SceneBuilder::new().finish();
    let mut random = fastrand::Rng::with_seed(3);
    let mut compared = 0;
    let far = [
        plane(0.3, -0.7, 1.7),
        plane(-40.0, 3.0, 0.02),
        plane(1.0, 90.0, 500.0),
    ];
    for (fov, [width, height], samples, plane) in [
        (45.0, [1920, 1080], 1, ImagePlane::CENTERED),
        (45.0, [33, 21], 5, ImagePlane::CENTERED),
        (1e-5, [640, 480], 1, ImagePlane::CENTERED),
        (179.9, [1000, 700], 2, ImagePlane::CENTERED),
        (60.0, [1 << 23, 3], 1, ImagePlane::CENTERED),
        (1e-3, [3, 1 << 21], 4, ImagePlane::CENTERED),
        (45.0, [640, 480], 1, far[0]),
        (120.0, [640, 480], 3, far[1]),
        (1e-2, [640, 480], 1, far[1]),
        (2.0, [1000, 700], 1, far[2]),
    ] {
        let [eye, target] = [DVec3::new(3.0, -2.0, 1.0), DVec3::new(0.1, 0.2, 0.3)];
        let camera = Camera::look_at(eye, target, DVec3::Z, fov).unwrap();
        let axes = camera.pixel_rays(&scene, width, height, samples);
        let camera = camera.with_image_plane(plane).unwrap();
        let rays = camera.pixel_rays(&scene, width, height, samples);
        for _ in 0..500 {
            let first = [random.u32(0..width), random.u32(0..height)];
            let size = [
                random.u32(1..=128.min(width - first[0])),
                random.u32(1..=16.min(height - first[1])),
            ];
            let corners = rays.corners(first, size);
            if !corners.iter().all(|corner| corner.is_finite()) {
                continue;
            }
            let corners = corners.map(|corner| slopes(&axes, corner));
            compared += 1;
            for _ in 0..20 {
                let [x, y] = [0, 1].map(|axis| first[axis] + random.u32(0..size[axis]));
                let sample = [(); 2].map(|()| random.u32(0..samples));
                let direction = if samples == 1 {
                    // The reach of the widest filter.
                    let offset = [(); 2].map(|()| 6.0 * random.f32() - 3.0);
                    rays.ray_at(Portable, [x, y], sample, offset, [0.0; 2]).direction
                } else {
                    rays.direction(x, y, sample)
                };
                for (axis, slope) in slopes(&axes, direction).into_iter().enumerate() {
                    let of_corners = corners.iter().map(|corner| corner[axis]);
                    let least = of_corners.clone().fold(f64::INFINITY, f64::min);
                    let largest = of_corners.fold(f64::NEG_INFINITY, f64::max);
                    assert!(
                        least < slope && slope < largest,
                        "{fov}, {plane:?}, {first:?}: {slope} of {least} to {largest}"
                    );
                }
            }
        }
    }
    assert!(compared > 3500, "{compared}");
}

#[test]
fn parallel_rays_leave_a_plane() {
    let scene = SceneBuilder::new().finish();
    let camera = Camera::new(&View {
        eye: DVec3::new(1.0, 2.0, 3.0),
        target: DVec3::new(1.0, 7.0, 3.0),
        up: DVec3::Z,
        projection: Projection::Orthographic { height: 4.0 },
        lens: Lens::PINHOLE,
    });
    let rays = camera.unwrap().pixel_rays(&scene, 6, 8, 1);
    assert_eq!(rays.shared_origin(), None);
    assert_eq!((rays.cone().width(0.0), rays.cone().width(100.0)), (0.5, 0.5));
    for y in 0..8 {
        for x in 0..6 {
            let ray = rays.ray(x, y, [0, 0]);
            let [right, down] = [x, y].map(|i| i as f32 * 0.5);
            assert_eq!(ray.origin, Vec3::new(-0.25 + right, 2.0, 4.75 - down));
            assert_eq!(ray.direction, Vec3::Y);
        }
    }
    let offset = [F32x8::new([0.5; LANES]), F32x8::ZERO];
    let middle = [Portable.splat(0.0); 2];
    let (origin, direction) = rays.rays(Portable, [2, 4], [0, 0], &offset, middle);
    for lane in 0..LANES {
        let pixel = [2 + lane as u32 % 4, 4 + lane as u32 / 4];
        let ray = rays.ray_at(Portable, pixel, [0, 0], [0.5, 0.0], [0.0; 2]);
        assert_eq!(
            (origin.lane(lane), direction.lane(lane)),
            (ray.origin, ray.direction)
        );
    }
}

/// All rays of a pixel meet in the plane in focus, at the point of the ray through the lens's centre.
#[test]
fn rays_through_a_lens_meet_in_focus() {
    let scene = SceneBuilder::new().finish();
    let mut random = fastrand::Rng::with_seed(8);
    let planes = [ImagePlane::CENTERED, plane(0.4, -0.2, 1.5)];
    for projection in [Projection::DEFAULT, Projection::Orthographic { height: 4.0 }] {
        for (focus, plane) in [None, Some(3.0)]
            .into_iter()
            .zip(planes)
            .chain([(Some(3.0), planes[0]), (None, planes[1])])
        {
            let lens = Lens { aperture: 0.5, focus };
            let view = View {
                eye: DVec3::new(1.0, 2.0, 3.0),
                target: DVec3::new(1.0, 7.0, 3.0),
                up: DVec3::Z,
                projection,
                lens,
            };
            let camera = Camera::new(&view).unwrap().with_image_plane(plane).unwrap();
            let rays = camera.pixel_rays(&scene, 6, 8, 1);
            assert_eq!(rays.shared_origin(), None);
            let in_focus = |ray: Ray| {
                let distance = focus.unwrap_or(5.0) as f32 / ray.direction.y;
                ray.origin + ray.direction * distance
            };
            for _ in 0..200 {
                let pixel @ [x, y] = [random.u32(0..6), random.u32(0..8)];
                let middle = rays.ray(x, y, [0, 0]);
                let point = [(); 2].map(|()| random.f32() - 0.5);
                let ray = rays.ray_at(Portable, pixel, [0, 0], [0.0; 2], point);
                assert!(in_focus(ray).distance(in_focus(middle)) < 1e-5);
                let expected = middle.origin + Vec3::new(point[0], 0.0, point[1]) * 0.25;
                assert!(ray.origin.distance(expected) < 1e-6);
                let lens = point.map(|c| Portable.splat(c));
                let offset = [F32x8::ZERO; 2];
                let (origins, directions) = rays.rays_of(Portable, &[pixel; LANES], &offset, lens);
                assert_eq!((origins.lane(3), directions.lane(3)), (ray.origin, ray.direction));
            }
        }
    }
}

/// Rays go through the points that the pinhole model of COLMAP and Nerfstudio projects to their pixels.
#[test]
fn rays_follow_the_intrinsics() {
    let scene = SceneBuilder::new().finish();
    let [eye, target] = [DVec3::ZERO, DVec3::Y];
    let camera = Camera::look_at(eye, target, DVec3::Z, 50.0).unwrap();
    for plane in [
        ImagePlane::CENTERED,
        plane(0.25, -0.1, 1.0),
        plane(-0.6, 0.3, 0.7),
    ] {
        let camera = camera.with_image_plane(plane).unwrap();
        assert_eq!(camera.image_plane(), plane);
        let [width, height] = [320, 200];
        let intrinsics = camera.intrinsics(width, height).unwrap();
        let ([fl_x, fl_y], [cx, cy]) = (intrinsics.focal, intrinsics.principal_point);
        assert!((fl_y / fl_x - plane.pixel_aspect).abs() < 1e-12);
        assert!((cx - (160.0 + 200.0 * plane.principal_offset[0])).abs() < 1e-9);
        assert!((cy - (100.0 + 200.0 * plane.principal_offset[1])).abs() < 1e-9);
        let rays = camera.pixel_rays(&scene, width, height, 1);
        for [x, y] in [[0, 0], [319, 0], [0, 199], [319, 199], [97, 143]] {
            let direction = rays.direction(x, y, [0, 0]).as_dvec3();
            let seen = [direction.x, -direction.z].map(|side| side / direction.y);
            let [u, v] = [fl_x * seen[0] + cx, fl_y * seen[1] + cy];
            let off = (u - f64::from(x) - 0.5).hypot(v - f64::from(y) - 0.5);
            assert!(off < 1e-3, "{plane:?} {x} {y}: {u} {v}");
        }
    }
    let parallel = View {
        projection: Projection::Orthographic { height: 2.0 },
        ..camera.view()
    };
    let parallel = Camera::new(&parallel)
        .unwrap()
        .with_image_plane(plane(0.5, 0.25, 2.0));
    let parallel = parallel.unwrap();
    assert_eq!(parallel.intrinsics(4, 4), None);
    // Heights are 2 units, pixels 1 x 0.5: the axis is 2 pixels right of the centre and 1 below it.
    let ray = parallel.pixel_rays(&scene, 4, 4, 1).ray(0, 0, [0, 0]);
    assert_eq!((ray.origin, ray.direction), (Vec3::new(-3.5, 0.0, 1.25), Vec3::Y));
}

#[test]
fn image_planes_are_checked() {
    let camera = Camera::classic_view(1).unwrap();
    let refused = |plane| camera.with_image_plane(plane).err();
    for offset in [[f64::NAN, 0.0], [0.0, -101.0], [f64::INFINITY, 0.0]] {
        let error = refused(plane(offset[0], offset[1], 1.0));
        assert!(
            matches!(error, Some(CameraError::PrincipalOffset(_))),
            "{offset:?}"
        );
    }
    for aspect in [f64::NAN, 0.0, -1.0, 1e-4, 1e4] {
        let error = refused(plane(0.0, 0.0, aspect));
        assert!(matches!(error, Some(CameraError::PixelAspect(_))), "{aspect}");
    }
}
