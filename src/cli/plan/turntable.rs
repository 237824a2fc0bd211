//! `--turntable`: the camera turns once around its target. Frames of poses and of animated scenes are counted likewise.

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

/// Numbers of frames, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    /// From 1 on; frame 1 is the camera's own view.
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

    /// The frames to render.
    ///
    /// # Errors
    /// [`CliError::Usage`] if `frames` goes beyond the last one.
    pub fn turns(self) -> Result<impl Iterator<Item = Turn>, CliError> {
        let Self { count, frames } = self;
        let FrameRange { first, last } = frames.unwrap_or(FrameRange {
            first: 1,
            last: count,
        });
        if last > count {
            return Err(CliError::Usage(format!(
                "--frames {first}-{last}: the last frame is {count}, expected numbers from 1 to {count}"
            )));
        }
        Ok((first..=last).map(move |number| Turn { number, count }))
    }
}

/// The view of one frame: the first is the view itself, the others follow counterclockwise around the up vector.
pub fn turned(view: &View, Turn { number, count }: Turn) -> View {
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
mod tests {
    use super::*;
    use crate::scene::{Lens, Projection};
    use glam::DVec3;
    use proptest::prelude::*;

    #[test]
    fn a_quarter_turn_goes_counterclockwise() {
        let view = View {
            eye: DVec3::new(3.0, 0.0, 2.0),
            target: DVec3::new(1.0, 0.0, 0.0),
            up: DVec3::new(0.0, 0.0, 4.0),
            projection: Projection::DEFAULT,
            lens: Lens::PINHOLE,
        };
        assert_eq!(turned(&view, Turn { number: 1, count: 4 }), view);
        let second = turned(&view, Turn { number: 2, count: 4 });
        assert!(
            (second.eye - DVec3::new(1.0, 2.0, 2.0)).length() < 1e-12,
            "{second:?}"
        );
        assert_eq!((second.target, second.up), (view.target, view.up));
    }

    proptest! {
        #[test]
        fn the_distance_stays(x in -9.0..9.0, y in -9.0..9.0, z in 1.0..9.0, number in 1u32..=24) {
            let eye = DVec3::new(x, y, z);
            let view = View { eye, target: DVec3::ZERO, up: DVec3::new(0.3, -0.2, 1.0), projection: Projection::DEFAULT, lens: Lens::PINHOLE };
            let turned = turned(&view, Turn { number, count: 24 }).eye;
            prop_assert!((turned.length() - eye.length()).abs() < 1e-9);
            prop_assert!((turned.dot(view.up) - eye.dot(view.up)).abs() < 1e-9);
        }
    }
}
