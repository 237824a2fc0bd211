//! The plans of all commands but `render`, and the choices that several commands share.

#[cfg(feature = "viewer")]
use super::Looks;
use super::{InputPlan, PicturePath, is_standard_stream};
use crate::{
    accel::BuildQuality,
    bench::Method,
    cli::{
        CliError, report,
        write::{Output, check_writable, identity, names_directory},
    },
    error::clip_path,
    generate::{self, Kind},
    render::Settings,
    verify,
    whole_file::follow_links,
};
use std::{
    fs, io,
    path::{Path, PathBuf},
    time::Duration,
};

/// How much time building the BVH may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Build {
    /// The quality with the lowest estimated total of build and render time.
    Auto,
    Quality(BuildQuality),
}

impl Build {
    /// The quality for a scene of `primitives` that `rays` are traced through.
    pub fn quality(self, rays: f64, primitives: usize) -> BuildQuality {
        match self {
            Self::Auto => BuildQuality::for_rays(rays, primitives),
            Self::Quality(quality) => quality,
        }
    }

    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Quality(quality) => quality.name(),
        }
    }
}

/// Where a command's JSON goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum JsonTarget {
    Stdout,
    File(PathBuf),
}

impl JsonTarget {
    /// The message if standard output would get the JSON and a picture.
    pub const BESIDE_PICTURE: &str =
        "both the picture and the JSON would go to standard output: name a file for one of them";

    /// `-` is standard output.
    ///
    /// # Errors
    /// [`CliError::Failed`] if it cannot be written, such as a directory.
    pub fn new(path: &Path) -> Result<Self, CliError> {
        if is_standard_stream(path) {
            report::check_stdout()?;
            return Ok(Self::Stdout);
        }
        let name = clip_path(path);
        if names_directory(path) {
            return Err(CliError::writing(&name, &io::ErrorKind::IsADirectory.into()));
        }
        let found = fs::metadata(path).ok();
        // Pipes and devices are written as they are.
        if !found
            .as_ref()
            .is_some_and(|found| !found.is_file() && !found.is_dir())
        {
            let place = follow_links(path).map_err(|error| CliError::writing(&name, &error))?;
            check_writable(&place, found.is_some(), &name)?;
        }
        Ok(Self::File(path.to_owned()))
    }

    /// Whether it is the file of an output: also through links, or because standard output is redirected to it.
    pub fn is_file_of(&self, output: &Output) -> bool {
        let path = match self {
            Self::Stdout => Path::new("/dev/stdout"),
            Self::File(path) => path,
        };
        let is_at_place = || follow_links(path).is_ok_and(|path| path == output.place());
        let found = fs::metadata(path).ok();
        let found = found.and_then(|found| identity(path, &found));
        (found.is_some() && found.as_ref() == output.replaced()) || is_at_place()
    }
}

/// What `octray info` does.
#[derive(Debug)]
pub struct InfoPlan {
    pub path: PathBuf,
    pub json: Option<JsonTarget>,
    /// Memory that the scene may take, bytes.
    pub memory: u64,
}

/// What `octray merge` does.
#[derive(Debug)]
pub struct MergePlan {
    pub tiles: Vec<PathBuf>,
    pub output: PicturePath,
    /// Do nothing if the picture exists.
    pub skip_existing: bool,
    pub json: Option<JsonTarget>,
    /// Memory that the call may take, bytes.
    pub memory: u64,
    pub quiet: bool,
}

/// What `octray bench` does.
#[derive(Debug)]
pub struct BenchPlan {
    pub scenes: BenchScenes,
    /// Memory that a scene and its rays may take, bytes.
    pub memory: u64,
    pub methods: Vec<Method>,
    pub settings: Settings,
    /// How often each method runs, or each whole frame.
    pub repeat: u32,
    /// Time whole frames only.
    pub frames_only: bool,
    pub build: Build,
    pub json: Option<JsonTarget>,
}

/// What `octray bench` traces.
#[derive(Debug)]
pub enum BenchScenes {
    One(Box<InputPlan>),
    Suite { quick: bool },
}

/// What `octray verify` does.
#[derive(Debug)]
pub struct VerifyPlan {
    pub settings: verify::Settings,
    pub time_limit: Option<Duration>,
    pub json: Option<JsonTarget>,
}

/// What `octray generate` does.
#[derive(Debug)]
pub struct GeneratePlan {
    pub kind: Kind,
    pub options: generate::Options,
    pub folder: PathBuf,
    /// Replace files that octray did not make.
    pub force: bool,
    pub json: Option<JsonTarget>,
}

/// What `octray view` does.
#[cfg(feature = "viewer")]
#[derive(Debug)]
pub struct ViewPlan {
    pub input: InputPlan,
    /// The settings of the last picture at rest, with the size of the window.
    pub looks: Looks,
    /// Whether `octray render` would read a config file.
    pub has_config: bool,
    pub build: Build,
    /// Time for a frame while the camera moves.
    pub budget: Duration,
    /// Frames per second of an animated scene.
    pub fps: u32,
    pub benchmark: Option<Duration>,
    pub json: Option<JsonTarget>,
    /// Memory that the scene may take, bytes.
    pub memory: u64,
}
