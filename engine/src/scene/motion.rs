//! Motion: instances and cameras between keyframes. Times are frame numbers.
//!
//! All of it is computed in `f64` with `libm`, so that a frame is the same on every machine.

use super::{Camera, CameraError, Lens, Projection, Transform, View};
use crate::{error::SceneError, math};
use glam::{DVec3, DVec4};

/// The most keyframes of a scene.
pub const MAX_KEYFRAMES: usize = 1 << 16;

/// The most steps of a keyframe.
pub const MAX_STEPS: usize = 16;

/// The last time of a keyframe.
pub const MAX_TIME: f64 = 100_000.0;

/// Axes whose directions differ by less are one axis.
const SAME_AXIS: f64 = 1e-12;

/// A step that places an instance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// A scaling about the origin.
    Scale(DVec3),
    /// A rotation about an axis through the origin, counterclockwise as seen from its tip.
    Rotate {
        /// Of any length but 0.
        axis: DVec3,
        /// Any number of turns.
        degrees: f64,
    },
    /// A move.
    Translate(DVec3),
}

impl Step {
    /// Returns the name of the step in the scene language.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Scale(_) => "scale",
            Self::Rotate { .. } => "rotate",
            Self::Translate(_) => "translate",
        }
    }

    /// The identity of this kind of step.
    fn neutral(self) -> Self {
        match self {
            Self::Scale(_) => Self::Scale(DVec3::ONE),
            Self::Rotate { axis, .. } => Self::Rotate { axis, degrees: 0.0 },
            Self::Translate(_) => Self::Translate(DVec3::ZERO),
        }
    }

    /// Interpolates to another step of its kind; `share` is from 0 to 1.
    fn towards(self, next: Self, share: f64) -> Self {
        match (self, next) {
            (Self::Scale(a), Self::Scale(b)) => Self::Scale(mix(a, b, share)),
            (Self::Translate(a), Self::Translate(b)) => Self::Translate(mix(a, b, share)),
            (
                Self::Rotate { axis, degrees },
                Self::Rotate {
                    axis: next,
                    degrees: end,
                },
            ) => rotation_between((axis, degrees), (next, end), share),
            _ => self,
        }
    }
}

fn unit_or_zero(vector: DVec3) -> DVec3 {
    math::moderate(vector).normalize_or_zero()
}

/// Interpolates two rotations: about the same axis, or opposite ones, the angles, which may be several turns, else by slerp
/// (Shoemake, *Animating Rotation with Quaternion Curves*, 1985).
fn rotation_between(
    (axis, degrees): (DVec3, f64),
    (next_axis, next_degrees): (DVec3, f64),
    share: f64,
) -> Step {
    let (a, b) = (unit_or_zero(axis), unit_or_zero(next_axis));
    let about = |axis, from: f64, to: f64| Step::Rotate {
        axis,
        degrees: from + (to - from) * share,
    };
    // At 0 degrees any axis is the same.
    if degrees == 0.0 {
        return about(next_axis, 0.0, next_degrees);
    }
    if next_degrees == 0.0 || (a - b).length() < SAME_AXIS {
        return about(axis, degrees, next_degrees);
    }
    if (a + b).length() < SAME_AXIS {
        return about(axis, degrees, -next_degrees);
    }
    let quaternion = |axis: DVec3, degrees: f64| {
        let (sin, cos) = libm::sincos((degrees * 0.5).to_radians());
        DVec4::from((axis * sin, cos))
    };
    let between = slerp(quaternion(a, degrees), quaternion(b, next_degrees), share);
    let (axis, w) = (between.truncate(), between.w);
    Step::Rotate {
        axis,
        degrees: (2.0 * libm::atan2(axis.length(), w)).to_degrees(),
    }
}

/// Interpolates two unit quaternions spherically, the shorter way. glam's version has the sine of the system.
#[doc(hidden)]
#[must_use]
pub fn slerp(from: DVec4, to: DVec4, share: f64) -> DVec4 {
    // A quaternion and its negative are one rotation.
    let to = if from.dot(to) < 0.0 { -to } else { to };
    let angle = 2.0 * libm::atan2((from - to).length(), (from + to).length());
    let sin = libm::sin(angle);
    if sin > SAME_AXIS {
        (from * libm::sin((1.0 - share) * angle) + to * libm::sin(share * angle)) / sin
    } else {
        from
    }
}

