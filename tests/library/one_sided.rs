//! One-sided surfaces: camera rays pass their backs, also behind mirrors, glass and half-transparent surfaces; light does not.

use crate::{
    blending::assert_left,
    glass::{assert_near, color, surface, under},
    sameness::{Sameness, sized},
};
use glam::{DVec3, Vec3};
use octray::{
    accel::Bvh,
    render::{Film, Mode, Renderer, Settings},
    scene::{
        Background, Camera, Light, LightShape, Material, MaterialId, Opacity, Scene, SceneBuilder,
        SurfaceTextures, Transform, TriangleMesh,
    },
};
use std::ops::ControlFlow;

const GREY: Background = Background {
    bottom: [0.25; 3],
    top: [0.25; 3],
};

const RED: Material = Material::Silhouette {
    color: [1.0, 0.0, 0.0],
};
const BLUE: Material = Material::Silhouette {
    color: [0.0, 0.0, 1.0],
};
const MIRROR: Material = Material::Reflection {
    color: [0.0; 3],
    mirror_share: 1.0,
};

fn one_sided(builder: &mut SceneBuilder, material: Material, opacity: f32) -> MaterialId {
    let textures = SurfaceTextures {
        opacity: Opacity::new(opacity, None),
        one_sided: true,
        ..SurfaceTextures::NONE
    };
    builder.add_textured_material(material, textures).unwrap()
}

/// The colour of a ray straight down on a surface that faces up or down, with `behind` in the scene.
fn seen(up: bool, opacity: f32, behind: impl Fn(&mut SceneBuilder)) -> [f64; 3] {
    let (mut builder, _) = under(GREY, BLUE);
    let red = one_sided(&mut builder, RED, opacity);
    surface(&mut builder, 0.0, up, red);
    behind(&mut builder);
    color(&builder.finish(), DVec3::Z * 2.0, DVec3::ZERO, 4)
}

#[test]
fn backs_are_invisible() {
    let (red, blue, grey) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.25; 3]);
    let floor = |builder: &mut SceneBuilder| {
        let id = builder.add_material(BLUE).unwrap();
        surface(builder, -1.0, true, id);
    };
    assert_eq!(seen(true, 1.0, floor), red);
    assert_eq!(seen(false, 1.0, floor), blue);
    assert_eq!(seen(false, 1.0, |_| {}), grey);
    // Any number of them.
    let many = |builder: &mut SceneBuilder| {
        let id = one_sided(builder, RED, 1.0);
        (1..200).for_each(|i| surface(builder, -0.001 * i as f32, false, id));
        floor(builder);
    };
    assert_eq!(seen(false, 1.0, many), blue);
    // Half-transparent ones, and in a scene whose rays branch.
    assert_eq!(seen(true, 0.5, floor), [0.5, 0.0, 0.5]);
    assert_eq!(seen(false, 0.5, floor), blue);
    // Behind half-transparent surfaces, in the same place as well: the back is not what is opaque there.
    for z in [0.5, 0.0] {
        let pane = |builder: &mut SceneBuilder| {
            let textures = SurfaceTextures {
                opacity: Opacity::new(0.5, None),
                ..SurfaceTextures::NONE
            };
            let id = builder.add_textured_material(RED, textures).unwrap();
            surface(builder, z, true, id);
            floor(builder);
        };
        assert_eq!(seen(false, 1.0, pane), [0.5, 0.0, 0.5], "{z}");
    }
    // In mirrors: below the camera, and what is above is seen from below.
    for (up, expected) in [(false, red), (true, grey)] {
        let (mut builder, _) = under(GREY, BLUE);
        let mirror = builder.add_material(MIRROR).unwrap();
        surface(&mut builder, 0.0, true, mirror);
        let red = one_sided(&mut builder, RED, 1.0);
        surface(&mut builder, 5.0, up, red);
        assert_eq!(color(&builder.finish(), DVec3::Z * 2.0, DVec3::ZERO, 4), expected);
    }
}

