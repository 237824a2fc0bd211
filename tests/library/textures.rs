//! Textures: where texels are on a mesh, cut-outs against holes, mipmaps, emission, and images that cannot be shown.

use crate::{images::package, shipped_scene};
use glam::{DVec3, Vec3};
use octray::{
    accel::Bvh,
    format::{self, mesh},
    ray::{Ray, SceneHit},
    reference::{
        brute,
        shade::{Intersect, PixelSample, SecondaryRays, radiance},
    },
    render::{Film, Settings, render},
    scene::{Camera, CutOut, Image, Material, Scene, SceneBuilder, SurfaceTextures, Texture, TriangleMesh},
};
use std::{io, ops::ControlFlow, path::Path};

mod files;

fn film(scene: &Scene, camera: &Camera, settings: Settings) -> Film {
    let frame = render(scene, &Bvh::build(scene), camera, &settings, &|_| {
        ControlFlow::Continue(())
    });
    frame.expect("it renders").film
}

fn sized(side: u32) -> Settings {
    Settings {
        width: side,
        height: side,
        ..Settings::default()
    }
}

/// Looks down at the square from -1 to 1, which fills the picture; +y is up in it.
fn above() -> Camera {
    Camera::look_at(DVec3::Z * 2.0, DVec3::ZERO, DVec3::Y, 53.130_102_354_155_98).expect("a camera")
}

/// A square from -1 to 1 at a height; the image's upper edge is at y = 1.
fn square(z: f32) -> TriangleMesh {
    TriangleMesh {
        x: vec![-1.0, 1.0, 1.0, -1.0],
        y: vec![-1.0, -1.0, 1.0, 1.0],
        z: vec![z; 4],
        uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..TriangleMesh::default()
    }
}

fn png(size: [u32; 2], pixels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = io::Cursor::new(Vec::new());
    let image = image::RgbaImage::from_raw(size[0], size[1], pixels.concat()).expect("as many pixels");
    image
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("it is written");
    bytes.into_inner()
}

const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 255];
const BLUE: [u8; 4] = [0, 0, 255, 255];
const WHITE: [u8; 4] = [255; 4];

/// Loads the square as OBJ with a material, and puts it under full ambient light.
fn obj_scene(material: &str, image: &[u8]) -> (Scene, Vec<String>) {
    let text = "mtllib a.mtl\nusemtl a\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n\
        vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    let material = format!("newmtl a\n{material}\n");
    let loaded = mesh::parse(text.into(), Path::new("a.obj"), &mut |path| match path.to_str() {
        Some("a.mtl") => Ok(material.clone().into()),
        Some("a.png") => Ok(image.to_vec()),
        _ => Err(io::ErrorKind::NotFound.into()),
    });
    let loaded = loaded.expect("a mesh");
    let notes = loaded.notes.clone();
    let mut builder = SceneBuilder::new();
    builder.set_ambient(1.0).expect("a share");
    loaded.add_to(&mut builder, None).expect("a scene");
    (builder.finish(), notes)
}

#[test]
fn texels_are_where_the_file_puts_them() {
    let (scene, notes) = obj_scene("Kd 1 1 1\nmap_Kd a.png", &png([2, 2], &[RED, GREEN, BLUE, WHITE]));
    assert!(notes.is_empty(), "{notes:?}");
    let film = film(&scene, &above(), sized(64));
    // The centres of the four texels, rows from the top.
    for (x, y, expected) in [(15, 15, RED), (48, 15, GREEN), (15, 48, BLUE), (48, 48, WHITE)] {
        let found = film.pixels()[y * 64 + x];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!(
                (found - f32::from(expected) / 255.0).abs() < 0.05,
                "{x} {y}: {found}"
            );
        }
    }
    // A base colour multiplies it.
    let (scene, _) = obj_scene("KD 0.5 1 1\nmap_kd a.png", &png([1, 1], &[WHITE]));
    assert_eq!(
        self::film(&scene, &above(), sized(4)).pixels()[5],
        [0.5, 1.0, 1.0]
    );
}

