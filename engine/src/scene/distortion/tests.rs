use super::*;
use crate::{
    lanes::{F32x8, LANES},
    ray::T_MAX,
    scene::{Camera, ImagePlane, Lens, PixelRays, Projection, SceneBuilder, View},
};
use glam::Vec3;

fn brown(radial: [f64; 4], divisor: [f64; 3], tangential: [f64; 2]) -> Distortion {
    Distortion::Perspective {
        radial,
        divisor,
        tangential,
    }
}

fn radial(k1: f64, k2: f64) -> Distortion {
    brown([k1, k2, 0.0, 0.0], [0.0; 3], [0.0; 2])
}

fn fisheye(radial: [f64; 4]) -> Distortion {
    Distortion::Fisheye { radial }
}

/// A camera at the origin with these focal lengths and principal point in pictures of 640x480.
fn camera([fl_x, fl_y, cx, cy]: [f64; 4], distortion: Distortion) -> Camera {
    let view = View {
        eye: DVec3::ZERO,
        target: DVec3::Y,
        up: DVec3::Z,
        projection: Projection::Perspective {
            fov_degrees: 2.0 * (240.0 / fl_y).atan().to_degrees(),
        },
        lens: Lens::PINHOLE,
    };
    let plane = ImagePlane {
        principal_offset: [(cx - 320.0) / 480.0, (cy - 240.0) / 480.0],
        pixel_aspect: fl_y / fl_x,
    };
    let camera = Camera::new(&view).unwrap().with_image_plane(plane).unwrap();
    camera.with_distortion(Some(distortion)).unwrap()
}

const SIZE: [u32; 2] = [640, 480];

/// The pixel of a direction that is not beyond the distortion's end, by the models' definition.
fn projected(camera: &Camera, direction: DVec3) -> [f64; 2] {
    let intrinsics = camera.intrinsics(SIZE[0], SIZE[1]).unwrap();
    let inverse = Inverse::new(camera.distortion().unwrap()).unwrap();
    let DVec3 { x, y, z } = direction;
    let across = x.hypot(y);
    let scale = match inverse.distortion {
        Distortion::Perspective { .. } => 1.0 / z,
        Distortion::Fisheye { .. } if across == 0.0 => 0.0,
        Distortion::Fisheye { .. } => across.atan2(z) / across,
    };
    let point = inverse.distort([x * scale, y * scale]).point;
    [0, 1].map(|axis| intrinsics.focal[axis] * point[axis] + intrinsics.principal_point[axis])
}

/// What `pycolmap.Camera.img_from_cam` of pycolmap 4.2.1 prints for [`POINTS`], the last one only for fisheye lenses.
/// `cv2.projectPoints` and `cv2.fisheye.projectPoints` print the same.
#[test]
fn points_are_seen_where_colmap_projects_them() {
    const POINTS: [[f64; 3]; 6] = [
        [0.0, 0.0, 1.0],
        [0.3, -0.2, 1.0],
        [-0.55, 0.42, 1.0],
        [0.1, 0.45, 1.0],
        [-0.6, -0.44, 1.0],
        [1.0, -0.8, 0.2],
    ];
    for (lens, distortion, pixels) in colmap_pixels() {
        let camera = camera(lens, distortion);
        for (&[x, y, z], &pixel) in POINTS.iter().zip(&pixels) {
            let direction = DVec3::new(x, y, z).normalize();
            let seen = camera.sight(pixel, SIZE).expect("it is projected there");
            assert!(seen.distance(direction) < 1e-10, "{distortion:?}: {pixel:?}");
            let again = projected(&camera, seen);
            let off = (again[0] - pixel[0]).hypot(again[1] - pixel[1]);
            assert!(off < 1e-9, "{distortion:?}: {pixel:?} {again:?}");
        }
    }
}

type Projected = ([f64; 4], Distortion, Vec<[f64; 2]>);

