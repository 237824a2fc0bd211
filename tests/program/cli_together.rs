//! Options, inputs and names in combination.

use crate::program::{Folder, shipped_mesh};
use std::fs;

/// A mesh's camera moves with the mesh and can be chosen by name.
#[test]
fn cameras_of_meshes_in_a_scene() {
    let folder = Folder::new();
    fs::copy(shipped_mesh("mobile.gltf"), folder.path("m.gltf")).expect("the mesh is copied");
    let placed = "rotate 1 0 0 90 scale 0.5 translate 3 2 1";
    let text = format!("light 3 -2 9 0.7\nmesh m.gltf {placed}\nmesh m.gltf\n");
    folder.write("mobile.scn", &text);
    folder.write(
        "front.scn",
        &format!("camera front eye 1 2 9 target 3 2 1\n{text}"),
    );
    let read = |arguments: &[&str]| {
        let arguments = [arguments, &["--size=64x48", "-o=p.ppm", "--quiet"]].concat();
        folder.run(&arguments).succeeded();
        fs::read(folder.path("p.ppm")).expect("a picture")
    };
    let info = folder.run(&["info", "--json=-", "mobile.scn"]);
    let info: serde_json::Value = serde_json::from_str(info.succeeded().text()).expect("JSON");
    let cameras = info["cameras"].as_array().expect("a list");
    assert_eq!((cameras.len(), &cameras[0]["name"]), (2, &"front".into()));
    let vector = |name: &str| {
        let [x, y, z] = [0, 1, 2].map(|i| cameras[0][name][i].to_string());
        format!("--{name}={x},{y},{z}")
    };
    let (eye, target, up) = (vector("eye"), vector("target"), vector("up"));
    let fov = format!("--fov={}", cameras[0]["fov"]);
    let by_name = read(&["mobile.scn", "--camera=front"]);
    assert_eq!(by_name, read(&["mobile.scn", &eye, &target, &up, &fov]));
    assert_eq!(by_name, read(&["mobile.scn", "--camera=1"]));
    assert_ne!(by_name, read(&["mobile.scn", "--camera=2"]));
    // It moved with the mesh, so it sees it.
    let mesh_pixels = |picture: &[u8]| picture.chunks_exact(3).filter(|pixel| *pixel != [255; 3]).count();
    assert!(mesh_pixels(&by_name) > 64 * 48 / 50, "{}", mesh_pixels(&by_name));
    // The scene's own cameras come first.
    assert_eq!(read(&["mobile.scn"]), read(&["mobile.scn", "--view=1"]));
    assert_eq!(read(&["front.scn"]), read(&["front.scn", "--camera=front"]));
    folder.fails(&["mobile.scn", "--camera", "frant"], 2, "did you mean `front`?");
}

/// The camera and its light go round the mesh and frame it from every side.
#[test]
fn turntables_frame_and_light_meshes() {
    let folder = Folder::new();
    for (mesh, options) in [
        ("house.stl", "--size=90x60"),
        ("vase.obj", "--size=50x90"),
        ("mobile.gltf", "--size=64x64"),
    ] {
        let mesh = shipped_mesh(mesh);
        let arguments = [
            &mesh,
            options,
            "--turntable=5",
            "--background=transparent",
            "-o=t-#.png",
            "--quiet",
        ];
        folder.run(&arguments).succeeded();
        let mut darkest = u64::MAX;
        let mut brightest = 0;
        for number in 1..=5 {
            let path = folder.path(&format!("t-{number}.png"));
            let picture = image::open(path).expect("a picture").into_rgba8();
            let [right, bottom] = [picture.width() - 1, picture.height() - 1];
            let seen =
                |(x, y, _): &(u32, u32, &image::Rgba<u8>)| *x == 0 || *y == 0 || *x == right || *y == bottom;
            let shown = picture.enumerate_pixels().filter(|(_, _, pixel)| pixel.0[3] > 0);
            assert!(!shown.clone().any(|pixel| seen(&pixel)), "{mesh} {number}");
            // In red all of these meshes look about the same from all sides.
            let values = shown.clone().map(|(_, _, pixel)| u64::from(pixel.0[0]));
            let mean = values.sum::<u64>() / shown.clone().count().max(1) as u64;
            darkest = darkest.min(mean);
            brightest = brightest.max(mean);
            assert!(
                shown.count() as u32 * 50 > right * bottom,
                "{mesh} {number} is small"
            );
        }
        // A light that stayed in place would leave the back much darker.
        assert!(3 * darkest > 2 * brightest, "{mesh}: {darkest} to {brightest}");
    }
}

/// File names with spaces, dashes and pattern characters, and many options at once.
#[test]
fn odd_names_with_many_options() {
    let folder = Folder::new();
    let scene = "light 3 -2 9 0.7\nmaterial 2\nsphere 0 0 0.5 0.5\n";
    for name in ["two words ü####.scn", "{stem}.scn", "-x.scn"] {
        folder.write(name, scene);
    }
    folder.write("defaults.toml", "samples = 4\nsrgb = true\nsize = \"40x30\"\n");
    let script = "\"$0\" - './-x.scn' 'two words ü####.scn' '{stem}.scn' --config defaults.toml --crop 5,6,30,20 \
        --turntable 3 --frames 2-3 --aov depth,heat -o 'a b-{stem}-##.png' --quiet < '{stem}.scn'";
    folder.shell(script).succeeded();
    let names = folder.names();
    for stem in ["stdin", "-x", "two words ü####", "{stem}"] {
        for number in ["02", "03"] {
            for kind in ["", ".depth", ".heat"] {
                let name = format!("a b-{stem}-{number}{kind}.png");
                assert!(names.contains(&name), "{name} is not among {names:?}");
                let size = image::image_dimensions(folder.path(&name)).expect("a picture");
                assert_eq!(size, (25, 14));
            }
        }
    }
    assert_eq!(names.len(), 5 + 24, "{names:?}");
}

#[test]
fn a_picture_is_refused_as_a_scene() {
    let folder = Folder::new();
    folder.write("a.scn", "sphere 0 0 0 1\n");
    folder.run(&["a.scn", "--size=8x8", "--quiet"]).succeeded();
    folder.fails(
        &["a.png"],
        1,
        "a.png: this is a PNG picture, expected a scene or a mesh",
    );
    folder.fails(&["a"], 1, "did you mean `a.scn`?");
}
