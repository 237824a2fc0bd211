//! Rays of the kinds that break ray tracers: along axes or almost, through vertices and edges, in the planes of boxes,
//! from surfaces, from far away, and with ends close to a hit.

use super::Random;
use crate::{
    lanes::LANES,
    ray::{Ray, RayPackets, T_MAX},
    scene::{Primitive, Scene},
    trace::BUNDLE,
};
use glam::Vec3;

/// Rays that are traced together.
#[derive(Clone, Debug)]
pub struct Group {
    /// Whether all rays start at the first one's origin.
    pub shared: bool,
    /// At least one ray.
    pub rays: Vec<Ray>,
    /// The same rays in packets. Lanes past the last ray repeat it with `t_max` 0.
    pub packets: RayPackets,
}

impl Group {
    /// Makes a group of `rays`.
    #[must_use]
    pub fn new(shared: bool, rays: Vec<Ray>) -> Self {
        let mut packets = RayPackets::default();
        packets.restart(rays.first().filter(|_| shared).map(|ray| ray.origin));
        for chunk in rays.chunks(LANES) {
            packets.push_rays(&std::array::from_fn(|lane| {
                let ray = chunk[lane.min(chunk.len() - 1)];
                let t_max = if lane < chunk.len() { ray.t_max } else { 0.0 };
                Ray { t_max, ..ray }
            }));
        }
        Self {
            shared,
            rays,
            packets,
        }
    }

    /// Makes up to `most` random rays: similar, with a shared origin, or unrelated; some have `t_max` 0, and some are
    /// [invalid](Ray::is_valid).
    /// Most groups fit into one bundle; some are larger than the number that is sorted together.
    pub fn random(random: &mut Random, scene: &Scene, most: usize) -> Self {
        let packets = match random.below(32) {
            0 => 10 * BUNDLE,
            1..=3 => 5 * BUNDLE / 2,
            _ => BUNDLE,
        };
        let count = 1 + random.index(most.min(packets * LANES));
        let first = ray(random, scene);
        let kind = random.below(4);
        let spread = random.pick(&[0.0, 1e-3, 0.1, 1.0]);
        let rays = (0..count).map(|_| {
            let other = ray(random, scene);
            let mut ray = match kind {
                0 => other,
                1 => {
                    let to = other.origin + other.direction - first.origin;
                    Ray {
                        origin: first.origin,
                        direction: to.normalize_or(Vec3::Z),
                        ..other
                    }
                }
                _ => {
                    let towards = first.direction + (other.direction - first.direction) * spread;
                    let origin = if kind == 2 {
                        first.origin
                    } else {
                        first.origin + (other.origin - first.origin) * (spread * 0.1)
                    };
                    Ray {
                        origin,
                        direction: towards.normalize_or(Vec3::Z),
                        t_max: other.t_max,
                    }
                }
            };
            if random.one_in(16) {
                ray.t_max = 0.0;
            }
            ray
        });
        let mut rays: Vec<Ray> = rays.collect();
        let shared = matches!(kind, 1 | 2);
        if random.one_in(4) {
            for _ in 0..=random.below(4) {
                let i = random.index(rays.len());
                // A shared origin is that of all rays.
                let origin = rays[i].origin;
                spoil(random, &mut rays[i]);
                if shared && rays[i].origin != origin {
                    let spoiled = rays[i].origin;
                    for ray in &mut rays {
                        ray.origin = spoiled;
                    }
                }
            }
        }
        Self::new(shared, rays)
    }
}

/// Makes a ray invalid.
fn spoil(random: &mut Random, ray: &mut Ray) {
    let number = random.pick(&[f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY]);
    let axis = random.index(3);
    match random.below(16) {
        0 => ray.origin[axis] = number,
        1..=8 => ray.direction[axis] = number,
        9..=12 => ray.t_max = number,
        _ => ray.direction = Vec3::ZERO,
    }
}

