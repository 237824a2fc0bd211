//! Surface packets: points, normals and offsets of eight hits on one material.

mod instances;
mod lift;
mod planes;

pub(super) use instances::place;

use super::queue::{HitQueue, PacketLanes, RayIndex, RayQueue};
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::{HitPacket, PrimitiveId},
    scene::{Plane, Primitive, Scene},
    simd::{EightLanes, LaneMask, Lanes, Simd, Vec3Eight, Vec3Lanes},
};

/// Eight points on surfaces of one material.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePacket {
    /// Lanes that hold a point; the others repeat one of these.
    pub active: u32,
    /// Lanes whose ray comes from behind: the geometric normal was turned.
    pub from_behind: u32,
    /// The points, scene units.
    pub point: Vec3x8,
    /// The lanes whose `rise` is above 0, a bit each.
    pub raised: u32,
    /// How far the smooth surface is above each point, scene units; 0 without [smooth shadows](Scene::smooth_shadows).
    pub rise: F32x8,
    /// Unit geometric normals on the viewer's side.
    pub geometric_normal: Vec3x8,
    /// Unit shading normals, negated where the geometric ones are.
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
    /// Copies a whole packet.
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

    /// Copies the lanes `bits` of a packet; the others repeat the first of these.
    #[inline(always)]
    fn masked<S: Simd>(simd: S, rays: &RayQueue, hits: &[HitPacket], p: usize, bits: u32) -> Self {
        let mut copied = Self::whole(rays, hits, p);
        let (first, mask) = (bits.trailing_zeros() as usize, simd.mask(bits));
        let Self {
            direction: d,
            origin: o,
            t,
            u,
            v,
            primitive,
            ..
        } = &mut copied;
        for numbers in [
            &mut d.x, &mut d.y, &mut d.z, &mut o.x, &mut o.y, &mut o.z, t, u, v,
        ] {
            let repeated = simd.splat(numbers.as_array()[first % LANES]);
            *numbers = S::V8::select(mask, simd.load(numbers), repeated).to8();
        }
        let repeated = primitive[first % LANES];
        for (i, id) in primitive.iter_mut().enumerate() {
            if bits >> i & 1 == 0 {
                *id = repeated;
            }
        }
        copied
    }

    /// Gathers up to eight rays of any packets; the last one is repeated.
    #[inline(always)]
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
            gathered.direction.set(to, packet.direction.lane(from));
            gathered.origin.set(to, rays.rays.origin(p).lane(from));
            gathered.weight.as_mut_array()[to] = rays.weight(p).as_array()[from];
            gathered.t.as_mut_array()[to] = hits.t.as_array()[from];
            gathered.u.as_mut_array()[to] = hits.u.as_array()[from];
            gathered.v.as_mut_array()[to] = hits.v.as_array()[from];
            gathered.pixel[to] = rays.pixel(p)[from];
            gathered.primitive[to] = hits.primitive[from];
        }
        gathered
    }
}

const ALL_LANES: u32 = (1 << LANES) - 1;

/// Makes surface packets of the sorted hits, in the order of `by_material`.
#[inline(always)]
pub(super) fn gather<S: Simd>(
    simd: S,
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
                Hits8::masked(simd, rays, hits, packet as usize, bits)
            };
            push(simd, scene, &hits8, bits, &mut cache, surfaces);
        }
        for chunk in bucket.compacted.chunks(LANES) {
            let hits8 = Hits8::gather(rays, hits, chunk);
            let active = ALL_LANES >> (LANES - chunk.len());
            push(simd, scene, &hits8, active, &mut cache, surfaces);
        }
    }
}

/// Points and normals, before the normals are turned to the viewer.
struct Points<S: Simd> {
    point: Vec3Eight<S>,
    geometric: Vec3Eight<S>,
    normal: Vec3Eight<S>,
    magnitude: S::V8,
}

// Called twice, so not inlined; it therefore enters the level again.
#[inline(never)]
fn push<S: Simd>(
    simd: S,
    scene: &Scene,
    hits: &Hits8,
    active: u32,
    cache: &mut Option<CachedTriangle<S>>,
    surfaces: &mut Vec<SurfacePacket>,
) {
    simd.call(
        #[inline(always)]
        || {
            let points = points(simd, scene, hits, cache);
            let away = points
                .geometric
                .dot(simd.load3(&hits.direction))
                .gt(simd.splat(0.0));
            surfaces.push(SurfacePacket {
                active,
                from_behind: away.bits(),
                point: points.point.to8(),
                raised: 0,
                rise: F32x8::ZERO,
                geometric_normal: Vec3Lanes::select(away, -points.geometric, points.geometric).to8(),
                normal: Vec3Lanes::select(away, -points.normal, points.normal).to8(),
                direction: hits.direction,
                magnitude: points.magnitude.to8(),
                pixel: hits.pixel,
                weight: hits.weight,
            });
        },
    );
    // A pass of its own: scenes without smooth shadows keep their code.
    if scene.smooth_shadows()
        && let Some(surface) = surfaces.last_mut()
    {
        lift::raise(simd, scene, hits, surface);
    }
}

