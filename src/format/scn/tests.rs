use super::*;
use crate::{
    error::LoadError,
    format::load_from_bytes,
    scene::{Background, Material, Projection, View},
};
use glam::{DVec3, Vec3};
use std::io;

const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

fn load(text: &[u8]) -> Result<Scene, LoadError> {
    load_from_bytes(text, Path::new("dir/a.scn"), &mut |path| match path
        .to_str()
        .map(|path| path.replace('\\', "/"))
        .as_deref()
    {
        Some("dir/t.ply" | "dir/my mesh.ply" | "dir/./t.ply" | "dir/deep/../t.ply") => Ok(TRIANGLE.into()),
        Some("dir/part.scn") => {
            Ok(b"material matte cd 0 0 1\nsphere 0 0 0 1\ninclude deep/leaf.scn\n".to_vec())
        }
        Some("dir/deep/leaf.scn") => Ok(b"ply_file ../t.ply\ncamera leaf eye 1 2 3 target 0 0 0\n".to_vec()),
        Some("dir/points.obj") => Ok(b"v 0 0 0 1 0 0\nv 2 0 0 0 0 1\np 1 2\n".to_vec()),
        Some("dir/points.ply") => Ok(TRIANGLE
            .replace("face 1", "face 0")
            .replace("3 0 1 2\n", "")
            .into()),
        Some("dir/colors.ply") => Ok(TRIANGLE
            .replace(
                "element face",
                "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face",
            )
            .replace(" 0\n", " 0 0 255 51\n")
            .into()),
        Some("dir/bad.ply") => Ok(TRIANGLE.replace("3 0 1 2", "3 0 1 9").into()),
        _ => Err(io::ErrorKind::NotFound.into()),
    })
}

fn scene(text: &str) -> Scene {
    load(text.as_bytes()).unwrap_or_else(|error| panic!("{text:?}: {}", error.report()))
}

fn fault(text: impl AsRef<[u8]>) -> String {
    let error = load(text.as_ref()).expect_err("must be refused");
    error.to_string().trim_start_matches("dir/a.scn:").to_owned()
}

#[test]
fn statements() {
    let scene = scene(
        "// a comment\n\n  light 9 -4.0 10.0  0.7 // trailing\n\tsphere 0 .5 1. 1e-1\r\nmaterial 3\n\
         sphere +0 0 0 1//close\nmaterial 1\nply_file t.ply\nply_file \"my mesh.ply\" // quoted\nmaterial 2",
    );
    assert_eq!(scene.lights()[0].intensity, 0.7);
    assert_eq!(scene.spheres().center_y, [0.5, 0.0]);
    assert_eq!(scene.spheres().radius, [0.1, 1.0]);
    assert_eq!(scene.spheres().material, [MaterialId(0), MaterialId(3)]);
    assert_eq!(scene.triangles().material, [MaterialId(1); 2]);
}

/// A copy would lie exactly in the first. One of another material is seen if the first is not opaque.
#[test]
fn a_mesh_named_again_is_there_once() {
    let scene = scene(
        "material 1\nply_file t.ply\nmaterial 2\nply_file ./t.ply\nply_file \"my mesh.ply\"\nply_file t.ply",
    );
    let materials = [1, 2, 2].map(MaterialId);
    assert_eq!(scene.triangles().material, materials);
}

#[test]
fn nothing_is_a_scene() {
    for text in ["", "\n", "\r\n\r\n", "//", "\u{feff}", "\u{feff}// caf\u{e9}\n"] {
        assert_eq!(scene(text).primitive_count(), 0, "{text:?}");
    }
    assert_eq!(
        load(b"// \xff latin-1")
            .expect("comments may have any bytes")
            .primitive_count(),
        0
    );
    assert_eq!(scene("\u{feff}sphere 0 0 0 1").primitive_count(), 1);
}

