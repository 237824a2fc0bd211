//! Tests of `placed`.

use super::*;
use glam::DVec3;

#[test]
fn points_are_those_of_meshes_in_place() {
    let mut random = fastrand::Rng::with_seed(5);
    let mut column = |count: usize| (0..count).map(|_| random.f32() - 0.3).collect::<Vec<f32>>();
    let mesh = TriangleMesh {
        x: column(10_001),
        y: column(10_001),
        z: column(10_001),
        ..TriangleMesh::default()
    };
    let place = |i: usize| {
        Transform::IDENTITY
            .then_rotate(DVec3::new(1.0, 2.0, 0.5), 31.0 * i as f64)
            .then_translate(DVec3::new(i as f64, 0.1, -0.7))
    };
    let placements: Vec<Transform> = (0..5).map(place).collect();
    let mut expected = Aabb::EMPTY;
    for placement in &placements {
        let mut placed = TriangleMesh {
            x: mesh.x.clone(),
            y: mesh.y.clone(),
            z: mesh.z.clone(),
            ..TriangleMesh::default()
        };
        placement.apply(&mut placed);
        expected = expected.union(PlacedMesh::bounds(&[PlacedMesh::in_place(&placed)]));
    }
    let placed = PlacedMesh {
        mesh: &mesh,
        placements: &placements,
    };
    let found = PlacedMesh::bounds(&[placed]);
    assert_eq!((found.lower, found.upper), (expected.lower, expected.upper));
    let coarse = Points::with_most(&[placed], 1000);
    assert!(coarse.are_corners);
    let count = coarse.fold(|| 0, |count, _| count + 1, |a, b| a + b);
    assert_eq!(count, 5 * 8);
    let around = coarse.fold(
        || Aabb::EMPTY,
        |bounds, point| bounds.union(Aabb::around([point])),
        Aabb::union,
    );
    assert_eq!(around.union(found).upper, around.upper);
    assert!(PlacedMesh::bounds(&[]).is_empty());
}

#[test]
fn extremes_reach_as_far_as_all_points() {
    let mut random = fastrand::Rng::with_seed(6);
    let mut column = || {
        (0..50_000)
            .map(|_| random.f32() * random.f32())
            .collect::<Vec<f32>>()
    };
    let mesh = TriangleMesh {
        x: column(),
        y: column(),
        z: column(),
        ..TriangleMesh::default()
    };
    let placed = [PlacedMesh::in_place(&mesh)];
    let extremes = PlacedMesh::extremes(&placed);
    assert_eq!(extremes.len(), DIRECTIONS);
    let bounds = PlacedMesh::bounds(&placed);
    let found = Aabb::around(extremes.iter().copied());
    assert_eq!((found.lower, found.upper), (bounds.lower, bounds.upper));
    for _ in 0..100 {
        let mut axis = || random.f32() - 0.5;
        let direction = Vec3::new(axis(), axis(), axis()).normalize();
        let reach = Points::of(&placed).fold(
            || f32::NEG_INFINITY,
            |reach, point| reach.max(direction.dot(point)),
            f32::max,
        );
        let found = extremes.iter().map(|point| direction.dot(*point));
        assert!(found.fold(f32::NEG_INFINITY, f32::max) > reach - 0.03);
    }
    assert!(PlacedMesh::extremes(&[]).is_empty());
}
