//! Cameras of frames, and the file that lists them.

use super::{Call, moving};
use crate::{
    cli::{
        CliError, load,
        plan::{Frame, Job, JsonTarget, ListedPicture, PoseFiles, RenderPlan, SavedPoses, Turn},
        report,
        write::{AovKind, Inputs, RenderedAovs, json_line, write_json},
    },
    scene::{Camera, Scene},
};
use std::path::{Component, Path};

impl RenderPlan {
    /// The camera of a frame: a pose, or that of the scene or its options, turned for a turntable.
    pub(super) fn camera_of(&self, turn: Option<Turn>, camera: &Camera) -> Result<Camera, CliError> {
        let pose = |turn: Turn| {
            let poses = &self.poses.as_ref()?.poses;
            Some(poses.get(turn.number as usize - 1)?.camera)
        };
        Ok(match (turn.and_then(pose), turn.zip(self.orbit)) {
            (Some(camera), _) => camera,
            (None, Some((turn, orbit))) => Camera::new(&orbit.view(&camera.view(), turn))?,
            _ => *camera,
        })
    }

    /// The cameras of all pictures of a job's series, if they are to be saved. `camera` is that of the loaded scene.
    ///
    /// # Errors
    /// [`CliError`] for cameras that make no picture or are orthographic.
    pub(super) fn poses_of(
        &self,
        job: &Job,
        scene: &Scene,
        camera: &Camera,
    ) -> Result<Option<SavedPoses>, CliError> {
        let Some(path) = &self.save_poses else {
            return Ok(None);
        };
        // Styles do not change it.
        let look = &self.looks.mesh;
        let size = [look.settings.width, look.settings.height];
        let mut saved = SavedPoses::new(size, look.picture.z_step);
        for picture in &job.listed {
            let moved = moving::camera_at(job, scene, picture.turn)?;
            let camera = self.camera_of(picture.turn, &moved.unwrap_or(*camera))?;
            SavedPoses::check(&camera)?;
            saved.push(files(path, picture), &camera);
        }
        Ok(Some(saved))
    }

    /// Writes the cameras of all pictures, if they are to be saved and none of the inputs is lost.
    pub(super) fn write_poses(&self, saved: &SavedPoses, inputs: &Inputs) -> Result<(), CliError> {
        let Some(path) = &self.save_poses else {
            return Ok(());
        };
        let target = JsonTarget::File(path.clone());
        inputs.check_json(Some(&target))?;
        write_json(&target, &json_line(&saved.file()))
    }
}

/// Writes the cameras of all pictures, if they are to be saved, without rendering any.
///
/// # Errors
/// [`CliError`], as for rendering.
pub fn save(plan: &RenderPlan) -> Result<(), CliError> {
    let Some(job) = plan.jobs.first().filter(|_| plan.save_poses.is_some()) else {
        return Ok(());
    };
    let mut opened = Vec::new();
    let input = load::load_and_list(&job.input, job.scene_memory, &mut opened)?;
    let mut inputs = plan.inputs.clone();
    inputs.add_scene(&job.input.path, &opened, Some(&input.scene));
    let saved = plan.poses_of(job, &input.scene, &input.camera)?;
    saved.map_or(Ok(()), |saved| plan.write_poses(&saved, &inputs))
}

/// The files of a picture as seen from the file of poses.
fn files(poses: &Path, picture: &ListedPicture) -> PoseFiles {
    let aov = |which| picture.aov(which).map(|file| seen_from(poses, file));
    PoseFiles {
        picture: seen_from(poses, &picture.path),
        mask: aov(AovKind::Mask),
        depth: aov(AovKind::Z),
    }
}

impl Call<'_> {
    /// Warns of depth beyond the range of its file, once.
    pub fn warn_of_depth(&mut self, frame: &Frame, aovs: Option<&RenderedAovs>) {
        if self.plan.quiet || self.warned_of_depth {
            return;
        }
        let warning = aovs.and_then(|aovs| frame.aovs.warning(aovs));
        self.warned_of_depth = warning.is_some();
        report::warnings(warning);
    }
}

/// The path of `file` as seen from the folder of the file `from`, with `/` between names; `file` itself if they share no
/// folder, as on two drives.
fn seen_from(from: &Path, file: &Path) -> String {
    let joined = |parts: &mut dyn Iterator<Item = Component<'_>>| {
        let parts: Vec<_> = parts.map(|part| part.as_os_str().to_string_lossy()).collect();
        parts.join("/")
    };
    let lexical = from.parent().and_then(|folder| file.strip_prefix(folder).ok());
    if let Some(inside) = lexical.filter(|_| from.is_absolute() == file.is_absolute()) {
        return joined(&mut inside.components());
    }
    let folder = |of: &Path| {
        let folder = of.parent().filter(|folder| !folder.as_os_str().is_empty());
        folder.unwrap_or(Path::new(".")).canonicalize()
    };
    if let (Ok(here), Ok(there), Some(name)) = (folder(from), folder(file), file.file_name()) {
        let pairs = here.components().zip(there.components());
        let shared = pairs.take_while(|(a, b)| a == b).count();
        if shared > 0 {
            let up = here.components().skip(shared).map(|_| Component::ParentDir);
            let down = there.components().skip(shared);
            return joined(&mut up.chain(down).chain([Component::Normal(name)]));
        }
    }
    file.to_string_lossy().into_owned()
}
