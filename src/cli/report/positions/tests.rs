//! Tests of `positions`.

use super::*;
use crate::scene::{MaterialId, SceneBuilder};

#[test]
fn positions_have_the_digits_of_their_file() {
    let scene = |offset: DVec3, radius: f32| {
        let mut builder = SceneBuilder::new();
        builder.set_offset(offset).unwrap();
        builder.add_sphere(Vec3::ZERO, radius, MaterialId(0)).unwrap();
        Positions::of(&builder.finish())
    };
    let near = scene(DVec3::ZERO, 1.0);
    assert_eq!(near.within(Vec3::new(0.1, -2.7, 1e9)), [0.1, -2.7, 1e9]);
    assert_eq!(near.rounded(DVec3::splat(f64::from(0.1_f32))), [0.1; 3]);
    let far = DVec3::new(500_000.0, 4e6, 0.0);
    let map = scene(far, 10.0);
    assert_eq!(
        map.within(Vec3::new(0.001, -0.7, 0.3)),
        [500_000.001, 3_999_999.3, 0.3]
    );
    assert_eq!(
        scene(far, 1e5).within(Vec3::splat(0.123)),
        [500_000.12, 4_000_000.12, 0.12]
    );
    assert_eq!(scene(far, 1e-9).decimals, Some(12));
}
