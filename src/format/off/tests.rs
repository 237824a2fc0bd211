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
