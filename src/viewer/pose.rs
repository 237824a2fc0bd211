//! A camera as plain numbers.

use crate::{
    classic,
    scene::{Camera, CameraError, Lens, Projection, View},
};
use glam::{DMat3, DVec3};

/// A camera as the options of `octray render` describe it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position of the camera, scene units.
    pub eye: DVec3,
    /// The point it looks at, scene units.
    pub target: DVec3,
    /// The up vector.
    pub up: DVec3,
    /// Perspective or orthographic.
    pub projection: Projection,
    /// The lens, or a pinhole.
    pub lens: Lens,
}

impl From<View> for Pose {
    fn from(view: View) -> Self {
        let View {
            eye,
            target,
            up,
            projection,
            lens,
        } = view;
        Self {
            eye,
            target,
            up,
            projection,
            lens,
        }
    }
}

impl Pose {
    /// Classic viewpoint 1 to 6; `None` for another number.
    #[must_use]
    pub fn classic_view(view: u32) -> Option<Self> {
        View::classic(view).map(Self::from)
    }

    /// The camera for rendering.
    ///
    /// # Errors
    /// [`CameraError`] if this is not a valid view.
    pub fn camera(&self) -> Result<Camera, CameraError> {
        let &Self {
            eye,
            target,
            up,
            projection,
            lens,
        } = self;
        Camera::new(&View {
            eye,
            target,
            up,
            projection,
            lens,
        })
    }

    /// Returns the options of `octray render` that give this camera, exact to the last bit.
    #[must_use]
    pub fn options(&self) -> String {
        let vector = |v: DVec3| format!("{},{},{}", v.x, v.y, v.z);
        let mut options = format!(
            "--eye={} --target={} --up={}",
            vector(self.eye),
            vector(self.target),
            vector(self.up)
        );
        options += &match self.projection {
            Projection::Perspective { fov_degrees } => format!(" --fov={fov_degrees}"),
            Projection::Orthographic { height } => format!(" --ortho={height}"),
        };
        let Lens { aperture, focus } = self.lens;
        if aperture > 0.0 {
            options += &format!(" --aperture={aperture}");
            if let Some(focus) = focus {
                options += &format!(" --focus={focus}");
            }
        }
        options
    }

    /// Distance from the target, scene units.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.eye.distance(self.target)
    }

    /// Turns the camera and its up vector about the target.
    #[must_use]
    pub fn rotated(&self, rotation: DMat3) -> Self {
        Self {
            eye: self.target + rotation * (self.eye - self.target),
            up: rotation * self.up,
            ..*self
        }
    }

    /// Scales the view around the target. A perspective camera moves, and its focus distance scales with that to the target; the
    /// height of an orthographic one changes.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        match self.projection {
            Projection::Perspective { .. } => Self {
                eye: self.target + (self.eye - self.target) * factor,
                lens: Lens {
                    focus: self.lens.focus.map(|focus| focus * factor),
                    ..self.lens
                },
                ..*self
            },
            Projection::Orthographic { height } => Self {
                projection: Projection::Orthographic {
                    height: height * factor,
                },
                ..*self
            },
        }
    }

    /// Unit vectors to the right, upwards and forwards.
    #[must_use]
    pub fn frame(&self) -> [DVec3; 3] {
        let forward = (self.target - self.eye).normalize_or(DVec3::X);
        let right = forward.cross(self.up).normalize_or(DVec3::Y);
        [right, right.cross(forward), forward]
    }

    /// Looks at the centre of a box of this size around `target`, without turning, from a distance at which all of it is inside
    /// a picture `aspect` times as wide as it is high, times `margin`. The centre is in focus. An orthographic camera is placed
    /// like one with the usual field of view.
    #[must_use]
    pub fn framing(&self, target: DVec3, size: DVec3, aspect: f64, margin: f64) -> Self {
        let slope = match self.projection {
            Projection::Perspective { fov_degrees } => half_height(fov_degrees),
            Projection::Orthographic { .. } => half_height(classic::FOV_DEGREES),
        };
        let [right, up, forward] = self.frame();
        // The smallest distance at which every corner is inside the picture, and half the height of the box as seen from afar.
        let (mut distance, mut half) = (0.0_f64, 0.0_f64);
        for corner in 0..8_u32 {
            let signs = [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -0.5 } else { 0.5 });
            let v = size * DVec3::from_array(signs);
            let reach = (v.dot(right).abs() / aspect).max(v.dot(up).abs());
            distance = distance.max(reach / slope - v.dot(forward));
            half = half.max(reach);
        }
        Self {
            eye: target - forward * (distance * margin),
            target,
            projection: match self.projection {
                Projection::Orthographic { .. } => Projection::Orthographic {
                    height: 2.0 * half * margin,
                },
                perspective @ Projection::Perspective { .. } => perspective,
            },
            lens: Lens {
                focus: None,
                ..self.lens
            },
            ..*self
        }
    }
}

/// Half of the height of a picture at distance 1.
pub(super) fn half_height(fov_degrees: f64) -> f64 {
    libm::tan(fov_degrees.to_radians() / 2.0)
}

#[cfg(test)]
mod tests;
