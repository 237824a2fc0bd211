//! `--turntable` and `--sphere`: the camera goes around its target. Frames of poses and of animated scenes are counted likewise.

use crate::{cli::CliError, scene::View};
use std::f64::consts::TAU;

/// The frames of a turntable, of poses or of a scene, or a part of them.
#[derive(Clone, Copy, Debug)]
pub struct Turntable {
    /// All frames.
    pub count: u32,
    /// The frames to render; all by default.
    pub frames: Option<FrameRange>,
}

/// How the camera goes around its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Orbit {
    /// Once around the up vector.
    Turn,
    /// To points that are spread evenly over a sphere.
    Sphere,
}

/// Numbers of frames, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    /// From 1 on; frame 1 of a turntable is the camera's own view.
    pub first: u32,
    /// Not below the first.
    pub last: u32,
}

/// One frame of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turn {
    /// From 1 on.
    pub number: u32,
    /// All frames.
    pub count: u32,
}

impl Turntable {
    /// How many frames there are to render.
    pub fn frames_to_render(self) -> u64 {
        self.frames.map_or(u64::from(self.count), |frames| {
            u64::from(frames.last - frames.first) + 1
        })
    }

    /// The frames to render; `of` says in the error what has them, such as ` of a.scn`.
    ///
    /// # Errors
    /// [`CliError::Usage`] if `frames` goes beyond the last one.
    pub fn turns(self, of: &str) -> Result<impl Iterator<Item = Turn>, CliError> {
        let Self { count, frames } = self;
        let FrameRange { first, last } = frames.unwrap_or(FrameRange {
            first: 1,
            last: count,
        });
        if last > count {
            return Err(CliError::Usage(format!(
                "--frames {first}-{last}: the last frame{of} is {count}, expected numbers from 1 to {count}"
            )));
        }
        Ok((first..=last).map(move |number| Turn { number, count }))
    }
}

impl Orbit {
    /// The view of one frame.
    pub fn view(self, view: &View, turn: Turn) -> View {
        match self {
            Self::Turn => turned(view, turn),
            Self::Sphere => on_sphere(view, turn),
        }
    }
}

/// The view of one frame from a sphere around the target: from top to bottom on a Fibonacci spiral (Vogel 1979), each point
/// in a band of equal area.
fn on_sphere(view: &View, Turn { number, count }: Turn) -> View {
    let arm = view.eye - view.target;
    let Some(axis) = view.up.try_normalize() else {
        return *view;
    };
    let side = arm - axis * axis.dot(arm);
    let side = side
        .try_normalize()
        .unwrap_or_else(|| axis.any_orthonormal_vector());
    let golden_angle = TAU * (1.0 - 0.5 * (5.0_f64.sqrt() - 1.0));
    let height = 1.0 - (2.0 * f64::from(number) - 1.0) / f64::from(count);
    let (sin, cos) = libm::sincos(golden_angle * f64::from(number - 1));
    let around = side * cos + axis.cross(side) * sin;
    let out = axis * height + around * (1.0 - height * height).sqrt();
    View {
        eye: view.target + out * arm.length(),
        ..*view
    }
}

/// The view of one frame of a turntable: the first is the view itself, the others follow counterclockwise around the up vector.
fn turned(view: &View, Turn { number, count }: Turn) -> View {
    let Some(axis) = view.up.try_normalize().filter(|_| number > 1) else {
        return *view;
    };
    let (sin, cos) = libm::sincos(TAU * f64::from(number - 1) / f64::from(count));
    let arm = view.eye - view.target;
    // Rodrigues' formula.
    let turned = arm * cos + axis.cross(arm) * sin + axis * (axis.dot(arm) * (1.0 - cos));
    View {
        eye: view.target + turned,
        ..*view
    }
}

#[cfg(test)]
mod tests;
