use super::*;

#[test]
fn every_kind_is_recognised() {
    let binary_stl = |facets: u8| {
        let mut bytes = vec![b' '; 80];
        bytes.extend([facets, 0, 0, 0]);
        bytes.resize(84 + 50 * usize::from(facets), 1);
        bytes
    };
    let is = |bytes: &[u8], expected: Option<MeshFormat>| {
        let found = match detect(bytes) {
            Detected::Scene => None,
            Detected::Mesh(format) => Some(format),
        };
        assert_eq!(found, expected, "{}", String::from_utf8_lossy(bytes));
    };
    let (ply, gltf, stl, obj) = (
        Some(MeshFormat::Ply),
        Some(MeshFormat::Gltf),
        Some(MeshFormat::Stl),
        Some(MeshFormat::Obj),
    );
    is(b"ply\nformat ascii 1.0\n", ply);
    is(b"ply\r\nformat ascii 1.0\r\n", ply);
    is(b"\xef\xbb\xbfply\r\n", ply);
    is(b"glTF\x02\0\0\0", gltf);
    is(b" \n{\"asset\": {}}", gltf);
    is(b"\xef\xbb\xbf{}", gltf);
    is(b"PK\x03\x04\x14\0", Some(MeshFormat::ThreeMf));
    is(b"# vtk DataFile Version 4.2\n", Some(MeshFormat::Vtk));
    is(
        b"<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">",
        Some(MeshFormat::Vtk),
    );
    is(b"OFF\n1 0 0\n0 0 0\n", Some(MeshFormat::Off));
    is(b"# c\nCOFF 1 0 0\n", Some(MeshFormat::Off));
    is(b"OFFICE\nv 0 0 0\n", obj);
    is(&binary_stl(0), stl);
    is(&binary_stl(3), stl);
    is(b"solid cube\nendsolid cube\n", stl);
    is(b"SOLID\n", stl);
    is(b"// a scene\n\nlight 9 -4 10 0.7\n", None);
    is(b"\xef\xbb\xbfmaterial 1\r\n", None);
    is(b"sphre 0 0 0 1\n", None);
    is(b"# not a comment here\nsphere 0 0 0 1\n", None);
    is(b"// nothing yet\n", None);
    is(b"", None);
    is(b"# Blender\no cube\nv 0 0 0\n", obj);
    is(b"v 0 0 0\nsphere 0 0 0 1\n", obj);
    is(b"mtllib a.mtl\n", obj);
    is(b"Dear reader,", obj);
    is(b"solidify 1\n", obj);
    is(&binary_stl(3)[..200], obj);
}

#[test]
fn other_files_are_called_by_their_kind() {
    for (bytes, kind) in [
        (&b"\xff\xd8\xff\xe0\0\x10JFIF"[..], "a JPEG picture"),
        (b"%PDF-1.7\n", "a PDF document"),
        (b"\x1f\x8b\x08\0", "compressed by gzip (gunzip unpacks it)"),
    ] {
        let error = load_any(bytes, Path::new("-"), &mut Vec::new(), u64::MAX).expect_err(kind);
        assert_eq!(
            error.to_string(),
            format!("-: this is {kind}, expected a scene or a mesh")
        );
    }
}

#[test]
fn a_reader_gives_a_scene_or_a_mesh() {
    let load =
        |text: &str| load_any(text.as_bytes(), Path::new("-"), &mut Vec::new(), u64::MAX).expect("it loads");
    assert!(matches!(load("sphere 0 0 0 1"), Loaded::Scene(scene) if scene.primitive_count() == 1));
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    assert!(matches!(load(square), Loaded::Mesh(mesh) if mesh.columns.triangles.len() == 2));
    let error = load_any(square.as_bytes(), Path::new("-"), &mut Vec::new(), 10).expect_err("too large");
    assert_eq!(error.to_string(), "-: the input is larger than 10 B");
}
