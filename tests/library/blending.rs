//! Half-transparent surfaces against closed forms: each shows its opacity times its own colour, and the rest of what is
//! behind it.

use crate::glass::{GRADIENT, assert_near, color, pixels, sky, surface, under};
use glam::{DVec3, Vec3};
use octray::{
    accel::Bvh,
    render::{Film, Mode, Renderer, Settings},
    scene::{
        Background, Camera, Image, Light, LightShape, Material, MaterialId, Opacity, Scene, SceneBuilder,
        SurfaceTextures, Texture,
    },
};
use std::ops::ControlFlow;

const WHITE: Background = Background {
    bottom: [1.0; 3],
    top: [1.0; 3],
};

pub fn see_through(builder: &mut SceneBuilder, material: Material, opacity: f32) -> MaterialId {
    let textures = SurfaceTextures {
        opacity: Opacity::new(opacity, None),
        ..SurfaceTextures::NONE
    };
    builder.add_textured_material(material, textures).unwrap()
}

fn pane(builder: &mut SceneBuilder, z: f32, color: [f32; 3], opacity: f32) {
    let id = see_through(builder, Material::Silhouette { color }, opacity);
    surface(builder, z, true, id);
}

/// The colour of a ray straight down.
fn below(builder: SceneBuilder, max_depth: u32) -> [f64; 3] {
    color(&builder.finish(), DVec3::Z * 2.0, DVec3::ZERO, max_depth)
}

#[test]
fn panes_one_behind_the_other() {
    let panes = [
        ([1.0, 0.0, 0.25], 0.3),
        ([0.0, 0.5, 1.0], 0.6),
        ([0.5; 3], 0.001),
        ([1.0; 3], 0.99),
    ];
    let (mut builder, _) = under(WHITE, Material::GLASS);
    let mut expected = [1.0_f64; 3];
    for (i, (own, opacity)) in panes.into_iter().enumerate() {
        pane(&mut builder, -(i as f32), own, opacity);
    }
    for (own, opacity) in panes.into_iter().rev() {
        // What is less opaque than 1/512 is not there.
        let opacity = if opacity < 1.0 / 512.0 {
            0.0
        } else {
            f64::from(opacity)
        };
        for (sum, own) in expected.iter_mut().zip(own) {
            *sum = opacity * f64::from(own) + (1.0 - opacity) * *sum;
        }
    }
    // Going straight on takes nothing of the depth.
    for (found, expected) in below(builder, 1).into_iter().zip(expected) {
        assert_near(found, expected, 1e-6);
    }
}

/// What is behind a tinted pane is multiplied by its base colour, its image included, even if nothing else is seen of it.
#[test]
fn tinted_panes() {
    for (opacity, transparent) in [(0.0, false), (0.3, false), (0.3, true)] {
        let (mut builder, _) = under(WHITE, Material::GLASS);
        let image = Image::new([1, 1], vec![[255, 51, 0, 255]]).unwrap();
        let base = Texture {
            image: builder.add_image(image).unwrap(),
            ..Texture::default()
        };
        let tinted = Opacity::new(opacity, None).map(|all| Opacity {
            is_tinted: true,
            ..all
        });
        let textures = SurfaceTextures {
            base: Some(base),
            opacity: tinted,
            ..SurfaceTextures::NONE
        };
        let own = Material::Silhouette {
            color: [0.5, 0.75, 1.0],
        };
        let id = builder.add_textured_material(own, textures).unwrap();
        surface(&mut builder, 0.0, true, id);
        surface(&mut builder, -1.0, true, id);
        let a = f64::from(opacity);
        let colors = [0.5, 0.75 * 0.2, 0.0];
        if transparent {
            // Alpha has no tint.
            let scene = builder.finish();
            let camera = Camera::look_at(DVec3::Z * 2.0, DVec3::ZERO, DVec3::Y, 1e-3).unwrap();
            let [packet, scalar] = [Mode::Packet, Mode::Scalar].map(|mode| coverage(&scene, &camera, mode));
            assert_eq!(packet, scalar);
            let [r, .., alpha] = packet[0];
            assert_near(f64::from(alpha), 1.0 - (1.0 - a) * (1.0 - a), 1e-6);
            assert_near(f64::from(r), a * 0.5 + (1.0 - a) * 0.5 * a * 0.5, 1e-6);
            continue;
        }
        for (found, own) in below(builder, 1).into_iter().zip(colors) {
            let through = |behind: f64| a * own + (1.0 - a) * own * behind;
            assert_near(found, through(through(1.0)), 1e-6);
        }
    }
}

