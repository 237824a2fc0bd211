//! The plans of all commands but `render`, and the choices that several commands share.

use super::InputPlan;
use crate::{
    accel::BuildQuality,
    bench::Method,
    generate::{self, Kind},
    render::Settings,
    verify,
};
use std::{
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
    /// `-` is standard output.
    pub fn new(path: &Path) -> Self {
        if path.as_os_str() == "-" {
            Self::Stdout
        } else {
            Self::File(path.to_owned())
        }
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

/// What `octray bench` does.
#[derive(Debug)]
pub struct BenchPlan {
    pub scenes: BenchScenes,
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
    /// A scene, and the memory that it may take, bytes.
    One(Box<InputPlan>, u64),
    Suite {
        quick: bool,
    },
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
}

/// What `octray view` does.
#[cfg(feature = "viewer")]
#[derive(Debug)]
pub struct ViewPlan {
    pub input: InputPlan,
    /// Of the size of the window.
    pub settings: Settings,
    pub build: Build,
    /// Time for a frame while the camera moves.
    pub budget: Duration,
    pub benchmark: Option<Duration>,
    pub json: Option<JsonTarget>,
    /// Memory that the scene may take, bytes.
    pub memory: u64,
}
