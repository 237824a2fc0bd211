mod faces;
#[cfg(feature = "textures")]
mod paint;

use super::{
    super::mesh::{MeshFormat, UpAxis, UpSource},
    *,
};
use glam::Vec3;

const SCALARS: [[&str; 2]; 8] = [
    ["char", "int8"],
    ["uchar", "uint8"],
    ["short", "int16"],
    ["ushort", "uint16"],
    ["int", "int32"],
    ["uint", "uint32"],
    ["float", "float32"],
    ["double", "float64"],
];

fn read(bytes: impl AsRef<[u8]>) -> Result<TriangleMesh, LoadError> {
    parse(bytes.as_ref(), Path::new("m.ply"))
}

fn loaded(bytes: impl AsRef<[u8]>, shows_colors: bool) -> Result<LoadedMesh, LoadError> {
    let open = &mut |_: &Path| Err(io::ErrorKind::NotFound.into());
    let open: Option<OpenMesh<'_>> = if shows_colors { Some(open) } else { None };
    parse_mesh(bytes.as_ref(), Path::new("m.ply"), open, &Budget::unlimited())
}

fn mesh(bytes: impl AsRef<[u8]>) -> TriangleMesh {
    read(bytes).unwrap_or_else(|error| panic!("{}", error.report()))
}

fn fault(bytes: impl AsRef<[u8]>) -> String {
    let error = read(bytes).expect_err("must be refused").to_string();
    error.trim_start_matches("m.ply:").to_owned()
}

/// A header of three coordinates and a list, of types that fit.
fn header(format: &str, vertices: usize, faces: usize) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

fn ascii(body: &str, vertices: usize, faces: usize) -> String {
    header("ascii", vertices, faces) + body
}

/// `value` as a binary scalar.
fn scalar(name: &str, value: i8, big_endian: bool) -> Vec<u8> {
    let mut bytes = match name {
        "char" | "int8" | "uchar" | "uint8" => value.to_le_bytes().to_vec(),
        "short" | "int16" | "ushort" | "uint16" => i16::from(value).to_le_bytes().to_vec(),
        "int" | "int32" | "uint" | "uint32" => i32::from(value).to_le_bytes().to_vec(),
        "float" | "float32" => f32::from(value).to_le_bytes().to_vec(),
        _ => f64::from(value).to_le_bytes().to_vec(),
    };
    if big_endian {
        bytes.reverse();
    }
    bytes
}

#[test]
fn every_type_in_every_encoding() {
    for [old, new] in SCALARS {
        for name in [old, new] {
            for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
                let mut bytes = format!(
                    "ply\nformat {format} 1.0\nelement vertex 4\nproperty {name} x\nproperty {name} z\n\
                     property {name} y\nelement face 2\nproperty list {name} {name} vertex_index\nend_header\n"
                )
                .into_bytes();
                let rows: [&[i8]; 6] = [
                    &[0, 1, 2],
                    &[3, 4, 5],
                    &[6, 7, 8],
                    &[9, 10, 11],
                    &[4, 0, 1, 2, 3],
                    &[3, 3, 2, 1],
                ];
                for row in rows {
                    for &value in row {
                        match format {
                            "ascii" => bytes.extend(format!("{value} ").bytes()),
                            _ => bytes.extend(scalar(name, value, format == "binary_big_endian")),
                        }
                    }
                    if format == "ascii" {
                        bytes.push(b'\n');
                    }
                }
                let mesh = mesh(&bytes);
                assert_eq!(mesh.x, [0.0, 3.0, 6.0, 9.0], "{format} {name}");
                assert_eq!(mesh.y, [2.0, 5.0, 8.0, 11.0], "{format} {name}");
                assert_eq!(mesh.z, [1.0, 4.0, 7.0, 10.0], "{format} {name}");
                assert_eq!(
                    mesh.triangles,
                    [[0, 1, 2], [0, 2, 3], [3, 2, 1]],
                    "{format} {name}"
                );
                assert!(mesh.normals.is_empty());
                // Any cut must be noticed in binary, and in text if a number is lost.
                assert!(read(&bytes[..bytes.len() - 3]).is_err(), "{format} {name}");
            }
        }
    }
}