/// An absolute path of another machine: the file of that name beside the mesh is shown.
#[test]
fn images_of_other_machines_lie_beside_the_mesh() {
    let image = png([1, 1], &[RED]);
    for name in ["C:\\art\\a.png", "/no such folder/a.png", "\\\\host\\art/a.png"] {
        let (scene, notes) = obj_scene(&format!("Kd 1 1 1\nmap_Kd {name}"), &image);
        let expected = format!(
            "a.obj: 1 texture has an absolute path of another machine (`{name}`): taken from beside the mesh"
        );
        assert_eq!(notes, [expected]);
        assert_eq!(film(&scene, &above(), sized(4)).pixels()[5], [1.0, 0.0, 0.0]);
    }
}

/// A square of a PLY file, by its corners or by its vertices, has the bytes of the same square of an OBJ file.
#[test]
fn ply_and_obj_show_the_same() {
    let image = png([2, 2], &[RED, GREEN, BLUE, WHITE]);
    let (obj, _) = obj_scene("Kd 1 1 1\nKs 0.06 0.06 0.06\nNs 24\nmap_Kd a.png", &image);
    let expected = film(&obj, &above(), sized(16));
    let vertices = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
    let face = "element face 1\nproperty list uchar int vertex_indices\n";
    for text in [
        format!(
            "{vertices}{face}property list uchar float texcoord\nend_header\n-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n\
             4 0 1 2 3 8 0 0 1 0 1 1 0 1\n"
        ),
        format!(
            "{vertices}property float s\nproperty float t\n{face}end_header\n-1 -1 0 0 0\n1 -1 0 1 0\n1 1 0 1 1\n\
             -1 1 0 0 1\n4 0 1 2 3\n"
        ),
    ] {
        let text = format!("ply\nformat ascii 1.0\ncomment TextureFile a.png\n{text}");
        let loaded = mesh::parse(text.into(), Path::new("a.ply"), &mut |_| Ok(image.clone()));
        let loaded = loaded.expect("a mesh");
        assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);
        let mut builder = SceneBuilder::new();
        builder.set_ambient(1.0).expect("a share");
        loaded.add_to(&mut builder, None).expect("a scene");
        assert_eq!(
            film(&builder.finish(), &above(), sized(16)).pixels(),
            expected.pixels()
        );
    }
}

#[test]
fn what_emits_needs_no_light() {
    let (mut scene, notes) = obj_scene("Kd 0 0 0\nKe 1 0.5 0\nmap_Ke a.png", &png([1, 1], &[WHITE]));
    assert!(notes.is_empty(), "{notes:?}");
    let camera = above();
    assert_eq!(film(&scene, &camera, sized(4)).pixels()[5], [1.0, 0.5, 0.0]);
    scene.take_lights(SceneBuilder::new().finish());
    assert_eq!(film(&scene, &camera, sized(4)).pixels()[5], [1.0, 0.5, 0.0]);
}

#[test]
fn images_that_cannot_be_shown_are_notes() {
    for (image, reason) in [
        (
            &b"DDS "[..],
            "unknown kind of picture, expected PNG, JPEG, WebP, BMP, TGA, GIF or TIFF",
        ),
        (&png([2, 2], &[RED; 4])[..40], "the file is cut short"),
    ] {
        let (scene, notes) = obj_scene("Kd 1 1 1\nmap_Kd a.png", image);
        assert_eq!(notes.len(), 1, "{notes:?}");
        assert!(
            notes[0].starts_with("a.obj: texture a.png is not shown: "),
            "{notes:?}"
        );
        assert!(notes[0].contains(reason), "{notes:?}");
        assert!(!scene.has_textures() && scene.vertices().uvs.is_empty());
    }
    let (_, notes) = obj_scene("map_Kd no.png", b"");
    assert_eq!(notes, ["a.obj: texture no.png is not shown: file not found"]);
    let (_, notes) = obj_scene("map_Kd D:\\dev\\no.png", b"");
    let expected = "a.obj: texture D:\\dev\\no.png is not shown: that is an absolute path of another machine, and \
                    there is no `no.png` beside the mesh";
    assert_eq!(notes, [expected]);
    // A header that promises more bytes than follow.
    let mut huge = png([1, 1], &[RED]);
    huge[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]);
    let crc = crc(&huge[12..29]);
    huge[29..33].copy_from_slice(&crc.to_be_bytes());
    let (_, notes) = obj_scene("map_Kd a.png", &huge);
    let expected =
        "a.obj: texture a.png is not shown: it has 65535x65535 pixels, expected at most 16384x16384";
    assert_eq!(notes, [expected]);
}

