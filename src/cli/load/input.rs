//! Loads a scene file, or a mesh that is made into a scene.

use super::stage::{self, Rig, Stage};
use crate::{
    cli::{
        CliError,
        plan::{InputKind, InputPlan, is_standard_input, kind_of},
    },
    error::{LoadError, SceneError, escape},
    format::{self, mesh::LoadedMesh},
    scene::{Camera, NamedCamera, Scene, SceneBuilder},
};
use glam::DVec3;
use std::{
    io::{self, IsTerminal},
    path::{Path, PathBuf},
};

/// Stands for standard input in errors. Without a folder, so that paths count from the current one.
const STDIN: &str = "standard input";

/// A scene and how to look at it.
pub struct Input {
    pub scene: Scene,
    pub camera: Camera,
    /// The direction of the viewer for whom a mesh is lit.
    #[cfg_attr(
        not(feature = "viewer"),
        expect(dead_code, reason = "the window prints it as an option")
    )]
    pub lit_from: Option<DVec3>,
    /// The lights of a mesh, if they turn with the camera of a turntable.
    pub rig: Option<Rig>,
    /// Warnings.
    pub notes: Vec<String>,
}

/// Loads a scene or a mesh and sets up the camera. The scene may take `memory` bytes. Adds every file that was opened to
/// `files`.
///
/// # Errors
/// [`CliError`].
pub fn load_and_list(plan: &InputPlan, memory: u64, files: &mut Vec<PathBuf>) -> Result<Input, CliError> {
    match plan.kind {
        InputKind::Scene => load_scene(plan, memory, files),
        InputKind::Mesh => load_mesh(plan, memory, files),
    }
}

fn load_scene(plan: &InputPlan, memory: u64, files: &mut Vec<PathBuf>) -> Result<Input, CliError> {
    let scene = scene_file(&plan.path, memory, files)?;
    Ok(Input {
        camera: plan.camera.for_scene(&scene)?,
        lit_from: None,
        rig: None,
        notes: scene.sources().notes.clone(),
        scene,
    })
}

fn load_mesh(plan: &InputPlan, memory: u64, files: &mut Vec<PathBuf>) -> Result<Input, CliError> {
    let InputPlan { path, mesh, .. } = plan;
    let mut loaded = format::mesh::load_within(path, files, memory)?;
    refuse_nothing(path, &loaded)?;
    if let Some(degrees) = mesh.smooth_degrees {
        if !loaded.columns.normals.is_empty() {
            let note = "the mesh has normals of its own, so --smooth-angle has no effect";
            loaded.notes.push(format!("{}: {note}", path.display()));
        }
        loaded.columns.smooth_normals(degrees);
    }
    let up = mesh.up_axis.unwrap_or(loaded.up);
    let camera = plan.camera.for_mesh(&loaded, up, plan.aspect, mesh.turning)?;
    // A note about another file names that file already.
    let named = |note: String| match note.strip_prefix("left out") {
        Some(_) => format!("{}: {note}", path.display()),
        None => note,
    };
    let notes = std::mem::take(&mut loaded.notes).into_iter().map(named).collect();
    let view = camera.view();
    let lit_from = mesh.lit_from.unwrap_or(view.eye - view.target);
    let stage = Stage {
        towards_viewer: lit_from,
        up: up.vector(),
        ground: mesh.ground,
    };
    let (scene, rig) = stage::build(loaded, &stage, memory).map_err(|error| failed(path, &error))?;
    Ok(Input {
        scene,
        camera,
        lit_from: Some(lit_from),
        rig: Some(rig).filter(|_| mesh.turning && mesh.lit_from.is_none()),
        notes,
    })
}

/// A scene from a file, or from standard input for `-`.
fn scene_file(path: &Path, memory: u64, files: &mut Vec<PathBuf>) -> Result<Scene, CliError> {
    if !is_standard_input(path) {
        return Ok(format::load_within(path, files, memory)?);
    }
    let stdin = io::stdin();
    if stdin.is_terminal() {
        return Err(CliError::Usage(
            "cannot read a scene from a terminal: redirect a file with <, or a program's output with |"
                .into(),
        ));
    }
    Ok(format::load_from_reader(
        stdin.lock(),
        Path::new(STDIN),
        files,
        memory,
    )?)
}

/// Loads a scene, or a mesh as it is: without lights, with its cameras and notes. It may take `memory` bytes.
///
/// # Errors
/// [`CliError`].
pub fn load_bare(path: &Path, memory: u64) -> Result<Scene, CliError> {
    if kind_of(path)? == InputKind::Scene {
        return scene_file(path, memory, &mut Vec::new());
    }
    let mut builder = SceneBuilder::within(memory);
    let mut loaded = format::mesh::load_within(path, &mut Vec::new(), memory)?;
    for note in std::mem::take(&mut loaded.notes) {
        builder.add_note(note);
    }
    for camera in std::mem::take(&mut loaded.cameras) {
        // A camera without a valid view is an error only if it is asked for.
        if let Ok(view) = Camera::new(&camera.view()) {
            builder.add_camera(NamedCamera {
                name: Some(camera.name).filter(|name| !name.is_empty()),
                camera: view,
            });
        }
    }
    loaded
        .add_to(&mut builder, None)
        .map_err(|error| failed(path, &error))?;
    Ok(builder.finish())
}

fn failed(path: &Path, error: &SceneError) -> CliError {
    LoadError::whole_file(path, error.to_string()).into()
}

/// An empty picture would look like a bug.
fn refuse_nothing(path: &Path, loaded: &LoadedMesh) -> Result<(), CliError> {
    if !loaded.columns.triangles.is_empty() {
        return Ok(());
    }
    let vertices = match loaded.columns.x.len() {
        1 => "1 vertex".to_owned(),
        count => format!("{count} vertices"),
    };
    let left_out: String = loaded
        .notes
        .iter()
        .map(|note| format!("; {}", escape(note)))
        .collect();
    let message = format!("no triangles to render ({vertices}; points and lines are not rendered){left_out}");
    Err(LoadError::whole_file(path, message).into())
}