/// One-sided surfaces with another in the same place: each is seen from its side.
#[test]
fn two_sides_in_one_place() {
    let floor = |up: bool| {
        move |builder: &mut SceneBuilder| {
            let id = one_sided(builder, BLUE, 1.0);
            surface(builder, 0.0, up, id);
        }
    };
    assert_eq!(seen(true, 1.0, floor(false)), [1.0, 0.0, 0.0]);
    assert_eq!(seen(false, 1.0, floor(true)), [0.0, 0.0, 1.0]);
    // The same corners, with two sides.
    let both = |builder: &mut SceneBuilder| {
        let id = builder.add_material(BLUE).unwrap();
        surface(builder, 0.0, false, id);
    };
    assert_eq!(seen(false, 1.0, both), [0.0, 0.0, 1.0]);
}

#[test]
fn backs_stop_light() {
    for up in [false, true] {
        assert_left([0.0; 3], |builder| {
            let id = one_sided(builder, BLUE, 1.0);
            surface(builder, 4.0, up, id);
        });
        // Behind glass, light is followed from surface to surface.
        assert_left([0.0; 3], |builder| {
            let glass = builder.add_material(Material::GLASS).unwrap();
            surface(builder, 2.0, false, glass);
            surface(builder, 3.0, true, glass);
            let id = one_sided(builder, BLUE, 1.0);
            surface(builder, 4.0, up, id);
        });
    }
}

/// Mirrored or not, instances keep their fronts.
#[test]
fn instances_keep_their_fronts() {
    for factor in [1.0, -1.0] {
        for (up, expected) in [(true, 1.0), (false, 0.25)] {
            let (mut builder, _) = under(GREY, BLUE);
            let red = one_sided(&mut builder, RED, 1.0);
            let prototype = builder.add_prototype(|builder| {
                surface(builder, 0.0, up, red);
                Ok(())
            });
            let placed = Transform::IDENTITY.then_scale(DVec3::new(factor, 1.0, 1.0));
            builder.add_instance(prototype.unwrap(), &placed).unwrap();
            let scene = builder.finish();
            let found = color(&scene, DVec3::Z * 2.0, DVec3::ZERO, 1);
            assert_near(found[0], expected, 0.0);
            let below = color(&scene, DVec3::Z * -2.0, DVec3::ZERO, 1);
            assert_near(below[0], 1.25 - expected, 0.0);
        }
    }
}

/// Triangles of all materials, one-sided or not, some of them instances, under several lights.
fn scattered(branches: bool, textured: bool) -> Scene {
    let mut random = fastrand::Rng::with_seed(23);
    let mut builder = SceneBuilder::new();
    builder.add_light(Vec3::new(-2.0, -3.0, 4.0), 0.4).unwrap();
    let sun = LightShape::directional(DVec3::new(1.0, -2.0, 3.0), 9.0).unwrap();
    builder.add(Light::new(sun)).unwrap();
    builder.set_ambient_reach(Some(1.0)).unwrap();
    let mirror = Material::CLASSIC[2];
    let mut materials = Vec::new();
    for material in [Material::CLASSIC[0], Material::CLASSIC[1], mirror, BLUE] {
        materials.push(one_sided(&mut builder, material, 1.0));
        materials.push(builder.add_material(material).unwrap());
    }
    if branches {
        materials.push(one_sided(&mut builder, RED, 0.5));
        materials.push(builder.add_material(Material::GLASS).unwrap());
    }
    if textured {
        let textures = SurfaceTextures {
            emission: [0.1, 0.0, 0.2],
            one_sided: true,
            ..SurfaceTextures::NONE
        };
        let added = builder.add_textured_material(Material::CLASSIC[1], textures);
        materials.push(added.unwrap());
    }
    let mut corner = |size: f32| Vec3::new(random.f32(), random.f32(), random.f32()) * size - 0.5 * size;
    for i in 0..150 {
        let at = corner(3.0);
        let corners = [at, at + corner(1.5), at + corner(1.5)];
        let material = materials[i % materials.len()];
        builder.add_triangle(corners, material).unwrap();
        if i % 5 == 0 {
            // The same again.
            let other = materials[i / 5 % materials.len()];
            builder.add_triangle(corners, other).unwrap();
        }
    }
    let tent = TriangleMesh {
        x: vec![-1.0, 1.0, 1.0, -1.0, 0.0],
        y: vec![-1.0, -1.0, 1.0, 1.0, 0.0],
        z: vec![0.0, 0.0, 0.0, 0.0, 0.8],
        triangles: vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
        ..TriangleMesh::default()
    };
    let prototype = builder.add_prototype(|builder| builder.add_mesh(tent, materials[2]));
    let prototype = prototype.unwrap();
    for i in 0..12 {
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        let placed = Transform::IDENTITY
            .then_scale(DVec3::new(0.3 * sign, 0.4, 0.5))
            .then_rotate(corner(2.0).as_dvec3(), 30.0 * f64::from(i))
            .then_translate(corner(3.0).as_dvec3());
        builder.add_instance(prototype, &placed).unwrap();
    }
    builder
        .add_plane(Vec3::Z * -1.2, Vec3::new(0.1, 0.0, 1.0), materials[3])
        .unwrap();
    builder.finish()
}