/// The CRC-32 of a PNG chunk.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 }
        })
    })
}

#[test]
fn textures_far_away_are_their_mean() {
    let mut builder = SceneBuilder::new();
    builder.set_ambient(1.0).expect("a share");
    let pixels = (0..256 * 256).map(|i| {
        if (i % 256 + i / 256) % 2 == 0 {
            WHITE
        } else {
            [0, 0, 0, 255]
        }
    });
    let mut image = Image::new([256, 256], pixels.collect()).expect("an image");
    image.set_curve(octray::scene::Curve::Srgb);
    let textures = SurfaceTextures {
        base: Some(Texture {
            image: builder.add_image(image).expect("little memory"),
            ..Texture::default()
        }),
        ..SurfaceTextures::NONE
    };
    let matte = Material::Matte { color: [1.0; 3] };
    let material = builder
        .add_textured_material(matte, textures)
        .expect("a material");
    builder.add_mesh(square(0.0), material).expect("a mesh");
    let scene = builder.finish();
    // Sixteen texels in a pixel; with a texel a pixel it would be black or white.
    for pixel in film(&scene, &above(), sized(16)).pixels() {
        assert!((pixel[0] - 0.5).abs() < 0.01, "{pixel:?}");
    }
    let near = film(&scene, &above(), sized(1024));
    let extreme = near
        .pixels()
        .iter()
        .filter(|pixel| pixel[0] < 0.3 || pixel[0] > 0.7)
        .count();
    assert!(extreme > near.pixels().len() / 5, "{extreme}");
}

/// A floor, a mirror beside it, a light above, and between them every other one of 8x8 squares: cut out of
/// one square, or squares of their own.
fn lattice(is_cut_out: bool) -> Scene {
    let mut builder = SceneBuilder::new();
    builder.add_light(Vec3::new(0.5, 0.3, 4.0), 0.8).expect("a light");
    let color = Material::Matte {
        color: [0.9, 0.6, 0.3],
    };
    let is_there = |i: u32| (i % 8 + i / 8).is_multiple_of(2);
    if is_cut_out {
        let alpha = |i: u32| if is_there(i) { [0, 0, 0, 255] } else { [0; 4] };
        // Sixteen texels a square, so that edges are sharp.
        let pixels = (0..128 * 128).map(|i: u32| alpha(i % 128 / 16 + i / 128 / 16 * 8));
        let image = Image::new([128, 128], pixels.collect()).expect("an image");
        let textures = SurfaceTextures {
            cut_out: Some(CutOut {
                texture: Texture {
                    image: builder.add_image(image).expect("little memory"),
                    nearest: true,
                    ..Texture::default()
                },
                channel: 3,
                limit: 0.5,
            }),
            ..SurfaceTextures::NONE
        };
        let material = builder
            .add_textured_material(color, textures)
            .expect("a material");
        builder.add_mesh(square(1.0), material).expect("a mesh");
    } else {
        let material = builder.add_material(color).expect("a material");
        for i in (0..64).filter(|&i| is_there(i)) {
            let mut mesh = square(1.0);
            let (column, row) = ((i % 8) as f32, (i / 8) as f32);
            mesh.x
                .iter_mut()
                .for_each(|x| *x = (*x + 1.0 + 2.0 * column) / 8.0 - 1.0);
            mesh.y
                .iter_mut()
                .for_each(|y| *y = 1.0 - (1.0 - *y + 2.0 * row) / 8.0);
            builder.add_mesh(mesh, material).expect("a mesh");
        }
    }
    let floor = builder.classic_material(1).expect("there are four");
    let mirror = builder.classic_material(3).expect("there are four");
    for (material, corners) in [
        (
            floor,
            [
                [-3.0, -3.0, 0.0],
                [3.0, -3.0, 0.0],
                [3.0, 3.0, 0.0],
                [-3.0, 3.0, 0.0],
            ],
        ),
        (
            mirror,
            [
                [-2.0, 2.0, 0.0],
                [2.0, 2.0, 0.0],
                [2.0, 2.0, 3.0],
                [-2.0, 2.0, 3.0],
            ],
        ),
    ] {
        let [a, b, c, d] = corners.map(Vec3::from_array);
        builder.add_triangle([a, b, c], material).expect("a triangle");
        builder.add_triangle([a, c, d], material).expect("a triangle");
    }
    builder.finish()
}

