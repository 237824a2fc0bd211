//! Faces, strips and polygons.

use super::*;

#[test]
fn faces_may_come_first() {
    let text = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex 3\n\
        property float x\nproperty float y\nproperty float z\nend_header\n3 2 1 0\n0 0 0\n1 0 0\n0 1 0";
    assert_eq!(mesh(text).triangles, [[2, 1, 0]]);
    assert!(fault(text.replace("2 1 0", "2 1 3")).starts_with("10:1: vertex index 3"));
}

#[test]
fn strips_of_triangles() {
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
             property uchar red\nelement tristrips 2\nproperty list int int vertex_indices\nend_header\n"
        )
    };
    let vertices = "0 0 0 9\n1 0 0 9\n0 1 0 9\n1 1 0 9\n0 2 0 9\n";
    let text = format!("{}{vertices}8 0 1 2 3 -1 2 3 4\n2 0 1\n", header("ascii"));
    let expected = [[0, 1, 2], [2, 1, 3], [2, 3, 4]];
    assert_eq!(mesh(&text).triangles, expected);
    let notes = |text: &str| loaded(text, true).expect("a mesh").notes;
    assert_eq!(notes(&text), ["m.ply: left out: vertex colours"]);

    let mut binary = header("binary_big_endian").into_bytes();
    for line in vertices.lines() {
        let numbers: Vec<f32> = line.split(' ').map(|word| word.parse().unwrap()).collect();
        binary.extend(numbers[..3].iter().flat_map(|value| value.to_be_bytes()));
        binary.push(9);
    }
    let indices = [8_i32, 0, 1, 2, 3, -1, 2, 3, 4, 2, 0, 1];
    binary.extend(indices.iter().flat_map(|value| value.to_be_bytes()));
    assert_eq!(mesh(&binary).triangles, expected);

    let beyond = text.replace("3 4\n2", "3 5\n2");
    assert!(fault(beyond).contains("vertex index 5, but the file has only 5 vertices"));
    let other = text.replace("-1 2", "-2 2");
    assert!(fault(other).contains("vertex index -2"));
}

/// The outline of an arrowhead, which fans around most corners do not fill.
const ARROW: &str = "0 2 0\n-1 0 0\n0 1 0\n1 0 0\n";

fn area(mesh: &TriangleMesh, triangle: &[u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|i| glam::DVec2::new(mesh.x[i as usize].into(), mesh.y[i as usize].into()));
    (b - a).perp_dot(c - a) * 0.5
}

#[test]
fn concave_polygons_are_filled_however_they_are_read() {
    let corners: [f32; 12] = [0.0, 2.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0];
    let faces = |lists: &[&[u32]], big_endian: bool| {
        let mut bytes: Vec<u8> = Vec::new();
        let order = |mut number: [u8; 4]| {
            if big_endian {
                number.reverse();
            }
            number
        };
        bytes.extend(corners.iter().flat_map(|x| order(x.to_le_bytes())));
        for list in lists {
            bytes.push(list.len() as u8);
            bytes.extend(list.iter().flat_map(|i| order(i.to_le_bytes())));
        }
        bytes
    };
    let arrow: &[u32] = &[1, 2, 3, 0];
    // Longer than what one thread takes.
    let many = vec![arrow; 10_000];
    let mixed = [&[1, 2, 0][..], arrow, &[2, 3, 0], arrow];
    for (format, big_endian) in [("binary_little_endian", false), ("binary_big_endian", true)] {
        for lists in [&many[..], &mixed[..]] {
            let bytes = [
                header(format, 4, lists.len()).into_bytes(),
                faces(lists, big_endian),
            ]
            .concat();
            let mesh = mesh(bytes);
            assert!(mesh.triangles.iter().all(|t| (area(&mesh, t) - 0.5).abs() < 1e-6));
        }
    }
    // A line each, and a file that has to be read word by word.
    for text in [
        "3 1 2 0\n4 1 2 3 0\n4 1 2 3 0\n",
        "3 1\n2 0\n4 1 2 3 0\n4 1 2 3\n0\n",
    ] {
        let mesh = mesh(ascii(&format!("{ARROW}{text}"), 4, 3));
        assert_eq!(mesh.triangles.len(), 5);
        assert!(
            mesh.triangles.iter().all(|t| (area(&mesh, t) - 0.5).abs() < 1e-6),
            "{text:?}"
        );
    }
}

#[test]
fn strips_and_faces_in_one_file() {
    let text = header("ascii", 4, 1).replace(
        "element face",
        "element tristrips 1\nproperty list int int vertex_indices\nelement face",
    );
    let found = mesh(text + ARROW + "3 1 2 0\n3 2 3 0\n");
    assert_eq!(found.triangles, [[1, 2, 0], [2, 3, 0]]);
}
