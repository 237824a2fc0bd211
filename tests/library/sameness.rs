//! One scene, one picture: packets or scalar code, any BVH, one thread or two give the same linear colours, bit for bit.
//!
//! `OCTRAY_LONG=1` makes larger pictures, each in both modes on one thread and on two with every BVH.

use crate::{
    blending::see_through,
    long::{is_long, rounds},
    shipped_scene,
};
use glam::{DVec3, Vec3};
use octray::{
    accel::{BuildQuality, Bvh, Layout},
    generate::{Kind, Options, generate},
    render::{Film, Mode, Pattern, Renderer, Settings, render},
    scene::{
        Camera, Environment, EnvironmentPicture, Image, Light, LightShape, Material, Opacity, Scene,
        SceneBuilder, SphereCloud, Spot, SurfaceTextures, Texture, Transform, TriangleMesh,
    },
};
use std::ops::ControlFlow;

pub const SHIPPED: [&str; 11] = [
    "silhouette",
    "matte",
    "blinn_phong",
    "reflections",
    "hall_of_mirrors",
    "evening",
    "garden",
    "glass",
    "sky",
    "forest",
    "gears",
];

/// Width, height and samples per pixel: no multiple of a packet or tile, a single pixel, very wide, several samples.
pub fn sizes() -> [(u32, u32, u32); 4] {
    let [width, height] = rounds([149, 67], [333, 217]);
    [(width, height, 1), (1, 1, 1), (8191, 3, 1), (64, 48, 4)]
}

/// The first pixel whose bits differ.
fn first_difference(a: &Film, b: &Film) -> Option<String> {
    let bits = |pixel: &[f32; 3]| pixel.map(f32::to_bits);
    let (i, (pa, pb)) = a
        .pixels()
        .iter()
        .zip(b.pixels())
        .enumerate()
        .find(|(_, (pa, pb))| bits(pa) != bits(pb))?;
    let (x, y) = (i % a.width() as usize, i / a.width() as usize);
    Some(format!("pixel ({x}, {y}): {pa:?} and {pb:?}"))
}

/// BVHs, modes and threads that must make the same picture as packets on one thread with the default BVH. The first three
/// have each of them.
fn others() -> Vec<(BuildQuality, Layout, Mode, usize)> {
    let mut others = vec![
        (BuildQuality::Fast, Layout::Whole, Mode::Packet, 2),
        (BuildQuality::Best, Layout::Indexed, Mode::Packet, 1),
        (BuildQuality::Ploc, Layout::Whole, Mode::Scalar, 2),
    ];
    if is_long() {
        for (quality, layout) in [
            (BuildQuality::Best, Layout::Whole),
            (BuildQuality::Fast, Layout::Whole),
            (BuildQuality::Best, Layout::Indexed),
            (BuildQuality::Ploc, Layout::Whole),
        ] {
            for mode in [Mode::Packet, Mode::Scalar] {
                others.extend([1, 2].map(|threads| (quality, layout, mode, threads)));
            }
        }
    }
    others
}

/// A scene and its BVHs.
pub struct Sameness<'a> {
    name: &'a str,
    scene: &'a Scene,
    bvh: Bvh,
    others: Vec<Other>,
}

/// What makes the same picture: a BVH, a mode and threads.
struct Other {
    bvh: Bvh,
    mode: Mode,
    threads: usize,
    what: String,
}

impl<'a> Sameness<'a> {
    pub fn of(name: &'a str, scene: &'a Scene) -> Self {
        let others = others()
            .into_iter()
            .map(|(quality, layout, mode, threads)| Other {
                bvh: Bvh::build_as(scene, quality, layout),
                mode,
                threads,
                what: format!("{mode:?} on {threads} with {quality:?}, {layout:?}"),
            });
        Self {
            name,
            scene,
            bvh: Bvh::build(scene),
            others: others.collect(),
        }
    }

    pub fn check(&self, camera: &Camera, settings: &Settings) {
        let name = self.name;
        let film = |bvh: &Bvh, mode, threads| {
            let settings = Settings {
                mode,
                threads: Some(threads),
                ..*settings
            };
            let frame = render(self.scene, bvh, camera, &settings, &|_| ControlFlow::Continue(()));
            frame.unwrap_or_else(|error| panic!("{name}: {error}")).film
        };
        let [width, height] = [settings.width, settings.height];
        let first = film(&self.bvh, Mode::Packet, 1);
        assert_eq!(first.pixels().len(), width as usize * height as usize, "{name}");
        for other in &self.others {
            let found = film(&other.bvh, other.mode, other.threads);
            if let Some(difference) = first_difference(&first, &found) {
                panic!(
                    "{name}, {width}x{height}: packets on 1 thread with the default BVH, and {} differ at {difference}",
                    other.what
                );
            }
        }
    }
}

