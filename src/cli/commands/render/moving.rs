//! Frames of an animated scene or mesh.

use super::Call;
use crate::{
    accel::{BuildQuality, Bvh},
    cli::{
        CliError,
        load::{self, Input, Legend, Poses, Rig, memory},
        plan::{InputKind, Job, NOT_PLAYED_FROM_STANDARD_INPUT, Turn},
    },
    scene::{Camera, Scene, SceneBuilder, View},
};
use std::time::{Duration, Instant};

/// A loaded scene, and what a frame may move.
pub struct SceneAtTime {
    pub scene: Scene,
    pub bvh: Bvh,
    pub camera: Camera,
    /// Lights that turn with the camera.
    pub rig: Option<Rig>,
    /// What the colours of a mesh mean.
    pub legend: Option<Legend>,
    /// The poses of a mesh that is played: each frame is loaded again.
    pub poses: Option<Poses>,
    /// How the BVH of each frame is built.
    pub quality: BuildQuality,
}

impl SceneAtTime {
    /// How many of `frames` one renderer can render. It borrows the scene, so if frames change the scene each needs its own.
    pub fn frames_together(&self, frames: usize) -> usize {
        if self.rig.is_some() || self.poses.is_some() || self.scene.moves() {
            1
        } else {
            frames.max(1)
        }
    }

    /// Moves scene, BVH and camera to a frame. Returns the time that took.
    pub fn move_to(&mut self, turn: Option<Turn>, job: &Job) -> Result<Duration, CliError> {
        let Some(turn) = turn.filter(|_| self.poses.is_some() || self.scene.moves()) else {
            return Ok(Duration::ZERO);
        };
        let start = Instant::now();
        if let Some(poses) = &self.poses {
            // The old pose is freed before the new one takes memory. The first one is loaded already.
            if turn.number != 1 {
                self.scene = SceneBuilder::new().finish();
                self.bvh = Bvh::build(&self.scene);
                let Input { scene, camera, .. } =
                    load::load_frame(&job.input, job.scene_memory, poses, turn.number)?;
                memory::check_build(&scene, self.quality)?;
                self.bvh = Bvh::build_with(&scene, self.quality);
                (self.scene, self.camera) = (scene, camera);
            }
            return Ok(start.elapsed());
        }
        let moved = self.scene.set_time(turn.number.into());
        moved.map_err(|error| CliError::Failed(error.to_string()))?;
        self.bvh.follow(&self.scene);
        self.camera = job.input.camera.for_scene(&self.scene)?;
        Ok(start.elapsed())
    }

    /// Turns the lights of the rig to the camera `view`.
    pub fn light(&mut self, view: &View) -> Result<(), CliError> {
        if let Some(rig) = &self.rig {
            let lights = rig.lights(view.eye - view.target);
            let lights = lights.map_err(|error| CliError::Failed(error.to_string()))?;
            self.scene.take_lights(lights);
        }
        Ok(())
    }
}

/// Refuses cameras that make no picture in one of a scene's frames, before the first is rendered.
pub fn check_cameras(job: &Job, scene: &Scene) -> Result<(), CliError> {
    let frames = job.frames.iter();
    frames
        .map(|frame| camera_at(job, scene, frame.turn))
        .try_for_each(|camera| camera.map(drop))
}

/// The camera of a frame, if the scene moves.
pub fn camera_at(job: &Job, scene: &Scene, turn: Option<Turn>) -> Result<Option<Camera>, CliError> {
    let Some(turn) = turn.filter(|_| scene.moves()) else {
        return Ok(None);
    };
    let time = turn.number.into();
    let own = scene.cameras_at(time);
    let own = own.map_err(|error| CliError::Failed(error.to_string()))?;
    job.input.camera.at_time(scene, &own, time).map(Some)
}

impl Call<'_> {
    /// Rejects frames that a scene from standard input does not have, which is known only after loading.
    pub fn check_frames(&self, job: &Job, scene: &Scene, is_mesh: bool) -> Result<(), CliError> {
        let is_played = job.input.mesh.playback.is_some();
        let is_own = self.plan.orbit.is_none() && self.plan.poses.is_none() && !is_played;
        let last = job.frames.last().and_then(|frame| frame.turn).filter(|_| is_own);
        let count = scene.frame_count();
        match last {
            Some(_) if job.input.kind == InputKind::Any && is_mesh => {
                Err(CliError::Usage(NOT_PLAYED_FROM_STANDARD_INPUT.into()))
            }
            Some(last) if last.number > count => Err(CliError::Usage(format!(
                "--frames: the last frame of the scene is {count}, expected numbers from 1 to {count}"
            ))),
            _ => Ok(()),
        }
    }
}