/// 64 panes let light through; the next one is opaque.
#[test]
fn a_stack_of_panes_does_not_end_in_black() {
    for (count, passed) in [(40, 40), (64, 64), (100, 64)] {
        let (mut builder, _) = under(WHITE, Material::GLASS);
        for i in 0..count {
            pane(&mut builder, -0.1 * i as f32, [0.0; 3], 0.05);
        }
        let left = 0.95_f64.powi(passed);
        let expected = if count > passed { 0.0 } else { left };
        assert_near(below(builder, 1)[0], expected, 1e-5);
    }
}

/// The pane is seen once more in the mirror, which takes one of the depth, and so is what is behind it there.
#[test]
fn a_pane_in_front_of_a_mirror() {
    let (a, m) = (0.3_f32, 0.8_f32);
    for max_depth in [1, 2, 3] {
        let (mut builder, _) = under(GRADIENT, Material::GLASS);
        pane(&mut builder, 1.0, [0.5; 3], a);
        let mirror = Material::Reflection {
            color: [0.0; 3],
            mirror_share: m,
        };
        let mirror = builder.add_material(mirror).unwrap();
        surface(&mut builder, 0.0, true, mirror);
        let (a, m) = (f64::from(a), f64::from(m));
        let pane = |behind: f64| a * 0.5 + (1.0 - a) * behind;
        let mirrored = if max_depth == 1 { sky(1.0) } else { pane(sky(1.0)) };
        assert_near(below(builder, max_depth)[0], pane(m * mirrored), 1e-6);
    }
}

/// A half-transparent mirror shows both.
#[test]
fn half_a_mirror() {
    let (mut builder, _) = under(GRADIENT, Material::GLASS);
    let mirror = Material::Reflection {
        color: [0.0; 3],
        mirror_share: 0.8,
    };
    let id = see_through(&mut builder, mirror, 0.25);
    surface(&mut builder, 0.0, true, id);
    let expected = 0.25 * 0.8 * sky(1.0) + 0.75 * sky(-1.0);
    assert_near(below(builder, 2)[0], expected, 1e-6);
}

/// Light above 1 is dimmed before anything clamps it.
#[test]
fn bright_light_behind_a_pane() {
    let (mut builder, _) = under(WHITE, Material::GLASS);
    pane(&mut builder, 1.0, [0.0; 3], 0.75);
    let textures = SurfaceTextures {
        emission: [8.0, 2.0, 0.0],
        ..SurfaceTextures::NONE
    };
    let black = Material::Silhouette { color: [0.0; 3] };
    let lamp = builder.add_textured_material(black, textures).unwrap();
    surface(&mut builder, 0.0, true, lamp);
    for (found, expected) in below(builder, 1).into_iter().zip([2.0, 0.5, 0.0]) {
        assert_near(found, expected, 1e-6);
    }
}

/// What is left of the light of a lamp straight above a floor, whichever way its shadow rays run, by channel.
fn left(bodies: impl Fn(&mut SceneBuilder)) -> [f64; 3] {
    let of_lamp = |light: Light| {
        let (mut builder, _) = under(WHITE, Material::GLASS);
        builder.set_ambient(0.0).unwrap();
        builder.add(light).unwrap();
        let matte = builder.classic_material(1).unwrap();
        surface(&mut builder, 0.0, true, matte);
        bodies(&mut builder);
        // From below what dims the light.
        color(&builder.finish(), DVec3::Z, DVec3::ZERO, 3).map(|c| c / 0.7)
    };
    let from_light = of_lamp(Light {
        intensity: 0.7,
        ..Light::new(LightShape::Point {
            position: Vec3::Z * 90.0,
        })
    });
    let from_floor = of_lamp(Light {
        intensity: 0.7,
        ..Light::new(LightShape::directional(DVec3::Z, 0.0).unwrap())
    });
    for (a, b) in from_light.into_iter().zip(from_floor) {
        assert_near(a, b, 1e-5);
    }
    from_light
}

