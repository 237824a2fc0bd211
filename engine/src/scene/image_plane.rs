//! How a picture lies in the image plane, and the intrinsics of a camera in pixels.
//!
//! ```text
//!   +---------------------+
//!   |          |          |   the optical axis meets the picture at the principal point P,
//!   |          +----> P   |   `principal_offset` away from the centre
//!   |                     |
//!   +---------------------+
//! ```

use super::{CameraError, Projection};

/// How a picture lies in the image plane: for cameras with an off-centre principal point, or pixels that are not square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImagePlane {
    /// The principal point relative to the picture's centre: right and down, in heights of the picture.
    pub principal_offset: [f64; 2],
    /// Width of a pixel over its height: `fl_y / fl_x`.
    pub pixel_aspect: f64,
}

impl ImagePlane {
    /// The optical axis meets the picture's centre, and pixels are square.
    pub const CENTERED: Self = Self {
        principal_offset: [0.0; 2],
        pixel_aspect: 1.0,
    };

    /// The largest offset, so that directions keep their precision in `f32`.
    const MAX_OFFSET: f64 = 100.0;

    /// The largest aspect of a pixel, or of one on its side.
    const MAX_ASPECT: f64 = 1000.0;

    /// Checks the numbers.
    pub(super) fn check(self) -> Result<(), CameraError> {
        // The comparisons are false for NaN.
        if !self
            .principal_offset
            .iter()
            .all(|offset| offset.abs() <= Self::MAX_OFFSET)
        {
            return Err(CameraError::PrincipalOffset(self.principal_offset));
        }
        if !(self.pixel_aspect >= 1.0 / Self::MAX_ASPECT && self.pixel_aspect <= Self::MAX_ASPECT) {
            return Err(CameraError::PixelAspect(self.pixel_aspect));
        }
        Ok(())
    }

    /// Returns the picture's centre relative to the optical axis, right and up, for a picture with that half height.
    pub(super) fn shift(self, half_height: f64) -> [f64; 2] {
        let [right, down] = self.principal_offset.map(|offset| offset * 2.0 * half_height);
        [-right * self.pixel_aspect, down]
    }
}

/// The intrinsics of a perspective camera, in pixels of a picture. Pixel centres are at half numbers: the top left one is at
/// (0.5, 0.5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Focal lengths: `fl_x`, `fl_y`.
    pub focal: [f64; 2],
    /// The principal point: `cx`, `cy`.
    pub principal_point: [f64; 2],
}

impl Intrinsics {
    /// Those of a picture; `None` for an orthographic projection.
    pub(super) fn new(projection: Projection, plane: ImagePlane, [width, height]: [u32; 2]) -> Option<Self> {
        let Projection::Perspective { fov_degrees } = projection else {
            return None;
        };
        let [width, height] = [width, height].map(f64::from);
        let focal = 0.5 * height / libm::tan(0.5 * fov_degrees.to_radians());
        let [right, down] = plane.principal_offset;
        Some(Self {
            focal: [focal / plane.pixel_aspect, focal],
            principal_point: [0.5 * width + right * height, 0.5 * height + down * height],
        })
    }
}
