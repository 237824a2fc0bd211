//! Scale and position of a scene change its picture only by rounding.
//!
//! A *speckle* is a pixel that differs from the expected picture by more than 2/255 and, in some channel, lies that far
//! outside the range of the 5x5 pixels around it. An edge that rounding moved is not a speckle: it takes a neighbour's
//! colour.

use crate::{
    numbers::{SIDE, picture, picture_in, placed_view},
    shipped_scene,
};
use glam::Vec3;
use image::RgbImage;
use octray::{
    render::Mode,
    scene::{Light, LightShape, MaterialId, Scene, SceneBuilder, TriangleMesh, View},
};

const TOLERANCE: i16 = 2;

/// A copy of the scene, scaled and then moved.
fn placed(scene: &Scene, scale: f32, shift: Vec3) -> Scene {
    let place = |p: Vec3| p * scale + shift;
    let mut builder = SceneBuilder::new();
    builder.set_ambient(scene.ambient()).unwrap();
    builder.set_background(scene.background()).unwrap();
    let materials = scene.materials().iter();
    let ids = materials.map(|&material| builder.add_material(material).unwrap());
    let ids: Vec<MaterialId> = ids.collect();
    let vertices = scene.vertices();
    let all: Vec<Vec3> = (0..vertices.x.len() as u32)
        .map(|i| place(scene.origin() + vertices.position(i)))
        .collect();
    let column = |axis: usize| all.iter().map(|p| p[axis]).collect();
    let mesh = TriangleMesh {
        x: column(0),
        y: column(1),
        z: column(2),
        normals: vertices.normals.clone(),
        colors: vertices.colors.clone(),
        uvs: vertices.uvs.clone(),
        tangents: vertices.tangents.clone(),
        triangles: scene.triangles().corners.clone(),
    };
    let material_of = scene.triangles().material.iter();
    let materials = material_of.map(|id| ids[id.0 as usize]).collect();
    builder.add_mesh_with_materials(mesh, materials).unwrap();
    let spheres = scene.spheres();
    for (i, radius) in spheres.radius.iter().enumerate() {
        let material = ids[spheres.material[i].0 as usize];
        builder
            .add_sphere(
                place(scene.origin() + spheres.center(i)),
                radius * scale,
                material,
            )
            .unwrap();
    }
    for light in scene.lights() {
        builder.add(placed_light(light, scene, scale, place)).unwrap();
    }
    builder.finish()
}

fn placed_light(light: &Light, scene: &Scene, scale: f32, place: impl Fn(Vec3) -> Vec3) -> Light {
    let place = |p: Vec3| place(scene.origin() + p);
    let shape = match light.shape {
        LightShape::Point { position } => LightShape::Point {
            position: place(position),
        },
        LightShape::Sphere { center, radius } => LightShape::Sphere {
            center: place(center),
            radius: radius * scale,
        },
        LightShape::Rectangle { center, edges } => LightShape::Rectangle {
            center: place(center),
            edges: edges.map(|edge| edge * scale),
        },
        directional @ LightShape::Directional { .. } => directional,
    };
    Light {
        shape,
        falloff: light.falloff.map(|distance| distance * scale),
        ..*light
    }
}

/// The number of pixels that differ by more than the tolerance, and of speckles among them.
fn difference(expected: &RgbImage, found: &RgbImage) -> (usize, usize) {
    let (mut different, mut speckles) = (0, 0);
    for (x, y, pixel) in found.enumerate_pixels() {
        let there = expected.get_pixel(x, y);
        let off = |a: u8, b: u8| i16::from(a).abs_diff(i16::from(b)) as i16 > TOLERANCE;
        if !(0..3).any(|c| off(pixel[c], there[c])) {
            continue;
        }
        different += 1;
        let around = |at: u32| at.saturating_sub(2)..=(at + 2).min(SIDE - 1);
        let is_speckle = (0..3).any(|c| {
            let near = || around(y).flat_map(|y| around(x).map(move |x| (x, y)));
            let values = || near().map(|(x, y)| i16::from(expected.get_pixel(x, y)[c]));
            let (least, most) = (values().min().unwrap(), values().max().unwrap());
            !(least - TOLERANCE..=most + TOLERANCE).contains(&i16::from(pixel[c]))
        });
        speckles += usize::from(is_speckle);
    }
    (different, speckles)
}

