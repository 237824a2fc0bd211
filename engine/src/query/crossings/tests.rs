use super::*;

fn passed(ray: &Ray, triangles: &[Crossing]) -> usize {
    decide(ray, triangles)
        .into_iter()
        .filter(|&passes| passes)
        .count()
}

/// Fans around a vertex, and rays at it: one triangle is passed.
#[test]
fn one_triangle_of_a_fan_is_passed() {
    let mut random = fastrand::Rng::with_seed(11);
    for round in 0..2000 {
        let count = 3 + round % 6;
        let mut unit = || random.f32() * 2.0 - 1.0;
        let tip = Vec3::new(unit(), unit(), 5.0 + unit());
        let rim: Vec<Vec3> = (0..count)
            .map(|i| {
                let angle = (i as f32) * std::f32::consts::TAU / count as f32;
                Vec3::new(3.0 * angle.cos(), 3.0 * angle.sin(), 5.0 + unit())
            })
            .collect();
        let fan: Vec<Crossing> = (0..count)
            .map(|i| Crossing([tip, rim[i], rim[(i + 1) % count]]))
            .collect();
        let on_edge = tip.lerp(rim[0], 0.25);
        for to in [tip, on_edge] {
            assert_eq!(
                passed(&Ray::new(Vec3::ZERO, to.normalize()), &fan),
                1,
                "{round} {to}"
            );
        }
    }
}

/// Closed meshes with corners on a grid, and rays along its lines: edges lie on the ray, vertices coincide.
#[test]
fn closed_meshes_on_a_grid_are_passed_evenly() {
    let mut random = fastrand::Rng::with_seed(12);
    for round in 0..3000 {
        let mut grid = || {
            Vec3::new(
                random.i32(-2..=2) as f32,
                random.i32(-2..=2) as f32,
                random.i32(-2..=2) as f32,
            )
        };
        let mut triangles = Vec::new();
        for _ in 0..3 {
            let [a, b, c, d] = [grid(), grid(), grid(), grid()];
            let solid = [[a, c, b], [a, b, d], [b, c, d], [a, d, c]];
            if (b - a).cross(c - a).dot(d - a) != 0.0 {
                triangles.extend(solid.map(Crossing));
            }
        }
        let origin = grid() - [Vec3::X, Vec3::ONE, Vec3::new(0.0, 3.0, 1.0)][round % 3] * 5.0;
        let way = [Vec3::X, Vec3::ONE, Vec3::new(0.0, 3.0, 1.0)][round % 3];
        assert_eq!(passed(&Ray::new(origin, way), &triangles) % 2, 0, "{round}");
    }
}

#[test]
fn signs_are_those_of_whole_numbers() {
    let mut random = fastrand::Rng::with_seed(13);
    let mut zeros = 0;
    for round in 0..20_000 {
        let most = [2, 9, 4000, 1 << 37][round % 4];
        let mut rows = [[0_i128; 4]; 4];
        for (i, row) in rows.iter_mut().enumerate() {
            *row = std::array::from_fn(|_| i128::from(random.i64(-most..=most)));
            row[3] = i128::from(i != 1);
        }
        if round % 2 == 0 {
            // Nearly in one plane, far away.
            for row in &mut rows {
                row[2] = row[0] + row[1] + row[3] * 100_000;
            }
            rows[3][0] += i128::from(random.i64(0..2));
        }
        let minor = |skip: usize| {
            let at: Vec<usize> = (0..4).filter(|&i| i != skip).collect();
            let m = |i: usize, j: usize| rows[at[i]][j];
            m(0, 0) * (m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1))
                - m(0, 1) * (m(1, 0) * m(2, 2) - m(1, 2) * m(2, 0))
                + m(0, 2) * (m(1, 0) * m(2, 1) - m(1, 1) * m(2, 0))
        };
        let expected: i128 = (0..4)
            .map(|i| rows[i][3] * minor(i) * if i % 2 == 0 { -1 } else { 1 })
            .sum();
        let found = sign(rows.map(|row| row.map(|number| number as f64)));
        assert_eq!(found.partial_cmp(&0.0), Some(expected.cmp(&0)), "{rows:?}");
        zeros += u32::from(expected == 0);
    }
    assert!(zeros > 1000);
}