#[test]
fn unknown_statements() {
    assert_eq!(
        fault("\n sphre 0 0 0 1"),
        "2:2: unknown statement `sphre`, did you mean `sphere`?"
    );
    assert_eq!(
        fault("Light 0 0 0 1"),
        "1:1: unknown statement `Light`, did you mean `light`?"
    );
    assert_eq!(
        fault("plyfile a"),
        "1:1: unknown statement `plyfile`, did you mean `ply_file`?"
    );
    assert_eq!(
        fault("materials 1"),
        "1:1: unknown statement `materials`, did you mean `material`?"
    );
    let expected = "expected `light`, `directional_light`, `sphere`, `triangle`, `plane`, `mesh`, `instance`, `ply_file`, `material`, `camera`, `background`, `environment`, \
        `ambient`, `ambient_specular`, `smooth_shadows`, `at` or `include`";
    assert_eq!(
        fault("cube"),
        format!("1:1: unknown statement `cube`, {expected}")
    );
    assert_eq!(
        fault(b"\xff\x1b"),
        format!("1:1: unknown statement `\\xff\\u{{1b}}`, {expected}")
    );
    assert!(fault("ply\nformat ascii 1.0").starts_with("1:1: found `ply`: this looks like a PLY mesh"));
}

#[test]
fn counts() {
    assert_eq!(
        fault("sphere 0 0 0 1 2 3"),
        "1:16: found `2` after `sphere x y z radius`, expected the end of the line"
    );
    assert_eq!(
        fault("sphere 0 0 0 1 # a ball"),
        "1:16: found `#`: `#` does not start a comment, expected `//`"
    );
    assert_eq!(
        fault("light 0 0 "),
        "1:10: `light` with 2 of 4 values, expected `light x y z intensity`"
    );
    assert_eq!(
        fault("background blue"),
        "1:16: `background` with 1 of 3 values, expected `background r g b`, a colour as three numbers such as `1 0.5 0`"
    );
    assert_eq!(
        fault("material"),
        "1:9: nothing follows `material`, expected `material NAME`"
    );
    assert!(fault("ply_file my mesh.ply").starts_with("1:13: found `mesh.ply` after `ply_file PATH`"));
    assert_eq!(
        fault("ply_file \"a"),
        "1:10: the path has no closing quote, expected `\"` before the end of the line"
    );
    assert_eq!(
        fault("ply_file \"\""),
        "1:10: the path is empty, expected the path of a .ply file"
    );
}

#[test]
fn numbers() {
    for (text, report) in [
        (
            "sphere 0 0,5 0 1",
            "1:10: y is `0,5`, expected a number such as 0.5",
        ),
        ("sphere 0 0 nan 1", "1:12: z is `nan`, expected a finite number"),
        ("light -inf 0 0 1", "1:7: x is `-inf`, expected a finite number"),
        (
            "light 0 0 0 1e999",
            "1:13: intensity is 1e999, but numbers above 1e9 are not supported",
        ),
        (
            "light 0 1e30 0 1",
            "1:9: y is 1e30, but numbers above 1e9 are not supported",
        ),
        ("sphere 0 0 0 0", "1:14: radius is 0, expected a number above 0"),
    ] {
        assert_eq!(fault(text), report);
    }
    assert_eq!(
        fault("sphere 0 0 0 -0.5"),
        "1:14: radius is -0.5, expected a number above 0"
    );
    assert_eq!(
        fault("light 0 0 0 -1"),
        "1:13: intensity is -1, expected 0 or more"
    );
    for word in ["4", "-1", "1.0", "99999999999", "velvet"] {
        let expected = "expected 0 (silhouette), 1 (matte), 2 (blinn_phong), 3 (reflection), one of these names, \
            `glass` or `own`";
        assert_eq!(
            fault(format!("material {word}")),
            format!("1:10: unknown material `{word}`, {expected}")
        );
    }
}

#[test]
fn binary_and_endless_lines() {
    assert_eq!(
        fault(b"sphere 0 0 0 1\n//\0\n"),
        "2:3: found a NUL byte: this is binary data, expected the text of a scene"
    );
    let line = format!("//{}\n", "x".repeat(MAX_LINE - 2));
    assert_eq!(scene(&line).primitive_count(), 0);
    assert!(fault(format!("\n/{line}")).starts_with("2:1: line of 65537 bytes"));
}

