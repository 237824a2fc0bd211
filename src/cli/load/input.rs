//! Loads a scene file, or a mesh and makes a scene of it.

use super::{
    Legend, Poses, color, environment, faults,
    stage::{self, Built, Rig, Stage},
};
use crate::{
    cli::{
        CliError,
        plan::{InputKind, InputPlan, Shading, Style, kind_of, name},
        process,
    },
    error::{LoadError, SceneError, clip_path},
    format::{
        self, Limits, Loaded,
        mesh::{LoadedMesh, MeshAnimation, Moment, Scalar, Shown, Surface, Wanted},
    },
    scene::{Camera, Image, NamedCamera, Scene, SceneBuilder, check_memory},
};
use glam::DVec3;
use std::{
    io::{self, IsTerminal},
    path::{Path, PathBuf},
};

/// A scene and its camera.
pub struct Input {
    pub scene: Scene,
    pub camera: Camera,
    /// The direction of the viewer for whom a mesh is lit.
    pub lit_from: Option<DVec3>,
    /// Whether a mesh is lit by its own lights instead.
    #[cfg(feature = "viewer")]
    pub has_own_lights: bool,
    /// Whether a mesh has points or lines instead of faces.
    pub is_cloud: bool,
    /// The lights of a mesh, if they turn with the camera of a turntable.
    pub rig: Option<Rig>,
    /// What the colours of a mesh mean, if they show numbers.
    pub legend: Option<Legend>,
    /// The poses of a mesh that is played.
    pub poses: Option<Poses>,
    /// Warnings.
    pub notes: Vec<String>,
}

/// Loads a scene or a mesh within these limits and sets up the camera. Adds every file that was opened to `files`.
///
/// # Errors
/// [`CliError`].
pub fn load_and_list(
    plan: &InputPlan,
    limits: impl Into<Limits>,
    files: &mut Vec<PathBuf>,
) -> Result<Input, CliError> {
    let limits = limits.into();
    let memory = limits.memory;
    let poses = plan.mesh.playback.as_ref();
    let poses = poses
        .map(|playback| Poses::of(plan, playback, memory))
        .transpose()?;
    match read(
        &plan.path,
        plan.kind,
        limits,
        files,
        shown(plan, plan.mesh.moment.clone()),
    )? {
        Loaded::Scene(scene) => show_scene(plan, *scene),
        Loaded::Mesh(mesh) => {
            files.extend(plan.mesh.environment.as_ref().map(|(path, _)| path.clone()));
            let input = show_pose(plan, *mesh, memory, poses.as_ref())?;
            Ok(Input { poses, ..input })
        }
    }
}

/// As [`load_and_list`], from the bytes of a scene or a mesh: the plan's path only names them, and files that they name are
/// in its folder.
///
/// # Errors
/// [`CliError`].
pub fn load_bytes(plan: &InputPlan, bytes: &[u8], memory: u64) -> Result<Input, CliError> {
    let path = plan.name();
    process::at_work_on(path);
    let shown = shown(plan, plan.mesh.moment.clone());
    match format::load_any_shown(bytes, path, &mut Vec::new(), memory, shown)? {
        Loaded::Scene(scene) => show_scene(plan, *scene),
        Loaded::Mesh(mesh) => show_mesh(plan, *mesh, memory),
    }
}

/// Loads a frame of the animation that a mesh plays, as [`load_and_list`] its first one.
///
/// # Errors
/// [`CliError`].
pub fn load_frame(plan: &InputPlan, memory: u64, poses: &Poses, frame: u32) -> Result<Input, CliError> {
    let moment = plan.mesh.playback.as_ref().map(|playback| playback.moment(frame));
    poses.check(plan)?;
    let mesh = format::mesh::load_shown(&plan.path, &mut Vec::new(), memory, shown(plan, moment))?;
    show_pose(plan, mesh, memory, Some(poses))
}

/// What is shown of a plan's mesh at a moment.
fn shown(plan: &InputPlan, moment: Option<Moment>) -> Shown {
    Shown {
        images: plan.mesh.style != Style::Clay && plan.mesh.color_by.values == Shading::Own,
        moment,
        scalars: plan.mesh.color_by.values.wanted(),
    }
}

fn read(
    path: &Path,
    kind: InputKind,
    limits: Limits,
    files: &mut Vec<PathBuf>,
    shown: Shown,
) -> Result<Loaded, CliError> {
    process::at_work_on(name(path));
    Ok(match kind {
        InputKind::Scene => Loaded::Scene(Box::new(format::load_limited(path, files, limits)?)),
        InputKind::Mesh => {
            let mesh = format::mesh::load_shown(path, files, limits, shown)?;
            Loaded::Mesh(Box::new(mesh))
        }
        InputKind::Any => {
            let stdin = io::stdin();
            if stdin.is_terminal() {
                let why =
                    "standard input is a terminal: redirect a file with <, or a program's output with |";
                return Err(CliError::Usage(why.into()));
            }
            format::load_any_shown(stdin.lock(), name(path), files, limits, shown)?
        }
    })
}

