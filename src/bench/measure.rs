//! Timing ways of tracing against each other on the same rays, interleaved, and checking that all agree.

use super::workload::{Kind, RaySet};
use crate::{
    accel::{BinaryBvh, Bvh},
    ray::{HitPacket, Origins, PrimitiveId, Ray, RayPacket},
    reference::bvh::{self, Stack},
    scene::Scene,
    simd::{F32x8, LANES},
    trace::{self, Tracer},
};
use std::time::Instant;

/// A way of tracing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The scalar reference over the binary BVH: the baseline, and the truth that the others are held to.
    Scalar,
    /// Packets of eight, each on its own.
    Packet,
    /// One ray against eight boxes at a time.
    Single,
    /// What the renderer uses: bundles, packets or single rays, as the rays want it.
    Render,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 4] = [Self::Scalar, Self::Packet, Self::Single, Self::Render];

    /// "scalar", "packet", "single" or "render".
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Packet => "packet",
            Self::Single => "single",
            Self::Render => "render",
        }
    }
}

/// One row of results.
#[derive(Clone, Copy, Debug)]
pub struct Measurement {
    /// What the rays are for.
    pub kind: Kind,
    /// How they were traced.
    pub method: Method,
    /// How many rays.
    pub rays: u64,
    /// How many hit (shadow rays: were blocked).
    pub hits: u64,
    /// Sum of the distances to all hits; 0 for shadow rays.
    pub t_sum: f64,
    /// Millions of rays a second, median of the repetitions.
    pub mrays_per_s: f64,
    /// (slowest - fastest) / median.
    pub spread: f64,
    /// Whether every hit is the scalar reference's, bit for bit.
    pub agree: bool,
}

/// Results of one method over a set, packets in the set's order.
#[derive(Debug, Default)]
pub struct Results {
    /// Camera and mirror rays: what they hit first.
    pub hits: Vec<HitPacket>,
    /// Shadow rays: a bit a lane, set where something blocks the ray.
    pub blocked: Vec<u8>,
}

impl Results {
    /// Whether two methods found the same, bit for bit.
    #[must_use]
    pub fn same(&self, other: &Self) -> bool {
        let bits = |h: &HitPacket| {
            let lanes = |v: F32x8| v.to_array().map(f32::to_bits);
            (lanes(h.t), lanes(h.u), lanes(h.v), h.primitive)
        };
        self.blocked == other.blocked
            && self.hits.len() == other.hits.len()
            && self.hits.iter().zip(&other.hits).all(|(a, b)| bits(a) == bits(b))
    }

    fn count(&self) -> (u64, f64) {
        let blocked = self
            .blocked
            .iter()
            .map(|b| u64::from(b.count_ones()))
            .sum::<u64>();
        let mut sum = (blocked, 0.0);
        for packet in &self.hits {
            for lane in 0..LANES {
                if packet.primitive[lane] != PrimitiveId::NONE.0 {
                    sum = (sum.0 + 1, sum.1 + f64::from(packet.t.as_array()[lane]));
                }
            }
        }
        sum
    }
}

/// Ray packets that are turned around at a time, for then they stay in the cache: as many as the renderer's tile of 128x16
/// pixels holds.
const BATCH: usize = 256;

/// Shadow rays from their light to the surface.
fn reversed(packet: &RayPacket) -> RayPacket {
    RayPacket {
        direction: -packet.direction,
        t_max: packet.t_max,
    }
}

fn run_scalar(binary: &BinaryBvh, set: &RaySet, results: &mut Results) {
    let mut stack = Stack::default();
    for (light, group) in &set.groups {
        for (packet_i, packet) in group.packets().iter().enumerate() {
            let rays: [Ray; LANES] = std::array::from_fn(|lane| match light {
                Some(light) => {
                    let ray = group.ray(packet_i, lane);
                    Ray {
                        origin: *light,
                        direction: -ray.direction,
                        ..ray
                    }
                }
                None => group.ray(packet_i, lane),
            });
            if set.kind == Kind::Shadow {
                let blocked =
                    |lane: &usize| rays[*lane].t_max > 0.0 && bvh::occluded(binary, &mut stack, &rays[*lane]);
                results
                    .blocked
                    .push((0..LANES).filter(blocked).fold(0, |bits, lane| bits | 1 << lane));
            } else {
                let mut hits = HitPacket::miss(packet.t_max);
                for (lane, ray) in rays.iter().enumerate().filter(|(_, ray)| ray.t_max > 0.0) {
                    hits.set_hit(lane, &bvh::closest_hit(binary, &mut stack, ray));
                }
                results.hits.push(hits);
            }
        }
    }
}

