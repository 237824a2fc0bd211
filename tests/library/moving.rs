//! Animated scenes: placements between keyframes have their closed forms, and a frame equals that of a static scene, in all
//! modes.

use crate::{instances::brute_force_agrees, sameness};
use glam::{DMat3, DVec3};
use octray::{
    accel::Bvh,
    error::LoadError,
    format::load_from_bytes,
    render::{Film, Mode, Settings, render},
    scene::{
        CameraError, CameraMotion, Lens, MAX_KEYFRAMES, MaterialId, Motion, Projection, Scene, SceneBuilder,
        Step, Transform, View,
    },
};
use std::{ops::ControlFlow, path::Path};

/// A wedge.
const WEDGE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

const NO_FACES: &str = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n\
    property float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n";

fn load(text: &str) -> Result<Scene, LoadError> {
    load_from_bytes(text.as_bytes(), Path::new("a.scn"), &mut |path| {
        Ok(match path.to_str() {
            Some("places.txt") => b"0 0 0\n2 0 0\n0 3 0\n".to_vec(),
            Some("none.txt") => b"# nothing\n".to_vec(),
            Some("none.ply") => NO_FACES.into(),
            _ => WEDGE.into(),
        })
    })
}

/// The matrix and the offset.
fn numbers(transform: &Transform) -> (DMat3, DVec3) {
    let bits = transform.bits().map(f64::from_bits);
    let linear = DMat3::from_cols_slice(&bits[..9]);
    (linear, DVec3::from_slice(&bits[9..]))
}

fn motion(keyframes: &[(f64, Step)]) -> Motion {
    let mut motion = Motion::default();
    for (time, step) in keyframes {
        motion.add(*time, vec![*step]).expect("a keyframe");
    }
    motion
}

fn rotation(axis: [f64; 3], degrees: f64) -> Step {
    let axis = DVec3::from_array(axis);
    Step::Rotate { axis, degrees }
}

fn is_rotation(found: &Motion, time: f64, axis: [f64; 3], degrees: f64) {
    let expected = Transform::IDENTITY.then_step(&rotation(axis, degrees));
    let (found, expected) = (numbers(&found.at(time)).0, numbers(&expected).0);
    assert!(
        found.abs_diff_eq(expected, 1e-12),
        "at {time}: {found}, {expected}"
    );
}

#[test]
fn steps_between_keyframes_have_closed_forms() {
    let moved = motion(&[
        (2.0, Step::Translate(DVec3::new(1.0, 2.0, 3.0))),
        (6.0, Step::Translate(DVec3::new(3.0, -2.0, 3.0))),
        (7.0, Step::Translate(DVec3::ZERO)),
    ]);
    for (time, expected) in [
        (-1.0, [1.0, 2.0, 3.0]),
        (2.0, [1.0, 2.0, 3.0]),
        (4.0, [2.0, 0.0, 3.0]),
        (6.0, [3.0, -2.0, 3.0]),
        (6.5, [1.5, -1.0, 1.5]),
        (7.0, [0.0; 3]),
        (1e9, [0.0; 3]),
    ] {
        assert_eq!(
            numbers(&moved.at(time)),
            (DMat3::IDENTITY, expected.into()),
            "{time}"
        );
    }
    let scaled = motion(&[
        (0.0, Step::Scale(DVec3::new(1.0, -2.0, 4.0))),
        (1.0, Step::Scale(DVec3::new(3.0, -4.0, 2.0))),
    ]);
    let expected = DMat3::from_diagonal(DVec3::new(2.0, -3.0, 3.0));
    assert_eq!(numbers(&scaled.at(0.5)).0, expected);

    // Two axes: the shortest way, half of it after half of the time. Rotations about x and y by 90 degrees are 120 degrees
    // apart; about the diagonal of both.
    let turned = motion(&[
        (1.0, rotation([0.0, 0.0, 1.0], 0.0)),
        (3.0, rotation([0.0, 0.0, 2.0], 90.0)),
    ]);
    is_rotation(&turned, 2.0, [0.0, 0.0, 1.0], 45.0);
    let angle = 2.0 * (2.0_f64.sqrt() / 3.0_f64.sqrt()).acos();
    let turned = motion(&[
        (0.0, rotation([1.0, 0.0, 0.0], 90.0)),
        (2.0, rotation([0.0, 1.0, 0.0], 90.0)),
    ]);
    is_rotation(&turned, 1.0, [1.0, 1.0, 0.0], angle.to_degrees());
    is_rotation(&turned, 0.0, [1.0, 0.0, 0.0], 90.0);
    is_rotation(&turned, 2.0, [0.0, 1.0, 0.0], 90.0);
    // The other name of the second rotation makes no difference.
    let turned = motion(&[
        (0.0, rotation([1.0, 0.0, 0.0], 90.0)),
        (2.0, rotation([0.0, -1.0, 0.0], 270.0)),
    ]);
    is_rotation(&turned, 1.0, [1.0, 1.0, 0.0], angle.to_degrees());
    // At even speed.
    let turned = motion(&[
        (0.0, rotation([1.0, 0.0, 0.0], 180.0)),
        (3.0, rotation([0.0, 1.0, 0.0], 180.0)),
    ]);
    let axis = |degrees: f64| [degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0];
    is_rotation(&turned, 1.0, axis(30.0), 180.0);

    // One axis, or its opposite: as many turns as the numbers say.
    let turned = motion(&[
        (0.0, rotation([0.0, 0.0, 3.0], 0.0)),
        (8.0, rotation([0.0, 0.0, 1.0], -720.0)),
    ]);
    is_rotation(&turned, 1.0, [0.0, 0.0, 1.0], -90.0);
    let turned = motion(&[
        (0.0, rotation([0.0, 0.0, 1.0], 10.0)),
        (8.0, rotation([0.0, 0.0, -1.0], 350.0)),
    ]);
    is_rotation(&turned, 4.0, [0.0, 0.0, 1.0], -170.0);
}