impl Input {
    /// The direction of the viewer for whom a mesh is lit, unless it has its own lights.
    #[cfg(feature = "viewer")]
    pub fn is_lit_from(&self) -> Option<DVec3> {
        self.lit_from.filter(|_| !self.has_own_lights)
    }

    /// Whether it is a mesh, and not a scene.
    pub fn is_mesh(&self) -> bool {
        self.lit_from.is_some()
    }
}

fn show_scene(plan: &InputPlan, scene: Scene) -> Result<Input, CliError> {
    plan.mesh.refuse_for_scene(plan.name())?;
    plan.camera.refuse_for_scene(plan.name())?;
    Ok(Input {
        camera: plan.camera.for_scene(&scene)?,
        lit_from: None,
        #[cfg(feature = "viewer")]
        has_own_lights: false,
        is_cloud: false,
        rig: None,
        legend: None,
        poses: None,
        notes: scene.sources().notes.clone(),
        scene,
    })
}

/// Makes a scene of a mesh and sets up the camera.
///
/// # Errors
/// [`CliError`].
pub fn show_mesh(plan: &InputPlan, loaded: LoadedMesh, memory: u64) -> Result<Input, CliError> {
    show_pose(plan, loaded, memory, None)
}

/// As [`show_mesh`], for one of several poses.
fn show_pose(
    plan: &InputPlan,
    mut loaded: LoadedMesh,
    memory: u64,
    poses: Option<&Poses>,
) -> Result<Input, CliError> {
    let mesh = &plan.mesh;
    let path = plan.name();
    refuse_nothing(path, &loaded)?;
    set_point_radius(&mut loaded, mesh.point_size, path);
    if let Some(degrees) = mesh.smooth_degrees {
        smooth(&mut loaded, degrees, path, memory)?;
    }
    let up = mesh.up_axis.unwrap_or(loaded.up);
    let around = poses.map(|poses| poses.around(&mut loaded));
    let surface = match mesh.style {
        Style::Clay => Surface {
            diffuse: Surface::WHITE.diffuse,
            ..Surface::CLAY
        },
        _ => Surface::WHITE,
    };
    let (poses, limits) = (around.as_ref(), (path, memory));
    let legend = color::color(&mut loaded, poses, &mesh.color_by, surface, limits)?;
    let framed = around.as_ref().unwrap_or(&loaded);
    let camera = plan.camera.for_mesh(framed, up, plan.aspect, mesh)?;
    let (offset, is_cloud) = (loaded.offset, loaded.cloud.is_some());
    let mut notes = std::mem::take(&mut loaded.notes);
    if mesh.up_axis.is_none() {
        notes.extend(loaded.up_note(path));
    }
    let environment = mesh.environment.as_ref();
    let environment = environment
        .map(|(path, degrees)| environment::load((path, *degrees), up, memory, &mut notes))
        .transpose()?;
    let view = camera.view();
    let lit_from = mesh.lit_from.unwrap_or(view.eye - view.target);
    let stage = Stage {
        towards_viewer: lit_from,
        up: up.vector(),
        ground: mesh.ground,
        style: mesh.style,
        is_colored: legend.is_some(),
        own_lights: mesh.lit_from.is_none(),
        around: around.as_ref(),
    };
    let built = stage::build(loaded, &stage, environment, memory);
    let Built { scene, rig, bounds } = built.map_err(|message| LoadError::whole_file(path, message))?;
    notes.extend(faults::coarse(path, &bounds));
    let up = up.vector();
    let lowest = [bounds.lower, bounds.upper].map(|corner| corner.as_dvec3().dot(up));
    if mesh.ground && (view.eye - offset).dot(up) < lowest[0].min(lowest[1]) {
        notes.push(format!(
            "{}: the camera is below the ground, which hides the mesh: leave out --ground",
            clip_path(path)
        ));
    }
    Ok(Input {
        scene,
        camera,
        lit_from: Some(lit_from),
        #[cfg(feature = "viewer")]
        has_own_lights: rig.is_none(),
        is_cloud,
        rig: rig.filter(|_| mesh.orbit.is_some() && mesh.lit_from.is_none()),
        legend,
        poses: None,
        notes,
    })
}

/// Gives the mesh smooth normals if it has none. Shared parts are smoothed separately.
fn smooth(loaded: &mut LoadedMesh, degrees: f64, path: &Path, memory: u64) -> Result<(), CliError> {
    let why = match &loaded.cloud {
        Some(cloud) if cloud.lines.is_empty() => "points are spheres",
        Some(_) => "lines are round",
        None => "the mesh has normals of its own",
    };
    let has_normals = loaded.arrays().any(|columns| !columns.normals.is_empty());
    if loaded.cloud.is_some() || has_normals {
        let note = format!("{why}, so --smooth-angle has no effect");
        loaded.notes.push(format!("{}: {note}", clip_path(path)));
        return Ok(());
    }
    // Smoothing takes about as much memory as the scene. Each vertex gets a normal.
    let (mut triangles, mut vectors) = (0, 0);
    for columns in loaded.arrays() {
        triangles += columns.triangles.len();
        vectors += 2 * columns.x.len() + columns.colors.len() + columns.uvs.len() + columns.tangents.len();
    }
    let images = loaded
        .images
        .iter()
        .map(|image| Image::bytes(image.size()) as u64);
    let fits = check_memory([triangles, 0, vectors], images.sum(), memory);
    fits.map_err(|error| failed(path, &error))?;
    loaded
        .arrays_mut()
        .try_for_each(|columns| columns.smooth_normals(degrees))
        .map_err(|error| failed(path, &error))
}