#[test]
fn extras_are_skipped() {
    let text = "ply\r\nformat ascii 1.0\r\ncomment caf\u{e9}\r\nobj_info x\r\nelement material 2\r\n\
        property list uchar float shades\r\nproperty int id\r\nelement nothing 99999999999\r\n\
        element vertex 3\r\nproperty list int int neighbours\r\nproperty float x\r\nproperty float y\r\n\
        property uchar red\r\nproperty float z\r\nproperty float nx\r\nelement face 3\r\n\
        property list uchar float texcoord\r\nproperty list uchar int vertex_indices\r\nproperty int flags\r\n\
        element tail 1\r\nproperty int a\r\nend_header\r\n\r\n\r\n\
        2 .5 .5 7\r\n0 8\r\n\r\n0 0 0 255 0 1\r\n1 9 1 0 255 0 1\r\n0 0 1 255 0 1\r\n\
        0 3 0 1 2 5\r\n1 .5 2 0 1 5\r\n0 0 5\r\n 0";
    let found = mesh(text);
    assert_eq!(found.x, [0.0, 1.0, 0.0]);
    assert_eq!(found.triangles, [[0, 1, 2]]);
    assert!(found.normals.is_empty(), "nx alone is no normal");

    let mut binary = b"ply\nformat binary_little_endian 1.0\ncomment \xff\xfe\nelement a 2\nproperty list uchar short l\n\
        element b 2\nproperty int i\nelement vertex 1\nproperty list uchar short l\nproperty float x\nproperty float y\n\
        property float z\nend_header\n"
        .to_vec();
    binary.extend([1, 9, 9, 0, 1, 1, 1, 1, 2, 2, 2, 2, 1, 9, 9]);
    binary.extend([1.0_f32, 2.0, 3.0].iter().flat_map(|value| value.to_le_bytes()));
    assert_eq!(mesh(binary).z, [3.0]);
}

#[test]
fn what_is_not_read_is_said() {
    let text = "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 1\nproperty float x\n\
        property float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty float s\n\
        property float confidence\nproperty float intensity\nelement face 1\nproperty list uchar int vertex_indices\n\
        property int flags\nelement edge 2\nproperty int a\nelement nothing 0\nproperty int a\nend_header\n\
        0 0 0 1 1 0 1 1\n0 7\n1\n1\n";
    let notes = loaded(text, true).expect("a mesh").notes;
    assert_eq!(
        notes,
        [
            "m.ply: left out: vertex colours, texture coordinates, vertex properties `confidence`, `intensity`, face \
             properties `flags`, 2 `edge` records, textures, 1 face with fewer than 3 corners"
        ]
    );
}

#[test]
fn the_header_may_name_the_up_axis() {
    let with = |comment: &str| {
        let text = ascii("0 0 0\n", 1, 0).replacen("element", &format!("{comment}\nelement"), 1);
        let mesh = loaded(text, true).expect("a mesh");
        (mesh.up, mesh.up_source)
    };
    for (comment, axis) in [
        ("comment up z", UpAxis::Z),
        ("comment  UP   -X ", UpAxis::MinusX),
        ("comment up y", UpAxis::Y),
        (
            "comment made by octray\ncomment up -z\ncomment z is up",
            UpAxis::MinusZ,
        ),
    ] {
        assert_eq!(with(comment), (axis, UpSource::Stated), "{comment}");
    }
    for comment in [
        "comment",
        "comment up",
        "comment up north",
        "comment up z axis",
        "obj_info up z",
    ] {
        assert_eq!(
            with(comment),
            (UpAxis::Y, UpSource::Assumed(MeshFormat::Ply)),
            "{comment}"
        );
    }
}

#[test]
fn normals_need_all_three() {
    let text = "ply\nformat FORMAT 1.0\nelement vertex 1\nproperty float nx\nproperty float x\nproperty float y\n\
        property float z\nproperty float nz\nproperty float ny\nend_header\n";
    let expected = [Vec3::new(1.0, 6.0, 5.0)];
    assert_eq!(
        mesh(text.replace("FORMAT", "ascii") + "1 2 3 4 5 6").normals,
        expected
    );
    for big_endian in [false, true] {
        let format = if big_endian {
            "binary_big_endian"
        } else {
            "binary_little_endian"
        };
        let mut bytes = text.replace("FORMAT", format).into_bytes();
        bytes.extend((1..=6).flat_map(|value| scalar("float", value, big_endian)));
        assert_eq!(mesh(bytes).normals, expected);
    }
}

