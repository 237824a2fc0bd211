//! Tests of `instance`.

use super::*;
use crate::scene::{MaterialId, SceneBuilder};

#[test]
fn the_end_of_an_image_is_the_least_t_at_the_end_of_the_ray() {
    let mut random = fastrand::Rng::with_seed(3);
    for round in 0..200_000 {
        let power = |random: &mut fastrand::Rng, most: f64| 10_f64.powf((random.f64() * 2.0 - 1.0) * most);
        let length = [1.0, power(&mut random, 9.0), power(&mut random, 30.0)][round % 3];
        let end = power(&mut random, 45.0) as f32;
        let t_max = [end, 1.0, T_MAX, f32::MIN_POSITIVE, 1e-40, 0.0][round % 6].min(T_MAX);
        let image = ImageRay::new(Ray::new(Vec3::ZERO, Vec3::X), length).unwrap();
        let end = image.end(t_max);
        assert!(end == T_MAX || image.in_scene(end) >= t_max, "{length} {t_max}");
        assert!(
            end == 0.0 || image.in_scene(end.next_down()) < t_max,
            "{length} {t_max}"
        );
        if image.in_scene(T_MAX) > t_max {
            assert!(image.in_scene(image.beyond(t_max)) >= t_max, "{length} {t_max}");
        }
    }
}

#[test]
fn vertices_that_no_triangle_uses_do_not_enlarge_an_instance() {
    let bounds_with = |more: &[f32]| {
        let with = |column: [f32; 3]| [&column[..], more].concat();
        let mesh = TriangleMesh {
            x: with([0.0, 1.0, 0.0]),
            y: with([0.0, 0.0, 1.0]),
            z: with([0.0, 0.0, 0.5]),
            triangles: vec![[0, 1, 2]],
            ..TriangleMesh::default()
        };
        let mut builder = SceneBuilder::new();
        let prototype = builder.add_prototype(|builder| builder.add_mesh(mesh, MaterialId(0)));
        builder
            .add_instance(
                prototype.unwrap(),
                &Transform::IDENTITY.then_scale(DVec3::splat(2e4)),
            )
            .unwrap();
        builder.finish().instance_bounds(InstanceId(0))
    };
    let bounds = bounds_with(&[]);
    assert_eq!(
        (bounds.lower, bounds.upper),
        (Vec3::ZERO, Vec3::new(2e4, 2e4, 1e4))
    );
    for far in [-99_999.0, 1e9] {
        let with_more = bounds_with(&[far]);
        assert_eq!((with_more.lower, with_more.upper), (bounds.lower, bounds.upper));
    }
}

#[test]
fn errors_about_memory_name_the_whole_limit() {
    let limit = 100_000;
    let mut builder = SceneBuilder::within(limit);
    let prototype = builder.add_prototype(|builder| builder.add_sphere(Vec3::ZERO, 1.0, MaterialId(0)));
    let prototype = prototype.unwrap();
    let error = std::iter::repeat_with(|| builder.add_instance(prototype, &Transform::IDENTITY))
        .find_map(Result::err)
        .unwrap();
    let found =
        matches!(error, SceneError::OverLimit { needed, limit: found } if found == limit && needed > limit);
    assert!(found, "{error:?}");
    assert_eq!(builder.check_instances(0), Ok(()));
    let many = builder.check_instances(1000);
    assert!(matches!(many, Err(SceneError::OverLimit { needed, .. }) if needed > 260_000));
}
