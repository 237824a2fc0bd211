//! A scene or a mesh to load, with its camera.

use super::{ColorBy, Orbit, Playback, Shading};
use crate::{
    cli::CliError,
    error::clip_path,
    format::{
        self,
        mesh::{self, MeshFormat, Moment, UpAxis},
    },
    scene::Projection,
};
use glam::{DMat3, DVec3};
use std::{
    ffi::OsStr,
    io::Read,
    path::{Path, PathBuf},
};

/// A scene or a mesh to load, with its camera.
#[derive(Clone, Debug)]
pub struct InputPlan {
    pub path: PathBuf,
    pub kind: InputKind,
    pub camera: CameraOptions,
    pub mesh: MeshOptions,
    /// Width of the picture over its height.
    pub aspect: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputKind {
    Scene,
    Mesh,
    /// Standard input: known once it is read.
    Any,
}

/// The selected camera, and the changes to it.
#[derive(Clone, Debug, Default)]
pub struct CameraOptions {
    pub start: StartView,
    pub target: Option<DVec3>,
    pub up: Option<DVec3>,
    pub projection: Option<Projection>,
    /// An orthographic view that frames the mesh, instead of `projection`.
    pub fits_ortho: bool,
    /// Diameter of the lens, scene units.
    pub aperture: Option<f64>,
    /// Distance in focus, scene units.
    pub focus: Option<f64>,
    /// Options from a config file, which are ignored where they do not apply.
    pub defaults: Vec<&'static str>,
}

/// The camera before target, up, projection and lens are changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum StartView {
    /// The scene's first camera, else the first classic viewpoint; a mesh is framed.
    #[default]
    Default,
    /// A camera of the file, by name or number.
    Named(String),
    /// A classic viewpoint.
    Classic(u32),
    Eye(DVec3),
    /// A mesh is framed from there.
    Side(Side),
}

/// Where the viewer of a mesh is, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// To the right of the mesh's front.
    pub azimuth: f64,
    /// Above the mesh.
    pub elevation: f64,
}

impl Side {
    /// The sides that have names.
    pub const NAMED: [(&str, Self); 6] = [
        ("front", Self::at(0.0, 0.0)),
        ("right", Self::at(90.0, 0.0)),
        ("back", Self::at(180.0, 0.0)),
        ("left", Self::at(-90.0, 0.0)),
        ("top", Self::at(0.0, 90.0)),
        ("bottom", Self::at(0.0, -90.0)),
    ];

    const fn at(azimuth: f64, elevation: f64) -> Self {
        Self { azimuth, elevation }
    }
}

/// The lighting of a mesh, and the defaults of its picture's options.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// Two point lights; one sample per pixel, display values.
    #[default]
    Plain,
    /// A large light and ambient occlusion; many samples, linear light, sRGB.
    Studio,
    /// As [`Self::Studio`], all of one colour.
    Clay,
}

impl Style {
    /// Whether colours are linear light, and shadows soft.
    pub fn is_soft(self) -> bool {
        self != Self::Plain
    }
}

/// How a mesh without a scene is shown.
#[derive(Clone, Debug, Default)]
pub struct MeshOptions {
    pub style: Style,
    /// Whether the style was chosen.
    pub is_style_given: bool,
    pub up_axis: Option<UpAxis>,
    /// How keys have turned the mesh, with its up axis, since the camera was chosen.
    pub turned: DMat3,
    pub ground: bool,
    pub smooth_degrees: Option<f64>,
    /// Diameter of points and lines; by their spacing or size if `None`.
    pub point_size: Option<f32>,
    /// Numbers that are shown instead of its colours.
    pub color_by: ColorBy,
    /// The moment of an animation in which the mesh is shown.
    pub moment: Option<Moment>,
    /// How an animation is played; frame 1 is the `moment`.
    pub playback: Option<Playback>,
    /// The direction of the viewer for whom the mesh is lit; by default that of the eye.
    pub lit_from: Option<DVec3>,
    /// The picture of an environment, which lights the mesh instead, and its rotation in degrees.
    pub environment: Option<(PathBuf, f64)>,
    /// The camera goes around the mesh, which stays whole in the picture.
    pub orbit: Option<Orbit>,
    /// Options from a config file that a scene ignores.
    pub defaults: Vec<&'static str>,
}

