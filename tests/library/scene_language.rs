//! The examples of `docs/scene-language.md`: each loads, shows something, and gives the same picture in packet and scalar
//! mode. Every statement has an example.

use glam::DVec3;
use octray::{
    accel::Bvh,
    format::load_from_bytes,
    render::{Film, Mode, Settings, render},
    scene::{Camera, Scene},
};
use std::{fs, ops::ControlFlow, path::Path};

/// A block of the document: a scene, or a named part.
struct Block {
    part: Option<String>,
    text: String,
}

fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn blocks() -> Vec<Block> {
    let document = fs::read_to_string(package().join("docs/scene-language.md")).expect("the document");
    let mut blocks = Vec::new();
    for fence in document.split("```scn").skip(1) {
        let (name, rest) = fence.split_once('\n').expect("a line behind the fence");
        let (text, _) = rest.split_once("```").expect("a closing fence");
        let name = name.trim();
        blocks.push(Block {
            part: (!name.is_empty()).then(|| name.to_owned()),
            text: text.to_owned(),
        });
    }
    blocks
}

/// Loads a scene as if it were in `scenes/`, with the parts of the document beside it.
fn load(text: &str, blocks: &[Block]) -> Scene {
    let folder = package().join("scenes");
    let open = &mut |path: &Path| {
        let part = path.strip_prefix(&folder).ok().and_then(Path::to_str);
        match blocks.iter().find(|block| block.part.as_deref() == part) {
            Some(block) if part.is_some() => Ok(block.text.clone().into_bytes()),
            _ => fs::read(path),
        }
    };
    load_from_bytes(text.as_bytes(), &folder.join("example.scn"), open)
        .unwrap_or_else(|error| panic!("{text}\n{}", error.report()))
}

fn film(scene: &Scene, camera: &Camera, mode: Mode) -> Film {
    let settings = Settings {
        width: 96,
        height: 80,
        mode,
        ..Settings::default()
    };
    let frame = render(scene, &Bvh::build(scene), camera, &settings, &|_| {
        ControlFlow::Continue(())
    });
    frame.expect("a small picture").film
}

/// An example without its shapes.
fn without_shapes(text: &str) -> String {
    let keeps = |line: &&str| line.starts_with("background") || line.starts_with("camera");
    text.lines().filter(keeps).collect::<Vec<_>>().join("\n")
}

#[test]
fn every_example_shows_something() {
    let blocks = blocks();
    for Block { text, .. } in blocks.iter().filter(|block| block.part.is_none()) {
        let scene = load(text, &blocks);
        let camera = scene.cameras().first().map(|named| named.camera);
        let camera = camera.unwrap_or_else(|| Camera::classic_view(1).expect("a view"));
        let packet = film(&scene, &camera, Mode::Packet);
        let scalar = film(&scene, &camera, Mode::Scalar);
        let mut moved = load(text, &blocks);
        moved.set_time(scene.frame_count().into()).expect("a frame");
        let last = film(&moved, &camera, Mode::Packet);
        assert_eq!(scene.moves(), last != packet, "{text}");
        let bits = |film: &Film| -> Vec<[u32; 3]> {
            film.pixels()
                .iter()
                .map(|pixel| pixel.map(f32::to_bits))
                .collect()
        };
        assert_eq!(bits(&packet), bits(&scalar), "{text}");

        let nothing = film(&load(&without_shapes(text), &blocks), &camera, Mode::Packet);
        let shown = packet
            .pixels()
            .iter()
            .zip(nothing.pixels())
            .filter(|(a, b)| a != b)
            .count();
        assert!(shown > 96 * 80 / 50, "{shown} pixels show something:\n{text}");
    }
}

/// The colours of one file, as they are and decoded, in meshes and instances.
#[test]
fn own_colours_are_decoded_on_request() {
    let text = "ambient 1\nmesh a.obj\nmaterial own srgb\nmesh a.obj translate 4 0 0\nmesh a.obj translate 8 0 0\n\
                instance a.obj translate 12 0 0\nmaterial own\ninstance a.obj translate 16 0 0\n";
    let mesh = "mtllib a.mtl\nusemtl a\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n";
    let scene = load_from_bytes(text.as_bytes(), Path::new("a.scn"), &mut |path| {
        let is_mesh = path.extension().is_some_and(|extension| extension == "obj");
        Ok(if is_mesh { mesh } else { "newmtl a\nKd 1 0.5 0\n" }.into())
    });
    let scene = scene.expect("a scene");
    for (x, green) in [(0.0, 0.5), (4.0, 0.214), (8.0, 0.214), (12.0, 0.214), (16.0, 0.5)] {
        let (eye, target) = (DVec3::new(x, 0.0, 9.0), DVec3::new(x, 0.0, 0.0));
        let camera = Camera::look_at(eye, target, DVec3::Y, 1.0).expect("a camera");
        let [red, found, blue] = film(&scene, &camera, Mode::Packet).pixels()[0];
        assert_eq!((red, blue), (1.0, 0.0));
        assert!((found - green).abs() < 1e-4, "{found} at {x}");
    }
}

/// The list of statements is that of the error about an unknown one.
#[test]
fn every_statement_and_key_has_an_example() {
    let error = load_from_bytes(b"?", Path::new("a.scn"), &mut |_| Ok(Vec::new())).expect_err("no statement");
    let statements: Vec<&str> = error.message.split('`').skip(3).step_by(2).collect();
    assert!(statements.len() >= 10, "{statements:?}");
    let examples: String = blocks()
        .iter()
        .filter(|block| block.part.is_none())
        .map(|block| block.text.clone())
        .collect();
    for statement in statements {
        let found = examples
            .lines()
            .any(|line| line.trim_start().starts_with(statement));
        assert!(found, "no example of {statement}");
    }
    for key in "scale rotate translate point_size placements cd cs kd ks alpha mix color bottom top eye target up fov ortho aperture focus normal checker size own srgb silhouette matte \
                blinn_phong reflection glass ior tint depth opacity tinted lights"
        .split_whitespace()
    {
        assert!(examples.split_whitespace().any(|word| word == key), "no example of {key}");
    }
}

/// A scene with nothing that gives light is told, even if it says so itself.
#[test]
fn scenes_without_ambient_light_are_noted() {
    let notes = |text: &str| {
        let nothing: &mut dyn FnMut(&Path) -> std::io::Result<Vec<u8>> =
            &mut |_| Err(std::io::ErrorKind::NotFound.into());
        let scene = load_from_bytes(text.as_bytes(), Path::new("a.scn"), nothing).expect(text);
        scene.sources().notes.clone()
    };
    let shape = "material 1\nsphere 0 0 0 1\n";
    assert_eq!(
        notes(&format!("{shape}ambient 0")),
        [
            "a.scn: the scene has no light, so nothing lights its surfaces; add a line such as `light 9 -4 10 0.7`"
        ]
    );
    for light in ["ambient 0\nlight 9 -4 10 0.7", "ambient 0.01"] {
        assert!(notes(&format!("{shape}{light}")).is_empty(), "{light}");
    }
}
