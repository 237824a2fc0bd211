//! Tests of `probe`.

use super::*;
use crate::{accel::Bvh, format::mesh::UpAxis, scene::SceneBuilder, viewer::pose::Pose};
use glam::Vec3;

/// From a mouse over a scene to the box that `f` frames.
#[test]
fn the_ground_under_the_mouse_is_not_framed() {
    let mut builder = SceneBuilder::new();
    let matte = builder.classic_material(1).unwrap();
    builder.add_sphere(Vec3::new(0.0, 0.0, 0.5), 0.5, matte).unwrap();
    builder.add_sphere(Vec3::new(0.0, 3.0, 0.5), 0.2, matte).unwrap();
    let far = 1000.0;
    for corners in [
        [[-far, -far], [far, -far], [far, far]],
        [[-far, -far], [far, far], [-far, far]],
    ] {
        let corners = corners.map(|[x, y]| Vec3::new(x, y, 0.0));
        builder.add_triangle(corners, matte).unwrap();
    }
    let scene = builder.finish();
    let bvh = Bvh::build(&scene);
    let model = Model::new(scene, bvh);
    let camera = Pose::classic_view(1).unwrap().camera().unwrap();
    let bounds = |pixel| {
        let (_, hit, _) = pick(&model, &camera, [100, 100], pixel);
        let under = hit.is_hit().then_some(hit);
        (
            hit.is_hit(),
            model.objects().bounds(&model.scene, under, UpAxis::Z).upper.y,
        )
    };
    assert_eq!(bounds([50, 50]), (true, 0.5));
    // The ground in front, and the horizon.
    assert_eq!(bounds([50, 95]), (true, 3.2));
    assert_eq!(bounds([50, 0]).1, 3.2);
}