#[expect(clippy::too_many_lines, reason = "numbers")]
fn colmap_pixels() -> [Projected; 8] {
    let centered = [500.0, 500.0, 320.0, 240.0];
    let square = |f: f64| [f, f, 310.0, 235.0];
    let oblong = [500.0, 510.0, 310.0, 235.0];
    [
        (
            centered,
            radial(-0.12, 0.0),
            vec![
                [320.0, 240.0],
                [467.66, 141.56],
                [60.8037, 437.93172],
                [368.725, 459.2625],
                [39.9296, 34.61504],
            ],
        ),
        (
            square(500.0),
            radial(-0.25, 0.08),
            vec![
                [310.0, 235.0],
                [455.3278, 138.1148],
                [62.87878038, 423.710749528],
                [357.524375, 448.8596875],
                [44.16464896, 40.054075904],
            ],
        ),
        (
            oblong,
            brown([-0.2, 0.06, 0.0, 0.0], [0.0; 3], [0.0015, -0.002]),
            vec![
                [310.0, 235.0],
                [455.8521, 135.831622],
                [56.124904035, 432.738959139],
                [357.84546875, 455.7486390625],
                [36.82188672, 31.500368067],
            ],
        ),
        (
            oblong,
            brown([0.4, -0.05, 0.01, 0.0], [0.55, -0.03, 0.004], [0.001, -0.002]),
            vec![
                [310.0, 235.0],
                [456.853419481, 135.117574753],
                [50.260725588, 437.184501542],
                [358.345945577, 457.991640197],
                [29.396394378, 25.804931794],
            ],
        ),
        (
            square(200.0),
            fisheye([0.0; 4]),
            vec![
                [310.0, 235.0],
                [367.58569014, 196.609539907],
                [213.776789668, 308.479542435],
                [328.740405194, 319.331823375],
                [206.832138004, 159.34356787],
                [531.122370022, 58.102103983],
            ],
        ),
        (
            square(200.0),
            fisheye([-0.02, 0.0, 0.0, 0.0]),
            vec![
                [310.0, 235.0],
                [367.447774165, 196.70148389],
                [214.482016763, 307.941005381],
                [328.670474817, 319.017136679],
                [207.676438174, 159.962721328],
                [522.256693241, 65.194645408],
            ],
        ),
        (
            square(200.0),
            fisheye([0.02, -0.004, 0.0, 0.0]),
            vec![
                [310.0, 235.0],
                [367.72030307, 196.519797953],
                [213.123249194, 308.978609706],
                [328.807726099, 319.634767443],
                [206.056933265, 158.775084394],
                [536.433443766, 53.853244987],
            ],
        ),
        (
            [200.0, 205.0, 310.0, 235.0],
            fisheye([0.02, -0.01, 0.003, -0.0002]),
            vec![
                [310.0, 235.0],
                [367.715642784, 195.560977431],
                [213.186920604, 310.7782376],
                [328.804172497, 321.734245643],
                [206.139950113, 156.931862502],
                [535.731706326, 49.900000813],
            ],
        ),
    ]
}

#[test]
fn a_pinhole_sees_straight() {
    let camera = camera([500.0, 400.0, 310.0, 250.0], radial(0.1, 0.0));
    let camera = camera.with_distortion(None).unwrap();
    let seen = camera.sight([410.0, 150.0], SIZE).unwrap();
    assert!(
        seen.distance(DVec3::new(0.2, -0.25, 1.0).normalize()) < 1e-12,
        "{seen}"
    );
    let view = View {
        projection: Projection::Orthographic { height: 2.0 },
        ..camera.view()
    };
    assert_eq!(Camera::new(&view).unwrap().sight([410.0, 150.0], SIZE), None);
}