#[test]
fn cut_outs_are_holes_for_all_rays() {
    let camera = Camera::look_at(
        DVec3::new(1.0, -4.0, 3.0),
        DVec3::new(0.0, 0.5, 0.8),
        DVec3::Z,
        50.0,
    );
    let camera = camera.expect("a camera");
    let [cut, holes] = [true, false].map(|is_cut_out| film(&lattice(is_cut_out), &camera, sized(256)));
    let near = |a: &[f32; 3], b: &[f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4);
    let different = cut
        .pixels()
        .iter()
        .zip(holes.pixels())
        .filter(|(a, b)| !near(a, b))
        .count();
    // At edges, where rounding decides.
    assert!(different < 40, "{different}");
    let unlike = cut
        .pixels()
        .windows(2)
        .filter(|pair| !near(&pair[0], &pair[1]))
        .count();
    assert!(unlike > 3000, "{unlike}");
}

/// Every primitive is tested.
struct Brute<'a>(&'a Scene);

impl Intersect for Brute<'_> {
    fn closest_hit(&mut self, ray: &Ray) -> SceneHit {
        brute::closest_hit(self.0, ray)
    }

    fn opaque_hit(&mut self, ray: &Ray) -> SceneHit {
        brute::opaque_hit(self.0, ray)
    }

    fn occluded(&mut self, ray: &Ray) -> bool {
        brute::occluded(self.0, ray)
    }
}

#[test]
fn brute_force_sees_the_same() {
    for (scene, camera) in [
        (
            lattice(true),
            Camera::look_at(DVec3::new(1.0, -4.0, 3.0), DVec3::Z, DVec3::Z, 50.0).expect("a camera"),
        ),
        (
            shipped_scene("garden"),
            shipped_scene("garden").cameras()[0].camera,
        ),
    ] {
        let film = film(&scene, &camera, sized(48));
        let rays = camera.pixel_rays(&scene, 48, 48, 1);
        for (i, pixel) in film.pixels().iter().enumerate() {
            let [x, y] = [i as u32 % 48, i as u32 / 48];
            let sample = PixelSample {
                pixel: [x, y],
                number: 0,
                count: 1,
                cone: rays.cone(),
            };
            let ray = Ray::new(rays.eye(), rays.direction(x, y, [0, 0]));
            let (depth, shadows) = (Settings::default().max_depth, true);
            let mut counts = SecondaryRays::default();
            let expected = radiance(
                &scene,
                &mut Brute(&scene),
                ray,
                sample,
                depth,
                shadows,
                &mut counts,
            );
            assert_eq!(pixel.map(f32::to_bits), expected.map(f32::to_bits), "{x} {y}");
        }
    }
}

