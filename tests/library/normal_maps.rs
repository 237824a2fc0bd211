//! Normal maps: a dome in an image is lit as a dome, wherever its square is.

use crate::sameness::{check, sized};
use glam::{DVec3, Vec3};
use octray::{
    accel::Bvh,
    format::mesh,
    render::render,
    scene::{
        Camera, Image, Material, MaterialId, NormalMap, Scene, SceneBuilder, SurfaceTextures, Texture,
        Transform, TriangleMesh, Wrap,
    },
};
use std::{io, ops::ControlFlow, path::Path};

const SIDE: u32 = 64;

/// The normal of the dome above a point of the square from -1 to 1.
fn dome(x: f64, y: f64) -> DVec3 {
    let rest = 1.0 - x * x - y * y;
    if rest < 0.1 {
        return DVec3::Z;
    }
    DVec3::new(x, y, rest.sqrt())
}

/// The point at the middle of a texel.
fn middle(column: u32, row: u32) -> (f64, f64) {
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE) * 2.0 - 1.0;
    (at(column), -at(row))
}

/// Tangents of the square: turned by some radians, and w.
type Tangents = Option<(f64, f32)>;

/// The dome, by these tangents.
fn texels(tangents: Tangents) -> Vec<[u8; 4]> {
    let (angle, sign) = tangents.unwrap_or((0.0, 1.0));
    let right = DVec3::new(angle.cos(), angle.sin(), 0.0);
    let top = DVec3::Z.cross(right) * f64::from(sign);
    let texel = |i: u32| {
        let (x, y) = middle(i % SIDE, i / SIDE);
        let normal = dome(x, y);
        let [r, g, b] =
            [normal.dot(right), normal.dot(top), normal.z].map(|n| ((n + 1.0) * 127.5 + 0.5) as u8);
        [r, g, b, 255]
    };
    (0..SIDE * SIDE).map(texel).collect()
}

/// The square from -1 to 1, the image's upper edge at y = 1, its triangles with different corners first.
fn square(tangents: Tangents) -> TriangleMesh {
    let tangent = |(angle, sign): (f64, f32)| [angle.cos() as f32, angle.sin() as f32, 0.0, sign];
    TriangleMesh {
        x: vec![-1.0, 1.0, 1.0, -1.0],
        y: vec![-1.0, -1.0, 1.0, 1.0],
        z: vec![0.0; 4],
        uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
        tangents: tangents.map_or(Vec::new(), |of| vec![tangent(of); 4]),
        triangles: vec![[0, 1, 2], [3, 0, 2]],
        ..TriangleMesh::default()
    }
}

fn mapped(builder: &mut SceneBuilder, material: Material, scale: f32, tangents: Tangents) -> MaterialId {
    let image = Image::of_numbers([SIDE; 2], texels(tangents)).expect("an image");
    let image = builder.add_image(image).expect("room");
    let texture = Texture {
        image,
        wrap: [Wrap::Clamp; 2],
        nearest: false,
    };
    let textures = SurfaceTextures {
        normal_map: Some(NormalMap { texture, scale }),
        ..SurfaceTextures::NONE
    };
    builder
        .add_textured_material(material, textures)
        .expect("a material")
}

const WHITE: Material = Material::Matte { color: [1.0; 3] };

/// The transforms, all without stretching, so that they take normals to normals.
fn transforms() -> [Transform; 3] {
    let turned = Transform::IDENTITY.then_rotate(DVec3::new(1.0, -2.0, 0.5), 40.0);
    let mirrored = turned.then_scale(DVec3::new(-1.0, 1.0, 1.0));
    [
        Transform::IDENTITY,
        turned.then_translate(DVec3::new(0.3, 0.2, -0.4)),
        mirrored.then_rotate(DVec3::Y, 70.0),
    ]
}

