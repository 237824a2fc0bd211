//! Rays and hits, single and eight-wide; which of two hits counts.

use crate::simd::{F32x8, LANES, Vec3x8, splat};
use glam::Vec3;

/// Which primitive: triangles count from 0, spheres go on where the triangles end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PrimitiveId(pub u32);

impl PrimitiveId {
    /// No primitive: the ray hit nothing.
    pub const NONE: Self = Self(u32::MAX);
}

/// The t of a ray that ends nowhere. Finite, so that products with 0 are not NaN.
pub const T_MAX: f32 = f32::MAX;

/// A half-line or, with a finite `t_max`, a segment: t in (0, t_max), both ends excluded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where t is 0, scene units.
    pub origin: Vec3,
    /// Unit length, so that t is a distance in scene units.
    pub direction: Vec3,
    /// Hits count only below this t.
    pub t_max: f32,
}

impl Ray {
    /// A ray without end.
    #[must_use]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self {
            origin,
            direction,
            t_max: T_MAX,
        }
    }
}

/// What a ray hit first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, scene units; [`T_MAX`] (or the ray's `t_max`) for a miss.
    pub t: f32,
    /// Barycentric weight of a triangle's second corner; 0 on spheres.
    pub u: f32,
    /// Barycentric weight of a triangle's third corner; 0 on spheres.
    pub v: f32,
    /// What was hit; [`PrimitiveId::NONE`] for a miss.
    pub primitive: PrimitiveId,
}

impl Hit {
    /// No hit before `t_max`.
    #[inline(always)]
    #[must_use]
    pub fn miss(t_max: f32) -> Self {
        Self {
            t: t_max,
            u: 0.0,
            v: 0.0,
            primitive: PrimitiveId::NONE,
        }
    }

    /// Whether a candidate at `t` on `primitive` replaces this hit: nearer, or equally near with the lower
    /// id. A miss holds the ray's `t_max`, which itself is excluded.
    #[inline(always)]
    #[must_use]
    pub fn loses_to(&self, t: f32, primitive: PrimitiveId) -> bool {
        t < self.t || (t == self.t && self.primitive != PrimitiveId::NONE && primitive < self.primitive)
    }

    /// Whether anything was hit.
    #[must_use]
    pub fn is_hit(&self) -> bool {
        self.primitive != PrimitiveId::NONE
    }
}

/// Eight rays. A lane without a ray has `t_max` 0 (and any unit direction): it hits nothing.
#[derive(Clone, Copy, Debug)]
pub struct RayPacket {
    /// Where t is 0, scene units.
    pub origin: Vec3x8,
    /// Unit length.
    pub direction: Vec3x8,
    /// Hits count only below this t.
    pub t_max: F32x8,
}

impl RayPacket {
    /// Eight lanes without a ray.
    #[must_use]
    pub fn inactive() -> Self {
        Self {
            origin: Vec3x8::ZERO,
            direction: Vec3x8::splat(Vec3::Z),
            t_max: F32x8::ZERO,
        }
    }

    /// Lane `i` as a ray.
    #[must_use]
    pub fn ray(&self, i: usize) -> Ray {
        Ray {
            origin: self.origin.lane(i),
            direction: self.direction.lane(i),
            t_max: self.t_max.as_array()[i],
        }
    }

    /// Puts `ray` into lane `i`.
    pub fn set_ray(&mut self, i: usize, ray: &Ray) {
        self.origin.x.as_mut_array()[i] = ray.origin.x;
        self.origin.y.as_mut_array()[i] = ray.origin.y;
        self.origin.z.as_mut_array()[i] = ray.origin.z;
        self.direction.x.as_mut_array()[i] = ray.direction.x;
        self.direction.y.as_mut_array()[i] = ray.direction.y;
        self.direction.z.as_mut_array()[i] = ray.direction.z;
        self.t_max.as_mut_array()[i] = ray.t_max;
    }
}

/// What eight rays hit first, a column a field of [`Hit`].
#[derive(Clone, Copy, Debug)]
pub struct HitPacket {
    /// Distances.
    pub t: F32x8,
    /// Barycentric weights of the second corner.
    pub u: F32x8,
    /// Barycentric weights of the third corner.
    pub v: F32x8,
    /// Primitives, as the raw value of [`PrimitiveId`].
    pub primitive: [u32; LANES],
}

impl HitPacket {
    /// Eight misses below `t_max`.
    #[must_use]
    pub fn miss(t_max: F32x8) -> Self {
        Self {
            t: t_max,
            u: splat(0.0),
            v: splat(0.0),
            primitive: [u32::MAX; LANES],
        }
    }

    /// Lane `i` as a hit.
    #[must_use]
    pub fn hit(&self, i: usize) -> Hit {
        Hit {
            t: self.t.as_array()[i],
            u: self.u.as_array()[i],
            v: self.v.as_array()[i],
            primitive: PrimitiveId(self.primitive[i]),
        }
    }

    /// Puts `hit` into lane `i`.
    #[inline(always)]
    pub fn set_hit(&mut self, i: usize, hit: &Hit) {
        self.t.as_mut_array()[i] = hit.t;
        self.u.as_mut_array()[i] = hit.u;
        self.v.as_mut_array()[i] = hit.v;
        self.primitive[i] = hit.primitive.0;
    }
}
