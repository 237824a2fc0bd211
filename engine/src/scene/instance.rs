//! Instances: meshes that are stored once, as prototypes, and placed any number of times.
//!
//! A ray hits an instance where its image, the ray in the prototype's space, hits the prototype. The image is computed in
//! `f64` and rounded once, by the same scalar code in all tracing methods, so that they find the same hits.

use super::{PlacedMesh, TriangleMesh};
use super::{Scene, Transform, builder::usable_point, origin::origin_of, texture::dot};
use crate::{
    error::SceneError,
    lanes::{LANES, Vec3x8},
    math::{Aabb, scale_to_one},
    ray::{InstanceId, Ray, T_MAX},
};
use glam::{DVec3, Vec3};
use std::ops::Range;

/// The most instances of a scene.
pub const MAX_INSTANCES: usize = 1 << 24;

/// The most prototypes of a scene.
pub const MAX_PROTOTYPES: usize = 1 << 16;

/// Rays that start farther than this from a prototype of about size 1 do not hit it: from there it is smaller than the
/// resolution of directions, and products of coordinates might overflow.
const FARTHEST: f32 = 1e9;

/// The least volume of a transformed unit cube, as a share of the product of its side lengths: flatter matrices are
/// numerically singular.
const LEAST_SOLIDITY: f64 = 1e-9;

/// The number of a prototype in its scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PrototypeId(pub u32);

/// A mesh that instances place: parts of the scene's arrays. Positions are in the prototype's space, with coordinates up to
/// about 1.
#[derive(Clone, Debug)]
pub struct Prototype {
    /// Its triangles, by index.
    pub triangles: Range<u32>,
    /// Its spheres, by index.
    pub spheres: Range<u32>,
    /// Its vertices, by index.
    pub vertices: Range<u32>,
    /// The box around it, in its own space.
    pub bounds: Aabb,
    /// Positions became (position - center) * scale, with a power of two as the scale.
    pub(super) center: Vec3,
    pub(super) scale: f32,
}

/// A placed prototype.
#[derive(Clone, Copy, Debug)]
pub struct Instance {
    /// The 3x4 matrix, row by row, from the scene's space relative to [`Scene::origin`] to the prototype's.
    to_prototype: [[f32; 4]; 3],
    prototype: PrototypeId,
}

/// A ray in a prototype's space, without an end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImageRay {
    /// The ray, its direction of unit length.
    pub ray: Ray,
    /// Length of the image of a unit distance.
    length: f64,
}

impl ImageRay {
    /// `None` for a ray whose direction has no length.
    #[inline(always)]
    #[must_use]
    pub fn new(ray: Ray, length: f64) -> Option<Self> {
        (length > 0.0 && length < f64::INFINITY).then_some(Self { ray, length })
    }

    /// The distance in the scene of `t` in the prototype's space.
    #[inline]
    #[must_use]
    pub fn in_scene(&self, t: f32) -> f32 {
        ((f64::from(t) / self.length) as f32).clamp(f32::MIN_POSITIVE, T_MAX)
    }

    /// The t of a distance in the scene.
    #[inline]
    #[must_use]
    pub fn of_distance(&self, distance: f32) -> f32 {
        (f64::from(distance) * self.length) as f32
    }

    /// The least t whose [distance in the scene](Self::in_scene) is `t_max` or more, or the largest number.
    #[must_use]
    pub fn end(&self, t_max: f32) -> f32 {
        // No distance is less, and stepping there would take long.
        if t_max <= f32::MIN_POSITIVE {
            return 0.0;
        }
        let mut end = ((f64::from(t_max) * self.length) as f32).clamp(0.0, T_MAX);
        while end < T_MAX && self.in_scene(end) < t_max {
            end = end.next_up();
        }
        while end > 0.0 && self.in_scene(end.next_down()) >= t_max {
            end = end.next_down();
        }
        end
    }

    /// A t slightly above all those whose distance in the scene is `t_max` or less.
    #[inline]
    #[must_use]
    pub fn beyond(&self, t_max: f32) -> f32 {
        const MORE: f64 = 1.0 + 1e-6;
        ((f64::from(t_max) * self.length * MORE) as f32)
            .next_up()
            .min(T_MAX)
    }
}

impl Instance {
    /// Returns the placed prototype.
    #[inline]
    #[must_use]
    pub fn prototype(&self) -> PrototypeId {
        self.prototype
    }

