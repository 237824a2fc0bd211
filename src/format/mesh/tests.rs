//! Colours of vertices and clouds of points, from every format to the scene.

use super::*;
use crate::scene::{MaterialId, SceneBuilder};
use glam::Vec3;
use std::io;

fn try_load(name: &str, bytes: impl Into<Vec<u8>>) -> Result<LoadedMesh, String> {
    let open = &mut |_: &Path| Err(io::ErrorKind::NotFound.into());
    parse(bytes.into(), Path::new(name), open).map_err(|error| error.to_string())
}

fn load(name: &str, bytes: impl Into<Vec<u8>>) -> LoadedMesh {
    try_load(name, bytes).unwrap_or_else(|error| panic!("{error}"))
}

/// Three vertices whose colours are `channels`, in words of `scalar`.
fn ply(format: &str, scalar: &str, names: [&str; 3], channels: [[f64; 3]; 3]) -> Vec<u8> {
    let [red, green, blue] = names;
    let mut bytes = format!(
        "ply\nformat {format} 1.0\nelement vertex 3\nproperty float x\nproperty {scalar} {red}\nproperty float y\n\
         property float z\nproperty {scalar} {green}\nproperty {scalar} {blue}\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    let corners = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    if format == "ascii" {
        for ([x, y, z], [r, g, b]) in corners.iter().zip(channels) {
            bytes.extend(format!("{x} {r} {y} {z} {g} {b}\n").bytes());
        }
        bytes.extend(b"3 0 1 2\n");
        return bytes;
    }
    let big_endian = format == "binary_big_endian";
    let mut put = |mut value: Vec<u8>| {
        if big_endian {
            value.reverse();
        }
        bytes.extend(value);
    };
    let number = |value: f64| match scalar {
        "uchar" => (value as u8).to_le_bytes().to_vec(),
        "ushort" => (value as u16).to_le_bytes().to_vec(),
        "int" => (value as i32).to_le_bytes().to_vec(),
        "float" => (value as f32).to_le_bytes().to_vec(),
        _ => value.to_le_bytes().to_vec(),
    };
    for ([x, y, z], [r, g, b]) in corners.iter().zip(channels) {
        put(x.to_le_bytes().to_vec());
        put(number(r));
        put(y.to_le_bytes().to_vec());
        put(z.to_le_bytes().to_vec());
        put(number(g));
        put(number(b));
    }
    put(vec![3]);
    for index in 0..3_u32 {
        put(index.to_le_bytes().to_vec());
    }
    bytes
}

const ENCODINGS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

#[test]
fn ply_colours_of_every_type() {
    let shares = [[0.0, 0.25, 1.0], [1.0, 0.5, 0.0], [0.75, 0.0, 0.125]];
    for (scalar, full) in [
        ("uchar", 255.0),
        ("ushort", 65535.0),
        ("int", 255.0),
        ("float", 1.0),
        ("double", 1.0),
    ] {
        let stored = shares
            .map(|color| color.map(|share: f64| if full > 1.0 { (share * full).round() } else { share }));
        let expected = stored.map(|color| color.map(|value| value as f32 / full as f32));
        for format in ENCODINGS {
            for names in [
                ["red", "green", "blue"],
                ["diffuse_red", "diffuse_green", "diffuse_blue"],
                ["r", "g", "b"],
            ] {
                let mesh = load("m.ply", ply(format, scalar, names, stored));
                assert_eq!(mesh.columns.colors, expected, "{scalar} {format}");
                assert_eq!(mesh.columns.y, [0.0, 0.0, 1.0]);
                assert_eq!(mesh.columns.triangles, [[0, 1, 2]]);
                assert!(mesh.notes.is_empty() && mesh.cloud.is_none());
            }
        }
    }
    // Word by word: a record takes several lines.
    let text = String::from_utf8(ply(
        "ascii",
        "uchar",
        ["red", "green", "blue"],
        [[51.0, 0.0, 255.0]; 3],
    ))
    .unwrap();
    let mesh = load("m.ply", text.replacen("0 51 0", "0 51\n0", 1));
    assert_eq!(mesh.columns.colors, [[0.2, 0.0, 1.0]; 3]);
}

