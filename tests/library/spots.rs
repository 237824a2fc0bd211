//! Spots against closed forms, very narrow ones too.

use super::{
    lights::{assert_close, lit},
    soft_light::brightness,
};
use glam::{DVec3, Vec3};
use octray::{
    reference::light,
    scene::{Light, LightShape, Spot},
};

#[test]
fn spots_light_their_cone() {
    let light = Light {
        spot: Some(Spot::new(DVec3::NEG_Z * 3.0, 20.0, 40.0).expect("a spot")),
        ..Light::new(LightShape::Point { position: Vec3::Z })
    };
    assert_eq!(light.spot.map(|spot| spot.degrees()), Some([20.0, 40.0]));
    let scene = lit(light, 1.0).finish();
    for (degrees, share) in [(0.0, 1.0), (19.0, 1.0), (30.0, 0.5), (41.0, 0.0), (70.0, 0.0)] {
        let cosine = f64::to_radians(degrees).cos();
        // Linear in the cosine, then squared.
        let [inner, outer] = [20.0_f64, 40.0].map(|angle| angle.to_radians().cos());
        let expected = if share == 0.5 {
            cosine * ((cosine - outer) / (inner - outer)).powi(2)
        } else {
            cosine * share
        };
        let at = DVec3::X * f64::to_radians(degrees).tan();
        assert_close(
            brightness(&scene, at, 1.0, 1),
            expected,
            1e-3,
            &format!("{degrees}"),
        );
    }
}

#[test]
fn narrow_spots_are_bright() {
    for (inner, outer) in [(1.0, 1.0), (0.0, 2.0), (0.3, 0.3), (1.5, 2.0)] {
        let light = Light {
            spot: Some(Spot::new(DVec3::NEG_Z, inner, outer).expect("a spot")),
            ..Light::new(LightShape::Point { position: Vec3::Z })
        };
        assert_eq!(light.spot.map(|spot| spot.degrees()), Some([inner, outer]));
        let found = brightness(&lit(light, 1.0).finish(), DVec3::ZERO, 1.0, 1);
        assert!(found > 0.95, "{inner} {outer}: {found}");
    }
}

/// A hundred metres above the ground, an angle of 0.05 degrees is 9 centimetres wide. Its cosine is six steps below 1 in `f32`.
#[test]
fn very_narrow_spots_fade_evenly() {
    let height = 100.0_f64;
    for (inner, outer) in [
        (0.02_f32, 0.05_f32),
        (0.0, 0.1),
        (0.004, 0.01),
        (0.1, 0.3),
        (0.0, 0.001),
    ] {
        for direction in [DVec3::NEG_Z, DVec3::new(0.48, -0.64, -0.6)] {
            let light = Light {
                spot: Some(Spot::new(direction, inner, outer).expect("a spot")),
                ..Light::new(LightShape::Directional {
                    to_light: Vec3::Z,
                    sine: 0.0,
                })
            };
            let share = |degrees: f64| {
                // Around the axis of the cone, by its own geometry.
                let side = direction.cross(DVec3::X).normalize();
                let angle = degrees.to_radians();
                let from_light = direction * angle.cos() + side * angle.sin();
                let shape = LightShape::Point {
                    position: (-from_light * height).as_vec3(),
                };
                let (_, power) = light::from_middle(&Light { shape, ..light }, Vec3::ZERO);
                f64::from(power[0])
            };
            let [inner, outer] = [inner, outer].map(f64::from);
            for step in 0..40 {
                let degrees = outer * f64::from(step) / 30.0;
                let drop = |degrees: f64| 1.0 - degrees.to_radians().cos();
                let fade = (drop(outer) - drop(degrees)) / (drop(outer) - drop(inner));
                let expected = fade.clamp(0.0, 1.0).powi(2);
                assert_close(
                    share(degrees),
                    expected,
                    0.02,
                    &format!("{inner} {outer} {degrees}"),
                );
            }
        }
    }
    let light = Light {
        spot: Some(Spot::new(DVec3::NEG_Z, 0.02, 0.05).expect("a spot")),
        ..Light::new(LightShape::Point {
            position: Vec3::Z * 100.0,
        })
    };
    let scene = lit(light, 1.0).finish();
    for (x, expected) in [(0.0, 1.0), (0.03, 1.0), (0.0611, 0.3686), (0.1, 0.0)] {
        let found = brightness(&scene, DVec3::X * x, 1.0, 1);
        assert_close(found, expected, 0.02, &format!("{x}"));
    }
}
