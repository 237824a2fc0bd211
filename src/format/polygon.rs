//! Triangles of polygons that a fan would not fill: concave ones.

use earcut::Earcut;
use glam::{DVec2, DVec3};

/// Polygons with more corners stay fans: cutting can take quadratic time.
const MOST_CORNERS: usize = 1024;

/// Cuts polygons; keeps its memory from one to the next.
#[derive(Default)]
pub(super) struct Cutter {
    earcut: Earcut<f64>,
    triangles: Vec<u32>,
}

impl Cutter {
    /// The triangles of a polygon, as numbers of its corners, two fewer triangles than corners, with the polygon's own
    /// sense. `None` where a fan around the first corner does as well, and where nothing fills it (its sides cross, or it
    /// has no area).
    pub(super) fn cut(&mut self, corners: &[DVec3]) -> Option<&[[u32; 3]]> {
        if corners.len() > MOST_CORNERS || corners.len() < 4 {
            return None;
        }
        let flat = flattened(corners);
        if is_convex(&flat) {
            return None;
        }
        self.earcut
            .earcut(flat.iter().map(DVec2::to_array), &[], &mut self.triangles);
        let sense = area(&flat).signum();
        let (triangles, _) = self.triangles.as_chunks_mut::<3>();
        for triangle in &mut *triangles {
            if area(&triangle.map(|i| flat[i as usize])).signum() == -sense {
                triangle.swap(1, 2);
            }
        }
        (triangles.len() == corners.len() - 2).then_some(triangles)
    }
}

/// The corners without the coordinate along which the polygon mostly faces.
fn flattened(corners: &[DVec3]) -> Vec<DVec2> {
    // Newell's normal; by differences, so that it does not matter how far away the polygon is.
    let middle = corners[0];
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let normal: DVec3 = sides.map(|(&a, &b)| (a - middle).cross(b - middle)).sum();
    let size = normal.abs();
    let drop = |p: DVec3| {
        let p = p - middle;
        if size.x >= size.y && size.x >= size.z {
            DVec2::new(p.y, p.z)
        } else if size.y >= size.z {
            DVec2::new(p.z, p.x)
        } else {
            DVec2::new(p.x, p.y)
        }
    };
    corners.iter().map(|&corner| drop(corner)).collect()
}

/// Twice the area, with the sense of the corners.
fn area(corners: &[DVec2]) -> f64 {
    let first = corners[0];
    let pairs = corners.windows(2);
    pairs
        .map(|pair| (pair[0] - first).perp_dot(pair[1] - first))
        .sum()
}

/// Whether no corner turns the other way, but for rounding.
fn is_convex(corners: &[DVec2]) -> bool {
    let area = area(corners);
    let next = |i: usize| corners[(i + 1) % corners.len()];
    (0..corners.len()).all(|i| {
        let (a, b, c) = (corners[i], next(i), next(i + 1));
        let turn = (b - a).perp_dot(c - b) * area.signum();
        turn >= -1e-6 * (b - a).length() * (c - b).length()
    })
}

#[cfg(test)]
mod tests {
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

    #[test]
    fn what_a_fan_fills_or_nothing_does_stays() {
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
        assert!(stays(&[[0.0, 0.0]; MOST_CORNERS + 1]));
    }
}