#[test]
fn ply_colours_of_gaussian_splats() {
    let names = ["f_dc_0", "f_dc_1", "f_dc_2"];
    let stored = [[0.0, 1.0, -1.0], [1.5, 9.0, -9.0], [0.0; 3]];
    let share = |coefficient: f64| (0.5 + coefficient / (4.0 * std::f64::consts::PI).sqrt()).clamp(0.0, 1.0);
    for format in ENCODINGS {
        let mesh = load("m.ply", ply(format, "float", names, stored));
        for (color, stored) in mesh.columns.colors.iter().zip(stored) {
            for (channel, coefficient) in color.iter().zip(stored) {
                assert!(
                    (f64::from(*channel) - share(coefficient)).abs() < 1e-6,
                    "{format} {coefficient}"
                );
            }
        }
        assert!(mesh.notes.is_empty());
    }
    let splat = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
        property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\nproperty float f_rest_0\n\
        property float opacity\nproperty float scale_0\nproperty float rot_0\nproperty float other\nend_header\n\
        0 0 0 0 0 0 1 1 1 1 1\n";
    let mesh = load("m.ply", splat);
    assert_eq!(mesh.columns.colors, [[0.5; 3]]);
    let note =
        "m.ply: left out: shapes, opacity and reflections of Gaussian splats, vertex properties `other`";
    assert_eq!(mesh.notes, [note]);
}

#[test]
fn ply_colours_out_of_range() {
    let names = ["red", "green", "blue"];
    for format in ENCODINGS {
        let odd = [[-0.5, 0.5, 1.5], [0.0, 1.0, 0.5], [0.0, 1e30, 0.0]];
        let mesh = load("m.ply", ply(format, "float", names, odd));
        assert_eq!(
            mesh.columns.colors,
            [[0.0, 0.5, 1.0], [0.0, 1.0, 0.5], [0.0, 1.0, 0.0]]
        );
        assert_eq!(
            mesh.notes,
            ["m.ply: 2 vertex colours are not from 0 to 1: clamped"]
        );
        for (value, word) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf")] {
            let broken = [[0.0; 3], [0.0, value, 0.0], [0.0; 3]];
            for scalar in ["float", "double"] {
                let error = try_load("m.ply", ply(format, scalar, names, broken)).expect_err("no colour");
                let expected = format!("vertex 2 of 3: green is {word}, expected a finite number");
                let place = if format == "ascii" {
                    "m.ply:14:9: "
                } else {
                    "m.ply: record 2: "
                };
                assert!(error.contains(&expected), "{error}");
                assert!(format != "ascii" || error.starts_with(place), "{error}");
            }
        }
    }
}

#[test]
fn ply_colours_that_are_left_out() {
    let header = |properties: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n{properties}end_header\n"
        )
    };
    let notes = |properties: &str, row: &str| load("m.ply", header(properties) + row).notes;
    let all = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    assert!(notes(all, "0 0 0 1 2 3\n").is_empty());
    let some = "property uchar red\nproperty uchar green\n";
    assert_eq!(notes(some, "0 0 0 1 2\n"), ["m.ply: left out: vertex colours"]);
    let with_alpha = format!("{all}property uchar alpha\n");
    assert!(notes(&with_alpha, "0 0 0 1 2 3 255\n").is_empty());
    for alpha in ["254", "0", "half"] {
        let row = format!("0 0 0 1 2 3 {alpha}\n");
        assert_eq!(notes(&with_alpha, &row), ["m.ply: left out: vertex alpha"]);
    }
    let twice = format!("{all}property float r\nproperty float g\nproperty float b\n");
    assert_eq!(
        notes(&twice, "0 0 0 1 2 3 1 1 1\n"),
        ["m.ply: left out: more vertex colours"]
    );
    let list = "property uchar red\nproperty uchar green\nproperty list uchar uchar blue\n";
    assert_eq!(
        notes(list, "0 0 0 1 2 1 3\n"),
        ["m.ply: left out: vertex colours"]
    );
}

