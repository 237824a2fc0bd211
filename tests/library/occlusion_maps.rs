//! Occlusion maps: they darken what comes from all around, and nothing else.

use crate::sameness::{check, sized};
use glam::{DVec3, Vec3};
use octray::{
    accel::Bvh,
    render::render,
    scene::{
        Background, Camera, Environment, Image, Material, MaterialId, OcclusionMap, SceneBuilder,
        SurfaceTextures, Texture, Transform, TriangleMesh,
    },
};
use std::ops::ControlFlow;

const WHITE: Material = Material::Matte { color: [1.0; 3] };

/// The square from -1 to 1.
fn square() -> TriangleMesh {
    TriangleMesh {
        x: vec![-1.0, 1.0, 1.0, -1.0],
        y: vec![-1.0, -1.0, 1.0, 1.0],
        z: vec![0.0; 4],
        uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..TriangleMesh::default()
    }
}

/// A material with a map of these reds.
fn mapped(builder: &mut SceneBuilder, material: Material, reds: &[u8], strength: f32) -> MaterialId {
    let texels = reds.iter().map(|&red| [red, 99, 7, 255]).collect();
    let image = Image::of_numbers([reds.len() as u32, 1], texels).expect("an image");
    let texture = Texture {
        image: builder.add_image(image).expect("room"),
        ..Texture::default()
    };
    let textures = SurfaceTextures {
        occlusion_map: Some(OcclusionMap { texture, strength }),
        emission: [0.125; 3],
        ..SurfaceTextures::NONE
    };
    let material = builder.add_textured_material(material, textures);
    material.expect("a material")
}

/// Half of white ambient light, of a white environment, and of a lamp from above, each on its own.
#[test]
fn only_light_from_all_around_is_darkened() {
    let mut plain = [0.5; 3];
    for (strength, share) in [(0.0, 1.0), (1.0, 51.0 / 255.0), (0.5, 0.6)] {
        for (kind, share) in [share, share, 1.0].into_iter().enumerate() {
            let mut builder = SceneBuilder::new();
            builder.set_ambient(0.0).expect("a share");
            match kind {
                0 => builder.set_ambient(0.5),
                1 => builder.set_environment(Environment::Background(Background::constant([0.5; 3]))),
                _ => builder.add_light(Vec3::new(0.0, 0.0, 1e4), 0.5),
            }
            .expect("light");
            let white = mapped(&mut builder, WHITE, &[51], strength);
            builder.add_mesh(square(), white).expect("a mesh");
            let scene = builder.finish();
            let camera = Camera::look_at(DVec3::Z * 3.0, DVec3::ZERO, DVec3::Y, 1.0).expect("a camera");
            let frame = render(&scene, &Bvh::build(&scene), &camera, &sized(1, 1, 16), &|_| {
                ControlFlow::Continue(())
            });
            let found = frame.expect("it renders").film.pixels()[0][0];
            if strength == 0.0 {
                // The environment is sampled.
                assert!((found - 0.625).abs() < 0.05, "{kind}: {found}");
                plain[kind] = found - 0.125;
            }
            let expected = plain[kind] * share + 0.125;
            assert!(
                (found - expected).abs() < 1e-6,
                "{strength} {kind}: {found} {expected}"
            );
        }
    }
    let mut builder = SceneBuilder::new();
    let textures = SurfaceTextures {
        occlusion_map: Some(OcclusionMap {
            texture: Texture::default(),
            strength: 1.1,
        }),
        ..SurfaceTextures::NONE
    };
    assert!(builder.add_textured_material(WHITE, textures).is_err());
}

/// All materials, with and without maps, instances, and every kind of light.
#[test]
fn both_modes_draw_the_same() {
    for is_soft in [false, true] {
        let mut builder = SceneBuilder::new();
        builder.set_ambient(0.3).expect("a share");
        builder.set_ambient_specular(true);
        builder
            .add_light(Vec3::new(3.0, -4.0, 5.0), 0.6)
            .expect("a light");
        if is_soft {
            builder.set_ambient_reach(Some(2.0)).expect("a reach");
            let sky = Environment::Background(Background::constant([0.3, 0.2, 0.1]));
            builder.set_environment(sky).expect("an environment");
        }
        let materials = [WHITE, Material::CLASSIC[2], Material::CLASSIC[3], Material::GLASS];
        for (i, material) in materials.into_iter().enumerate() {
            // Without glass, no rays branch.
            if !is_soft && i == 3 {
                continue;
            }
            let at = |z: f64| Transform::IDENTITY.then_translate(DVec3::new(2.2 * i as f64 - 3.3, 0.0, z));
            let ids = [
                mapped(&mut builder, material, &[255, 0, 128], 1.0),
                builder.add_material(material).expect("a material"),
            ];
            for (k, id) in ids.into_iter().enumerate() {
                let prototype = builder.add_prototype(|builder| builder.add_mesh(square(), id));
                let prototype = prototype.expect("a prototype");
                let placed = at(-1.0 - k as f64);
                builder.add_instance(prototype, &placed).expect("an instance");
            }
            let mut mesh = square();
            at(0.0).apply(&mut mesh);
            builder.add_mesh(mesh, ids[0]).expect("a mesh");
        }
        let camera =
            Camera::look_at(DVec3::new(1.0, -9.0, 6.0), DVec3::ZERO, DVec3::Z, 60.0).expect("a camera");
        let scene = builder.finish();
        check("occlusion maps", &scene, &camera, &sized(121, 61, 4));
    }
}