pub fn assert_left(expected: [f64; 3], bodies: impl Fn(&mut SceneBuilder)) {
    for (found, expected) in left(bodies).into_iter().zip(expected) {
        assert_near(found, expected, 1e-5);
    }
}

#[test]
fn shadows_of_panes() {
    for opacity in [0.0, 0.3, 0.7, 1.0] {
        assert_left([1.0 - f64::from(opacity); 3], |builder| {
            pane(builder, 4.0, [0.0; 3], opacity);
        });
    }
    assert_left([0.5 * 0.7 * 0.5, 0.0, 0.5 * 0.7 * 0.25], |builder| {
        pane(builder, 4.0, [1.0; 3], 0.5);
        let color = [0.5, 0.0, 0.25];
        let textures = SurfaceTextures {
            opacity: Opacity::new(0.3, None).map(|opacity| Opacity {
                is_tinted: true,
                ..opacity
            }),
            ..SurfaceTextures::NONE
        };
        let id = builder
            .add_textured_material(Material::Matte { color }, textures)
            .unwrap();
        surface(builder, 5.0, false, id);
    });
    for (panes, left) in [(64, 0.98_f64.powi(64)), (65, 0.0)] {
        assert_left([left; 3], |builder| {
            (0..panes).for_each(|i| pane(builder, 4.0 + i as f32, [0.0; 3], 0.02));
        });
    }
}

/// Each pane moves the start of the rest of the ray, but not its end, which would reach into the floor.
#[test]
fn slanted_light_through_many_panes() {
    let (mut builder, _) = under(WHITE, Material::GLASS);
    builder.set_ambient(0.0).unwrap();
    builder.add_light(Vec3::new(40.0, 0.0, 30.0), 0.7).unwrap();
    let matte = builder.classic_material(1).unwrap();
    surface(&mut builder, 0.0, true, matte);
    for i in 0..20 {
        pane(&mut builder, 2.0 + i as f32, [0.0; 3], 0.05);
    }
    let found = color(&builder.finish(), DVec3::Z, DVec3::ZERO, 3)[0];
    assert_near(found, 0.7 * 0.6 * 0.95_f64.powi(20), 1e-4);
}

/// Both sides of a slab reflect, and inside light is tinted: also if the floor or the lamp is in it.
#[test]
fn shadows_of_glass() {
    let glass = Material::Glass {
        index: 1.5,
        tint: [0.25, 1.0, 0.0],
        depth: 2.0,
    };
    let tinted = |depth: f64, sides: i32| {
        [0.25_f64.powf(depth / 2.0), 1.0, 0.0].map(|tint| tint * 0.96_f64.powi(sides))
    };
    let slab = |builder: &mut SceneBuilder, bottom: Option<f32>, top: Option<f32>| {
        let id = builder.add_material(glass).unwrap();
        if let Some(z) = bottom {
            surface(builder, z, false, id);
        }
        if let Some(z) = top {
            surface(builder, z, true, id);
        }
    };
    assert_left(tinted(3.0, 2), |builder| slab(builder, Some(2.0), Some(5.0)));
    // The camera is in the glass, one above the floor.
    assert_left(tinted(5.0 + 1.0, 1), |builder| slab(builder, None, Some(5.0)));
}

