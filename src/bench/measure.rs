//! Timing of the tracing methods on the same rays, alternating, with their results compared bit for bit.

use super::workload::{Kind, RaySet};
use crate::{
    accel::{BinaryBvh, Bvh},
    lanes::{F32x8, LANES, Vec3x8},
    ray::{HitPacket, Origins, PrimitiveId, Ray, RayPacket},
    reference::bvh::{self, Stack},
    scene::Scene,
    trace::{self, Tracer},
};
use std::time::Instant;

/// A tracing method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The scalar reference over the binary BVH, the baseline.
    Scalar,
    /// Packets of eight rays.
    Packet,
    /// Single rays against eight boxes at a time.
    Single,
    /// The renderer's choice of bundles or single rays.
    Render,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 4] = [Self::Scalar, Self::Packet, Self::Single, Self::Render];

    /// Returns "scalar", "packet", "single" or "render".
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

/// The measurement of one method on one kind of rays.
#[derive(Clone, Copy, Debug)]
pub struct Measurement {
    /// The kind of rays.
    pub kind: Kind,
    /// The tracing method.
    pub method: Method,
    /// Number of rays.
    pub rays: u64,
    /// Number of hits, or of occluded rays.
    pub hits: u64,
    /// Sum of t over all hits; 0 for rays that any hit stops.
    pub t_sum: f64,
    /// Millions of rays per second, median of the repetitions.
    pub mrays_per_s: f64,
    /// (slowest - fastest) / median.
    pub spread: f64,
    /// Whether all results equal those of the scalar reference, bit for bit.
    pub agree: bool,
}

/// The results of one method, packets in the order of the set.
#[derive(Debug, Default)]
pub struct Results {
    /// Closest hits of camera, mirror and diffuse rays.
    pub hits: Vec<HitPacket>,
    /// Occlusion of shadow and ambient occlusion rays, a bit per lane.
    pub blocked: Vec<u8>,
}

impl Results {
    /// Returns whether two results are equal, bit for bit.
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

/// Shadow packets that are reversed at a time, so that they stay in the cache: those of a tile of 128x16 pixels.
const BATCH: usize = 256;

/// Returns shadow rays from their light to the surface.
fn reversed(packet: &RayPacket) -> RayPacket {
    RayPacket {
        direction: Vec3x8 {
            x: negated(&packet.direction.x),
            y: negated(&packet.direction.y),
            z: negated(&packet.direction.z),
        },
        t_max: packet.t_max,
    }
}

#[inline(always)]
fn negated(numbers: &F32x8) -> F32x8 {
    let mut numbers = *numbers;
    for number in numbers.as_mut_array() {
        *number = -*number;
    }
    numbers
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
            if set.kind.is_any_hit() {
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

/// Traces a set into `results`, whose memory is reused: from rays in memory to hit records in memory, with
/// everything that the tracer needs in between.
pub fn trace_set(tracer: &mut Tracer<'_>, set: &RaySet, results: &mut Results) {
    let packets = set.groups.iter().map(|(_, rays)| rays.packets().len()).sum();
    let (hits, blocked) = if set.kind.is_any_hit() {
        (0, packets)
    } else {
        (packets, 0)
    };
    results.hits.resize(hits, HitPacket::miss(F32x8::ZERO));
    results.blocked.resize(blocked, 0);
    let mut reversed_rays = Vec::with_capacity(BATCH);
    let mut start = 0;
    for (light, rays) in &set.groups {
        let packets = rays.packets();
        let group = start..start + packets.len();
        start = group.end;
        let Some(light) = light else {
            if set.kind.is_any_hit() {
                tracer.occluded(rays.origins(), packets, &mut results.blocked[group]);
            } else {
                tracer.closest_hit(rays.origins(), packets, &mut results.hits[group]);
            }
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

/// Returns the results of the scalar reference, which those of every method must equal.
#[must_use]
pub fn reference(scene: &Scene, bvh: &Bvh, set: &RaySet) -> Results {
    let mut results = Results::default();
    run_scalar(bvh.binary(scene), set, &mut results);
    results
}

/// Times `methods` on the rays of `set`, `repeat` times each, alternating, on the calling thread.
///
/// The time includes everything from rays in memory to hit records in memory, also the reversal of shadow rays.
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
    let mut expected = Results::default();
    run_scalar(binary, set, &mut expected);

    let mut tracers = [
        trace::Method::Packet,
        trace::Method::Single,
        trace::Method::Adaptive,
    ]
    .map(|method| Tracer::with_method(bvh, method).with_instances(scene));
    let mut times = vec![Vec::new(); methods.len()];
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
                Method::Packet => trace_set(&mut tracers[0], set, &mut results),
                Method::Single => trace_set(&mut tracers[1], set, &mut results),
                Method::Render => trace_set(&mut tracers[2], set, &mut results),
            }
            times[method_i].push(start.elapsed().as_secs_f64());
            let (hits, t_sum) = results.count();
            rows[method_i] = (hits, t_sum, rows[method_i].2 && results.same(&expected));
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
