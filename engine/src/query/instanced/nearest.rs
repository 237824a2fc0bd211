//! The closest point of placed geometries: a search of the instances' boxes, and below each of a prototype's.
//!
//! In a prototype's space another point may be the nearest, so all distances are those of the scene. A box is no nearer than
//! the box around its image, nor than its distance in the prototype's space times the transform's least scale. Corners of
//! triangles are placed in `f64`.
// Both bounds pay: see docs/lab-notes.md#closest-points

use super::{InstancedGeometry, InstancedHit, ellipsoid::on_ellipsoid};
use crate::{
    accel::{Child, Instanced, Node8},
    query::{
        Points,
        nearest::{self, Id, In, SLACK, Search, Space, Stack, Visited, boxes, squared_distances, walk},
        points::{NEVER, for_neighbours},
    },
    ray::{Hit, InstanceId, PrimitiveId},
    scene::{Placement, Scene},
    simd::{Lanes, Simd, Vec3Lanes},
};
use glam::{DMat3, DVec3, Vec3};
use std::sync::atomic::AtomicBool;

/// Bound on the rounding of a placed coordinate in `f32`, relative to the sum of its terms: one half-ulp for each of the four
/// numbers, as many for the sums, and as many to spare.
const PLACED_ERROR: f64 = 16.0 / (1 << 24) as f64;

/// The closest point of an [`InstancedGeometry`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstancedClosestPoint {
    /// The point, in the space of the scene.
    pub point: DVec3,
    /// Its distance, at least 0.
    pub distance: f64,
    /// The triangle or sphere that it is on, by its id in its geometry.
    pub primitive: PrimitiveId,
    /// The instance, by its index in the array that was given.
    pub instance: InstanceId,
}

impl InstancedGeometry {
    /// Finds the closest point of all instances, in the space of the scene; of equally near primitives, the one in the first
    /// instance, and in that the one with the lowest id. `None` if there is nothing, or the point is not finite in `f32`.
    #[must_use]
    pub fn closest_point(&self, point: impl Into<DVec3>) -> Option<InstancedClosestPoint> {
        self.closest_near(point.into(), &mut None)
    }

    /// Begins with what is known of a point nearby, and leaves what is known of this one.
    fn closest_near(&self, point: DVec3, near: &mut Option<DVec3>) -> Option<InstancedClosestPoint> {
        let (middle, instanced) = (self.middle(), self.bvh.instanced()?);
        let from = point - middle;
        let reach = |[lower, upper]: [DVec3; 2]| (lower - middle).abs().max((upper - middle).abs());
        let largest = from
            .abs()
            .max(self.bounds.map_or(DVec3::ZERO, reach))
            .max_element();
        let instances = Instances {
            scene: &self.scene,
            instanced,
        };
        let nodes = (instanced.nodes(), Child::inner(0));
        let found = nearest::found(self.level, nodes, &instances, (from, *near), largest)?;
        *near = Some(found.point);
        let (instance, primitive) = found.id;
        let hit = Hit {
            primitive,
            ..Hit::default()
        };
        let given = self.given(&InstancedHit::new(hit, instance));
        Some(InstancedClosestPoint {
            point: found.point + middle,
            distance: found.distance,
            primitive: given.primitive,
            instance: given.instance,
        })
    }

    /// Finds the closest points to many points, on the threads of the current rayon pool.
    ///
    /// # Panics
    /// If points and answers differ in number.
    pub fn closest_points<'p>(
        &self,
        points: impl Into<Points<'p>>,
        closest: &mut [Option<InstancedClosestPoint>],
    ) {
        self.closest_points_until(points.into(), closest, &NEVER);
    }

    /// Finds closest points until the call is cancelled.
    #[doc(hidden)]
    pub fn closest_points_until(
        &self,
        points: Points<'_>,
        closest: &mut [Option<InstancedClosestPoint>],
        cancelled: &AtomicBool,
    ) {
        for_neighbours(points, closest, cancelled, |point, near| {
            self.closest_near(point, near)
        });
    }
}

/// The hierarchy over the instances.
struct Instances<'a> {
    scene: &'a Scene,
    instanced: &'a Instanced,
}

impl Visited for Instances<'_> {
    #[inline(always)]
    fn distances<S: Simd>(&self, simd: S, node: &Node8, search: &Search) -> S::V8 {
        search.box_distances(simd, node)
    }
    #[inline(always)]
    fn leaf<S: Simd>(&self, simd: S, leaf: Child, search: &mut Search, stack: &mut Stack) {
        let instance = InstanceId(leaf.index() as u32);
        let prototype = self.scene.instances()[leaf.index()].prototype();
        let bvh = self.instanced.prototype(prototype);
        let there = In {
            bvh,
            space: There::new(self.scene, instance, search),
        };
        walk(simd, (bvh.nodes(), bvh.root()), &there, search, stack);
    }
}