#[inline(always)]
fn points<S: Simd>(simd: S, scene: &Scene, hits: &Hits8, cache: &mut Option<CachedTriangle<S>>) -> Points<S> {
    let first = hits.primitive[0];
    if S::V8::equal_lanes(simd, &hits.primitive, first) == ALL_LANES {
        return match scene.primitive(PrimitiveId(first)) {
            Primitive::Triangle(i) => {
                let triangle = match cache {
                    Some(triangle) if triangle.triangle_i == i => triangle,
                    cache => cache.insert(CachedTriangle::new(simd, scene, i)),
                };
                triangles(simd, hits, &triangle.corners, &triangle.facet)
            }
            Primitive::Sphere(i) => {
                let spheres = scene.spheres();
                sphere(
                    simd,
                    hits,
                    simd.splat3(spheres.center(i)),
                    simd.splat(spheres.radius[i]),
                )
            }
            Primitive::Plane(i) => {
                let Plane { point, normal, .. } = scene.planes()[i];
                planes::plane(simd, hits, simd.splat3(point), simd.splat3(normal))
            }
        };
    }
    if scene.planes().is_empty() {
        finite(simd, scene, hits, &hits.primitive)
    } else {
        planes::with_planes(simd, scene, hits)
    }
}

/// Evaluates different triangles and spheres.
#[inline(always)]
fn finite<S: Simd>(simd: S, scene: &Scene, hits: &Hits8, primitive: &[u32; LANES]) -> Points<S> {
    let triangle_count = scene.triangles().corners.len() as u32;
    let mut sphere_bits = 0;
    for (lane, &id) in primitive.iter().enumerate() {
        sphere_bits |= u32::from(id >= triangle_count) << lane;
    }
    match sphere_bits {
        0 => distinct_triangles(simd, scene, hits, primitive),
        ALL_LANES => distinct_spheres(simd, scene, hits, primitive),
        _ => mixed(simd, scene, hits, primitive, sphere_bits),
    }
}

/// Returns the points of `a` in the lanes of `bits`, and those of `b` in the others.
#[inline(always)]
fn select<S: Simd>(simd: S, bits: u32, a: &Points<S>, b: &Points<S>) -> Points<S> {
    let mask = simd.mask(bits);
    Points {
        point: Vec3Lanes::select(mask, a.point, b.point),
        geometric: Vec3Lanes::select(mask, a.geometric, b.geometric),
        normal: Vec3Lanes::select(mask, a.normal, b.normal),
        magnitude: S::V8::select(mask, a.magnitude, b.magnitude),
    }
}

/// Triangles and spheres, the latter in the lanes of `sphere_bits`.
#[inline(always)]
fn mixed<S: Simd>(
    simd: S,
    scene: &Scene,
    hits: &Hits8,
    primitive: &[u32; LANES],
    sphere_bits: u32,
) -> Points<S> {
    // Lanes of the other kind compute on the first triangle or sphere.
    let (mut triangle_ids, mut sphere_ids) = (*primitive, *primitive);
    let first_triangle = primitive[sphere_bits.trailing_ones() as usize];
    let first_sphere = primitive[sphere_bits.trailing_zeros() as usize];
    for lane in 0..LANES {
        if sphere_bits >> lane & 1 == 1 {
            triangle_ids[lane] = first_triangle;
        } else {
            sphere_ids[lane] = first_sphere;
        }
    }
    let triangles = distinct_triangles(simd, scene, hits, &triangle_ids);
    let spheres = distinct_spheres(simd, scene, hits, &sphere_ids);
    select(simd, sphere_bits, &spheres, &triangles)
}

/// The vertices of eight triangles.
struct Corners<S: Simd> {
    position: [Vec3Eight<S>; 3],
    /// Vertex normals, if the scene has any.
    normal: Option<[Vec3Eight<S>; 3]>,
}

impl<S: Simd> Corners<S> {
    /// Broadcasts one triangle to all lanes.
    #[inline(always)]
    fn broadcast(simd: S, scene: &Scene, triangle_i: usize) -> Self {
        let normals = &scene.vertices().normals;
        let [a, b, c] = scene.triangle(triangle_i);
        let mut normal = None;
        if !normals.is_empty() {
            let [a, b, c] = scene.triangles().corners[triangle_i];
            normal = Some([
                simd.splat3(normals[a as usize]),
                simd.splat3(normals[b as usize]),
                simd.splat3(normals[c as usize]),
            ]);
        }
        Self {
            position: [simd.splat3(a), simd.splat3(b), simd.splat3(c)],
            normal,
        }
    }