/// Memory for a set's results, once: those of the last time are written over.
fn make_room(set: &RaySet, results: &mut Results) {
    let packets = set.groups.iter().map(|(_, rays)| rays.packets().len()).sum();
    let (hits, blocked) = if set.kind == Kind::Shadow {
        (0, packets)
    } else {
        (packets, 0)
    };
    results.hits.resize(hits, HitPacket::miss(F32x8::ZERO));
    results.blocked.resize(blocked, 0);
}

fn run_simd(tracer: &mut Tracer<'_>, set: &RaySet, results: &mut Results) {
    make_room(set, results);
    let mut reversed_rays = Vec::with_capacity(BATCH);
    let mut start = 0;
    for (light, rays) in &set.groups {
        let packets = rays.packets();
        let group = start..start + packets.len();
        start = group.end;
        let Some(light) = light else {
            tracer.closest_hit(rays.origins(), packets, &mut results.hits[group]);
            continue;
        };
        let blocked = results.blocked[group].chunks_mut(BATCH);
        for (packets, blocked) in packets.chunks(BATCH).zip(blocked) {
            reversed_rays.clear();
            reversed_rays.extend(packets.iter().map(reversed));
            tracer.occluded(Origins::Shared(*light), &reversed_rays, blocked);
        }
    }
}

/// What the scalar reference finds: the truth that every method is held to.
#[must_use]
pub fn reference(scene: &Scene, bvh: &Bvh, set: &RaySet) -> Results {
    let mut results = Results::default();
    run_scalar(bvh.binary(scene), set, &mut results);
    results
}

/// Traces a set into `results`, whose memory is reused: from rays in memory to hit records in memory, with
/// everything that the tracer needs in between.
pub fn trace_set(tracer: &mut Tracer<'_>, set: &RaySet, results: &mut Results) {
    run_simd(tracer, set, results);
}

/// Times `methods` on the rays of `set`, `repeat` times each, in turn; on this thread alone. Everything that a
/// method needs between rays in memory and hit records in memory is timed, the reversal of shadow rays
/// included.
#[must_use]
pub fn compare(
    scene: &Scene,
    bvh: &Bvh,
    set: &RaySet,
    methods: &[Method],
    repeat: usize,
) -> Vec<Measurement> {
    let binary = bvh.binary(scene);
    let packets = set.groups.iter().map(|(_, rays)| rays.packets().len()).sum();
    let mut truth = Results::default();
    run_scalar(binary, set, &mut truth);

    let mut tracers = [
        trace::Method::Packet,
        trace::Method::Single,
        trace::Method::Adaptive,
    ]
    .map(|method| Tracer::with_method(bvh, method));
    let mut times = vec![Vec::with_capacity(repeat); methods.len()];
    let mut rows: Vec<(u64, f64, bool)> = vec![(0, 0.0, true); methods.len()];
    let mut results = Results {
        hits: Vec::with_capacity(packets),
        blocked: Vec::with_capacity(packets),
    };
    for _ in 0..repeat.max(1) {
        for (method_i, method) in methods.iter().enumerate() {
            let start = Instant::now();
            match method {
                Method::Scalar => {
                    results.hits.clear();
                    results.blocked.clear();
                    run_scalar(binary, set, &mut results);
                }
                Method::Packet => run_simd(&mut tracers[0], set, &mut results),
                Method::Single => run_simd(&mut tracers[1], set, &mut results),
                Method::Render => run_simd(&mut tracers[2], set, &mut results),
            }
            times[method_i].push(start.elapsed().as_secs_f64());
            let (hits, t_sum) = results.count();
            rows[method_i] = (hits, t_sum, rows[method_i].2 && results.same(&truth));
        }
    }
    methods
        .iter()
        .zip(times)
        .zip(rows)
        .map(|((&method, mut times), (hits, t_sum, agree))| {
            times.sort_by(f64::total_cmp);
            let median = times[times.len() / 2].max(1e-9);
            Measurement {
                kind: set.kind,
                method,
                rays: set.count,
                hits,
                t_sum,
                mrays_per_s: set.count as f64 / median / 1e6,
                spread: (times[times.len() - 1] - times[0]) / median,
                agree,
            }
        })
        .collect()
}
