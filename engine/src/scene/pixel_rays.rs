//! The rays of a camera: from a pinhole, parallel ones, or from a thin lens (Cook, Porter and Carpenter, *Distributed Ray
//! Tracing*, 1984).
//!
//! ```text
//!   perspective                        orthographic
//!   lens   plane in focus              lens          plane in focus
//!    a --__     |                       o+a --__       |
//!   eye ----->  o  through the point o  o  --------->  o
//! ```
//! With slopes relative to the view direction, a ray from the point `a` of the lens has the slope of the ray through its
//! centre minus `a / focus`.

use super::distortion::Inverse;
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::{Ray, RayPacket},
    simd::{Level, Portable, Simd, at_level},
};
use glam::{DVec3, Vec3};

/// The width of a camera ray's sample along its path, scene units: a cone from a pinhole, or a cylinder.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayCone {
    /// Width where the ray starts.
    pub start: f32,
    /// Additional width per unit of distance.
    pub spread: f32,
}

impl RayCone {
    /// Returns the width at a distance.
    #[inline(always)]
    #[must_use]
    pub fn width(self, distance: f32) -> f32 {
        self.start + distance * self.spread
    }

    /// Returns the cone of one of `count` samples of a pixel.
    #[must_use]
    pub(crate) fn shared_by(self, count: f32) -> Self {
        let divisor = count.sqrt();
        Self {
            start: self.start / divisor,
            spread: self.spread / divisor,
        }
    }
}

/// A lens in the units of [`PixelRays`].
#[derive(Clone, Copy, Debug)]
pub(super) struct ThinLens {
    /// Scene units, along `right` and `up`.
    pub radius: [f32; 2],
    /// The radius over the distance in focus.
    pub slope: [f32; 2],
}

/// The distortion of a lens, and what it takes from the camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Undistortion {
    pub inverse: Inverse,
    /// The unit view direction.
    pub forward: Vec3,
    /// Unit vector.
    pub right: Vec3,
}

/// The end of a ray that hits nothing, but takes the background.
const BLIND: f32 = f32::MIN_POSITIVE;

/// Factors of points of the picture, in half samples, and of the lens, in radii.
struct Steps {
    /// Slope of the ray per unit of picture position.
    slope: f32,
    /// Origin of the ray per unit of picture position.
    place: f32,
    /// Slope and origin of the ray per unit of lens position, right and up.
    lens: [[f32; 2]; 2],
}

/// The camera rays of one picture size. A ray depends only on the absolute pixel, so a crop has the rays of the whole
/// picture.
#[derive(Clone, Copy, Debug)]
pub struct PixelRays {
    pub(super) eye: Vec3,
    /// To the picture's centre: the unit view direction, moved by `shift`.
    pub(super) forward: Vec3,
    /// Its length is `stretch`.
    pub(super) right: Vec3,
    pub(super) up: Vec3,
    /// Half a sample's height: at distance 1, or everywhere if rays are parallel.
    pub(super) step: f32,
    /// The picture's centre relative to the optical axis, right and up, in the units of `step`.
    pub(super) shift: [f32; 2],
    /// Width of a sample over its height.
    pub(super) stretch: f32,
    /// All rays have the same direction and separate origins.
    pub(super) is_parallel: bool,
    /// `None` for a pinhole.
    pub(super) lens: Option<ThinLens>,
    /// `None` without distortion; never with a lens or parallel rays.
    pub(super) undistortion: Option<Undistortion>,
    pub(super) samples_per_axis: i32,
    pub(super) width_samples: i32,
    pub(super) height_samples: i32,
}

impl PixelRays {
    /// Returns the position of the eye, scene units relative to [`Scene::origin`](super::Scene::origin).
    #[must_use]
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// Returns the shared origin, scene units relative to [`Scene::origin`](super::Scene::origin); `None` for separate ones.
    #[must_use]
    pub fn shared_origin(&self) -> Option<Vec3> {
        (!self.is_parallel && self.lens.is_none()).then_some(self.eye)
    }

    /// Returns the number of samples along one side of a pixel.
    #[must_use]
    pub fn samples_per_axis(&self) -> u32 {
        self.samples_per_axis as u32
    }

