//! Surface packets: points, normals and offsets of eight hits on one material.

use super::queue::{HitQueue, PacketLanes, RayIndex, RayQueue};
use crate::{
    ray::{HitPacket, PrimitiveId},
    scene::{Primitive, Scene},
    simd_old::{
        F32x8, LANES, Mask8, Vec3x8, eq, equal_lanes, from_lanes, gt, lane, max, scale_to_one, splat,
    },
};

/// Eight points on surfaces of one material.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePacket {
    /// Lanes that hold a point; the others repeat one of these.
    pub active: u32,
    /// The points, scene units.
    pub point: Vec3x8,
    /// Unit geometric normals on the viewer's side.
    pub geometric_normal: Vec3x8,
    /// Unit shading normals, negated gathered with the geometric ones.
    pub normal: Vec3x8,
    /// Unit directions of the rays.
    pub direction: Vec3x8,
    /// The largest absolute coordinate of each primitive, for ray offsets.
    pub magnitude: F32x8,
    /// Indices of the pixels in [`TileColors`](super::TileColors).
    pub pixel: [u32; LANES],
    /// The factors of the colours in the pixels.
    pub weight: F32x8,
}

/// Eight rays and their hits.
struct Hits8 {
    direction: Vec3x8,
    origin: Vec3x8,
    pixel: [u32; LANES],
    weight: F32x8,
    t: F32x8,
    u: F32x8,
    v: F32x8,
    primitive: [u32; LANES],
}

impl Hits8 {
    /// Loads a whole packet.
    #[inline(always)]
    fn whole(rays: &RayQueue, hits: &[HitPacket], p: usize) -> Self {
        let (packet, hits) = (&rays.rays.packets()[p], &hits[p]);
        Self {
            direction: packet.direction,
            origin: rays.rays.origin(p),
            pixel: rays.pixel(p),
            weight: rays.weight(p),
            t: hits.t,
            u: hits.u,
            v: hits.v,
            primitive: hits.primitive,
        }
    }

    /// Loads the lanes `bits` of a packet; the others repeat the first of these.
    fn masked(rays: &RayQueue, hits: &[HitPacket], p: usize, bits: u32) -> Self {
        let whole = Self::whole(rays, hits, p);
        let (first, mask) = (bits.trailing_zeros() as usize, Mask8::from_bits(bits));
        let repeat = |a: F32x8| mask.select(a, splat(lane(&a, first)));
        let repeat3 = |a: Vec3x8| Vec3x8::new(repeat(a.x), repeat(a.y), repeat(a.z));
        let mut primitive = whole.primitive;
        for (i, id) in primitive.iter_mut().enumerate() {
            if bits >> i & 1 == 0 {
                *id = whole.primitive[first];
            }
        }
        Self {
            direction: repeat3(whole.direction),
            origin: repeat3(whole.origin),
            t: repeat(whole.t),
            u: repeat(whole.u),
            v: repeat(whole.v),
            primitive,
            ..whole
        }
    }

    /// Gathers up to eight rays of any packets; the last one is repeated.
    fn gather(rays: &RayQueue, hits: &[HitPacket], ray_i: &[RayIndex]) -> Self {
        let mut gathered = Self {
            direction: Vec3x8::ZERO,
            origin: Vec3x8::ZERO,
            pixel: [0; LANES],
            weight: F32x8::ZERO,
            t: F32x8::ZERO,
            u: F32x8::ZERO,
            v: F32x8::ZERO,
            primitive: [0; LANES],
        };
        for to in 0..LANES {
            let i = ray_i[to.min(ray_i.len() - 1)] as usize;
            let (p, from) = (i / LANES, i % LANES);
            let (packet, hits) = (&rays.rays.packets()[p], &hits[p]);
            let copy = |to8: &mut F32x8, from8: &F32x8| to8.as_mut_array()[to] = lane(from8, from);
            let copy3 = |to8: &mut Vec3x8, from8: &Vec3x8| {
                copy(&mut to8.x, &from8.x);
                copy(&mut to8.y, &from8.y);
                copy(&mut to8.z, &from8.z);
            };
            copy3(&mut gathered.direction, &packet.direction);
            copy3(&mut gathered.origin, &rays.rays.origin(p));
            copy(&mut gathered.weight, &rays.weight(p));
            copy(&mut gathered.t, &hits.t);
            copy(&mut gathered.u, &hits.u);
            copy(&mut gathered.v, &hits.v);
            gathered.pixel[to] = rays.pixel(p)[from];
            gathered.primitive[to] = hits.primitive[from];
        }
        gathered
    }
}

const ALL_LANES: u32 = (1 << LANES) - 1;