/// Every pixel of pictures with lenses as they are sold, and the share of pixels that see something.
#[test]
fn what_is_seen_is_projected_back() {
    for (focal, distortion, share) in [
        (500.0, radial(-0.28, 0.07), 1.0),
        (
            400.0,
            brown([0.12, -0.3, 0.4, -0.1], [0.0; 3], [1e-3, -2e-3]),
            1.0,
        ),
        (
            450.0,
            brown([-0.4, 0.2, -0.05, 0.0], [0.0; 3], [-0.003, 0.002]),
            1.0,
        ),
        (
            450.0,
            brown([12.0, 7.0, 0.4, 0.0], [12.3, 9.0, 1.5], [1e-4, 0.0]),
            1.0,
        ),
        (
            2000.0,
            brown([0.5, 30.0, -400.0, 0.0], [0.0; 3], [2e-3, 1e-3]),
            1.0,
        ),
        (300.0, fisheye([0.03, -0.01, 2e-3, -2e-4]), 1.0),
        // The whole circle is in the picture: its radius is 70 pi = 219.9 pixels.
        (70.0, fisheye([0.0; 4]), 0.4946),
        // A circle of radius 400 * 0.70 = 281 pixels, cut by the picture's edges.
        (400.0, radial(-0.3, 0.0), 0.76),
    ] {
        let camera = camera([focal, 1.02 * focal, 325.5, 238.0], distortion);
        let mut seen = 0;
        for y in (0..SIZE[1]).step_by(3) {
            for x in (0..SIZE[0]).step_by(2) {
                let pixel = [x, y].map(|at| f64::from(at) + 0.5);
                let Some(direction) = camera.sight(pixel, SIZE) else {
                    continue;
                };
                seen += 1;
                let again = projected(&camera, direction);
                let off = (again[0] - pixel[0]).hypot(again[1] - pixel[1]);
                assert!(off < 1e-6, "{distortion:?}: {pixel:?} {again:?}");
            }
        }
        let found = f64::from(seen) / f64::from(SIZE[0] / 2 * (SIZE[1] / 3));
        assert!((found - share).abs() < 0.01, "{distortion:?}: {found}");
    }
}

/// Whatever the coefficients, each radius before the end is found, and none beyond.
#[test]
fn all_radii_up_to_the_end_are_found() {
    let mut random = fastrand::Rng::with_seed(7);
    let (mut ends, mut found) = (0, 0);
    for round in 0..3000 {
        let mut number = || {
            let size = 10.0_f64.powf(4.0 * random.f64() - 3.0);
            if random.bool() { size } else { -size }
        };
        let numerator = [(); 4].map(|()| number());
        let distortion = match round % 3 {
            0 => brown(numerator, [0.0; 3], [0.0; 2]),
            1 => brown(numerator, [(); 3].map(|()| number()), [0.0; 2]),
            _ => fisheye(numerator),
        };
        let inverse = Inverse::new(distortion).unwrap();
        let rim = |r: f64| r * inverse.quotient(r * r).value;
        let most = if round % 3 == 2 { PI } else { MAX_SLOPE };
        ends += u32::from(inverse.end < most);
        let near = inverse.end.min(3.0);
        let mut last = 0.0;
        for i in 1..100 {
            let radius = near * f64::from(i) / 100.0;
            let distorted = rim(radius);
            assert!(distorted > last, "{distortion:?}: {radius} {}", inverse.end);
            last = distorted;
            let [[x], [y]] = inverse.undistorted(&[[0.6 * distorted], [0.8 * distorted]]);
            // Close to the end, a radius is hardly determined by the distorted one.
            let off = (x - 0.6 * radius).hypot(y - 0.8 * radius);
            assert!(off < 1e-6 * radius, "{distortion:?}: {radius} {off}");
            let [direction] = inverse.directions(&[[0.6 * distorted], [0.8 * distorted]]);
            assert!(
                (direction.length() - 1.0).abs() < 1e-12,
                "{distortion:?}: {radius}"
            );
            found += 1;
        }
        // Past a turn, not past a pole.
        let end = rim(inverse.end);
        if inverse.end < 100.0 && end < 1e3 {
            assert!(end > 0.0, "{distortion:?}: {end}");
            assert_eq!(
                inverse.directions(&[[1.001 * end], [0.0]]),
                [DVec3::ZERO],
                "{distortion:?}"
            );
            let just_after = rim(inverse.end * 1.0001);
            assert!(just_after <= end || inverse.end == most, "{distortion:?}");
        }
    }
    assert!(ends > 1000 && ends < 2900, "{ends}");
    assert_eq!(found, 3000 * 99);
}

