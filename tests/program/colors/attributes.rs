//! Numbers of glTF and VTK files as colours.

use super::{GREY, VIRIDIS, assert_near, shown};
use crate::program::{Folder, assert_contains};
use base64::{Engine, prelude::BASE64_STANDARD};
use std::{fs, path::Path};

/// Three triangles with the numbers 0, 1 and 3 for their vertices, under two names; the third primitive has none.
fn triangles() -> String {
    let mut bytes: Vec<u8> = Vec::new();
    for left in [0.0_f32, 2.0, 4.0] {
        let corners = [left, 0.0, 0.0, left + 1.0, 0.0, 0.0, left + 0.5, 1.0, 0.0];
        bytes.extend(corners.iter().flat_map(|number| number.to_le_bytes()));
    }
    bytes.extend([[0_u8; 3], [1; 3], [3; 3]].as_flattened());
    let uri = BASE64_STANDARD.encode(&bytes);
    let accessor = |i: usize| {
        format!(
            r#"{{"bufferView":0,"byteOffset":{},"componentType":5126,"count":3,"type":"VEC3"}},
            {{"bufferView":1,"byteOffset":{},"componentType":5121,"count":3,"type":"SCALAR"}}"#,
            36 * i,
            3 * i
        )
    };
    let primitive = |i: usize| {
        format!(
            r#"{{"attributes":{{"POSITION":{0},"_HEAT":{1},"_OTHER":{1},"_VECTOR":{0}}}}}"#,
            2 * i,
            2 * i + 1
        )
    };
    format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{},{},{}]}}],
        "accessors":[{},{},{}],
        "bufferViews":[{{"buffer":0,"byteLength":108}},{{"buffer":0,"byteOffset":108,"byteLength":9}}],
        "buffers":[{{"byteLength":117,"uri":"data:;base64,{uri}"}}]}}"#,
        primitive(0),
        primitive(1),
        primitive(2),
        accessor(0),
        accessor(1),
        accessor(2)
    )
}

