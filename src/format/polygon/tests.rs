use super::*;

fn points(corners: &[[f64; 2]], at: impl Fn(f64, f64) -> DVec3) -> Vec<DVec3> {
    corners.iter().map(|&[x, y]| at(x, y)).collect()
}

fn total_area(corners: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| corners[i as usize]);
        (b - a).cross(c - a).length() * 0.5
    };
    triangles.iter().map(of).sum()
}

const LETTER: [[f64; 2]; 8] = [
    [0.0, 0.0],
    [3.0, 0.0],
    [3.0, 3.0],
    [2.0, 3.0],
    [2.0, 1.0],
    [1.0, 1.0],
    [1.0, 3.0],
    [0.0, 3.0],
];

#[test]
fn concave_polygons_are_filled_once() {
    let mut cutter = Cutter::default();
    let planes: [fn(f64, f64) -> DVec3; 3] = [
        |x, y| DVec3::new(x, y, 1e6),
        |x, y| DVec3::new(5.0, x, y),
        |x, y| DVec3::new(-y, 3.0, x + 1e3),
    ];
    for at in planes {
        for start in 0..LETTER.len() {
            for turned in [false, true] {
                let mut letter = LETTER;
                letter.rotate_left(start);
                if turned {
                    letter.reverse();
                }
                let corners = points(&letter, at);
                let triangles = cutter.cut(&corners).expect("a U is concave").to_vec();
                assert_eq!(triangles.len(), 6);
                // 7 of 9 squares.
                assert!((total_area(&corners, &triangles) - 7.0).abs() < 1e-9);
                let facing = |t: &[u32; 3]| {
                    let [a, b, c] = t.map(|i| corners[i as usize]);
                    (b - a).cross(c - a).normalize()
                };
                let first = facing(&triangles[0]);
                assert!(triangles.iter().all(|t| facing(t).dot(first) > 0.99));
            }
        }
    }
}

/// A polygon of `teeth` teeth around a disc, 4 corners each, and half a tooth's depth.
fn gear(teeth: usize) -> Vec<[f64; 2]> {
    let corner = |i: usize| {
        let (angle, radius) = (
            i as f64 / teeth as f64 * std::f64::consts::FRAC_PI_2,
            if i % 4 < 2 { 1.0 } else { 0.9 },
        );
        [radius * libm::cos(angle), radius * libm::sin(angle)]
    };
    (0..4 * teeth).map(corner).collect()
}

#[test]
fn large_polygons_are_filled_once() {
    let mut cutter = Cutter::default();
    let comb = |i: usize| [(i / 2) as f64, if i % 4 == 1 || i % 4 == 2 { 5.0 } else { 0.0 }];
    let comb: Vec<[f64; 2]> = [[499.0, -1.0], [0.0, -1.0]]
        .into_iter()
        .chain((0..1000).map(comb))
        .collect();
    let keyhole = || {
        let outer = gear(64).into_iter().chain([gear(64)[0]]);
        let inner = gear(64).into_iter().chain([gear(64)[0]]).rev();
        outer.chain(inner.map(|[x, y]| [0.5 * x, 0.5 * y])).collect()
    };
    let spiral = |i: usize| {
        let (step, radius) = if i < 300 { (i, 1.0) } else { (599 - i, 1.1) };
        let (angle, radius) = (step as f64 * 0.1, radius * libm::exp(step as f64 * 0.005));
        [radius * libm::cos(angle), radius * libm::sin(angle)]
    };
    for polygon in [
        gear(17),
        gear(256),
        comb,
        keyhole(),
        (0..600).map(spiral).collect(),
    ] {
        for turned in [false, true] {
            let mut polygon: Vec<[f64; 2]> = polygon.clone();
            if turned {
                polygon.reverse();
            }
            let corners = points(&polygon, |x, y| DVec3::new(x, y, 3.0));
            let triangles = cutter.cut(&corners).expect("a simple polygon").to_vec();
            assert_eq!(triangles.len(), corners.len() - 2);
            let area = area(&flattened(&corners)).abs() / 2.0;
            assert!((total_area(&corners, &triangles) - area).abs() < 1e-9 * area);
        }
    }
}

#[test]
fn other_polygons_stay_fans() {
    let mut cutter = Cutter::default();
    let mut stays = |corners: &[[f64; 2]]| {
        cutter
            .cut(&points(corners, |x, y| DVec3::new(x, y, 0.0)))
            .is_none()
    };
    assert!(stays(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]));
    assert!(stays(&[
        [0.0, 0.0],
        [1.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [0.0, 1.0]
    ]));
    assert!(stays(&[[0.0, 0.0]; 5]));
    assert!(stays(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]));
}

/// Teeth along a diagonal, `turned` so that a fan fills none of them.
fn saw(corners: usize) -> Vec<[f64; 2]> {
    let n = corners as f64;
    let tooth = |i: usize| {
        let (x, height) = (i as f64, if i % 2 == 1 { n } else { 0.0 });
        [x - height, x + height]
    };
    let base = [[n + 1.0, n - 1.0], [1.0, -1.0]].into_iter();
    base.chain((0..corners - 2).map(tooth)).collect()
}

#[test]
fn very_large_polygons_are_filled_or_counted() {
    let mut cutter = Cutter::default();
    let fills = |cutter: &mut Cutter, polygon: &[[f64; 2]]| {
        let corners = points(polygon, |x, y| DVec3::new(x, y, 0.0));
        let area = area(&flattened(&corners)).abs() / 2.0;
        let triangles = cutter.cut(&corners).unwrap_or_default();
        (total_area(&corners, triangles) - area).abs() < 1e-9 * area
    };
    assert!(fills(&mut cutter, &gear(5000)));
    assert!(fills(&mut cutter, &saw(1024)));
    assert_eq!(cutter.given_up, 0);
    assert!(!fills(&mut cutter, &saw(20_000)));
    assert!(cutter.cut(&vec![DVec3::ZERO; MOST_CORNERS + 1]).is_none());
    assert_eq!(cutter.given_up, 1);
    let too_many = gear(MOST_CORNERS / 4 + 1);
    assert!(!fills(&mut cutter, &too_many));
    assert_eq!(cutter.given_up, 2);
}
