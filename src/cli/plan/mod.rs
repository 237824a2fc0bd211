//! What a call does, as plain values: made and checked from the arguments before anything is loaded.
//!
//! This module does not know how options are spelled or parsed; later ones do not look at the arguments again.

mod choice;
mod color;
mod defaults;
mod input;
mod job;
mod keyframes;
mod listed;
mod look;
mod misplaced;
mod names;
mod places;
mod poses;
mod render;
mod turntable;

#[cfg(feature = "viewer")]
pub use choice::ViewPlan;
pub use choice::{BenchPlan, BenchScenes, Build, GeneratePlan, InfoPlan, JsonTarget, MergePlan, VerifyPlan};
pub use color::{COLORS, ColorBy, ColorMap, Shading, color_of};
pub use defaults::{ConfigDefault, explained, explained_plan};
pub use input::{
    ANIMATION, CameraOptions, FIT, FOCUS, FOR_MESHES, InputKind, InputPlan, MeshOptions, Side, StartView,
    Style, is_for_meshes, is_standard_stream, kind_of, name,
};
pub use job::{Engine, JobPlan};
#[cfg(feature = "viewer")]
pub use keyframes::playback_of;
pub use keyframes::{Keyframes, NOT_PLAYED_FROM_STANDARD_INPUT, Playback, Playing, keyframes};
pub use listed::ListedPicture;
pub use look::{Backdrop, Look, Looks, PictureOptions};
pub use names::{Origin, PicturePath, aov as aov_path, check_pattern, expand, has_number, of_frame, stem};
pub use poses::{PoseFile, PoseFiles, Poses, SavedPoses};
pub use render::{
    CompareOptions, Frame, Job, Pictures, Planned, RenderPlan, SheetPlan, check_inputs, objection,
};
pub use turntable::{FrameRange, Orbit, Turn, Turntable};

use super::load::memory;

/// One call of the program.
#[derive(Debug)]
pub enum Plan {
    Render(Box<RenderPlan>),
    #[cfg(feature = "viewer")]
    View(Box<ViewPlan>),
    Job(Box<JobPlan>),
    Merge(MergePlan),
    Info(InfoPlan),
    Bench(BenchPlan),
    Verify(VerifyPlan),
    Generate(GeneratePlan),
    /// The completion script of the shell of this name.
    Completions(String),
    /// The manual page of a command, or of octray as a whole.
    Man(Option<String>),
}

impl Plan {
    /// Memory that the call may take, bytes.
    pub fn memory(&self) -> u64 {
        match self {
            Self::Render(plan) => plan.memory,
            #[cfg(feature = "viewer")]
            Self::View(plan) => plan.memory,
            Self::Job(plan) => plan.render.memory,
            Self::Merge(plan) => plan.memory,
            Self::Info(plan) => plan.memory,
            Self::Bench(plan) => plan.memory,
            _ => memory::limit(None),
        }
    }
}
