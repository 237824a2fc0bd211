//! Tests of `aov`.

use super::*;

#[test]
fn depth_spans_the_scene() {
    let bounds = Aabb {
        lower: Vec3::ZERO,
        upper: Vec3::splat(2.0),
    };
    let range = DepthRange::from(bounds, Vec3::new(-3.0, 1.0, 1.0));
    assert_eq!(
        (range.white, range.gray(3.0), range.gray(range.black)),
        (3.0, 255, 1)
    );
    let within = DepthRange::from(bounds, Vec3::ONE);
    assert!(within.white > 0.0 && within.gray(0.0) == 255);
    let parallel = DepthRange::along(bounds, Vec3::new(-3.0, 9.0, 1.0), Vec3::X);
    assert_eq!((parallel.white, parallel.black), (3.0, 5.0));
}

#[test]
fn planes_widen_the_range() {
    let range = |white, black| DepthRange { white, black };
    let scene = range(3.0, 20.0);
    assert_eq!(scene.with_planes([].into_iter()), scene);
    assert_eq!(scene.with_planes([[2.0; 2]].into_iter()), range(2.0, 200.0));
    assert_eq!(
        scene.with_planes([[0.1; 2], [5.0; 2]].into_iter()),
        range(0.1, 500.0)
    );
    assert_eq!(scene.with_planes([[0.0; 2]].into_iter()), scene);
    let nothing = DepthRange::nothing();
    assert_eq!(nothing.with_planes([[2.0; 2]].into_iter()), range(2.0, 200.0));
    for without in [&[][..], &[[0.0; 2]], &[[1.0, f32::INFINITY]]] {
        assert_eq!(nothing.with_planes(without.iter().copied()), range(0.0, 1.0));
    }
    assert_eq!(nothing.with_planes([[0.02, 2.0]].into_iter()), range(0.02, 200.0));
    let ground = nothing.with_planes([[2.0; 2]].into_iter());
    let grays = [0.0, 2.0, 20.0, 199.0, 200.0, 1e30, f32::INFINITY].map(|depth| ground.gray(depth));
    assert_eq!(grays, [255, 255, 127, 1, 1, 1, 1]);
    let wide = nothing.with_planes([[f32::MAX; 2]].into_iter());
    assert!(wide.black.is_finite() && wide.gray(f32::MAX) > 0);
}
