//! Tests of `far`.

use super::*;

#[test]
fn bounds_are_coarse_by_their_distance_and_size() {
    for (center, radius, step) in [
        ([448_262.0, 5_411_933.0, 275.0], 1.0, Some(0.5)),
        ([0.0, -100_000.0, 0.0], 10.0, Some(0.007_812_5)),
        ([1e6, 0.0, 0.0], 0.0, Some(0.0625)),
        ([100_000.0, 0.0, 0.0], 100.0, None),
        ([5000.0, 5000.0, 0.0], 4.0, None),
        ([0.0; 3], 1e-6, None),
    ] {
        let center = Vec3::from(center);
        let bounds = Aabb {
            lower: center - radius,
            upper: center + radius,
        };
        assert_eq!(Coarse::of(&bounds).map(|coarse| coarse.step), step, "{center}");
    }
    assert!(Coarse::of(&Aabb::EMPTY).is_none());
}

#[test]
fn outliers_do_not_move_the_offset() {
    let grid = |outliers: &[[f32; 3]]| {
        let points = (0..100).map(|i| [5e5 + (i % 10) as f32, 4e6 + (i / 10) as f32, 7.0]);
        let points: Vec<[f32; 3]> = points.chain(outliers.iter().copied()).collect();
        let column = |axis: usize| points.iter().map(|point| point[axis]).collect();
        let mut mesh = LoadedMesh::default();
        (mesh.columns.x, mesh.columns.y, mesh.columns.z) = (column(0), column(1), column(2));
        let bounds = PlacedMesh::bounds(&mesh.placed());
        offset_of(&mesh, (bounds, middle_half(&mesh.columns)), 0.0)
    };
    let near = |offset: Option<DVec3>| {
        let offset = offset.expect("the mesh is coarse");
        (offset.truncate() - glam::DVec2::new(500_004.5, 4_000_004.5)).length() < 2.0
    };
    assert!(near(grid(&[])));
    assert!(near(grid(&[[0.0; 3]])));
    assert!(near(grid(&[[9e8, 0.0, -9e8], [9e8; 3], [0.0; 3]])));
    // Half of the vertices elsewhere are no outliers.
    assert_eq!(grid(&[[0.0; 3]; 90]), None);
}
