//! Hits of lines in `f64`.

use super::*;
use octray::query::exact::Line;

/// Rays in `f64` at points so near to edges and vertices of a hilly mesh that `f32` takes one side for the other: the hits
/// are those of exact signs for each triangle by itself.
#[test]
fn hits_are_those_of_exact_arithmetic() {
    let mut random = Random::new(21);
    let side = 10;
    let heights: Vec<f32> = (0..side * side).map(|_| random.0.f32()).collect();
    let positions: Vec<[f32; 3]> = (0..side * side)
        .map(|i| [(i % side) as f32, (i / side) as f32, heights[i]])
        .collect();
    let corners = (0..side * (side - 1)).filter(|i| i % side < side - 1);
    let triangles: Vec<[u32; 3]> = corners
        .flat_map(|i| {
            let [a, b, c, d] = [i, i + 1, i + side, i + side + 1].map(|i| i as u32);
            [[a, b, c], [b, d, c]]
        })
        .collect();
    let geometry = Geometry::from_triangles(&positions, &triangles).unwrap();
    let (mut origins, mut directions) = (Vec::new(), Vec::new());
    for _ in 0..4000 {
        let [a, b, _] =
            triangles[random.0.usize(0..triangles.len())].map(|v| Vec3::from(positions[v as usize]));
        let on_edge = a
            .as_dvec3()
            .lerp(b.as_dvec3(), [0.0, 0.5, random.0.f64()][random.0.usize(0..3)]);
        let aside = random.vector().as_dvec3() * [0.0, 1e-7, 1e-9, 1e-15][random.0.usize(0..4)];
        let origin = DVec3::new(4.5, 4.5, 0.0) + random.vector().as_dvec3() * 9.0 + DVec3::Z * 12.3;
        origins.push(origin.to_array());
        directions.push(((on_edge + aside - origin) * random.0.f64()).to_array());
    }
    let rays = Rays::from_arrays(&origins, &directions).unwrap();
    let (found, rounded) = (
        geometry.exact_hits_each(rays, None, false),
        geometry.all_hits_each(rays, None),
    );
    let (mut differ, mut all) = (0, 0);
    for i in 0..origins.len() {
        let given = [DVec3::from(origins[i]), DVec3::from(directions[i])];
        let line = Line::new(given, geometry.middle(), (given[0] - geometry.middle()).as_vec3());
        let is_met = |&id: &u32| {
            let corners = geometry.triangle(id as usize);
            line.meets(corners.map(|corner| (corner - geometry.middle()).as_vec3()))
        };
        let expected: Vec<u32> = (0..triangles.len() as u32).filter(is_met).collect();
        let mut ids: Vec<u32> = found.of_ray(i).iter().map(|hit| hit.primitive.0).collect();
        ids.sort_unstable();
        assert_eq!(ids, expected, "{i}");
        all += ids.len();
        differ += usize::from(found.of_ray(i) != rounded.of_ray(i));
    }
    assert!(all > 3000 && differ > 1000, "{all} {differ}");
}

/// Two sheets very near each other, seen from afar through their vertices and edges: a triangle of each, that with the lowest
/// id, also if only the nearest hits are wanted. Without `once` it is all that the ray touches.
#[test]
fn one_triangle_is_hit_at_each_place() {
    let side = 9_u32;
    let sheet = |z: f32| (0..side * side).map(move |i| [(i % side) as f32, (i / side) as f32, z]);
    let positions: Vec<[f32; 3]> = sheet(0.0).chain(sheet(1e-3)).collect();
    let squares = (0..side * (side - 1)).filter(|i| i % side < side - 1);
    let of_sheet: Vec<[u32; 3]> = squares
        .flat_map(|i| [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]])
        .collect();
    let above = of_sheet.iter().map(|corners| corners.map(|i| i + side * side));
    let triangles: Vec<[u32; 3]> = of_sheet.iter().copied().chain(above).collect();
    let geometry = Geometry::from_triangles(&positions, &triangles).unwrap();
    let mut random = Random::new(22);
    let mut number = || f64::from(random.0.u32(2..14)) / 2.0;
    let at: Vec<[f64; 2]> = (0..500).map(|_| [number(), number()]).collect();
    let origins: Vec<[f64; 3]> = at.iter().map(|&[x, y]| [x, y, 1e4]).collect();
    let directions = vec![[0.0, 0.0, -1.0]; origins.len()];
    let rays = Rays::from_arrays(&origins, &directions).unwrap();
    let ids = |limit, once| {
        let found = geometry.exact_hits_each(rays, limit, once);
        let of_ray = |i| found.of_ray(i).iter().map(|hit| hit.primitive.0).collect();
        (0..origins.len()).map(of_ray).collect::<Vec<Vec<u32>>>()
    };
    let (every, once) = (ids(None, false), ids(None, true));
    let [nearest, both] = [1, 2].map(|limit| ids(Some(limit), true));
    let half = of_sheet.len() as u32;
    for i in 0..origins.len() {
        let lowest = |lower: bool| every[i].iter().copied().filter(|&id| (id < half) == lower).min();
        let mut expected: Vec<u32> = [true, false].into_iter().filter_map(lowest).collect();
        assert!(expected.len() == 2 && every[i].len() >= 2, "{i}");
        let mut found = once[i].clone();
        assert_eq!([&both[i], &nearest[i][..]], [&found, &found[..1]], "{i}");
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!(found, expected, "{i}");
    }
    assert!(every.iter().filter(|ids| ids.len() == 12).count() > 50);
}

#[test]
fn directions_of_any_length_have_the_same_hits() {
    let geometry = Geometry::from_triangles(
        &[[0.0_f32, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]],
        &[[0, 1, 2]],
    );
    let geometry = geometry.unwrap();
    for scale in [1e-37, 1e-30, 1.0, 1e30, 1e37] {
        for (x, is_hit) in [(-1e-12, false), (0.0, true), (1e-12, true)] {
            let direction = [[x * scale, 0.25 * scale, scale]];
            let rays = Rays::from_arrays(&[[0.0_f64; 3]], &direction).unwrap();
            let hits = geometry.exact_hits_each(rays, None, false).hits.len();
            assert_eq!(hits, usize::from(is_hit), "{scale} {x}");
        }
    }
}
