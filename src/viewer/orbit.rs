//! The position of the camera and its movements: around its target, towards it, and in free flight.

use super::{axis, pose::Pose};
use crate::{
    format::mesh::UpAxis,
    math::Aabb,
    scene::{Camera, CameraError, Projection},
};
use glam::DVec3;

/// Degrees that the camera turns for each pixel of a drag.
pub const DEGREES_PER_PIXEL: f64 = 0.25;
/// The highest and, negated, the lowest elevation of the camera, degrees. Straight above the target, "up" has no
/// meaning.
pub const MAX_ELEVATION_DEGREES: f64 = 89.99;
/// The nearest and the farthest distance from the target, in diagonals of the scene. Nearer, `f32` is too coarse for
/// camera rays.
pub const DISTANCES: [f64; 2] = [1e-6, 1e3];
/// A framed box is seen from this many times the distance at which it touches the edge of the picture.
const FRAME_MARGIN: f64 = 1.08;

/// The diagonal of a box, scene units; `None` if it is empty or a single point.
fn diagonal_of(bounds: Aabb) -> Option<f64> {
    let extent = bounds.upper.as_dvec3() - bounds.lower.as_dvec3();
    (extent.min_element() >= 0.0 && extent.max_element() > 0.0).then(|| extent.length())
}

/// A pose that is always a valid view.
#[derive(Clone, Copy, Debug)]
pub struct Orbit {
    pose: Pose,
    camera: Camera,
    /// The nearest and the farthest distance from the target, scene units.
    limits: [f64; 2],
}

impl Orbit {
    /// Begins exactly at `pose`, in a scene of these bounds.
    ///
    /// # Errors
    /// [`CameraError`] if the pose is not a valid view.
    pub fn new(pose: Pose, bounds: Aabb) -> Result<Self, CameraError> {
        let mut orbit = Self {
            pose,
            camera: pose.camera()?,
            limits: DISTANCES,
        };
        orbit.set_bounds(bounds);
        Ok(orbit)
    }

    /// Where the camera is.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// The camera for rendering.
    #[must_use]
    pub fn camera(&self) -> Camera {
        self.camera
    }

    /// Sets the bounds of the scene, which limit the distance from the target.
    pub fn set_bounds(&mut self, bounds: Aabb) {
        let diagonal = diagonal_of(bounds).unwrap_or(1.0);
        self.limits = DISTANCES.map(|distance| distance * diagonal);
    }

    /// Moves to `pose` if it is a valid view.
    pub fn go_to(&mut self, pose: Pose) {
        if let Ok(camera) = pose.camera() {
            self.pose = pose;
            self.camera = camera;
        }
    }

    /// Orbits around the target as a drag by `right` and `down` pixels does: the object follows the mouse.
    pub fn turn(&mut self, right: f64, down: f64) {
        let Pose { eye, target, up, .. } = self.pose;
        let up = up.normalize_or(DVec3::Z);
        let from_target = eye - target;
        let distance = from_target.length();
        // Azimuth 0 is +x where z points up.
        let across = if up.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
        let e0 = (across - up * up.dot(across)).normalize_or(DVec3::X);
        let e1 = up.cross(e0);
        let step = DEGREES_PER_PIXEL.to_radians();
        let limit = MAX_ELEVATION_DEGREES.to_radians();
        let azimuth = libm::atan2(from_target.dot(e1), from_target.dot(e0)) - right * step;
        let height = (from_target.dot(up) / distance).clamp(-1.0, 1.0);
        let elevation = (libm::asin(height) + down * step).clamp(-limit, limit);
        let (sin_a, cos_a) = libm::sincos(azimuth);
        let (sin_e, cos_e) = libm::sincos(elevation);
        let direction = (e0 * cos_a + e1 * sin_a) * cos_e + up * sin_e;
        self.go_to(Pose {
            eye: target + direction * distance,
            ..self.pose
        });
    }

    /// Multiplies the distance from the target by `factor`, or the height of an orthographic view. A step beyond [`DISTANCES`]
    /// is not taken; a camera that is already beyond them can come back by the same factor.
    pub fn approach(&mut self, factor: f64) {
        let size = match self.pose.projection {
            Projection::Perspective { .. } => self.pose.distance(),
            Projection::Orthographic { height } => height,
        };
        let [nearest, farthest] = self.limits;
        let next = size * factor;
        if next >= nearest.min(size) && next <= farthest.max(size) {
            self.go_to(self.pose.scaled(factor));
        }
    }

    /// Flies `right`, `up` and `forward` (1 for a second at full speed) without turning. Speed is in proportion to the
    /// distance from the target, or to the height of an orthographic view, so that small objects can be looked at closely.
    pub fn fly(&mut self, right: f64, up: f64, forward: f64) {
        const SPEED: f64 = 0.8;
        let Pose { eye, target, .. } = self.pose;
        let axes = self.pose.frame();
        let step = axes[0] * right + axes[1] * up + axes[2] * forward;
        let step = step
            * match self.pose.projection {
                Projection::Perspective { .. } => SPEED * self.pose.distance(),
                Projection::Orthographic { height } => SPEED * height,
            };
        self.go_to(Pose {
            eye: eye + step,
            target: target + step,
            ..self.pose
        });
    }

    /// Frames bounds, which are relative to a point, as seen from one of the six sides of a mesh that stands on `up`.
    pub fn frame_side(&mut self, bounds: (Aabb, DVec3), aspect: f64, side: usize, up: UpAxis) {
        let Pose { target, .. } = self.pose;
        self.go_to(Pose {
            eye: target + axis::side(up, side),
            up: up.vector(),
            ..self.pose
        });
        self.frame(bounds, aspect);
    }

    /// Looks at the centre of `bounds`, which are relative to `offset`, from where all of it is inside a picture `aspect` times
    /// as wide as it is high, without turning. Does nothing if `bounds` is empty or a point.
    pub fn frame(&mut self, (bounds, offset): (Aabb, DVec3), aspect: f64) {
        if diagonal_of(bounds).is_none() {
            return;
        }
        let (lower, upper) = (bounds.lower.as_dvec3(), bounds.upper.as_dvec3());
        let (middle, size) = ((lower + upper) / 2.0 + offset, upper - lower);
        self.go_to(self.pose.framing(middle, size, aspect, FRAME_MARGIN));
    }
}

#[cfg(test)]
mod tests;
