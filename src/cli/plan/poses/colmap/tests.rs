use super::{
    super::{PoseFile, Poses},
    MODELS,
};
use crate::scene::{Camera, Distortion, Projection};
use glam::{DMat3, DQuat, DVec3};
use std::{fs, path::Path};

const EYE: DVec3 = DVec3::new(3.0, -2.0, 1.0);
const TARGET: DVec3 = DVec3::new(0.0, 0.5, 0.5);

/// The rotation and translation of a camera at `EYE`.
fn pose() -> [f64; 7] {
    let forward = (TARGET - EYE).normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let to_camera = DMat3::from_cols(right, forward.cross(right), forward).transpose();
    let [x, y, z, w] = DQuat::from_mat3(&to_camera).to_array();
    let [tx, ty, tz] = (-(to_camera * EYE)).to_array();
    [w, x, y, z, tx, ty, tz]
}

fn found(folder: &Path, name: &str) -> Result<Poses, String> {
    let poses = PoseFile::read(&folder.join(name)).and_then(|file| file.poses([600, 400], false));
    poses.map_err(|error| error.text().unwrap_or_default())
}

fn write(folder: &Path, cameras: &str, images: &str) {
    fs::write(folder.join("cameras.txt"), cameras).expect("a file");
    fs::write(folder.join("images.txt"), images).expect("a file");
}

fn write_binary(folder: &Path) {
    let mut cameras = 1_u64.to_le_bytes().to_vec();
    cameras.extend([7_u32, 1].iter().flat_map(|n| n.to_le_bytes()));
    cameras.extend([600_u64, 400].iter().flat_map(|n| n.to_le_bytes()));
    cameras.extend(
        [500.0_f64, 400.0, 300.0, 200.0]
            .iter()
            .flat_map(|n| n.to_le_bytes()),
    );
    let mut images = 1_u64.to_le_bytes().to_vec();
    images.extend(1_u32.to_le_bytes());
    images.extend(pose().iter().flat_map(|n| n.to_le_bytes()));
    images.extend(7_u32.to_le_bytes());
    images.extend(b"left/my picture 1.png\0");
    images.extend(2_u64.to_le_bytes());
    images.extend([0; 48]);
    fs::write(folder.join("cameras.bin"), cameras).expect("a file");
    fs::write(folder.join("images.bin"), images).expect("a file");
}

fn radial(radial: [f64; 4]) -> Distortion {
    Distortion::Perspective {
        radial,
        divisor: [0.0; 3],
        tangential: [0.0; 2],
    }
}

#[test]
fn text_and_binary_files_have_the_same_cameras() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let words = pose().map(|number| number.to_string()).join(" ");
    write(
        folder,
        "\u{feff}# cameras\n7 PINHOLE 600 400 500 400 300 200\n8 SIMPLE_RADIAL 600 400 500 300 200 0.1\n",
        &format!("# images\n\n2 {words} 8 right.png\n\n1 {words} 7 left/my picture 1.png\n1 2 -1 3 4 5\n"),
    );
    write_binary(folder);
    let text = found(folder, "images.txt").expect("poses");
    assert!(text.notes.is_empty());
    assert_eq!(
        text.poses[1].camera.distortion(),
        Some(radial([0.1, 0.0, 0.0, 0.0]))
    );
    let names: Vec<&str> = text.poses.iter().map(|pose| &pose.name[..]).collect();
    assert_eq!(names, ["my picture 1", "right"]);
    let binary = found(folder, "images.bin").expect("poses");
    assert!(binary.notes.is_empty());
    let expected = Camera::look_at(EYE, TARGET, DVec3::Z, 2.0 * f64::atan(0.5).to_degrees());
    let expected = expected.expect("a camera").view();
    for pose in [&text.poses[0], &binary.poses[0]] {
        let view = pose.camera.view();
        assert!(view.eye.distance(EYE) < 1e-12);
        assert!((view.target - view.eye).distance((TARGET - EYE).normalize()) < 1e-12);
        assert!(view.up.dot(DVec3::Z) > 0.9);
        let fov = |projection| match projection {
            Projection::Perspective { fov_degrees } => fov_degrees,
            Projection::Orthographic { .. } => 0.0,
        };
        assert!((fov(view.projection) - fov(expected.projection)).abs() < 1e-9);
    }
}