#[test]
fn points_beyond_the_monotonic_range_see_nothing() {
    // r (1 - 0.3 r²) is largest at 1 / sqrt(0.9).
    let inverse = Inverse::new(radial(-0.3, 0.0)).unwrap();
    assert!((inverse.end - 1.0 / 0.9_f64.sqrt()).abs() < 1e-12);
    let sees = |radius: f64| inverse.directions(&[[0.0], [radius]])[0] != DVec3::ZERO;
    assert!(sees(0.0) && sees(0.7027) && !sees(0.7028) && !sees(50.0) && !sees(f64::NAN) && !sees(1e300));
    // A pole at 2, which no direction passes.
    let pole = Inverse::new(brown([0.0; 4], [-0.25, 0.0, 0.0], [0.0; 2])).unwrap();
    let [far] = pole.directions(&[[1e5], [0.0]]);
    assert!((far.x / far.z - 2.0).abs() < 1e-4, "{far}");
    // The angle itself, up to straight back.
    let round = Inverse::new(fisheye([0.0; 4])).unwrap();
    let [side, back, none] = round.directions(&[[0.0, 3.0, 3.15], [-0.5 * PI, 0.0, 0.0]]);
    assert!(side.distance(DVec3::NEG_Y) < 1e-12);
    assert!(back.distance(DVec3::new(3.0_f64.sin(), 0.0, 3.0_f64.cos())) < 1e-12);
    assert_eq!(none, DVec3::ZERO);
    assert_eq!(round.directions(&[[0.0]; 2]), [DVec3::Z]);
}

#[test]
fn distortions_are_checked() {
    let camera = Camera::classic_view(1).unwrap();
    let refused = |camera: Camera, distortion| camera.with_distortion(Some(distortion)).err();
    for wrong in [f64::NAN, f64::INFINITY, -1e13] {
        for distortion in [
            radial(wrong, 0.0),
            brown([0.0; 4], [0.0, 0.0, wrong], [0.0; 2]),
            brown([0.0; 4], [0.0; 3], [0.0, wrong]),
            fisheye([0.0, 0.0, 0.0, wrong]),
        ] {
            let error = refused(camera, distortion);
            assert!(
                matches!(error, Some(CameraError::Distortion(_))),
                "{distortion:?}"
            );
        }
    }
    for distortion in [brown([1e12; 4], [1e12; 3], [1e12; 2]), fisheye([-1e12; 4])] {
        let camera = camera.with_distortion(Some(distortion)).unwrap();
        assert_eq!(camera.distortion(), Some(distortion));
        assert_eq!(camera.sight([320.0, 240.0], SIZE), Some(DVec3::Z));
        assert_eq!(camera.with_distortion(None).unwrap().distortion(), None);
    }
    let parallel = View {
        projection: Projection::Orthographic { height: 2.0 },
        ..camera.view()
    };
    let aperture = View {
        lens: Lens {
            aperture: 0.1,
            focus: None,
        },
        ..camera.view()
    };
    for view in [parallel, aperture] {
        let camera = Camera::new(&view).unwrap();
        assert_eq!(
            refused(camera, radial(0.1, 0.0)),
            Some(CameraError::DistortedProjection)
        );
        assert_eq!(camera.with_distortion(None), Ok(camera));
    }
}

fn rays(distortion: Distortion, samples: u32) -> (Camera, PixelRays) {
    let camera = camera([180.0, 200.0, 335.0, 221.0], distortion);
    (
        camera,
        camera.pixel_rays(&SceneBuilder::new().finish(), SIZE[0], SIZE[1], samples),
    )
}

