//! What a command is given: a scene file, or a mesh that is made into a scene.

use super::{
    CliError,
    camera_args::{CameraArgs, MeshArgs, UpArg},
    source,
    stage::{self, Rig},
};
use crate::{
    error::{LoadError, SceneError, escape},
    format::{
        self,
        mesh::{LoadedMesh, MeshFormat, UpAxis},
    },
    scene::{Camera, NamedCamera, Scene, SceneBuilder},
};
use glam::DVec3;
use std::{
    io::Read,
    path::{Path, PathBuf},
};

/// A scene and how to look at it.
pub struct Input {
    pub scene: Scene,
    pub camera: Camera,
    /// From where a mesh is lit: [`MeshArgs::lit_from`], or what stood for it.
    #[cfg_attr(
        not(feature = "viewer"),
        expect(
            dead_code,
            reason = "the window prints it, so that a picture can be made again"
        )
    )]
    pub lit_from: Option<DVec3>,
    /// What lights a mesh anew for each picture of a turntable, where nothing else says how it is lit.
    pub rig: Option<Rig>,
    /// To be printed as warnings.
    pub notes: Vec<String>,
}

/// Files that people try, some of them text, which would be taken for faulty scenes.
const OTHER_KINDS: [&str; 18] = [
    "3ds", "3mf", "blend", "dae", "fbx", "iges", "igs", "jpg", "mtl", "off", "png", "step", "stp", "usd",
    "usda", "vtk", "wrl", "x3d",
];

/// Whether the file is a mesh and not a scene: by its extension, or by how it begins where that says nothing.
///
/// # Errors
/// [`CliError::Failed`] for what is neither.
pub fn is_mesh(path: &Path) -> Result<bool, CliError> {
    if MeshFormat::of_path(path).is_some() {
        return Ok(true);
    }
    let is_scene = |extension: &std::ffi::OsStr| extension.eq_ignore_ascii_case("scn");
    if path.as_os_str() == "-" || path.extension().is_some_and(is_scene) || !path.is_file() {
        return Ok(false);
    }
    let mut start = Vec::new();
    // What cannot be read is refused when it is loaded, with better words.
    let read = format::open_file(path).and_then(|file| file.take(1024).read_to_end(&mut start));
    if read.is_ok() && MeshFormat::of(path, &start).is_some() {
        return Ok(true);
    }
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    if start.contains(&0) || OTHER_KINDS.iter().any(|&other| extension == other) {
        return Err(CliError::Failed(format!(
            "{}: this is no kind of file that octray reads, expected a scene (.scn) or a mesh (.ply, .obj, .stl, .gltf, \
             .glb)",
            escape(&path.display().to_string())
        )));
    }
    Ok(false)
}

/// Refuses what is wrong already before anything is loaded: files that are not there or of no kind that is read,
/// options that do not suit them, options that make no view.
///
/// # Errors
/// [`CliError`].
pub fn check(path: &Path, camera: &CameraArgs, mesh: &MeshArgs) -> Result<(), CliError> {
    if !source::is_standard_input(path) {
        format::check_file(path)?;
    }
    check_options(path, camera, mesh).map(|_| ())
}

/// The options of [`check`]; says whether the file is a mesh.
fn check_options(path: &Path, camera: &CameraArgs, mesh: &MeshArgs) -> Result<bool, CliError> {
    camera.check()?;
    let is_mesh = is_mesh(path)?;
    if !is_mesh {
        refuse_mesh_options(path, mesh)?;
        camera.without_scene()?;
    }
    Ok(is_mesh)
}

/// Loads a scene or a mesh, and sets up the camera. `aspect` is the picture's width over its height; `memory` is what the
/// scene may take, bytes.
///
/// # Errors
/// [`CliError`].
pub fn load(
    path: &Path,
    camera: &CameraArgs,
    mesh: &MeshArgs,
    aspect: f64,
    memory: u64,
) -> Result<Input, CliError> {
    load_and_list(path, camera, mesh, aspect, memory, &mut Vec::new())
}