#[test]
fn attributes_of_gltf_are_colours() {
    let folder = Folder::new();
    let text = triangles();
    folder.write("a.gltf", &text);
    let [first, _, last] = VIRIDIS;
    let found = shown(&folder, "a.gltf --color-by _HEAT");
    assert_near([found[0], found[2], first], [first, last, first], "glTF");
    let range = shown(&folder, "a.gltf --color-by _HEAT --color-range 0,1");
    assert_near(range, [first, last, last], "a range");
    // A primitive without the numbers.
    let without = text.replacen(r#""_HEAT":3"#, r#""_COLD":3"#, 1);
    folder.write("b.gltf", &without);
    let found = shown(&folder, "b.gltf --color-by _HEAT");
    assert_near(found, [first, GREY, last], "a part");
    let info = folder.run_line("info a.gltf");
    assert_contains(
        info.succeeded().text(),
        &[
            "scalar             \"_HEAT\" of vertices, 0 to 3\n",
            "scalar             \"_OTHER\" of vertices, 0 to 3\n",
        ],
    );
    // Zeros that are not stored, for more vertices than there are.
    let huge = r#",{"componentType":5126,"count":1000000000000000000,"type":"SCALAR"}],
        "bufferViews""#;
    let text_of_huge = text.replacen(r#""_OTHER":1"#, r#""_HUGE":6"#, 1);
    folder.write(
        "d.gltf",
        &text_of_huge.replace("],\n        \"bufferViews\"", huge),
    );
    let info = folder.run_line("info d.gltf");
    let listed = info.succeeded().text();
    assert!(listed.contains("_OTHER") && !listed.contains("_HUGE"), "{listed}");
    for (file, name, words) in [
        (
            "a.gltf",
            "_heat",
            "the file has `_HEAT`, `_OTHER` of vertices; x, y",
        ),
        (
            "a.gltf",
            "HEAT",
            "no scalar property `HEAT`: the file has `_HEAT`",
        ),
        ("a.gltf", "POSITION", "no scalar property `POSITION`"),
        (
            "a.gltf",
            "_VECTOR",
            "`_VECTOR` of vertices is a vector, expected one number",
        ),
    ] {
        folder.fails(&[file, "--color-by", name], 2, words);
    }
    folder.write(
        "c.gltf",
        &text.replace(r#""count":3,"type":"SCALAR""#, r#""count":2,"type":"SCALAR""#),
    );
    let words = "accessors[1] has 2 numbers, but the primitive has 3 vertices";
    folder.fails(&["c.gltf", "--color-by", "_HEAT"], 1, words);
    folder.run_line("c.gltf -s 8x8 -q").succeeded();
}

/// Numbers that Draco has compressed: texture coordinates under another name.
#[test]
fn attributes_may_be_compressed() {
    let folder = Folder::new();
    let seed = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/gltf/draco.glb");
    // Not in the package.
    let Ok(glb) = fs::read(seed) else { return };
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let (json, rest) = glb[20..].split_at(length);
    let json = std::str::from_utf8(json).unwrap().trim_end();
    for (name, id) in [("a.glb", r#""_U":2,"#), ("b.glb", "")] {
        let mut json = json
            .replace(r#""POSITION":1,"#, r#""_U":5,"POSITION":1,"#)
            .replace(r#""POSITION":0,"#, &format!(r#"{id}"POSITION":0,"#))
            .replace(
                r#""count":42,"type":"VEC4"}]"#,
                r#""count":42,"type":"VEC4"},{"componentType":5126,"count":42,"type":"SCALAR"}]"#,
            );
        json += &" ".repeat(json.len().next_multiple_of(4) - json.len());
        let size = |bytes: usize| (bytes as u32).to_le_bytes();
        let whole = [
            &glb[..8],
            &size(20 + json.len() + rest.len()),
            &size(json.len()),
            b"JSON",
            json.as_bytes(),
            rest,
        ];
        fs::write(folder.path(name), whole.concat()).unwrap();
    }
    let info = folder.run_line("info a.glb");
    assert_contains(info.succeeded().text(), &["\"_U\" of vertices, 0 to 1\n"]);
    let picture = |options: &str| {
        folder
            .run_line(&format!("a.glb -s 16x16 -q -o a.ppm {options}"))
            .succeeded();
        fs::read(folder.path("a.ppm")).unwrap()
    };
    assert!(picture("--color-by _U") != picture("--color-by _U --color-range 1,0"));
    // Announced, but not there.
    folder.run_line("info b.glb").succeeded();
    folder.fails(&["b.glb", "--color-by", "_U"], 1, "has no _U");
}

/// Numbers of VTK files, of points and of cells, give the pictures of the same PLY file.
#[test]
fn numbers_of_vtk_files() {
    let folder = Folder::new();
    let points = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    folder.write(
        "a.vtk",
        &format!(
            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n{points}POLYGONS 2 8\n3 0 1 2\n3 0 2 3\n\
             POINT_DATA 4\nSCALARS heat float\nLOOKUP_TABLE default\n0 1 2 3\nCELL_DATA 2\nSCALARS id int\nLOOKUP_TABLE default\n5 7\n"
        ),
    );
    let numbered: String = (0..)
        .zip(points.lines())
        .map(|(i, point)| format!("{point} {i}\n"))
        .collect();
    folder.write(
        "a.ply",
        &format!(
            "ply\nformat ascii 1.0\ncomment up z\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
             property float heat\nelement face 2\nproperty list uchar int vertex_indices\nproperty int id\nend_header\n\
             {numbered}3 0 1 2 5\n3 0 2 3 7\n"
        ),
    );
    for options in ["--color-by heat", "--color-by id", ""] {
        let picture = |mesh: &str| {
            let line = format!("{mesh} -s 24x24 -q -o a.ppm --from top {options}");
            folder.run_line(&line).succeeded();
            fs::read(folder.path("a.ppm")).unwrap()
        };
        assert!(picture("a.vtk") == picture("a.ply"), "{options}");
    }
    let info = folder.run_line("info a.vtk").stdout;
    let info = String::from_utf8_lossy(&info);
    assert_contains(
        &info,
        &["\"heat\" of vertices, 0 to 3", "\"id\" of faces, 5 to 7"],
    );
}