#[test]
fn cameras_between_keyframes_have_closed_forms() {
    let view = |eye: [f64; 3], up: [f64; 3], fov_degrees: f64, focus: f64| View {
        eye: eye.into(),
        target: DVec3::new(0.0, 0.0, 1.0),
        up: up.into(),
        projection: Projection::Perspective { fov_degrees },
        lens: Lens {
            aperture: 0.1 * focus,
            focus: Some(focus),
        },
    };
    let mut motion = CameraMotion::default();
    motion
        .add(1.0, view([5.0, 0.0, 2.0], [0.0, 0.0, 7.0], 30.0, 1.0))
        .expect("a view");
    motion
        .add(25.0, view([0.0, 5.0, 4.0], [0.0, 0.0, 1.0], 60.0, 4.0))
        .expect("a view");
    let found = |time| motion.at(time).expect("a camera").view();
    assert_eq!(found(7.0), view([3.75, 1.25, 2.5], [0.0, 0.0, 1.0], 37.5, 1.75));
    assert_eq!(found(0.0), view([5.0, 0.0, 2.0], [0.0, 0.0, 7.0], 30.0, 1.0));
    assert_eq!(found(99.0), view([0.0, 5.0, 4.0], [0.0, 0.0, 1.0], 60.0, 4.0));
}

const MOVING: &str = "\
light 9 -4 10 0.7
light -3 -6 4 0.3 radius 0.5
camera eye 5 -3 3 target 0 0 0.5 fov 40
  at 1 // a comment

  // and another
  at 25 eye 5 3 1
material matte cd 0.4 0.7 0.9
instance a.obj scale 0.5
  at 1
  at 25 scale 1 1 3 rotate 0 0 1 180 translate 0.5 -1 0.25
material reflection
instance a.obj rotate 0 0 1 30 placements places.txt scale 0.25
  at 5.5 rotate 1 0 0 0
  at 13 rotate 0 1 1 75
instance a.obj scale 2 2 0.1 translate -1 -1 -0.4
";

/// The scene of frame 13, without keyframes; except for the placements.
const STANDING: &str = "\
light 9 -4 10 0.7
light -3 -6 4 0.3 radius 0.5
camera eye 5 0 2 target 0 0 0.5 fov 40
material matte cd 0.4 0.7 0.9
instance a.obj scale 0.5 scale 1 1 2 rotate 0 0 1 90 translate 0.25 -0.5 0.125
material reflection
instance a.obj rotate 0 0 1 30 placements places.txt scale 0.25 rotate 0 1 1 75
instance a.obj scale 2 2 0.1 translate -1 -1 -0.4
";

fn film(scene: &Scene, bvh: &Bvh, mode: Mode) -> Film {
    let settings = Settings {
        mode,
        ..sameness::sized(48, 40, 4)
    };
    let camera = scene.cameras()[0].camera;
    let frame = render(scene, bvh, &camera, &settings, &|_| ControlFlow::Continue(()));
    frame.expect("a small picture").film
}

fn bits(film: &Film) -> Vec<[u32; 3]> {
    film.pixels()
        .iter()
        .map(|pixel| pixel.map(f32::to_bits))
        .collect()
}

#[test]
fn a_moved_frame_is_that_of_a_scene_that_stands_there() {
    let mut scene = load(MOVING).expect("a scene");
    assert_eq!((scene.frame_count(), scene.keyframe_count()), (25, 6));
    assert_eq!(scene.moving_counts(), [4, 1]);
    let mut bvh = Bvh::build(&scene);
    let first = film(&scene, &bvh, Mode::Scalar);
    let memory = bvh.stats().memory_bytes;
    scene.set_time(13.0).expect("a frame");
    bvh.follow(&scene);
    let standing = load(STANDING).expect("a scene");
    assert_eq!(scene.bounds(), standing.bounds());
    let expected = bits(&film(&standing, &Bvh::build(&standing), Mode::Packet));
    assert!(expected != bits(&first));
    for mode in [Mode::Packet, Mode::Scalar] {
        assert!(bits(&film(&scene, &bvh, mode)) == expected, "{mode:?}");
    }
    let camera = scene.cameras()[0].camera;
    sameness::check("frame 13", &scene, &camera, &sameness::sized(31, 18, 1));
    brute_force_agrees(&scene, &camera);
    // Back, with all that was kept.
    scene.set_time(1.0).expect("a frame");
    bvh.follow(&scene);
    assert_eq!(bvh.stats().memory_bytes, memory);
    assert!(bits(&film(&scene, &bvh, Mode::Scalar)) == bits(&first));
    assert!(bits(&film(&scene, &bvh, Mode::Packet)) == bits(&first));
}