    /// Returns the cone of a sample around the optical axis, as wide as a square of the sample's area.
    #[must_use]
    pub fn cone(&self) -> RayCone {
        let width = 2.0 * self.step * self.stretch.sqrt();
        if self.is_parallel {
            RayCone {
                start: width,
                spread: 0.0,
            }
        } else {
            RayCone {
                start: 0.0,
                spread: width,
            }
        }
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

    /// Returns the ray through sample `sample` (column, row) of pixel (`x`, `y`); row 0 is the top. It passes through the
    /// centre of the lens. Where a distortion has no inverse, it has the view direction and ends before it hits anything.
    #[must_use]
    pub fn ray(&self, x: u32, y: u32, sample: [u32; 2]) -> Ray {
        self.ray_at(Portable, [x, y], sample, [0.0; 2], [0.0; 2])
    }

    /// Returns the ray through the point that is `offset` half pixels right and up from the pixel's centre, for one sample
    /// per pixel; or, for an offset of 0, through the sample. It starts at the point `lens` of a lens of radius 1.
    #[inline(always)]
    pub(crate) fn ray_at<S: Simd>(
        &self,
        simd: S,
        [x, y]: [u32; 2],
        sample: [u32; 2],
        [right, up]: [f32; 2],
        lens: [f32; 2],
    ) -> Ray {
        let (center_right, center_up) = self.offsets(x, y, sample);
        let (right, up) = (center_right + right, center_up + up);
        if let Some(origin) = self.shared_origin() {
            let direction = self.toward(simd, (right, up));
            return match &self.undistortion {
                Some(undistortion) if direction == Vec3::ZERO => Ray {
                    t_max: BLIND,
                    ..Ray::new(origin, undistortion.forward)
                },
                _ => Ray::new(origin, direction),
            };
        }
        let Steps {
            slope,
            place,
            lens: [lens_slope, radius],
        } = self.steps();
        let along = |from: Vec3, [right, up]: [f32; 2]| {
            simd.mul_add3(self.up, up, simd.mul_add3(self.right, right, from))
        };
        let [a, b] = lens;
        let origin = [right * place + a * radius[0], up * place + b * radius[1]];
        let slopes = [right * slope - a * lens_slope[0], up * slope - b * lens_slope[1]];
        Ray::new(
            along(self.eye, origin),
            simd.normalize(along(self.forward, slopes)),
        )
    }

    /// Returns the factors for rays with separate origins.
    #[inline(always)]
    fn steps(&self) -> Steps {
        let lens = self.lens.map_or([[0.0; 2]; 2], |lens| [lens.slope, lens.radius]);
        let (slope, place) = if self.is_parallel {
            (0.0, self.step)
        } else {
            (self.step, 0.0)
        };
        Steps { slope, place, lens }
    }

    /// Returns the unit direction of [`Self::ray`] from a pinhole; 0 where a distortion has no inverse.
    #[must_use]
    pub fn direction(&self, x: u32, y: u32, sample: [u32; 2]) -> Vec3 {
        self.toward(Portable, self.offsets(x, y, sample))
    }

    /// Returns the unit direction from a pinhole through the point with these offsets, like [`Self::toward8`].
    #[inline(always)]
    fn toward<S: Simd>(&self, simd: S, (right, up): (f32, f32)) -> Vec3 {
        if let Some(undistortion) = &self.undistortion {
            let [direction] = self.curved(undistortion, &[right], &[up]);
            return direction;
        }
        let along_right = simd.mul_add3(self.right, right * self.step, self.forward);
        simd.normalize(simd.mul_add3(self.up, up * self.step, along_right))
    }

    /// Returns what [`PixelRays::direction`] returns for the 4x2 pixels from (`x`, `y`); lane `4 * row + column`.
    #[must_use]
    pub fn directions8(&self, x: u32, y: u32, sample: [u32; 2]) -> Vec3x8 {
        if self.is_distorted() {
            let pixel = |lane: usize| [x + (lane % 4) as u32, y + (lane / 4) as u32];
            let direction = |lane| {
                let [x, y] = pixel(lane);
                self.direction(x, y, sample)
            };
            return Vec3x8::from_lanes(std::array::from_fn(direction));
        }
        at_level!(Level::current(), |simd| self.directions(
            simd,
            [x, y],
            sample,
            &[F32x8::ZERO; 2]
        ))
    }

    /// Returns the directions of [`PixelRays::ray_at`] for pixels as in [`PixelRays::directions8`], from a pinhole without
    /// distortion.
    #[inline(always)]
    pub(crate) fn directions<S: Simd>(
        &self,
        simd: S,
        pixel: [u32; 2],
        sample: [u32; 2],
        offset: &[F32x8; 2],
    ) -> Vec3x8 {
        self.toward8(simd, self.points(simd, pixel, sample, offset))
    }

    /// Returns the origins and directions of [`PixelRays::ray_at`] for pixels as in [`PixelRays::directions8`].
    #[inline(always)]
    pub(crate) fn rays<S: Simd>(
        &self,
        simd: S,
        pixel: [u32; 2],
        sample: [u32; 2],
        offset: &[F32x8; 2],
        lens: [S::V8; 2],
    ) -> (Vec3x8, Vec3x8) {
        self.leaving8(simd, self.points(simd, pixel, sample, offset), lens)
    }

    /// [`Self::directions`] for eight pixels anywhere. Only for one sample per pixel.
    #[inline(always)]
    pub(crate) fn directions_of<S: Simd>(
        &self,
        simd: S,
        pixels: &[[u32; 2]; LANES],
        offset: &[F32x8; 2],
    ) -> Vec3x8 {
        self.toward8(simd, self.points_of(simd, pixels, offset))
    }

    /// [`Self::rays`] for eight pixels anywhere. Only for one sample per pixel.
    #[inline(always)]
    pub(crate) fn rays_of<S: Simd>(
        &self,
        simd: S,
        pixels: &[[u32; 2]; LANES],
        offset: &[F32x8; 2],
        lens: [S::V8; 2],
    ) -> (Vec3x8, Vec3x8) {
        self.leaving8(simd, self.points_of(simd, pixels, offset), lens)
    }

    /// Returns the offsets from the picture's centre of points of 4x2 pixels, right and up, in half samples.
    #[inline(always)]
    fn points<S: Simd>(
        &self,
        simd: S,
        [x, y]: [u32; 2],
        sample: [u32; 2],
        [offset_right, offset_up]: &[F32x8; 2],
    ) -> [S::V8; 2] {
        const COLUMN: F32x8 = F32x8::new([0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0]);
        const ROW: F32x8 = F32x8::new([0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
        let (right, up) = self.offsets(x, y, sample);
        let pitch = (2 * self.samples_per_axis) as f32;
        let right = simd.splat(right) + simd.load(&COLUMN) * pitch + simd.load(offset_right);
        let up = simd.splat(up) - simd.load(&ROW) * pitch + simd.load(offset_up);
        [right, up]
    }

    /// [`Self::points`] for pixels anywhere.
    #[inline(always)]
    fn points_of<S: Simd>(
        &self,
        simd: S,
        pixels: &[[u32; 2]; LANES],
        [offset_right, offset_up]: &[F32x8; 2],
    ) -> [S::V8; 2] {
        let (mut right, mut up) = ([0.0; LANES], [0.0; LANES]);
        for (lane, &[x, y]) in pixels.iter().enumerate() {
            (right[lane], up[lane]) = self.offsets(x, y, [0, 0]);
        }
        let right = simd.load(&F32x8::new(right)) + simd.load(offset_right);
        let up = simd.load(&F32x8::new(up)) + simd.load(offset_up);
        [right, up]
    }

    /// [`Self::toward`] for eight points, without distortion.
    #[inline(always)]
    fn toward8<S: Simd>(&self, simd: S, [right, up]: [S::V8; 2]) -> Vec3x8 {
        let forward = simd.splat3(self.forward);
        let along_right = simd.splat3(self.right).mul_add(right * self.step, forward);
        simd.splat3(self.up)
            .mul_add(up * self.step, along_right)
            .normalize()
            .to8()
    }

    /// [`Self::toward`] for points of a distorted picture, each by the same operations. Numbers are those of a pinhole,
    /// rounded to `f32`: so a camera that is saved and read again has the same rays.
    #[inline(always)]
    fn curved<const N: usize>(
        &self,
        undistortion: &Undistortion,
        right: &[f32; N],
        up: &[f32; N],
    ) -> [Vec3; N] {
        let (step, stretch) = (f64::from(self.step), f64::from(self.stretch));
        let [shift_right, shift_up] = self.shift.map(f64::from);
        let points = [
            right.map(|right| shift_right + f64::from(right) * step * stretch),
            up.map(|up| -(shift_up + f64::from(up) * step)),
        ];
        let axes = [undistortion.right, -self.up, undistortion.forward].map(Vec3::as_dvec3);
        undistortion.inverse.directions(&points).map(|DVec3 { x, y, z }| {
            let direction = axes[0] * x + axes[1] * y + axes[2] * z;
            let length = direction.length();
            if length > 0.0 {
                (direction / length).as_vec3()
            } else {
                Vec3::ZERO
            }
        })
    }

    /// Returns whether the lens has distortion.
    #[inline]
    pub(crate) fn is_distorted(&self) -> bool {
        self.undistortion.is_some()
    }

    /// Returns the rays of [`Self::ray_at`] for eight pixels anywhere, which end at `t_max`. For a camera with distortion.
    pub(crate) fn distorted(
        &self,
        pixels: &[[u32; 2]; LANES],
        sample: [u32; 2],
        [offset_right, offset_up]: &[F32x8; 2],
        mut t_max: F32x8,
    ) -> RayPacket {
        let (mut right, mut up) = (*offset_right, *offset_up);
        for (lane, &[x, y]) in pixels.iter().enumerate() {
            let (center_right, center_up) = self.offsets(x, y, sample);
            right.as_mut_array()[lane] += center_right;
            up.as_mut_array()[lane] += center_up;
        }
        let Some(undistortion) = &self.undistortion else {
            let direction = self.toward8(Portable, [Portable.load(&right), Portable.load(&up)]);
            return RayPacket { direction, t_max };
        };
        let mut directions = self.curved(undistortion, right.as_array(), up.as_array());
        for (direction, t_max) in directions.iter_mut().zip(t_max.as_mut_array()) {
            if *direction == Vec3::ZERO {
                (*direction, *t_max) = (undistortion.forward, t_max.min(BLIND));
            }
        }
        RayPacket {
            direction: Vec3x8::from_lanes(directions),
            t_max,
        }
    }

    /// [`Self::ray_at`] for eight points of the picture and of the lens; for separate origins.
    #[inline(always)]
    fn leaving8<S: Simd>(&self, simd: S, [right, up]: [S::V8; 2], [a, b]: [S::V8; 2]) -> (Vec3x8, Vec3x8) {
        let Steps {
            slope,
            place,
            lens: [lens_slope, radius],
        } = self.steps();
        let (right_axis, up_axis) = (simd.splat3(self.right), simd.splat3(self.up));
        let origin = right_axis.mul_add(right * place + a * radius[0], simd.splat3(self.eye));
        let origin = up_axis.mul_add(up * place + b * radius[1], origin);
        let direction = right_axis.mul_add(right * slope - a * lens_slope[0], simd.splat3(self.forward));
        let direction = up_axis.mul_add(up * slope - b * lens_slope[1], direction);
        (origin.to8(), direction.normalize().to8())
    }

    /// Returns four unit vectors whose convex cone contains all rays through `width` x `height` pixels.
    ///
    /// They lie two pixels outside, because filters reach beyond a pixel, plus a margin for rounding. NaN where the rays
    /// are so oblique that rounding might exceed the margin, and with a distortion. Only for a shared origin.
    #[must_use]
    pub fn corners(&self, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> [Vec3; 4] {
        if self.undistortion.is_some() {
            return [Vec3::NAN; 4];
        }
        let pixel = (2 * self.samples_per_axis) as f32 * self.step;
        let [shift_right, shift_up] = self.shift;
        // Rounding is relative to the vector to the picture's centre, too.
        let shift_squared = shift_right * shift_right + shift_up * shift_up;
        [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(rightwards, upwards)| {
            let (right, up) = self.offsets(
                if rightwards > 0.0 { x + width } else { x },
                if upwards < 0.0 { y + height } else { y },
                [0, 0],
            );
            let (right, up) = (right * self.step, up * self.step);
            // Slopes of the corner. The sums are exact without a shift.
            let (x, y) = (shift_right + right * self.stretch, shift_up + up);
            if x.abs().max(y.abs()).max(shift_right.abs()).max(shift_up.abs()) > MAX_CORNER_SLOPE {
                return Vec3::NAN;
            }
            let rounding = CORNER_MARGIN * (1.0 + x * x + y * y + shift_squared);
            let (margin, margin_right) = (2.0 * pixel + rounding, 2.0 * pixel + rounding / self.stretch);
            let along_right = Portable.mul_add3(self.right, right + rightwards * margin_right, self.forward);
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

#[cfg(test)]
mod tests;
