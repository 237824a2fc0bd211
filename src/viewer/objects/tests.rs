use super::*;
use crate::{
    ray::{Hit, PrimitiveId},
    scene::{MaterialId, SceneBuilder},
};
use glam::Vec3;

const MATERIAL: MaterialId = MaterialId(1);

/// A square at a height, as two triangles with corners of their own.
fn add_square(builder: &mut SceneBuilder, half: f32, z: f32) {
    let corner = |x: f32, y: f32| Vec3::new(x * half, y * half, z);
    let [a, b, c, d] = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    builder.add_triangle([a, b, c], MATERIAL).unwrap();
    builder.add_triangle([a, c, d], MATERIAL).unwrap();
}

/// Water, a sphere and an upright triangle.
fn scene() -> Scene {
    let mut builder = SceneBuilder::new();
    add_square(&mut builder, 2000.0, 0.0);
    builder
        .add_triangle([Vec3::ZERO, Vec3::X, Vec3::Z], MATERIAL)
        .unwrap();
    builder.add_sphere(Vec3::NEG_X, 0.5, MATERIAL).unwrap();
    builder.finish()
}

fn hit(id: u32) -> SceneHit {
    let primitive = PrimitiveId(id);
    Hit {
        primitive,
        ..Hit::miss(1.0)
    }
    .into()
}

fn bounds_under(scene: &Scene, id: Option<u32>) -> Aabb {
    Objects::new(scene).bounds(scene, id.map(hit), UpAxis::Z)
}

#[test]
fn triangles_that_share_corners_are_one_object() {
    let objects = Objects::new(&scene());
    assert_eq!(objects.of_triangle, [0, 0, 1]);
    assert_eq!((objects.meshes, objects.boxes.len()), (2, 3));
}

#[test]
fn what_is_under_the_mouse_is_framed() {
    let scene = scene();
    let sphere = Aabb {
        lower: Vec3::new(-1.5, -0.5, -0.5),
        upper: Vec3::new(-0.5, 0.5, 0.5),
    };
    let triangle = Aabb {
        lower: Vec3::ZERO,
        upper: Vec3::new(1.0, 0.0, 1.0),
    };
    assert_eq!(bounds_under(&scene, Some(3)), sphere);
    assert_eq!(bounds_under(&scene, Some(2)), triangle);
}

#[test]
fn the_ground_is_never_framed() {
    let scene = scene();
    let all = Aabb {
        lower: Vec3::new(-1.5, -0.5, -0.5),
        upper: Vec3::new(1.0, 0.5, 1.0),
    };
    for under in [None, Some(0), Some(1)] {
        assert_eq!(bounds_under(&scene, under), all);
    }
    // Seen with another axis up it is a wall.
    let wall = Objects::new(&scene).bounds(&scene, Some(hit(0)), UpAxis::Y);
    assert_eq!(wall.upper.x, 2000.0);
}

#[test]
fn huge_spheres_and_several_layers_are_ground() {
    let mut builder = SceneBuilder::new();
    builder.add_sphere(Vec3::Z, 1.0, MATERIAL).unwrap();
    builder
        .add_sphere(Vec3::new(0.0, 0.0, -1000.0), 1000.0, MATERIAL)
        .unwrap();
    add_square(&mut builder, 50.0, -0.1);
    let scene = builder.finish();
    for under in [None, Some(0), Some(1), Some(3)] {
        assert_eq!(bounds_under(&scene, under).upper, Vec3::new(1.0, 1.0, 2.0));
    }
}

#[test]
fn plates_and_roofs_are_objects() {
    // Nothing stands on it.
    let mut builder = SceneBuilder::new();
    add_square(&mut builder, 3.0, 0.0);
    let scene = builder.finish();
    assert_eq!(bounds_under(&scene, None).upper.x, 3.0);
    // Above everything else.
    let mut builder = SceneBuilder::new();
    builder.add_sphere(Vec3::ZERO, 0.5, MATERIAL).unwrap();
    add_square(&mut builder, 3.0, 1.0);
    let scene = builder.finish();
    assert_eq!(bounds_under(&scene, None).upper.x, 3.0);
    // Hardly wider than what is on it.
    let mut builder = SceneBuilder::new();
    builder.add_sphere(Vec3::ZERO, 0.5, MATERIAL).unwrap();
    add_square(&mut builder, 0.6, -0.5);
    let scene = builder.finish();
    assert_eq!(bounds_under(&scene, Some(0)).upper.x, 0.6);
    let nothing = SceneBuilder::new().finish();
    assert!(bounds_under(&nothing, None).is_empty());
}

#[test]
fn boxes_are_in_scene_coordinates() {
    let mut builder = SceneBuilder::new();
    let center = Vec3::new(1e5, 2e5, 3e5);
    builder.add_sphere(center, 1.0, MATERIAL).unwrap();
    let scene = builder.finish();
    assert_ne!(scene.origin(), Vec3::ZERO);
    let bounds = bounds_under(&scene, Some(0));
    assert_eq!((bounds.lower, bounds.upper), (center - 1.0, center + 1.0));
}