#[test]
fn empty_meshes() {
    assert_eq!(mesh("ply\nformat ascii 1.0\nend_header").x.len(), 0);
    assert_eq!(mesh(ascii("", 0, 0)).triangles.len(), 0);
    assert_eq!(mesh(ascii("0 0 0\n", 1, 0)).x, [0.0]);
    let no_properties = "ply\nformat ascii 1.0\nelement vertex 0\nelement face 0\nend_header\n";
    assert_eq!(mesh(no_properties).x.len(), 0);
    assert_eq!(mesh(ascii("0 0 0\n0\n1 0\n2 0 0\n", 1, 3)).triangles.len(), 0);
}

#[test]
fn a_double_is_rounded_once() {
    // Just above halfway between two floats; through f64 it would round to even.
    let word = "1.00000005960464477540";
    let text = ascii(&format!("{word} 0 0"), 1, 0).replace("float x", "double x");
    assert_eq!(mesh(text).x, [word.parse::<f32>().expect("a number")]);
}

#[test]
fn indices() {
    let three = "0 0 0\n1 0 0\n0 1 0\n";
    assert_eq!(
        fault(ascii(&format!("\n{three}3 0 1 2\n  3 0 1 3"), 3, 2)),
        "15:3: vertex index 3, but the file has only 3 vertices"
    );
    assert_eq!(
        fault(ascii(&format!("{three}3 0 -1 2"), 3, 1)),
        "13:1: vertex index -1, but the file has only 3 vertices"
    );
    assert_eq!(
        fault(ascii(&format!("{three}3 0 0.5 2"), 3, 1)),
        "13:5: `vertex_indices` of face 1 of 1 is `0.5`, expected a whole number"
    );
    assert_eq!(
        fault(ascii(&format!("{three}-3 0 1 2"), 3, 1)),
        "13:1: `vertex_indices` of face 1 of 1 is a list of -3 values, expected 0 or more"
    );
    assert_eq!(
        fault(ascii(&format!("{three}99 0 1 2"), 3, 1)),
        "13:1: `vertex_indices` of face 1 of 1 is a list of 99 values, but only 6 bytes follow"
    );
    let mut bytes = header("binary_little_endian", 1, 2).into_bytes();
    bytes.extend([0; 12]);
    bytes.extend([0, 3, 0, 0, 0, 0, 0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0]);
    assert_eq!(
        fault(&bytes),
        format!(
            " vertex index -1, but the file has only 1 vertex (face 2 of 2 starts at byte {})",
            bytes.len() - 13
        )
    );
    bytes.truncate(bytes.len() - 1);
    assert!(fault(&bytes).contains("face 2 of 2 is a list of 3 values, but only 11 bytes follow"));
}

#[test]
fn numbers() {
    assert_eq!(
        fault(ascii("0 nan 0\ninf 0 0\n", 2, 0)),
        "10:3: vertex 1 of 2: y is NaN, expected a finite number"
    );
    assert_eq!(
        fault(ascii("0 0 1e999", 1, 0)),
        "10:5: vertex 1 of 1: z is inf, expected a finite number"
    );
    assert_eq!(
        fault(ascii("2e9 0 0", 1, 0)),
        "10:1: vertex 1 of 1: x is 2e9, but numbers above 1e9 are not supported"
    );
    assert_eq!(
        fault(ascii("0 zero 0", 1, 0)),
        "10:3: `y` of vertex 1 of 1 is `zero`, expected a number"
    );
    assert_eq!(
        fault(ascii("0 -nan(ind) 0", 1, 0)),
        "10:3: `y` of vertex 1 of 1 is `-nan(ind)`, expected a number"
    );
    let mut bytes = header("binary_big_endian", 2, 0).into_bytes();
    let start = bytes.len();
    bytes.extend(
        [[1.0, f32::INFINITY, f32::NAN], [f32::NAN, 0.0, 0.0]]
            .iter()
            .flatten()
            .flat_map(|v| v.to_be_bytes()),
    );
    assert_eq!(
        fault(bytes),
        format!(" vertex 1 of 2: y is inf, expected a finite number (the record starts at byte {start})")
    );
}

#[test]
fn records_that_do_not_fit_their_lines() {
    assert_eq!(
        fault(ascii("0 0 0 7\n1 0 0\n", 2, 0)),
        "10:7: found `7` after vertex 1 of 2, expected the end of the line"
    );
    assert_eq!(
        fault(ascii("0 0 0\n1 0\n1 0 0\n1.0 1.0 1.0\n", 4, 0)),
        "11:4: the line ends inside vertex 2 of 4, expected more numbers"
    );
    assert_eq!(
        fault(ascii("0.0 0.0 0.0\n1.0 0.0 0.0\n1 0\n\n", 3, 0)),
        "12:4: the file ends inside vertex 3 of 3, expected `z`"
    );
    assert_eq!(mesh(ascii("0 0\n0\n1\n0\n\n0", 2, 0)).x, [0.0, 1.0]);
}

