use glam::Vec3;
use octray::{
    Level,
    accel::Bvh,
    lanes::{F32x8, LANES, Vec3x8},
    ray::{Hit, HitPacket, Origins, Ray, RayPacket, RayPackets},
    scene::SceneBuilder,
    trace::{Method, Tracer, order},
};

/// From a light to points among long thin triangles: several groups, and lanes and packets without a ray.
#[test]
fn sorted_shadow_rays_are_blocked_as_others_are() {
    let mut random = fastrand::Rng::with_seed(5);
    let mut unit = move || random.f32() * 2.0 - 1.0;
    let mut vector = move || Vec3::new(unit(), unit(), unit());
    let mut builder = SceneBuilder::new();
    let material = builder.classic_material(1).unwrap();
    for _ in 0..3000 {
        let (at, along) = (vector(), vector() * 0.5);
        let corners = [at - along, at + along, at + vector() * 0.01];
        builder.add_triangle(corners, material).unwrap();
    }
    let scene = builder.finish();
    let bvh = Bvh::build(&scene);
    let light = Vec3::new(2.0, 3.0, 4.0);
    let packets = 3 * order::PACKETS + 7;
    let rays: Vec<RayPacket> = (0..packets)
        .map(|i| {
            let to = [(); LANES].map(|()| vector() * 0.5 - light);
            let mut t_max = to.map(Vec3::length);
            t_max[i % LANES] = 0.0;
            RayPacket {
                direction: Vec3x8::from_lanes(to.map(Vec3::normalize)),
                t_max: if i % 9 == 0 {
                    F32x8::ZERO
                } else {
                    F32x8::from(t_max)
                },
            }
        })
        .collect();
    let separate = vec![Vec3x8::splat(-light); packets];
    // From the light, from the other side, and from the light again.
    let blocked = |tracer: &mut Tracer<'_>| {
        [
            Origins::Shared(light),
            Origins::Separate(&separate),
            Origins::Shared(light + Vec3::X),
            Origins::Shared(light),
        ]
        .map(|origins| {
            let mut blocked = vec![0; packets];
            tracer.occluded(origins, &rays, &mut blocked);
            blocked
        })
    };
    let expected = blocked(&mut Tracer::with_method(&bvh, Method::Packet));
    let count: u32 = expected[0].iter().map(|bits| bits.count_ones()).sum();
    assert!((5000..8000).contains(&count), "{count}");
    for level in Level::all() {
        let mut tracer = Tracer::new(&bvh).at_level(level);
        assert!(!tracer.has_sorted());
        let mut first = vec![0; packets];
        tracer.occluded(Origins::Shared(light), &rays, &mut first);
        assert!(tracer.has_sorted(), "nothing was sorted");
        assert!(first == expected[0], "{level}");
        assert!(blocked(&mut tracer) == expected, "{level}");
    }
}

/// The ray made invalid in each way.
fn spoiled(ray: Ray) -> [Ray; 6] {
    let [x, y, z] = ray.direction.to_array();
    [
        Ray {
            direction: Vec3::new(f32::NAN, y, z),
            ..ray
        },
        Ray {
            direction: Vec3::new(x, f32::INFINITY, z),
            ..ray
        },
        Ray {
            direction: Vec3::ZERO,
            ..ray
        },
        Ray {
            t_max: f32::NAN,
            ..ray
        },
        Ray {
            t_max: f32::INFINITY,
            ..ray
        },
        Ray {
            origin: Vec3::new(x, y, f32::NEG_INFINITY),
            ..ray
        },
    ]
}

/// One invalid ray among hundreds: the others find what they find without it, and it finds nothing.
#[test]
fn invalid_rays_hit_nothing_and_change_no_other() {
    let mut random = fastrand::Rng::with_seed(9);
    let mut unit = move || random.f32() * 2.0 - 1.0;
    let mut vector = move || Vec3::new(unit(), unit(), unit());
    let mut builder = SceneBuilder::new();
    let material = builder.classic_material(1).unwrap();
    for _ in 0..2000 {
        let at = vector();
        let corners = [at, at + vector() * 0.2, at + vector() * 0.2];
        builder.add_triangle(corners, material).unwrap();
    }
    let scene = builder.finish();
    let bvh = Bvh::build(&scene);
    let mut towards = |origin: Vec3| Ray::new(origin, (vector() - origin).normalize());
    let shared = Vec3::new(0.1, 0.2, 2.5);
    let from_one: Vec<Ray> = (0..2048).map(|_| towards(shared)).collect();
    let apart: Vec<Ray> = from_one.iter().map(|ray| towards(ray.direction * 3.0)).collect();
    let methods = [Method::Adaptive, Method::Packet, Method::Single];
    let here = methods.map(|method| (method, Level::current()));
    let lower = Level::all().map(|level| (Method::Adaptive, level));
    for (method, level) in lower.filter(|it| *it != here[0]).chain(here) {
        for (origin, valid) in [(Some(shared), &from_one), (None, &apart)] {
            let traced = |rays: &[Ray]| {
                let mut packets = RayPackets::default();
                packets.restart(origin);
                for eight in rays.as_chunks::<LANES>().0 {
                    packets.push_rays(eight);
                }
                let count = packets.packets().len();
                let mut hits = vec![HitPacket::miss(F32x8::ZERO); count];
                let mut blocked = vec![0; count];
                let mut tracer = Tracer::with_method(&bvh, method).at_level(level);
                tracer.closest_hit(packets.origins(), packets.packets(), &mut hits);
                tracer.occluded(packets.origins(), packets.packets(), &mut blocked);
                let found = |i: usize| {
                    (
                        hits[i / LANES].hit(i % LANES),
                        blocked[i / LANES] >> (i % LANES) & 1,
                    )
                };
                (0..rays.len()).map(found).collect::<Vec<_>>()
            };
            let expected = traced(valid);
            assert!(expected.iter().filter(|(hit, _)| hit.is_hit()).count() > 300);
            for i in [0, 7, 700, 2047] {
                for spoiled in spoiled(valid[i]) {
                    if spoiled.is_valid() || origin.is_some() && !spoiled.origin.is_finite() {
                        continue;
                    }
                    let mut rays = valid.clone();
                    rays[i] = spoiled;
                    let mut found = traced(&rays);
                    assert_eq!(found[i], (Hit::miss(0.0), 0), "{method:?} {i} {spoiled:?}");
                    found[i] = expected[i];
                    assert!(found == expected, "{method:?} {i} {spoiled:?}");
                }
            }
        }
        let mut hits = [HitPacket::miss(F32x8::ZERO)];
        let rays = [RayPacket {
            direction: Vec3x8::splat(Vec3::X),
            t_max: F32x8::splat(1e9),
        }];
        let nowhere = Origins::Shared(Vec3::splat(f32::NAN));
        Tracer::with_method(&bvh, method)
            .at_level(level)
            .closest_hit(nowhere, &rays, &mut hits);
        assert!((0..LANES).all(|lane| hits[0].hit(lane) == Hit::miss(0.0)));
    }
}