/// Shipped scenes, each with a view: matte, highlights, mirrors, mirrors in mirrors.
fn shipped() -> Vec<(&'static str, Scene, View)> {
    [
        ("matte", 1),
        ("blinn_phong", 3),
        ("reflections", 1),
        ("hall_of_mirrors", 2),
    ]
    .into_iter()
    .map(|(name, view)| {
        (
            name,
            shipped_scene(name),
            View::classic(view).expect("views are 1 to 6"),
        )
    })
    .collect()
}

#[test]
fn scaling_by_a_power_of_two_changes_no_byte() {
    for (name, scene, view) in shipped() {
        for mode in [Mode::Packet, Mode::Scalar] {
            let picture = |scale| {
                let camera = placed_view(&view, scale, Vec3::ZERO);
                picture_in(&placed(&scene, scale, Vec3::ZERO), &camera, SIDE, mode, 5)
            };
            let expected = picture(1.0);
            for exponent in [-20, -13, -1, 1, 7, 17] {
                assert!(
                    picture(2.0_f32.powi(exponent)) == expected,
                    "{name}, {mode:?}: 2^{exponent}"
                );
            }
        }
    }
}

#[test]
fn scaling_changes_few_pixels() {
    let (mut failures, pixels) = (Vec::new(), (SIDE * SIDE) as usize);
    for (name, scene, view) in shipped() {
        let expected = picture(&scene, &placed_view(&view, 1.0, Vec3::ZERO));
        for scale in [1e-4, 3e-3, 0.1, 0.7, 3.0, 1e3, 1e5] {
            let camera = placed_view(&view, scale, Vec3::ZERO);
            let found = picture(&placed(&scene, scale, Vec3::ZERO), &camera);
            let (different, speckles) = difference(&expected, &found);
            let line = format!("{name}: scale {scale}: {different} of {pixels} differ, {speckles} speckles");
            println!("{line}");
            if different * 100 > pixels || speckles > 0 {
                failures.push(line);
            }
        }
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

/// Moving rounds a scene's coordinates, by a thousandth at a distance of 10,000. Moving it back rounds nothing more, so
/// hardly a pixel may differ from that picture. Against the original scene, details below a pixel may differ.
#[test]
fn moving_changes_few_pixels() {
    let (mut failures, pixels) = (Vec::new(), (SIDE * SIDE) as usize);
    for (name, scene, view) in shipped() {
        let camera = placed_view(&view, 1.0, Vec3::ZERO);
        let original = picture(&scene, &camera);
        for far in [0.3, 7.0, 100.0, 1e3, 1e4] {
            for direction in [Vec3::new(0.8, -0.55, 0.3), Vec3::new(-1.0, 0.0, 0.03), Vec3::ONE] {
                let shift = direction * far;
                let moved = placed(&scene, 1.0, shift);
                let back = picture(&placed(&moved, 1.0, -shift), &camera);
                let found = picture(&moved, &placed_view(&view, 1.0, shift));
                for (what, expected, max_different, max_speckles) in [
                    ("moved back", &back, 2, 0),
                    ("original", &original, pixels / 400, pixels / 5000),
                ] {
                    let (different, speckles) = difference(expected, &found);
                    let line = format!(
                        "{name}: moved by {shift}, against the scene {what}: {different} of {pixels} differ, {speckles} speckles"
                    );
                    println!("{line}");
                    if different > max_different || speckles > max_speckles {
                        failures.push(line);
                    }
                }
            }
        }
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}