/// Returns a vertex, or a point of an edge, a triangle or a sphere; sometimes as an instance places it.
fn point_of(random: &mut Random, scene: &Scene) -> Vec3 {
    let point = point_of_arrays(random, scene);
    if !scene.instances().is_empty() && random.one_in(2) {
        return random.pick(scene.instances()).placement().point(point);
    }
    point
}

/// The same as the scene's arrays have it.
fn point_of_arrays(random: &mut Random, scene: &Scene) -> Vec3 {
    let triangles = scene.triangles().corners.len();
    let spheres = scene.spheres().radius.len();
    if triangles > 0 && (spheres == 0 || random.one_in(2)) {
        let [a, b, c] = scene.triangle(random.index(triangles));
        match random.below(4) {
            0 => a,
            1 => a + (b - a) * random.unit(),
            2 => (a + b) * 0.5,
            _ => {
                let (u, v) = (random.unit(), random.unit());
                a + (b - a) * u + (c - a) * (v * (1.0 - u))
            }
        }
    } else if spheres > 0 {
        let i = random.index(spheres);
        let direction = if random.one_in(2) {
            Vec3::X
        } else {
            random.in_cube().normalize_or(Vec3::Z)
        };
        scene.spheres().center(i) + direction * scene.spheres().radius[i]
    } else {
        random.in_cube()
    }
}

/// Returns the origin and direction of a ray in the plane of a face of a primitive's box.
fn along_a_face(random: &mut Random, scene: &Scene) -> (Vec3, Vec3) {
    let id = crate::ray::PrimitiveId(random.below(scene.primitive_count() as u32));
    let (lower, upper) = match scene.primitive(id) {
        Primitive::Triangle(i) => {
            let [a, b, c] = scene.triangle(i);
            (a.min(b).min(c), a.max(b).max(c))
        }
        Primitive::Sphere(i) => {
            let bounds = scene.sphere_bounds(i);
            (bounds.lower, bounds.upper)
        }
        Primitive::Plane(i) => (scene.planes()[i].point, scene.planes()[i].point),
    };
    let axis = random.index(3);
    let plane = if random.one_in(2) { lower } else { upper };
    let target = lower + (upper - lower) * Vec3::new(random.unit(), random.unit(), random.unit());
    let mut origin = target + random.in_cube() * (upper - lower).max_element() * 3.0;
    let mut direction = (target - origin).normalize_or(Vec3::X);
    origin[axis] = plane[axis];
    // Exactly in the plane, or off it by less than f32 resolves.
    direction[axis] = random.pick(&[0.0, -0.0, 1e-19, -1e-19, 1e-17, -1e-17, 1e-30]);
    let direction = direction.normalize_or(if axis == 0 { Vec3::Y } else { Vec3::X });
    (origin, direction)
}

/// Makes a random ray, usually aimed at a point of `scene`.
pub fn ray(random: &mut Random, scene: &Scene) -> Ray {
    let size = scene.bounds().diagonal().max(1e-6);
    let target = point_of(random, scene);
    let origin = match random.below(6) {
        0 => point_of(random, scene),
        1 => target + random.pick(&Vec3::AXES) * size * random.signed(),
        2 => target + random.in_cube() * size * 1e3,
        3 => {
            let mut origin = random.in_cube() * size;
            let axis = random.index(3);
            origin[axis] = target[axis];
            origin
        }
        _ => scene.bounds().lower - scene.origin() + random.in_cube() * size,
    };
    let mut direction = (target - origin).normalize_or(random.pick(&Vec3::AXES));
    let mut start = origin;
    match random.below(16) {
        0 | 1 => direction = random.pick(&Vec3::AXES) * random.pick(&[1.0, -1.0]),
        2 if scene.primitive_count() > 0 => (start, direction) = along_a_face(random, scene),
        _ => {}
    }
    let t_max = if random.one_in(3) {
        (target - origin).length()
    } else {
        T_MAX
    };
    Ray {
        origin: start,
        direction,
        t_max,
    }
}