#[test]
fn a_dome_is_lit_as_a_dome() {
    let tangents = [None, Some((2.0, 1.0)), Some((-0.7, -1.0))];
    for (transform, tangents) in tangents
        .iter()
        .flat_map(|of| transforms().map(|transform| (transform, *of)))
    {
        let point = |p: DVec3| transform.point(p.as_vec3()).as_dvec3();
        for (is_instance, side) in [(false, 1.0), (true, 1.0), (false, -1.0), (true, -1.0)] {
            let to_light = DVec3::new(0.6, 0.3, 0.7 * side).normalize();
            let mut builder = SceneBuilder::new();
            builder.set_ambient(0.0).expect("a share");
            let light = point(to_light * 1e4).as_vec3();
            builder.add_light(light, 1.0).expect("a light");
            let white = mapped(&mut builder, WHITE, 1.0, tangents);
            let mut mesh = square(tangents);
            if is_instance {
                let prototype = builder.add_prototype(|builder| builder.add_mesh(mesh, white));
                let prototype = prototype.expect("a prototype");
                builder.add_instance(prototype, &transform).expect("an instance");
            } else {
                transform.apply(&mut mesh);
                builder.add_mesh(mesh, white).expect("a mesh");
            }
            let scene = builder.finish();
            for (column, row) in [(32, 20), (20, 32), (44, 40), (12, 12), (40, 52), (50, 20)] {
                let (x, y) = middle(column, row);
                let from = point(DVec3::new(x, y, 2.0 * side));
                let to = point(DVec3::new(x, y, 0.0));
                // From behind a dome is a dent.
                let expected = (dome(x, y) * side).dot(to_light).max(0.0);
                let found = f64::from(color(&scene, from, to));
                assert!(
                    (found - expected).abs() < 0.02,
                    "{transform:?} {tangents:?} {is_instance} {side}, {column} {row}: {expected} {found}"
                );
            }
        }
    }
}

/// The red of a picture of one pixel.
fn color(scene: &Scene, from: DVec3, to: DVec3) -> f32 {
    let up = if (to - from).cross(DVec3::Z).length() > 0.1 {
        DVec3::Z
    } else {
        DVec3::Y
    };
    let camera = Camera::look_at(from, to, up, 0.01).expect("a camera");
    let frame = render(scene, &Bvh::build(scene), &camera, &sized(1, 1, 1), &|_| {
        ControlFlow::Continue(())
    });
    frame.expect("it renders").film.pixels()[0][0]
}

/// The scale flattens it, and mipmaps are means of the bytes, which the curve of colours does not change.
#[test]
fn scale_and_mipmaps() {
    let mut builder = SceneBuilder::new();
    builder.set_ambient(0.0).expect("a share");
    builder.add_light(Vec3::new(0.0, 0.0, 1e4), 1.0).expect("a light");
    let flat = mapped(&mut builder, WHITE, 0.0, None);
    builder.add_mesh(square(None), flat).expect("a mesh");
    let scene = builder.finish();
    let (from, to) = (DVec3::new(0.5, 0.2, 2.0), DVec3::new(0.5, 0.2, 0.0));
    assert!((color(&scene, from, to) - 1.0).abs() < 1e-6);

    let mut image = Image::of_numbers([2, 1], vec![[0, 255, 10, 255], [255, 0, 21, 0]]).expect("an image");
    assert!(image.has_numbers());
    let before = format!("{image:?}");
    image.set_curve(octray::scene::Curve::Srgb);
    assert_eq!(format!("{image:?}"), before);
    assert!(before.contains("[[128, 128, 16, 128]]"), "{before}");
    let error = SceneBuilder::new().add_textured_material(
        WHITE,
        SurfaceTextures {
            normal_map: Some(NormalMap {
                texture: Texture::default(),
                scale: f32::NAN,
            }),
            ..SurfaceTextures::NONE
        },
    );
    assert!(error.is_err());
}

/// A triangle with other tangents at its corners shows those of its texture coordinates, and the mean of three that agree.
#[test]
fn tangents_that_do_not_agree() {
    let red = |change: &dyn Fn(&mut TriangleMesh)| {
        let mut builder = SceneBuilder::new();
        builder.set_ambient(0.0).expect("a share");
        builder.add_light(Vec3::new(6e3, 3e3, 7e3), 1.0).expect("a light");
        let white = mapped(&mut builder, WHITE, 1.0, None);
        let mut mesh = square(Some((0.0, 1.0)));
        change(&mut mesh);
        builder.add_mesh(mesh, white).map(|()| {
            let (from, to) = (DVec3::new(0.5, -0.3, 2.0), DVec3::new(0.5, -0.3, 0.0));
            color(&builder.finish(), from, to)
        })
    };
    let own = red(&|mesh| mesh.tangents.clear());
    let turned = red(&|mesh| mesh.tangents.fill([0.0, 5.0, 0.0, 0.5]));
    assert_ne!(own, turned);
    for wrong in [
        [0.0; 4],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [0.0, 1.0, 0.0, -1.0],
    ] {
        let found = red(&|mesh| {
            mesh.tangents.fill([0.0, 1.0, 0.0, 1.0]);
            mesh.tangents[2] = wrong;
        });
        assert_eq!(found, own, "{wrong:?}");
    }
    // None is along the surface.
    assert_eq!(red(&|mesh| mesh.tangents.fill([0.0, 0.0, 1.0, 1.0])), own);
    assert!(red(&|mesh| mesh.tangents[1][3] = f32::NAN).is_err());
    assert!(red(&|mesh| mesh.tangents.truncate(3)).is_err());
}

