use super::*;
use crate::simd::{EightLanes, LaneMask, Portable, Simd};
type V8 = <Portable as Simd>::V8;
use crate::{
    accel::{Child, Node8},
    lanes::Vec3x8,
    math::Aabb,
    ray::RayPacket,
    trace::single::SingleRay,
};
use glam::Vec3;

/// Directions, one of them along an axis or in a plane of two; half of the time all in one direction octant, see
/// [`BundleFrustum::octant`](super::super::frustum::BundleFrustum::octant).
fn directions(
    round: usize,
    vector: &mut impl FnMut(f32) -> Vec3,
    ways: &mut fastrand::Rng,
) -> ([Vec3; LANES], Option<[u8; 3]>) {
    let mut directions = [(); LANES].map(|()| vector(1.0).normalize());
    directions[0] = [Vec3::X, Vec3::NEG_Y, Vec3::new(-0.0, 0.6, 0.8)][round % 3];
    let octant = ways.bool().then(|| [(); 3].map(|()| ways.u8(..2)));
    if let Some(octant) = octant {
        let signs = Vec3::from(octant.map(|down| 1.0 - 2.0 * f32::from(down)));
        directions = directions.map(|d| (d.abs() + 1e-5) * signs);
    }
    (directions, octant)
}

/// Boxes around points on rays, of all sizes and near and far from where rays start, some of these along an axis;
/// half of the rays are in one direction octant.
#[test]
fn slabs_hold_what_the_canonical_interval_holds() {
    let mut random = fastrand::Rng::with_seed(3);
    let mut ways = random.fork();
    let mut unit = move || random.f32() * 2.0 - 1.0;
    let mut vector = |size: f32| Vec3::new(unit(), unit(), unit()) * size;
    let mut met = 0;
    for round in 0..20_000 {
        let size = [1e-6, 1.0, 1e6, 1e9][round % 4];
        let far = [1.0, 1e3, 1e12, 1e30][round / 4 % 4];
        let origins = [(); LANES].map(|()| vector(size * far));
        let (directions, octant) = directions(round, &mut vector, &mut ways);
        let ray = round % LANES;
        let at = (origins[ray] + directions[ray] * size).clamp(Vec3::splat(-2e9), Vec3::splat(2e9));
        let half = vector(size).abs() * [0.0, 1e-6, 1.0][round / 16 % 3];
        let bounds = Aabb {
            lower: at - half,
            upper: at + half,
        };
        let rays = RayPacket {
            direction: Vec3x8::from_lanes(directions),
            t_max: F32x8::splat(f32::MAX),
        };
        let mut packet = Packet::EMPTY;
        packet.set::<V8>(Portable, [&rays; 4], [&rays.t_max; 4]);
        let origin8 = Vec3x8::from_lanes(origins);
        packet.start_at::<V8>(Portable, [&origin8; 4]);
        let mut slabs = PacketSlabs::EMPTY;
        slabs.set::<V8>(Portable, &packet, octant.is_some());
        let node = Node8::new(&[(Child::inner(0), bounds)]);
        let planes = in_order(&node, octant);
        let rays = slabs.load::<V8>(Portable, &packet);
        let (near, entering) = if octant.is_some() {
            rays.enter::<true>(&planes, 0)
        } else {
            rays.enter::<false>(&planes, 0)
        };
        let o = Vec3Lanes::<V8>::load(Portable, &packet.origin);
        let (lower, upper) = (
            Vec3Lanes::splat(Portable, bounds.lower),
            Vec3Lanes::splat(Portable, bounds.upper),
        );
        let (canonical_near, canonical_far) = packet.interval(lower - o, upper - o);
        if octant.is_some() {
            let (first, last) = corners(Portable, &planes, 0);
            let same = packet.interval_in_octant(first - o, last - o);
            let bits = |t: V8| t.to8().to_array().map(f32::to_bits);
            assert_eq!(bits(same.0), bits(canonical_near), "{round}");
            assert_eq!(bits(same.1), bits(canonical_far), "{round}");
        }
        for i in 0..LANES {
            let near = near.lane(i);
            let [least, most] = [canonical_near, canonical_far].map(|t| t.lane(i));
            if least <= most {
                met += 1;
                let (entered, near8) = SingleRay::new(&packet, 0, i).enter(Portable, &node, f32::MAX);
                let near8 = near8.to8();
                assert!(
                    entered == 1 && near8.as_array()[0] <= least.min(f32::MAX),
                    "{round}: alone"
                );
                let empty = (1..LANES).all(|c| near8.as_array()[c] == f32::INFINITY);
                assert!(empty, "{round}: {near8:?}");
                let enters = entering.bits() >> i & 1 != 0;
                assert!(enters && near <= least, "{round}: {enters} {near} {least}");
            }
        }
    }
    assert!(met > 5_000, "{met}");
}

/// The same where rays share their origin, for rays that end at the box as well; the origin is sometimes in it.
#[test]
fn planes_as_seen_from_one_origin_hold_what_the_canonical_interval_holds() {
    let mut random = fastrand::Rng::with_seed(4);
    let mut ways = random.fork();
    let mut unit = move || random.f32() * 2.0 - 1.0;
    let mut vector = |size: f32| Vec3::new(unit(), unit(), unit()) * size;
    let mut met = 0;
    for round in 0..50_000 {
        let size = [1e-6, 1.0, 1e6, 1e9][round % 4];
        let origin = vector(size * [0.0, 1.0, 1e3][round / 4 % 3]).clamp(Vec3::splat(-2e9), Vec3::splat(2e9));
        let (directions, octant) = directions(round, &mut vector, &mut ways);
        let at = origin + directions[round % LANES] * size;
        let half = vector(size).abs() * [0.0, 1e-6, 1.0, 3.0][round / 16 % 4];
        let bounds = Aabb {
            lower: at - half,
            upper: at + half,
        };
        let rays = RayPacket {
            direction: Vec3x8::from_lanes(directions),
            t_max: F32x8::splat(f32::MAX),
        };
        let mut packet = Packet::EMPTY;
        packet.set::<V8>(Portable, [&rays; 4], [&rays.t_max; 4]);
        let origin8 = Vec3x8::splat(origin);
        packet.start_at::<V8>(Portable, [&origin8; 4]);
        let o = Vec3Lanes::<V8>::load(Portable, &packet.origin);
        let (lower, upper) = (
            Vec3Lanes::splat(Portable, bounds.lower),
            Vec3Lanes::splat(Portable, bounds.upper),
        );
        let (canonical_near, canonical_far) = packet.interval(lower - o, upper - o);
        if ways.bool() {
            // As soon as they are in the box.
            canonical_near
                .max(Portable.splat(f32::MIN_POSITIVE))
                .store(&mut packet.t);
        }
        let mut planes = in_order(&Node8::new(&[(Child::inner(0), bounds)]), octant);
        for (i, plane) in planes.iter_mut().enumerate() {
            *plane = (Portable.load(plane) - Portable.splat(origin[i % 3])).to8();
        }
        let (near, entering) = if octant.is_some() {
            enter::<V8, true>(Portable, &planes, 0, &packet)
        } else {
            enter::<V8, false>(Portable, &planes, 0, &packet)
        };
        for i in 0..LANES {
            let [least, most] = [canonical_near, canonical_far].map(|t| t.lane(i));
            if least <= most && most > 0.0 {
                met += 1;
                let (enters, near) = (entering.bits() >> i & 1 != 0, near.lane(i));
                assert!(enters && near <= least, "{round}: {enters} {near} {least}");
            }
        }
    }
    assert!(met > 20_000, "{met}");
}