#[test]
fn obj_colours() {
    let mesh = load(
        "m.obj",
        "v 0 0 0\nv 1 0 0 0.5 1 0 # red\nv 0 1 0 0 0.25 1 1\nv 1 1 0 1 1\nf 1 2 4 3\n",
    );
    let white = [1.0; 3];
    assert_eq!(
        mesh.columns.colors,
        [white, [0.5, 1.0, 0.0], [0.0, 0.25, 1.0], white]
    );
    assert!(mesh.notes.is_empty() && mesh.cloud.is_none());
    assert!(
        load("m.obj", "v 0 0 0 1\nv 1 0 0 # 1 2 3\nv 0 1 0\nf 1 2 3\n")
            .columns
            .colors
            .is_empty()
    );

    // A position with several normals is several vertices of one colour.
    let corners = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nvn 0 0 1\nvn 1 0 0\n";
    let mesh = load("m.obj", format!("{corners}f 1//1 2//1 3//1\nf 1//2 2//2 3//2\n"));
    let [red, green, blue] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(mesh.columns.colors, [red, green, blue, red, green, blue]);

    let mesh = load(
        "m.obj",
        "v 0 0 0 -1 0.5 2\nv 1 0 0 0 0 0\nv 0 1 0 255 0 0\nf 1 2 3\n",
    );
    assert_eq!(mesh.columns.colors, [[0.0, 0.5, 1.0], [0.0; 3], red]);
    assert_eq!(
        mesh.notes,
        ["m.obj: 2 vertex colours are not from 0 to 1: clamped"]
    );
    let error = try_load("m.obj", "v 0 0 0\nv 1 0 0 0 nan 0\n").expect_err("no colour");
    assert_eq!(error, "m.obj:2:11: green is NaN, expected a finite number");
}

#[test]
fn clouds_of_every_format() {
    let mesh = load("m.obj", "v 0 0 0 1 0 0\nv 2 0 0 0 1 0\np 1 2\nvn 0 0 1\n");
    assert!(mesh.notes.is_empty() && mesh.cloud == Some(Cloud::default()));
    let both = load("m.obj", "v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\np 1\n");
    assert!(both.cloud.is_none());
    assert_eq!(both.notes, ["m.obj: left out: 1 point element"]);

    let header =
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n";
    let list = "property list uchar int vertex_indices\nend_header\n";
    let rows = "0 0 0\n3 0 0\n";
    assert!(
        load("m.ply", format!("{header}end_header\n{rows}"))
            .cloud
            .is_some()
    );
    assert!(
        load("m.ply", format!("{header}element face 0\n{list}{rows}"))
            .cloud
            .is_some()
    );
    // A face without triangles is a face all the same.
    assert!(
        load("m.ply", format!("{header}element face 1\n{list}{rows}2 0 1\n"))
            .cloud
            .is_none()
    );
    let none = header.replace("vertex 2", "vertex 0");
    assert!(load("m.ply", format!("{none}end_header\n")).cloud.is_none());
}

/// Two sets of points, one placed twice and one in the colour of its material.
#[cfg(feature = "gltf")]
#[test]
fn clouds_of_gltf() {
    let text = |modes: [u8; 2]| {
        let [first, second] = modes;
        format!(
            r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}},{{"mesh":0,"translation":[0,5,0]}},{{"mesh":1}}],
"materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[1,0,0,1]}}}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":{first}}}]}},
{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":{second},"material":0}}]}}],
"buffers":[{{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}}],
"bufferViews":[{{"buffer":0,"byteLength":36}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}]}}"#
        )
    };
    let cloud = load("m.gltf", text([0, 0]));
    assert_eq!((&cloud.cloud, cloud.notes.len()), (&Some(Cloud::default()), 0));
    assert_eq!(cloud.columns.y, [0.0, 0.0, 1.0, 5.0, 5.0, 6.0, 0.0, 0.0, 1.0]);
    assert_eq!(cloud.columns.colors[5..7], [[1.0; 3], [1.0, 0.0, 0.0]]);
    assert_eq!(scene(cloud, None).spheres().center_x.len(), 9);
    let mixed = load("m.gltf", text([4, 0]));
    assert_eq!((mixed.cloud, mixed.columns.triangles.len()), (None, 2));
    assert_eq!(mixed.notes, ["m.gltf: left out: 1 set of points"]);
}

fn scene(mesh: LoadedMesh, material: Option<MaterialId>) -> crate::scene::Scene {
    let mut builder = SceneBuilder::new();
    mesh.add_to(&mut builder, material).expect("a scene");
    builder.finish()
}

#[test]
fn clouds_become_spheres() {
    let text = "v 5 0 0 1 0 0\nv 7 0 0 0 1 0\nv 5 3 0 0 0 1\n";
    let made = scene(load("m.obj", text), None);
    let spheres = made.spheres();
    assert_eq!(
        (
            made.primitive_count(),
            spheres.radius.len(),
            made.vertices().x.len()
        ),
        (3, 3, 0)
    );
    assert_eq!(spheres.radius, [1.3; 3]);
    assert_eq!(spheres.color, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    assert_eq!(spheres.center(1) + made.origin(), Vec3::new(7.0, 0.0, 0.0));
    assert_eq!(
        made.materials()[spheres.material[0].0 as usize],
        Surface::WHITE.material()
    );

    let mut mesh = load("m.obj", text);
    mesh.cloud = Some(Cloud {
        radius: Some(0.25),
        lines: Vec::new(),
    });
    let made = scene(mesh, Some(MaterialId(1)));
    assert_eq!(made.spheres().radius, [0.25; 3]);
    assert!(!made.has_colors());
    assert_eq!(made.spheres().material, [MaterialId(1); 3]);

    let grey = scene(load("m.obj", "v 0 0 0\n"), None);
    assert_eq!(grey.materials()[4], Surface::NEUTRAL.material());
}

#[test]
fn colours_have_a_white_surface_unless_a_material_is_given() {
    let text = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n";
    let own = scene(load("m.obj", text), None);
    assert_eq!(own.vertices().colors.len(), 3);
    assert_eq!(
        own.materials()[own.triangles().material[0].0 as usize],
        Surface::WHITE.material()
    );
    let given = scene(load("m.obj", text), Some(MaterialId(1)));
    assert!(!given.has_colors());
}

/// A triangle with colours of the type `component` in the bytes of `colors`, 12 bytes apart.
#[cfg(feature = "gltf")]
fn gltf(component: u32, kind: &str, colors: &[u8], more: &str) -> String {
    use base64::{Engine, prelude::BASE64_STANDARD};
    let positions = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut bytes: Vec<u8> = positions.iter().flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend(colors);
    let (length, rest) = (bytes.len(), colors.len());
    let data = BASE64_STANDARD.encode(bytes);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":
        {{"POSITION":0,"COLOR_0":1}}{more}}}]}}],"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
        {{"bufferView":1,"componentType":{component},"count":3,"type":"{kind}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":{rest},"byteStride":16}}],
        "buffers":[{{"byteLength":{length},"uri":"data:application/octet-stream;base64,{data}"}}]}}"#
    )
}