/// Packets and the scalar reference have the same bytes: all materials, instances, bumpy ones too, and mirrors.
#[test]
fn both_modes_draw_the_same() {
    let mut builder = SceneBuilder::new();
    builder.set_ambient(0.2).expect("a share");
    builder
        .add_light(Vec3::new(3.0, -4.0, 5.0), 0.6)
        .expect("a light");
    let materials = [
        WHITE,
        Material::CLASSIC[2],
        Material::CLASSIC[3],
        Material::CLASSIC[0],
        Material::GLASS,
    ];
    for (i, material) in materials.into_iter().enumerate() {
        let tangents = (i > 1).then_some((i as f64, 1.0));
        let id = mapped(&mut builder, material, 1.0 + i as f32, tangents);
        let prototype = builder.add_prototype(|builder| builder.add_mesh(square(tangents), id));
        let prototype = prototype.expect("a prototype");
        for (k, placed) in transforms().into_iter().enumerate() {
            let at = DVec3::new(2.2 * i as f64 - 4.4, 2.2 * k as f64 - 2.2, 0.0);
            let placed = placed.then_translate(at);
            builder.add_instance(prototype, &placed).expect("an instance");
        }
        let mut mesh = square(tangents);
        let lower = Transform::IDENTITY.then_translate(DVec3::new(2.2 * i as f64 - 4.4, 0.0, -2.0));
        lower.apply(&mut mesh);
        builder.add_mesh(mesh, id).expect("a mesh");
    }
    let camera = Camera::look_at(DVec3::new(1.0, -9.0, 6.0), DVec3::ZERO, DVec3::Z, 60.0).expect("a camera");
    let scene = builder.finish();
    check("normal maps", &scene, &camera, &sized(201, 101, 1));
    check("normal maps", &scene, &camera, &sized(64, 48, 4));
}

/// OBJ files name normal maps after three keywords, and height maps, which are grey.
#[test]
fn obj_materials() {
    let png = |pixels: &[[u8; 4]]| {
        let mut bytes = io::Cursor::new(Vec::new());
        let image = image::RgbaImage::from_raw(SIDE, SIDE, pixels.concat()).expect("as many pixels");
        let written = image.write_to(&mut bytes, image::ImageFormat::Png);
        written.expect("it is written");
        bytes.into_inner()
    };
    let heights: Vec<[u8; 4]> = texels(None)
        .iter()
        .map(|texel| [texel[2], texel[2], texel[2], 255])
        .collect();
    let (normals, heights) = (png(&texels(None)), png(&heights));
    let load = |material: &str, bytes: &[u8]| {
        let text = "mtllib a.mtl\nusemtl a\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n\
            vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
        let loaded = mesh::parse(text.into(), Path::new("a.obj"), &mut |path| match path.to_str() {
            Some("a.mtl") => Ok(format!("newmtl a\nKd 1 1 1\n{material}\n").into()),
            Some("a.png") => Ok(bytes.to_vec()),
            _ => Err(io::ErrorKind::NotFound.into()),
        });
        loaded.expect("a mesh")
    };
    for keyword in ["norm", "bump -bm 0.5", "map_Bump -bm 0.5"] {
        // The image may be a colour, too.
        let material = format!("map_Kd a.png\n{keyword} a.png");
        let mesh = load(&material, &normals);
        assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
        let map = mesh.surfaces[0].textures.normal_map.expect("a map");
        assert_eq!(map.scale, if keyword == "norm" { 1.0 } else { 0.5 });
        let mesh = load(&material, &heights);
        assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
        assert!(mesh.surfaces[0].textures.normal_map.is_some());
        // To the right, by 45 degrees.
        let mesh = load(&material, &png(&[[218, 128, 218, 255]; (SIDE * SIDE) as usize]));
        if keyword == "norm" {
            assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
            assert!(mesh.surfaces[0].textures.normal_map.is_some());
            continue;
        }
        assert_eq!(
            mesh.notes,
            ["a.obj: texture a.png is not shown: it is neither a normal map nor a grey height map"]
        );
        assert_eq!(mesh.surfaces[0].textures.normal_map, None);
    }
    for (material, notes) in [
        ("norm a.png\nbump b.png", &["a.mtl: left out: texture `bump`"][..]),
        ("bump b.png\nnorm a.png", &[]),
    ] {
        let mesh = load(material, &normals);
        assert_eq!(mesh.notes, notes);
        assert!(mesh.surfaces[0].textures.normal_map.is_some());
    }
}
