//! Cameras, and the order in which their pixels are traced.

use super::{
    CameraError, Distortion, ImagePlane, Intrinsics, Lens, PixelRays, Projection, Scene, View,
    distortion::Inverse,
    pixel_rays::{ThinLens, Undistortion},
};
use crate::math;
use glam::{DVec3, Vec3};

/// The most samples along a side of a picture: sample offsets are integers that must be exact in `f32`.
pub const MAX_SIDE_SAMPLES: u32 = 1 << 23;

/// A camera of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedCamera {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// The camera.
    pub camera: Camera,
}

/// A camera with a right-handed frame: `right = forward x up`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    view: View,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    half_height: f64,
    /// Distance in focus.
    focus: f64,
    plane: ImagePlane,
    distortion: Option<Inverse>,
}

impl Camera {
    /// Makes a perspective camera at `eye` that looks at `target`; `fov_degrees` is the vertical field of view.
    ///
    /// # Errors
    /// [`CameraError`] if these do not define a view.
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, fov_degrees: f64) -> Result<Self, CameraError> {
        Self::new(&View {
            eye,
            target,
            up,
            projection: Projection::Perspective { fov_degrees },
            lens: Lens::PINHOLE,
        })
    }

    /// Makes the camera of a view.
    ///
    /// # Errors
    /// [`CameraError`] if it does not define a picture.
    pub fn new(view: &View) -> Result<Self, CameraError> {
        let &View { eye, target, up, .. } = view;
        if !(eye.is_finite() && target.is_finite() && up.is_finite()) {
            return Err(CameraError::NotFinite);
        }
        let moderate_up = math::moderate(up);
        let half_height = view.projection.half_height()?;
        let forward = (target - eye).try_normalize().ok_or(CameraError::EyeOnTarget)?;
        let up = moderate_up.try_normalize().ok_or(CameraError::UpParallel)?;
        let right = forward.cross(up);
        if right.length() < 1e-9 {
            return Err(CameraError::UpParallel);
        }
        let right = right.normalize();
        let focus = view.lens.check(eye.distance(target))?;
        Ok(Self {
            view: View {
                up: moderate_up,
                ..*view
            },
            forward,
            right,
            up: right.cross(forward),
            half_height,
            focus,
            plane: ImagePlane::CENTERED,
            distortion: None,
        })
    }

    /// Returns the camera with another image plane. The field of view becomes that of a picture of the same height around the
    /// optical axis.
    ///
    /// # Errors
    /// [`CameraError::PrincipalOffset`] or [`CameraError::PixelAspect`] if a number is out of range.
    pub fn with_image_plane(self, plane: ImagePlane) -> Result<Self, CameraError> {
        plane.check()?;
        Ok(Self { plane, ..self })
    }

    /// Returns how the picture lies in the image plane.
    #[must_use]
    pub fn image_plane(&self) -> ImagePlane {
        self.plane
    }

    /// Returns the camera with a distortion, or without one. Pixels that see nothing, because the distortion has no inverse
    /// there, show the background as it is along the view.
    ///
    /// # Errors
    /// [`CameraError::Distortion`] if a coefficient is out of range; [`CameraError::DistortedProjection`] if the camera is
    /// orthographic or has an aperture.
    pub fn with_distortion(self, distortion: Option<Distortion>) -> Result<Self, CameraError> {
        let is_perspective = matches!(self.view.projection, Projection::Perspective { .. });
        if distortion.is_some() && (!is_perspective || self.has_lens()) {
            return Err(CameraError::DistortedProjection);
        }
        let distortion = distortion.map(Inverse::new).transpose()?;
        Ok(Self { distortion, ..self })
    }

    /// Returns the distortion, if there is one.
    #[must_use]
    pub fn distortion(&self) -> Option<Distortion> {
        self.distortion.map(|inverse| inverse.distortion)
    }

    /// Returns the unit direction in which the camera sees a point of a picture of `width` x `height` pixels, in the
    /// camera's space: right, down and forward. [`PixelRays`] have it in world space, in `f32`. `None` for an orthographic
    /// camera, and where the distortion has no inverse.
    #[must_use]
    pub fn sight(&self, point: [f64; 2], [width, height]: [u32; 2]) -> Option<DVec3> {
        let Intrinsics {
            focal,
            principal_point,
        } = self.intrinsics(width, height)?;
        let [x, y] = [0, 1].map(|axis| (point[axis] - principal_point[axis]) / focal[axis]);
        match &self.distortion {
            None => DVec3::new(x, y, 1.0).try_normalize(),
            Some(inverse) => inverse.directions(&[[x], [y]])[0].try_normalize(),
        }
    }

    /// Returns the focal lengths and the principal point in a picture of `width` x `height` pixels; `None` for an orthographic
    /// camera.
    #[must_use]
    pub fn intrinsics(&self, width: u32, height: u32) -> Option<Intrinsics> {
        Intrinsics::new(self.view.projection, self.plane, [width, height])
    }

    /// Returns the camera with a pinhole instead of its lens.
    #[must_use]
    pub fn without_lens(&self) -> Self {
        let mut camera = *self;
        camera.view.lens = Lens::PINHOLE;
        camera
    }

    /// Returns whether the camera has a lens, so that each sample starts at another point of it.
    #[must_use]
    pub fn has_lens(&self) -> bool {
        self.view.lens.aperture > 0.0
    }

    /// Returns the parameters of the camera, without its [`ImagePlane`]. An extremely long or short up vector is scaled.
    #[must_use]
    pub fn view(&self) -> View {
        self.view
    }

    /// Returns the camera of the classic viewpoint 1 to 6; `None` for another number.
    #[must_use]
    pub fn classic_view(view: u32) -> Option<Self> {
        Self::new(&View::classic(view)?).ok()
    }

    /// Returns the position of the eye, scene units.
    #[must_use]
    pub fn eye(&self) -> Vec3 {
        self.view.eye.as_vec3()
    }

    /// Returns the unit direction in which the camera looks.
    #[must_use]
    pub fn forward(&self) -> Vec3 {
        self.forward.as_vec3()
    }

    /// Returns the rays of a picture of `scene`: `width` x `height` pixels of `samples_per_axis`² samples each.
    ///
    /// # Panics
    /// If a side has no pixel or sample, or more than [`MAX_SIDE_SAMPLES`] samples.
    #[doc(hidden)]
    #[must_use]
    pub fn pixel_rays(&self, scene: &Scene, width: u32, height: u32, samples_per_axis: u32) -> PixelRays {
        self.pixel_rays_by(|point| scene.relative(point), [width, height], samples_per_axis)
    }

    /// As [`Self::pixel_rays`]; `relative` moves a point of world space to where rays are traced.
    pub(crate) fn pixel_rays_by(
        &self,
        relative: impl Fn(DVec3) -> Vec3,
        [width, height]: [u32; 2],
        samples_per_axis: u32,
    ) -> PixelRays {
        let n = samples_per_axis;
        let along = |pixels: u32| {
            let samples = pixels.saturating_mul(n);
            assert!(
                (1..=MAX_SIDE_SAMPLES).contains(&samples),
                "{pixels} pixels of {n} samples along a side, expected at most {MAX_SIDE_SAMPLES} samples"
            );
            samples as i32
        };
        // Half a sample's width: sample centres are odd multiples of it.
        let step = (self.half_height / (f64::from(height) * f64::from(n))) as f32;
        let is_parallel = matches!(self.view.projection, Projection::Orthographic { .. });
        let (mut eye, mut forward, mut right) = (self.view.eye, self.forward, self.right);
        let mut shift = [0.0; 2];
        // Adding 0 would change the sign of -0.
        if self.plane != ImagePlane::CENTERED {
            shift = self.plane.shift(self.half_height);
            let center = if is_parallel { &mut eye } else { &mut forward };
            *center += self.right * shift[0] + self.up * shift[1];
            right *= self.plane.pixel_aspect;
        }
        let stretch = self.plane.pixel_aspect as f32;
        PixelRays {
            eye: relative(eye),
            forward: forward.as_vec3(),
            right: right.as_vec3(),
            up: self.up.as_vec3(),
            step,
            shift: shift.map(|shift| shift as f32),
            stretch,
            undistortion: self.distortion.map(|inverse| Undistortion {
                inverse,
                forward: self.forward.as_vec3(),
                right: self.right.as_vec3(),
            }),
            is_parallel,
            lens: self.has_lens().then(|| {
                let radius = (0.5 * self.view.lens.aperture) as f32;
                let slope = (0.5 * self.view.lens.aperture / self.focus) as f32;
                // The lens is a circle, although `right` is stretched.
                ThinLens {
                    radius: [radius / stretch, radius],
                    slope: [slope / stretch, slope],
                }
            }),
            samples_per_axis: n as i32,
            width_samples: along(width),
            height_samples: along(height),
        }
    }
}

/// Side of a block, pixels: a block is a bundle, or half of the largest one.
const BLOCK: u32 = 16;

/// Calls `visit` with the top left pixel of each packet of 4x2 pixels of a picture or a part of it.
///
/// Neighbours in this order are neighbours in the picture: blocks of 16x16 pixels row by row, within a block a Z-order
/// curve (2 packets are 4x4 pixels, 8 packets 8x8). Packets may reach beyond the right and lower edge.
#[inline(always)]
pub fn for_each_packet(width: u32, height: u32, mut visit: impl FnMut([u32; 2])) {
    for block_y in (0..height).step_by(BLOCK as usize) {
        for block_x in (0..width).step_by(BLOCK as usize) {
            for i in 0..32 {
                let x = block_x + ((i >> 1 & 1) + (i >> 3 & 1) * 2) * 4;
                let y = block_y + ((i & 1) + (i >> 2 & 1) * 2 + (i >> 4) * 4) * 2;
                if x < width && y < height {
                    visit([x, y]);
                }
            }
        }
    }
}
