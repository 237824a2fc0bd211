use glam::Vec3;
use octray::{
    accel::Bvh,
    lanes::{F32x8, LANES, Vec3x8},
    ray::{HitPacket, Origins, RayPacket},
    scene::SceneBuilder,
    trace::{Method, Tracer, order},
};

/// Rays with hits, without, lanes and packets without a ray, runs that go past everything, and rays that are sorted.
#[test]
fn one_call_finds_what_short_ones_find() {
    let mut random = fastrand::Rng::with_seed(9);
    let mut unit = move || random.f32() * 2.0 - 1.0;
    let mut vector = move || Vec3::new(unit(), unit(), unit());
    let mut builder = SceneBuilder::new();
    let material = builder.classic_material(1).unwrap();
    for _ in 0..100 {
        let at = vector();
        builder
            .add_triangle([at, at + vector() * 0.3, at + vector() * 0.3], material)
            .unwrap();
    }
    let scene = builder.finish();
    let bvh = Bvh::build(&scene);
    let packets = 20 * order::PACKETS + 100;
    let rays: Vec<RayPacket> = (0..packets)
        .map(|i| {
            // Runs of 512 packets: into the scene, past it, every way.
            let (way, spread) = [(Vec3::ONE, 0.4), (Vec3::NEG_X, 0.1), (Vec3::ONE, 9.0)][i / 512 % 3];
            let none = [0.0, 0.0, 0.0, vector().x][i % 4];
            let t_max = F32x8::from([none, 1.0, 1.0, none, 4.0, 4.0, none, 4.0]);
            let way = way + vector() * spread;
            RayPacket {
                direction: Vec3x8::from_lanes(
                    [(); LANES].map(|()| (way + vector() * spread * 0.1).normalize()),
                ),
                t_max: if i % 7 == 0 { F32x8::ZERO } else { t_max },
            }
        })
        .collect();
    let origin = Vec3::new(-1.5, -1.5, 0.0);
    let separate: Vec<Vec3x8> = (0..packets)
        .map(|_| Vec3x8::splat(origin + vector() * 0.1))
        .collect();
    for method in [Method::Adaptive, Method::Packet, Method::Single] {
        let mut tracer = Tracer::with_method(&bvh, method);
        for is_shared in [true, false] {
            let mut trace = |from: usize, to: usize, hits: &mut [HitPacket]| {
                let origins = if is_shared {
                    Origins::Shared(origin)
                } else {
                    Origins::Separate(&separate[from..to])
                };
                tracer.closest_hit(origins, &rays[from..to], hits);
            };
            let mut short = vec![HitPacket::miss(F32x8::ZERO); packets];
            for (i, hits) in short.chunks_mut(256).enumerate() {
                trace(i * 256, i * 256 + hits.len(), hits);
            }
            let mut long = vec![HitPacket::miss(F32x8::ZERO); packets];
            trace(0, packets, &mut long);
            let hit = |hits: &HitPacket| hits.primitive.iter().filter(|&&id| id != u32::MAX).count();
            let found: usize = long.iter().map(hit).sum();
            assert!(found > 1000 && found < packets * LANES / 2, "{found}");
            assert!(
                bytemuck::cast_slice::<_, u8>(&short) == bytemuck::cast_slice::<_, u8>(&long),
                "{method:?} {is_shared}"
            );
        }
    }
}