/// Stands for standard input in messages. Without a folder, so that paths count from the current one.
const STDIN: &str = "standard input";

impl InputPlan {
    /// What messages call it.
    pub fn name(&self) -> &Path {
        name(&self.path)
    }

    /// A scene or a mesh that is in memory, with this name in messages.
    ///
    /// # Errors
    /// [`CliError`], as for [`InputPlan::new`].
    pub fn in_memory(
        (name, kind): (&Path, InputKind),
        camera: CameraOptions,
        mesh: MeshOptions,
        aspect: f64,
    ) -> Result<Self, CliError> {
        camera.check()?;
        mesh.check()?;
        Ok(Self {
            path: name.to_owned(),
            kind,
            camera,
            mesh,
            aspect,
        })
    }

    /// Checks what can be known without loading: the file exists, its type is supported, and the options suit it.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn new(path: &Path, camera: CameraOptions, mesh: MeshOptions, aspect: f64) -> Result<Self, CliError> {
        if path.is_dir() {
            let (folder, files) = (clip_path(path), clip_path(&path.join("*.scn")));
            return Err(CliError::Failed(format!(
                "{folder}: this is a directory, expected files such as {files}"
            )));
        }
        if !is_standard_stream(path) {
            format::check_file(path)?;
        }
        camera.check()?;
        let kind = kind_of(path)?;
        if kind == InputKind::Scene {
            mesh.refuse_for_scene(path)?;
            camera.refuse_for_scene(path)?;
            camera.without_scene()?;
        } else {
            mesh.check()?;
        }
        Ok(Self {
            path: path.to_owned(),
            kind,
            camera,
            mesh,
            aspect,
        })
    }
}

/// Other files that people try. Some are text and would otherwise be read as faulty scenes.
const OTHER_KINDS: [&str; 3] = ["jpg", "mtl", "png"];

/// Distinguishes meshes from scenes by the file's extension, else by its first bytes.
///
/// # Errors
/// [`CliError::Failed`] for any other kind of file.
pub fn kind_of(path: &Path) -> Result<InputKind, CliError> {
    if MeshFormat::of_path(path).is_some() {
        return Ok(InputKind::Mesh);
    }
    let is_scene = |extension: &OsStr| extension.eq_ignore_ascii_case("scn");
    if is_standard_stream(path) {
        return Ok(InputKind::Any);
    }
    if path.extension().is_some_and(is_scene) || !path.is_file() {
        return Ok(InputKind::Scene);
    }
    let mut start = Vec::new();
    // A file that cannot be read is refused when it is loaded, with a better message.
    let read = format::open_file(path).and_then(|file| file.take(1024).read_to_end(&mut start));
    if read.is_ok() && MeshFormat::of(path, &start).is_some() {
        return Ok(InputKind::Mesh);
    }
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    // Text without any statement of a scene is no scene.
    let is_scene = format::is_scene_file(path, &start);
    if read.is_ok() {
        format::refuse_unread(path, &start)?;
    }
    if !is_scene || OTHER_KINDS.iter().any(|&other| extension == other) {
        // By its bytes: `mesh.ply.gz` and pictures are known.
        if read.is_ok() {
            format::refuse_foreign(path, &start)?;
        }
        return Err(CliError::Failed(format!(
            "{}: unknown file type, expected a scene (.scn) or a mesh (.ply, .obj, .off, .stl, .gltf, .glb, .3mf, .vtk, .vtp, .vtu)",
            clip_path(path)
        )));
    }
    Ok(InputKind::Scene)
}

/// The options that show a pose of an animation.
pub const ANIMATION: [&str; 2] = ["--animation", "--animation-time"];
/// The distance in focus, which needs a lens.
pub const FOCUS: &str = "--focus";
/// The height that frames a mesh.
pub const FIT: &str = "--ortho fit";

