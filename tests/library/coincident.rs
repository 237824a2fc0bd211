//! Opaque surfaces in the same place as half-transparent ones and glass: nothing passes them.

use crate::{
    blending::{assert_left, see_through},
    glass::{color, pixels, surface, under},
    instances::brute_force_agrees,
};
use glam::{DQuat, DVec3, Vec3};
use octray::scene::{
    Background, Camera, Image, Material, MaterialId, Opacity, SceneBuilder, SurfaceTextures, Texture,
    Transform,
};

const BLUE: Background = Background {
    bottom: [0.0, 0.0, 1.0],
    top: [0.0, 0.0, 1.0],
};

/// What the square in front is made of.
#[derive(Clone, Copy, Debug)]
enum Front {
    Pane,
    Clear,
    Image,
    Glass,
}

const FRONTS: [Front; 4] = [Front::Pane, Front::Clear, Front::Image, Front::Glass];

impl Front {
    fn add(self, builder: &mut SceneBuilder) -> MaterialId {
        let red = Material::Silhouette {
            color: [1.0, 0.0, 0.0],
        };
        match self {
            Self::Pane => see_through(builder, red, 0.3),
            Self::Clear => see_through(builder, red, 0.01),
            Self::Image => {
                let image = Image::new([1, 1], vec![[255, 255, 255, 99]]).unwrap();
                let map = Texture {
                    image: builder.add_image(image).unwrap(),
                    ..Texture::default()
                };
                let textures = SurfaceTextures {
                    opacity: Opacity::new(1.0, Some(map)),
                    ..SurfaceTextures::NONE
                };
                builder.add_textured_material(red, textures).unwrap()
            }
            Self::Glass => builder.add_material(Material::GLASS).unwrap(),
        }
    }
}

/// What is opaque, in the same place.
#[derive(Clone, Copy, Debug)]
enum Behind {
    Same,
    /// Triangles of another size, so that distances are rounded in another way.
    Larger,
    Plane,
    Instance,
}

const BEHIND: [Behind; 4] = [Behind::Same, Behind::Larger, Behind::Plane, Behind::Instance];

/// The corners of two triangles of a square about `center`.
fn square(center: DVec3, turn: DQuat, size: f64) -> [[Vec3; 3]; 2] {
    let corner = |x: f64, y: f64| (center + turn * DVec3::new(x * size, y * size, 0.0)).as_vec3();
    let [a, b, c, d] = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    [[a, b, c], [a, c, d]]
}

impl Behind {
    fn add(self, builder: &mut SceneBuilder, center: DVec3, turn: DQuat, material: MaterialId) {
        let size = match self {
            Self::Same => 2.0,
            Self::Larger => 7.3,
            Self::Plane => {
                let normal = (turn * DVec3::Z).as_vec3();
                return builder.add_plane(center.as_vec3(), normal, material).unwrap();
            }
            Self::Instance => {
                let square = square(DVec3::ZERO, DQuat::IDENTITY, 1.0);
                let prototype = builder.add_prototype(|builder| {
                    square
                        .into_iter()
                        .try_for_each(|corners| builder.add_triangle(corners, material))
                });
                let (axis, angle) = turn.to_axis_angle();
                let placed = Transform::IDENTITY
                    .then_scale(DVec3::splat(2.5))
                    .then_rotate(axis, angle.to_degrees())
                    .then_translate(center);
                return builder.add_instance(prototype.unwrap(), &placed).unwrap();
            }
        };
        for corners in square(center, turn, size) {
            builder.add_triangle(corners, material).unwrap();
        }
    }
}

/// Calls `check` with what adds a pair of squares about a point to a scene, for each pair, order and tilt.
fn each_pair(at: DVec3, mut check: impl FnMut(&str, &dyn Fn(&mut SceneBuilder))) {
    let tilted = DQuat::from_axis_angle(DVec3::new(0.6, 0.7, 0.2).normalize(), 0.9);
    for turn in [DQuat::IDENTITY, tilted] {
        for (front, behind) in FRONTS
            .iter()
            .flat_map(|front| BEHIND.map(|behind| (front, behind)))
        {
            for is_front_first in [false, true] {
                let name = format!("{front:?} {behind:?} {is_front_first} {turn}");
                check(&name, &|builder| {
                    let green = Material::Silhouette {
                        color: [0.0, 1.0, 0.0],
                    };
                    let (front, green) = (front.add(builder), builder.add_material(green).unwrap());
                    let add_front = |builder: &mut SceneBuilder| {
                        for corners in square(at, turn, 2.0) {
                            builder.add_triangle(corners, front).unwrap();
                        }
                    };
                    if is_front_first {
                        add_front(builder);
                    }
                    behind.add(builder, at, turn, green);
                    if !is_front_first {
                        add_front(builder);
                    }
                });
            }
        }
    }
}

#[test]
fn cameras_see_what_is_opaque() {
    let center = DVec3::new(0.3, -0.7, 1.1);
    each_pair(center, |name, add| {
        let (mut builder, _) = under(BLUE, Material::GLASS);
        add(&mut builder);
        let scene = builder.finish();
        for side in [1.0, -1.0] {
            let eye = center + DVec3::new(0.5, 0.2, 3.0) * side;
            let camera = Camera::look_at(eye, center, DVec3::Y, 12.0).unwrap();
            for pixel in pixels(&scene, &camera, 4) {
                assert_eq!(pixel, [0.0, 1.0, 0.0], "{name}, side {side}");
            }
            if name.contains("Glass") {
                brute_force_agrees(&scene, &camera);
            }
        }
    });
}

#[test]
fn no_light_passes() {
    each_pair(DVec3::new(0.3, -0.2, 4.1), |_, add| assert_left([0.0; 3], add));
}

/// A floor in the bottom of a slab of glass is seen, and lit through the glass above it.
#[test]
fn glass_on_a_floor() {
    let slab = Material::Glass {
        index: 1.5,
        tint: [0.25, 1.0, 0.0],
        depth: 2.0,
    };
    // Light goes through 5, and what the camera sees of it through 1: three times the depth of the tint.
    let left = [0.25_f64.powi(3), 1.0, 0.0].map(|tint| tint * 0.96);
    assert_left(left, |builder| {
        let id = builder.add_material(slab).unwrap();
        surface(builder, 0.0, false, id);
        surface(builder, 5.0, true, id);
    });
}

/// Of equal triangles the BVH keeps some: with a half-transparent one the opaque one, too.
#[test]
fn equal_triangles_keep_what_is_opaque() {
    for opacity in [0.3, 0.5, 0.7, 0.99] {
        let (mut builder, _) = under(BLUE, Material::GLASS);
        let [red, green] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|color| Material::Silhouette { color });
        let pane = see_through(&mut builder, red, opacity);
        let wall = builder.add_material(green).unwrap();
        for material in [pane, wall, wall, pane] {
            surface(&mut builder, 0.0, true, material);
        }
        let found = color(&builder.finish(), DVec3::Z * 2.0, DVec3::ZERO, 4);
        assert_eq!(found, [0.0, 1.0, 0.0], "{opacity}");
    }
}