/// Whatever the tangential part, a point is found if the distortion is monotonic on the way to it, and nothing else is.
#[test]
fn all_points_before_the_fold_are_found() {
    let mut random = fastrand::Rng::with_seed(11);
    let mut number = |most: f64| most * (2.0 * random.f64() - 1.0);
    let (mut found, mut folded) = (0, 0);
    for _ in 0..300 {
        let radial = [number(0.4), number(0.2), 0.0, 0.0];
        let inverse = Inverse::new(brown(radial, [0.0; 3], [number(0.15), number(0.15)])).unwrap();
        for _ in 0..30 {
            let point = [number(2.0), number(2.0)];
            let way = (1..=200).map(|part| point.map(|at| at * f64::from(part) / 200.0));
            let is_monotonic = |at: [f64; 2]| inverse.distort(at).is_monotonic();
            let is_before = way.clone().all(is_monotonic);
            let [[x], [y]] = inverse.distort(point).point.map(|at| [at]);
            let [direction] = inverse.directions(&[[x], [y]]);
            let off = (direction - inverse.direction(point)).length();
            if is_before {
                // At the fold itself it is hardly determined.
                let Distorted { a, b, c, .. } = inverse.distort(point);
                assert!(
                    off < 1e-6 || a * c - b * b < 1e-2,
                    "{inverse:?} {point:?} {direction}"
                );
                found += 1;
            } else if way.clone().filter(|&at| !is_monotonic(at)).count() > 10 {
                assert!(off > 1e-9, "{inverse:?} {point:?}");
                folded += 1;
            }
        }
    }
    assert!(found > 3000 && folded > 500, "{found} {folded}");
}

/// Rays are those of [`Camera::sight`], and those of eight pixels the same as those of one.
#[test]
fn distorted_rays_are_what_the_camera_sees() {
    let mut random = fastrand::Rng::with_seed(5);
    for distortion in [
        radial(-0.28, 0.07),
        brown([-0.2, 0.06, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0015, -0.002]),
        fisheye([0.02, -0.01, 0.003, -0.0002]),
        fisheye([-0.05, 0.0, 0.0, 0.0]),
    ] {
        for samples in [1, 3] {
            let (camera, rays) = rays(distortion, samples);
            assert_eq!(rays.shared_origin(), Some(Vec3::ZERO));
            let mut blind = 0;
            for _ in 0..500 {
                let [x, y] = [random.u32(0..636), random.u32(0..478)];
                let sample = [(); 2].map(|()| random.u32(0..samples));
                let all = rays.directions8(x, y, sample);
                let pixels = std::array::from_fn(|lane| [x + lane as u32 % 4, y + lane as u32 / 4]);
                let offset = [F32x8::ZERO; 2];
                let packet = rays.distorted(&pixels, sample, &offset, F32x8::splat(T_MAX));
                for lane in 0..LANES {
                    let pixel = pixels[lane];
                    let direction = rays.direction(pixel[0], pixel[1], sample);
                    let ray = rays.ray(pixel[0], pixel[1], sample);
                    assert_eq!(all.lane(lane), direction);
                    assert_eq!(packet.direction.lane(lane), ray.direction);
                    assert_eq!(packet.t_max.as_array()[lane], ray.t_max);
                    let point = [0, 1].map(|axis| {
                        f64::from(pixel[axis]) + (f64::from(sample[axis]) + 0.5) / f64::from(samples)
                    });
                    let Some(seen) = camera.sight(point, SIZE) else {
                        blind += 1;
                        assert_eq!(
                            (direction, ray.direction, ray.t_max),
                            (Vec3::ZERO, Vec3::Y, BLIND)
                        );
                        continue;
                    };
                    let Vec3 { x, y, z } = direction;
                    let again = projected(&camera, Vec3::new(x, -z, y).as_dvec3());
                    let off = (again[0] - point[0]).hypot(again[1] - point[1]);
                    assert!(off < 1e-3, "{distortion:?}: {point:?} {again:?}");
                    assert!(direction.as_dvec3().distance(DVec3::new(seen.x, seen.z, -seen.y)) < 1e-3);
                    assert_eq!((ray.direction, ray.t_max), (direction, T_MAX));
                }
            }
            let has_end = distortion == fisheye([-0.05, 0.0, 0.0, 0.0]);
            assert_eq!(blind > 0, has_end, "{distortion:?}");
        }
    }
}

/// The end of rays that see nothing.
const BLIND: f32 = f32::MIN_POSITIVE;

/// No cone of four corners is around rays that bend, so empty tiles are traced.
#[test]
fn distorted_tiles_have_no_corners() {
    for distortion in [radial(0.2, 0.0), fisheye([0.0; 4])] {
        let (_, rays) = rays(distortion, 1);
        for corner in rays.corners([0, 0], [64, 16]) {
            assert!(corner.is_nan());
        }
    }
}