/// Further options that apply to meshes only.
pub const FOR_MESHES: [&str; 12] = [
    "--style",
    "--ground",
    "--up-axis",
    "--smooth-angle",
    "--point-size",
    "--color-by",
    "--color-map",
    "--color-range",
    "--lit-from",
    "--environment",
    "--environment-rotate",
    "--from",
];

/// What messages call an input.
pub fn name(path: &Path) -> &Path {
    if is_standard_stream(path) {
        Path::new(STDIN)
    } else {
        path
    }
}

/// Whether this stands for standard input or output.
pub fn is_standard_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

impl MeshOptions {
    /// Checks what concerns neither the mesh nor the camera.
    fn check(&self) -> Result<(), CliError> {
        let Some((path, _)) = &self.environment else {
            return Ok(());
        };
        format::check_file(path)?;
        if self.style.is_soft() {
            return Ok(());
        }
        let why = "--environment needs --style studio or clay: plain light is not linear";
        Err(CliError::Usage(why.to_owned()))
    }

    /// Leaves out an animation of the config file if the mesh has none. Finding that out may take `memory` bytes.
    pub(super) fn without_stray_animation(self, path: &Path, memory: u64) -> Self {
        let is_default = |option| self.defaults.contains(option);
        let is_default = self.moment.is_some() && ANIMATION.iter().all(is_default);
        if !is_default || self.playback.is_some() || is_standard_stream(path) {
            return self;
        }
        // What cannot be read is refused when it is loaded.
        match mesh::animations(path, memory) {
            Ok(animations) if animations.is_empty() => Self { moment: None, ..self },
            _ => self,
        }
    }

    /// Refuses options that have no effect on a scene.
    ///
    /// # Errors
    /// [`CliError::Usage`].
    pub fn refuse_for_scene(&self, scene: &Path) -> Result<(), CliError> {
        let is_named = |moment: &Moment| moment.animation.is_some();
        let given = [
            ("--style", self.is_style_given),
            ("--ground", self.ground),
            ("--up-axis", self.up_axis.is_some()),
            ("--smooth-angle", self.smooth_degrees.is_some()),
            ("--point-size", self.point_size.is_some()),
            ("--color-by", self.color_by.values != Shading::Own),
            (ANIMATION[0], self.moment.as_ref().is_some_and(is_named)),
            (ANIMATION[1], self.moment.is_some()),
            ("--lit-from", self.lit_from.is_some()),
            ("--environment", self.environment.is_some()),
        ];
        refuse_any(&given, &self.defaults, scene)
    }
}

impl CameraOptions {
    /// Refuses options that need a mesh.
    ///
    /// # Errors
    /// [`CliError::Usage`].
    pub fn refuse_for_scene(&self, scene: &Path) -> Result<(), CliError> {
        let is_side = matches!(self.start, StartView::Side(_));
        let given = [("--from", is_side), (FIT, self.fits_ortho)];
        refuse_any(&given, &self.defaults, scene)
    }
}

/// Whether an option with its value, such as `--from=top`, applies to meshes only.
pub fn is_for_meshes(option: &str) -> bool {
    let name = option.split('=').next().unwrap_or_default();
    option == "--ortho=fit" || ANIMATION.contains(&name) || FOR_MESHES.contains(&name)
}

/// Refuses options of meshes that are given for a scene, except for those that are only `defaults`.
fn refuse_any(given: &[(&str, bool)], defaults: &[&str], scene: &Path) -> Result<(), CliError> {
    let is_refused = |(option, is_given): &&(&str, bool)| *is_given && !defaults.contains(option);
    match given.iter().find(is_refused) {
        Some((option, _)) => Err(CliError::Usage(format!(
            "{option} applies to meshes only (.ply, .obj, .off, .stl, .gltf, .glb, .3mf, .vtk, .vtp, .vtu), and {} is a scene",
            clip_path(scene)
        ))),
        None => Ok(()),
    }
}
