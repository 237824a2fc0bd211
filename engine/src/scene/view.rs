//! The parameters of a camera: position, projection and lens.

use crate::{classic, error::short_number};
use glam::DVec3;
use std::fmt;

/// Why a camera cannot be set up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraError {
    /// A coordinate is NaN or infinite.
    NotFinite,
    /// Eye and target are the same point.
    EyeOnTarget,
    /// The view direction is parallel to the up vector, or the up vector is zero.
    UpParallel,
    /// The field of view is not between 0 and 180 degrees.
    FieldOfView(f64),
    /// The height of an orthographic view is not a number above 0, or too large for `f32`.
    ViewHeight(f64),
    /// The diameter of the lens is negative, not finite, or too large for the distance in focus.
    Aperture(f64),
    /// The distance in focus is not a number above 0.
    Focus(f64),
    /// The principal point is not finite, or more than 100 heights of the picture from its centre.
    PrincipalOffset([f64; 2]),
    /// The aspect of a pixel is not a number from 0.001 to 1000.
    PixelAspect(f64),
    /// A coefficient of the distortion is NaN, or larger than 1e12.
    Distortion(f64),
    /// A distortion for an orthographic camera, or for one with an aperture.
    DistortedProjection,
    /// A motion without keyframes.
    NoKeyframes,
}

impl fmt::Display for CameraError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "the camera has a coordinate that is not finite"),
            Self::NoKeyframes => write!(f, "the motion of the camera has no keyframes"),
            Self::EyeOnTarget => write!(
                f,
                "eye and target are the same point, so there is no view direction"
            ),
            Self::UpParallel => write!(
                f,
                "the up vector is zero or parallel to the view direction; choose another, such as 0 1 0 for a view \
                 straight down"
            ),
            Self::FieldOfView(degrees) => write!(
                f,
                "the field of view is {} degrees, expected more than 0 and less than 180",
                short_number(*degrees)
            ),
            Self::ViewHeight(height) => write!(
                f,
                "the height of the orthographic view is {}, expected a number above 0",
                short_number(*height)
            ),
            Self::Aperture(diameter) => write!(
                f,
                "the aperture is {}, expected a diameter of 0 or more, and at most a million times the distance in \
                 focus",
                short_number(*diameter)
            ),
            Self::Focus(distance) => write!(
                f,
                "the distance in focus is {}, expected a number above 0",
                short_number(*distance)
            ),
            Self::PrincipalOffset([right, down]) => write!(
                f,
                "the principal point is {} picture heights right of and {} below the centre, expected at most 100",
                short_number(*right),
                short_number(*down)
            ),
            Self::PixelAspect(aspect) => write!(
                f,
                "the pixels are {} times as wide as high, expected a number from 0.001 to 1000",
                short_number(*aspect)
            ),
            Self::Distortion(coefficient) => write!(
                f,
                "the distortion has the coefficient {}, expected a number of at most 1e12",
                short_number(*coefficient)
            ),
            Self::DistortedProjection => {
                write!(f, "a distortion needs a perspective camera without an aperture")
            }
        }
    }
}

impl std::error::Error for CameraError {}

/// The projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// All rays start at the eye.
    Perspective {
        /// Vertical field of view, degrees.
        fov_degrees: f64,
    },
    /// All rays are parallel and start at the plane through the eye.
    Orthographic {
        /// Height of the view, scene units.
        height: f64,
    },
}

impl Projection {
    /// The default: a perspective one.
    pub const DEFAULT: Self = Self::Perspective {
        fov_degrees: classic::FOV_DEGREES,
    };

    /// Returns half of the height of the view: at distance 1 of a perspective one, else in scene units.
    pub(super) fn half_height(self) -> Result<f64, CameraError> {
        match self {
            Self::Perspective { fov_degrees } if fov_degrees > 0.0 && fov_degrees < 180.0 => {
                Ok(libm::tan(fov_degrees.to_radians() * 0.5))
            }
            Self::Perspective { fov_degrees } => Err(CameraError::FieldOfView(fov_degrees)),
            Self::Orthographic { height } if height > 0.0 && (height as f32).is_finite() => Ok(0.5 * height),
            Self::Orthographic { height } => Err(CameraError::ViewHeight(height)),
        }
    }
}

/// A thin lens, which is in focus at one distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Diameter, scene units; 0 for a pinhole.
    pub aperture: f64,
    /// Distance along the view of the plane in focus, scene units; that of the target if `None`.
    pub focus: Option<f64>,
}

impl Lens {
    /// Everything is sharp.
    pub const PINHOLE: Self = Self {
        aperture: 0.0,
        focus: None,
    };

    /// The largest diameter relative to the focus distance, so that directions stay finite in `f32`.
    const MAX_APERTURE: f64 = 1e6;

    /// Returns the lens of a scene that is scaled.
    #[must_use]
    pub(super) fn scaled(self, scale: f64) -> Self {
        Self {
            aperture: self.aperture * scale,
            focus: self.focus.map(|focus| focus * scale),
        }
    }

    /// Checks the lens; `distance` is that of the target. Returns the distance in focus.
    pub(super) fn check(self, distance: f64) -> Result<f64, CameraError> {
        let focus = self.focus.unwrap_or(distance);
        if !(focus > 0.0 && focus.is_finite()) {
            return Err(CameraError::Focus(focus));
        }
        if !(self.aperture >= 0.0 && self.aperture <= focus * Self::MAX_APERTURE) {
            return Err(CameraError::Aperture(self.aperture));
        }
        Ok(focus)
    }
}

/// The parameters of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Position of the eye, scene units.
    pub eye: DVec3,
    /// The point to look at, scene units.
    pub target: DVec3,
    /// The up vector, of any length.
    pub up: DVec3,
    /// Perspective or orthographic.
    pub projection: Projection,
    /// The lens, or a pinhole.
    pub lens: Lens,
}

impl View {
    /// The default up vector.
    pub const UP: DVec3 = classic::UP;
    /// The default vertical field of view, degrees.
    pub const FOV_DEGREES: f64 = classic::FOV_DEGREES;

    /// Returns the classic viewpoint 1 to 6; `None` for another number.
    #[must_use]
    pub fn classic(view: u32) -> Option<Self> {
        Some(Self {
            eye: classic::viewpoint(view)?,
            target: classic::TARGET,
            up: Self::UP,
            projection: Projection::DEFAULT,
            lens: Lens::PINHOLE,
        })
    }
}