fn mix(a: DVec3, b: DVec3, share: f64) -> DVec3 {
    a + (b - a) * share
}

/// States at ascending times.
#[derive(Clone, Debug)]
struct Track<T>(Vec<(f64, T)>);

impl<T> Track<T> {
    /// Checks the time of the next state.
    fn check(&self, time: f64) -> Result<(), SceneError> {
        if !(0.0..=MAX_TIME).contains(&time) {
            return Err(SceneError::Keyframe(format!(
                "the time is {time}, expected a number from 0 to {MAX_TIME}"
            )));
        }
        match self.0.last() {
            Some((last, _)) if time <= *last => Err(SceneError::Keyframe(format!(
                "the time is {time}, expected more than {last}, the time of the previous keyframe"
            ))),
            _ if self.0.len() >= MAX_KEYFRAMES => Err(SceneError::TooMany {
                what: "keyframes",
                limit: MAX_KEYFRAMES,
            }),
            _ => Ok(()),
        }
    }

    /// The states around a time, and the share for interpolation. Before the first and after the last state nothing moves.
    fn around(&self, time: f64) -> Option<(&T, &T, f64)> {
        let next = self.0.partition_point(|(at, _)| *at <= time);
        let last = self.0.get(next.saturating_sub(1))?;
        let end = self.0.get(next).filter(|_| next > 0).unwrap_or(last);
        let share = if end.0 > last.0 {
            (time - last.0) / (end.0 - last.0)
        } else {
            0.0
        };
        Some((&last.1, &end.1, share))
    }
}

impl<T> Default for Track<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

/// The motion of an instance: steps at times, which apply after its own placement.
///
/// ```
/// # use octray_engine as octray;
/// use octray::{glam::DVec3, scene::{Motion, Step, Transform}};
///
/// # fn main() -> Result<(), octray::error::SceneError> {
/// let mut motion = Motion::default();
/// motion.add(1.0, vec![Step::Translate(DVec3::ZERO)])?;
/// motion.add(25.0, vec![Step::Translate(DVec3::X * 6.0)])?;
/// assert_eq!(motion.at(9.0), Transform::IDENTITY.then_translate(DVec3::X * 2.0));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct Motion(Track<Vec<Step>>);

impl Motion {
    /// Adds a keyframe. All have steps of the same kinds in the same order; one without steps changes nothing.
    ///
    /// # Errors
    /// [`SceneError::Keyframe`]: a time that is not after the one before or not from 0 to [`MAX_TIME`], other steps than
    /// those of the previous keyframe, factors of a scaling that pass 0. [`SceneError::TooMany`].
    pub fn add(&mut self, time: f64, mut steps: Vec<Step>) -> Result<(), SceneError> {
        self.0.check(time)?;
        if steps.len() > MAX_STEPS {
            return Err(SceneError::TooMany {
                what: "steps of a keyframe",
                limit: MAX_STEPS,
            });
        }
        if let Some((_, before)) = self.0.0.last_mut() {
            let neutral = |steps: &[Step]| steps.iter().map(|step| step.neutral()).collect();
            if steps.is_empty() {
                steps = neutral(before);
            } else if before.is_empty() {
                *before = neutral(&steps);
            }
            check_steps(before, &steps)?;
        }
        self.0.0.push((time, steps));
        Ok(())
    }

    /// Returns the placement at a time: between two keyframes each step is interpolated; before the first and after the last
    /// keyframe nothing moves.
    ///
    /// Numbers are interpolated linearly, and angles too if both rotations have the same axis, or opposite ones; other
    /// rotations by slerp.
    #[must_use]
    pub fn at(&self, time: f64) -> Transform {
        let Some((from, to, share)) = self.0.around(time) else {
            return Transform::IDENTITY;
        };
        let steps = from.iter().zip(to);
        steps.fold(Transform::IDENTITY, |transform, (from, to)| {
            transform.then_step(&if share > 0.0 {
                from.towards(*to, share)
            } else {
                *from
            })
        })
    }

    /// Returns the times of the keyframes, in ascending order.
    pub fn times(&self) -> impl ExactSizeIterator<Item = f64> {
        self.0.0.iter().map(|(time, _)| *time)
    }

    /// Refuses a time for the next keyframe.
    #[doc(hidden)]
    pub fn check_time(&self, time: f64) -> Result<(), SceneError> {
        self.0.check(time)
    }
}

