//! Every instruction set of this CPU computes the same: pictures in both modes, and trees.
//!
//! `OCTRAY_LONG=1` makes larger pictures.

use crate::long::rounds;
use glam::{DVec3, Vec3};
use octray::{
    Level,
    accel::{BuildQuality, Bvh, Layout},
    generate::{Kind, Options, generate},
    render::{Edges, Film, Mode, Pattern, Pixel, Renderer, Settings},
    scene::{Camera, MaterialId, Scene, SceneBuilder, SphereCloud, TriangleMesh},
};
use std::ops::ControlFlow;

/// All classic materials on spheres and triangles, with and without vertex normals, under two lights. If `colored`, half
/// of the spheres and a mesh of every material have colours, a third light is a sphere, ambient light is occluded, and
/// shadows are smooth.
fn all_materials(colored: bool) -> Scene {
    let mut random = fastrand::Rng::with_seed(21);
    let mut unit = move || random.f32() * 2.0 - 1.0;
    let mut vector = move || Vec3::new(unit(), unit(), unit());
    let mut builder = SceneBuilder::new();
    builder.add_light(Vec3::new(3.0, -4.0, 6.0), 0.7).unwrap();
    builder.add_light(Vec3::new(-5.0, 1.0, 4.0), 0.4).unwrap();
    if colored {
        let above = Vec3::new(0.0, 0.0, 5.0);
        builder
            .add_sphere_light(above, 1.5, 0.5, [1.0, 0.8, 0.6])
            .unwrap();
        builder.set_ambient_reach(Some(0.7)).unwrap();
        builder.set_smooth_shadows(true);
        builder.set_ambient_specular(true);
    }
    for i in 0..200 {
        let material = builder.classic_material(i % 4).unwrap();
        let at = vector() * 2.0;
        builder
            .add_sphere(at, 0.1 + 0.1 * vector().x.abs(), material)
            .unwrap();
        let corners = [(); 3].map(|()| at + vector() * 0.5);
        builder.add_triangle(corners, material).unwrap();
    }
    let positions: Vec<Vec3> = (0..300).map(|_| vector() * 2.0).collect();
    let mesh = TriangleMesh {
        x: positions.iter().map(|p| p.x).collect(),
        y: positions.iter().map(|p| p.y).collect(),
        z: positions.iter().map(|p| p.z).collect(),
        normals: positions.iter().map(|_| vector().normalize()).collect(),
        colors: Vec::new(),
        uvs: Vec::new(),
        tangents: Vec::new(),
        triangles: (0..100).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    };
    let mirror = builder.classic_material(3).unwrap();
    builder.add_mesh(mesh, mirror).unwrap();
    if colored {
        let mut color = || vector().abs().to_array();
        let materials: Vec<MaterialId> = (0..100).map(|i| MaterialId(i % 4)).collect();
        let mesh = TriangleMesh {
            x: positions.iter().map(|p| p.y).collect(),
            y: positions.iter().map(|p| p.z).collect(),
            z: positions.iter().map(|p| p.x).collect(),
            normals: Vec::new(),
            colors: positions.iter().map(|_| color()).collect(),
            uvs: Vec::new(),
            tangents: Vec::new(),
            triangles: (0..100).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        };
        builder.add_mesh_with_materials(mesh, materials).unwrap();
        for i in 0..4 {
            let material = builder.classic_material(i).unwrap();
            let centers = positions.iter().skip(i as usize).step_by(6);
            let spheres = SphereCloud {
                x: centers.clone().map(|p| p.z).collect(),
                y: centers.clone().map(|p| p.x).collect(),
                z: centers.clone().map(|p| p.y).collect(),
                radius: centers.clone().map(|p| 0.05 + 0.05 * p.x.abs()).collect(),
                colors: centers.map(|_| color()).collect(),
            };
            builder.add_spheres(spheres, material).unwrap();
        }
    }
    builder.finish()
}

fn check<P: Pixel + PartialEq>(scene: &Scene, bvh: &Bvh, camera: &Camera, settings: Settings) {
    let film = |level, mode| {
        let mut film = Film::<P>::black(1, 1);
        let settings = Settings {
            level,
            mode,
            ..settings
        };
        let go_on = &|_| ControlFlow::Continue(());
        Renderer::new(scene, bvh)
            .render(camera, &settings, &mut film, go_on)
            .unwrap();
        film
    };
    let expected = film(Level::PORTABLE, Mode::Packet);
    let all = Level::all().flat_map(|level| [(level, Mode::Packet), (level, Mode::Scalar)]);
    // The first one is `expected`.
    for (level, mode) in all.skip(1) {
        assert!(film(level, mode) == expected, "{level} {mode:?} {settings:?}");
    }
}

#[test]
fn every_level_makes_the_same_pictures_in_both_modes() {
    let plain = all_materials(false);
    let colored = all_materials(true);
    assert!(!plain.has_colors() && colored.has_colors());
    for scene in [plain, colored] {
        check_pictures(&scene);
    }
    let textured = crate::shipped_scene("garden");
    assert!(textured.has_textures() && textured.has_cut_outs());
    check_pictures(&textured);
    check_pictures(&crate::shipped_scene("glass"));
}

fn check_pictures(scene: &Scene) {
    let bvh = Bvh::build(scene);
    let camera = Camera::look_at(DVec3::new(4.0, 3.0, 2.0), DVec3::ZERO, DVec3::Z, 50.0).unwrap();
    let [width, height] = rounds([33, 27], [91, 67]);
    let settings = Settings {
        width,
        height,
        max_depth: 5,
        ..Settings::default()
    };
    check::<[f32; 3]>(scene, &bvh, &camera, settings);
    check::<[u8; 3]>(scene, &bvh, &camera, settings);
    check::<[f32; 4]>(
        scene,
        &bvh,
        &camera,
        Settings {
            samples: 4,
            ..settings
        },
    );
    let adaptive = Settings {
        samples: 9,
        adaptive: true,
        pattern: Pattern::Sobol,
        ..settings
    };
    check::<[f32; 3]>(scene, &bvh, &camera, adaptive);
    let edges = Some(Edges::default());
    check::<[f32; 4]>(scene, &bvh, &camera, Settings { edges, ..adaptive });
}

#[test]
fn every_level_builds_the_same_trees() {
    let generated = |kind, count| {
        let options = Options {
            seed: 2,
            count: Some(count),
        };
        generate(kind, options).unwrap().into_scene().unwrap()
    };
    let scenes = [
        all_materials(true),
        generated(Kind::Flake, 3000),
        generated(Kind::Blobs, rounds(40_000, 80_000)),
    ];
    for scene in &scenes {
        for quality in [BuildQuality::Fast, BuildQuality::Best] {
            for layout in [Layout::Whole, Layout::Indexed] {
                // Whatever runs beside this finds the same at any level.
                let tree = |level: Level| {
                    level.hold();
                    let bvh = Bvh::build_as(scene, quality, layout);
                    let blocks = format!("{:?} {:?}", bvh.triangle_blocks(), bvh.sphere_blocks());
                    (format!("{:?}", bvh.nodes()), blocks)
                };
                let expected = tree(Level::PORTABLE);
                for level in Level::all().skip(1) {
                    assert!(tree(level) == expected, "{level} {quality:?} {layout:?}");
                }
            }
        }
    }
}
