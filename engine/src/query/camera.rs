//! The rays of a camera, for queries.

use super::{QueryError, Rays};
use crate::scene::{Camera, MAX_SIDE_SAMPLES};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// The rays through the centres of a picture's pixels, row by row from the top left, world space.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraRays {
    /// The eye, which all rays share; of an orthographic camera one origin for each ray.
    pub origins: Vec<DVec3>,
    /// Unit vectors, `width * height` of them. 0 where a distortion has no inverse: such a ray hits nothing.
    pub directions: Vec<Vec3>,
}

impl CameraRays {
    /// Returns the rays as queries take them.
    #[must_use]
    pub fn rays(&self) -> Rays<'_> {
        Rays::of_camera(&self.origins, &self.directions)
    }
}

impl Camera {
    /// Returns the ray through the centre of each pixel of a picture of `width` x `height` pixels. A lens counts as a pinhole.
    ///
    /// These are the rays of pictures with one sample per pixel, for scenes whose origin is 0. Queries make their directions
    /// unit vectors once more, which may change the last bit. [`Self::rays_around`] has those of geometry far from 0. They take
    /// 12 bytes per pixel, 36 if the camera is orthographic.
    ///
    /// ```
    /// # use octray_engine as octray;
    /// use octray::{Geometry, Hit, glam::DVec3, scene::Camera};
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let positions = [[0.0_f32, -1.0, -1.0], [0.0, 1.0, -1.0], [0.0, 0.0, 1.0]];
    /// let geometry = Geometry::from_triangles(&positions, &[[0, 1, 2]])?;
    /// let camera = Camera::look_at(DVec3::new(4.0, 0.0, 0.0), DVec3::ZERO, DVec3::Z, 40.0)?;
    /// let rays = camera.rays(64, 48)?;
    /// let mut hits = vec![Hit::default(); 64 * 48];
    /// geometry.closest_hits(rays.rays(), &mut hits);
    /// assert!(hits[24 * 64 + 32].is_hit() && !hits[0].is_hit());
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`QueryError::TooMany`] if a side has more than [`MAX_SIDE_SAMPLES`] pixels; [`QueryError::NoMemory`].
    pub fn rays(&self, width: u32, height: u32) -> Result<CameraRays, QueryError> {
        self.rays_around(DVec3::ZERO, width, height)
    }

    /// As [`Self::rays`], for geometry that is stored relative to `middle`, such as [`Geometry::middle`](super::Geometry::middle):
    /// the origins of an orthographic camera are rounded to `f32` relative to it.
    ///
    /// # Errors
    /// As [`Self::rays`].
    pub fn rays_around(&self, middle: DVec3, width: u32, height: u32) -> Result<CameraRays, QueryError> {
        self.rays_of_rows(middle, [width, height], 0..height)
    }

    /// As [`Self::rays_around`], for some rows of a picture of `width` x `height` pixels, so that a caller can stop between
    /// two parts of a large one. Rows below the picture are left out.
    ///
    /// # Errors
    /// As [`Self::rays`].
    pub fn rays_of_rows(
        &self,
        middle: DVec3,
        [width, height]: [u32; 2],
        rows: Range<u32>,
    ) -> Result<CameraRays, QueryError> {
        if width.max(height) > MAX_SIDE_SAMPLES {
            return Err(QueryError::TooMany {
                what: "pixels along a side",
                limit: MAX_SIDE_SAMPLES as usize,
            });
        }
        let eye = self.view().eye;
        let rows = rows.start..rows.end.min(height);
        if width == 0 || rows.is_empty() {
            return Ok(CameraRays {
                origins: vec![eye],
                directions: Vec::new(),
            });
        }
        let pinhole = self.without_lens();
        let pixels = pinhole.pixel_rays_by(|point| (point - middle).as_vec3(), [width, height], 1);
        let at = |i: usize| {
            let row = (i / width as usize) as u32;
            [(i % width as usize) as u32, rows.start + row]
        };
        let count = (width as usize).checked_mul(rows.len());
        let origins = match pixels.shared_origin() {
            Some(_) => vec![eye],
            None => filled(count, |i| {
                let [x, y] = at(i);
                middle + pixels.ray(x, y, [0; 2]).origin.as_dvec3()
            })?,
        };
        let directions = filled(count, |i| {
            let [x, y] = at(i);
            match pixels.shared_origin() {
                Some(_) => pixels.direction(x, y, [0; 2]),
                None => pixels.ray(x, y, [0; 2]).direction,
            }
        })?;
        Ok(CameraRays { origins, directions })
    }
}

/// An array of `count` items, or no memory.
fn filled<T: Send>(
    count: Option<usize>,
    item: impl Fn(usize) -> T + Sync + Send,
) -> Result<Vec<T>, QueryError> {
    let no_memory = QueryError::NoMemory {
        what: "the rays of the camera",
    };
    let Some(count) = count else {
        return Err(no_memory);
    };
    let mut items = Vec::new();
    items.try_reserve_exact(count).map_err(|_| no_memory)?;
    (0..count).into_par_iter().map(item).collect_into_vec(&mut items);
    Ok(items)
}
