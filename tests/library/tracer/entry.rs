use glam::Vec3;
use octray::{
    accel::Bvh,
    lanes::{F32x8, LANES, Vec3x8},
    ray::{HitPacket, Origins, RayPacket},
    scene::SceneBuilder,
    trace::{Method, Tracer},
};

#[test]
fn bundles_that_share_an_entry_hit_what_single_rays_hit() {
    let mut random = fastrand::Rng::with_seed(5);
    let mut unit = move || random.f32() * 2.0 - 1.0;
    let mut vector = move || Vec3::new(unit(), unit(), unit());
    let mut builder = SceneBuilder::new();
    let material = builder.classic_material(1).unwrap();
    for _ in 0..3000 {
        let at = vector();
        builder
            .add_triangle([at, at + vector() * 0.1, at + vector() * 0.1], material)
            .unwrap();
    }
    let scene = builder.finish();
    let bvh = Bvh::build(&scene);
    let mut hit = 0;
    for round in 0..60 {
        let origin = vector() * [0.5, 3.0, 20.0][round % 3];
        let spread = [0.0, 0.02, 0.3][round / 3 % 3] / origin.length();
        let to = if round % 5 == 0 {
            origin + Vec3::X
        } else {
            vector()
        };
        let rays: Vec<RayPacket> = (0..200)
            .map(|_| {
                let mut direction = || (to - origin + vector() * spread * to.distance(origin)).normalize();
                let directions: [Vec3; LANES] = [(); LANES].map(|()| direction());
                RayPacket {
                    direction: Vec3x8::from_lanes(directions),
                    t_max: F32x8::splat(f32::MAX),
                }
            })
            .collect();
        let hits_of = |method| {
            let mut hits = vec![HitPacket::miss(F32x8::ZERO); rays.len()];
            Tracer::with_method(&bvh, method).closest_hit(Origins::Shared(origin), &rays, &mut hits);
            hits
        };
        let (bundled, single) = (hits_of(Method::Adaptive), hits_of(Method::Single));
        for (bundled, single) in bundled.iter().zip(&single) {
            assert_eq!(bundled.primitive, single.primitive);
            assert_eq!(bundled.t.to_array(), single.t.to_array());
            hit += bundled.primitive.iter().filter(|&&id| id != u32::MAX).count();
        }
    }
    assert!(hit > 10_000, "{hit}");
}

/// Triangles in a corner of the view, seen from afar and from among them.
#[test]
fn what_may_not_be_hit_is_not_hit() {
    let mut random = fastrand::Rng::with_seed(7);
    let mut unit = move || random.f32() * 2.0 - 1.0;
    let mut builder = SceneBuilder::new();
    let material = builder.classic_material(1).unwrap();
    for _ in 0..500 {
        let mut vector = || Vec3::new(unit(), unit(), unit());
        let at = vector();
        builder
            .add_triangle([at, at + vector() * 0.1, at + vector() * 0.1], material)
            .unwrap();
    }
    let scene = builder.finish();
    let bvh = Bvh::build(&scene);
    let mut tracer = Tracer::new(&bvh);
    let (mut empty, mut hit) = (0, 0);
    for round in 0..2000 {
        let mut vector = || Vec3::new(unit(), unit(), unit());
        let origin = vector() * [0.5, 3.0, 20.0][round % 3];
        let to = vector() * 2.0 - origin;
        let spread = [0.0, 0.05, 0.3, 2.0][round % 4];
        let corners = [(); 4].map(|()| (to.normalize() + vector() * spread).normalize());
        let may_hit = tracer.may_hit(origin, corners);
        empty += usize::from(!may_hit);
        let rays: Vec<RayPacket> = (0..16)
            .map(|_| {
                let mut direction = || {
                    let shares = [(); 4].map(|()| unit().max(0.0).powi(4));
                    let sum: Vec3 = corners.iter().zip(shares).map(|(&c, share)| c * share).sum();
                    sum.try_normalize().unwrap_or(corners[0])
                };
                RayPacket {
                    direction: Vec3x8::from_lanes([(); LANES].map(|()| direction())),
                    t_max: F32x8::splat(f32::MAX),
                }
            })
            .collect();
        let mut hits = vec![HitPacket::miss(F32x8::ZERO); rays.len()];
        tracer.closest_hit(Origins::Shared(origin), &rays, &mut hits);
        let is_hit = hits
            .iter()
            .any(|hits| hits.primitive.iter().any(|&id| id != u32::MAX));
        assert!(
            may_hit || !is_hit,
            "round {round}: from {origin} between {corners:?}"
        );
        hit += usize::from(is_hit);
    }
    assert!(empty > 300 && hit > 300, "{empty} see nothing, {hit} something");
}
