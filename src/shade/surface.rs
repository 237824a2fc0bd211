//! From hits to surface packets: where the points are, and which way they face.

use super::queue::{HitQueue, RayQueue};
use crate::{
    ray::{HitPacket, PrimitiveId},
    scene::{Primitive, Scene},
    simd::{F32x8, LANES, Mask8, Vec3x8, gt, max, splat},
};
use glam::Vec3;

/// Eight points on surfaces of one material.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePacket {
    /// Lanes that hold a point (the others repeat the last one).
    pub active: u32,
    /// The points, scene units.
    pub point: Vec3x8,
    /// Unit geometric normals, towards the viewer.
    pub geometric_normal: Vec3x8,
    /// Unit normals for shading, turned with the geometric ones.
    pub normal: Vec3x8,
    /// Unit directions of the rays that hit.
    pub direction: Vec3x8,
    /// The largest absolute coordinate of each primitive, for offsets.
    pub magnitude: F32x8,
    /// Pixels within the tile.
    pub pixel: [u32; LANES],
    /// What the points' colours count.
    pub weight: F32x8,
}

/// The corners or the sphere of eight hits, a lane a hit, before anything is computed from them.
struct Gathered {
    sphere_bits: u32,
    smooth_bits: u32,
    corners: [[Vec3; LANES]; 3],
    normals: [[Vec3; LANES]; 3],
    center: [Vec3; LANES],
    radius: [f32; LANES],
    u: [f32; LANES],
    v: [f32; LANES],
    t: [f32; LANES],
    origin: [Vec3; LANES],
    direction: [Vec3; LANES],
    pixel: [u32; LANES],
    weight: [f32; LANES],
}

/// A triangle of no interest, for lanes that hold a sphere.
const UNIT_CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

impl Gathered {
    const EMPTY: Self = Self {
        sphere_bits: 0,
        smooth_bits: 0,
        corners: [
            [UNIT_CORNERS[0]; LANES],
            [UNIT_CORNERS[1]; LANES],
            [UNIT_CORNERS[2]; LANES],
        ],
        normals: [[Vec3::Z; LANES]; 3],
        center: [Vec3::ZERO; LANES],
        radius: [1.0; LANES],
        u: [0.0; LANES],
        v: [0.0; LANES],
        t: [1.0; LANES],
        origin: [Vec3::ZERO; LANES],
        direction: [Vec3::Z; LANES],
        pixel: [0; LANES],
        weight: [0.0; LANES],
    };

    fn set(&mut self, lane: usize, scene: &Scene, rays: &RayQueue, hits: &[HitPacket], ray_i: usize) {
        let (packet_i, ray_lane) = (ray_i / LANES, ray_i % LANES);
        let packet = &rays.packets[packet_i];
        let hit = hits[packet_i].hit(ray_lane);
        self.direction[lane] = packet.direction.lane(ray_lane);
        self.pixel[lane] = rays.pixel[packet_i][ray_lane];
        self.weight[lane] = rays.weight[packet_i].as_array()[ray_lane];
        match scene.primitive(PrimitiveId(hit.primitive.0)) {
            Primitive::Triangle(i) => {
                let (vertices, triangles) = (scene.vertices(), scene.triangles());
                let index = [triangles.v0[i], triangles.v1[i], triangles.v2[i]];
                (self.u[lane], self.v[lane]) = (hit.u, hit.v);
                for (corner, &vertex) in self.corners.iter_mut().zip(&index) {
                    corner[lane] = vertices.position(vertex);
                }
                if !vertices.normals.is_empty() {
                    let normals = index.map(|vertex| vertices.normals[vertex as usize]);
                    if normals.iter().all(|&n| n != Vec3::ZERO) {
                        self.smooth_bits |= 1 << lane;
                        for (own, new) in self.normals.iter_mut().zip(normals) {
                            own[lane] = new;
                        }
                    }
                }
            }
            Primitive::Sphere(i) => {
                self.sphere_bits |= 1 << lane;
                self.center[lane] = scene.spheres().center(i);
                self.radius[lane] = scene.spheres().radius[i];
                self.t[lane] = hit.t;
                self.origin[lane] = packet.origin.lane(ray_lane);
            }
        }
    }
}

