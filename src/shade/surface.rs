//! From hits to surface packets: where the points are, and which way they face.

use super::queue::{HitQueue, RayIndex, RayQueue};
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
    fn new(rays: &RayQueue, hits: &[HitPacket], ray_i: &[RayIndex; LANES]) -> Self {
        let first = ray_i[0];
        if (first as usize).is_multiple_of(LANES)
            && ray_i.iter().zip(first..).all(|(&i, expected)| i == expected)
        {
            return Self::whole_packet(rays, hits, first as usize / LANES);
        }
        let place = ray_i.map(|i| (i as usize / LANES, i as usize % LANES));
        let lanes = |of: &dyn Fn(usize) -> F32x8| F32x8::from(place.map(|(p, lane)| of(p).as_array()[lane]));
        let vectors =
            |of: &dyn Fn(usize) -> Vec3x8| Vec3x8::from_lanes(place.map(|(p, lane)| of(p).lane(lane)));
        Self {
            direction: vectors(&|p| rays.packets[p].direction),
            origin: vectors(&|p| rays.packets[p].origin),
            pixel: place.map(|(p, lane)| rays.pixel[p][lane]),
            weight: lanes(&|p| rays.weight[p]),
            t: lanes(&|p| hits[p].t),
            u: lanes(&|p| hits[p].u),
            v: lanes(&|p| hits[p].v),
            primitive: place.map(|(p, lane)| hits[p].primitive[lane]),
        }
    }

    /// Most often all rays of a packet hit the same material: then nothing moves between lanes.
    fn whole_packet(rays: &RayQueue, hits: &[HitPacket], p: usize) -> Self {
        let (packet, hits) = (&rays.packets[p], &hits[p]);
        Self {
            direction: packet.direction,
            origin: packet.origin,
            pixel: rays.pixel[p],
            weight: rays.weight[p],
            t: hits.t,
            u: hits.u,
            v: hits.v,
            primitive: hits.primitive,
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
            let last = chunk.len() - 1;
            let ray_i = std::array::from_fn(|lane| chunk[lane.min(last)]);
            let hits8 = Hits8::new(rays, hits, &ray_i);
            surfaces.push(surface(scene, &hits8, (1 << chunk.len()) - 1));
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

fn surface(scene: &Scene, hits: &Hits8, active: u32) -> SurfacePacket {
    let shapes = hits.primitive.map(|id| scene.primitive(PrimitiveId(id)));
    let triangle_of = |shape: &Primitive| match *shape {
        Primitive::Triangle(i) => Some(i),
        Primitive::Sphere(_) => None,
    };
    let sphere_of = |shape: &Primitive| match *shape {
        Primitive::Triangle(_) => None,
        Primitive::Sphere(i) => Some(i),
    };
    // Lanes of the other kind compute on a neighbour's triangle or sphere.
    let triangle = shapes.iter().find_map(triangle_of);
    let sphere = shapes.iter().find_map(sphere_of);
    let on_triangles =
        triangle.map(|other| triangles(scene, hits, shapes.map(|s| triangle_of(&s).unwrap_or(other))));
    let on_spheres = sphere.map(|other| spheres(scene, hits, shapes.map(|s| sphere_of(&s).unwrap_or(other))));
    let facing = match (on_triangles, on_spheres) {
        (Some(facing), None) | (None, Some(facing)) => facing,
        (Some(flat), Some(round)) => {
            let bits = (0..LANES)
                .filter(|&i| sphere_of(&shapes[i]).is_some())
                .fold(0, |bits, i| bits | 1 << i);
            let round8 = Mask8::from_bits(bits);
            Facing {
                point: Vec3x8::select(round8, round.point, flat.point),
                geometric: Vec3x8::select(round8, round.geometric, flat.geometric),
                normal: Vec3x8::select(round8, round.normal, flat.normal),
                magnitude: round8.select(round.magnitude, flat.magnitude),
            }
        }
        // A primitive is a triangle or a sphere.
        (None, None) => unreachable!("eight shapes of no kind"),
    };
    let away = gt(facing.geometric.dot(hits.direction), splat(0.0));
    SurfacePacket {
        active,
        point: facing.point,
        geometric_normal: Vec3x8::select(away, -facing.geometric, facing.geometric),
        normal: Vec3x8::select(away, -facing.normal, facing.normal),
        direction: hits.direction,
        magnitude: facing.magnitude,
        pixel: hits.pixel,
        weight: hits.weight,
    }
}

fn triangles(scene: &Scene, hits: &Hits8, triangle_i: [usize; LANES]) -> Facing {
    let (vertices, triangles) = (scene.vertices(), scene.triangles());
    let index =
        [&triangles.v0, &triangles.v1, &triangles.v2].map(|column| triangle_i.map(|i| column[i] as usize));
    let [v0, v1, v2] = index.each_ref().map(|vertex_i| {
        let column = |of: &[f32]| F32x8::from(vertex_i.map(|i| of[i]));
        Vec3x8::new(column(&vertices.x), column(&vertices.y), column(&vertices.z))
    });
    let w = splat(1.0) - hits.u - hits.v;
    let interpolate = |a: Vec3x8, b: Vec3x8, c: Vec3x8| b.mul_add(hits.u, c.mul_add(hits.v, a * w));
    let facet = (v1 - v0).cross(v2 - v0);
    // Scaled first, so that squares of tiny or huge triangles' normals stay within f32.
    let size = facet.max_abs();
    let geometric = Vec3x8::new(facet.x / size, facet.y / size, facet.z / size).normalize();
    let mut normal = geometric;
    if !vertices.normals.is_empty() {
        let normals = index.map(|vertex_i| vertex_i.map(|i| vertices.normals[i]));
        let missing = |lane: usize| normals.iter().any(|n| n[lane] == Vec3::ZERO);
        let missing_bits = (0..LANES)
            .filter(|&lane| missing(lane))
            .fold(0, |bits, lane| bits | 1 << lane);
        let [n0, n1, n2] = normals.map(Vec3x8::from_lanes);
        let smooth = interpolate(n0, n1, n2);
        let size = smooth.max_abs();
        let usable = gt(size, splat(0.0)) & !Mask8::from_bits(missing_bits);
        let smooth = Vec3x8::new(smooth.x / size, smooth.y / size, smooth.z / size).normalize();
        normal = Vec3x8::select(usable, smooth, geometric);
    }
    let magnitude = max(max(v0.max_abs(), v1.max_abs()), v2.max_abs());
    Facing {
        point: interpolate(v0, v1, v2),
        geometric,
        normal,
        magnitude,
    }
}

fn spheres(scene: &Scene, hits: &Hits8, sphere_i: [usize; LANES]) -> Facing {
    let spheres = scene.spheres();
    let column = |of: &[f32]| F32x8::from(sphere_i.map(|i| of[i]));
    let center = Vec3x8::new(
        column(&spheres.center_x),
        column(&spheres.center_y),
        column(&spheres.center_z),
    );
    let radius = column(&spheres.radius);
    let hit = hits.direction.mul_add(hits.t, hits.origin);
    let outward = (hit - center).normalize();
    Facing {
        point: outward.mul_add(radius, center),
        geometric: outward,
        normal: outward,
        magnitude: center.max_abs() + radius,
    }
}