    /// Returns the 3x4 matrix, row by row, from the prototype's space to the scene's, relative to [`Scene::origin`].
    #[must_use]
    pub fn to_scene(&self) -> [f32; 12] {
        let Placement { linear, offset, .. } = self.placement();
        std::array::from_fn(|i| linear[i / 4].get(i % 4).copied().unwrap_or(offset[i / 4]) as f32)
    }

    /// The image of a valid ray; `None` if it starts too far away to hit anything.
    #[inline]
    #[must_use]
    pub(crate) fn image(&self, ray: &Ray) -> Option<ImageRay> {
        let origin = self.image_of_origin(ray.origin)?;
        let d = ray.direction;
        let (direction, length) = self.image_of_direction(d.x, d.y, d.z);
        ImageRay::new(Ray::new(origin, Vec3::from_array(direction)), length)
    }

    /// The image of a point that rays start from; `None` if it is too far away.
    #[inline]
    #[must_use]
    pub(crate) fn image_of_origin(&self, origin: Vec3) -> Option<Vec3> {
        let image = self
            .to_prototype
            .map(|row| (product(&row, origin.x, origin.y, origin.z) + f64::from(row[3])) as f32);
        let image = Vec3::from_array(image);
        // NaN is not near either.
        (image.abs().max_element() <= FARTHEST).then_some(image)
    }

    /// The images of eight directions, of unit length, and how long they were.
    #[inline(always)]
    #[must_use]
    pub(crate) fn images_of_directions(&self, d: &Vec3x8) -> ([[f32; LANES]; 3], [f64; LANES]) {
        let (mut images, mut lengths) = ([[0.0; LANES]; 3], [0.0; LANES]);
        let (x, y, z) = (d.x.as_array(), d.y.as_array(), d.z.as_array());
        for i in 0..LANES {
            let ([a, b, c], length) = self.image_of_direction(x[i], y[i], z[i]);
            (images[0][i], images[1][i], images[2][i], lengths[i]) = (a, b, c, length);
        }
        (images, lengths)
    }

    #[inline(always)]
    fn image_of_direction(&self, x: f32, y: f32, z: f32) -> ([f32; 3], f64) {
        let [a, b, c] = &self.to_prototype;
        let (x, y, z) = (product(a, x, y, z), product(b, x, y, z), product(c, x, y, z));
        let length = (x * x + y * y + z * z).sqrt();
        (
            [(x / length) as f32, (y / length) as f32, (z / length) as f32],
            length,
        )
    }

    /// The inverse: from the prototype's space to the scene's.
    #[must_use]
    #[doc(hidden)]
    pub fn placement(&self) -> Placement {
        let rows = self.to_prototype.map(|row| row.map(f64::from));
        let [a, b, c] = rows;
        let cross = |p: [f64; 4], q: [f64; 4]| {
            [
                p[1] * q[2] - p[2] * q[1],
                p[2] * q[0] - p[0] * q[2],
                p[0] * q[1] - p[1] * q[0],
            ]
        };
        // Columns of the adjugate.
        let [x, y, z] = [cross(b, c), cross(c, a), cross(a, b)];
        let determinant = a[0] * x[0] + a[1] * x[1] + a[2] * x[2];
        let linear = [0, 1, 2].map(|i| [x[i] / determinant, y[i] / determinant, z[i] / determinant]);
        let offset = linear.map(|row| -(row[0] * a[3] + row[1] * b[3] + row[2] * c[3]));
        Placement { rows, linear, offset }
    }
}

/// The first three numbers of a row times a vector.
#[inline(always)]
fn product(row: &[f32; 4], x: f32, y: f32, z: f32) -> f64 {
    f64::from(row[0]) * f64::from(x) + f64::from(row[1]) * f64::from(y) + f64::from(row[2]) * f64::from(z)
}

/// The transform from a prototype's space to the scene's.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct Placement {
    /// The matrix to the prototype.
    pub(crate) rows: [[f64; 4]; 3],
    /// The rows of the matrix to the scene.
    pub(crate) linear: [[f64; 3]; 3],
    offset: [f64; 3],
}

