//! Bundles, packets, single rays, the scalar BVH and brute force find the same hits, bit for bit.
//!
//! `OCTRAY_LONG=1` runs 1,000,000 rays against each of 200 scenes.

mod common;

use common::random_scene::{self, Random};
use glam::Vec3;
use octray::{
    accel::Bvh,
    ray::{Hit, HitPacket, Ray, RayPacket},
    reference::{brute, bvh},
    scene::Scene,
    simd::{F32x8, LANES},
    trace::{BUNDLE, Method, Origins, Tracer},
};
use proptest::prelude::*;

fn bits(hit: Hit) -> [u32; 4] {
    [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.primitive.0]
}

/// Groups of rays as they come: all alike, sharing an origin, or mixed; some lanes without a ray.
fn ray_group(random: &mut Random, scene: &Scene) -> (Origins, Vec<Ray>) {
    let count = random.usize(1..=BUNDLE * LANES);
    let first = random_scene::ray(random, scene);
    let kind = random.u32(0..4);
    let spread = [0.0, 1e-3, 0.1, 1.0][random.usize(0..4)];
    let rays = (0..count)
        .map(|_| {
            let other = random_scene::ray(random, scene);
            let mut ray = match kind {
                0 => other,
                1 => {
                    let to = other.origin + other.direction - first.origin;
                    Ray {
                        origin: first.origin,
                        direction: to.normalize_or(Vec3::Z),
                        ..other
                    }
                }
                _ => {
                    let towards = first.direction + (other.direction - first.direction) * spread;
                    let origin = if kind == 2 {
                        first.origin
                    } else {
                        first.origin + (other.origin - first.origin) * (spread * 0.1)
                    };
                    Ray {
                        origin,
                        direction: towards.normalize_or(Vec3::Z),
                        t_max: other.t_max,
                    }
                }
            };
            if random.u32(0..16) == 0 {
                ray.t_max = 0.0;
            }
            ray
        })
        .collect();
    (
        if matches!(kind, 1 | 2) {
            Origins::Shared
        } else {
            Origins::Separate
        },
        rays,
    )
}

/// Lanes past the last ray repeat it, switched off.
fn packets(rays: &[Ray]) -> Vec<RayPacket> {
    rays.chunks(LANES)
        .map(|chunk| {
            let mut packet = RayPacket::inactive();
            for lane in 0..LANES {
                let mut ray = chunk[lane.min(chunk.len() - 1)];
                if lane >= chunk.len() {
                    ray.t_max = 0.0;
                }
                packet.set_ray(lane, &ray);
            }
            packet
        })
        .collect()
}

fn compare(scene: &Scene, bvh: &Bvh, origins: Origins, rays: &[Ray]) -> Result<(), String> {
    let packets = packets(rays);
    let binary = bvh.binary(scene);
    let mut stack = bvh::Stack::default();
    let expected: Vec<Hit> = rays.iter().map(|ray| brute::closest_hit(scene, ray)).collect();
    let blocked: Vec<bool> = rays.iter().map(|ray| brute::occluded(scene, ray)).collect();
    let differ = |what: String, i: usize, found: &dyn std::fmt::Debug, expected: &dyn std::fmt::Debug| {
        Err(format!(
            "{what}, ray {i} of {}: {:?}\nfound {found:?}\nexpected {expected:?}",
            rays.len(),
            rays[i]
        ))
    };
    for (i, ray) in rays.iter().enumerate() {
        let found = bvh::closest_hit(binary, &mut stack, ray);
        if bits(found) != bits(expected[i]) {
            return differ("scalar BVH".into(), i, &found, &expected[i]);
        }
        let found = bvh::occluded(binary, &mut stack, ray);
        if found != blocked[i] {
            return differ("scalar BVH, occlusion".into(), i, &found, &blocked[i]);
        }
    }
    for method in [
        Method::Adaptive,
        Method::Adaptive8,
        Method::Packet,
        Method::Single,
    ] {
        let mut tracer = Tracer::with_method(bvh, method);
        let mut hits = vec![HitPacket::miss(F32x8::ZERO); packets.len()];
        tracer.closest_hit(origins, &packets, &mut hits);
        let mut occluded = vec![0; packets.len()];
        tracer.occluded(origins, &packets, &mut occluded);
        for i in 0..rays.len() {
            let found = hits[i / LANES].hit(i % LANES);
            if bits(found) != bits(expected[i]) {
                return differ(format!("{method:?} {origins:?}"), i, &found, &expected[i]);
            }
            let found = occluded[i / LANES] >> (i % LANES) & 1 == 1;
            if found != blocked[i] {
                return differ(
                    format!("{method:?} {origins:?}, occlusion"),
                    i,
                    &found,
                    &blocked[i],
                );
            }
        }
    }
    Ok(())
}

fn check(seed: u64, count: usize, rays_wanted: usize) -> Result<(), String> {
    let mut random = Random::with_seed(seed);
    let scene = random_scene::scene(&mut random, count);
    let bvh = Bvh::build(&scene);
    let mut rays_done = 0;
    while rays_done < rays_wanted {
        let (origins, rays) = ray_group(&mut random, &scene);
        rays_done += rays.len();
        compare(&scene, &bvh, origins, &rays)
            .map_err(|e| format!("scene seed {seed}, {count} primitives: {e}"))?;
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_way_of_tracing_agrees_with_brute_force(seed in any::<u64>(), count in 0_usize..=64) {
        check(seed, count, 1_000).map_err(TestCaseError::fail)?;
    }

    #[test]
    fn and_on_larger_scenes(seed in any::<u64>(), count in 65_usize..=400) {
        check(seed, count, 300).map_err(TestCaseError::fail)?;
    }
}

#[test]
fn long_mode() {
    if std::env::var_os("OCTRAY_LONG").is_none() {
        println!("skipped: set OCTRAY_LONG=1 to trace 1,000,000 rays in each of 200 scenes");
        return;
    }
    for seed in 0..200 {
        let count = 1 + seed as usize % 64;
        check(seed, count, 1_000_000).unwrap();
    }
}