#[test]
fn meshes() {
    assert_eq!(
        fault("ply_file no.ply"),
        "1:10: cannot load dir/no.ply\n  caused by: dir/no.ply: file not found"
    );
    assert_eq!(
        fault("ply_file bad.ply"),
        "1:10: cannot load dir/bad.ply\n  \
         caused by: dir/bad.ply:13:1: vertex index 9, but the file has only 3 vertices"
    );
    assert!(fault("ply_file other.scn").contains("expected `include` for scenes"));
    assert_eq!(fault(b"ply_file \xff"), "1:10: path `\\xff` is not valid UTF-8");
}

#[test]
fn cameras() {
    let scene = scene(
        "camera eye 1 2 3 target 0 0 0.5\ncamera \"from above\" target 0 0 0 eye 0 0 9 fov 30 up 0 1 0 // top\n\
         camera \"eye\" eye 1 0 0 target 0 0 0\ncamera caf\u{e9} eye 1 0 0 target 0 0 0\n\
         camera plan eye 1 0 0 target 0 0 0 ortho 2.5",
    );
    let names: Vec<_> = scene.cameras().iter().map(|c| c.name.as_deref()).collect();
    assert_eq!(
        names,
        [
            None,
            Some("from above"),
            Some("eye"),
            Some("caf\u{e9}"),
            Some("plan")
        ]
    );
    let [first, above] = [0, 1].map(|i: usize| scene.cameras()[i].camera.view());
    assert_eq!(first.eye, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!((first.up, first.projection), (View::UP, Projection::DEFAULT));
    assert_eq!(
        (above.up, above.projection),
        (DVec3::Y, Projection::Perspective { fov_degrees: 30.0 })
    );
    let plan = scene.cameras()[4].camera.view();
    assert_eq!(plan.projection, Projection::Orthographic { height: 2.5 });
}

#[test]
fn scene_wide_values() {
    let plain = scene("sphere 0 0 0 1");
    assert_eq!(plain.ambient(), 0.05);
    assert_eq!(plain.background(), Background::constant([1.0; 3]));
    assert!(plain.lights().is_empty());
    let scene = scene(
        "ambient 0.25\nbackground top 0 0 1 bottom 1 0.5 0\nlight 1 2 3 0.5 color 1 0.5 0\nlight 1 2 3 0.5",
    );
    assert_eq!(scene.ambient(), 0.25);
    assert_eq!(scene.background().top, [0.0, 0.0, 1.0]);
    assert_eq!(scene.background().bottom, [1.0, 0.5, 0.0]);
    assert_eq!(scene.lights()[0].power(), [0.5, 0.25, 0.0]);
    assert_eq!(scene.lights()[1].power(), [0.5; 3]);
}

#[test]
fn materials() {
    let scene = scene(
        "sphere 0 0 0 1\nmaterial matte\nsphere 0 0 0 1\nmaterial matte cd 0 1 0\nsphere 0 0 0 1\n\
         material blinn_phong ks 0.25 alpha 9\nsphere 0 0 0 1\nmaterial matte cd 0 1 0\nsphere 0 0 0 1\n\
         material reflection mix 1 cd 0 0 0\nsphere 0 0 0 1\nmaterial silhouette cd 0 0 1\nsphere 0 0 0 1\n\
         material own\nsphere 0 0 0 1\nmaterial 3\nsphere 0 0 0 1",
    );
    // A material that was there already keeps its id.
    let ids: Vec<u32> = scene.spheres().material.iter().map(|id| id.0).collect();
    assert_eq!(ids, [0, 1, 4, 5, 4, 6, 7, 0, 3]);
    let Material::BlinnPhong {
        diffuse,
        specular,
        k_d,
        k_s,
        alpha,
    } = scene.materials()[5]
    else {
        panic!("another kind");
    };
    assert_eq!((diffuse, specular), ([1.0, 0.0, 0.0], [1.0; 3]));
    assert_eq!((k_d, k_s, alpha), (0.8, 0.25, 9));
    assert_eq!(
        scene.materials()[6],
        Material::Reflection {
            color: [0.0; 3],
            mirror_share: 1.0
        }
    );
}

#[test]
fn glass() {
    let scene =
        scene("material glass\nsphere 0 0 0 1\nmaterial glass depth 2 tint 0.5 1 0 ior 1.33\nsphere 0 0 0 1");
    assert_eq!(
        &scene.materials()[4..],
        [
            Material::GLASS,
            Material::Glass {
                index: 1.33,
                tint: [0.5, 1.0, 0.0],
                depth: 2.0
            }
        ]
    );
    // It needs no light.
    assert_eq!(scene.sources().notes, [""; 0]);
}

#[test]
fn other_names_of_materials_are_suggested() {
    for (word, meant) in [
        ("phong", "blinn_phong"),
        ("mirror", "reflection"),
        ("dielectric", "glass"),
        ("Matte", "matte"),
    ] {
        assert_eq!(
            fault(format!("material {word}")),
            format!("1:10: unknown material `{word}`, did you mean `{meant}`?")
        );
    }
}

#[test]
fn a_scene_without_lights_is_noted() {
    let notes = |text: &str| scene(text).sources().notes.clone();
    let expected = [
        "dir/a.scn: the scene has no light, so only ambient light reaches its surfaces; add a line such as \
         `light 9 -4 10 0.7`",
    ];
    for text in [
        "material 1\nsphere 0 0 0 1",
        "material matte\ntriangle 0 0 0 1 0 0 0 1 0",
        "mesh t.ply",
        "material 2\nply_file t.ply",
        "material 1\nsphere 0 0 0 1\nmaterial 0",
    ] {
        assert_eq!(notes(text), expected, "{text}");
    }
    for text in [
        "",
        "sphere 0 0 0 1\nply_file t.ply",
        "material silhouette cd 0 0 1\nsphere 0 0 0 1\nmesh t.ply",
        "material 1\nsphere 0 0 0 1\nlight 9 -4 10 0.7",
        "material 1\nsphere 0 0 0 1\nambient 1",
        "material 1\nmaterial own\nsphere 0 0 0 1",
    ] {
        assert!(notes(text).is_empty(), "{text}");
    }
}

#[test]
fn triangles() {
    let scene = scene("material 1\nply_file t.ply\nmaterial 2\ntriangle 0 0 1 1 0 1 0 1 2");
    assert_eq!(scene.triangles().material, [MaterialId(1), MaterialId(2)]);
    assert_eq!(
        scene.triangle(1),
        [Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.0, 1.0, 2.0)]
    );
}

