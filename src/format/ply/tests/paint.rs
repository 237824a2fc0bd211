//! Textures and colours of faces.

use super::*;
use crate::format::mesh::Surface;

/// A picture of one pixel.
const PIXEL: &[u8] =
    b"\x42\x4d\x3a\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x01\0\0\0\x01\0\0\0\x01\0\x18\0\0\0\0\0\x04\0\0\0\
    \0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x10\x20\xff\0";

/// Reads a mesh whose images have one pixel; returns it and the images that it asked for.
fn shown(bytes: impl AsRef<[u8]>) -> (LoadedMesh, Vec<PathBuf>) {
    let mut asked = Vec::new();
    let open = &mut |path: &Path| {
        asked.push(path.to_path_buf());
        Ok(PIXEL.to_vec())
    };
    let mesh = parse_mesh(
        bytes.as_ref(),
        Path::new("m.ply"),
        Some(open),
        &Budget::unlimited(),
    );
    let mesh = mesh.unwrap_or_else(|error| panic!("{}", error.report()));
    (mesh, asked)
}

/// A text as binary: every word becomes the next of the types that its line has.
fn binary(text: &str, types: &[(usize, &[&str])], big_endian: bool) -> Vec<u8> {
    let (head, body) = text.split_once("end_header\n").expect("a header");
    let format = if big_endian {
        "binary_big_endian"
    } else {
        "binary_little_endian"
    };
    let mut bytes = format!("{}end_header\n", head.replace("ascii", format)).into_bytes();
    let mut lines = body.lines();
    for &(count, types) in types {
        for line in lines.by_ref().take(count) {
            for (word, kind) in line.split(' ').zip(types.iter().cycle()) {
                let number: f64 = word.parse().expect("a number");
                let mut number = match *kind {
                    "uchar" => vec![number as u8],
                    "int" => (number as i32).to_le_bytes().to_vec(),
                    _ => (number as f32).to_le_bytes().to_vec(),
                };
                if big_endian {
                    number.reverse();
                }
                bytes.extend(number);
            }
        }
    }
    bytes
}

const FIVE: &str = "ply\nformat ascii 1.0\ncomment TextureFile a b.png\ncomment texturefile \"sub\\c.png\"\n\
    element vertex 5\nproperty float x\nproperty float y\nproperty float z\n";
const POINTS: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 2 0\n";

#[test]
fn coordinates_of_corners() {
    let text = format!(
        "{FIVE}element face 3\nproperty list uchar float texcoord\nproperty list uchar int vertex_indices\n\
         property int texnumber\nend_header\n{POINTS}\
         6 0 0 1 0 1 1 3 0 1 2 1\n6 0 0 1 1 0.5 1 3 0 2 3 0\n6 0.25 0 1 1 0 1 3 0 2 4 1\n"
    );
    let types: [(usize, &[&str]); 2] = [
        (5, &["float"]),
        (
            3,
            &[
                "uchar", "float", "float", "float", "float", "float", "float", "uchar", "int", "int", "int",
                "int",
            ],
        ),
    ];
    let expected = shown(&text);
    for big_endian in [false, true] {
        let other = shown(binary(&text, &types, big_endian));
        assert_eq!(format!("{other:?}"), format!("{expected:?}"));
    }
    let (mesh, asked) = expected;
    // The first two faces agree at vertices 0 and 2; the third one does not at vertex 0.
    assert_eq!(mesh.columns.triangles, [[0, 1, 2], [0, 2, 3], [5, 2, 4]]);
    assert_eq!(
        mesh.columns.uvs,
        [
            [0.0, 1.0],
            [1.0, 1.0],
            [1.0, 0.0],
            [0.5, 0.0],
            [0.0, 0.0],
            [0.25, 1.0]
        ]
    );
    assert_eq!(mesh.columns.x, [0.0, 1.0, 1.0, 0.0, 2.0, 0.0]);
    let files = [Path::new("sub/c.png"), Path::new("a b.png")];
    assert!(asked.len() == 2 && files.iter().all(|file| asked.contains(&file.to_path_buf())));
    assert_eq!(mesh.texture_files, [files[1], files[0]]);
    let image = |i: usize| {
        mesh.surfaces[mesh.surface_of[i] as usize]
            .textures
            .base
            .expect("an image")
            .image
    };
    assert_eq!([image(0), image(1), image(2)], [1, 0, 1]);
    assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
}

