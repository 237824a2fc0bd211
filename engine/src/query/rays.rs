//! Rays, points and hits as callers have them: world space, directions of any length, `f32` or `f64`.

use super::QueryError;
use crate::{
    lanes::{F32x8, LANES},
    simd::{EightLanes, Simd},
};
use glam::{DVec3, Vec3};

/// A ray in world space: the points `origin + t * direction` for `t_min < t < t_max`.
///
/// A ray with a NaN or infinite origin or direction, without a direction, or with a NaN end hits nothing.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Ray {
    /// The point at t = 0.
    pub origin: Vec3,
    /// A vector of any length but 0; t counts its length.
    pub direction: Vec3,
    /// Where the ray begins. Values below 0 count as 0.
    pub t_min: f32,
    /// Where it ends; may be infinite.
    pub t_max: f32,
}

impl Ray {
    /// Makes a ray from `origin` without end.
    #[must_use]
    pub fn new(origin: impl Into<Vec3>, direction: impl Into<Vec3>) -> Self {
        Self {
            origin: origin.into(),
            direction: direction.into(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        }
    }

    /// Makes a ray between two points, both excluded; t is 1 at `to`.
    #[must_use]
    pub fn between(from: impl Into<Vec3>, to: impl Into<Vec3>) -> Self {
        let from = from.into();
        Self {
            t_max: 1.0,
            ..Self::new(from, to.into() - from)
        }
    }
}

/// Points or vectors, x, y and z each, in either precision.
#[derive(Clone, Copy, Debug)]
pub enum Points<'a> {
    /// In single precision.
    F32(&'a [[f32; 3]]),
    /// In double precision.
    F64(&'a [[f64; 3]]),
}

impl Points<'_> {
    /// Returns how many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::F32(points) => points.len(),
            Self::F64(points) => points.len(),
        }
    }

    /// Returns whether it is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns point `i`.
    ///
    /// # Panics
    /// If there is no such point.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, i: usize) -> DVec3 {
        match self {
            Self::F32(points) => Vec3::from_array(points[i]).as_dvec3(),
            Self::F64(points) => DVec3::from_array(points[i]),
        }
    }

    /// Eight of them from `i` on as a structure of arrays, the last one repeated.
    #[inline(always)]
    fn eight(&self, i: usize, columns: &mut [[f64; LANES]; 3]) {
        match self {
            Self::F32(points) => eight_of(points, i, columns),
            Self::F64(points) => eight_of(points, i, columns),
        }
    }
}

#[inline(always)]
fn eight_of<T: Copy + Into<f64>>(points: &[[T; 3]], i: usize, columns: &mut [[f64; LANES]; 3]) {
    if let Some((eight, _)) = points[i..].split_first_chunk::<LANES>() {
        for lane in 0..LANES {
            for axis in 0..3 {
                columns[axis][lane] = eight[lane][axis].into();
            }
        }
        return;
    }
    for lane in 0..LANES {
        let point = points[(i + lane).min(points.len() - 1)];
        for axis in 0..3 {
            columns[axis][lane] = point[axis].into();
        }
    }
}

macro_rules! points {
    ($($number:ty, $kind:ident, $vector:ty;)*) => {$(
        impl<'a> From<&'a [[$number; 3]]> for Points<'a> {
            fn from(points: &'a [[$number; 3]]) -> Self {
                Self::$kind(points)
            }
        }
        impl<'a> From<&'a Vec<[$number; 3]>> for Points<'a> {
            fn from(points: &'a Vec<[$number; 3]>) -> Self {
                Self::$kind(points)
            }
        }
        impl<'a, const N: usize> From<&'a [[$number; 3]; N]> for Points<'a> {
            fn from(points: &'a [[$number; 3]; N]) -> Self {
                Self::$kind(points)
            }
        }
        impl<'a> From<&'a [$vector]> for Points<'a> {
            fn from(points: &'a [$vector]) -> Self {
                Self::$kind(bytemuck::must_cast_slice(points))
            }
        }
        impl<'a> From<&'a Vec<$vector>> for Points<'a> {
            fn from(points: &'a Vec<$vector>) -> Self {
                points.as_slice().into()
            }
        }
        impl<'a, const N: usize> From<&'a [$vector; N]> for Points<'a> {
            fn from(points: &'a [$vector; N]) -> Self {
                points.as_slice().into()
            }
        }
    )*};
}
points! { f32, F32, Vec3; f64, F64, DVec3; }

