//! Cameras of frames, and the file that lists them.

use super::Call;
use crate::{
    cli::{
        CliError,
        plan::{Frame, JsonTarget, PoseFiles, SavedPoses, Turn},
        write::{AovKind, Output, json_line, write_json},
    },
    render::Settings,
    scene::Camera,
};
use std::path::Path;

impl Call<'_> {
    /// The camera of a frame: a pose, or that of the scene or its options, turned for a turntable.
    pub fn camera_of(&self, turn: Option<Turn>, camera: &Camera) -> Result<Camera, CliError> {
        let pose = |turn: Turn| {
            Some(
                self.plan
                    .poses
                    .as_ref()?
                    .poses
                    .get(turn.number as usize - 1)?
                    .camera,
            )
        };
        Ok(match (turn.and_then(pose), turn.zip(self.plan.orbit)) {
            (Some(camera), _) => camera,
            (None, Some((turn, orbit))) => Camera::new(&orbit.view(&camera.view(), turn))?,
            _ => *camera,
        })
    }

    /// Refuses to save the pose of an orthographic camera, or of one with another field of view than those before, before its
    /// picture is rendered.
    pub fn prepare_poses(&mut self, camera: &Camera, settings: &Settings) -> Result<(), CliError> {
        if self.plan.save_poses.is_none() {
            return Ok(());
        }
        let poses = SavedPoses::new(camera, [settings.width, settings.height])?;
        if let Some(saved) = &self.saved_poses {
            return saved.check_fits(&poses);
        }
        self.saved_poses = Some(poses);
        Ok(())
    }

    /// Remembers the camera of a picture.
    pub fn save_pose(&mut self, frame: &Frame, camera: &Camera) {
        if let (Some(path), Some(saved)) = (&self.plan.save_poses, &mut self.saved_poses) {
            let relative = |output: &Output| {
                let file = Path::new(output.full_name());
                let relative = path.parent().and_then(|folder| file.strip_prefix(folder).ok());
                relative.unwrap_or(file).to_string_lossy().into_owned()
            };
            let files = PoseFiles {
                picture: relative(&frame.output),
                mask: frame.aovs.file(AovKind::Mask).map(relative),
                depth: frame.aovs.file(AovKind::Z).map(relative),
            };
            saved.push(files, camera);
        }
    }

    pub fn write_poses(&self) -> Result<(), CliError> {
        let (Some(path), Some(saved)) = (&self.plan.save_poses, &self.saved_poses) else {
            return Ok(());
        };
        let target = JsonTarget::File(path.clone());
        self.inputs.check_json(Some(&target))?;
        write_json(&target, &json_line(saved))
    }
}
