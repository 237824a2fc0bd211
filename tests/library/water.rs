//! Light in tinted glass, to surfaces in the same glass, against Beer and Lambert.

use super::{
    blending::see_through,
    glass::{assert_near, color, surface, under},
};
use glam::{DVec3, Vec3};
use octray::scene::{Background, Light, LightShape, Material, MaterialId, Scene, SceneBuilder};

const TINT: [f32; 3] = [0.5, 0.7, 1.0];
const INTENSITY: f64 = 0.8;

/// Glass that neither reflects nor bends light, and a white ground at z = 0.
fn scene(with: impl FnOnce(&mut SceneBuilder, MaterialId)) -> Scene {
    let material = Material::Glass {
        index: 1.0,
        tint: TINT,
        depth: 1.0,
    };
    let (mut builder, water) = under(Background::constant([0.0; 3]), material);
    builder.set_ambient(0.0).unwrap();
    let white = builder.add_material(Material::Matte { color: [1.0; 3] }).unwrap();
    surface(&mut builder, 0.0, true, white);
    with(&mut builder, water);
    builder.finish()
}

fn lamp(builder: &mut SceneBuilder, shape: LightShape) {
    let light = Light {
        intensity: INTENSITY as f32,
        ..Light::new(shape)
    };
    builder.add(light).unwrap();
}

/// What a camera at this height sees of the ground below it: `share` of the light after a distance in glass.
#[track_caller]
fn assert_seen(scene: &Scene, height: f64, share: f64, distance: f64) {
    let found = color(scene, DVec3::Z * height, DVec3::ZERO, 30);
    for (found, tint) in found.into_iter().zip(TINT) {
        assert_near(found, INTENSITY * share * f64::from(tint).powf(distance), 2e-3);
    }
}

/// Lamps one above the ground, and a sun.
fn shapes() -> [(LightShape, f64); 3] {
    let up = Vec3::Z;
    [
        (LightShape::Point { position: up }, 1.0),
        (
            LightShape::Sphere {
                center: up * 1.001,
                radius: 0.001,
            },
            1.0,
        ),
        (
            LightShape::Rectangle {
                center: up,
                edges: [Vec3::Y * 0.01, Vec3::X * 0.01],
            },
            1.0,
        ),
    ]
}

#[test]
fn lamps_in_water_are_tinted_on_their_way() {
    for (shape, way) in shapes() {
        let made = scene(|builder, water| {
            surface(builder, 3.0, true, water);
            lamp(builder, shape);
        });
        // In the water, and above it.
        assert_seen(&made, 0.5, 1.0, way + 0.5);
        assert_seen(&made, 4.0, 1.0, way + 3.0);
    }
}

#[test]
fn light_from_above_is_tinted_in_the_water_only() {
    let sun = LightShape::Directional {
        to_light: Vec3::Z,
        sine: 0.0,
    };
    let above = LightShape::Point {
        position: Vec3::Z * 2.0,
    };
    for shape in [sun, above] {
        let made = scene(|builder, water| {
            surface(builder, 0.75, true, water);
            lamp(builder, shape);
        });
        assert_seen(&made, 0.5, 1.0, 0.75 + 0.5);
        assert_seen(&made, 3.0, 1.0, 0.75 + 0.75);
    }
    // Without water around the eye or the lamp there is no tint.
    let made = scene(|builder, water| {
        surface(builder, -1.0, true, water);
        lamp(builder, above);
    });
    assert_seen(&made, 0.5, 1.0, 0.0);
}

#[test]
fn sheets_in_water_dim_light_too() {
    for (shape, way) in shapes() {
        let made = scene(|builder, water| {
            surface(builder, 3.0, true, water);
            let black = Material::Silhouette { color: [0.0; 3] };
            let sheet = see_through(builder, black, 0.25);
            surface(builder, 0.6, true, sheet);
            lamp(builder, shape);
        });
        assert_seen(&made, 0.5, 0.75, way + 0.5);
        assert_seen(&made, 4.0, 0.75 * 0.75, way + 3.0);
    }
}

/// Half of the pixels see a point whose light is blocked: blocked and other rays share packets.
#[test]
fn shadows_in_water_are_black() {
    let made = scene(|builder, water| {
        surface(builder, 3.0, true, water);
        let black = builder
            .add_material(Material::Silhouette { color: [0.0; 3] })
            .unwrap();
        let corner = |x: f32, y: f32| Vec3::new(x, y, 0.8);
        builder
            .add_triangle([corner(0.0, -9.0), corner(9.0, 0.0), corner(0.0, 9.0)], black)
            .unwrap();
        lamp(builder, LightShape::Point { position: Vec3::Z });
    });
    // Both modes agree, which `color` checks; the view is across the shadow's edge.
    let up = DVec3::Y;
    let camera = octray::scene::Camera::look_at(DVec3::new(-0.1, 0.0, 0.5), DVec3::ZERO, up, 20.0).unwrap();
    let pixels = super::glass::pixels(&made, &camera, 5);
    let [dark, lit] = [true, false].map(|dark| pixels.iter().filter(|p| (p[1] == 0.0) == dark).count());
    assert!(dark > 20 && lit > 20, "{dark} {lit}");
}

/// A lamp and a body in a glass ball, seen from outside.
#[test]
fn lamps_in_a_ball_are_tinted_on_their_way() {
    let material = Material::Glass {
        index: 1.0,
        tint: TINT,
        depth: 1.0,
    };
    let (mut builder, id) = under(Background::constant([0.0; 3]), material);
    builder.set_ambient(0.0).unwrap();
    builder.add_sphere(Vec3::ZERO, 2.0, id).unwrap();
    let white = builder.add_material(Material::Matte { color: [1.0; 3] }).unwrap();
    let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    builder
        .add_triangle([corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.0, 0.5)], white)
        .unwrap();
    lamp(
        &mut builder,
        LightShape::Point {
            position: Vec3::Z * 1.5,
        },
    );
    assert_seen(&builder.finish(), 9.0, 1.0, 1.5 + 2.0);
}
