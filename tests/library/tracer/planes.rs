use glam::Vec3;
use octray::{
    accel::Bvh,
    lanes::{F32x8, LANES, Vec3x8},
    ray::{Hit, HitPacket, Origins, PrimitiveId, RayPacket, T_MAX},
    scene::{MaterialId, Scene, SceneBuilder},
    trace::Tracer,
};

/// A floor and a ceiling, and nothing between them.
fn scene() -> Scene {
    let mut builder = SceneBuilder::new();
    for (point, normal) in [(Vec3::NEG_Z, Vec3::Z), (Vec3::Z * 2.0, Vec3::new(0.1, 0.0, 1.0))] {
        builder.add_plane(point, normal, MaterialId(1)).unwrap();
    }
    builder.finish()
}

#[test]
fn what_is_no_ray_hits_no_plane() {
    let scene = scene();
    let bvh = Bvh::build(&scene);
    let mut tracer = Tracer::new(&bvh).with_planes(&scene);
    let down = Vec3::NEG_Z;
    for (direction, t_max, origin) in [
        (Vec3::new(f32::NAN, 0.0, -1.0), T_MAX, Vec3::ZERO),
        (Vec3::new(0.0, 0.0, f32::NEG_INFINITY), T_MAX, Vec3::ZERO),
        (Vec3::ZERO, T_MAX, Vec3::ZERO),
        (down, f32::INFINITY, Vec3::ZERO),
        (down, f32::NAN, Vec3::ZERO),
        (down, 0.0, Vec3::ZERO),
        (down, T_MAX, Vec3::splat(f32::NAN)),
        (down, T_MAX, Vec3::Z * f32::INFINITY),
        (Vec3::X, T_MAX, Vec3::new(0.0, 0.0, -1.0)),
    ] {
        let rays = [RayPacket {
            direction: Vec3x8::splat(direction),
            t_max: F32x8::splat(t_max),
        }];
        let origins = [Vec3x8::splat(origin)];
        let (mut hits, mut blocked) = ([HitPacket::miss(F32x8::ZERO)], [0]);
        for origins in [Origins::Separate(&origins), Origins::Shared(origin)] {
            tracer.closest_hit(origins, &rays, &mut hits);
            tracer.occluded(origins, &rays, &mut blocked);
            let expected = if direction == Vec3::X {
                scene.plane_id(1)
            } else {
                PrimitiveId::NONE
            };
            let found = hits[0].hit(3).primitive;
            assert_eq!(found, expected, "{direction} {t_max} {origin}");
            assert_eq!(blocked[0] != 0, expected != PrimitiveId::NONE);
        }
    }
}

#[test]
#[should_panic(expected = "this BVH was built from another scene")]
fn a_tracer_refuses_a_scene_that_its_hierarchy_is_not_of() {
    let bvh = Bvh::build(&scene());
    let _ = Tracer::new(&bvh).of_scene(&scene());
}

#[test]
fn cones_that_may_not_hit_planes_do_not() {
    let scene = scene();
    let bvh = Bvh::build(&scene);
    let mut tracer = Tracer::new(&bvh).with_planes(&scene);
    let mut random = fastrand::Rng::with_seed(4);
    let (mut off, mut on) = (0, 0);
    for _ in 0..2000 {
        let mut vector = || Vec3::new(random.f32(), random.f32(), random.f32()) * 2.0 - 1.0;
        let (origin, middle, spread) = (vector() * 8.0, vector(), vector().length() * 0.3);
        let corners = [(); 4].map(|()| (middle + vector() * spread).normalize());
        let may_hit = tracer.may_hit(origin, corners);
        let direction = Vec3x8::from_lanes([(); LANES].map(|()| {
            let shares = [(); 4].map(|()| vector().x.abs());
            let sum: Vec3 = corners
                .iter()
                .zip(shares)
                .map(|(&corner, share)| corner * share)
                .sum();
            sum.normalize()
        }));
        let rays = [RayPacket {
            direction,
            t_max: F32x8::splat(T_MAX),
        }];
        let mut hits = [HitPacket::miss(F32x8::ZERO)];
        tracer.closest_hit(Origins::Shared(origin), &rays, &mut hits);
        let is_hit = (0..LANES).any(|lane| Hit::is_hit(&hits[0].hit(lane)));
        assert!(may_hit || !is_hit, "{origin} {corners:?}");
        (off, on) = (off + u32::from(!may_hit), on + u32::from(is_hit));
    }
    assert!(off > 100 && on > 100, "{off} {on}");
}