#[test]
fn broken_files_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let camera = "1 PINHOLE 600 400 500 500 300 200\n";
    for (cameras, images, expected) in [
        (camera, "1 1 0 0 0 0 0 0 1\n", "images.txt:1:1: expected an image"),
        (
            camera,
            "1 1 0 x 0 0 0 0 1 a.png\n",
            "images.txt:1:7: found `x`, expected a number",
        ),
        (
            camera,
            "\n1 1 0 0 0 0 0 0 -1 a.png\n",
            "images.txt:2:17: found `-1`",
        ),
        (camera, "1 1 0 0 0 0 0 0 2 a.png\n", "a.png: no camera 2"),
        (
            camera,
            "1 1 0 0 0 0 0 0 1 a.png\n2 1 0 0 0 0 0 0 1 b.png\n",
            "images.txt:2:1: expected the line of points of a.png, which may be empty",
        ),
        (
            camera,
            "1 1 0 0 0 0 0 0 1 a.png\n2 .5 .5 .5 .5 0 0 0 1 my b.png\n",
            "images.txt:2:1: expected the line of points of a.png",
        ),
        (
            camera,
            "1 0 0 0 0 0 0 0 1 b/c.png\n\n2 1 0 0 0 0 0 0 1 a.png\n",
            "images.txt: b/c.png: its rotation is 0 0 0 0, expected a quaternion",
        ),
        (
            "\n1 PINHOLE 0 400 500 500 300 200\n",
            "1 1 0 0 0 0 0 0 1 a.png\n",
            "cameras.txt:2:11: found a picture of 0x400, expected pixels",
        ),
        (camera, "# none\n", "0 frames"),
        (
            "1 BOX 6 4\n",
            "",
            "cameras.txt:1:3: unknown camera model `BOX`, expected one that octray knows, such as PINHOLE",
        ),
        (
            "1 EQUIRECTANGULAR 6 4 6 4\n",
            "",
            "cameras.txt:1:3: EQUIRECTANGULAR has no focal length",
        ),
        ("1 PINHOLE 6 4 1\n", "", "PINHOLE has 1 parameters, expected 4"),
        (
            "1 PINHOLE 600 400 0 0 300 200\n",
            "1 1 0 0 0 0 0 0 1 a.png\n",
            "a.png: `fl_x` is 0, expected a focal length",
        ),
    ] {
        write(folder, cameras, images);
        let error = found(folder, "images.txt").expect_err(expected);
        assert!(error.contains(expected), "{expected}: {error}");
    }
    write_binary(folder);
    for name in ["images.bin", "cameras.bin"] {
        let whole = fs::read(folder.join(name)).expect("a file");
        for length in 0..whole.len() {
            fs::write(folder.join(name), &whole[..length]).expect("a file");
            let error = found(folder, "images.bin").expect_err("it is cut");
            assert!(error.contains("end"), "{length}: {error}");
        }
        fs::write(folder.join(name), whole).expect("a file");
    }
    let mut cameras = fs::read(folder.join("cameras.bin")).expect("a file");
    cameras[16..24].fill(0);
    fs::write(folder.join("cameras.bin"), cameras).expect("a file");
    let error = found(folder, "images.bin").expect_err("it has no width");
    let expected = "cameras.bin: camera 7: found a picture of 0x400, expected pixels";
    assert!(error.contains(expected), "{error}");
}

