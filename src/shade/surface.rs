//! From hits to surface packets: where the points are, and which way they face.

use super::queue::{HitQueue, PacketLanes, RayIndex, RayQueue};
use crate::{
    ray::{HitPacket, PrimitiveId},
    scene::{Primitive, Scene},
    simd::{F32x8, LANES, Mask8, Vec3x8, eq, equal_lanes, from_lanes, gt, lane, max, scale_to_one, splat},
};

/// Eight points on surfaces of one material.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePacket {
    /// Lanes that hold a point (the others repeat one of them).
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
    /// Places of the pixels in [`TileColors`](super::TileColors).
    pub pixel: [u32; LANES],
    /// What the points' colours count.
    pub weight: F32x8,
}

/// Eight hits and the rays that hit, a lane a hit.
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
    /// A packet as it is.
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

    /// A packet of which only the lanes of `bits` count; the others repeat the first of them.
    fn some(rays: &RayQueue, hits: &[HitPacket], p: usize, bits: u32) -> Self {
        let whole = Self::whole(rays, hits, p);
        let (first, own) = (bits.trailing_zeros() as usize, Mask8::from_bits(bits));
        let repeat = |a: F32x8| own.select(a, splat(lane(&a, first)));
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

    /// Up to eight rays from anywhere; the last one is repeated.
    fn put_together(rays: &RayQueue, hits: &[HitPacket], ray_i: &[RayIndex]) -> Self {
        let mut together = Self {
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
            copy3(&mut together.direction, &packet.direction);
            copy3(&mut together.origin, &rays.rays.origin(p));
            copy(&mut together.weight, &rays.weight(p));
            copy(&mut together.t, &hits.t);
            copy(&mut together.u, &hits.u);
            copy(&mut together.v, &hits.v);
            together.pixel[to] = rays.pixel(p)[from];
            together.primitive[to] = hits.primitive[from];
        }
        together
    }
}

const ALL_LANES: u32 = (1 << LANES) - 1;

/// Makes surface packets of the filed hits, material by material, in the order of `by_material`.
pub fn gather(
    scene: &Scene,
    rays: &RayQueue,
    hits: &[HitPacket],
    by_material: &HitQueue,
    surfaces: &mut Vec<SurfacePacket>,
) {
    surfaces.clear();
    let mut last = None;
    for (_, bucket) in by_material.buckets() {
        for &PacketLanes { packet, bits } in &bucket.in_place {
            let hits8 = if bits == ALL_LANES {
                Hits8::whole(rays, hits, packet as usize)
            } else {
                Hits8::some(rays, hits, packet as usize, bits)
            };
            push(scene, &hits8, bits, &mut last, surfaces);
        }
        for chunk in bucket.loose.chunks(LANES) {
            let hits8 = Hits8::put_together(rays, hits, chunk);
            let active = ALL_LANES >> (LANES - chunk.len());
            push(scene, &hits8, active, &mut last, surfaces);
        }
    }
}

/// Where points are and which way their surfaces face, before that is turned to the viewer.
struct Facing {
    point: Vec3x8,
    geometric: Vec3x8,
    normal: Vec3x8,
    magnitude: F32x8,
}

fn push(
    scene: &Scene,
    hits: &Hits8,
    active: u32,
    last: &mut Option<OneTriangle>,
    surfaces: &mut Vec<SurfacePacket>,
) {
    let facing = facing(scene, hits, last);
    let away = gt(facing.geometric.dot(hits.direction), splat(0.0));
    surfaces.push(SurfacePacket {
        active,
        point: facing.point,
        geometric_normal: Vec3x8::select(away, -facing.geometric, facing.geometric),
        normal: Vec3x8::select(away, -facing.normal, facing.normal),
        direction: hits.direction,
        magnitude: facing.magnitude,
        pixel: hits.pixel,
        weight: hits.weight,
    });
}

#[inline(always)]
fn facing(scene: &Scene, hits: &Hits8, last: &mut Option<OneTriangle>) -> Facing {
    let one = hits.primitive[0];
    if equal_lanes(&hits.primitive, one) == ALL_LANES {
        return match scene.primitive(PrimitiveId(one)) {
            Primitive::Triangle(i) => {
                let of_one = match last {
                    Some(of_one) if of_one.triangle_i == i => of_one,
                    _ => last.insert(OneTriangle::new(scene, i)),
                };
                triangles(hits, &of_one.corners, &of_one.facet)
            }
            Primitive::Sphere(i) => {
                let spheres = scene.spheres();
                sphere(hits, Vec3x8::splat(spheres.center(i)), splat(spheres.radius[i]))
            }
        };
    }
    let triangle_count = scene.triangles().corners.len() as u32;
    let mut round = 0;
    for (lane, &id) in hits.primitive.iter().enumerate() {
        round |= u32::from(id >= triangle_count) << lane;
    }
    match round {
        0 => triangles_apart(hits, &Corners::of_eight(scene, &hits.primitive)),
        ALL_LANES => on_spheres(scene, hits, &hits.primitive),
        _ => mixed(scene, hits, round),
    }
}