/// One end for all rays, or one each.
#[derive(Clone, Copy, Debug)]
pub enum Ends<'a> {
    /// The same for all.
    All(f32),
    /// One for each ray.
    Each(&'a [f32]),
}

impl Ends<'_> {
    #[inline(always)]
    fn eight(&self, i: usize) -> [f32; LANES] {
        match self {
            Self::All(end) => [*end; LANES],
            Self::Each(ends) => {
                let mut eight = [0.0; LANES];
                for (lane, end) in eight.iter_mut().enumerate() {
                    *end = ends[(i + lane).min(ends.len() - 1)];
                }
                eight
            }
        }
    }
}

impl From<f32> for Ends<'_> {
    fn from(end: f32) -> Self {
        Self::All(end)
    }
}

impl<'a> From<&'a [f32]> for Ends<'a> {
    fn from(ends: &'a [f32]) -> Self {
        Self::Each(ends)
    }
}

impl<'a> From<&'a Vec<f32>> for Ends<'a> {
    fn from(ends: &'a Vec<f32>) -> Self {
        Self::Each(ends)
    }
}

impl<'a, const N: usize> From<&'a [f32; N]> for Ends<'a> {
    fn from(ends: &'a [f32; N]) -> Self {
        Self::Each(ends)
    }
}

/// Many rays: a slice of [`Ray`]s, or arrays of origins and directions. Neighbours should be neighbours in space, as
/// the pixels of a picture are: those are traced together.
#[derive(Clone, Copy, Debug)]
pub struct Rays<'a> {
    source: Source<'a>,
    /// The first of these rays.
    start: usize,
    len: usize,
}

#[derive(Clone, Copy, Debug)]
enum Source<'a> {
    Each(&'a [Ray]),
    Arrays {
        origins: Points<'a>,
        directions: Points<'a>,
        t_min: Ends<'a>,
        t_max: Ends<'a>,
    },
}

/// Eight rays as columns.
#[derive(Clone, Copy, Debug)]
pub(super) struct EightRays {
    pub origin: [[f64; LANES]; 3],
    pub direction: [[f64; LANES]; 3],
    pub t_min: [f32; LANES],
    pub t_max: [f32; LANES],
}

impl EightRays {
    pub(super) const ZERO: Self = Self {
        origin: [[0.0; LANES]; 3],
        direction: [[0.0; LANES]; 3],
        t_min: [0.0; LANES],
        t_max: [0.0; LANES],
    };

    /// Origin and direction of one of them.
    pub(super) fn line(&self, lane: usize) -> [DVec3; 2] {
        [self.origin, self.direction].map(|[x, y, z]| DVec3::new(x[lane], y[lane], z[lane]))
    }
}

impl<'a> Rays<'a> {
    /// Makes rays from arrays, without ends. A single origin is shared by all.
    ///
    /// # Errors
    /// [`QueryError::Length`] if there is neither one origin nor one for each direction.
    pub fn from_arrays(
        origins: impl Into<Points<'a>>,
        directions: impl Into<Points<'a>>,
    ) -> Result<Self, QueryError> {
        let (origins, directions) = (origins.into(), directions.into());
        let len = directions.len();
        if origins.len() != len && origins.len() != 1 {
            return Err(QueryError::Length {
                what: "origins",
                found: origins.len(),
                expected: len,
            });
        }
        let source = Source::Arrays {
            origins,
            directions,
            t_min: Ends::All(0.0),
            t_max: Ends::All(f32::INFINITY),
        };
        Ok(Self {
            source,
            start: 0,
            len,
        })
    }

    /// The rays of a camera, which has as many origins as [`Self::from_arrays`] takes.
    pub(super) fn of_camera(origins: &'a [DVec3], directions: &'a [Vec3]) -> Self {
        Self {
            source: Source::Arrays {
                origins: origins.into(),
                directions: directions.into(),
                t_min: Ends::All(0.0),
                t_max: Ends::All(f32::INFINITY),
            },
            start: 0,
            len: directions.len(),
        }
    }