/// Lines of points are longer than what is read of them.
#[test]
fn lines_of_points_have_any_length() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let camera = "1 PINHOLE 600 400 500 500 300 200\n";
    for count in [0, 1, 100, 1000, 100_000] {
        for point in ["1234.5 0.25 -1 ", "1 2 18446744073709551615 ", "1e2\t3 7  "] {
            let points = point.repeat(count);
            let images = format!("1 1 0 0 0 0 0 0 1 a.png\n{points}\r\n2 1 0 0 0 0 0 0 1 b.png\n{points}");
            write(folder, camera, &images);
            let found = found(folder, "images.txt").map(|poses| poses.poses.len());
            assert_eq!(found, Ok(2), "{count} {point}");
        }
    }
}

/// The models whose distortion is rendered, by their coefficients 1, 2, 3, ...
fn known(name: &str) -> Option<Distortion> {
    let fisheye = |radial| Distortion::Fisheye { radial };
    Some(match name {
        "SIMPLE_RADIAL" => radial([1.0, 0.0, 0.0, 0.0]),
        "RADIAL" => radial([1.0, 2.0, 0.0, 0.0]),
        "OPENCV" => Distortion::Perspective {
            radial: [1.0, 2.0, 0.0, 0.0],
            divisor: [0.0; 3],
            tangential: [3.0, 4.0],
        },
        "FULL_OPENCV" => Distortion::Perspective {
            radial: [1.0, 2.0, 5.0, 0.0],
            divisor: [6.0, 7.0, 8.0],
            tangential: [3.0, 4.0],
        },
        "SIMPLE_FISHEYE" | "FISHEYE" => fisheye([0.0; 4]),
        "SIMPLE_RADIAL_FISHEYE" => fisheye([1.0, 0.0, 0.0, 0.0]),
        "RADIAL_FISHEYE" => fisheye([1.0, 2.0, 0.0, 0.0]),
        "OPENCV_FISHEYE" => fisheye([1.0, 2.0, 3.0, 4.0]),
        _ => return None,
    })
}

/// The distortion of every model, and a note for those that are not rendered.
#[test]
fn models_are_rendered_or_noted() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let words = pose().map(|number| number.to_string()).join(" ");
    for &(name, count, is_simple) in &MODELS {
        let focals = if is_simple { "400" } else { "500 400" };
        let coefficients = count - if is_simple { 3 } else { 4 };
        let numbers: String = (1..=coefficients).map(|k| format!(" {k}")).collect();
        write(
            folder,
            &format!("7 {name} 600 400 {focals} 310 190{numbers}\n"),
            &format!("1 {words} 7 a.png\n"),
        );
        let poses = found(folder, "images.txt").unwrap_or_else(|error| panic!("{name}: {error}"));
        let known = known(name);
        assert_eq!(poses.poses[0].camera.distortion(), known, "{name}");
        let is_noted = known.is_none() && !name.contains("PINHOLE");
        assert_eq!(
            poses.notes.len(),
            usize::from(is_noted),
            "{name} {:?}",
            poses.notes
        );
    }
}

