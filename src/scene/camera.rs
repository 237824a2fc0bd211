//! The pinhole camera and its rays.

use super::Scene;
use crate::{
    classic,
    lanes::{F32x8, LANES, Vec3x8},
    simd::{Level, Portable, Simd, at_level},
};
use glam::{DVec3, Vec3};
use std::fmt;

/// The most samples along a side of a picture: sample offsets are integers that must be exact in `f32`.
pub const MAX_SIDE_SAMPLES: u32 = 1 << 23;

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
}

impl fmt::Display for CameraError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "the camera has a coordinate that is not finite"),
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
                "the field of view is {degrees} degrees, expected more than 0 and less than 180"
            ),
        }
    }
}

impl std::error::Error for CameraError {}

/// The parameters of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Position of the eye, scene units.
    pub eye: DVec3,
    /// The point to look at, scene units.
    pub target: DVec3,
    /// The up vector, of any length.
    pub up: DVec3,
    /// Vertical field of view, degrees.
    pub fov_degrees: f64,
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
            fov_degrees: Self::FOV_DEGREES,
        })
    }
}

/// A camera of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedCamera {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// The camera.
    pub camera: Camera,
}

/// A pinhole camera with a right-handed frame: `right = forward x up`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    view: View,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    half_height: f64,
}

impl Camera {
    /// Makes a camera at `eye` that looks at `target`; `fov_degrees` is the vertical field of view.
    ///
    /// # Errors
    /// [`CameraError`] if these do not define a view.
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, fov_degrees: f64) -> Result<Self, CameraError> {
        if !(eye.is_finite() && target.is_finite() && up.is_finite()) {
            return Err(CameraError::NotFinite);
        }
        if !(fov_degrees > 0.0 && fov_degrees < 180.0) {
            return Err(CameraError::FieldOfView(fov_degrees));
        }
        let forward = (target - eye).try_normalize().ok_or(CameraError::EyeOnTarget)?;
        let given_up = up;
        let up = up.try_normalize().ok_or(CameraError::UpParallel)?;
        let right = forward.cross(up);
        if right.length() < 1e-9 {
            return Err(CameraError::UpParallel);
        }
        let right = right.normalize();
        let half_height = libm::tan(fov_degrees.to_radians() * 0.5);
        Ok(Self {
            view: View {
                eye,
                target,
                up: given_up,
                fov_degrees,
            },
            forward,
            right,
            up: right.cross(forward),
            half_height,
        })
    }

    /// Makes the camera of a view.
    ///
    /// # Errors
    /// As [`Camera::look_at`].
    pub fn new(view: &View) -> Result<Self, CameraError> {
        Self::look_at(view.eye, view.target, view.up, view.fov_degrees)
    }

    /// Returns the parameters of the camera.
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

    /// Returns the rays of a picture of `scene`: `width` x `height` pixels of `samples_per_axis`² samples each.
    ///
    /// # Panics
    /// If a side has no pixel or sample, or more than [`MAX_SIDE_SAMPLES`] samples.
    #[must_use]
    pub fn pixel_rays(&self, scene: &Scene, width: u32, height: u32, samples_per_axis: u32) -> PixelRays {
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
        PixelRays {
            eye: (self.view.eye - scene.origin().as_dvec3()).as_vec3(),
            forward: self.forward.as_vec3(),
            right: self.right.as_vec3(),
            up: self.up.as_vec3(),
            step,
            samples_per_axis: n as i32,
            width_samples: along(width),
            height_samples: along(height),
        }
    }
}

/// The camera rays of one picture size. A direction depends on the absolute pixel alone, so a crop has the rays of the
/// whole picture.
#[derive(Clone, Copy, Debug)]
pub struct PixelRays {
    eye: Vec3,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    step: f32,
    samples_per_axis: i32,
    width_samples: i32,
    height_samples: i32,
}

impl PixelRays {
    /// Returns the shared origin of all rays, scene units relative to [`Scene::origin`].
    #[must_use]
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// Returns the number of samples along one side of a pixel.
    #[must_use]
    pub fn samples_per_axis(&self) -> u32 {
        self.samples_per_axis as u32
    }

    /// Returns the width of a sample's share of its pixel in the picture's middle at distance 1.
    #[must_use]
    pub fn pixel_width(&self) -> f32 {
        2.0 * self.step
    }