#[test]
fn scenes_of_one_sided_surfaces() {
    for (branches, textured) in [(false, false), (false, true), (true, false)] {
        let scene = scattered(branches, textured);
        let sameness = Sameness::of("one-sided surfaces", &scene);
        for (i, max_depth) in [(1, 1), (2, 5)] {
            let camera = Camera::classic_view(i).expect("views are 1 to 6");
            let settings = Settings {
                max_depth,
                ..sized(61, 47, 4)
            };
            sameness.check(&camera, &settings);
        }
    }
}

/// Where only backs are in the way, pictures without a background are transparent, and AOVs show what pictures do.
#[test]
fn coverage_and_aovs() {
    let (mut builder, _) = under(GREY, BLUE);
    let red = one_sided(&mut builder, RED, 1.0);
    surface(&mut builder, 1.0, false, red);
    let blue = builder.add_material(BLUE).unwrap();
    let corners = [Vec3::ZERO, Vec3::X * 9.0, Vec3::new(9.0, 9.0, 0.0)];
    builder.add_triangle(corners, blue).unwrap();
    let scene = builder.finish();
    let bvh = Bvh::build(&scene);
    let camera = Camera::look_at(DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y, 40.0).unwrap();
    let mut all = Vec::new();
    for mode in [Mode::Packet, Mode::Scalar] {
        let settings = Settings {
            width: 21,
            height: 15,
            mode,
            ..Settings::default()
        };
        let mut renderer = Renderer::new(&scene, &bvh);
        let mut film = Film::<[f32; 4]>::black(21, 15);
        let go_on = |_| ControlFlow::Continue(());
        renderer
            .render(&camera, &settings, &mut film, &|p| go_on(p))
            .unwrap();
        let aovs = renderer.aovs(&camera, &settings, false, &|_| ControlFlow::Continue(()));
        let depths: Vec<f32> = aovs.unwrap().pixels.iter().map(|aov| aov.depth).collect();
        let is_blue = |pixel: &[f32; 4]| *pixel == [0.0, 0.0, 1.0, 1.0];
        assert!(film.pixels().iter().any(is_blue));
        for (pixel, depth) in film.pixels().iter().zip(&depths) {
            assert!(is_blue(pixel) || *pixel == [0.0; 4], "{pixel:?}");
            assert_eq!(depth.is_finite(), is_blue(pixel), "{depth}");
            assert!(!is_blue(pixel) || *depth > 4.9, "{depth}");
        }
        all.push((film.pixels().to_vec(), depths));
    }
    assert_eq!(all[0], all[1]);
}

#[test]
fn two_sides_of_a_leaf_are_no_duplicates() {
    for (one_sided, expected) in [(true, 1), (false, 2)] {
        let mut builder = SceneBuilder::new();
        let textures = SurfaceTextures {
            one_sided,
            ..SurfaceTextures::NONE
        };
        let red = builder.add_textured_material(RED, textures).unwrap();
        let mesh = TriangleMesh {
            x: vec![0.0, 1.0, 0.0],
            y: vec![0.0, 0.0, 1.0],
            z: vec![0.0; 3],
            triangles: vec![[0, 1, 2], [1, 0, 2], [2, 1, 0]],
            ..TriangleMesh::default()
        };
        builder.add_mesh(mesh, red).unwrap();
        assert_eq!(builder.finish().mesh_faults().duplicate, expected);
    }
}