/// A scene without studio light, and what else the file of a mesh has.
pub struct Bare {
    pub scene: Scene,
    pub animations: Vec<MeshAnimation>,
    pub(in crate::cli) scalars: Vec<Scalar>,
}

/// Loads a scene, or a mesh without studio light, with its lights, cameras and notes. It may take `memory` bytes. Adds every
/// file that was opened to `files`.
///
/// # Errors
/// [`CliError`].
pub fn load_bare(path: &Path, memory: u64, files: &mut Vec<PathBuf>) -> Result<Bare, CliError> {
    let kind = kind_of(path)?;
    let shown = Shown {
        images: true,
        scalars: Wanted::Ranges,
        ..Shown::default()
    };
    let mut loaded = match read(path, kind, memory.into(), files, shown)? {
        Loaded::Scene(scene) => {
            return Ok(Bare {
                scene: *scene,
                animations: Vec::new(),
                scalars: Vec::new(),
            });
        }
        Loaded::Mesh(mesh) => *mesh,
    };
    let path = name(path);
    let mut builder = SceneBuilder::within(memory);
    let with_offset = builder.set_offset(loaded.offset);
    with_offset.map_err(|error| failed(path, &error))?;
    for note in std::mem::take(&mut loaded.notes) {
        builder.add_note(note);
    }
    for (number, camera) in (1..).zip(std::mem::take(&mut loaded.cameras)) {
        // A camera without a valid view is an error only if it is selected.
        match Camera::new(&camera.view()) {
            Ok(view) => builder.add_camera(NamedCamera {
                name: Some(camera.name).filter(|name| !name.is_empty()),
                camera: view,
            }),
            Err(error) => {
                let path = clip_path(path);
                builder.add_note(format!("{path}: camera {number} makes no picture: {error}"));
            }
        }
    }
    for light in std::mem::take(&mut loaded.lights) {
        builder.add(light).map_err(|error| failed(path, &error))?;
    }
    set_point_radius(&mut loaded, None, path);
    if let Some(cloud) = &loaded.cloud {
        let radius = cloud.radius(&loaded.columns);
        let what = match cloud.lines.len() {
            0 => "its points become spheres".to_owned(),
            1 => "its line becomes a tube".to_owned(),
            lines => format!("its {lines} lines become tubes"),
        };
        builder.add_note(format!(
            "{}: no faces: {what} of radius {radius}",
            clip_path(path)
        ));
    }
    if let Some(note) = faults::coarse(path, &stage::bounds_of(&loaded)) {
        builder.add_note(note);
    }
    let animations = std::mem::take(&mut loaded.animations);
    let scalars = std::mem::take(&mut loaded.scalars.listed);
    loaded
        .add_to(&mut builder, None)
        .map_err(|error| failed(path, &error))?;
    Ok(Bare {
        scene: builder.finish(),
        animations,
        scalars,
    })
}

pub(super) fn failed(path: &Path, error: &SceneError) -> CliError {
    LoadError::whole_file(path, error.to_string())
        .with_kind(error.into())
        .into()
}

/// Sets the radius of a cloud's points and lines: half the diameter if there is one, else by the cloud.
fn set_point_radius(loaded: &mut LoadedMesh, diameter: Option<f32>, path: &Path) {
    if let Some(cloud) = &mut loaded.cloud {
        cloud.radius = diameter.map(|diameter| 0.5 * diameter);
        cloud.radius = Some(cloud.radius(&loaded.columns));
    } else if diameter.is_some() {
        let note = "the mesh has faces, so --point-size has no effect";
        loaded.notes.push(format!("{}: {note}", clip_path(path)));
    }
}

/// An empty picture would look like a bug.
fn refuse_nothing(path: &Path, loaded: &LoadedMesh) -> Result<(), CliError> {
    if loaded.cloud.is_some() || loaded.arrays().any(|columns| !columns.triangles.is_empty()) {
        return Ok(());
    }
    let vertices = match loaded.columns.x.len() {
        1 => "1 vertex".to_owned(),
        count => format!("{count} vertices"),
    };
    const MOST_NOTES: usize = 3;
    let prefix = format!("{}: ", clip_path(path));
    let notes = loaded.notes.iter().take(MOST_NOTES);
    let left_out: String = notes
        .map(|note| format!("; {}", note.strip_prefix(&prefix).unwrap_or(note)))
        .collect();
    let message = format!("no triangles to render ({vertices}){left_out}");
    Err(LoadError::whole_file(path, message).into())
}
