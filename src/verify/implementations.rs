//! The tracing implementations that are compared with brute force.

use super::Group;
use crate::{
    accel::Bvh,
    lanes::{F32x8, LANES},
    ray::{HitPacket, SceneHit},
    reference::{bvh::OverScene, shade::Intersect},
    scene::Scene,
    simd::Level,
    trace::{Method, Tracer},
};

/// The results of one ray.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// The closest hit.
    pub hit: SceneHit,
    /// Whether the ray is occluded, from a query of its own.
    pub blocked: bool,
}

impl Found {
    /// Returns whether two results are equal, bit for bit.
    #[must_use]
    pub fn same(&self, other: &Self) -> bool {
        let bits = |hit: &SceneHit| [hit.t, hit.u, hit.v].map(f32::to_bits);
        bits(&self.hit) == bits(&other.hit)
            && self.hit.primitive == other.hit.primitive
            && self.hit.instance == other.hit.instance
            && self.blocked == other.blocked
    }
}

/// An implementation under test, set up for one scene.
pub trait Implementation {
    /// Returns the name to show in reports.
    fn name(&self) -> &str;
    /// Traces a group for closest hits and for occlusion. Replaces `found` by one result per ray.
    fn trace(&mut self, group: &Group, found: &mut Vec<Found>);
}

/// Sets up the implementations under test for a scene.
pub type Implementations = dyn for<'a> Fn(&'a Scene, &'a Bvh) -> Vec<Box<dyn Implementation + 'a>> + Sync;

/// Returns every implementation that octray has on this CPU: the scalar baseline, and each method at each level.
#[must_use]
pub fn implementations<'a>(scene: &'a Scene, bvh: &'a Bvh) -> Vec<Box<dyn Implementation + 'a>> {
    let mut all: Vec<Box<dyn Implementation + 'a>> = vec![Box::new(Scalar {
        scene: OverScene::new(scene, bvh, Level::current()),
    })];
    let methods = [
        ("render", Method::Adaptive),
        ("single rays", Method::Single),
        ("packets", Method::Packet),
    ];
    for level in Level::all() {
        for (name, method) in methods {
            all.push(Box::new(Kernel {
                name: format!("{name}, {level}"),
                tracer: Tracer::with_method(bvh, method).at_level(level).of_scene(scene),
                hits: Vec::new(),
                blocked: Vec::new(),
            }));
        }
    }
    all
}

/// The scalar baseline.
struct Scalar<'a> {
    scene: OverScene<'a>,
}

impl Implementation for Scalar<'_> {
    fn name(&self) -> &'static str {
        "scalar BVH"
    }

    fn trace(&mut self, group: &Group, found: &mut Vec<Found>) {
        found.clear();
        found.extend(group.rays.iter().map(|ray| Found {
            hit: self.scene.closest_hit(ray),
            blocked: self.scene.occluded(ray),
        }));
    }
}

/// A method of the tracer.
struct Kernel<'a> {
    name: String,
    tracer: Tracer<'a>,
    hits: Vec<HitPacket>,
    blocked: Vec<u8>,
}

impl Implementation for Kernel<'_> {
    fn name(&self) -> &str {
        &self.name
    }

    fn trace(&mut self, group: &Group, found: &mut Vec<Found>) {
        let (origins, packets) = (group.packets.origins(), group.packets.packets());
        self.hits.resize(packets.len(), HitPacket::miss(F32x8::ZERO));
        self.blocked.resize(packets.len(), 0);
        self.tracer.closest_hit(origins, packets, &mut self.hits);
        self.tracer.occluded(origins, packets, &mut self.blocked);
        found.clear();
        found.extend((0..group.rays.len()).map(|i| Found {
            hit: self.tracer.scene_hit(&self.hits, i / LANES, i % LANES),
            blocked: self.blocked[i / LANES] >> (i % LANES) & 1 == 1,
        }));
    }
}