/// The space of an instance's prototype.
struct There {
    instance: InstanceId,
    placement: Placement,
    /// The rows of the matrix to the scene, and where the prototype's origin is from the point.
    rows: [Vec3; 3],
    origin: Vec3,
    /// Bounds on the rounding of placed coordinates.
    margin: Vec3,
    /// The point in the prototype's space, and bounds on its rounding.
    point: Vec3,
    rounding: Vec3,
    /// The least scale of the matrix, times that of the search.
    scale: f32,
}

impl There {
    #[inline(always)]
    fn new(scene: &Scene, instance: InstanceId, search: &Search) -> Self {
        let stored = &scene.instances()[instance.0 as usize];
        let placement = stored.placement();
        let prototype = &scene.prototypes()[stored.prototype().0 as usize];
        let most = f64::from(prototype.bounds.max_abs());
        let rows = placement.linear.map(DVec3::from_array);
        let origin = placement.point_in_f64(DVec3::ZERO) - search.point;
        let sums = DVec3::from_array(rows.map(|row| row.abs().element_sum()));
        let margin = (sums * most + origin.abs()) * PLACED_ERROR;
        let [point, _] = placement.image_of_line([search.point, DVec3::ZERO]);
        let mut there = Self {
            instance,
            rows: rows.map(DVec3::as_vec3),
            origin: origin.as_vec3(),
            margin: margin.as_vec3(),
            point: point.as_vec3(),
            rounding: (point.abs() * SLACK).as_vec3(),
            scale: (least_scale(&placement) * (1.0 - SLACK)) as f32 * search.scale,
            placement,
        };
        if !there.point.is_finite() {
            // Its distance is unknown there.
            (there.point, there.scale) = (Vec3::ZERO, 0.0);
        }
        there
    }
}

/// Returns a lower bound on how much a transform scales any direction, which it reaches if it turns and then stretches along
/// the axes, or the other way round.
fn least_scale(placement: &Placement) -> f64 {
    let [a, b, c] = placement.rows.map(|[x, y, z, _]| DVec3::new(x, y, z));
    let inverse = DMat3::from_cols(a, b, c);
    // The largest scale of the inverse: its square is an eigenvalue of both products, which no sum of a row is below.
    let largest = |product: DMat3| {
        let [a, b, c] = [product.x_axis, product.y_axis, product.z_axis];
        (a.abs() + b.abs() + c.abs()).max_element()
    };
    let transposed = inverse.transpose();
    let squared = largest(inverse * transposed).min(largest(transposed * inverse));
    1.0 / squared.sqrt()
}

impl Space for There {
    #[inline(always)]
    fn distances<S: Simd>(&self, simd: S, node: &Node8, search: &Search) -> S::V8 {
        let [lower, upper] = boxes(simd, node);
        let point = simd.splat3(self.point);
        let rounding = simd.splat3(self.rounding);
        let there = squared_distances(lower - point, upper - point, rounding, self.scale);
        let center = self.relative(simd, (lower + upper) * lower.x.all(0.5), search);
        let half = (upper - lower) * lower.x.all(0.5);
        let [a, b, c] = self.rows;
        let half = Vec3Lanes::new(
            half.dot_about(simd.splat3(a.abs())),
            half.dot_about(simd.splat3(b.abs())),
            half.dot_about(simd.splat3(c.abs())),
        );
        let margin = simd.splat3(self.margin);
        let image = squared_distances(center - half, center + half, margin, search.scale);
        there.max(image)
    }
    #[inline(always)]
    fn relative<S: Simd>(&self, simd: S, corner: Vec3Lanes<S::V8>, _: &Search) -> Vec3Lanes<S::V8> {
        let [a, b, c] = self.rows;
        let turned = Vec3Lanes::new(
            corner.dot_about(simd.splat3(a)),
            corner.dot_about(simd.splat3(b)),
            corner.dot_about(simd.splat3(c)),
        );
        turned + simd.splat3(self.origin)
    }
    #[inline(always)]
    fn margin(&self) -> Vec3 {
        self.margin
    }
    #[inline(always)]
    fn corner(&self, corner: Vec3) -> DVec3 {
        self.placement.point_in_f64(corner.as_dvec3())
    }
    fn on_sphere(&self, point: DVec3, center: DVec3, radius: f64) -> DVec3 {
        let linear = DMat3::from_cols_array_2d(&self.placement.linear).transpose();
        let axes = [linear.x_axis, linear.y_axis, linear.z_axis].map(|axis| axis * radius);
        on_ellipsoid(point, self.placement.point_in_f64(center), axes)
    }
    #[inline(always)]
    fn id(&self, primitive: PrimitiveId) -> Id {
        (self.instance, primitive)
    }
}