#[test]
fn counts_beyond_the_file_are_refused_at_once() {
    for count in ["4", "4294967296", "18446744073709551615"] {
        for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
            for element in ["vertex", "face", "other"] {
                let text = format!(
                    "ply\nformat {format} 1.0\nelement {element} {count}\nproperty double x\nproperty double y\n\
                     property list uint int vertex_indices\nproperty double z\nend_header\n0 0 0 0"
                );
                let error = fault(&text);
                assert!(
                    error.starts_with(&format!("3:1: {count} `{element}` records need ")),
                    "{error}"
                );
            }
        }
    }
    let mut list = header("binary_little_endian", 0, 1)
        .replace("uchar int", "uint int")
        .into_bytes();
    list.extend([0xff; 8]);
    assert!(fault(list).contains("a list of 4294967295 values, but only 4 bytes follow"));
}

#[test]
fn a_byte_order_mark_is_skipped() {
    let text = "\u{feff}ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
                end_header\n1 2 3\n";
    assert_eq!(read(text).expect("a mesh").z, [3.0]);
    // Some programs write the first line in capitals.
    let capitals = text.replacen("ply", "PLY", 1);
    assert_eq!(read(capitals).expect("a mesh").z, [3.0]);
}

#[test]
fn headers() {
    assert_eq!(fault(""), " the file is empty, expected a PLY mesh");
    assert_eq!(
        fault("solid x\n"),
        "1:1: not a PLY mesh: found `solid x`, expected `ply`"
    );
    assert_eq!(
        fault("ply\nformat"),
        "2:7: the file ends inside its header, expected `end_header`"
    );
    assert!(
        fault("ply\nend_header\n").starts_with("2:1: missing format specification; expected a `format` line")
    );
    assert!(
        fault("ply\n format text 1.0\nend_header\n")
            .starts_with("2:2: unknown format: text; expected `format ascii")
    );
    let broken = |from: &str, to: &str| fault(ascii("0 0 0\n", 1, 0).replace(from, to));
    assert!(
        broken("float y", "flaot y")
            .starts_with("5:1: unknown scalar type: flaot; expected `property TYPE NAME`")
    );
    assert!(
        broken("vertex 1", "vertex -1")
            .starts_with("3:1: invalid element count: -1; expected `element NAME COUNT`")
    );
    assert!(broken("element vertex 1\n", "").starts_with("3:1: property without element; expected"));
    assert_eq!(
        broken("float z", "float w"),
        "3:1: element `vertex` has no property `z`, expected `x`, `y` and `z`"
    );
    assert_eq!(
        broken("float z", "float y"),
        "6:1: second property `y`, expected one"
    );
    assert_eq!(
        broken("float z", "list int int z"),
        "6:1: `z` is a list, expected a number"
    );
    assert_eq!(
        broken("element face 0", "element vertex 0"),
        "7:1: second element `vertex`, expected one"
    );
    assert_eq!(
        broken("list uchar int", "int"),
        "8:1: `vertex_indices` is a number, expected a list"
    );
    assert_eq!(
        broken(
            "face 0\nproperty list uchar int vertex_indices",
            "face 1\nproperty list int int corners"
        ),
        "7:1: element `face` has no list `vertex_indices` or `vertex_index`, expected one"
    );
    let endless = format!("ply\n{}", "comment x\n".repeat(200_000));
    assert!(fault(endless).contains("the header has more than 1048576 bytes"));
}

/// What is not wanted may be anything.
#[test]
fn colors_that_are_left_out() {
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        property float red\nproperty float green\nproperty float blue\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n";
    let text = format!("{header}0 0 0 1 1 nan\n1 0 0 1 inf 1\n0 1 0 1 1 1\n3 0 1 2\n");
    let read = |keeps| loaded(&text, keeps);
    assert!(read(true).is_err());
    let mesh = read(false).expect("a mesh");
    assert!(mesh.columns.colors.is_empty() && mesh.columns.triangles == [[0, 1, 2]]);
    assert_eq!(mesh.notes, ["m.ply: left out: vertex colours"]);
}
