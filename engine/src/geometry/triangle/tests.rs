use super::*;
use crate::{
    ray::PrimitiveId,
    simd::{Portable, Simd},
};

/// Rays at triangles of all shapes, slivers whose longest edge is opposite the first corner among them, near and
/// far from where the rays start, which is sometimes the triangle's plane.
#[test]
fn may_hit_loses_no_ray_that_passes_through() {
    let mut random = fastrand::Rng::with_seed(17);
    let mut unit = move || random.f32() * 2.0 - 1.0;
    let mut vector = |size: f32| Vec3::new(unit(), unit(), unit()) * size;
    let (mut passing, mut elsewhere, mut in_vain) = (0, 0, 0);
    const ROUNDS: usize = 200_000;
    for round in 0..ROUNDS {
        let size = [1e-25, 1e-3, 1.0, 1e3, 1e15][round % 5];
        let around = vector([0.0, 1.0, 1e4][round % 3] * size);
        let part = vector(1.0);
        let corners = [(); 3].map(|()| around + vector(size));
        let [a, b, c] = corners;
        let corners = match round % 4 {
            0 => [a + (b - a) * part.x.abs(), a, b],
            1 => [a, b, a + (b - a) * part.x.abs()],
            _ => [a, b, c],
        };
        let [v0, v1, v2] = corners;
        let elsewhere_at = around + vector(4.0 * size);
        let start = around + vector(3.0 * size);
        // A point of the triangle's plane; on an edge if it is not `aside`.
        let mut in_plane = |aside: f32| {
            let part = vector(1.0);
            v0 + (v1 - v0) * part.x.abs() + (v2 - v0) * part.y * aside
        };
        let aim = round / 8 % 3;
        let at = [in_plane(0.0), in_plane(1.0), elsewhere_at][aim];
        let origin = if round % 7 == 0 { in_plane(3.0) } else { start };
        // Scaled first: squares of 1e-25 underflow.
        let to = at - origin;
        let direction = (to / to.abs().max_element()).normalize();
        if !direction.is_finite() {
            continue;
        }
        let block = TriangleBlock::new(&[(PrimitiveId(0), corners)]).load(Portable);
        let (origin8, direction8) = (Portable.splat3(origin), Portable.splat3(direction));
        let edges = EdgeFunctions::new(&block, origin8);
        let test = edges.test(direction8, (Portable.splat(0.0), Portable.splat(f32::INFINITY)));
        let [u, v, w] = test.weights.map(|weight| weight.to8().as_array()[0]);
        let columns = [u, v, w, 1.0];
        let may_hit = may_hit(&block, origin8, direction8) & 1 != 0;
        let passes = test.candidates().bits() & 1 != 0
            && meets(origin, direction, corners, columns, [0.0, f32::INFINITY]).0;
        assert!(
            may_hit || !passes,
            "round {round}: {corners:?} {origin} {direction}"
        );
        passing += u32::from(passes);
        let is_known = edges.tolerance.to8().as_array()[0] < f32::INFINITY;
        if aim == 2 && is_known && (1e-20..1e10).contains(&size) {
            elsewhere += 1;
            in_vain += u32::from(may_hit && !passes);
        }
    }
    assert!(passing > 20_000, "{passing} of {ROUNDS} pass through");
    assert!(
        in_vain * 20 < elsewhere,
        "{in_vain} of {elsewhere} rays that go elsewhere are not left out"
    );
}
