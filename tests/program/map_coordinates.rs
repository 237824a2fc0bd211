//! Meshes in coordinates of a map: pictures, options and outputs are those of the same mesh around 0.

#[path = "../library/targets/archive.rs"]
mod archive;

use crate::program::{Folder, assert_contains};
use std::{fmt::Write as _, fs};

const SMALL: &str = "--size=64x48";
/// Metres east and north in a zone of UTM, and above the sea.
const FAR: [f64; 3] = [500_000.0, 4_000_000.0, 300.0];

/// A ball with bumps, symmetric, in steps of a 1024th, which are exact in `f64` everywhere and in `f32` only near 0.
struct Ball {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
}

impl Ball {
    fn at(center: [f64; 3]) -> Self {
        const ROWS: usize = 12;
        const ROUND: usize = 2 * ROWS;
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        let step = std::f64::consts::PI / ROWS as f64;
        for row in 0..=ROWS {
            let (out, height) = (step * row as f64).sin_cos();
            for i in 0..ROUND {
                let (sin, cos) = (step * i as f64).sin_cos();
                let radius = 1.0 + 0.05 * (6.0 * step * i as f64).sin() * out * out;
                let point = [out * cos, out * sin, height].map(|x| (radius * x * 1024.0).round() / 1024.0);
                vertices.push([0, 1, 2].map(|axis| center[axis] + point[axis]));
            }
        }
        for row in 0..ROWS {
            for i in 0..ROUND {
                let at = |row: usize, i: usize| row * ROUND + i % ROUND;
                let [a, b, c, d] = [at(row, i), at(row + 1, i), at(row + 1, i + 1), at(row, i + 1)];
                // At the poles a row is one point.
                triangles.extend((row + 1 < ROWS).then_some([a, b, c]));
                triangles.extend((row > 0).then_some([a, c, d]));
            }
        }
        Self { vertices, triangles }
    }

    /// Lines of the vertices, then of the triangles, whose first index is `first`.
    fn lines(&self, vertex: &str, triangle: &str, first: usize) -> String {
        let mut text = String::new();
        for [x, y, z] in &self.vertices {
            let _ = writeln!(text, "{vertex}{x} {y} {z}");
        }
        for [a, b, c] in self.triangles.iter().map(|t| t.map(|i| i + first)) {
            let _ = writeln!(text, "{triangle}{a} {b} {c}");
        }
        text
    }

    fn obj(&self) -> Vec<u8> {
        self.lines("v ", "f ", 1).into()
    }

    fn off(&self) -> Vec<u8> {
        let counts = format!("OFF\n{} {} 0\n", self.vertices.len(), self.triangles.len());
        (counts + &self.lines("", "3 ", 0)).into()
    }

    fn ply_header(&self, format: &str, scalar: &str) -> String {
        format!(
            "ply\nformat {format} 1.0\nelement vertex {}\nproperty {scalar} x\nproperty {scalar} y\nproperty {scalar} z\n\
             element face {}\nproperty list uchar int vertex_indices\nend_header\n",
            self.vertices.len(),
            self.triangles.len()
        )
    }

    fn text_ply(&self) -> Vec<u8> {
        (self.ply_header("ascii", "double") + &self.lines("", "3 ", 0)).into()
    }

    fn binary_ply(&self, scalar: &str) -> Vec<u8> {
        let mut bytes = self.ply_header("binary_big_endian", scalar).into_bytes();
        for &value in self.vertices.as_flattened() {
            match scalar {
                "double" => bytes.extend(value.to_be_bytes()),
                _ => bytes.extend((value as f32).to_be_bytes()),
            }
        }
        for triangle in &self.triangles {
            bytes.push(3);
            bytes.extend(triangle.iter().flat_map(|&i| (i as u32).to_be_bytes()));
        }
        bytes
    }

    fn stl(&self) -> Vec<u8> {
        let mut text = "solid\n".to_owned();
        for triangle in &self.triangles {
            text += "facet normal 0 0 0 outer loop\n";
            for [x, y, z] in triangle.map(|i| self.vertices[i]) {
                let _ = writeln!(text, "vertex {x} {y} {z}");
            }
            text += "endloop endfacet\n";
        }
        (text + "endsolid\n").into()
    }