/// Makes surface packets of the filed hits, material by material, in the order of `by_material`.
pub fn gather(
    scene: &Scene,
    rays: &RayQueue,
    hits: &[HitPacket],
    by_material: &HitQueue,
    surfaces: &mut Vec<SurfacePacket>,
) {
    surfaces.clear();
    for (_, bucket) in by_material.buckets() {
        for chunk in bucket.chunks(LANES) {
            let mut gathered = Gathered::EMPTY;
            for lane in 0..LANES {
                let ray_i = chunk[lane.min(chunk.len() - 1)];
                gathered.set(lane, scene, rays, hits, ray_i as usize);
            }
            surfaces.push(surface(&gathered, (1 << chunk.len()) - 1));
        }
    }
}

fn surface(gathered: &Gathered, active: u32) -> SurfacePacket {
    let direction = Vec3x8::from_lanes(gathered.direction);
    let sphere8 = Mask8::from_bits(gathered.sphere_bits);
    let (mut point, mut geometric, mut normal, mut magnitude) = triangles(gathered);
    if gathered.sphere_bits != 0 {
        let (on_sphere, outward, size) = spheres(gathered, direction);
        point = Vec3x8::select(sphere8, on_sphere, point);
        geometric = Vec3x8::select(sphere8, outward, geometric);
        normal = Vec3x8::select(sphere8, outward, normal);
        magnitude = sphere8.select(size, magnitude);
    }
    let away = gt(geometric.dot(direction), splat(0.0));
    SurfacePacket {
        active,
        point,
        geometric_normal: Vec3x8::select(away, -geometric, geometric),
        normal: Vec3x8::select(away, -normal, normal),
        direction,
        magnitude,
        pixel: gathered.pixel,
        weight: gathered.weight.into(),
    }
}

/// Points, geometric normals, shading normals and magnitudes of triangles.
fn triangles(gathered: &Gathered) -> (Vec3x8, Vec3x8, Vec3x8, F32x8) {
    let [v0, v1, v2] = gathered.corners.map(Vec3x8::from_lanes);
    let (u, v) = (F32x8::from(gathered.u), F32x8::from(gathered.v));
    let w = splat(1.0) - u - v;
    let interpolate = |a: Vec3x8, b: Vec3x8, c: Vec3x8| b.mul_add(u, c.mul_add(v, a * w));
    let point = interpolate(v0, v1, v2);
    let facet = (v1 - v0).cross(v2 - v0);
    // Scaled first, so that squares of tiny or huge triangles' normals stay within f32.
    let size = facet.max_abs();
    let geometric = Vec3x8::new(facet.x / size, facet.y / size, facet.z / size).normalize();
    let magnitude = max(max(v0.max_abs(), v1.max_abs()), v2.max_abs());
    let mut normal = geometric;
    if gathered.smooth_bits != 0 {
        let [n0, n1, n2] = gathered.normals.map(Vec3x8::from_lanes);
        let smooth = interpolate(n0, n1, n2);
        let size = smooth.max_abs();
        let usable = gt(size, splat(0.0)) & Mask8::from_bits(gathered.smooth_bits);
        let smooth = Vec3x8::new(smooth.x / size, smooth.y / size, smooth.z / size).normalize();
        normal = Vec3x8::select(usable, smooth, geometric);
    }
    (point, geometric, normal, magnitude)
}

/// Points, outward normals and magnitudes of spheres.
fn spheres(gathered: &Gathered, direction: Vec3x8) -> (Vec3x8, Vec3x8, F32x8) {
    let center = Vec3x8::from_lanes(gathered.center);
    let radius = F32x8::from(gathered.radius);
    let hit = direction.mul_add(gathered.t.into(), Vec3x8::from_lanes(gathered.origin));
    let outward = (hit - center).normalize();
    (
        outward.mul_add(radius, center),
        outward,
        center.max_abs() + radius,
    )
}
