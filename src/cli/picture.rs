//! A picture in memory, as `octray render` makes it: for the Python package.

pub use super::plan::{CameraOptions, Side, StartView, Style};
use super::{
    CliError, args, load,
    plan::{InputPlan, MeshOptions},
};
use crate::{
    accel::{BuildQuality, Bvh},
    format::{
        self,
        mesh::{LoadedMesh, UpAxis, UpSource},
    },
    render::{Aovs, Film, OnProgress, Renderer, Settings},
    scene::{Camera, TriangleMesh},
};
use std::path::Path;

/// Loads a mesh alone, within the memory that a picture may take.
///
/// # Errors
/// [`CliError::Load`].
pub fn mesh(path: &Path) -> Result<LoadedMesh, CliError> {
    let memory = load::memory::limit(None);
    Ok(format::mesh::load_within(path, &mut Vec::new(), memory)?)
}

/// Returns the camera of a picture of `size`: of a mesh whose z axis points up, in the style of [`picture`], or one that
/// depends on no mesh.
///
/// # Errors
/// [`CliError::Usage`].
pub fn camera(
    mesh: Option<TriangleMesh>,
    options: &CameraOptions,
    [width, height]: [u32; 2],
) -> Result<Camera, CliError> {
    options.check()?;
    let Some(columns) = mesh else {
        let missing = || CliError::Usage("the camera depends on a mesh".into());
        return options.without_scene()?.ok_or_else(missing);
    };
    let aspect = f64::from(width) / f64::from(height);
    let mesh = LoadedMesh {
        columns,
        ..LoadedMesh::default()
    };
    options.for_mesh(&mesh, UpAxis::Z, aspect, &shown(None))
}

/// How a mesh is shown.
fn shown(style: Option<Style>) -> MeshOptions {
    MeshOptions {
        style: style.unwrap_or(Style::Studio),
        is_style_given: style.is_some(),
        ..MeshOptions::default()
    }
}

/// The subject of a picture.
#[derive(Debug)]
pub enum Subject<'a> {
    /// A scene or a mesh.
    File(&'a Path),
    /// A mesh whose z axis points up.
    Mesh(TriangleMesh),
}

/// A picture in memory.
#[derive(Debug)]
pub struct Picture {
    /// Red, green and blue of each pixel, row by row, the top row first: the bytes that `octray render` writes.
    pub color: Vec<u8>,
    /// Its output variables, if requested.
    pub aovs: Option<Aovs>,
    /// Warnings.
    pub notes: Vec<String>,
}

/// Renders a picture of `size` (width and height, pixels). Without a style meshes are in that of `octray render`; `samples`
/// is a value of its `--samples`.
///
/// # Errors
/// [`CliError`].
pub fn picture(
    subject: Subject<'_>,
    camera: CameraOptions,
    [width, height]: [u32; 2],
    style: Option<Style>,
    samples: Option<&str>,
    with_aovs: bool,
    on_progress: OnProgress<'_>,
) -> Result<Picture, CliError> {
    let settings = Settings {
        width,
        height,
        ..Settings::default()
    };
    settings.validate()?;
    let aspect = f64::from(width) / f64::from(height);
    let memory = load::memory::limit(None);
    let mesh = shown(style);
    let style = mesh.style;
    let (plan, mut input) = match subject {
        Subject::File(path) => {
            let plan = InputPlan::new(path, camera, mesh, aspect)?;
            let input = load::load_and_list(&plan, memory, &mut Vec::new())?;
            (plan, input)
        }
        Subject::Mesh(columns) => {
            camera.check()?;
            let plan = InputPlan::of_mesh(camera, mesh, aspect);
            let mesh = LoadedMesh {
                columns,
                up: UpAxis::Z,
                up_source: UpSource::Stated,
                ..LoadedMesh::default()
            };
            let input = load::show_mesh(&plan, mesh, memory)?;
            (plan, input)
        }
    };
    let faults = load::faults::of(&input.scene);
    if !input.is_cloud {
        input.notes.extend(faults.warning(plan.name()));
    }
    let (settings, transfer) = args::look(settings, input.is_mesh().then_some(style), samples)?;
    settings.validate()?;
    load::memory::check_build(&input.scene, BuildQuality::Best)?;
    let bvh = Bvh::build(&input.scene);
    let mut renderer = Renderer::new(&input.scene, &bvh);
    let mut film = <Film>::new(1, 1);
    renderer.render(&input.camera, &settings, &mut film, on_progress)?;
    let aovs = if with_aovs {
        Some(renderer.aovs(&input.camera, &settings, false, on_progress)?)
    } else {
        None
    };
    Ok(Picture {
        color: film.to_bytes(transfer),
        aovs,
        notes: input.notes,
    })
}