    /// Gathers one triangle per lane.
    #[inline(always)]
    fn gather(simd: S, scene: &Scene, triangle_i: &[u32; LANES]) -> Self {
        let (vertices, triangles) = (scene.vertices(), scene.triangles());
        let (mut position, mut normal) = ([Vec3x8::ZERO; 3], [Vec3x8::ZERO; 3]);
        let has_normals = !vertices.normals.is_empty();
        for (lane, &i) in triangle_i.iter().enumerate() {
            let corners = triangles.corners[i as usize];
            for k in 0..3 {
                let at = corners[k] as usize;
                position[k].x.as_mut_array()[lane] = vertices.x[at];
                position[k].y.as_mut_array()[lane] = vertices.y[at];
                position[k].z.as_mut_array()[lane] = vertices.z[at];
                if has_normals {
                    normal[k].set(lane, vertices.normals[at]);
                }
            }
        }
        let [a, b, c] = &position;
        let position = [simd.load3(a), simd.load3(b), simd.load3(c)];
        let [a, b, c] = &normal;
        let normal = [simd.load3(a), simd.load3(b), simd.load3(c)];
        Self {
            position,
            normal: if has_normals { Some(normal) } else { None },
        }
    }
}

/// Values that depend only on the triangles, not on the hits.
struct Facet<S: Simd> {
    /// Unit normals.
    geometric: Vec3Eight<S>,
    magnitude: S::V8,
}

impl<S: Simd> Facet<S> {
    #[inline(always)]
    fn new(corners: &Corners<S>) -> Self {
        let [v0, v1, v2] = corners.position;
        let facet = (v1 - v0).cross(v2 - v0);
        Self {
            // Scaled first, so that squared normals of tiny or huge triangles stay in the range of f32.
            geometric: (facet * facet.max_abs().scale_to_one()).normalize(),
            magnitude: v0.max_abs().max(v1.max_abs()).max(v2.max_abs()),
        }
    }
}

/// The last triangle that all lanes of a packet hit: the next packet often hits it as well.
// Tuned: see docs/lab-notes.md#cached-triangle
struct CachedTriangle<S: Simd> {
    triangle_i: usize,
    corners: Corners<S>,
    facet: Facet<S>,
}

impl<S: Simd> CachedTriangle<S> {
    #[inline(always)]
    fn new(simd: S, scene: &Scene, triangle_i: usize) -> Self {
        let corners = Corners::broadcast(simd, scene, triangle_i);
        Self {
            triangle_i,
            facet: Facet::new(&corners),
            corners,
        }
    }
}

/// Evaluates a triangle per lane.
#[inline(always)]
fn distinct_triangles<S: Simd>(simd: S, scene: &Scene, hits: &Hits8, triangle_i: &[u32; LANES]) -> Points<S> {
    let corners = Corners::gather(simd, scene, triangle_i);
    triangles(simd, hits, &corners, &Facet::new(&corners))
}

#[inline(always)]
fn triangles<S: Simd>(simd: S, hits: &Hits8, corners: &Corners<S>, facet: &Facet<S>) -> Points<S> {
    let (u, v) = (simd.load(&hits.u), simd.load(&hits.v));
    let weights = [simd.splat(1.0) - u - v, u, v];
    let mut normal = facet.geometric;
    if let Some(normals) = corners.normal {
        let smooth = interpolated::<S>(normals, weights);
        let size = smooth.max_abs();
        let [n0, n1, n2] = normals;
        let usable = size.gt(simd.splat(0.0)) & !(is_zero(n0) | is_zero(n1) | is_zero(n2));
        let smooth = (smooth * size.scale_to_one()).normalize();
        normal = Vec3Lanes::select(usable, smooth, facet.geometric);
    }
    Points {
        point: interpolated::<S>(corners.position, weights),
        geometric: facet.geometric,
        normal,
        magnitude: facet.magnitude,
    }
}

#[inline(always)]
fn interpolated<S: Simd>([a, b, c]: [Vec3Eight<S>; 3], [w, u, v]: [S::V8; 3]) -> Vec3Eight<S> {
    b.mul_add(u, c.mul_add(v, a * w))
}

#[inline(always)]
fn is_zero<V: Lanes>(n: Vec3Lanes<V>) -> V::Mask {
    let zero = n.x.all(0.0);
    n.x.eq(zero) & n.y.eq(zero) & n.z.eq(zero)
}

/// Evaluates a sphere per lane.
#[inline(always)]
fn distinct_spheres<S: Simd>(simd: S, scene: &Scene, hits: &Hits8, id: &[u32; LANES]) -> Points<S> {
    let (spheres, first) = (scene.spheres(), scene.triangles().corners.len());
    let (mut center, mut radius) = (Vec3x8::ZERO, F32x8::ZERO);
    for (lane, &id) in id.iter().enumerate() {
        let i = id as usize - first;
        center.set(lane, spheres.center(i));
        radius.as_mut_array()[lane] = spheres.radius[i];
    }
    sphere(simd, hits, simd.load3(&center), simd.load(&radius))
}

#[inline(always)]
fn sphere<S: Simd>(simd: S, hits: &Hits8, center: Vec3Eight<S>, radius: S::V8) -> Points<S> {
    // Relative to the centre: far from the origin, a point has few bits left for its position on the sphere.
    let from_center = simd.load3(&hits.origin) - center;
    let outward = simd
        .load3(&hits.direction)
        .mul_add(simd.load(&hits.t), from_center)
        .normalize();
    Points {
        point: outward.mul_add(radius, center),
        geometric: outward,
        normal: outward,
        magnitude: center.max_abs() + radius,
    }
}
