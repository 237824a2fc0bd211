use super::*;
use crate::scene::{Distortion, ImagePlane};

fn found(text: &str, size: [u32; 2]) -> Result<Poses, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("t.json");
    std::fs::write(&path, text).expect("a file");
    let poses = PoseFile::read(&path).and_then(|file| file.poses(size, false));
    poses.map_err(|error| error.text().unwrap_or_default())
}

#[test]
fn saved_poses_are_read_again() {
    let cameras = [
        (DVec3::new(3.0, -2.0, 1.0), DVec3::Z),
        (DVec3::new(0.1, 0.2, -4.0), DVec3::Y),
    ]
    .map(|(eye, up)| Camera::look_at(eye, DVec3::new(0.0, 0.0, 0.5), up, 40.0).expect("a camera"));
    let mut saved = SavedPoses::new([640, 360], 0.001);
    for camera in &cameras {
        let picture = "train/r_7.png".into();
        saved.push(
            PoseFiles {
                picture,
                ..PoseFiles::default()
            },
            camera,
        );
    }
    let text = serde_json::to_string(&saved.file()).expect("JSON");
    let read = found(&text, [640, 360]).expect("poses");
    assert!(read.notes.is_empty());
    for (pose, camera) in read.poses.iter().zip(&cameras) {
        assert_eq!(pose.name, "r_7");
        let (a, b) = (pose.camera.view(), camera.view());
        let direction = |view: &View| (view.target - view.eye).normalize();
        assert!((a.eye - b.eye).length() < 1e-12 && (direction(&a) - direction(&b)).length() < 1e-12);
        let (Projection::Perspective { fov_degrees: a }, Projection::Perspective { fov_degrees: b }) =
            (a.projection, b.projection)
        else {
            panic!("perspective cameras")
        };
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}

/// The file of the synthetic NeRF scenes has a horizontal angle alone.
#[test]
fn a_horizontal_angle_is_enough() {
    let frame = r#"{"file_path":"./train/r_0","rotation":0.1,"transform_matrix":[[1,0,0,0],[0,0,-1,-4],[0,1,0,0.5],[0,0,0,1]]}"#;
    let text = format!(r#"{{"camera_angle_x":0.6911,"frames":[{frame}]}}"#);
    let poses = found(&text, [8, 8]).expect("poses");
    let view = poses.poses[0].camera.view();
    assert_eq!(view.eye, DVec3::new(0.0, -4.0, 0.5));
    assert_eq!(
        (view.target - view.eye, poses.poses[0].name.as_str()),
        (DVec3::Y, "r_0")
    );
    let wide = found(&text, [16, 8]).expect("poses").poses[0].camera.view();
    assert!(format!("{:?}", wide.projection) < format!("{:?}", view.projection));
    let other = text.replacen('{', r#"{"k5":0.1,"cx":10,"w":40,"#, 1);
    assert_eq!(found(&other, [8, 8]).expect("poses").notes.len(), 2);
}

#[test]
fn broken_files_are_refused() {
    let frame =
        |matrix: &str| format!(r#"{{"camera_angle_x":1,"frames":[{{"transform_matrix":{matrix}}}]}}"#);
    for (text, expected) in [
        (
            String::new(),
            "t.json: the file is empty, expected a NeRF transforms.json",
        ),
        (
            "{".to_owned(),
            "1:1: not a NeRF transforms.json: the file is cut short",
        ),
        (r#"{"frames":[]}"#.to_owned(), "0 frames"),
        (frame("[[1,0,0]]"), "not a NeRF transforms.json"),
        (frame("[[1,0,0,0]]"), "frames[0]: transform_matrix has 1 rows"),
        (
            frame("[[0,0,0,0],[0,0,0,0],[0,0,0,0]]"),
            "frames[0]: the first column of transform_matrix has length 0",
        ),
        (
            frame("[[1,0,0,0],[0,1,0,0],[0,0,0,0]]"),
            "frames[0]: the third column of transform_matrix has length 0",
        ),
        (
            frame("[[0,0,0,0],[0,1,0,0],[0,0,1,0]]"),
            "frames[0]: the first column of transform_matrix has length 0",
        ),
        (
            frame("[[1,0,0,1e999],[0,1,0,0],[0,0,1,0]]"),
            "not a NeRF transforms.json",
        ),
        (
            frame("[[1,0,0,0],[0,1,0,0],[0,0,1,0]]").replace("\"camera_angle_x\":1,", ""),
            "no field of view",
        ),
        (
            frame("[[1,0,0,0],[0,1,0,0],[0,0,1,0]]").replace("x\":1,", "x\":9,"),
            "frames[0]: `camera_angle_x` is 9, expected radians, between 0 and pi",
        ),
        (
            frame("[[1,0,0,0],[0,1,0,0],[0,0,1,0],[3,2,1,1]]"),
            "frames[0]: the last row of transform_matrix is [3.0, 2.0, 1.0, 1.0], expected [0, 0, 0, 1]",
        ),
        (
            frame("[[1,0,0,0],[0,1,0,0],[0,0,1,0]]").replacen('{', r#"{"w":0,"h":9,"cx":3,"#, 1),
            "frames[0]: `w` is 0, expected",
        ),
        (
            frame("[[1,0,0,0],[0,1,0,0],[0,0,1,0]]").replacen('{', r#"{"h":-9,"#, 1),
            "frames[0]: `h` is -9, expected",
        ),
        (
            frame("[[1,0,0,0],[0,1,0,0],[0,0,1,0]]").replacen('{', r#"{"fl_y":-9,"#, 1),
            "frames[0]: `fl_y` is -9, expected a focal length in pixels, more than 0",
        ),
    ] {
        let error = found(&text, [8, 8]).expect_err(&text);
        assert!(error.contains(expected), "{text}: {error}");
    }
}

#[test]
fn faults_of_lenses_are_told() {
    let matrix = "[[1,0,0,0],[0,1,0,0],[0,0,1,0]]";
    for (lens, expected) in [
        (
            r#""camera_angle_x":50"#,
            "`camera_angle_x` is 50, expected radians, between 0 and pi",
        ),
        (
            r#""camera_angle_x":3.15"#,
            "`camera_angle_x` is 3.15, expected radians",
        ),
        (r#""camera_angle_x":0"#, "`camera_angle_x` is 0, expected radians"),
        (
            r#""camera_angle_x":1,"camera_angle_y":40"#,
            "`camera_angle_y` is 40,",
        ),
        (r#""w":9"#, "no field of view: expected"),
        (
            r#""camera_angle_x":1,"w":200,"h":100,"cx":1e300"#,
            "the principal point is 1.0000000000000001e298 picture heights right",
        ),
        (r#""camera_angle_x":1,"h":-1e300"#, "`h` is -1e300, expected"),
    ] {
        let text = format!(r#"{{{lens},"frames":[{{"transform_matrix":{matrix}}}]}}"#);
        let error = found(&text, [8, 8]).expect_err(lens);
        assert!(error.contains(expected), "{lens}: {error}");
    }
    // A focal length counts before an angle.
    let poses = posed(r#""camera_angle_x":50,"fl_x":300,"w":320,"h":240,"#, "");
    assert!(poses.notes.is_empty());
}

/// A pose of a file with that lens, and its notes.
fn posed(lens: &str, frame: &str) -> Poses {
    let matrix = "[[1,0,0,0],[0,1,0,0],[0,0,1,0]]";
    let text = format!(r#"{{{lens}"frames":[{{{frame}"transform_matrix":{matrix}}}]}}"#);
    found(&text, [320, 240]).unwrap_or_else(|error| panic!("{text}: {error}"))
}

#[test]
fn intrinsics_are_those_of_the_file() {
    // At half of the file's size.
    let lens = r#""w":640,"h":480,"fl_x":1000,"fl_y":700,"cx":340,"cy":230,"#;
    let frame = r#""cx":300,"#;
    for (common, frame, cx) in [(lens, "", 170.0), (lens, frame, 150.0), ("", lens, 170.0)] {
        let poses = posed(common, frame);
        assert!(poses.notes.is_empty(), "{:?}", poses.notes);
        let found = poses.poses[0].camera.intrinsics(320, 240).expect("perspective");
        let numbers = [found.focal, found.principal_point].concat();
        for (found, expected) in numbers.iter().zip([500.0, 350.0, cx, 115.0]) {
            assert!((found - expected).abs() < 1e-9, "{frame}: {numbers:?}");
        }
    }
    // A focal length along one axis is for both; angles and focal lengths are rounded.
    for lens in [
        r#""w":640,"h":480,"fl_x":700,"cx":320,"cy":240,"#,
        r#""w":640,"h":480,"fl_y":700,"camera_angle_x":0.8575560548920328,"#,
    ] {
        let camera = posed(lens, "").poses[0].camera;
        assert_eq!(camera.image_plane(), ImagePlane::CENTERED, "{lens}");
        let focal = camera.intrinsics(320, 240).expect("perspective").focal[1];
        assert!((focal - 350.0).abs() < 1e-9, "{lens}: {focal}");
    }
}

/// A frame's own angle or focal length counts before those of the file, whatever their keys.
#[test]
fn a_frame_has_its_own_field_of_view() {
    let lens = r#""w":640,"h":480,"fl_x":1000,"fl_y":700,"camera_angle_y":0.2,"#;
    for frame in [
        r#""camera_angle_x":1.6,"#,
        r#""camera_angle_y":1.2,"#,
        r#""fl_x":500,"#,
        r#""fl_y":500,"#,
        r#""fl_x":500,"fl_y":400,"#,
    ] {
        let common = r#""w":640,"h":480,"#;
        let [own, expected] = [posed(lens, frame), posed(common, frame)]
            .map(|poses| poses.poses[0].camera.intrinsics(320, 240).expect("perspective"));
        assert_eq!(own.focal, expected.focal, "{frame}");
    }
}

#[test]
fn mirrored_matrices_are_noted() {
    let pose = |x: i32| format!(r#"{{"transform_matrix":[[{x},0,0,0],[0,1,0,0],[0,0,1,0]]}}"#);
    for (signs, count) in [([1, 1], 0), ([1, -1], 1), ([-1, -1], 1)] {
        let frames = signs.map(pose).join(",");
        let text = format!(r#"{{"camera_angle_x":1,"frames":[{frames}]}}"#);
        let notes = found(&text, [8, 8]).expect("poses").notes;
        let mirrored = notes.iter().filter(|note| note.contains("mirroring"));
        assert_eq!((mirrored.count(), notes.len()), (count, count), "{signs:?}");
    }
}

#[test]
fn sheared_matrices_are_noted() {
    for (shear, count) in [(0.0, 0), (0.001, 0), (0.5, 1)] {
        let matrix = format!("[[2,{shear},0,0],[0,2,0,0],[0,0,2,0]]");
        let text = format!(r#"{{"camera_angle_x":1,"frames":[{{"transform_matrix":{matrix}}}]}}"#);
        let notes = found(&text, [8, 8]).expect("poses").notes;
        let sheared = notes.iter().filter(|note| note.contains("shear"));
        assert_eq!((sheared.count(), notes.len()), (count, count), "{shear}");
    }
}

#[test]
fn lenses_that_are_not_known_are_noted() {
    for lens in [
        r#""camera_model":"THIN_PRISM_FISHEYE","#,
        r#""camera_model":"FISHEYE624","k1":0.1,"#,
        r#""camera_model":"EQUIRECTANGULAR","#,
        r#""camera_model":"OPENCV_FISHEYE","p1":0.1,"#,
        r#""k5":0.1,"#,
        r#""camera_model":"OPENCV","k6":-0.1,"#,
        r#""distortion_params":[0,0.1,0,0],"#,
        r#""equirectangular":true,"#,
        r#""latlong":true,"#,
        r#""ftheta_p0":0.5,"#,
    ] {
        for in_frame in [false, true] {
            let angle = r#""camera_angle_x":1,"#;
            let poses = if in_frame {
                posed(angle, lens)
            } else {
                posed(&format!("{angle}{lens}"), "")
            };
            let [note] = &poses.notes[..] else {
                panic!("{lens}: {:?}", poses.notes)
            };
            assert!(note.contains("lens distortion"), "{lens}: {note}");
            assert_eq!(poses.poses[0].camera.distortion(), None, "{lens}");
        }
    }
    for lens in [
        r#""camera_model":"OPENCV","k1":0,"k2":0.0,"k3":0,"k4":0,"p1":0,"p2":0,"#,
        r#""camera_model":"PINHOLE","distortion_params":[0,0,0,0,0,0],"#,
        r#""is_fisheye":false,"latlong":null,"#,
    ] {
        let poses = posed(&format!(r#"{lens}"camera_angle_x":1,"#), "");
        assert!(poses.notes.is_empty(), "{lens}: {:?}", poses.notes);
        assert_eq!(poses.poses[0].camera.distortion(), None, "{lens}");
    }
}

fn perspective(radial: [f64; 4], divisor: [f64; 3], tangential: [f64; 2]) -> Distortion {
    Distortion::Perspective {
        radial,
        divisor,
        tangential,
    }
}

/// Lenses of a file, or of a frame, and what they are.
#[test]
fn distortion_is_that_of_the_file() {
    let radial = |radial| perspective(radial, [0.0; 3], [0.0; 2]);
    let fisheye = |radial| Distortion::Fisheye { radial };
    for (lens, expected) in [
        (r#""k1":-0.1,"#, radial([-0.1, 0.0, 0.0, 0.0])),
        (r#""k3":0.1,"k4":-0.2,"#, radial([0.0, 0.0, 0.1, -0.2])),
        (
            r#""camera_model":"OPENCV","k1":1,"k2":2,"k3":3,"k4":4,"p1":5,"p2":6,"#,
            perspective([1.0, 2.0, 3.0, 4.0], [0.0; 3], [5.0, 6.0]),
        ),
        (
            r#""camera_model":"SIMPLE_RADIAL","k1":0.5,"#,
            radial([0.5, 0.0, 0.0, 0.0]),
        ),
        (
            r#""camera_model":"FULL_OPENCV","k1":1,"k2":2,"k3":3,"k4":4,"k5":5,"k6":6,"p1":7,"p2":8,"#,
            perspective([1.0, 2.0, 3.0, 0.0], [4.0, 5.0, 6.0], [7.0, 8.0]),
        ),
        (r#""camera_model":"OPENCV_FISHEYE","#, fisheye([0.0; 4])),
        (
            r#""is_fisheye":true,"k2":0.1,"p1":0,"#,
            fisheye([0.0, 0.1, 0.0, 0.0]),
        ),
        (
            r#""camera_model":"OPENCV_FISHEYE","k1":1,"k2":2,"k3":3,"k4":4,"#,
            fisheye([1.0, 2.0, 3.0, 4.0]),
        ),
    ] {
        let angle = r#""camera_angle_x":1,"#;
        for (common, frame) in [(format!("{angle}{lens}"), ""), (angle.to_owned(), lens)] {
            let poses = posed(&common, frame);
            assert!(poses.notes.is_empty(), "{common} {frame}: {:?}", poses.notes);
            assert_eq!(
                poses.poses[0].camera.distortion(),
                Some(expected),
                "{common} {frame}"
            );
        }
    }
    // A frame's coefficient counts before that of the file.
    let poses = posed(r#""camera_angle_x":1,"k1":9,"k2":0.2,"#, r#""k1":0.1,"#);
    let expected = radial([0.1, 0.2, 0.0, 0.0]);
    assert_eq!(poses.poses[0].camera.distortion(), Some(expected));
    let text =
        r#"{"camera_angle_x":1,"k1":1e13,"frames":[{"transform_matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,0]]}]}"#;
    let error = found(text, [8, 8]).expect_err("it is too large");
    assert!(
        error.contains("frames[0]: the distortion has the coefficient"),
        "{error}"
    );
}

/// Distortions and intrinsics are read again as they were, shared by all frames or not.
#[test]
fn saved_distortions_are_read_again() {
    let camera = |distortion| {
        let camera = Camera::look_at(DVec3::X, DVec3::ZERO, DVec3::Z, 40.0).expect("a camera");
        camera.with_distortion(distortion).expect("a distortion")
    };
    let brown = Some(perspective([0.1, -0.2, 0.0, 0.0], [0.0; 3], [0.01, 0.0]));
    let more = Some(perspective([0.1, 0.0, 0.3, -0.4], [0.0; 3], [0.0, 0.02]));
    let full = Some(perspective([0.1, 0.2, 0.3, 0.0], [0.0, 0.5, 0.6], [0.01, 0.02]));
    let fisheye = Some(Distortion::Fisheye {
        radial: [0.01, 0.0, 0.0, -0.002],
    });
    for (pair, model, in_file) in [
        ([None, None], None, false),
        ([brown, brown], Some("OPENCV"), true),
        ([more, more], Some("OPENCV"), true),
        ([full, full], Some("FULL_OPENCV"), true),
        ([fisheye, fisheye], Some("OPENCV_FISHEYE"), true),
        ([brown, more], Some("OPENCV"), false),
        ([brown, full], None, false),
        ([fisheye, None], None, false),
    ] {
        let mut saved = SavedPoses::new([320, 240], 0.001);
        for distortion in pair {
            saved.push(PoseFiles::default(), &camera(distortion));
        }
        let text = serde_json::to_string(&saved.file()).expect("JSON");
        let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(json["camera_model"].as_str(), model, "{text}");
        assert_eq!(json["k1"].is_number(), in_file, "{text}");
        // Instant NGP would take the one for the other.
        for lens in [&json, &json["frames"][0]] {
            assert!(lens["is_fisheye"].is_null() || lens["p1"].is_null(), "{text}");
        }
        let read = found(&text, [320, 240]).expect("poses");
        assert!(read.notes.is_empty(), "{text}");
        for (pose, distortion) in read.poses.iter().zip(pair) {
            assert_eq!(pose.camera.distortion(), distortion, "{text}");
        }
    }
}

#[test]
fn intrinsics_that_differ_are_saved_for_each_frame() {
    let camera = |fov| Camera::look_at(DVec3::X, DVec3::ZERO, DVec3::Z, fov).expect("a camera");
    let plane = ImagePlane {
        principal_offset: [0.1, -0.2],
        pixel_aspect: 1.25,
    };
    let shifted = camera(40.0).with_image_plane(plane).expect("a camera");
    for (cameras, is_shared) in [
        ([shifted, shifted], true),
        ([camera(40.0), camera(50.0)], false),
        ([camera(40.0), shifted], false),
    ] {
        let mut saved = SavedPoses::new([320, 240], 0.001);
        for camera in &cameras {
            saved.push(PoseFiles::default(), camera);
        }
        let text = serde_json::to_string(&saved.file()).expect("JSON");
        let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        for key in ["fl_x", "fl_y", "cx", "cy", "w", "h"] {
            assert_eq!(json[key].is_number(), is_shared, "{text}");
            assert_eq!(json["frames"][1][key].is_number(), !is_shared, "{text}");
        }
        assert!(json["integer_depth_scale"].is_null(), "{text}");
        let read = found(&text, [320, 240]).expect("poses");
        for (pose, camera) in read.poses.iter().zip(&cameras) {
            let [a, b] =
                [&pose.camera, camera].map(|camera| camera.intrinsics(320, 240).expect("perspective"));
            for (a, b) in [a.focal, a.principal_point]
                .concat()
                .iter()
                .zip([b.focal, b.principal_point].concat())
            {
                assert!((a - b).abs() < 1e-9, "{text}");
            }
        }
    }
}

#[test]
fn pictures_of_one_size_have_a_size() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("t.json");
    let matrix = r#""transform_matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,0]]"#;
    for (lens, frames, expected) in [
        (r#""w":640.0,"h":480"#, ["", ""], Some([640, 480])),
        (r#""w":640"#, [r#""h":480,"#; 2], Some([640, 480])),
        (r#""w":640"#, [r#""h":480,"#, r#""h":481,"#], None),
        (r#""w":640"#, [r#""h":480,"#, ""], None),
        (r#""w":640,"h":0"#, ["", ""], None),
        (r#""w":640,"h":-1"#, ["", ""], None),
        (r#""w":640,"h":1e300"#, ["", ""], None),
        (r#""w":640.4,"h":9"#, ["", ""], Some([640, 9])),
    ] {
        let [a, b] = frames;
        let text = format!(r#"{{{lens},"camera_angle_x":1,"frames":[{{{a}{matrix}}},{{{b}{matrix}}}]}}"#);
        std::fs::write(&path, &text).expect("a file");
        assert_eq!(PoseFile::read(&path).expect(&text).size(), expected, "{text}");
    }
    let lens = r#""w":640,"h":480,"camera_angle_x":1,"#;
    assert!(posed(lens, "").notes.is_empty());
    let notes = posed(&lens.replace("480", "640"), "").notes;
    assert!(
        notes.len() == 1 && notes[0].contains("another shape than 320x240"),
        "{notes:?}"
    );
}

#[test]
fn pictures_of_several_sizes_need_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("t.json");
    let matrix = r#""transform_matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,0]]"#;
    for (second, size, is_chosen, expected) in [
        (
            r#""w":128,"h":100"#,
            [512, 512],
            false,
            Some("has pictures of 256x200 and 128x100, but all are rendered with 512x512: give --size"),
        ),
        (
            r#""w":128,"h":100"#,
            [512, 512],
            true,
            Some("another shape than 512x512"),
        ),
        (r#""w":128,"h":100"#, [256, 200], true, None),
        (r#""w":256,"h":200"#, [256, 200], false, None),
    ] {
        let first = r#""w":256,"h":200"#;
        let text = format!(r#"{{"camera_angle_x":1,"frames":[{{{first},{matrix}}},{{{second},{matrix}}}]}}"#);
        std::fs::write(&path, &text).expect("a file");
        let file = PoseFile::read(&path).expect(&text);
        let notes = file.poses(size, is_chosen).expect(&text).notes;
        let found = notes.iter().map(String::as_str).collect::<String>();
        match expected {
            Some(expected) => assert!(notes.len() == 1 && found.contains(expected), "{found}"),
            None => assert!(notes.is_empty(), "{found}"),
        }
    }
}
