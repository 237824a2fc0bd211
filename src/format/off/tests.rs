use super::*;
use glam::Vec3;

fn load(text: &str) -> Result<LoadedMesh, String> {
    let loaded = parse(text.as_bytes(), Path::new("a.off"), &Budget::unlimited());
    loaded.map_err(|error| error.to_string().trim_start_matches("a.off:").to_owned())
}

fn mesh(text: &str) -> LoadedMesh {
    load(text).unwrap_or_else(|error| panic!("{error}"))
}

const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

#[test]
fn headers_comments_and_polygons() {
    for header in [
        "OFF\n4 1 0",
        "OFF 4 1 0",
        "OFF4 1 0",
        "# a\n\nOFF # b\n\n4 1\n",
        "4 1 0",
        "\u{feff}OFF\r4 1 4\r",
    ] {
        let mesh = mesh(&format!("{header}\n{SQUARE}4 0 1 2 3 # c\n"));
        assert_eq!(mesh.columns.triangles, [[0, 1, 2], [0, 2, 3]], "{header}");
        assert_eq!(mesh.columns.y, [0.0, 0.0, 1.0, 1.0]);
        assert!(mesh.notes.is_empty() && mesh.surfaces.is_empty() && mesh.surface_of.is_empty());
    }
    // Concave: the fan around the first corner does not fill it.
    let concave = mesh("OFF\n4 1 0\n0 0 0\n2 -1 0\n1 0 0\n2 1 0\n4 1 2 3 0\n").columns;
    assert_eq!(concave.triangles.len(), 2);
    assert!(
        concave
            .triangles
            .iter()
            .all(|corners| corners.contains(&0) && corners.contains(&2))
    );
}

#[test]
fn colours_of_vertices_and_faces() {
    let white = "1 0 0 255 255 255 255\n0 1 0 255 255 255 255\n";
    for header in ["COFF", "OFF"] {
        let mesh = mesh(&format!("{header}\n3 1 0\n0 0 0 255 0 51 255\n{white}3 0 1 2\n"));
        assert_eq!(mesh.columns.colors, [[1.0, 0.0, 0.2], [1.0; 3], [1.0; 3]]);
    }
    let shares =
        mesh("CNOFF\n3 1 0\n0 0 0 0 0 1 0.5 0 1 1\n1 0 0 0 0 1 1 1 1 1\n0 1 0 0 0 1 1 1 1 1\n3 0 1 2\n");
    assert_eq!(shares.columns.colors[0], [0.5, 0.0, 1.0]);
    assert_eq!(shares.columns.normals, [Vec3::Z; 3]);
    let faces =
        format!("OFF\n4 5 0\n{SQUARE}3 0 1 2 255 0 0\n3 0 2 3\n3 0 1 3 1.0 0 0 0.5\n3 1 2 3 7\n2 0 1\n");
    let faces = mesh(&faces);
    assert_eq!(faces.surface_of, [1, 0, 1, 0]);
    assert_eq!(
        (faces.surfaces[0], faces.surfaces[1].diffuse),
        (Surface::NEUTRAL, [1.0, 0.0, 0.0])
    );
    assert_eq!(
        faces.notes,
        ["a.off: left out: 1 face with fewer than 3 corners, 1 numbered colour"]
    );
}

#[test]
fn without_faces_it_is_a_cloud() {
    assert!(mesh(&format!("OFF\n4 0 0\n{SQUARE}")).cloud.is_some());
    assert!(mesh("OFF\n0 0 0\n").cloud.is_none());
}

#[test]
fn faults_have_places() {
    for (text, expected) in [
        ("", "1:1: the file is empty, expected an OFF mesh"),
        ("# x\n", "1:1: the file has no counts, expected an OFF mesh"),
        (
            "OFF BINARY\n\0",
            "1:1: `OFF BINARY` is not supported, expected text in three dimensions",
        ),
        (
            "4OFF\n1 0 0\n",
            "1:1: `4OFF` is not supported, expected text in three dimensions",
        ),
        (
            "OFF\nx 1 0\n",
            "2:1: found `x`, expected the number of vertices of an OFF mesh",
        ),
        ("OFF\n1 0 0\n0 0 nan\n", "3:5: z is NaN, expected a finite number"),
        (
            "OFF\n1 0 0\n0 0\n",
            "3:4: the line ends before `z`, expected a number",
        ),
        (
            "OFF\n4000000000 0 0\n0 0 0\n",
            "4:1: the file ends before the last vertex: the header promises 4000000000",
        ),
        (
            "OFF\n1 1 0\n0 0 0\n3 0 0 1\n",
            "4:7: vertex index `1`, but the file has only 1 vertices",
        ),
        (
            "OFF\n1 1 0\n0 0 0\n3 0 -1 0\n",
            "4:5: vertex index `-1`, but the file has only 1 vertices",
        ),
        (
            "OFF\n1 1 0\n0 0 0\n4 0 0 0\n",
            "4:8: the line ends before corner 4",
        ),
    ] {
        let found = load(text).expect_err(text);
        assert!(found.starts_with(expected), "{text}: {found}");
    }
}

