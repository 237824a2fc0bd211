use super::*;

fn points(positions: impl IntoIterator<Item = [f32; 3]>) -> TriangleMesh {
    let mut points = TriangleMesh::default();
    for [x, y, z] in positions {
        points.x.push(x);
        points.y.push(y);
        points.z.push(z);
    }
    points
}

fn radius(positions: impl IntoIterator<Item = [f32; 3]>) -> f32 {
    Cloud::default().radius(&points(positions))
}

#[test]
fn the_radius_follows_the_spacing() {
    let grid = |copies: u32| {
        (0..10_000 * copies).map(move |i| {
            [
                (i / copies % 100) as f32 * 0.25,
                (i / copies / 100) as f32 * 0.25,
                3.0,
            ]
        })
    };
    assert_eq!(radius(grid(1)), 0.65 * 0.25);
    // Neither copies nor a few points far away change it.
    assert_eq!(radius(grid(3)), 0.65 * 0.25);
    let outliers = (0..50).map(|i| [1e6 + 1e3 * i as f32, 0.0, 0.0]);
    assert_eq!(radius(grid(1).chain(outliers)), 0.65 * 0.25);
    assert_eq!(radius([[0.0; 3], [0.0, 2.0, 0.0]]), 1.3);
    let set = Cloud {
        radius: Some(0.125),
        ..Cloud::default()
    };
    assert_eq!(set.radius(&points(grid(1))), 0.125);
}

#[test]
fn points_at_one_position_have_a_radius() {
    assert_eq!(radius([[1.0, 2.0, 3.0]]), 0.5);
    assert_eq!(radius(vec![[1.0, 2.0, 3.0]; 5000]), 0.5);
    assert_eq!(radius([[0.0, -1e9, 0.0]]), 1e6);
    assert_eq!(radius([]), 0.5);
    // So close that the square is 0.
    assert_eq!(radius([[0.0; 3], [1e-30, 0.0, 0.0]]), 0.5);
}

#[test]
fn the_radius_of_lines_follows_their_box() {
    let lines = Cloud {
        radius: None,
        lines: vec![[0, 1]],
    };
    let radius = |positions: &[[f32; 3]]| lines.radius(&points(positions.iter().copied()));
    let start = [1.0, 2.0, 3.0];
    assert_eq!(radius(&[start, [401.0, 2.0, 3.0], [9.0, 2.0, 3.0]]), 1.0);
    // Points beside the lines do not count, unless no line has a length.
    assert_eq!(radius(&[start, [401.0, 2.0, 3.0], [9e6; 3]]), 1.0);
    assert_eq!(radius(&[start, start, [1.0, 2.0, 7.0]]), 0.65 * 4.0);
    assert_eq!(radius(&[start, start]), 0.5);
    assert_eq!(radius(&[]), 0.5);
}

#[test]
fn spheres_keep_the_colours() {
    let mut cloud = points([[0.0; 3], [1.0, 0.0, 0.0]]);
    cloud.colors = vec![[1.0, 0.0, 0.0], [0.0, 0.5, 0.0]];
    cloud.normals = vec![Vec3::Z; 2];
    let spheres = spheres(cloud, 0.65).expect("little memory");
    assert_eq!(
        (&spheres.x[..], &spheres.radius[..]),
        (&[0.0, 1.0][..], &[0.65; 2][..])
    );
    assert_eq!(spheres.colors, [[1.0, 0.0, 0.0], [0.0, 0.5, 0.0]]);
}
