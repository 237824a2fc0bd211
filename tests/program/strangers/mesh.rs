//! Meshes in OBJ, PLY and STL.

use super::Call;
use crate::program::Folder;
use std::{fmt::Write, fs};

/// `count` points in a cube.
fn vertices(count: usize) -> String {
    let mut random = fastrand::Rng::with_seed(1);
    let mut point = |_| {
        format!(
            "v {} {} {}\n",
            random.u32(..100),
            random.u32(..100),
            random.u32(..100)
        )
    };
    (0..count).map(&mut point).collect()
}

/// A binary PLY of three vertices and these faces, lists of `length` and `uchar`.
fn ply(length: &str, count: usize, faces: &[u8]) -> Vec<u8> {
    let header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty char x\nproperty char y\n\
         property char z\nelement face {count}\nproperty list {length} uchar vertex_indices\nend_header\n"
    );
    [header.as_bytes(), &[0, 0, 0, 1, 0, 0, 0, 1, 0], faces].concat()
}

#[test]
fn many_faces_at_a_vertex() {
    let folder = Folder::new();
    fs::write(
        folder.path("hub.ply"),
        ply("uchar", 12_000, &[3, 0, 1, 2].repeat(12_000)),
    )
    .unwrap();
    let mut text = vertices(101);
    for i in 0..8000 {
        let _ = writeln!(text, "f 1 {} {}", i % 100 + 2, i * 7 % 100 + 2);
    }
    folder.write("hub.obj", &text);
    for name in ["hub.ply", "hub.obj"] {
        let arguments = [name, "--smooth-angle", "30", "--size", "16x16", "--quiet"];
        assert_eq!(Call::new(&folder, &arguments).run().code, Some(0));
    }
    let mut text = vertices(3) + &"vn 0 0 1\n".repeat(50_000);
    (1..=50_000).for_each(|i| _ = writeln!(text, "f 1//{i} 2//1 3//1"));
    folder.write("normals.obj", &text);
    assert_eq!(Call::new(&folder, &["info", "normals.obj"]).run().code, Some(0));
}

#[test]
fn polygons_that_cross_themselves() {
    let folder = Folder::new();
    let mut random = fastrand::Rng::with_seed(2);
    let mut text = vertices(1024);
    while text.len() < 100_000 {
        let mut order: Vec<usize> = (1..=1024).collect();
        random.shuffle(&mut order);
        let words: String = order.iter().map(|corner| format!(" {corner}")).collect();
        let _ = writeln!(text, "f{words}");
    }
    folder.write("polygons.obj", &text);
    assert_eq!(Call::new(&folder, &["info", "polygons.obj"]).run().code, Some(0));
}

#[test]
fn material_libraries() {
    let folder = Folder::new();
    let library: String = (0..20_000).map(|i| format!("newmtl m{i}\nKd 1 0 0\n")).collect();
    folder.write("a.mtl", &library);
    let triangle = vertices(3) + "usemtl m9\nf 1 2 3\n";
    let spellings: String = (0..900)
        .map(|i| format!("mtllib {}a.mtl\n", "./".repeat(i)))
        .collect();
    for (name, lines) in [
        ("line.obj", format!("mtllib{}\n", " a.mtl".repeat(5000))),
        ("lines.obj", "mtllib a.mtl\n".repeat(5000)),
        ("spellings.obj", spellings),
        (
            "missing.obj",
            (0..5000).map(|i| format!("mtllib {i}.mtl\n")).collect(),
        ),
    ] {
        folder.write(name, &(lines + &triangle));
        assert_eq!(Call::new(&folder, &["info", name]).run().code, Some(0));
    }
    let words: String = (0..5000).map(|i| format!(" {i}.mtl")).collect();
    folder.write("many.obj", &format!("mtllib{words}\n{triangle}"));
    Call::new(&folder, &["info", "many.obj"]).refused("more than 1024 material libraries");
}

#[test]
fn meshes_above_the_memory_limit() {
    let folder = Folder::new();
    let corners = [&4_500_000_u32.to_le_bytes()[..], &[0, 1, 2].repeat(1_500_000)].concat();
    fs::write(folder.path("face.ply"), ply("uint", 1, &corners)).unwrap();
    folder.write("face.obj", &(vertices(3) + "f" + &" 1 2".repeat(1_250_000)));
    folder.write("faces.obj", &(vertices(3) + &"f 1 2 3\n".repeat(750_000)));
    for name in ["face.ply", "face.obj", "faces.obj"] {
        let call = Call::new(&folder, &["info", name]).within(25);
        call.refused(&format!("{name}: "));
    }
}