#[test]
fn free_format() {
    let usual = mesh(&format!("OFF\n4 2 0\n{SQUARE}3 0 1 2\n4 0 1 2 3\n")).columns;
    let vertices = "0 0 0 1 0 0\n1 1 0\n\n0 # x y\n1 0";
    for text in [
        // All in one line.
        "OFF 4 2 0 0 0 0 1 0 0 1 1 0 0 1 0 3 0 1 2 4 0 1 2 3".to_owned(),
        format!("OFF\n4\r\n2\r\n0 # counts\n{vertices}\n3 0 1 2\n4 0 1\n2 3\n"),
        format!("4 2 0\n{vertices}\n3 0 1\n2\n\n4 0 1 2 3"),
        format!("OFF4 2 0 {vertices} 3 0 1 2 4 0 1 2 3\n\n# end"),
        format!("OFF\n4 2 0\n{SQUARE}3\n0\n1\n2\n4\n0\n1\n2\n3\n"),
        // As many lines as faces, and more, but no colours.
        format!("OFF\n4 2 0\n{SQUARE}3 0 1\n2 4 0\n1 2 3\n"),
        format!("OFF\n4 2 0\n{vertices}\n3 0\n1 2 4\n0 1 2\n3\n"),
        "OFF\n4 2 0\n0 0 0 1 0\n0 1 1 0 0\n1 0 3\n0 1 2\n4\n0\n1 2 3".to_owned(),
        format!(
            "\u{feff}OFF\r4 2 0\r{}3 0 1 2\r4 0\r1 2 3\r",
            SQUARE.replace('\n', "\r")
        ),
    ] {
        let mesh = mesh(&text);
        let found = (
            &mesh.columns.x,
            &mesh.columns.y,
            &mesh.columns.z,
            &mesh.columns.triangles,
        );
        assert_eq!(found, (&usual.x, &usual.y, &usual.z, &usual.triangles), "{text}");
        assert!(mesh.notes.is_empty() && mesh.surfaces.is_empty(), "{text}");
    }
    assert!(mesh("OFF 4 0 0 0 0 0 1 0 0 1 1 0 0 1 0").cloud.is_some());
}

#[test]
fn colours_in_free_format() {
    // Of vertices, with and without the prefix; of faces up to the end of the line.
    let faces = "3 0 1\n2 255 0 0 # red\n3 0 2\n3";
    let colored = SQUARE.replace('\n', " 255 0 51\n");
    let four = SQUARE.replace('\n', " 0 0 1 255 0 51 255 ");
    for text in [
        format!("OFF\n4 2 0\n{colored}{faces}"),
        format!("COFF\n4 2 0\n{colored}{faces}"),
        format!("CNOFF\n4 2 0\n{four}\n{faces}"),
    ] {
        let mesh = mesh(&text);
        assert_eq!(mesh.columns.colors, [[1.0, 0.0, 0.2]; 4], "{text}");
        assert_eq!(
            (&mesh.surface_of[..], mesh.surfaces.len()),
            (&[1, 0][..], 2),
            "{text}"
        );
    }
}

#[test]
fn numbers_that_are_missing_are_not_those_of_the_next_line() {
    for (text, expected) in [
        (
            "0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n",
            "3:4: the line ends before `z`",
        ),
        (
            "0 0 0\n1 0 0\n1 1 0\n0 1\n3 0 1 2\n3 0 2 3\n",
            "6:4: the line ends before `z`",
        ),
        (
            "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1\n3 0 2 3\n",
            "7:6: the line ends before corner 3",
        ),
        (
            "0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n3 0 2 1\n",
            "8:1: the file ends before the last face",
        ),
        (
            "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n",
            "8:1: the file ends before the last face",
        ),
    ] {
        let found = load(&format!("OFF\n4 2 0\n{text}")).expect_err(text);
        assert!(found.starts_with(expected), "{text}: {found}");
    }
    // The places are those of the file, and the memory is counted.
    let far = "OFF 3 1 0 0 0 0 1 0 0\n# a\n1 1e10 0 3 0 1 2";
    let far = load(far).expect_err("nothing is left");
    assert!(far.starts_with("3:3: y is 1e10"), "{far}");
    let text = format!("OFF 99999 0 0 {}", "1 2 3 ".repeat(99_999));
    let load = |memory: u64| parse(text.as_bytes(), Path::new("a.off"), &Budget::new(memory));
    assert_eq!(
        load(1 << 18).expect_err("too little").kind(),
        LoadErrorKind::Limit
    );
    assert!(load(4 << 20).is_ok());
}