    /// Returns the offset of a sample from the picture's centre, right and up, in half samples: an integer, exact up to
    /// 2^24.
    #[inline(always)]
    fn offsets(&self, x: u32, y: u32, sample: [u32; 2]) -> (f32, f32) {
        let n = self.samples_per_axis;
        let right = 2 * (x as i32 * n + sample[0] as i32) + 1 - self.width_samples;
        let down = 2 * (y as i32 * n + sample[1] as i32) + 1 - self.height_samples;
        (right as f32, -down as f32)
    }

    /// Returns the unit direction through sample `sample` (column, row) of pixel (`x`, `y`); row 0 is the top.
    #[must_use]
    pub fn direction(&self, x: u32, y: u32, sample: [u32; 2]) -> Vec3 {
        self.direction_at(Portable, [x, y], sample)
    }

    /// Does [`Self::direction`] at a level.
    #[inline(always)]
    pub(crate) fn direction_at<S: Simd>(&self, simd: S, [x, y]: [u32; 2], sample: [u32; 2]) -> Vec3 {
        self.toward(simd, self.offsets(x, y, sample))
    }

    /// Returns the unit direction through the point that is `right` and `up` half pixels from the pixel's centre.
    /// Only for one sample per pixel.
    #[must_use]
    pub fn direction_offset(&self, x: u32, y: u32, offset: [f32; 2]) -> Vec3 {
        self.direction_offset_at(Portable, [x, y], offset)
    }

    /// Does [`Self::direction_offset`] at a level.
    #[inline(always)]
    pub(crate) fn direction_offset_at<S: Simd>(
        &self,
        simd: S,
        [x, y]: [u32; 2],
        [right, up]: [f32; 2],
    ) -> Vec3 {
        let (center_right, center_up) = self.offsets(x, y, [0, 0]);
        self.toward(simd, (center_right + right, center_up + up))
    }

    /// Returns the unit direction through the point with these offsets; twin of [`Self::directions`].
    #[inline(always)]
    fn toward<S: Simd>(&self, simd: S, (right, up): (f32, f32)) -> Vec3 {
        let along_right = simd.mul_add3(self.right, right * self.step, self.forward);
        simd.normalize(simd.mul_add3(self.up, up * self.step, along_right))
    }

    /// Returns what [`PixelRays::direction`] returns for the 4x2 pixels from (`x`, `y`); lane `4 * row + column`.
    #[must_use]
    pub fn directions8(&self, x: u32, y: u32, sample: [u32; 2]) -> Vec3x8 {
        at_level!(Level::current(), |simd| self.directions(
            simd,
            [x, y],
            sample,
            &[F32x8::ZERO; 2]
        ))
    }

