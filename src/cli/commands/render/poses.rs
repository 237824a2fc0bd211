//! Cameras of frames, and the file that lists them.

use super::Call;
use crate::{
    cli::{
        CliError,
        plan::{Frame, JsonTarget, Look, PoseFiles, SavedPoses, Turn},
        report,
        write::{AovKind, Output, RenderedAovs, json_line, write_json},
    },
    scene::Camera,
};
use std::path::{Component, Path};

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

    /// Refuses to save the pose of an orthographic camera, before its picture is rendered.
    pub fn prepare_poses(&mut self, camera: &Camera, look: &Look) -> Result<(), CliError> {
        if self.plan.save_poses.is_none() {
            return Ok(());
        }
        SavedPoses::check(camera)?;
        let Look { settings, picture } = look;
        let size = [settings.width, settings.height];
        let new = || SavedPoses::new(size, picture.z_step);
        self.saved_poses.get_or_insert_with(new);
        Ok(())
    }

    /// Remembers the camera of a picture.
    pub fn save_pose(&mut self, frame: &Frame, camera: &Camera) {
        if let (Some(path), Some(saved)) = (&self.plan.save_poses, &mut self.saved_poses) {
            let relative = |output: &Output| seen_from(path, Path::new(output.full_name()));
            let files = PoseFiles {
                picture: relative(&frame.output),
                mask: frame.aovs.file(AovKind::Mask).map(relative),
                depth: frame.aovs.file(AovKind::Z).map(relative),
            };
            saved.push(files, camera);
        }
    }

    /// Warns of depth beyond the range of its file, once.
    pub fn warn_of_depth(&mut self, frame: &Frame, aovs: Option<&RenderedAovs>) {
        if self.plan.quiet || self.warned_of_depth {
            return;
        }
        let warning = aovs.and_then(|aovs| frame.aovs.warning(aovs));
        self.warned_of_depth = warning.is_some();
        report::warnings(warning);
    }

    pub fn write_poses(&self) -> Result<(), CliError> {
        let (Some(path), Some(saved)) = (&self.plan.save_poses, &self.saved_poses) else {
            return Ok(());
        };
        let target = JsonTarget::File(path.clone());
        self.inputs.check_json(Some(&target))?;
        write_json(&target, &json_line(&saved.file()))
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