/// Refuses steps that cannot follow others.
fn check_steps(before: &[Step], steps: &[Step]) -> Result<(), SceneError> {
    let names = |steps: &[Step]| steps.iter().map(Step::name).collect::<Vec<_>>().join(" ");
    let kinds = [before, steps].map(names);
    if kinds[0] != kinds[1] {
        return Err(SceneError::Keyframe(format!(
            "found the steps `{}`, expected those of the previous keyframe, `{}`",
            kinds[1], kinds[0]
        )));
    }
    let flips = before.iter().zip(steps).any(|steps| match steps {
        (Step::Scale(a), Step::Scale(b)) => (*a * *b).min_element() <= 0.0,
        _ => false,
    });
    if flips {
        let why = "a factor of `scale` changes its sign, so that it would be 0 in between";
        return Err(SceneError::Keyframe(why.into()));
    }
    Ok(())
}

/// The motion of a camera: views at times.
#[derive(Clone, Debug, Default)]
pub struct CameraMotion(Track<View>);

impl CameraMotion {
    /// Adds a keyframe. All have a projection of the same kind, and all or none a distance in focus.
    ///
    /// # Errors
    /// [`SceneError::Keyframe`]: a time that is not after the one before or not from 0 to [`MAX_TIME`], a view without a
    /// picture, or of another kind than the one before. [`SceneError::TooMany`].
    pub fn add(&mut self, time: f64, view: View) -> Result<(), SceneError> {
        self.0.check(time)?;
        Camera::new(&view).map_err(|error| SceneError::Keyframe(error.to_string()))?;
        if let Some((_, before)) = self.0.0.last() {
            use std::mem::discriminant;
            let why = if discriminant(&before.projection) != discriminant(&view.projection) {
                "a perspective camera cannot become an orthographic one"
            } else if before.lens.focus.is_some() != view.lens.focus.is_some() {
                "some keyframes have a focus and others do not, expected all or none"
            } else {
                ""
            };
            if !why.is_empty() {
                return Err(SceneError::Keyframe(why.into()));
            }
        }
        self.0.0.push((time, view));
        Ok(())
    }

    /// Returns the camera at a time: all numbers are interpolated linearly, up vectors after normalisation; before the first
    /// and after the last keyframe nothing moves.
    ///
    /// # Errors
    /// [`CameraError`] if the eye meets its target there, or the view is along the up vector; without keyframes.
    pub fn at(&self, time: f64) -> Result<Camera, CameraError> {
        let (from, to, share) = self.0.around(time).ok_or(CameraError::NoKeyframes)?;
        Camera::new(&if share > 0.0 {
            view_between(from, to, share)
        } else {
            *from
        })
    }

    /// Returns the times of the keyframes, in ascending order.
    pub fn times(&self) -> impl ExactSizeIterator<Item = f64> {
        self.0.0.iter().map(|(time, _)| *time)
    }

    /// Whether there is a lens at a keyframe.
    pub(super) fn has_lens(&self) -> bool {
        self.0.0.iter().any(|(_, view)| view.lens.aperture > 0.0)
    }

    /// Refuses a time for the next keyframe.
    #[doc(hidden)]
    pub fn check_time(&self, time: f64) -> Result<(), SceneError> {
        self.0.check(time)
    }
}

fn view_between(a: &View, b: &View, share: f64) -> View {
    let number = |a: f64, b: f64| a + (b - a) * share;
    View {
        eye: mix(a.eye, b.eye, share),
        target: mix(a.target, b.target, share),
        up: if a.up == b.up {
            a.up
        } else {
            mix(unit_or_zero(a.up), unit_or_zero(b.up), share)
        },
        projection: match (a.projection, b.projection) {
            (
                Projection::Perspective { fov_degrees },
                Projection::Perspective {
                    fov_degrees: next_degrees,
                },
            ) => Projection::Perspective {
                fov_degrees: number(fov_degrees, next_degrees),
            },
            (Projection::Orthographic { height }, Projection::Orthographic { height: next }) => {
                Projection::Orthographic {
                    height: number(height, next),
                }
            }
            (projection, _) => projection,
        },
        lens: Lens {
            aperture: number(a.lens.aperture, b.lens.aperture),
            focus: a.lens.focus.zip(b.lens.focus).map(|(a, b)| number(a, b)),
        },
    }
}