/// Makes surface packets of the sorted hits, in the order of `by_material`.
pub fn gather(
    scene: &Scene,
    rays: &RayQueue,
    hits: &[HitPacket],
    by_material: &HitQueue,
    surfaces: &mut Vec<SurfacePacket>,
) {
    surfaces.clear();
    let mut cache = None;
    for (_, bucket) in by_material.buckets() {
        for &PacketLanes { packet, bits } in &bucket.in_place {
            let hits8 = if bits == ALL_LANES {
                Hits8::whole(rays, hits, packet as usize)
            } else {
                Hits8::masked(rays, hits, packet as usize, bits)
            };
            push(scene, &hits8, bits, &mut cache, surfaces);
        }
        for chunk in bucket.compacted.chunks(LANES) {
            let hits8 = Hits8::gather(rays, hits, chunk);
            let active = ALL_LANES >> (LANES - chunk.len());
            push(scene, &hits8, active, &mut cache, surfaces);
        }
    }
}

/// Points and normals, before the normals are turned to the viewer.
struct Points8 {
    point: Vec3x8,
    geometric: Vec3x8,
    normal: Vec3x8,
    magnitude: F32x8,
}

fn push(
    scene: &Scene,
    hits: &Hits8,
    active: u32,
    cache: &mut Option<CachedTriangle>,
    surfaces: &mut Vec<SurfacePacket>,
) {
    let points = points(scene, hits, cache);
    let away = gt(points.geometric.dot(hits.direction), splat(0.0));
    surfaces.push(SurfacePacket {
        active,
        point: points.point,
        geometric_normal: Vec3x8::select(away, -points.geometric, points.geometric),
        normal: Vec3x8::select(away, -points.normal, points.normal),
        direction: hits.direction,
        magnitude: points.magnitude,
        pixel: hits.pixel,
        weight: hits.weight,
    });
}

#[inline(always)]
fn points(scene: &Scene, hits: &Hits8, cache: &mut Option<CachedTriangle>) -> Points8 {
    let first = hits.primitive[0];
    if equal_lanes(&hits.primitive, first) == ALL_LANES {
        return match scene.primitive(PrimitiveId(first)) {
            Primitive::Triangle(i) => {
                let triangle = match cache {
                    Some(triangle) if triangle.triangle_i == i => triangle,
                    _ => cache.insert(CachedTriangle::new(scene, i)),
                };
                triangles(hits, &triangle.corners, &triangle.facet)
            }
            Primitive::Sphere(i) => {
                let spheres = scene.spheres();
                sphere(hits, Vec3x8::splat(spheres.center(i)), splat(spheres.radius[i]))
            }
        };
    }
    let triangle_count = scene.triangles().corners.len() as u32;
    let mut sphere_bits = 0;
    for (lane, &id) in hits.primitive.iter().enumerate() {
        sphere_bits |= u32::from(id >= triangle_count) << lane;
    }
    match sphere_bits {
        0 => distinct_triangles(scene, hits, &hits.primitive),
        ALL_LANES => distinct_spheres(scene, hits, &hits.primitive),
        _ => mixed(scene, hits, sphere_bits),
    }
}

/// Triangles and spheres, the latter in the lanes of `sphere_bits`.
#[inline(never)]
fn mixed(scene: &Scene, hits: &Hits8, sphere_bits: u32) -> Points8 {
    // Lanes of the other kind compute on the first triangle or sphere.
    let (mut triangle_ids, mut sphere_ids) = (hits.primitive, hits.primitive);
    let first_triangle = hits.primitive[sphere_bits.trailing_ones() as usize];
    let first_sphere = hits.primitive[sphere_bits.trailing_zeros() as usize];
    for lane in 0..LANES {
        if sphere_bits >> lane & 1 == 1 {
            triangle_ids[lane] = first_triangle;
        } else {
            sphere_ids[lane] = first_sphere;
        }
    }
    let triangles = distinct_triangles(scene, hits, &triangle_ids);
    let spheres = distinct_spheres(scene, hits, &sphere_ids);
    let sphere8 = Mask8::from_bits(sphere_bits);
    Points8 {
        point: Vec3x8::select(sphere8, spheres.point, triangles.point),
        geometric: Vec3x8::select(sphere8, spheres.geometric, triangles.geometric),
        normal: Vec3x8::select(sphere8, spheres.normal, triangles.normal),
        magnitude: sphere8.select(spheres.magnitude, triangles.magnitude),
    }
}

/// The vertices of eight triangles.
struct Corners {
    position: [Vec3x8; 3],
    /// Vertex normals, if the scene has any.
    normal: Option<[Vec3x8; 3]>,
}

impl Corners {
    /// Broadcasts one triangle to all lanes.
    #[inline(always)]
    fn broadcast(scene: &Scene, triangle_i: usize) -> Self {
        let (vertices, triangles) = (scene.vertices(), scene.triangles());
        let [a, b, c] = scene.triangle(triangle_i);
        let normal = |k: usize| Vec3x8::splat(vertices.normals[triangles.corners[triangle_i][k] as usize]);
        Self {
            position: [Vec3x8::splat(a), Vec3x8::splat(b), Vec3x8::splat(c)],
            normal: (!vertices.normals.is_empty()).then(|| [normal(0), normal(1), normal(2)]),
        }
    }

