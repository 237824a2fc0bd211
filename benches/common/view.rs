//! The camera in a scene file's comment: `octray generate` and the shipped scenes write
//! `--eye=x,y,z --target=x,y,z --fov=DEG` there.

use glam::DVec3;
use octray::{classic, scene::Camera};

/// The camera of the first comment that has one.
pub fn told_in(scene_file: &str) -> Option<Camera> {
    let mut comments = scene_file
        .lines()
        .filter(|line| line.trim_start().starts_with("//"));
    comments.find_map(camera)
}

fn camera(comment: &str) -> Option<Camera> {
    let option = |name: &str| {
        comment
            .split_whitespace()
            .find_map(|word| word.strip_prefix(name))
    };
    let eye = vector(option("--eye=")?)?;
    let target = option("--target=").map_or(Some(classic::TARGET), vector)?;
    let fov = option("--fov=").map_or(Some(classic::FOV_DEGREES), |text| text.parse().ok())?;
    Camera::look_at(eye, target, classic::UP, fov).ok()
}

/// `x,y,z`.
pub fn vector(text: &str) -> Option<DVec3> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(str::parse).collect();
    match numbers.as_deref() {
        Ok([x, y, z]) => Some(DVec3::new(*x, *y, *z)),
        _ => None,
    }
}