pub fn check(name: &str, scene: &Scene, camera: &Camera, settings: &Settings) {
    Sameness::of(name, scene).check(camera, settings);
}

pub fn sized(width: u32, height: u32, samples: u32) -> Settings {
    Settings {
        width,
        height,
        samples,
        ..Settings::default()
    }
}

#[test]
fn shipped_scenes() {
    for name in SHIPPED {
        let scene = shipped_scene(name);
        let bvh = Bvh::build(&scene);
        let camera = Camera::classic_view(1).expect("views are 1 to 6");
        let frame = render(&scene, &bvh, &camera, &sized(32, 32, 1), &|_| {
            ControlFlow::Continue(())
        });
        let film = frame.expect("it renders").film;
        assert!(
            film.pixels().iter().any(|pixel| *pixel != film.pixels()[0]),
            "{name}: the picture has one colour"
        );
        let sameness = Sameness::of(name, &scene);
        for (i, (width, height, samples)) in sizes().into_iter().enumerate() {
            let camera = Camera::classic_view(i as u32 + 1).expect("views are 1 to 6");
            sameness.check(&camera, &sized(width, height, samples));
        }
    }
}

#[test]
fn without_shadows_and_with_deep_reflections() {
    let scene = shipped_scene("hall_of_mirrors");
    let camera = Camera::classic_view(2).expect("views are 1 to 6");
    for (shadows, max_depth) in [(false, 1), (false, 3), (true, 1), (true, 20)] {
        let settings = Settings {
            shadows,
            max_depth,
            ..sized(97, 61, 1)
        };
        check("hall_of_mirrors", &scene, &camera, &settings);
    }
}

#[test]
fn adaptive_pictures() {
    let mut scenes = Vec::from(SHIPPED.map(|name| (name, shipped_scene(name))));
    scenes.push(("soft", shipped_scene("soft")));
    scenes.push(("colours", colored_scene()));
    for (i, (name, scene)) in scenes.iter().enumerate() {
        let camera = Camera::classic_view(i as u32 % 6 + 1).expect("views are 1 to 6");
        let [width, height] = rounds([101, 43], [149, 67]);
        let sameness = Sameness::of(name, scene);
        for (width, height, samples) in [(width, height, 16), (1, 1, 5), (1023, 3, 4)] {
            let settings = Settings {
                adaptive: true,
                pattern: Pattern::Sobol,
                ..sized(width, height, samples)
            };
            sameness.check(&camera, &settings);
        }
    }
}

/// A floor and a wall with a colour at each corner, one of them a mirror, and coloured spheres of two materials, beside
/// triangles and spheres without colours.
fn colored_scene() -> Scene {
    let mut random = fastrand::Rng::with_seed(35);
    let mut color = move || [(); 3].map(|()| random.f32());
    let mut builder = SceneBuilder::new();
    builder.add_light(Vec3::new(3.0, -4.0, 6.0), 0.7).unwrap();
    let matte = builder
        .add_material(Material::Matte {
            color: [0.9, 0.8, 0.7],
        })
        .unwrap();
    let mirror = builder.classic_material(3).unwrap();
    let shiny = builder.classic_material(2).unwrap();
    for (upright, material) in [(false, matte), (true, mirror)] {
        let at = |i: u32| ((i % 9) as f32 * 0.5 - 2.0, (i / 9) as f32 * 0.5 - 2.0);
        let mesh = TriangleMesh {
            x: (0..81).map(|i| at(i).0).collect(),
            y: (0..81).map(|i| if upright { 2.0 } else { at(i).1 }).collect(),
            z: (0..81)
                .map(|i| if upright { at(i).1 + 2.0 } else { 0.0 })
                .collect(),
            normals: Vec::new(),
            colors: (0..81).map(|_| color()).collect(),
            uvs: Vec::new(),
            tangents: Vec::new(),
            triangles: (0..71)
                .filter(|i| i % 9 < 8)
                .flat_map(|i| [[i, i + 1, i + 10], [i, i + 10, i + 9]])
                .collect(),
        };
        builder.add_mesh(mesh, material).unwrap();
    }
    for material in [shiny, mirror, matte] {
        let at = |i: u32| (i % 5) as f32 * 0.4 - 1.0 + 0.1 * material.0 as f32;
        builder
            .add_spheres(
                SphereCloud {
                    x: (0..20).map(at).collect(),
                    y: (0..20).map(|i| (i / 5) as f32 * 0.5 - 1.0).collect(),
                    z: (0..20).map(|i| 0.2 + 0.05 * i as f32).collect(),
                    radius: vec![0.12; 20],
                    colors: if material == matte {
                        Vec::new()
                    } else {
                        (0..20).map(|_| color()).collect()
                    },
                },
                material,
            )
            .unwrap();
    }
    let corners = [
        Vec3::new(-1.0, -1.0, 0.5),
        Vec3::new(1.0, -1.0, 0.5),
        Vec3::new(0.0, 0.0, 2.0),
    ];
    builder.add_triangle(corners, shiny).unwrap();
    builder.finish()
}