#[test]
fn a_polygon_keeps_its_coordinates() {
    // An arrowhead, which a fan around its first corner does not fill.
    let text = format!(
        "{FIVE}element face 1\nproperty list uchar int vertex_index\nproperty list uchar float texcoord\nend_header\n\
         -1 0 0\n0 1 0\n1 0 0\n0 2 0\n9 9 9\n4 0 1 2 3 8 -1 0 0 1 1 0 0 2\n"
    );
    let (mesh, _) = shown(text);
    let columns = mesh.columns;
    assert_eq!(columns.triangles.len(), 2);
    assert!(
        columns
            .triangles
            .iter()
            .all(|triangle| triangle.contains(&1) && triangle.contains(&3))
    );
    for corner in columns.triangles.as_flattened() {
        let i = *corner as usize;
        assert_eq!(columns.uvs[i], [columns.x[i], 1.0 - columns.y[i]]);
    }
}

#[test]
fn coordinates_of_vertices() {
    for names in [
        ["s", "t"],
        ["u", "v"],
        ["texture_u", "texture_v"],
        ["texture_s", "texture_t"],
    ] {
        let text = format!(
            "{FIVE}property float {}\nproperty float {}\nelement face 1\nproperty list uchar int vertex_index\n\
             end_header\n0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 0.5\n0 1 0 0 1\n2 2 0 1 1\n5 0 1 4 2 3\n",
            names[0], names[1]
        );
        let types: [(usize, &[&str]); 2] = [
            (5, &["float"]),
            (1, &["uchar", "int", "int", "int", "int", "int"]),
        ];
        let expected = shown(&text);
        for big_endian in [false, true] {
            let other = shown(binary(&text, &types, big_endian));
            assert_eq!(format!("{other:?}"), format!("{expected:?}"));
        }
        let (mesh, asked) = expected;
        assert_eq!(
            mesh.columns.uvs,
            [[0.0, 1.0], [1.0, 1.0], [1.0, 0.5], [0.0, 0.0], [1.0, 0.0]]
        );
        assert_eq!(asked, [Path::new("a b.png")]);
        assert_eq!(mesh.surface_of, [0; 3]);
        assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
        // Without an image all is as if there were no coordinates.
        let mesh = loaded(&text, true).expect("a mesh");
        assert!(mesh.columns.uvs.is_empty() && mesh.images.is_empty());
        assert_eq!(mesh.surfaces, [Surface::NEUTRAL]);
        assert_eq!(
            mesh.notes,
            ["m.ply: texture a b.png is not shown: file not found"]
        );
        let mesh = loaded(&text, false).expect("a mesh");
        assert_eq!(mesh.notes, ["m.ply: left out: texture coordinates, textures"]);
        assert!(mesh.columns.uvs.is_empty() && mesh.surfaces.is_empty() && mesh.texture_files.len() == 2);
    }
}