impl Placement {
    /// The place of a point in the scene, relative to its origin.
    #[must_use]
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.point_in_f64(p.as_dvec3()).as_vec3()
    }

    #[must_use]
    pub fn point_in_f64(&self, p: DVec3) -> DVec3 {
        let place = |i: usize| {
            let [a, b, c] = self.linear[i];
            a * p.x + b * p.y + c * p.z + self.offset[i]
        };
        DVec3::new(place(0), place(1), place(2))
    }

    /// The image of a direction, of another length, and whether the transform mirrors.
    pub(super) fn direction(&self, d: DVec3) -> (DVec3, bool) {
        let [a, b, c] = self.linear.map(DVec3::from_array);
        let image = DVec3::new(dot(a, d), dot(b, d), dot(c, d));
        (image, dot(a.cross(b), c) < 0.0)
    }

    /// The unit normal in the scene of a surface with this normal: that of the inverse transpose.
    #[must_use]
    pub fn normal(&self, normal: Vec3) -> Vec3 {
        let DVec3 { x, y, z } = self.normal_in_f64(normal.as_dvec3());
        let length = (x * x + y * y + z * z).sqrt();
        Vec3::new((x / length) as f32, (y / length) as f32, (z / length) as f32)
    }

    /// That normal in `f64`, of another length.
    #[inline]
    pub(crate) fn normal_in_f64(&self, n: DVec3) -> DVec3 {
        let [a, b, c] = &self.rows;
        let along = |i: usize| a[i] * n.x + b[i] * n.y + c[i] * n.z;
        DVec3::new(along(0), along(1), along(2))
    }

    /// A line in the scene, relative to its origin, in the prototype's space: a point and a direction, with the same t.
    pub(crate) fn image_of_line(&self, [origin, direction]: [DVec3; 2]) -> [DVec3; 2] {
        let image = |v: DVec3, w: f64| {
            let [x, y, z] = self
                .rows
                .map(|row| row[0] * v.x + row[1] * v.y + row[2] * v.z + row[3] * w);
            DVec3::new(x, y, z)
        };
        [image(origin, 1.0), image(direction, 0.0)]
    }

    /// An upper bound on the scene coordinates of points with coordinates up to `magnitude`; it bounds the rounding of
    /// positions.
    #[must_use]
    pub fn magnitude(&self, magnitude: f32) -> f32 {
        let most = |i: usize| {
            let [a, b, c] = self.linear[i].map(f64::abs);
            (a + b + c) * f64::from(magnitude) + self.offset[i].abs()
        };
        most(0).max(most(1)).max(most(2)) as f32
    }

    /// The box around the image of a box.
    #[must_use]
    pub fn bounds(&self, bounds: Aabb) -> Aabb {
        let (lower, upper) = (bounds.lower.as_dvec3(), bounds.upper.as_dvec3());
        let (mut least, mut most) = (self.offset, self.offset);
        for i in 0..3 {
            for (j, factor) in self.linear[i].into_iter().enumerate() {
                let (from, to) = (factor * lower[j], factor * upper[j]);
                least[i] += from.min(to);
                most[i] += from.max(to);
            }
        }
        Aabb {
            lower: DVec3::from_array(least).as_vec3(),
            upper: DVec3::from_array(most).as_vec3(),
        }
    }
}

/// An instance whose scene has no origin yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unplaced {
    linear: [[f32; 3]; 3],
    /// The position of the prototype's origin.
    position: DVec3,
    prototype: PrototypeId,
}

impl Unplaced {
    /// Places a prototype of index `id` by `transform`.
    pub(super) fn new(
        prototype: &Prototype,
        id: PrototypeId,
        transform: &Transform,
    ) -> Result<Self, SceneError> {
        let (linear, position) = transform.about(prototype.center.as_dvec3());
        let inverse = (linear * f64::from(prototype.scale.recip())).inverse();
        let [x, y, z] = inverse.to_cols_array_2d();
        let rows = [0, 1, 2].map(|i| [x[i] as f32, y[i] as f32, z[i] as f32]);
        let is_flat = {
            let [a, b, c] = rows.map(|row| DVec3::from_array(row.map(f64::from)));
            let solidity = a.dot(b.cross(c)).abs() / (a.length() * b.length() * c.length());
            !(solidity >= LEAST_SOLIDITY && solidity.is_finite())
        };
        if is_flat {
            return Err(SceneError::Flat);
        }
        let unplaced = Self {
            linear: rows,
            position,
            prototype: id,
        };
        let bounds = unplaced.at(Vec3::ZERO).placement().bounds(prototype.bounds);
        for corner in [bounds.lower, bounds.upper] {
            usable_point(corner)?;
        }
        Ok(unplaced)
    }

