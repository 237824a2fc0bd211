use super::{super::leaf, *};
use crate::{
    geometry::{EdgeFunctions, TriangleBlock, meets},
    lanes::{F32x8, Vec3x8},
    ray::{PrimitiveId, RayPacket},
    simd::{Portable, Simd, Vec3Eight},
    trace::dominant::DominantAxis,
};

type V8 = <Portable as Simd>::V8;

/// The lanes that may hit the first triangle, of rays with equal directions.
fn ahead(
    block: &[Vec3Eight<Portable>; 3],
    edges: &Edges<V8>,
    origin8: &Vec3x8,
    direction: Vec3,
    (point, extent): (Vec3, f32),
    round: usize,
) -> u32 {
    let mut packets = [Packet::EMPTY; PACKETS];
    let rays = RayPacket {
        direction: Vec3x8::splat(direction),
        t_max: F32x8::splat(f32::MAX),
    };
    packets[0].set::<V8>(Portable, [&rays; 4], [&rays.t_max; 4]);
    packets[0].start_at::<V8>(Portable, [origin8; 4]);
    // Any axis that they go along well enough.
    let frustum = (0..3).find_map(|turn| {
        let axis = (round + turn) % 3;
        let sign = direction[axis].signum();
        BundleFrustum::<V8>::new::<Separate>(Portable, &packets, 1, DominantAxis { axis, sign })
    });
    let space = ShearedSpace::new(frustum.as_ref(), point, extent);
    assert!(space.slack.is_finite(), "one axis is along {direction}");
    let mut lines = ShearedPacket::EMPTY;
    lines.set::<V8>(Portable, &packets[0], &space);
    let seen = SeenTriangles::new(block, edges, &space);
    let v0 = leaf::vector::<V8, V8>(&block[0], 0);
    let a = v0 - Vec3Lanes::load(Portable, &packets[0].origin);
    let plane = leaf::vector::<V8, V8>(&edges.normal, 0).dot(a);
    let unknown = Edges::unknown_side(leaf::vector::<V8, V8>(&edges.permanent, 0), plane, a);
    let [above, below] = lines.load::<V8>(Portable).sides(&seen, 0, Portable.mask(0xff));
    let candidate = Candidate {
        above: above.bits() as u16,
        below: below.bits() as u16,
        pair: 0,
    };
    candidate.ahead(plane.sign_bits()) | u32::from(candidate.above | candidate.below) & unknown.bits()
}

/// Rays at corners, at edges and past them, of triangles of all shapes, near and far from their origins.
#[test]
fn first_looks_lose_no_ray_that_passes_through() {
    let mut random = fastrand::Rng::with_seed(11);
    let mut unit = move || random.f32() * 2.0 - 1.0;
    let mut vector = |size: f32| Vec3::new(unit(), unit(), unit()) * size;
    let mut passing = 0;
    for round in 0..20_000 {
        let size = [1e-3, 1.0, 1e3, 1e15][round % 4];
        let around = vector([0.0, 1.0, 1e4][round % 3] * size);
        let corners = [(); 3].map(|()| around + vector(size));
        let sliver = [corners[0], corners[1], (corners[0] + corners[1]) * 0.5];
        let corners = if round % 5 == 0 { sliver } else { corners };
        let block = TriangleBlock::new(&[(PrimitiveId(0), corners)]).load(Portable);
        let origins = [(); LANES].map(|()| around + vector(3.0 * size));
        let mut part = vector(1.0);
        let directions = origins.map(|origin| {
            part = Vec3::new(part.y, part.z, (part.x * 7.0).fract());
            let at = corners[0]
                + (corners[1] - corners[0]) * part.x.abs()
                + (corners[2] - corners[0]) * [0.0, part.y][round % 2];
            (at - origin).normalize()
        });
        let point = origins.into_iter().fold(origins[0], Vec3::min);
        let extent = (origins.into_iter().fold(origins[0], Vec3::max) - point).length();
        let edges8 = Edges::new(&block);
        let origin8 = Vec3x8::from_lanes(origins);
        for (lane, (origin, direction)) in origins.into_iter().zip(directions).enumerate() {
            let ahead = ahead(&block, &edges8, &origin8, direction, (point, extent), round);
            let edges = EdgeFunctions::new(&block, Portable.splat3(origin));
            let interval = (Portable.splat(0.0), Portable.splat(f32::INFINITY));
            let test = edges.test(Portable.splat3(direction), interval);
            let candidate = test.candidates().bits() & 1;
            let [u, v, w] = test.weights.map(EightLanes::first);
            let (passes, _) = meets(origin, direction, corners, [u, v, w, 1.0], [0.0, f32::INFINITY]);
            passing += u32::from(passes);
            assert!(
                !passes || candidate != 0 && ahead >> lane & 1 != 0,
                "round {round}: {corners:?} {origin} {direction}"
            );
        }
    }
    assert!(
        (40_000..120_000).contains(&passing),
        "{passing} of 160,000 pass through"
    );
}