/// Triangles and spheres, these in the lanes of `round`.
#[inline(never)]
fn mixed(scene: &Scene, hits: &Hits8, round: u32) -> Facing {
    // Lanes of the other kind compute on a neighbour's triangle or sphere.
    let (mut flat_id, mut round_id) = (hits.primitive, hits.primitive);
    let other_flat = hits.primitive[round.trailing_ones() as usize];
    let other_round = hits.primitive[round.trailing_zeros() as usize];
    for lane in 0..LANES {
        if round >> lane & 1 == 1 {
            flat_id[lane] = other_flat;
        } else {
            round_id[lane] = other_round;
        }
    }
    let flat = triangles_apart(hits, &Corners::of_eight(scene, &flat_id));
    let on_spheres = on_spheres(scene, hits, &round_id);
    let round8 = Mask8::from_bits(round);
    Facing {
        point: Vec3x8::select(round8, on_spheres.point, flat.point),
        geometric: Vec3x8::select(round8, on_spheres.geometric, flat.geometric),
        normal: Vec3x8::select(round8, on_spheres.normal, flat.normal),
        magnitude: round8.select(on_spheres.magnitude, flat.magnitude),
    }
}

/// What is stored at the corners of eight triangles.
struct Corners {
    position: [Vec3x8; 3],
    /// Normals, where the scene has any.
    normal: Option<[Vec3x8; 3]>,
}

impl Corners {
    /// The same triangle in all lanes.
    #[inline(always)]
    fn of_one(scene: &Scene, triangle_i: usize) -> Self {
        let (vertices, triangles) = (scene.vertices(), scene.triangles());
        let [a, b, c] = scene.triangle(triangle_i);
        let normal = |k: usize| Vec3x8::splat(vertices.normals[triangles.corners[triangle_i][k] as usize]);
        Self {
            position: [Vec3x8::splat(a), Vec3x8::splat(b), Vec3x8::splat(c)],
            normal: (!vertices.normals.is_empty()).then(|| [normal(0), normal(1), normal(2)]),
        }
    }

    /// A triangle a lane.
    #[inline(always)]
    fn of_eight(scene: &Scene, triangle_i: &[u32; LANES]) -> Self {
        let (vertices, triangles) = (scene.vertices(), scene.triangles());
        let (mut a, mut b, mut c) = ([0; LANES], [0; LANES], [0; LANES]);
        for (lane, &i) in triangle_i.iter().enumerate() {
            let corners = triangles.corners[i as usize];
            (a[lane], b[lane], c[lane]) = (corners[0] as usize, corners[1] as usize, corners[2] as usize);
        }
        let column = |of: &[f32], vertex_i: &[usize; LANES]| from_lanes(|lane| of[vertex_i[lane]]);
        let position = |vertex_i: &[usize; LANES]| {
            Vec3x8::new(
                column(&vertices.x, vertex_i),
                column(&vertices.y, vertex_i),
                column(&vertices.z, vertex_i),
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

/// What depends on triangles alone, not on where they are hit.
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
            // Scaled first, so that squares of tiny or huge triangles' normals stay within f32.
            geometric: (facet * scale_to_one(facet.max_abs())).normalize(),
            magnitude: max(max(v0.max_abs(), v1.max_abs()), v2.max_abs()),
        }
    }
}

/// A triangle that all lanes of a packet hit, kept for the next packet: neighbours often hit it as well. (Shading of the
/// course's scenes on Zen 5: 7 to 14 % less, frames 2 to 5 %.)
struct OneTriangle {
    triangle_i: usize,
    corners: Corners,
    facet: Facet,
}

impl OneTriangle {
    fn new(scene: &Scene, triangle_i: usize) -> Self {
        let corners = Corners::of_one(scene, triangle_i);
        Self {
            triangle_i,
            facet: Facet::new(&corners),
            corners,
        }
    }
}

/// Triangles of which each may be another.
#[inline(always)]
fn triangles_apart(hits: &Hits8, corners: &Corners) -> Facing {
    triangles(hits, corners, &Facet::new(corners))
}

#[inline(always)]
fn triangles(hits: &Hits8, corners: &Corners, &Facet { geometric, magnitude }: &Facet) -> Facing {
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
    Facing {
        point: interpolate(v0, v1, v2),
        geometric,
        normal,
        magnitude,
    }
}

fn on_spheres(scene: &Scene, hits: &Hits8, id: &[u32; LANES]) -> Facing {
    let (spheres, first) = (scene.spheres(), scene.triangles().corners.len());
    let column = |of: &[f32]| from_lanes(|lane| of[id[lane] as usize - first]);
    let center = Vec3x8::new(
        column(&spheres.center_x),
        column(&spheres.center_y),
        column(&spheres.center_z),
    );
    sphere(hits, center, column(&spheres.radius))
}

#[inline(always)]
fn sphere(hits: &Hits8, center: Vec3x8, radius: F32x8) -> Facing {
    // From the centre, not from the origin: far from the origin a point has few bits left for its place on the sphere.
    let outward = hits.direction.mul_add(hits.t, hits.origin - center).normalize();
    Facing {
        point: outward.mul_add(radius, center),
        geometric: outward,
        normal: outward,
        magnitude: center.max_abs() + radius,
    }
}