#[test]
fn colored_scenes() {
    let scene = colored_scene();
    for (i, (width, height, samples)) in sizes().into_iter().enumerate() {
        let camera = Camera::classic_view(i as u32 + 1).expect("views are 1 to 6");
        check("colours", &scene, &camera, &sized(width, height, samples));
    }
    // The albedo has the colours, too, the same in both modes.
    let bvh = Bvh::build(&scene);
    let camera = Camera::classic_view(1).expect("views are 1 to 6");
    let albedo = |mode| {
        let settings = Settings {
            mode,
            ..sized(64, 48, 1)
        };
        let aovs =
            Renderer::new(&scene, &bvh).aovs(&camera, &settings, false, &|_| ControlFlow::Continue(()));
        aovs.expect("AOVs").pixels
    };
    let pixels = albedo(Mode::Packet);
    assert_eq!(pixels, albedo(Mode::Scalar));
    let mut different: Vec<[u32; 3]> = pixels
        .iter()
        .map(|pixel| pixel.albedo.map(f32::to_bits))
        .collect();
    different.sort_unstable();
    different.dedup();
    assert!(different.len() > 200, "{}", different.len());
}

/// Lights of all kinds, one of them where a surface is, in a scene with mirrors.
#[test]
fn lights_of_all_kinds() {
    let mut builder = SceneBuilder::new();
    let point = LightShape::Point {
        position: Vec3::new(1.0, -2.0, 2.5),
    };
    let rectangle = LightShape::Rectangle {
        center: Vec3::new(-1.0, -1.0, 3.0),
        edges: [Vec3::new(1.0, 0.0, 0.3), Vec3::new(0.0, -1.0, 0.2)],
    };
    let sphere = LightShape::Sphere {
        center: Vec3::new(0.2, 0.1, 0.6),
        radius: 0.3,
    };
    let sun = |degrees| LightShape::directional(DVec3::new(1.0, -2.0, 3.0), degrees).expect("a direction");
    let spot = Spot::new(DVec3::new(-1.0, 2.0, -2.5), 10.0, 25.0).expect("a spot");
    for (shape, falloff, spot) in [
        (point, Some(1.5), None),
        (point, None, Some(spot)),
        (rectangle, Some(2.0), None),
        (
            rectangle,
            None,
            Some(Spot::new(DVec3::NEG_Z, 5.0, 60.0).expect("a spot")),
        ),
        (sphere, Some(0.3), None),
        (sun(0.0), None, None),
        (sun(9.0), None, None),
        (LightShape::Point { position: Vec3::ZERO }, Some(0.7), None),
    ] {
        let light = Light {
            intensity: 0.3,
            color: [1.0, 0.8, 0.6],
            falloff,
            spot,
            ..Light::new(shape)
        };
        builder.add(light).expect("a light");
    }
    let materials = [1, 2, 3].map(|number| builder.classic_material(number).expect("a material"));
    let floor = [
        Vec3::new(-3.0, -3.0, 0.0),
        Vec3::new(3.0, -3.0, 0.0),
        Vec3::new(0.0, 3.0, 0.0),
    ];
    builder.add_triangle(floor, materials[1]).expect("a floor");
    for i in 0..12_u8 {
        let turn = f32::from(i);
        let at = Vec3::new((turn * 0.9).cos(), (turn * 1.7).sin(), 0.2 + turn * 0.08);
        builder
            .add_sphere(at, 0.25, materials[usize::from(i) % 3])
            .expect("a sphere");
    }
    let mut random = fastrand::Rng::with_seed(3);
    let mut texels: Vec<_> = (0..200)
        .map(|_| [(); 3].map(|()| random.f32().powi(6) * 4.0))
        .collect();
    // Suns have samples of their own.
    texels[47] = [70.0, 60.0, 50.0];
    texels[91] = [50.0, 60.0, 70.0];
    let picture = EnvironmentPicture::new([20, 10], texels, 40.0, 0.5).expect("a picture");
    builder
        .set_environment(Environment::Picture(picture))
        .expect("an environment");
    let scene = builder.finish();
    for (i, (width, height, samples)) in sizes().into_iter().enumerate() {
        let camera = Camera::classic_view(i as u32 + 1).expect("views are 1 to 6");
        check("lights", &scene, &camera, &sized(width, height, samples));
    }
}

