//! The course's own scenes against the pictures of the course's own code. Neither is part of octray: the tests
//! are skipped, with a line that says so, where they are absent.
//!
//! Shares of pixels that differ by more than 2/255, as measured (x86-64-v3; allowed are 0.1 %, cow 0.5 %), all of
//! them at edges of surfaces and shadows:
//!
//! | scene | viewpoint 1 | viewpoint 3 |
//! |---|---|---|
//! | silhouette | 0.0000 % | 0 |
//! | matte | 0.0008 % | 0.0027 % |
//! | matte, no shadows | 0.0004 % | – |
//! | blinn_phong | 0.0008 % | 0.0027 % |
//! | reflections | 0.0015 % | 0.0046 % |
//! | cow | 0.0050 % | 0.0149 % |

use crate::images::{assert_all, compare, package, to_image};
use octray::{
    accel::Bvh,
    format,
    render::{Mode, Settings, render},
    scene::Camera,
};
use std::{
    ops::ControlFlow,
    path::{Path, PathBuf},
};

/// The folder with the course's scenes and expected pictures: `$OCTRAY_SHARED/course` or `../shared/course`.
/// `None`, and a line that says so, where it is absent: it is not part of the project.
fn classic_folder() -> Option<PathBuf> {
    let shared = std::env::var_os("OCTRAY_SHARED").map_or_else(|| package().join("../shared"), PathBuf::from);
    let folder = shared.join("course");
    if folder.is_dir() {
        Some(folder)
    } else {
        eprintln!(
            "skipped: {} is absent (the course's files are not part of octray; set OCTRAY_SHARED to find them)",
            folder.display()
        );
        None
    }
}

/// `matte_noshadow-1` is scene "matte" without shadows from viewpoint 1.
fn parse(stem: &str) -> Option<(&str, u32, bool)> {
    let (scene, view) = stem.rsplit_once('-')?;
    let view = view.parse().ok()?;
    Some(match scene.strip_suffix("_noshadow") {
        Some(scene) => (scene, view, false),
        None => (scene, view, true),
    })
}

fn check(course: &Path, expected: &Path, mode: Mode) -> Result<(), String> {
    let stem = expected
        .file_stem()
        .and_then(|stem| stem.to_str())
        .unwrap_or_default();
    let (scene_name, view, shadows) =
        parse(stem).ok_or(format!("{stem}.png: expected SCENE-VIEW.png as its name"))?;
    let scene = format::load(&course.join("framework").join(format!("{scene_name}.scn")))
        .map_err(|error| format!("{stem}: {error:?}"))?;
    let camera = Camera::classic_view(view).ok_or(format!("{stem}: no viewpoint {view}"))?;
    let settings = Settings {
        shadows,
        mode,
        ..Settings::default()
    };
    let bvh = Bvh::build(&scene);
    let frame = render(&scene, &bvh, &camera, &settings, &|_| ControlFlow::Continue(()))
        .map_err(|error| format!("{stem}: {error}"))?;
    // Where triangles are as small as the cow's, edges are a larger share of the picture.
    let share = if scene_name == "cow" { 0.005 } else { 0.001 };
    compare(
        &format!("course-{stem}-{mode:?}"),
        &to_image(&frame.film),
        expected,
        share,
    )
}

fn check_all(mode: Mode) {
    let Some(course) = classic_folder() else {
        return;
    };
    let mut expected: Vec<_> = std::fs::read_dir(course.join("expected"))
        .expect("the folder of expected pictures")
        .map(|entry| entry.expect("its entries").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "png"))
        .collect();
    expected.sort();
    assert!(!expected.is_empty(), "no expected pictures");
    assert_all(expected.iter().map(|path| check(&course, path, mode)));
}

#[test]
fn packets_draw_the_course_pictures() {
    check_all(Mode::Packet);
}

#[test]
fn the_scalar_reference_draws_the_course_pictures() {
    check_all(Mode::Scalar);
}

#[test]
fn names_of_expected_pictures_are_understood() {
    assert_eq!(parse("matte_noshadow-1"), Some(("matte", 1, false)));
    assert_eq!(parse("blinn_phong-3"), Some(("blinn_phong", 3, true)));
    assert_eq!(parse("readme"), None);
}
