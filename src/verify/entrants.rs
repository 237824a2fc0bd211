//! The ways of tracing that are held against brute force.

use super::Group;
use crate::{
    accel::{BinaryBvh, Bvh},
    ray::{Hit, HitPacket},
    reference::bvh::{self, Stack},
    scene::Scene,
    simd::{F32x8, LANES, pair},
    trace::{Method, Tracer, Widths},
};

/// What a ray came to.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// The nearest hit.
    pub hit: Hit,
    /// Whether anything was hit before the ray's end, asked for on its own.
    pub blocked: bool,
}

impl Found {
    /// The same, bit for bit.
    #[must_use]
    pub fn same(&self, other: &Self) -> bool {
        let bits = |hit: &Hit| [hit.t, hit.u, hit.v].map(f32::to_bits);
        bits(&self.hit) == bits(&other.hit)
            && self.hit.primitive == other.hit.primitive
            && self.blocked == other.blocked
    }
}

/// A way of tracing one scene.
pub trait Entrant {
    /// What it is called in results.
    fn name(&self) -> &'static str;
    /// Traces the rays of a group, in both ways; `found` holds one answer a ray afterwards.
    fn trace(&mut self, group: &Group, found: &mut Vec<Found>);
}

/// Makes the entrants for a scene.
pub type Entrants = dyn for<'a> Fn(&'a Scene, &'a Bvh) -> Vec<Box<dyn Entrant + 'a>> + Sync;

/// Every way of tracing that octray has on this CPU.
#[must_use]
pub fn entrants<'a>(scene: &'a Scene, bvh: &'a Bvh) -> Vec<Box<dyn Entrant + 'a>> {
    let with_tracer = |name, tracer| -> Box<dyn Entrant + 'a> {
        Box::new(Kernel {
            name,
            tracer,
            nodes_wait: false,
            hits: Vec::new(),
            blocked: Vec::new(),
        })
    };
    let kernel = |name, method| with_tracer(name, Tracer::with_method(bvh, method));
    let mut all: Vec<Box<dyn Entrant + 'a>> = vec![Box::new(Scalar {
        bvh: bvh.binary(scene),
        stack: Stack::default(),
    })];
    let held = |name, method, widths| {
        let mut tracer = Tracer::with_method(bvh, method);
        tracer.hold_to(widths);
        with_tracer(name, tracer)
    };
    if has_avx512() {
        all.push(kernel("adaptive, AVX-512", Method::Adaptive));
        all.push(held("adaptive, 16 lanes", Method::Adaptive, Widths::One));
        all.push(held("adaptive, 32 lanes", Method::Adaptive, Widths::Pair));
        all.push(kernel("single rays, AVX-512", Method::Single));
    } else {
        all.push(kernel("single rays", Method::Single));
    }
    all.push(kernel("adaptive, as compiled", Method::AdaptiveBaseline));
    if pair::IS_FAST {
        all.push(held("adaptive, 8 lanes", Method::AdaptiveBaseline, Widths::One));
    }
    all.push(kernel("packets", Method::Packet));
    all
}

#[cfg(target_arch = "x86_64")]
fn has_avx512() -> bool {
    crate::simd::avx512::is_available()
}

#[cfg(not(target_arch = "x86_64"))]
fn has_avx512() -> bool {
    false
}

/// The scalar baseline.
struct Scalar<'a> {
    bvh: &'a BinaryBvh,
    stack: Stack,
}

impl Entrant for Scalar<'_> {
    fn name(&self) -> &'static str {
        "scalar BVH"
    }

    fn trace(&mut self, group: &Group, found: &mut Vec<Found>) {
        found.clear();
        found.extend(group.rays.iter().map(|ray| Found {
            hit: bvh::closest_hit(self.bvh, &mut self.stack, ray),
            blocked: bvh::occluded(self.bvh, &mut self.stack, ray),
        }));
    }
}

/// A method of the tracer.
struct Kernel<'a> {
    name: &'static str,
    tracer: Tracer<'a>,
    /// Whether shadow rays let nodes wait.
    nodes_wait: bool,
    hits: Vec<HitPacket>,
    blocked: Vec<u8>,
}

impl Entrant for Kernel<'_> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn trace(&mut self, group: &Group, found: &mut Vec<Found>) {
        // Every other group as in trees that are larger than any here.
        self.nodes_wait = !self.nodes_wait;
        self.tracer.let_nodes_wait(self.nodes_wait);
        let (origins, packets) = (group.packets.origins(), group.packets.packets());
        self.hits.resize(packets.len(), HitPacket::miss(F32x8::ZERO));
        self.blocked.resize(packets.len(), 0);
        self.tracer.closest_hit(origins, packets, &mut self.hits);
        self.tracer.occluded(origins, packets, &mut self.blocked);
        found.clear();
        found.extend((0..group.rays.len()).map(|i| Found {
            hit: self.hits[i / LANES].hit(i % LANES),
            blocked: self.blocked[i / LANES] >> (i % LANES) & 1 == 1,
        }));
    }
}
