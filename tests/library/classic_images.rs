//! The original classic scenes against pictures of their original renderer. Neither is part of octray: without them
//! the tests skip themselves.
//!
//! Measured, at most 0.015 % of the pixels differ by more than 2/255, all at edges of surfaces and shadows.

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

/// The folder of the original scenes and pictures: `$OCTRAY_SHARED/course` or `../shared/course`. `None` if absent.
pub fn folder() -> Option<PathBuf> {
    let shared = std::env::var_os("OCTRAY_SHARED").map_or_else(|| package().join("../shared"), PathBuf::from);
    let folder = shared.join("course");
    if folder.is_dir() {
        return Some(folder);
    }
    println!(
        "skipped: {} is absent (OCTRAY_SHARED names its parent)",
        folder.display()
    );
    None
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

fn check(folder: &Path, expected: &Path, mode: Mode) -> Result<(), String> {
    let stem = expected
        .file_stem()
        .and_then(|stem| stem.to_str())
        .unwrap_or_default();
    let (scene_name, view, shadows) =
        parse(stem).ok_or(format!("{stem}.png: expected SCENE-VIEW.png as its name"))?;
    let scene = format::load(&folder.join("framework").join(format!("{scene_name}.scn")))
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
    // The cow's small triangles have more edges.
    let share = if scene_name == "cow" { 0.005 } else { 0.001 };
    compare(
        &format!("classic-{stem}-{mode:?}"),
        &to_image(&frame.film),
        expected,
        share,
    )
}

fn check_all(mode: Mode) {
    let Some(folder) = folder() else { return };
    let mut expected: Vec<_> = std::fs::read_dir(folder.join("expected"))
        .expect("the folder of expected pictures")
        .map(|entry| entry.expect("its entries").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "png"))
        .collect();
    expected.sort();
    assert!(!expected.is_empty(), "no expected pictures");
    assert_all(expected.iter().map(|path| check(&folder, path, mode)));
}

#[test]
fn packets_draw_the_classic_pictures() {
    check_all(Mode::Packet);
}

#[test]
fn the_scalar_reference_draws_the_classic_pictures() {
    check_all(Mode::Scalar);
}