/// As [`load`], and adds to `files` every file that was asked for.
///
/// # Errors
/// [`CliError`].
pub fn load_and_list(
    path: &Path,
    camera: &CameraArgs,
    mesh: &MeshArgs,
    aspect: f64,
    memory: u64,
    files: &mut Vec<PathBuf>,
) -> Result<Input, CliError> {
    if !check_options(path, camera, mesh)? {
        let scene = if source::is_standard_input(path) {
            source::load(path, memory)?
        } else {
            format::load_within(path, files, memory)?
        };
        return Ok(Input {
            camera: camera.for_scene(&scene)?,
            lit_from: None,
            rig: None,
            notes: scene.sources().notes.clone(),
            scene,
        });
    }
    let mut loaded = format::mesh::load_within(path, files, memory)?;
    refuse_nothing(path, &loaded)?;
    if let Some(degrees) = mesh.smooth_angle {
        if !loaded.columns.normals.is_empty() {
            let note = "the mesh has normals of its own, so --smooth-angle changes nothing";
            loaded.notes.push(format!("{}: {note}", path.display()));
        }
        loaded.columns.smooth_normals(degrees);
    }
    let up = up_axis(&loaded, mesh);
    let camera = camera.for_mesh(&loaded, up, aspect, mesh.turning)?;
    // Of several files: which one. A note about a file beside it names that one.
    let named = |note: String| match note.strip_prefix("left out") {
        Some(_) => format!("{}: {note}", path.display()),
        None => note,
    };
    let notes = std::mem::take(&mut loaded.notes).into_iter().map(named).collect();
    let view = camera.view();
    let lit_from = mesh.lit_from.unwrap_or(view.eye - view.target);
    let stage = stage::Stage {
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

/// Loads a scene, or a mesh as it is: without lights, with the cameras and notes of its file. `memory` is what it may
/// take, bytes.
///
/// # Errors
/// [`CliError`].
pub fn load_bare(path: &Path, memory: u64) -> Result<Scene, CliError> {
    if !is_mesh(path)? {
        return source::load(path, memory);
    }
    let mut builder = SceneBuilder::within(memory);
    let mut loaded = format::mesh::load_within(path, &mut Vec::new(), memory)?;
    for note in std::mem::take(&mut loaded.notes) {
        builder.add_note(note);
    }
    for camera in std::mem::take(&mut loaded.cameras) {
        // One without a view is refused where it is asked for.
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

/// A picture of nothing would look like a fault of ours.
fn refuse_nothing(path: &Path, loaded: &LoadedMesh) -> Result<(), CliError> {
    if !loaded.columns.triangles.is_empty() {
        return Ok(());
    }
    let vertices = match loaded.columns.x.len() {
        0 => String::new(),
        1 => ", only 1 vertex".to_owned(),
        count => format!(", only {count} vertices"),
    };
    let left_out: String = loaded
        .notes
        .iter()
        .map(|note| format!("; {}", escape(note)))
        .collect();
    let message = format!(
        "there are no triangles in it to render{vertices} (points and lines are not rendered){left_out}"
    );
    Err(LoadError::whole_file(path, message).into())
}

fn up_axis(loaded: &LoadedMesh, args: &MeshArgs) -> UpAxis {
    match args.up_axis {
        Some(UpArg::Y) => UpAxis::Y,
        Some(UpArg::Z) => UpAxis::Z,
        None => loaded.up,
    }
}

fn refuse_mesh_options(path: &Path, mesh: &MeshArgs) -> Result<(), CliError> {
    let given = [
        ("--ground", mesh.ground),
        ("--up-axis", mesh.up_axis.is_some()),
        ("--smooth-angle", mesh.smooth_angle.is_some()),
        ("--lit-from", mesh.lit_from.is_some()),
    ];
    match given.iter().find(|(_, given)| *given) {
        Some((option, _)) => Err(CliError::Usage(format!(
            "{option} is for meshes (.ply, .obj, .stl, .gltf, .glb), and {} is a scene",
            path.display()
        ))),
        None => Ok(()),
    }
}
