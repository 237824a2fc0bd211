//! Scenes, glTF, and what may be opened.

use super::Call;
use crate::{long::rounds, program::Folder};
use std::fs::{self, File};

fn gltf(body: &str) -> String {
    format!(r#"{{"asset":{{"version":"2.0"}},{body}}}"#)
}

/// `count` times `text`, between commas; `#` stands for the number.
fn list(text: &str, count: usize) -> String {
    let items: Vec<String> = (0..count).map(|i| text.replace('#', &i.to_string())).collect();
    items.join(",")
}

/// Nodes that place a triangle whose corners lie in the file `uri`.
fn placed(nodes: &str, uri: &str) -> String {
    gltf(&format!(
        r#""nodes":[{nodes}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36,"uri":"{uri}"}}]"#
    ))
}

/// A file of zeros that takes no room on the disk.
fn zeros(folder: &Folder, name: &str, length: u64) {
    let file = File::create(folder.path(name)).expect("a file");
    file.set_len(length).expect("its length");
}

fn placements(folder: &Folder, name: &str, mesh: &str, count: usize) {
    let text: String = (0..count)
        .map(|i| format!("mesh {mesh} translate {i} 0 0\n"))
        .collect();
    folder.write(name, &text);
}

#[test]
fn nodes_of_nothing() {
    let folder = Folder::new();
    folder.write(
        "a.gltf",
        &gltf(&format!(r#""nodes":[{}{{}}]"#, "{},".repeat(1_200_000))),
    );
    let info = || Call::new(&folder, &["info", "a.gltf"]);
    info().within(50).refused("loading takes");
    // As many as fit.
    folder.write(
        "a.gltf",
        &gltf(&format!(r#""nodes":[{}{{}}]"#, "{},".repeat(300_000))),
    );
    info().run();
    // Numbers of bounds are kept as JSON.
    let bounds = gltf(&format!(
        r#""accessors":[{{"componentType":5126,"count":3,"type":"VEC3","min":[{}0]}}]"#,
        "0,".repeat(4_000_000)
    ));
    folder.write("a.gltf", &bounds);
    info().within(50).refused("loading takes");
}

#[test]
fn buffers_of_one_file() {
    let folder = Folder::new();
    zeros(&folder, "big.bin", 200 << 20);
    let body = gltf(&format!(
        r#""nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{}]}}],"accessors":[{}],"bufferViews":[{}],"buffers":[{}]"#,
        list(r#"{"attributes":{"POSITION":#}}"#, 200),
        list(
            r#"{"bufferView":#,"componentType":5126,"count":3,"type":"VEC3"}"#,
            200
        ),
        list(r#"{"buffer":#,"byteLength":36}"#, 200),
        list(r#"{"byteLength":36,"uri":"big.bin"}"#, 200),
    ));
    folder.write("a.gltf", &body);
    assert_eq!(Call::new(&folder, &["info", "a.gltf"]).run().code, Some(0));
    zeros(&folder, "other.bin", 200 << 20);
    folder.write("a.gltf", &body.replacen("big.bin", "other.bin", 1));
    Call::new(&folder, &["info", "a.gltf"]).refused("above the memory limit of 300.0 MiB");
}

#[test]
fn a_triangle_placed_too_often() {
    let folder = Folder::new();
    zeros(&folder, "a.bin", 36);
    folder.write("a.gltf", &placed(&list(r#"{"mesh":0}"#, 30_000), "a.bin"));
    assert_eq!(Call::new(&folder, &["info", "a.gltf"]).run().code, Some(0));
    placements(&folder, "a.scn", "a.gltf", 330);
    Call::new(&folder, &["info", "a.scn"]).refused("above the memory limit of 300.0 MiB");
}

#[test]
fn a_mesh_with_a_large_buffer_placed_often() {
    let folder = Folder::new();
    zeros(&folder, "big.bin", 200 << 20);
    folder.write("a.gltf", &placed(r#"{"mesh":0}"#, "big.bin"));
    placements(&folder, "a.scn", "a.gltf", 100);
    assert_eq!(Call::new(&folder, &["info", "a.scn"]).run().code, Some(0));
}

#[test]
fn one_small_mesh_placed_65_536_times() {
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    placements(&folder, "a.scn", "a.obj", 65_536);
    assert_eq!(Call::new(&folder, &["info", "a.scn"]).run().code, Some(0));
    placements(&folder, "a.scn", "a.obj", 65_537);
    Call::new(&folder, &["info", "a.scn"]).refused("more than 65536 placed meshes");
}

#[test]
fn files_without_an_end() {
    let folder = Folder::new();
    let uri = "/proc/self/pagemap";
    folder.write("a.gltf", &placed(r#"{"mesh":0}"#, uri));
    Call::new(&folder, &["info", "a.gltf"]).refused("cannot load buffers[0]");
    folder.write(
        "a.obj",
        &format!("mtllib {uri}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    );
    assert_eq!(Call::new(&folder, &["info", "a.obj"]).run().code, Some(0));
    folder.write("a.scn", &format!("include {uri}\n"));
    Call::new(&folder, &["info", "a.scn"]).refused("cannot include");
    let endless = || File::open("/dev/zero").expect("a device");
    for mebibytes in [50, 100] {
        Call::new(&folder, &["info", "-"])
            .within(mebibytes)
            .with_input(endless())
            .refused("of memory or more, above the memory limit of");
    }
    Call::new(&folder, &["info", "-"])
        .with_input(File::open("/dev/null").expect("a device"))
        .refused("is empty, expected a scene or a mesh");
}

/// Thousands of names that are missing, in a folder of thousands of names like them.
#[test]
fn missing_files() {
    let folder = Folder::new();
    let name = "n".repeat(70);
    for i in 0..rounds(1000, 3000) {
        fs::write(folder.path(&format!("{name}{i}")), "").expect("a file");
    }
    let mut text = String::new();
    for i in 0..rounds(60, 200) {
        let libraries: String = (0..30).map(|i| format!("mtllib {name}x{i}\n")).collect();
        let mesh = format!("{libraries}v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        folder.write(&format!("{i}.obj"), &mesh);
        text += &format!("mesh {i}.obj\n");
    }
    folder.write("a.scn", &text);
    for arguments in [&["info", "0.obj"][..], &["a.scn", "--quiet", "--size", "16x16"]] {
        assert_eq!(Call::new(&folder, arguments).run().code, Some(0));
    }
}

#[test]
fn cameras_and_materials_without_number() {
    let folder = Folder::new();
    let cameras: String = (0..20_000)
        .map(|i| format!("camera c{i} eye 1 2 3 target 0 0 0\n"))
        .collect();
    folder.write("a.scn", &cameras);
    Call::new(&folder, &["info", "a.scn"]).refused("more than 1024 cameras");
    let materials: String = (0..1_000_000)
        .map(|i| format!("material matte cd 0 {} 1\n", f64::from(i) / 1e6))
        .collect();
    folder.write("a.scn", &materials);
    Call::new(&folder, &["info", "a.scn"])
        .within(50)
        .refused("above the memory limit of 50.0 MiB");
}