    /// Returns what [`PixelRays::direction_offset`] returns for pixels as in [`PixelRays::directions8`], or for offset 0
    /// what [`PixelRays::direction`] returns.
    #[inline(always)]
    pub(crate) fn directions<S: Simd>(
        &self,
        simd: S,
        [x, y]: [u32; 2],
        sample: [u32; 2],
        offset: &[F32x8; 2],
    ) -> Vec3x8 {
        const COLUMN: F32x8 = F32x8::new([0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0]);
        const ROW: F32x8 = F32x8::new([0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
        let (right, up) = self.offsets(x, y, sample);
        let pitch = (2 * self.samples_per_axis) as f32;
        let [offset_right, offset_up] = offset;
        let right = simd.splat(right) + simd.load(&COLUMN) * pitch + simd.load(offset_right);
        let up = simd.splat(up) - simd.load(&ROW) * pitch + simd.load(offset_up);
        self.toward8(simd, right, up)
    }

    /// Returns what [`PixelRays::direction_offset`] returns for eight pixels anywhere. Only for one sample per pixel.
    #[inline(always)]
    pub(crate) fn directions_of<S: Simd>(
        &self,
        simd: S,
        pixels: &[[u32; 2]; LANES],
        offset: &[F32x8; 2],
    ) -> Vec3x8 {
        let (mut right, mut up) = ([0.0; LANES], [0.0; LANES]);
        for (lane, &[x, y]) in pixels.iter().enumerate() {
            (right[lane], up[lane]) = self.offsets(x, y, [0, 0]);
        }
        let [offset_right, offset_up] = offset;
        let right = simd.load(&F32x8::new(right)) + simd.load(offset_right);
        let up = simd.load(&F32x8::new(up)) + simd.load(offset_up);
        self.toward8(simd, right, up)
    }

    /// Does [`Self::toward`] for eight points.
    #[inline(always)]
    fn toward8<S: Simd>(&self, simd: S, right: S::V8, up: S::V8) -> Vec3x8 {
        let forward = simd.splat3(self.forward);
        let along_right = simd.splat3(self.right).mul_add(right * self.step, forward);
        simd.splat3(self.up)
            .mul_add(up * self.step, along_right)
            .normalize()
            .to8()
    }

    /// Returns four unit vectors whose convex cone contains all rays through `width` x `height` pixels.
    ///
    /// They lie two pixels outside, because filters reach beyond a pixel, plus a margin for rounding. NaN where the rays
    /// are so oblique that rounding might exceed the margin.
    #[must_use]
    pub fn corners(&self, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> [Vec3; 4] {
        let pixel = (2 * self.samples_per_axis) as f32 * self.step;
        [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(rightwards, upwards)| {
            let (right, up) = self.offsets(
                if rightwards > 0.0 { x + width } else { x },
                if upwards < 0.0 { y + height } else { y },
                [0, 0],
            );
            let (right, up) = (right * self.step, up * self.step);
            if right.abs().max(up.abs()) > MAX_CORNER_SLOPE {
                return Vec3::NAN;
            }
            let margin = 2.0 * pixel + CORNER_MARGIN * (1.0 + right * right + up * up);
            let along_right = Portable.mul_add3(self.right, right + rightwards * margin, self.forward);
            Portable.normalize(Portable.mul_add3(self.up, up + upwards * margin, along_right))
        })
    }
}

/// Margin of [corners](PixelRays::corners) for rounding, on the plane at distance 1, per squared distance from the eye:
/// 64 half-ulps, because a direction is rounded a dozen times.
const CORNER_MARGIN: f32 = 64.0 / (1 << 24) as f32;

/// Largest offset of [corners](PixelRays::corners) on the plane at distance 1. At 20 times this, the margin would be as
/// large as the offset.
const MAX_CORNER_SLOPE: f32 = 1e4;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneBuilder;

    /// Slopes of a direction: right and up per unit forward.
    fn slopes(rays: &PixelRays, direction: Vec3) -> [f64; 2] {
        let along = |axis: Vec3| direction.as_dvec3().dot(axis.as_dvec3());
        [along(rays.right), along(rays.up)].map(|slope| slope / along(rays.forward))
    }

    #[test]
    fn corners_are_around_all_rays() {
        let scene = SceneBuilder::new().finish();
        let mut random = fastrand::Rng::with_seed(3);
        let mut compared = 0;
        for (fov, [width, height], samples) in [
            (45.0, [1920, 1080], 1),
            (45.0, [33, 21], 5),
            (1e-5, [640, 480], 1),
            (179.9, [1000, 700], 2),
            (60.0, [1 << 23, 3], 1),
            (1e-3, [3, 1 << 21], 4),
        ] {
            let [eye, target] = [DVec3::new(3.0, -2.0, 1.0), DVec3::new(0.1, 0.2, 0.3)];
            let camera = Camera::look_at(eye, target, DVec3::Z, fov).unwrap();
            let rays = camera.pixel_rays(&scene, width, height, samples);
            for _ in 0..500 {
                let first = [random.u32(0..width), random.u32(0..height)];
                let size = [
                    random.u32(1..=128.min(width - first[0])),
                    random.u32(1..=16.min(height - first[1])),
                ];
                let corners = rays.corners(first, size);
                if !corners.iter().all(|corner| corner.is_finite()) {
                    continue;
                }
                let corners = corners.map(|corner| slopes(&rays, corner));
                compared += 1;
                for _ in 0..20 {
                    let [x, y] = [0, 1].map(|axis| first[axis] + random.u32(0..size[axis]));
                    let sample = [(); 2].map(|()| random.u32(0..samples));
                    let direction = if samples == 1 {
                        // The reach of the widest filter.
                        rays.direction_offset(x, y, [(); 2].map(|()| 6.0 * random.f32() - 3.0))
                    } else {
                        rays.direction(x, y, sample)
                    };
                    for (axis, slope) in slopes(&rays, direction).into_iter().enumerate() {
                        let of_corners = corners.iter().map(|corner| corner[axis]);
                        let least = of_corners.clone().fold(f64::INFINITY, f64::min);
                        let largest = of_corners.fold(f64::NEG_INFINITY, f64::max);
                        assert!(
                            least < slope && slope < largest,
                            "{fov}, {first:?}: {slope} of {least} to {largest}"
                        );
                    }
                }
            }
        }
        assert!(compared > 2000, "{compared}");
    }
}
