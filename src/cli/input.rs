//! What a command is given: a scene file, or a mesh that is made into a scene.

use super::{
    CliError,
    args::{CameraArgs, MeshArgs, UpArg},
    source, stage,
};
use crate::{
    course,
    format::{
        self,
        mesh::{LoadedMesh, MeshCamera, MeshFormat, UpAxis},
    },
    scene::{Camera, CameraError, FitView, Scene, SceneBuilder},
};
use glam::DVec3;
use std::{
    fs::File,
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
    /// To be printed as warnings.
    pub notes: Vec<String>,
}

/// From where a mesh is shown: this far to the right of its front, degrees, ...
const AZIMUTH_DEGREES: f64 = 35.0;
/// ... and this far above.
const ELEVATION_DEGREES: f64 = 20.0;

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
    let read = File::open(path).and_then(|file| file.take(1024).read_to_end(&mut start));
    if read.is_ok() && MeshFormat::of(path, &start).is_some() {
        return Ok(true);
    }
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    if start.contains(&0) || OTHER_KINDS.iter().any(|&other| extension == other) {
        return Err(CliError::Failed(format!(
            "{}: this is no kind of file that octray reads, expected a scene (.scn) or a mesh (.ply, .obj, .stl, .gltf, \
             .glb)",
            crate::error::escape(&path.display().to_string())
        )));
    }
    Ok(false)
}

/// Loads a scene or a mesh, and sets up the camera. `aspect` is the picture's width over its height.
///
/// # Errors
/// [`CliError`].
pub fn load(path: &Path, camera: &CameraArgs, mesh: &MeshArgs, aspect: f64) -> Result<Input, CliError> {
    load_and_list(path, camera, mesh, aspect, &mut Vec::new())
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
    files: &mut Vec<PathBuf>,
) -> Result<Input, CliError> {
    if !is_mesh(path)? {
        refuse_mesh_options(path, mesh)?;
        // Before a large scene is loaded for nothing.
        camera.without_scene()?;
        let scene = if source::is_standard_input(path) {
            source::load(path)?
        } else {
            format::load_and_list(path, files)?
        };
        return Ok(Input {
            camera: camera.for_scene(&scene)?,
            lit_from: None,
            notes: scene.sources().notes.clone(),
            scene,
        });
    }
    check(camera)?;
    let loaded = load_mesh(path, mesh, files)?;
    let up = up_axis(&loaded, mesh);
    let view = View::new(path, &loaded, camera, up, aspect)?;
    let notes = loaded.notes.clone();
    let lit_from = mesh.lit_from.unwrap_or(view.eye - view.target);
    let stage = stage::Stage {
        towards_viewer: lit_from,
        up: up.vector(),
        ground: mesh.ground,
    };
    let scene = stage::build(loaded, &stage).map_err(|error| failed(path, &error))?;
    Ok(Input {
        scene,
        camera: Camera::look_at(view.eye, view.target, view.up, view.fov_degrees)?,
        lit_from: Some(lit_from),
        notes,
    })
}

/// Loads a scene, or a mesh as it is: without lights.
///
/// # Errors
/// [`CliError`].
pub fn load_bare(path: &Path) -> Result<Scene, CliError> {
    if !is_mesh(path)? {
        return source::load(path);
    }
    let mut builder = SceneBuilder::new();
    let loaded = format::mesh::load(path)?;
    loaded
        .add_to(&mut builder, None)
        .map_err(|error| failed(path, &error))?;
    Ok(builder.finish())
}

fn failed(path: &Path, error: &crate::error::SceneError) -> CliError {
    CliError::Load(crate::error::LoadError::whole_file(path, error.to_string()))
}