#[test]
#[cfg(feature = "gltf")]
fn gltf_colours_of_every_type() {
    let padded = |color: &[u8]| {
        let mut element = color.to_vec();
        element.resize(16, 0);
        element.repeat(3)
    };
    let floats = |values: [f32; 3]| padded(&values.map(f32::to_le_bytes).concat());
    let shorts = |values: [u16; 4]| padded(&values.map(u16::to_le_bytes).concat());
    // 0.5 of linear light is shown as 0.735.
    for (component, kind, bytes) in [
        (5121, "VEC3", padded(&[255, 128, 0])),
        (5121, "VEC4", padded(&[255, 128, 0, 7])),
        (5123, "VEC3", shorts([65535, 32768, 0, 0])),
        (5123, "VEC4", shorts([65535, 32768, 0, 9])),
        (5126, "VEC3", floats([1.0, 0.5, 0.0])),
    ] {
        let mesh = load("m.gltf", gltf(component, kind, &bytes, ""));
        assert!(
            mesh.notes.is_empty() && mesh.surfaces.is_empty(),
            "{:?}",
            mesh.notes
        );
        for [red, green, blue] in &mesh.columns.colors {
            assert!(
                *red == 1.0 && (green - 0.735).abs() < 0.003 && *blue == 0.0,
                "{kind} {green}"
            );
        }
        assert_eq!(mesh.columns.colors.len(), 3);
    }
    let mesh = load("m.gltf", gltf(5126, "VEC3", &floats([2.0, -1.0, 0.0]), ""));
    assert_eq!(mesh.columns.colors, [[1.0, 0.0, 0.0]; 3]);
    assert_eq!(
        mesh.notes,
        ["m.gltf: 3 vertex colours are not from 0 to 1: clamped"]
    );
    let refused = |json: String| try_load("m.gltf", json).expect_err("no colours");
    let nan = floats([0.0, f32::NAN, 0.0]);
    assert_eq!(
        refused(gltf(5126, "VEC3", &nan, "")),
        "m.gltf: accessors[1]: colour 1 of 3: green is NaN, expected a finite number"
    );
    let kind = "m.gltf: accessors[1] holds other elements, expected colours (3 or 4 bytes, unsigned shorts or floats)";
    assert_eq!(refused(gltf(5126, "VEC2", &nan, "")), kind);
    assert_eq!(refused(gltf(5120, "VEC3", &nan, "")), kind);
    let few = gltf(5126, "VEC3", &nan, "").replacen(
        r#""count":3,"type":"VEC3"}]"#,
        r#""count":2,"type":"VEC3"}]"#,
        1,
    );
    assert_eq!(
        refused(few),
        "m.gltf: accessors[1] has 2 colours, but the primitive has 3 vertices"
    );
    // A material multiplies the colours.
    let json = gltf(5121, "VEC3", &padded(&[255, 0, 0]), r#","material":0"#);
    let json = json.replacen(
        r#""accessors""#,
        r#""materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0,1,1,1]}}],"accessors""#,
        1,
    );
    let mesh = load("m.gltf", json);
    assert_eq!(
        (mesh.surfaces[0].diffuse, mesh.columns.colors[0]),
        ([0.0, 1.0, 1.0], [1.0, 0.0, 0.0])
    );
}

#[test]
fn ply_alpha_matters_where_it_is_less_than_1() {
    for format in ["binary_little_endian", "binary_big_endian"] {
        for (last, expected) in [
            (255, &[][..]),
            (254, &["m.ply: left out: vertex alpha".to_owned()]),
        ] {
            let mut bytes = format!(
                "ply\nformat {format} 1.0\nelement vertex 3\nproperty uchar red\nproperty uchar green\n\
                 property uchar blue\nproperty uchar alpha\nproperty char x\nproperty char y\nproperty char z\nend_header\n"
            )
            .into_bytes();
            for (alpha, x) in [(255, 0), (255, 1), (last, 2)] {
                bytes.extend([9, 9, 9, alpha, x, 0, 0]);
            }
            assert_eq!(load("m.ply", bytes).notes, expected);
        }
    }
}