/// Every model by its number and name: focal lengths, the principal point and whether the lens is noted without coefficients.
#[test]
fn all_models_are_known() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let words = pose().map(|number| number.to_string()).join(" ");
    for (number, &(name, count, is_simple)) in MODELS.iter().enumerate() {
        let focals: &[f64] = if is_simple { &[400.0] } else { &[500.0, 400.0] };
        let mut parameters = [focals, &[310.0, 190.0]].concat();
        parameters.resize(count, 0.0);
        if name == "EUCM" {
            parameters[5] = 1.0;
        }
        let text = parameters
            .iter()
            .map(f64::to_string)
            .collect::<Vec<_>>()
            .join(" ");
        write(
            folder,
            &format!("7 {name} 600 400 {text}\n"),
            &format!("1 {words} 7 a.png\n"),
        );
        write_binary(folder);
        let mut cameras = 1_u64.to_le_bytes().to_vec();
        cameras.extend([7, number as u32].iter().flat_map(|n| n.to_le_bytes()));
        cameras.extend([600_u64, 400].iter().flat_map(|n| n.to_le_bytes()));
        cameras.extend(parameters.iter().flat_map(|n| n.to_le_bytes()));
        fs::write(folder.join("cameras.bin"), cameras).expect("a file");
        for file in ["images.txt", "images.bin"] {
            let poses = found(folder, file).unwrap_or_else(|error| panic!("{name}: {error}"));
            let is_unknown = name.contains("PRISM_FISHEYE") || name == "FOV";
            assert_eq!(
                poses.notes.len(),
                usize::from(is_unknown),
                "{name} {:?}",
                poses.notes
            );
            let found = poses.poses[0].camera.intrinsics(600, 400).expect("perspective");
            let expected = [focals[0], 400.0, 310.0, 190.0];
            for (a, b) in [found.focal, found.principal_point].concat().iter().zip(expected) {
                assert!((a - b).abs() < 1e-9, "{name}: {found:?}");
            }
        }
    }
    let camera = |number: u32| {
        let bytes = 1_u64.to_le_bytes().into_iter().chain(7_u32.to_le_bytes());
        let bytes: Vec<u8> = bytes.chain(number.to_le_bytes()).chain([0; 64]).collect();
        fs::write(folder.join("cameras.bin"), bytes).expect("a file");
        found(folder, "images.bin").expect_err("no such model")
    };
    assert!(camera(17).contains("camera 7: EQUIRECTANGULAR has no focal length"));
    assert!(camera(18).contains("camera 7: unknown camera model 18, expected one that octray knows"));
}

/// A folder stands for its list of images.
#[test]
fn a_reconstruction_is_a_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let error = found(folder, "").expect_err("it is empty");
    assert!(
        error.contains("this is a directory without images.bin or images.txt"),
        "{error}"
    );
    let words = pose().map(|number| number.to_string()).join(" ");
    write(
        folder,
        "7 PINHOLE 600 400 500 400 300 200\n",
        &format!("1 {words} 7 text.png\n"),
    );
    assert_eq!(found(folder, "").expect("poses").poses[0].name, "text");
    write_binary(folder);
    assert_eq!(found(folder, "").expect("poses").poses[0].name, "my picture 1");
    let file = PoseFile::read(folder).expect("poses");
    assert_eq!(file.size(), Some([600, 400]));
    assert_eq!(
        file.files(),
        ["images.bin", "cameras.bin"].map(|name| folder.join(name))
    );
    for (name, expected) in [
        ("cameras.bin", "no poses: name images.bin"),
        ("points3D.txt", "no poses: name images.txt"),
    ] {
        let error = found(folder, name).expect_err(name);
        assert!(error.contains(expected), "{error}");
    }
}

/// Names need not be UTF-8, a line may be as long as the limit, and NaN is told as such.
#[test]
fn odd_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let words = pose().map(|number| number.to_string()).join(" ");
    let with = |comment: usize, points: &str| {
        write(folder, "7 PINHOLE 600 400 500 400 300 200\n", "");
        let head = format!(
            "#{}\n1 {words} 7 b.png\n{points}2 {words} 7 caf",
            "x".repeat(comment - 2)
        );
        fs::write(
            folder.join("images.txt"),
            [head.as_bytes(), b"\xe9.png\n"].concat(),
        )
        .expect("a file");
        found(folder, "images.txt")
    };
    let poses = with(1 << 16, "\n").expect("poses").poses;
    assert_eq!([0, 1].map(|i| &poses[i].name[..]), ["b", "caf\u{fffd}"]);
    let error = with((1 << 16) + 1, "\n").expect_err("it is too long");
    assert!(error.contains("a line of more than 65536 bytes"), "{error}");
    let error = with(8, "").expect_err("no points");
    assert!(error.contains("expected the line of points of b.png"), "{error}");
    write_binary(folder);
    let mut images = fs::read(folder.join("images.bin")).expect("a file");
    images[12..20].copy_from_slice(&f64::NAN.to_le_bytes());
    fs::write(folder.join("images.bin"), images).expect("a file");
    let error = found(folder, "images.bin").expect_err("not a number");
    assert!(error.contains("found NaN, expected a finite number"), "{error}");
}