/// Nested and intersecting glass of all kinds around mirrors and other materials, some half-transparent, in soft light:
/// packets of branches are full of rays of one pixel.
pub fn glass_scene() -> Scene {
    let mut random = fastrand::Rng::with_seed(53);
    let mut builder = SceneBuilder::new();
    builder
        .add_sphere_light(Vec3::new(3.0, -4.0, 6.0), 0.5, 0.7, [1.0, 0.9, 0.8])
        .unwrap();
    builder.add_light(Vec3::new(-3.0, 2.0, 5.0), 0.4).unwrap();
    builder.set_ambient_reach(Some(1.0)).unwrap();
    let mut materials: Vec<_> = (1..4)
        .map(|number| builder.classic_material(number).unwrap())
        .collect();
    for index in [0.7, 1.0, 1.3, 1.5, 2.4] {
        let glass = Material::Glass {
            index,
            tint: [random.f32(), if index == 1.5 { 0.0 } else { 1.0 }, 0.9],
            depth: 0.5,
        };
        materials.push(builder.add_material(glass).unwrap());
    }
    for (number, opacity) in [(0, 0.6), (1, 0.3), (2, 0.8), (3, 0.5), (1, 0.001)] {
        materials.push(see_through(&mut builder, Material::CLASSIC[number], opacity));
    }
    let tinted = SurfaceTextures {
        opacity: Opacity::new(0.001, None).map(|all| Opacity {
            is_tinted: true,
            ..all
        }),
        ..SurfaceTextures::NONE
    };
    let colored = Material::Matte {
        color: [0.9, 0.3, 0.6],
    };
    materials.push(builder.add_textured_material(colored, tinted).unwrap());
    for i in 0..60 {
        let at = Vec3::new(random.f32(), random.f32(), random.f32()) * 2.4 - 1.2;
        let material = materials[i % materials.len()];
        builder
            .add_sphere(at, 0.1 + 0.4 * random.f32(), material)
            .unwrap();
    }
    for i in 0..40 {
        let mut corner = || Vec3::new(random.f32(), random.f32(), random.f32()) * 3.0 - 1.5;
        let corners = [corner(), corner(), corner()];
        builder
            .add_triangle(corners, materials[i % materials.len()])
            .unwrap();
    }
    // A square whose opacity changes from texel to texel, placed twice.
    let texels = (0..64).map(|_| [255, 255, 255, random.u8(..)]).collect();
    let map = Texture {
        image: builder.add_image(Image::new([8, 8], texels).unwrap()).unwrap(),
        ..Texture::default()
    };
    let textures = SurfaceTextures {
        opacity: Opacity::new(0.9, Some(map)),
        ..SurfaceTextures::NONE
    };
    let faded = builder
        .add_textured_material(Material::CLASSIC[2], textures)
        .unwrap();
    let square = TriangleMesh {
        x: vec![-1.0, 1.0, 1.0, -1.0],
        y: vec![-1.0, -1.0, 1.0, 1.0],
        z: vec![-0.2, 0.0, 0.5, 0.4],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..TriangleMesh::default()
    };
    let prototype = builder.add_prototype(|builder| builder.add_mesh(square, faded));
    let elsewhere = Transform::IDENTITY.then_rotate(DVec3::Y, 70.0);
    for transform in [Transform::IDENTITY, elsewhere] {
        let placed = builder.add_instance(*prototype.as_ref().unwrap(), &transform);
        placed.unwrap();
    }
    builder
        .add_plane(Vec3::Z * -0.4, Vec3::new(0.1, 0.0, 1.0), materials[9])
        .unwrap();
    builder.finish()
}

#[test]
fn scenes_of_glass() {
    let scene = glass_scene();
    for (i, (width, height, samples)) in [(97, 61, 1), (16, 9, 4)].into_iter().enumerate() {
        for max_depth in [1, 2, 7] {
            let camera = Camera::classic_view(i as u32 + 1).expect("views are 1 to 6");
            let settings = Settings {
                max_depth,
                ..sized(width, height, samples)
            };
            check("glass", &scene, &camera, &settings);
        }
    }
    // From within.
    let eye = glam::DVec3::new(0.1, 0.0, 0.2);
    let camera = Camera::look_at(eye, glam::DVec3::ONE, glam::DVec3::Z, 80.0).expect("a view");
    check("in glass", &scene, &camera, &sized(64, 48, 1));
}

#[test]
fn generated_scenes() {
    for kind in Kind::ALL {
        let count = Some(kind.min_count().max(20_000));
        let generated = generate(kind, Options { seed: 5, count }).expect("a count within its limits");
        let camera = generated.view.camera().expect("a view");
        let scene = generated.into_scene().expect("a scene");
        check(kind.name(), &scene, &camera, &sized(201, 101, 1));
    }
}
