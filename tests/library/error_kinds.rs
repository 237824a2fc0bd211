//! Programs can tell why a file was not loaded.

use crate::targets::archive::of_model;
use octray::{
    error::{LoadError, LoadErrorKind as Kind},
    format,
};
use std::{fs, io::ErrorKind, path::Path};

const TRIANGLE: &str = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// Writes files into a folder, and loads the first of them within this much memory.
fn load(files: &[(&str, &[u8])], memory: u64) -> LoadError {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).expect("a file");
    }
    load_path(&folder.path().join(files[0].0), memory)
}

fn load_path(path: &Path, memory: u64) -> LoadError {
    let is_scene = path.extension().is_some_and(|extension| extension == "scn");
    let failed = if is_scene {
        format::load_within(path, &mut Vec::new(), memory).map(drop)
    } else {
        format::mesh::load_within(path, &mut Vec::new(), memory).map(drop)
    };
    failed.expect_err("a broken file")
}

#[test]
fn files_that_cannot_be_read_say_how() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["no.scn", "no.ply", "no.glb"] {
        let kind = load_path(&folder.path().join(name), u64::MAX).kind();
        assert_eq!(kind, Kind::Io(ErrorKind::NotFound), "{name}");
        fs::create_dir(folder.path().join(name)).expect("a folder");
        let kind = load_path(&folder.path().join(name), u64::MAX).kind();
        assert_eq!(kind, Kind::Io(ErrorKind::IsADirectory), "{name}");
    }
    let missing = format::check_file(&folder.path().join("no.obj")).expect_err("no file");
    assert_eq!(missing.kind(), Kind::Io(ErrorKind::NotFound));
}

#[test]
fn a_scene_has_the_kind_of_its_deepest_cause() {
    let include = ("a.scn", &b"include b.scn\n"[..]);
    for (mesh, kind) in [
        (None, Kind::Io(ErrorKind::NotFound)),
        (Some(&b"OFF\n3 1 0\n0 0"[..]), Kind::Invalid),
        (Some(&b"Kaydara FBX Binary"[..]), Kind::Unsupported),
    ] {
        let mut files = vec![include, ("b.scn", &b"mesh a.off\n"[..])];
        files.extend(mesh.map(|bytes| ("a.off", bytes)));
        let error = load(&files, u64::MAX);
        assert_eq!(error.kind(), kind, "{error}");
        assert!(error.chain().count() >= 3, "{error}");
        // The place in the scene itself is wrong, whatever the cause.
        let mut alone = error;
        alone.cause = None;
        assert_eq!(alone.kind(), Kind::Invalid);
    }
}

#[test]
fn what_octray_does_not_read_is_unsupported() {
    let extension = br#"{"asset":{"version":"2.0"},"extensionsRequired":["X_unknown"]}"#;
    for (name, bytes) in [
        ("a.fbx", &b"Kaydara FBX Binary"[..]),
        ("a.xyz", b"0 0 0\n"),
        ("a.what", b"\x01\x02"),
        ("a.ply", b"\x89PNG\r\n"),
        ("a.off", b"OFF BINARY\n"),
        ("a.gltf", extension),
        ("a.gltf", br#"{"asset":{"version":"1.0"}}"#),
    ] {
        let error = load(&[(name, bytes)], u64::MAX);
        assert_eq!(error.kind(), Kind::Unsupported, "{error}");
    }
}

#[test]
fn what_is_too_large_has_met_a_limit() {
    let mesh = TRIANGLE.as_bytes();
    let scene = ("a.scn", &b"mesh a.off\n"[..]);
    for memory in [0, 20, 100] {
        let error = load(&[("a.off", mesh)], memory);
        assert_eq!(error.kind(), Kind::Limit, "{error}");
        let error = load(&[scene, ("a.off", mesh)], memory);
        assert_eq!(error.kind(), Kind::Limit, "{error}");
    }
    let error = load(&[("a.scn", b"include a.scn\n")], u64::MAX);
    assert_eq!(error.kind(), Kind::Invalid, "{error}");
}

#[test]
fn too_many_of_something_is_a_limit() {
    let materials = "newmtl\n".repeat((1 << 20) + 1);
    let names = (
        "a.obj",
        &b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"[..],
    );
    let parts = |i: usize| {
        format!(
            "<object id='{i}'><components><component objectid='{}'/></components></object>",
            i + 1
        )
    };
    let parts: String = (1..100).map(parts).collect();
    let parts = format!("<model><resources>{parts}</resources><build><item objectid='1'/></build></model>");
    let [parts, deep] = [parts.into_bytes(), b"<model>".repeat(100)].map(|model| of_model(&model));
    let too_many = vec![names, ("a.mtl", materials.as_bytes())];
    let mut cases = vec![(too_many.clone(), u64::MAX), (too_many, 20 << 20)];
    if cfg!(feature = "threemf") {
        cases.extend([&parts, &deep].map(|model| (vec![("a.3mf", &model[..])], u64::MAX)));
    }
    for (files, memory) in cases {
        let error = load(&files, memory);
        assert_eq!(error.kind(), Kind::Limit, "{error}");
    }
}

#[test]
fn what_is_wrong_is_invalid() {
    for (name, text) in [
        ("a.scn", "sphere 1 2\n"),
        ("a.scn", "sphere 0 0 0 -1\n"),
        ("a.obj", "v 1 2\n"),
        ("a.ply", "ply\n"),
        ("a.ply", ""),
        ("a.stl", ""),
        ("a.glb", "glTF"),
        ("a.3mf", "PK\x03\x04"),
    ] {
        let error = load(&[(name, text.as_bytes())], u64::MAX);
        assert_eq!(error.kind(), Kind::Invalid, "{error}");
    }
}
