use super::*;
use crate::generate::{Kind, Options, generate};
use glam::Vec3;

#[test]
fn lines_end_at_the_picture_wherever_their_ends_are() {
    for ends in [
        [[-1e300, 3.0], [1e300, 3.0]],
        [[1e38, -1e38], [-1e38, 1e38]],
        [[f64::NAN, 0.0], [1.0, 1.0]],
        [[f64::INFINITY, 0.0], [1.0, f64::NEG_INFINITY]],
        [[2.0, 2.0], [2.0, 2.0]],
    ] {
        let mut pixels = vec![0; 64];
        let mut canvas = Canvas {
            pixels: &mut pixels,
            width: 8,
            height: 8,
        };
        line(&mut canvas, ends[0], ends[1], 1);
        assert!(
            pixels.iter().filter(|&&pixel| pixel == 1).count() <= 10,
            "{ends:?}"
        );
    }
}

#[test]
fn levels_and_leaves_are_found() {
    let options = Options {
        seed: 0,
        count: Some(500),
    };
    let scene = generate(Kind::Spheres, options).unwrap().into_scene().unwrap();
    let bvh = Bvh::build(&scene);
    let stats = bvh.stats();
    assert_eq!(select(&bvh, Boxes::Hidden).len(), 0);
    assert_eq!(select(&bvh, Boxes::Level(0)).len(), 1);
    assert_eq!(
        select(&bvh, Boxes::Level(1)).len(),
        bvh.nodes()[bvh.root().index()].count as usize
    );
    assert_eq!(
        select(&bvh, Boxes::Leaves).len(),
        stats.triangle_blocks + stats.sphere_blocks
    );
    assert!(select(&bvh, Boxes::Level(1000)).is_empty());
    let nothing = Bvh::build(&crate::scene::SceneBuilder::new().finish());
    for which in [Boxes::Leaves, Boxes::Level(3)] {
        assert!(select(&nothing, which).is_empty());
    }
}

#[test]
fn boxes_are_drawn_where_they_are() {
    use scene::Projection::{Orthographic, Perspective};
    for projection in [Perspective { fov_degrees: 90.0 }, Orthographic { height: 20.0 }] {
        let pose = Pose {
            eye: DVec3::new(0.0, -10.0, 0.0),
            target: DVec3::ZERO,
            up: DVec3::Z,
            projection,
            lens: scene::Lens::PINHOLE,
        };
        let mut pixels = vec![0; 100 * 100];
        let mut canvas = Canvas {
            pixels: &mut pixels,
            width: 100,
            height: 100,
        };
        let flat = Aabb {
            lower: Vec3::new(-5.1, 0.0, -5.1),
            upper: Vec3::new(5.1, 0.0, 5.1),
        };
        draw(&mut canvas, &pose, DVec3::ZERO, std::iter::once(flat), 7);
        // The outline of a square of half the picture's side.
        assert_eq!([pixels[50 * 100 + 24], pixels[24 * 100 + 50]], [7, 7]);
        assert_eq!(pixels[50 * 100 + 50], 0);
        let drawn = pixels.iter().filter(|&&pixel| pixel == 7).count();
        assert!((190..=210).contains(&drawn), "{drawn}");
    }
}

#[test]
fn around_and_behind_the_eye_nothing_breaks() {
    let pose = Pose::classic_view(1).unwrap();
    let mut pixels = vec![0; 33 * 17];
    let mut canvas = Canvas {
        pixels: &mut pixels,
        width: 33,
        height: 17,
    };
    for size in [1e-6, 1.0, 8.0, 1e9] {
        let around = Aabb {
            lower: Vec3::splat(-size),
            upper: Vec3::splat(size),
        };
        draw(&mut canvas, &pose, DVec3::ZERO, std::iter::once(around), 1);
    }
}
