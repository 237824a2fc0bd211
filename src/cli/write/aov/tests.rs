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
        (3.0, 255, 0)
    );
    let within = DepthRange::from(bounds, Vec3::ONE);
    assert!(within.white > 0.0 && within.gray(0.0) == 255);
    DepthRange::from(Aabb::EMPTY, Vec3::ONE);
    let parallel = DepthRange::along(bounds, Vec3::new(-3.0, 9.0, 1.0), Vec3::X);
    assert_eq!((parallel.white, parallel.black), (3.0, 5.0));
    assert!(DepthRange::along(Aabb::EMPTY, Vec3::ONE, Vec3::X).white > 0.0);
}