#[test]
fn a_time_at_which_something_cannot_be_placed_is_an_error_with_its_place() {
    let mut scene = load(
        "camera eye 1 0 0 target 0 0 0\n at 1\n at 3 eye -1 0 0\n\
         instance a.obj translate 0.9e9 0 0\n at 1\n at 3 rotate 0 0 1 90",
    )
    .expect("a scene");
    let before = scene.cameras()[0].camera;
    let error = scene.set_time(2.0).expect_err("the eye on its target");
    assert!(
        error.to_string().starts_with("a.scn:1:1: at 2: eye and target"),
        "{error}"
    );
    assert_eq!((scene.cameras()[0].camera, scene.time()), (before, 1.0));
    assert!(scene.set_time(f64::NAN).is_err());
    scene.set_time(3.0).expect("a frame");
    let still = load("sphere 0 0 0 1").expect("a scene");
    assert_eq!((still.frame_count(), still.moves()), (1, false));
}

/// Frames are counted in the text of a scene before it is loaded, so the loaded scene has as many.
#[test]
fn keyframes_count_though_nothing_is_there_to_move() {
    for (instance, note) in [
        (
            "instance a.obj placements none.txt",
            Some("none.txt: no placements"),
        ),
        ("instance none.ply", None),
    ] {
        let text = format!("{instance}\n at 1\n at 19.5 translate 0 0 1\nmaterial 0\nsphere 0 0 0 1");
        let mut scene = load(&text).expect(instance);
        assert_eq!(
            (scene.frame_count(), scene.keyframe_count()),
            (20, 2),
            "{instance}"
        );
        assert_eq!(
            (scene.moves(), scene.moving_counts()),
            (false, [0, 0]),
            "{instance}"
        );
        scene.set_time(7.0).expect(instance);
        let notes = &scene.sources().notes;
        assert!(
            note.is_none_or(|note| notes.iter().any(|known| known == note)),
            "{notes:?}"
        );
    }
}

/// The keyframe that opens the lens need not be the first with a focus.
#[test]
fn what_is_refused_leaves_no_keyframes() {
    let mut builder = SceneBuilder::new();
    let prototype = builder.add_prototype(|builder| builder.add_sphere(glam::Vec3::ZERO, 1.0, MaterialId(1)));
    let prototype = prototype.expect("a prototype");
    let far = motion(&[
        (1.0, Step::Translate(DVec3::ZERO)),
        (100.0, Step::Translate(DVec3::X * 1e12)),
    ]);
    let many = |count: usize| {
        let times = 1..=count;
        motion(
            &times
                .map(|time| (time as f64, Step::Translate(DVec3::X)))
                .collect::<Vec<_>>(),
        )
    };
    let mut add = |motion| builder.add_moving_instance(prototype, &Transform::IDENTITY, motion);
    add(far).expect_err("too far away");
    add(many(MAX_KEYFRAMES - 1)).expect("as many as fit but one");
    add(many(2)).expect_err("too many");
    add(many(1)).expect("the last one");
    let scene = builder.finish();
    assert_eq!(scene.keyframe_count(), MAX_KEYFRAMES);
    assert_eq!(scene.frame_count() as usize, MAX_KEYFRAMES - 1);
    let none = CameraMotion::default().at(1.0).expect_err("no camera");
    assert_eq!(none, CameraError::NoKeyframes);
}

#[test]
fn a_lens_that_opens_has_a_focus_in_all_keyframes() {
    let text = |more: &str| format!("camera eye 1 0 0 target 0 0 0\n at 1 focus 5\n at 9 focus 4{more}\n");
    assert!(load(&text(" aperture 0.1")).is_ok());
    // The camera's line may say either.
    for keyframe in ["", " focus 4"] {
        let text = format!("camera eye 1 0 0 target 0 0 0 focus 5\n at 1\n at 9{keyframe} aperture 0.1\n");
        assert!(load(&text).is_ok(), "{text}");
    }
    let own = "camera eye 1 0 0 target 0 0 0 focus 5\n at 1\n at 9 fov 50\n".to_owned();
    for (text, place) in [(text(""), "2:13"), (own, "1:37")] {
        let error = load(&text).expect_err("no aperture").to_string();
        let expected = format!("a.scn:{place}: `focus` without `aperture`");
        assert!(error.starts_with(&expected), "{error}");
    }
}