#[test]
fn placed_meshes() {
    let scene = scene(
        "mesh t.ply\nmesh ./t.ply\nmesh t.ply translate 0 0 1\nmesh t.ply translate 0 0 1\n\
         mesh t.ply scale 2 rotate 0 0 1 90 translate 0 0 1\nmaterial 1\nmesh \"my mesh.ply\" scale 1 -3 1",
    );
    assert_eq!(scene.triangles().corners.len(), 4);
    assert_eq!(
        scene.triangle(2),
        [Vec3::Z, Vec3::new(0.0, 2.0, 1.0), Vec3::new(-2.0, 0.0, 1.0)]
    );
    // Mirrored: the corners change places, so that the front stays in front.
    assert_eq!(
        scene.triangle(3),
        [Vec3::ZERO, Vec3::new(0.0, -3.0, 0.0), Vec3::X]
    );
    // Before the first `material` a mesh has its own look, and the same as the others.
    let materials: Vec<u32> = scene.triangles().material.iter().map(|id| id.0).collect();
    assert_eq!(materials, [4, 4, 4, 1]);
}

#[test]
fn clouds_and_colours() {
    let spheres = |text: &str| {
        let scene = scene(text);
        let spheres = scene.spheres();
        (
            spheres.radius.clone(),
            spheres.color.clone(),
            scene.triangles().corners.len(),
        )
    };
    let colors = vec![[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(spheres("mesh points.obj"), (vec![1.3; 2], colors.clone(), 0));
    // The radius follows the placement, unless a size is given.
    assert_eq!(spheres("mesh points.obj scale 0.5").0, [0.65; 2]);
    assert_eq!(
        spheres("mesh points.obj point_size 0.5 scale 0.5"),
        (vec![0.25; 2], colors.clone(), 0)
    );
    assert_eq!(
        spheres("material 1\nmesh points.obj"),
        (vec![1.3; 2], Vec::new(), 0)
    );
    // A file that is placed again is copied.
    let placed = "mesh points.obj\nmesh points.obj\nmesh points.obj translate 0 0 9\nmesh points.obj point_size 1 translate 0 0 5";
    let all = spheres(placed);
    assert_eq!(
        (all.0, all.1),
        (vec![1.3, 1.3, 1.3, 1.3, 0.5, 0.5], colors.repeat(3))
    );
    let triangle = scene("mesh colors.ply\nmesh colors.ply translate 0 0 1\nply_file t.ply");
    assert_eq!(triangle.vertices().colors[..6], [[0.0, 1.0, 0.2]; 6]);
    assert_eq!(triangle.vertices().colors[6..], [[1.0; 3]; 3]);
    // Classic scenes know neither.
    let classic = scene("ply_file colors.ply\nply_file points.ply");
    assert!(!classic.has_colors());
    let notes = &classic.sources().notes;
    assert!(
        notes[0].ends_with("colors.ply: left out: vertex colours"),
        "{notes:?}"
    );
    assert!(notes[1].ends_with("points.ply: left out: points"), "{notes:?}");
    assert_eq!(
        (classic.primitive_count(), classic.spheres().radius.len()),
        (1, 0)
    );
    // What `ply_file` does not show, `mesh` still does.
    let both = scene("ply_file points.ply\nmesh points.ply");
    assert_eq!(both.spheres().radius.len(), 3);
    for (size, words) in [
        ("0", "point_size is 0, expected a diameter above 0"),
        ("-1", "point_size is -1, expected a diameter above 0"),
        ("1e-60", "point_size is 1e-60, expected a diameter above 0"),
        ("nan", "point_size is `nan`, expected a finite number"),
        (
            "2e9",
            "point_size is 2e9, but numbers above 1e9 are not supported",
        ),
        ("x", "point_size is `x`, expected a number"),
    ] {
        assert_eq!(
            fault(format!("mesh points.obj point_size {size}")),
            format!("1:28: {words}")
        );
    }
    assert_eq!(
        fault(format!("mesh points.obj {0} scale 2 {0}", "point_size 1")),
        "1:38: second point_size, expected one"
    );
}

/// An included file's lines are read as if they stood in the scene; only its paths are its own.
#[test]
fn includes() {
    let scene = scene("material 2\ninclude part.scn\nsphere 0 0 0 2\nply_file t.ply");
    assert_eq!(scene.spheres().material, [MaterialId(4), MaterialId(4)]);
    assert_eq!(scene.spheres().radius, [1.0, 2.0]);
    assert_eq!(scene.cameras()[0].name.as_deref(), Some("leaf"));
    let includes: Vec<_> = scene
        .sources()
        .includes
        .iter()
        .map(|path| path.to_string_lossy().replace('\\', "/"))
        .collect();
    assert_eq!(includes, ["dir/part.scn", "dir/deep/leaf.scn"]);
}

/// Files of two lines that include each other twice would be read 2^n times.
#[test]
fn includes_have_limits() {
    let load = |text: &str, leaf: &str| {
        load_from_bytes(text.as_bytes(), Path::new("0.scn"), &mut |path| {
            let name = path.file_stem().and_then(|stem| stem.to_str());
            match name.and_then(|name| name.parse::<u32>().ok()) {
                Some(depth) => Ok(leaf.replace("NEXT", &format!("{}.scn", depth + 1)).into()),
                None => Ok(Vec::new()),
            }
        })
    };
    let error = load("include 1.scn", "include NEXT").expect_err("endless");
    assert!(
        error
            .to_string()
            .ends_with("16.scn:1:9: includes nest more than 16 deep"),
        "{error}"
    );
    let twice = "include leaf.scn\n".repeat(1024);
    assert!(load(&twice, "").is_ok());
    let error = load(&(twice + "include leaf.scn"), "").expect_err("too many");
    assert_eq!(
        error.to_string(),
        "0.scn:1025:9: more than 1024 includes in one scene"
    );
}