#[test]
fn triangles_without_texture_coordinates_have_the_base_colour() {
    let text = "mtllib a.mtl\nusemtl a\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nf 1/1 2/1 3/1\nf 1 3 4\n\
        f 1/9 3/1 4/1\n";
    let material = "newmtl a\nKd 1 1 1\nmap_Kd a.png # red\nmap_d ./a.png\n";
    let mut reads = 0;
    let loaded = mesh::parse(text.into(), Path::new("a.obj"), &mut |path| {
        reads += 1;
        Ok(if path.ends_with("a.mtl") {
            material.into()
        } else {
            png([1, 1], &[[255, 0, 0, 0]])
        })
    });
    let loaded = loaded.expect("a mesh");
    assert_eq!((reads, loaded.images.len()), (2, 1));
    assert_eq!(
        loaded.notes,
        ["a.obj: 2 triangles have no texture coordinates: shown without texture"]
    );
    assert_eq!(loaded.surface_of, [0, 1, 1]);
    assert_eq!(loaded.surfaces[1].textures, SurfaceTextures::NONE);
    assert!(loaded.surfaces[0].textures.cut_out.is_some() && loaded.images[0].has_alpha());
}

#[test]
fn alpha_of_what_is_not_cut_out_means_nothing() {
    let (scene, _) = obj_scene(
        "Kd 1 1 1\nmap_Kd a.png",
        &png([2, 1], &[[255, 0, 0, 255], [0, 255, 0, 0]]),
    );
    assert!(!scene.images()[0].has_alpha());
    let found = film(&scene, &above(), sized(1)).pixels()[0];
    assert!((found[0] - found[1]).abs() < 0.01 && found[0] > 0.4, "{found:?}");
}

#[test]
fn a_mesh_that_is_placed_again_shows_the_images_that_are_there() {
    let quad = "mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";
    let load = |text: &str| {
        let mut images = 0;
        let scene = format::load_from_bytes(text.as_bytes(), Path::new("a.scn"), &mut |path| {
            Ok(match path.extension().and_then(|extension| extension.to_str()) {
                Some("obj") => quad.into(),
                Some("mtl") => b"newmtl a\nKd 1 1 1\nmap_Kd a.png\n".to_vec(),
                _ => {
                    images += 1;
                    png([1, 1], &[RED])
                }
            })
        });
        let scene = scene.unwrap_or_else(|error| panic!("{error}"));
        assert!(scene.sources().notes.is_empty(), "{:?}", scene.sources().notes);
        let textured = scene
            .triangles()
            .material
            .iter()
            .filter(|&&id| scene.textures(id).is_some());
        (textured.count(), scene.images().len(), scene.vertices().uvs.len())
    };
    let again = "mesh a.obj translate 1 0 0\nmesh a.obj translate 2 0 0\n";
    assert_eq!(load(&format!("light 1 2 3 1\nmesh a.obj\n{again}")), (3, 1, 9));
    assert_eq!(
        load(&format!("light 1 2 3 1\nmaterial 1\nmesh a.obj\n{again}")),
        (0, 0, 0)
    );
    let late =
        format!("light 1 2 3 1\nmaterial 1\nmesh a.obj\n{again}material own\nmesh a.obj translate 3 0 0\n");
    assert_eq!(load(&format!("{late}mesh a.obj translate 4 0 0\n")), (2, 1, 15));
}

#[test]
fn an_image_is_read_once_and_only_if_a_triangle_shows_it() {
    let text =
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\nusemtl b\nf 1/1 2/1 3/1\n";
    let material = "newmtl a\nmap_Kd x.png\nnewmtl b\nmap_Kd x.png\nnewmtl c\nmap_Kd y.png\n";
    let image = png([3, 2], &[RED; 6]);
    let mut asked = Vec::new();
    let loaded = mesh::parse(text.into(), Path::new("a.obj"), &mut |path| {
        asked.push(path.to_path_buf());
        Ok(if path.ends_with("a.mtl") {
            material.into()
        } else {
            image.clone()
        })
    });
    let loaded = loaded.expect("a mesh");
    assert_eq!(asked, [Path::new("a.mtl"), Path::new("x.png")]);
    assert_eq!(loaded.images.len(), 1);
    assert_eq!(loaded.images[0].size(), [3, 2]);
    let scene = format::load(&package().join("scenes/garden.scn")).expect("a scene");
    assert_eq!(scene.images().len(), 3);
    assert!(scene.has_cut_outs());
}