    /// Gathers one triangle per lane.
    #[inline(always)]
    fn gather(scene: &Scene, triangle_i: &[u32; LANES]) -> Self {
        let (vertices, triangles) = (scene.vertices(), scene.triangles());
        let (mut a, mut b, mut c) = ([0; LANES], [0; LANES], [0; LANES]);
        for (lane, &i) in triangle_i.iter().enumerate() {
            let corners = triangles.corners[i as usize];
            (a[lane], b[lane], c[lane]) = (corners[0] as usize, corners[1] as usize, corners[2] as usize);
        }
        let load = |from: &[f32], vertex_i: &[usize; LANES]| from_lanes(|lane| from[vertex_i[lane]]);
        let position = |vertex_i: &[usize; LANES]| {
            Vec3x8::new(
                load(&vertices.x, vertex_i),
                load(&vertices.y, vertex_i),
                load(&vertices.z, vertex_i),
            )
        };
        let normal = |vertex_i: &[usize; LANES]| {
            let n = &vertices.normals[..];
            Vec3x8::new(
                from_lanes(|lane| n[vertex_i[lane]].x),
                from_lanes(|lane| n[vertex_i[lane]].y),
                from_lanes(|lane| n[vertex_i[lane]].z),
            )
        };
        Self {
            position: [position(&a), position(&b), position(&c)],
            normal: (!vertices.normals.is_empty()).then(|| [normal(&a), normal(&b), normal(&c)]),
        }
    }
}

/// Values that depend on the triangles alone, not on the hits.
struct Facet {
    /// Unit normals.
    geometric: Vec3x8,
    magnitude: F32x8,
}

impl Facet {
    #[inline(always)]
    fn new(corners: &Corners) -> Self {
        let [v0, v1, v2] = corners.position;
        let facet = (v1 - v0).cross(v2 - v0);
        Self {
            // Scaled first, so that squared normals of tiny or huge triangles stay in the range of f32.
            geometric: (facet * scale_to_one(facet.max_abs())).normalize(),
            magnitude: max(max(v0.max_abs(), v1.max_abs()), v2.max_abs()),
        }
    }
}

/// The last triangle that all lanes of a packet hit: the next packet often hits it as well.
// Tuned: see docs/lab-notes.md#cached-triangle
struct CachedTriangle {
    triangle_i: usize,
    corners: Corners,
    facet: Facet,
}

impl CachedTriangle {
    fn new(scene: &Scene, triangle_i: usize) -> Self {
        let corners = Corners::broadcast(scene, triangle_i);
        Self {
            triangle_i,
            facet: Facet::new(&corners),
            corners,
        }
    }
}

/// Evaluates a triangle per lane.
#[inline(always)]
fn distinct_triangles(scene: &Scene, hits: &Hits8, triangle_i: &[u32; LANES]) -> Points8 {
    let corners = Corners::gather(scene, triangle_i);
    triangles(hits, &corners, &Facet::new(&corners))
}

#[inline(always)]
fn triangles(hits: &Hits8, corners: &Corners, &Facet { geometric, magnitude }: &Facet) -> Points8 {
    let [v0, v1, v2] = corners.position;
    let w = splat(1.0) - hits.u - hits.v;
    let interpolate = |a: Vec3x8, b: Vec3x8, c: Vec3x8| b.mul_add(hits.u, c.mul_add(hits.v, a * w));
    let mut normal = geometric;
    if let Some([n0, n1, n2]) = corners.normal {
        let zero = splat(0.0);
        let missing = |n: Vec3x8| eq(n.x, zero) & eq(n.y, zero) & eq(n.z, zero);
        let smooth = interpolate(n0, n1, n2);
        let size = smooth.max_abs();
        let usable = gt(size, zero) & !(missing(n0) | missing(n1) | missing(n2));
        normal = Vec3x8::select(usable, (smooth * scale_to_one(size)).normalize(), geometric);
    }
    Points8 {
        point: interpolate(v0, v1, v2),
        geometric,
        normal,
        magnitude,
    }
}

/// Evaluates a sphere per lane.
fn distinct_spheres(scene: &Scene, hits: &Hits8, id: &[u32; LANES]) -> Points8 {
    let (spheres, first) = (scene.spheres(), scene.triangles().corners.len());
    let load = |from: &[f32]| from_lanes(|lane| from[id[lane] as usize - first]);
    let center = Vec3x8::new(
        load(&spheres.center_x),
        load(&spheres.center_y),
        load(&spheres.center_z),
    );
    sphere(hits, center, load(&spheres.radius))
}

#[inline(always)]
fn sphere(hits: &Hits8, center: Vec3x8, radius: F32x8) -> Points8 {
    // Relative to the centre: far from the origin, a point has few bits left for its position on the sphere.
    let outward = hits.direction.mul_add(hits.t, hits.origin - center).normalize();
    Points8 {
        point: outward.mul_add(radius, center),
        geometric: outward,
        normal: outward,
        magnitude: center.max_abs() + radius,
    }
}
