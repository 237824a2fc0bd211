//! The benchmark workload: camera, shadow, mirror, diffuse and ambient occlusion rays of a view, prepared before anything
//! is timed.

use crate::{
    accel::Bvh,
    lanes::{F32x8, LANES},
    math::{max_abs, scale_to_one},
    ray::{HitPacket, InstanceId, Ray, RayPacket, RayPackets, SceneHit, T_MAX},
    reference::shade,
    scene::{Camera, Primitive, Scene, for_each_packet},
    simd::{Portable, Simd},
    sobol::{hash, unit},
    trace::Tracer,
};
use glam::Vec3;
use std::f32::consts::TAU;

/// Offset of secondary rays off the surface, as a share of the scene's diagonal. (The renderer's is finer.)
const OFFSET: f32 = 1e-4;

/// Length of ambient occlusion rays, as a share of the scene's diagonal.
const REACH: f32 = 0.15;

/// The kind of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From the eye: closest hit.
    Camera,
    /// From camera hits to each light that they face: any hit before the light.
    Shadow,
    /// Mirrored at camera hits: closest hit.
    Mirror,
    /// From camera hits, a direction distributed by the cosine to the normal: closest hit.
    Diffuse,
    /// Ambient occlusion, the directions of [`Self::Diffuse`]: any hit within 0.15 of the scene's diagonal.
    Ao,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Camera, Self::Shadow, Self::Mirror, Self::Diffuse, Self::Ao];

    /// Returns "camera", "shadow", "mirror", "diffuse" or "ao".
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Shadow => "shadow",
            Self::Mirror => "mirror",
            Self::Diffuse => "diffuse",
            Self::Ao => "ao",
        }
    }

    /// Returns whether any hit will do, instead of the closest.
    #[must_use]
    pub fn is_any_hit(self) -> bool {
        matches!(self, Self::Shadow | Self::Ao)
    }
}

/// The rays of one kind, in packets of 4x2 pixels. Lanes without a ray have `t_max` 0; pairs of packets (4x4 pixels)
/// without any ray are left out. Shadow rays run from the surface to their light.
#[derive(Debug)]
pub struct RaySet {
    /// The kind of rays.
    pub kind: Kind,
    /// Groups of rays; a group of shadow rays comes with the position of its light.
    pub groups: Vec<(Option<Vec3>, RayPackets)>,
    /// Number of rays.
    pub count: u64,
}

impl RaySet {
    fn new(kind: Kind, groups: Vec<(Option<Vec3>, RayPackets)>) -> Self {
        let active = |p: &RayPacket| p.t_max.as_array().iter().filter(|&&t| t > 0.0).count() as u64;
        let count = groups
            .iter()
            .flat_map(|(_, rays)| rays.packets())
            .map(active)
            .sum();
        Self { kind, groups, count }
    }
}

/// The rays of one view of a scene.
#[derive(Debug)]
pub struct Workload {
    /// One set per kind, in the order of [`Kind::ALL`].
    pub sets: [RaySet; 5],
}

impl Workload {
    /// Prepares the rays of a picture of `width` x `height` pixels.
    #[must_use]
    pub fn new(scene: &Scene, bvh: &Bvh, camera: &Camera, width: u32, height: u32) -> Self {
        let camera_rays = camera_packets(scene, camera, width, height);
        let mut hits = vec![HitPacket::miss(F32x8::ZERO); camera_rays.packets().len()];
        let mut tracer = Tracer::new(bvh).with_instances(scene);
        tracer.closest_hit(camera_rays.origins(), camera_rays.packets(), &mut hits);
        let diagonal = scene.bounds().diagonal();
        let secondary = |ray_from: &dyn Fn(&Surface) -> Option<Ray>| {
            secondary((scene, &tracer), &camera_rays, &hits, diagonal * OFFSET, ray_from)
        };
        let lights = scene.lights().iter().filter_map(|light| light.shape.position());
        let shadow = lights
            .map(|light| (Some(light), secondary(&|surface| surface.towards(light))))
            .collect();
        let [mirror, diffuse, ao] = [
            secondary(&|surface| Some(surface.mirrored())),
            secondary(&|surface| Some(surface.scattered(T_MAX))),
            secondary(&|surface| Some(surface.scattered(diagonal * REACH))),
        ];
        Self {
            sets: [
                RaySet::new(Kind::Camera, vec![(None, camera_rays)]),
                RaySet::new(Kind::Shadow, shadow),
                RaySet::new(Kind::Mirror, vec![(None, mirror)]),
                RaySet::new(Kind::Diffuse, vec![(None, diffuse)]),
                RaySet::new(Kind::Ao, vec![(None, ao)]),
            ],
        }
    }
}

/// What a camera ray has hit.
struct Surface {
    /// The camera ray's direction.
    direction: Vec3,
    /// The hit point, moved off the surface.
    point: Vec3,
    /// The geometric normal on the viewer's side.
    normal: Vec3,
    /// The camera ray's number in the picture.
    pixel: u32,
}

