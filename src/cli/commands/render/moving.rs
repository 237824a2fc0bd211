//! Frames of an animated scene.

use super::Call;
use crate::{
    accel::Bvh,
    cli::{
        CliError,
        plan::{Job, Turn},
    },
    scene::{Camera, Scene},
};
use std::time::{Duration, Instant};

/// Moves a scene to a frame, with its BVH and camera. Returns the time that took.
pub fn move_to(
    turn: Option<Turn>,
    job: &Job,
    (scene, bvh): (&mut Scene, &mut Bvh),
    camera: &mut Camera,
) -> Result<Duration, CliError> {
    let start = Instant::now();
    if let Some(turn) = turn {
        let moved = scene.set_time(turn.number.into());
        moved.map_err(|error| CliError::Failed(error.to_string()))?;
        bvh.follow(scene);
        *camera = job.input.camera.for_scene(scene)?;
    }
    Ok(start.elapsed())
}

impl Call<'_> {
    /// Rejects frames that a scene from standard input does not have, which is known only after loading.
    pub fn check_frames(&self, job: &Job, scene: &Scene) -> Result<(), CliError> {
        let is_own = self.plan.orbit.is_none() && self.plan.poses.is_none();
        let last = job.frames.last().and_then(|frame| frame.turn).filter(|_| is_own);
        let count = scene.frame_count();
        match last {
            Some(last) if last.number > count => Err(CliError::Usage(format!(
                "--frames: the last frame of the scene is {count}, expected numbers from 1 to {count}"
            ))),
            _ => Ok(()),
        }
    }
}