    /// `transform`: that of the item that is built.
    fn threemf(&self, transform: &str) -> Vec<u8> {
        let mut model = "<model><resources><object id='1'><mesh><vertices>".to_owned();
        for [x, y, z] in &self.vertices {
            let _ = write!(model, "<vertex x='{x}' y='{y}' z='{z}'/>");
        }
        model += "</vertices><triangles>";
        for [a, b, c] in &self.triangles {
            let _ = write!(model, "<triangle v1='{a}' v2='{b}' v3='{c}'/>");
        }
        model += "</triangles></mesh></object></resources><build><item objectid='1'";
        model += transform;
        archive::of_model((model + "/></build></model>").as_bytes())
    }

    /// A node with this translation, as text, places the ball with two small ones, and the bytes of its buffer `a.bin`.
    fn gltf(&self, translation: &str) -> [Vec<u8>; 2] {
        let mut bytes: Vec<u8> = Vec::new();
        for &value in self.vertices.as_flattened() {
            bytes.extend((value as f32).to_le_bytes());
        }
        let positions = bytes.len();
        for &index in self.triangles.as_flattened() {
            bytes.extend((index as u16).to_le_bytes());
        }
        let (vertices, corners, all) = (self.vertices.len(), 3 * self.triangles.len(), bytes.len());
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],
"nodes":[{{"translation":[{translation}],"children":[1,2,3]}},{{"mesh":0}},
{{"mesh":0,"matrix":[0.25,0,0,0, 0,0.25,0,0, 0,0,0.25,0, 1.5,0,0,1]}},
{{"mesh":0,"matrix":[0.25,0,0,0, 0,0.25,0,0, 0,0,0.25,0, -1.5,0,0,1]}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
"buffers":[{{"byteLength":{all},"uri":"a.bin"}}],
"bufferViews":[{{"buffer":0,"byteLength":{positions}}},{{"buffer":0,"byteOffset":{positions},"byteLength":{}}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":{vertices},"type":"VEC3"}},
{{"bufferView":1,"componentType":5123,"count":{corners},"type":"SCALAR"}}]}}"#,
            all - positions
        );
        [json.into_bytes(), bytes]
    }
}

fn write(folder: &Folder, name: &str, bytes: Vec<u8>) {
    fs::write(folder.path(name), bytes).expect("the file is written");
}

