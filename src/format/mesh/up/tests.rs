use super::*;

/// A face of [`open_box`].
#[derive(PartialEq)]
enum Face {
    Bottom,
    Top,
}

/// A box without its sides, with these faces.
fn open_box(size: [f32; 3], faces: &[Face]) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for corner in 0..8 {
        let at = |axis: usize| if corner >> axis & 1 == 1 { size[axis] } else { 0.0 };
        mesh.x.push(at(0));
        mesh.y.push(at(1));
        mesh.z.push(at(2));
    }
    if faces.contains(&Face::Bottom) {
        mesh.triangles.extend([[0, 2, 1], [1, 2, 3]]);
    }
    if faces.contains(&Face::Top) {
        mesh.triangles.extend([[4, 5, 6], [5, 7, 6]]);
    }
    // A ridge from edge to edge: no side is flat.
    mesh.triangles.extend([[0, 1, 7], [2, 6, 5]]);
    mesh
}

#[test]
fn axes_are_parsed_as_they_are_written() {
    for axis in UpAxis::ALL {
        assert_eq!(axis.name().parse(), Ok(axis));
        assert_eq!(axis.name().to_uppercase().parse(), Ok(axis));
        assert_eq!(axis.right().cross(axis.vector()), axis.front());
    }
    assert_eq!("+z".parse(), Ok(UpAxis::Z));
    assert!("up".parse::<UpAxis>().is_err() && "--x".parse::<UpAxis>().is_err());
}

#[test]
fn the_front_is_gltfs_and_blenders() {
    assert_eq!((UpAxis::Y.front(), UpAxis::Y.right()), (DVec3::Z, DVec3::X));
    assert_eq!((UpAxis::Z.front(), UpAxis::Z.right()), (DVec3::NEG_Y, DVec3::X));
}

#[test]
fn a_mesh_that_lies_on_its_side_is_doubted() {
    let reason = |mesh: &TriangleMesh, assumed| doubt(mesh, assumed).map_or(String::new(), |doubt| doubt.1);
    let statue = open_box([1.0, 1.0, 2.0], &[Face::Bottom]);
    assert_eq!(reason(&statue, UpAxis::Y), "its flat side faces -z");
    assert_eq!(doubt(&statue, UpAxis::Z), None);
    let hanging = open_box([1.0, 1.0, 2.0], &[Face::Top]);
    assert_eq!(
        doubt(&hanging, UpAxis::Y).map(|(axis, _)| axis),
        Some(UpAxis::MinusZ)
    );
    let tower = open_box([1.0, 1.0, 5.0], &[]);
    assert_eq!(reason(&tower, UpAxis::Y), "it is longest along z");
    assert_eq!(doubt(&tower, UpAxis::Z), None);
    let lying = open_box([5.0, 1.0, 1.0], &[Face::Bottom, Face::Top]);
    assert_eq!(reason(&lying, UpAxis::Z), "it is longest along x");
    let column = open_box([1.0, 1.0, 5.0], &[Face::Bottom, Face::Top]);
    assert_eq!(reason(&column, UpAxis::Y), "it is longest along z");
    // Flat sides wherever it may stand.
    let mut closed = open_box([3.0, 4.0, 20.0], &[Face::Bottom, Face::Top]);
    closed
        .triangles
        .extend([[0, 1, 5], [0, 5, 4], [2, 7, 3], [2, 6, 7]]);
    assert_eq!(reason(&closed, UpAxis::Y), "it is longest along z");
    assert_eq!(doubt(&closed, UpAxis::Z), None);
    let terrain = open_box([10.0, 10.0, 1.0], &[]);
    assert_eq!(reason(&terrain, UpAxis::Y), "it is thinnest along z");
    let car = open_box([1.8, 1.4, 4.5], &[]);
    assert_eq!(doubt(&car, UpAxis::Y), None);
    assert_eq!(doubt(&TriangleMesh::default(), UpAxis::Y), None);
}
