//! Tests of `timeline`.

use super::*;
use crate::{
    format::mesh::UpAxis,
    math::Aabb,
    scene::{Motion, SceneBuilder, Step, Transform},
};
use glam::{DVec3, Vec3};

/// A ball that moves 8 units along x in 8 frames, beside one that stays.
fn rolling() -> Timeline {
    let mut builder = SceneBuilder::new();
    let matte = builder.classic_material(1).unwrap();
    builder.add_sphere(Vec3::ZERO, 1.0, matte).unwrap();
    let ball = builder
        .add_prototype(|builder| builder.add_sphere(Vec3::ZERO, 1.0, matte))
        .unwrap();
    let mut motion = Motion::default();
    for time in [1.0, 9.0] {
        let step = Step::Translate(DVec3::X * (time + 9.0));
        motion.add(time, vec![step]).unwrap();
    }
    builder
        .add_moving_instance(ball, &Transform::IDENTITY, motion)
        .unwrap();
    let scene = builder.finish();
    let bvh = Bvh::build(&scene);
    Timeline::new(Model::new(scene, bvh))
}

#[test]
fn a_scene_moves_when_nobody_uses_it() {
    let timeline = rolling();
    assert_eq!((timeline.count(), timeline.now().frame()), (9, 1));
    let all = |model: &Model| model.objects().bounds(&model.scene, None, UpAxis::Z);
    let reach = |bounds: Aabb| bounds.upper.x;
    let first = timeline.now();
    assert_eq!(reach(all(&first)), 11.0);
    assert!(timeline.at(5).unwrap().is_none());
    assert!(timeline.at(1).unwrap().is_some());
    drop(first);
    let fifth = timeline.at(5).unwrap().unwrap();
    assert_eq!((fifth.frame(), reach(all(&fifth))), (5, 15.0));
    assert!(fifth.bvh.is_of(&fifth.scene));
}