fn load_mesh(path: &Path, args: &MeshArgs, files: &mut Vec<PathBuf>) -> Result<LoadedMesh, CliError> {
    let mut loaded = format::mesh::load_and_list(path, files)?;
    if let Some(degrees) = args.smooth_angle {
        loaded.columns.smooth_normals(degrees);
    }
    Ok(loaded)
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

/// Refuses what makes no view whatever the mesh, before it is loaded.
fn check(args: &CameraArgs) -> Result<(), CameraError> {
    let fov = args.fov.unwrap_or(course::FOV_DEGREES);
    let eye = args.eye.unwrap_or(DVec3::new(1.0, 2.0, 3.0));
    let target = args.target.filter(|_| args.eye.is_some());
    let target = target.unwrap_or(eye + DVec3::new(0.3, 0.5, 0.7));
    // Any axis that is not along the view.
    let across = (target - eye)
        .try_normalize()
        .map_or(DVec3::Z, DVec3::any_orthonormal_vector);
    Camera::look_at(eye, target, args.up.unwrap_or(across), fov).map(|_| ())
}

/// How a mesh is looked at.
struct View {
    eye: DVec3,
    target: DVec3,
    up: DVec3,
    fov_degrees: f64,
}

impl View {
    fn new(
        path: &Path,
        loaded: &LoadedMesh,
        args: &CameraArgs,
        axis: UpAxis,
        aspect: f64,
    ) -> Result<Self, CliError> {
        if let Some(name) = &args.camera {
            let found = find_camera(path, &loaded.cameras, name)?;
            return Ok(Self {
                eye: found.eye,
                target: args.target.unwrap_or(found.target),
                up: args.up.unwrap_or(found.up),
                fov_degrees: args.fov.unwrap_or(found.fov_degrees),
            });
        }
        let fov_degrees = args.fov.unwrap_or(course::FOV_DEGREES);
        if let Some(eye) = args.view.and_then(course::viewpoint) {
            return Ok(Self {
                eye,
                target: args.target.unwrap_or(course::TARGET),
                up: args.up.unwrap_or(course::UP),
                fov_degrees,
            });
        }
        let up = args.up.unwrap_or(axis.vector());
        let view = FitView {
            towards_viewer: three_quarter(axis),
            up,
            fov_degrees,
            aspect,
        };
        let fit = view.fit(&loaded.columns)?;
        let target = args.target.unwrap_or(fit.target);
        Ok(Self {
            // Without an eye of its own, a target moves the view and leaves its direction.
            eye: args.eye.unwrap_or(target + fit.eye - fit.target),
            target,
            up,
            fov_degrees,
        })
    }
}

/// From the front, the right and above. A mesh's front is where it looks in Blender's and glTF's conventions.
fn three_quarter(axis: UpAxis) -> DVec3 {
    let (sin_a, cos_a) = libm::sincos(AZIMUTH_DEGREES.to_radians());
    let rise = libm::tan(ELEVATION_DEGREES.to_radians());
    match axis {
        UpAxis::Y => DVec3::new(sin_a, rise, cos_a),
        UpAxis::Z => DVec3::new(sin_a, -cos_a, rise),
    }
}

/// A camera of the file, by its name or its number from 1 on.
fn find_camera<'a>(path: &Path, cameras: &'a [MeshCamera], name: &str) -> Result<&'a MeshCamera, CliError> {
    let by_name = cameras.iter().find(|camera| camera.name == name);
    let by_number = || cameras.get(name.parse::<usize>().ok()?.checked_sub(1)?);
    by_name.or_else(by_number).ok_or_else(|| {
        let names = cameras
            .iter()
            .enumerate()
            .map(|(i, camera)| match camera.name.as_str() {
                "" => (i + 1).to_string(),
                name => format!("`{}`", crate::error::escape(name)),
            });
        let known: Vec<String> = names.take(20).collect();
        let known = if known.is_empty() {
            "no cameras".to_owned()
        } else {
            format!("these cameras: {}", known.join(", "))
        };
        CliError::Usage(format!("no camera `{name}`: {} has {known}", path.display()))
    })
}