    /// Sets the ends of rays from arrays, in units of their directions' lengths; rays of a slice keep their own.
    ///
    /// # Errors
    /// [`QueryError::Length`] if ends and rays differ in number.
    pub fn within(
        mut self,
        t_min: impl Into<Ends<'a>>,
        t_max: impl Into<Ends<'a>>,
    ) -> Result<Self, QueryError> {
        let (from, to) = (t_min.into(), t_max.into());
        for (what, ends) in [("values of t_min", from), ("values of t_max", to)] {
            if let Ends::Each(ends) = ends
                && ends.len() != self.len
            {
                return Err(QueryError::Length {
                    what,
                    found: ends.len(),
                    expected: self.len,
                });
            }
        }
        if let Source::Arrays { t_min, t_max, .. } = &mut self.source {
            (*t_min, *t_max) = (from, to);
        }
        Ok(self)
    }

    /// Returns how many rays there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Returns whether it is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// A part of them.
    pub(super) fn part(self, range: std::ops::Range<usize>) -> Self {
        debug_assert!(range.end <= self.len);
        Self {
            source: self.source,
            start: self.start + range.start,
            len: range.len(),
        }
    }

    /// Whether all share their origin, which is faster to trace.
    pub(super) fn share_origin(&self) -> bool {
        let range = self.start..self.start + self.len;
        match self.source {
            _ if range.is_empty() => false,
            Source::Each(rays) => rays[range].windows(2).all(|two| two[0].origin == two[1].origin),
            Source::Arrays { origins, .. } => match origins {
                _ if origins.len() == 1 => true,
                Points::F32(points) => points[range].windows(2).all(|two| two[0] == two[1]),
                Points::F64(points) => points[range].windows(2).all(|two| two[0] == two[1]),
            },
        }
    }

    /// Writes eight rays from `i` on, repeating the last one at the end.
    #[inline(always)]
    pub(super) fn eight<S: Simd>(&self, simd: S, i: usize, to: &mut EightRays) {
        let i = self.start + i;
        match &self.source {
            Source::Each(rays) => {
                let last = self.start + self.len - 1;
                let mut rows = [simd.splat(0.0); LANES];
                for (lane, row) in rows.iter_mut().enumerate() {
                    let ray: [f32; LANES] = bytemuck::must_cast(rays[(i + lane).min(last)]);
                    *row = simd.load(&F32x8::new(ray));
                }
                let columns = S::V8::transposed(rows);
                for axis in 0..3 {
                    to.origin[axis] = doubled(columns[axis].to8());
                    to.direction[axis] = doubled(columns[axis + 3].to8());
                }
                to.t_min = columns[6].to8().to_array();
                to.t_max = columns[7].to8().to_array();
            }
            Source::Arrays {
                origins,
                directions,
                t_min,
                t_max,
            } => {
                origins.eight(if origins.len() == 1 { 0 } else { i }, &mut to.origin);
                directions.eight(i, &mut to.direction);
                to.t_min = t_min.eight(i);
                to.t_max = t_max.eight(i);
            }
        }
    }
}

#[inline(always)]
fn doubled(from: F32x8) -> [f64; LANES] {
    let mut to = [0.0; LANES];
    for (to, from) in to.iter_mut().zip(from.to_array()) {
        *to = f64::from(from);
    }
    to
}

impl<'a> From<&'a [Ray]> for Rays<'a> {
    fn from(rays: &'a [Ray]) -> Self {
        Self {
            source: Source::Each(rays),
            start: 0,
            len: rays.len(),
        }
    }
}

impl<'a> From<&'a Vec<Ray>> for Rays<'a> {
    fn from(rays: &'a Vec<Ray>) -> Self {
        rays.as_slice().into()
    }
}

impl<'a, const N: usize> From<&'a [Ray; N]> for Rays<'a> {
    fn from(rays: &'a [Ray; N]) -> Self {
        rays.as_slice().into()
    }
}