impl Surface {
    /// Returns the shadow ray to a light, if the surface faces it.
    fn towards(&self, light: Vec3) -> Option<Ray> {
        let to_light = light - self.point;
        let distance = Portable.dot(to_light, to_light).sqrt();
        let faces = Portable.dot(self.normal, to_light) > 0.0;
        faces.then(|| Ray {
            origin: self.point,
            direction: to_light / distance,
            t_max: distance,
        })
    }

    fn mirrored(&self) -> Ray {
        let along = Portable.dot(self.direction, self.normal);
        let direction = Portable.mul_add3(self.normal, -2.0 * along, self.direction);
        Ray::new(self.point, Portable.normalize(direction))
    }

    /// Returns a ray whose direction is drawn by a hash of the pixel, distributed by the cosine to the normal.
    fn scattered(&self, t_max: f32) -> Ray {
        let across = unit(hash(self.pixel));
        let around = unit(hash(self.pixel ^ 0x5bd1_e995));
        let (sin, cos) = libm::sincosf(TAU * around);
        let (u, v) = self.normal.any_orthonormal_pair();
        let direction = (u * cos + v * sin) * across.sqrt() + self.normal * (1.0 - across).sqrt();
        Ray {
            t_max,
            ..Ray::new(self.point, Portable.normalize(direction))
        }
    }
}

/// Returns the camera rays of a picture, in the order of [`for_each_packet`].
#[must_use]
pub fn camera_packets(scene: &Scene, camera: &Camera, width: u32, height: u32) -> RayPackets {
    let pixel_rays = camera.without_lens().pixel_rays(scene, width, height, 1);
    let mut packets = RayPackets::default();
    packets.restart(pixel_rays.shared_origin());
    packets.reserve((width.div_ceil(4) * height.div_ceil(2)) as usize);
    for_each_packet(width, height, |[x, y]| {
        let inside = |lane: usize| x + lane as u32 % 4 < width && y + lane as u32 / 4 < height;
        packets.push_rays(&std::array::from_fn(|lane| {
            let (column, row) = (lane as u32 % 4, lane as u32 / 4);
            Ray {
                t_max: if inside(lane) { T_MAX } else { 0.0 },
                ..pixel_rays.ray(x + column, y + row, [0, 0])
            }
        }));
    });
    packets
}

/// Makes a packet for each camera packet, of the rays that `ray_from` makes of the surfaces hit. Lanes without a ray get
/// a neighbour's direction.
fn secondary(
    (scene, tracer): (&Scene, &Tracer<'_>),
    camera_rays: &RayPackets,
    hits: &[HitPacket],
    offset: f32,
    ray_from: &dyn Fn(&Surface) -> Option<Ray>,
) -> RayPackets {
    let mut neighbour = Ray {
        origin: Vec3::ZERO,
        direction: Vec3::Z,
        t_max: 0.0,
    };
    let mut packets = Vec::with_capacity(hits.len());
    for packet_i in 0..hits.len() {
        let rays: [Option<Ray>; LANES] = std::array::from_fn(|lane| {
            let ray = camera_rays.ray(packet_i, lane);
            let hit = tracer.scene_hit(hits, packet_i, lane);
            if !hit.is_hit() {
                return None;
            }
            let normal = geometric_normal(scene, &ray, &hit);
            ray_from(&Surface {
                direction: ray.direction,
                point: Portable.mul_add3(ray.direction, hit.t, ray.origin) + normal * offset,
                normal,
                pixel: (packet_i * LANES + lane) as u32,
            })
        });
        if let Some(ray) = rays.iter().flatten().next() {
            neighbour = Ray { t_max: 0.0, ..*ray };
        }
        packets.push(rays.map(|ray| ray.unwrap_or(neighbour)));
    }
    let holds_ray = |rays: &[Ray; LANES]| rays.iter().any(|ray| ray.t_max > 0.0);
    let mut kept = RayPackets::default();
    for pair in packets.chunks(2).filter(|pair| pair.iter().any(holds_ray)) {
        for rays in pair {
            kept.push_rays(rays);
        }
    }
    kept
}

fn geometric_normal(scene: &Scene, ray: &Ray, hit: &SceneHit) -> Vec3 {
    if hit.instance != InstanceId::NONE {
        return shade::geometric_normal(scene, ray, hit);
    }
    let normal = match scene.primitive(hit.primitive) {
        Primitive::Triangle(i) => {
            let [v0, v1, v2] = scene.triangle(i);
            let facet = Portable.cross(v1 - v0, v2 - v0);
            Portable.normalize(facet * scale_to_one(max_abs(facet)))
        }
        Primitive::Plane(i) => scene.planes()[i].normal,
        Primitive::Sphere(i) => Portable
            .normalize(Portable.mul_add3(ray.direction, hit.t, ray.origin) - scene.spheres().center(i)),
    };
    if Portable.dot(normal, ray.direction) > 0.0 {
        -normal
    } else {
        normal
    }
}