/// Glass stops no ambient light, and other surfaces from an opacity of 0.5 on.
#[test]
fn ambient_light_behind_surfaces() {
    let glass = |builder: &mut SceneBuilder| {
        let id = builder.add_material(Material::GLASS).unwrap();
        surface(builder, 1.0, false, id);
        surface(builder, 2.0, true, id);
    };
    let light = |above: &dyn Fn(&mut SceneBuilder)| {
        let (mut builder, _) = under(WHITE, Material::GLASS);
        builder.set_ambient(0.5).unwrap();
        builder.set_ambient_reach(Some(1e4)).unwrap();
        let matte = builder.classic_material(1).unwrap();
        surface(&mut builder, 0.0, true, matte);
        above(&mut builder);
        color(&builder.finish(), DVec3::Z * 0.5, DVec3::ZERO, 3)[0]
    };
    assert_near(light(&glass), 0.5, 1e-6);
    assert_near(light(&|builder| pane(builder, 1.0, [0.0; 3], 0.4)), 0.5, 1e-6);
    assert_near(light(&|builder| pane(builder, 1.0, [0.0; 3], 0.6)), 0.0, 1e-6);
}

/// Alpha of pictures without background is that of all surfaces on a ray, and colours are premultiplied by it.
#[test]
fn coverage_is_opacity() {
    let (a, b) = (0.3_f32, 0.6_f32);
    for (is_on_a_mirror, alpha) in [(false, 1.0 - (1.0 - a) * (1.0 - b)), (true, 1.0)] {
        let (mut builder, _) = under(WHITE, Material::GLASS);
        pane(&mut builder, 1.0, [1.0; 3], a);
        pane(&mut builder, 0.5, [0.0; 3], b);
        if is_on_a_mirror {
            let mirror = builder.classic_material(3).unwrap();
            surface(&mut builder, 0.0, true, mirror);
        }
        let scene = builder.finish();
        let camera = Camera::look_at(DVec3::Z * 2.0, DVec3::ZERO, DVec3::Y, 1e-3).unwrap();
        let [packet, scalar] = [Mode::Packet, Mode::Scalar].map(|mode| coverage(&scene, &camera, mode));
        assert_eq!(packet, scalar);
        for [r, .., found] in packet {
            assert_near(f64::from(found), f64::from(alpha), 1e-6);
            assert!(is_on_a_mirror || (r - a).abs() < 1e-6, "{r}");
        }
    }
}

fn coverage(scene: &Scene, camera: &Camera, mode: Mode) -> Vec<[f32; 4]> {
    let settings = Settings {
        width: 9,
        height: 5,
        samples: 4,
        mode,
        ..Settings::default()
    };
    let bvh = Bvh::build(scene);
    let mut film = Film::<[f32; 4]>::black(9, 5);
    let made =
        Renderer::new(scene, &bvh).render(camera, &settings, &mut film, &|_| ControlFlow::Continue(()));
    made.unwrap();
    film.pixels().to_vec()
}

/// Alpha of an image multiplies the opacity, and where it is 0 nothing is hit.
#[test]
fn an_image_gives_opacity() {
    for alpha in [0, 51, 255] {
        let (mut builder, _) = under(WHITE, Material::GLASS);
        let image = Image::new([1, 1], vec![[9, 9, 9, alpha]]).unwrap();
        let map = Texture {
            image: builder.add_image(image).unwrap(),
            ..Texture::default()
        };
        let textures = SurfaceTextures {
            opacity: Opacity::new(0.5, Some(map)),
            ..SurfaceTextures::NONE
        };
        let black = Material::Silhouette { color: [0.0; 3] };
        let id = builder.add_textured_material(black, textures).unwrap();
        surface(&mut builder, 0.0, true, id);
        let expected = 1.0 - 0.5 * f64::from(alpha) / 255.0;
        assert_near(below(builder, 1)[0], expected, 1e-6);
    }
}

/// Glass shows what is behind panes, panes what is behind glass.
#[test]
fn panes_and_glass_in_a_white_furnace() {
    let (mut builder, glass) = under(WHITE, Material::GLASS);
    pane(&mut builder, 0.2, [1.0; 3], 0.5);
    builder.add_sphere(Vec3::ZERO, 0.5, glass).unwrap();
    pane(&mut builder, -1.0, [1.0; 3], 0.3);
    let camera = Camera::look_at(DVec3::new(0.4, 0.3, 3.0), DVec3::ZERO, DVec3::Y, 30.0).unwrap();
    for [r, ..] in pixels(&builder.finish(), &camera, 5) {
        assert!((r - 1.0).abs() < 1e-5, "{r}");
    }
}