#[test]
fn faces_that_lack_a_texture() {
    let text = format!(
        "{FIVE}element face 7\nproperty list uchar int vertex_index\nproperty list uchar float texcoord\n\
         property float texnumber\nend_header\n{POINTS}3 0 1 2 6 0 0 nan 0 1 inf 0\n3 0 1 2 0 0\n4 0 1 2 3 6 0 0 0 0 0 0 1\n\
         3 0 1 2 7 0 0 0 0 0 0 0 1\n3 0 1 2 6 0 0 -nan(ind) 0 0 0 2\n3 0 1 2 6 0 0 0 0 0 0 -1\n3 0 1 2 6 0 0 0 0 0 0 0.5\n"
    );
    let (mesh, _) = shown(&text);
    assert_eq!(mesh.surface_of, [0, 1, 1, 1, 1, 1, 1, 1]);
    assert_eq!(mesh.surfaces[1], Surface::NEUTRAL);
    assert_eq!(mesh.columns.uvs[..3], [[0.0, 1.0], [0.0; 2], [0.0; 2]]);
    assert_eq!(
        mesh.notes,
        [
            "m.ply: left out: 3 texture coordinates that are NaN or too large",
            "m.ply: 4 triangles have no texture coordinates: shown without texture",
            "m.ply: 3 faces have a `texnumber` that is not from 0 to 1: shown without texture",
        ]
    );
    assert!(parse_mesh(text.as_bytes(), Path::new("m.ply"), None, &Budget::unlimited()).is_ok());
    let cut = text.trim_end().trim_end_matches(" 0.5");
    assert!(fault(cut).contains("the file ends inside face 7 of 7, expected `texnumber`"));
    let long = text.replace("6 0 0 nan", "999 0 0 nan");
    assert!(fault(long).contains("`texcoord` of face 1 of 7 is a list of 999 values"));
}

#[test]
fn colors_of_faces() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element tristrips 1\nproperty list int int vertex_indices\n\
        element face 4\nproperty list uchar int vertex_index\nproperty KIND red\nproperty KIND green\nproperty KIND blue\n\
        property uchar alpha\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let faces = |kind: &str, full: &str| {
        let lines =
            format!("3 0 1 2 {full} 0 0 9\n3 2 1 0 0 {full} 0 9\n2 0 1 0 0 {full} 9\n3 0 1 2 {full} 0 0 9\n");
        loaded(text.replace("KIND", kind) + &lines, true).expect("a mesh")
    };
    for (kind, full) in [
        ("uchar", "255"),
        ("float", "1"),
        ("ushort", "65535"),
        ("double", "1.0"),
    ] {
        let mesh = faces(kind, full);
        let colors: Vec<[f32; 3]> = mesh.surfaces.iter().map(|surface| surface.diffuse).collect();
        assert_eq!(
            colors,
            [Surface::NEUTRAL.diffuse, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        );
        assert_eq!(mesh.surface_of, [0, 1, 2, 1]);
        assert_eq!(
            mesh.notes,
            ["m.ply: left out: face alpha, 1 face with fewer than 3 corners"]
        );
        let opaque = text.replace("uchar alpha", "double alpha").replace("KIND", kind);
        let lines = format!("3 0 1 2 {full} 0 0 1\n").repeat(4);
        assert!(loaded(opaque + &lines, true).expect("a mesh").notes.is_empty());
    }
    let notes = faces("float", "2").notes;
    assert_eq!(notes[1..], ["m.ply: 3 face colours are not from 0 to 1: clamped"]);
    let red = text.replace("KIND", "float")
        + "3 0 1 2 nan 0 0 9\n3 0 1 2 0 0 0 9\n3 0 1 2 0 0 0 9\n3 0 1 2 0 0 0 9\n";
    assert_eq!(
        fault(&red),
        "20:9: face 1 of 4: red is NaN, expected a finite number"
    );
    assert_eq!(
        loaded(&red, false).expect("a mesh").notes,
        ["m.ply: left out: face colours"]
    );
    // Colours of vertices go before.
    let both = text.replace("KIND", "uchar").replacen(
        "z\n",
        "z\nproperty uchar r\nproperty uchar g\nproperty uchar b\n",
        1,
    );
    let both = both.replace(" 0\n1 0 0\n0 1 0\n", " 0 9 9 9\n1 0 0 9 9 9\n0 1 0 9 9 9\n");
    let mesh = loaded(both + &"3 0 1 2 1 1 1 1\n".repeat(4), true).expect("a mesh");
    assert!(mesh.surfaces.is_empty() && mesh.columns.colors.len() == 3);
    assert_eq!(mesh.notes, ["m.ply: left out: face colours"]);
}