fn read(folder: &Folder, name: &str) -> Vec<u8> {
    fs::read(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Renders a mesh and returns the bytes of its picture, and what the program said.
fn picture(folder: &Folder, mesh: &str, options: &[&str]) -> (Vec<u8>, String) {
    let run = folder.run(&[&["render", mesh, SMALL, "-o", "a.png"], options].concat());
    assert_eq!(run.code, Some(0), "{run:?}");
    (read(folder, "a.png"), run.stderr)
}

/// What is said of coarse coordinates.
const COARSE: &str = "rounded to steps";

/// A folder with the ball `near.obj` and `far.obj`.
fn folder() -> Folder {
    let folder = Folder::new();
    write(&folder, "near.obj", Ball::at([0.0; 3]).obj());
    write(&folder, "far.obj", Ball::at(FAR).obj());
    folder
}

#[test]
fn every_format_looks_as_around_0() {
    let folder = folder();
    let (near, far) = (Ball::at([0.0; 3]), Ball::at(FAR));
    let item = format!(" transform='1 0 0 0 1 0 0 0 1 {} {} {}'", FAR[0], FAR[1], FAR[2]);
    let translation = format!("{},{},{}", FAR[0] + 1.0 / 1024.0, FAR[1], FAR[2]);
    let ([near_gltf, buffer], [far_gltf, _]) = (near.gltf("0.0009765625,0,0"), near.gltf(&translation));
    write(&folder, "a.bin", buffer);
    for (name, near, far) in [
        ("a.obj", near.obj(), far.obj()),
        ("a.off", near.off(), far.off()),
        ("text.ply", near.text_ply(), far.text_ply()),
        ("double.ply", near.binary_ply("double"), far.binary_ply("double")),
        ("a.stl", near.stl(), far.stl()),
        ("a.3mf", near.threemf(""), far.threemf("")),
        ("item.3mf", near.threemf(""), near.threemf(&item)),
        ("a.gltf", near_gltf, far_gltf),
    ] {
        write(&folder, name, near);
        let (expected, said) = picture(&folder, name, &[]);
        assert!(!said.contains(COARSE), "{name}: {said}");
        write(&folder, name, far);
        let (found, said) = picture(&folder, name, &[]);
        assert!(!said.contains(COARSE), "{name}: {said}");
        assert!(found == expected, "{name} looks different far from 0");
    }
}

/// A file whose coordinates are `f32`, or were rounded to it by the program that wrote it, looks as it always did.
#[test]
fn coordinates_that_are_lost_are_warned_of() {
    let folder = folder();
    let mut far = Ball::at(FAR);
    write(&folder, "float.ply", far.binary_ply("float"));
    let (expected, said) = picture(&folder, "float.ply", &[]);
    assert_contains(
        &said,
        &[
            "float.ply: its coordinates go up to 4000001, where they are",
            COARSE,
        ],
    );
    let (fine, _) = picture(&folder, "far.obj", &[]);
    assert!(fine != expected);
    for value in far.vertices.as_flattened_mut() {
        *value = f64::from(*value as f32);
    }
    for (name, bytes) in [
        ("rounded.ply", far.text_ply()),
        ("rounded64.ply", far.binary_ply("double")),
    ] {
        write(&folder, name, bytes);
        let (found, said) = picture(&folder, name, &[]);
        assert_contains(&said, &[name, COARSE]);
        assert!(found == expected, "{name}");
        for line in [format!("info {name}"), format!("info {name} --json -")] {
            let run = folder.run_line(&line);
            run.succeeded();
            assert_contains(&String::from_utf8_lossy(&run.stdout), &[name, COARSE]);
        }
    }
    let fine = folder.run_line("info far.obj");
    assert!(!String::from_utf8_lossy(&fine.stdout).contains(COARSE));
    // Coordinates of a scene are `f32`.
    let scene = |mesh: &str| {
        let text = format!(
            "camera eye 500004 4000003 302 target 500000 4000000 300\nlight 500009 4000009 309 1\nmaterial 1\nmesh {mesh}\n"
        );
        folder.write("a.scn", &text);
        picture(&folder, "a.scn", &[]).0
    };
    write(&folder, "far.ply", Ball::at(FAR).text_ply());
    assert!(scene("far.ply") == scene("float.ply"));
}

/// A mesh in millimetres some metres from 0 is ordinary: whatever its file, it is rounded to `f32` as it is.
#[test]
fn ordinary_meshes_are_not_moved() {
    let folder = Folder::new();
    let mut ball = Ball::at([5000.0, 5000.0, 1200.0]);
    for value in ball.vertices.as_flattened_mut() {
        // Finer than `f32`.
        *value += 0.000_01;
    }
    for vertex in &mut ball.vertices[..3] {
        vertex[0] += 5.0;
    }
    write(&folder, "float.ply", ball.binary_ply("float"));
    write(&folder, "text.ply", ball.text_ply());
    write(&folder, "double.ply", ball.binary_ply("double"));
    let (expected, _) = picture(&folder, "float.ply", &[]);
    for name in ["text.ply", "double.ply"] {
        assert!(picture(&folder, name, &[]).0 == expected, "{name}");
    }
}

#[test]
fn options_are_in_the_coordinates_of_the_file() {
    let folder = folder();
    for (near, far) in [
        (
            &["--eye=5,3,2.5", "--target=0.25,0,0"][..],
            &["--eye=500005,4000003,302.5", "--target=500000.25,4000000,300"][..],
        ),
        (&["--target=0.25,0,0"], &["--target=500000.25,4000000,300"]),
        (&["--ground", "--style=plain"], &["--ground", "--style=plain"]),
        (&["--from=10,80", "--ortho=fit"], &["--from=10,80", "--ortho=fit"]),
    ] {
        let (expected, found) = (
            picture(&folder, "near.obj", near),
            picture(&folder, "far.obj", far),
        );
        assert!(found.0 == expected.0, "{far:?}");
        assert_eq!(found.1.replace("far", "near"), expected.1);
    }
    // From below the ground, with y up.
    let below = [
        "--ground",
        "--eye=500004,3999990,300",
        "--target=500000,4000000,300",
    ];
    assert_contains(
        &picture(&folder, "far.obj", &below).1,
        &["the camera is below the ground"],
    );
    // From a pipe.
    let piped = folder.shell("cat far.obj | \"$0\" render - --size=64x48 -o piped.png");
    piped.succeeded();
    assert!(read(&folder, "piped.png") == picture(&folder, "near.obj", &[]).0);
    // Each mesh of a sheet has its own offset.
    let [expected, found] = ["near", "far"].map(|which| {
        fs::create_dir(folder.path(which)).expect("a folder");
        let ball = format!("{which}/ball.obj");
        write(&folder, &ball, read(&folder, &format!("{which}.obj")));
        let sheet = [
            "render",
            "near.obj",
            &ball,
            "--size=32x32",
            "--sheet=2",
            "-o",
            "sheet.png",
            "--quiet",
        ];
        folder.run(&sheet).succeeded();
        read(&folder, "sheet.png")
    });
    assert!(expected == found);
    // Depth is shown in proportion to the bounds.
    let depth = |mesh: &str| {
        picture(&folder, mesh, &["--aov=depth"]);
        read(&folder, "a.depth.png")
    };
    assert!(depth("far.obj") == depth("near.obj"));
}

#[test]
fn saved_poses_are_in_the_coordinates_of_the_file() {
    let folder = folder();
    let eyes = |mesh: &str| {
        let arguments = [
            mesh,
            SMALL,
            "--turntable=2",
            "-o",
            "t#.png",
            "--save-poses=poses.json",
        ];
        folder.run(&arguments).succeeded();
        let json: serde_json::Value = serde_json::from_slice(&read(&folder, "poses.json")).expect("JSON");
        [0, 1].map(|frame| {
            let matrix = &json["frames"][frame]["transform_matrix"];
            [0, 1, 2].map(|axis| matrix[axis][3].as_f64().expect("a number"))
        })
    };
    let (near, far) = (eyes("near.obj"), eyes("far.obj"));
    for (near, far) in near.iter().zip(&far) {
        for axis in 0..3 {
            assert!(
                (far[axis] - near[axis] - FAR[axis]).abs() < 1e-8,
                "{far:?} {near:?}"
            );
        }
    }
    let save = ["far.obj", SMALL, "-o", "first.png", "--save-poses=pose.json"];
    folder.run(&save).succeeded();
    let again = ["far.obj", SMALL, "--poses=pose.json", "-o", "again.png"];
    folder.run(&again).succeeded();
    assert!(read(&folder, "first.png") == read(&folder, "again.png"));
}

#[test]
fn info_has_the_bounds_and_cameras_of_the_file() {
    let folder = folder();
    let run = folder.run(&["info", "far.obj", "--json=-"]);
    let json: serde_json::Value = serde_json::from_str(run.succeeded().text()).expect("JSON");
    let corner = |which: &str| {
        let corner = &json["bounds"][which];
        [0, 1, 2].map(|axis| corner[axis].as_f64().expect("a number"))
    };
    let ball = Ball::at(FAR);
    let extreme = |axis: usize, pick: fn(f64, f64) -> f64| {
        ball.vertices
            .iter()
            .map(|vertex| vertex[axis])
            .reduce(pick)
            .expect("vertices")
    };
    for axis in 0..3 {
        for (which, pick) in [("lower", f64::min as fn(f64, f64) -> f64), ("upper", f64::max)] {
            assert!(
                (corner(which)[axis] - extreme(axis, pick)).abs() < 1e-6,
                "{which} {axis}"
            );
        }
    }
    let text = folder.run(&["info", "far.obj"]);
    assert_contains(
        text.succeeded().text(),
        &["bounds, lower      499998.9", "bounds, upper      500001."],
    );
    // Translations of nodes are read as doubles, and so is the position of a camera.
    let [gltf, buffer] = Ball::at([0.0; 3]).gltf("500000.0009765625,4000000,300");
    write(&folder, "a.bin", buffer);
    let gltf = String::from_utf8(gltf).expect("text");
    let camera =
        r#""cameras":[{"type":"perspective","perspective":{"yfov":0.5,"znear":0.1}}],"nodes":[{"camera":0,"#;
    write(
        &folder,
        "a.gltf",
        gltf.replace(r#""nodes":[{""#, &format!("{camera}\"")).into(),
    );
    let text = folder.run(&["info", "a.gltf"]);
    let said = text.succeeded().text();
    assert_contains(
        said,
        &[
            "bounds, lower      499998.247314 3999998.985352 299",
            "eye 500000.000977 4000000 300",
        ],
    );
}
