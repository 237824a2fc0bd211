use glam::Vec3;
use octray::{
    Level,
    accel::Bvh,
    lanes::{F32x8, LANES, Vec3x8},
    ray::{Origins, RayPacket},
    scene::SceneBuilder,
    trace::{Method, Tracer},
};

/// From two lights in turn to points behind a large triangle, and behind many small ones, and beside them.
#[test]
fn bundles_are_blocked_where_single_rays_are() {
    let mut random = fastrand::Rng::with_seed(11);
    let mut unit = move || random.f32() * 2.0 - 1.0;
    let mut builder = SceneBuilder::new();
    let material = builder.classic_material(1).unwrap();
    let large = [[-2.0, -2.0], [0.5, -2.0], [-2.0, 2.0]].map(|[x, y]| Vec3::new(x, y, 1.0));
    builder.add_triangle(large, material).unwrap();
    for _ in 0..2000 {
        let at = Vec3::new(unit() * 2.0, unit() * 2.0, 0.5 + 0.1 * unit());
        let mut corner = || at + Vec3::new(unit(), unit(), unit()) * 0.05;
        builder
            .add_triangle([corner(), corner(), corner()], material)
            .unwrap();
    }
    let scene = builder.finish();
    let bvh = Bvh::build(&scene);
    let lights = [Vec3::new(0.3, 0.2, 5.0), Vec3::new(-3.0, 1.0, 4.0)];
    // In rows; the last ones are behind the large triangle.
    let to_points = |light: Vec3| -> Vec<RayPacket> {
        (0..512_usize)
            .map(|i| {
                let ends: [Vec3; LANES] = std::array::from_fn(|lane| {
                    let (x, y) = (i % 32 * 4 + lane % 4, 31 - (i / 32 * 2 + lane / 4));
                    Vec3::new(x as f32 / 32.0 - 2.0, y as f32 / 8.0 - 2.0, 0.0) - light
                });
                RayPacket {
                    direction: Vec3x8::from_lanes(ends.map(Vec3::normalize)),
                    t_max: F32x8::from(ends.map(Vec3::length)),
                }
            })
            .collect()
    };
    let blocked = |tracer: &mut Tracer<'_>, light: Vec3| {
        let rays = to_points(light);
        let mut blocked = vec![0; rays.len()];
        tracer.occluded(Origins::Shared(light), &rays, &mut blocked);
        blocked
    };
    let expected = lights.map(|light| blocked(&mut Tracer::with_method(&bvh, Method::Single), light));
    for expected in &expected {
        let count: u32 = expected.iter().map(|bits: &u8| bits.count_ones()).sum();
        assert!((1000..3500).contains(&count), "{count}");
    }
    for level in Level::all() {
        let mut tracer = Tracer::new(&bvh).at_level(level);
        for round in 0..6 {
            let light = round % 2;
            let own = blocked(&mut tracer, lights[light]);
            assert!(own == expected[light], "{level} {round}");
        }
    }
}