    /// The instance in a scene with that origin.
    pub(super) fn at(&self, origin: Vec3) -> Instance {
        let from = self.position - origin.as_dvec3();
        let row = |row: [f32; 3]| {
            let [a, b, c] = row.map(f64::from);
            let offset = -(a * from.x + b * from.y + c * from.z);
            [row[0], row[1], row[2], offset as f32]
        };
        Instance {
            to_prototype: self.linear.map(row),
            prototype: self.prototype,
        }
    }
}

impl Prototype {
    /// Returns whether it has no primitives.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty() && self.spheres.is_empty()
    }

    /// Finds the space of positions that are within `bounds`.
    pub(super) fn enclose(&mut self, bounds: Aabb) {
        self.center = origin_of(bounds);
        let size = Aabb {
            lower: bounds.lower - self.center,
            upper: bounds.upper - self.center,
        };
        self.scale = prototype_scale(size.max_abs());
        self.bounds = Aabb {
            lower: size.lower * self.scale,
            upper: size.upper * self.scale,
        };
    }
}

/// Checks whether a transform can place a mesh as an instance.
#[doc(hidden)]
pub struct Placing(Prototype);

impl Placing {
    #[doc(hidden)]
    pub fn of(mesh: &TriangleMesh) -> Self {
        let mut prototype = Prototype {
            triangles: 0..0,
            spheres: 0..0,
            vertices: 0..0,
            bounds: Aabb::EMPTY,
            center: Vec3::ZERO,
            scale: 1.0,
        };
        let bounds = PlacedMesh::bounds(&[PlacedMesh::in_place(mesh)]);
        if !bounds.is_empty() {
            prototype.enclose(bounds);
        }
        Self(prototype)
    }

    /// Refuses what [`SceneBuilder::add_instance`](super::SceneBuilder::add_instance) refuses.
    ///
    /// # Errors
    /// [`SceneError::Flat`] or [`SceneError::NotUsable`].
    #[doc(hidden)]
    pub fn check(&self, transform: &Transform) -> Result<(), SceneError> {
        Unplaced::new(&self.0, PrototypeId(0), transform).map(|_| ())
    }
}

/// The power of two that scales a prototype of this size to about 1.
fn prototype_scale(size: f32) -> f32 {
    if size >= f32::MIN_POSITIVE {
        scale_to_one(size)
    } else {
        1.0
    }
}

impl Scene {
    /// Returns the prototypes that [`PrototypeId`]s index.
    #[inline]
    #[must_use]
    pub fn prototypes(&self) -> &[Prototype] {
        &self.prototypes
    }

    /// Returns the instances that [`InstanceId`]s index.
    #[inline]
    #[must_use]
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// The instance with this id, if that is not [`InstanceId::NONE`].
    #[inline]
    #[must_use]
    pub(crate) fn instance(&self, id: InstanceId) -> Option<&Instance> {
        self.instances.get(id.0 as usize)
    }

    /// Returns the box around an instance, relative to [`Scene::origin`].
    ///
    /// # Panics
    /// If there is no such instance.
    #[must_use]
    pub fn instance_bounds(&self, id: InstanceId) -> Aabb {
        let instance = &self.instances[id.0 as usize];
        let prototype = &self.prototypes[instance.prototype.0 as usize];
        instance.placement().bounds(prototype.bounds)
    }

    /// Returns the ids of the primitives of a prototype, or of all that belong to none, in order.
    #[must_use]
    pub fn ids_of(&self, prototype: Option<PrototypeId>) -> Vec<Range<u32>> {
        let triangles = self.triangles.corners.len() as u32;
        let end = triangles + self.spheres.radius.len() as u32;
        let of_spheres = |range: &Range<u32>| triangles + range.start..triangles + range.end;
        if let Some(id) = prototype {
            let prototype = &self.prototypes[id.0 as usize];
            return vec![prototype.triangles.clone(), of_spheres(&prototype.spheres)];
        }
        let taken = (self.prototypes.iter().map(|p| p.triangles.clone()))
            .chain(self.prototypes.iter().map(|p| of_spheres(&p.spheres)));
        gaps(taken, end)
    }
}

/// The numbers up to `end` outside of the ranges `taken`, which are in order.
pub(super) fn gaps(taken: impl Iterator<Item = Range<u32>>, end: u32) -> Vec<Range<u32>> {
    let (mut free, mut next) = (Vec::new(), 0);
    for taken in taken.chain(std::iter::once(end..end)) {
        if next < taken.start {
            free.push(next..taken.start);
        }
        next = next.max(taken.end);
    }
    free
}

#[cfg(test)]
mod tests;
