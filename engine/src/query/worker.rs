//! Many rays at a time, in packets through the [`Tracer`]; hits before `t_min` are replaced ray by ray.

use super::{
    Geometry, Rays,
    order::Order,
    rays::EightRays,
    sinks::{Any, Closest},
    unit::{UnitPacket, UnitRay, reported},
};
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::{Hit, HitPacket, Origins, PrimitiveId, RayPacket},
    simd::{EightLanes, LaneMask, Lanes, Simd, at_level},
    trace::{Tracer, visit},
};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::{cell::Cell, fmt};

/// Packets that are prepared, traced and reported at a time: they stay in the L2 cache.
// Tuned: see docs/lab-notes.md#varied-constants
const PACKETS: usize = 2048;

/// Rays per task.
const PIECE: usize = PACKETS * LANES;

/// The memory of a worker. A thread keeps it from call to call, because new memory costs as much as tracing.
#[derive(Debug, Default)]
struct Buffers {
    packets: Vec<RayPacket>,
    origins: Vec<Vec3x8>,
    /// Where rays begin, by packet, up to the last packet with a ray that does not begin at its origin.
    starts: Vec<[f32; LANES]>,
    lengths: Vec<[f64; LANES]>,
    /// The origin, if `origins` is empty.
    shared: Vec3,
    hits: Vec<HitPacket>,
    /// The instances of `hits`, if there are any and rays are sorted.
    instances: Vec<[u32; LANES]>,
    occluded: Vec<u8>,
    order: Order,
}

thread_local! {
    static BUFFERS: Cell<Option<Box<Buffers>>> = const { Cell::new(None) };
}

/// What rays are traced through.
pub trait Target: Sync + Sized {
    /// A closest hit. The default is a miss at infinity.
    type Hit: Copy + Default + Send;
    /// What coordinates are relative to.
    fn middle(&self) -> DVec3;
    fn tracer(&self) -> Tracer<'_>;
    /// The hit of one ray.
    fn closest(&self, ray: &UnitRay) -> Option<Self::Hit>;
    /// Whether one ray hits anything.
    fn blocks(&self, ray: &UnitRay) -> bool;
    /// Writes up to eight hits, as they are reported. `instances` is empty without any.
    fn put<S: Simd>(
        &self,
        simd: S,
        found: (&HitPacket, &[u32]),
        lengths: &[f64; LANES],
        hits: &mut [Self::Hit],
    );
    /// Finds the closest hits of up to [`PIECE`] rays. Here, so that it is compiled with the engine and not with its users, who
    /// may optimise less.
    fn closest_of_piece(worker: &mut Worker<'_, Self>, rays: Rays<'_>, hits: &mut [Self::Hit]);
    /// The same for occlusion.
    fn occluded_of_piece(worker: &mut Worker<'_, Self>, rays: Rays<'_>, occluded: &mut [bool]);
}

impl Target for Geometry {
    type Hit = Hit;

    fn middle(&self) -> DVec3 {
        self.middle()
    }

    fn tracer(&self) -> Tracer<'_> {
        Tracer::new(self.bvh()).at_level(self.level())
    }

    fn closest(&self, ray: &UnitRay) -> Option<Hit> {
        let mut closest = Closest::new(ray);
        visit(self.level(), self.bvh(), &ray.ray, &mut closest);
        closest.hit()
    }

    fn blocks(&self, ray: &UnitRay) -> bool {
        let mut any = Any::new(ray);
        visit(self.level(), self.bvh(), &ray.ray, &mut any);
        any.is_hit
    }

    #[inline(always)]
    fn put<S: Simd>(
        &self,
        simd: S,
        (found, _): (&HitPacket, &[u32]),
        lengths: &[f64; LANES],
        hits: &mut [Hit],
    ) {
        put(simd, found, lengths, hits);
    }

    fn closest_of_piece(worker: &mut Worker<'_, Self>, rays: Rays<'_>, hits: &mut [Hit]) {
        worker.closest_of_piece(rays, hits);
    }

    fn occluded_of_piece(worker: &mut Worker<'_, Self>, rays: Rays<'_>, occluded: &mut [bool]) {
        worker.occluded_of_piece(rays, occluded);
    }
}

/// Traces many rays on the calling thread, with memory that is reused from call to call. [`Geometry::closest_hits`],
/// [`Geometry::occluded_each`] and those of [`InstancedGeometry`](crate::InstancedGeometry) use all threads of rayon's pool
/// instead.
pub struct Worker<'a, G = Geometry> {
    geometry: &'a G,
    tracer: Tracer<'a>,
    buffers: Box<Buffers>,
}

/// Finds closest hits on the threads of the current rayon pool.
pub(super) fn closest_hits<G: Target>(geometry: &G, rays: Rays<'_>, hits: &mut [G::Hit]) {
    assert_eq!(rays.len(), hits.len(), "a hit for each ray");
    let pieces = hits.par_chunks_mut(PIECE).enumerate();
    pieces.for_each_init(
        || Worker::new(geometry),
        |worker, (piece, hits)| {
            let start = piece * PIECE;
            G::closest_of_piece(worker, rays.part(start..start + hits.len()), hits);
        },
    );
}

/// Tests rays for hits on the threads of the current rayon pool.
pub(super) fn occluded_each<G: Target>(geometry: &G, rays: Rays<'_>, occluded: &mut [bool]) {
    assert_eq!(rays.len(), occluded.len(), "an answer for each ray");
    let pieces = occluded.par_chunks_mut(PIECE).enumerate();
    pieces.for_each_init(
        || Worker::new(geometry),
        |worker, (piece, occluded)| {
            let start = piece * PIECE;
            G::occluded_of_piece(worker, rays.part(start..start + occluded.len()), occluded);
        },
    );
}

impl<G: fmt::Debug> fmt::Debug for Worker<'_, G> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Worker")
            .field("geometry", &self.geometry)
            .finish_non_exhaustive()
    }
}

impl<G> Drop for Worker<'_, G> {
    fn drop(&mut self) {
        let buffers = std::mem::take(&mut self.buffers);
        // Fails on a thread that is ending: the buffers are dropped.
        let _ = BUFFERS.try_with(|kept| kept.set(Some(buffers)));
    }
}

impl<'a, G: Target> Worker<'a, G> {
    pub(super) fn new(geometry: &'a G) -> Self {
        Self {
            geometry,
            tracer: geometry.tracer(),
            buffers: BUFFERS.take().unwrap_or_default(),
        }
    }

    /// Finds closest hits, as [`Geometry::closest_hits`] does.
    ///
    /// # Panics
    /// If rays and hits differ in number.
    pub fn closest_hits<'r>(&mut self, rays: impl Into<Rays<'r>>, hits: &mut [G::Hit]) {
        let rays = rays.into();
        assert_eq!(rays.len(), hits.len(), "a hit for each ray");
        for (piece, hits) in hits.chunks_mut(PIECE).enumerate() {
            let start = piece * PIECE;
            G::closest_of_piece(self, rays.part(start..start + hits.len()), hits);
        }
    }

    /// Tests each ray for a hit, as [`Geometry::occluded_each`] does.
    ///
    /// # Panics
    /// If rays and answers differ in number.
    pub fn occluded_each<'r>(&mut self, rays: impl Into<Rays<'r>>, occluded: &mut [bool]) {
        let rays = rays.into();
        assert_eq!(rays.len(), occluded.len(), "an answer for each ray");
        for (piece, occluded) in occluded.chunks_mut(PIECE).enumerate() {
            let start = piece * PIECE;
            G::occluded_of_piece(self, rays.part(start..start + occluded.len()), occluded);
        }
    }

    /// Makes packets of up to [`PIECE`] rays; of one origin, if all have the same.
    fn prepare(&mut self, rays: Rays<'_>) {
        self.buffers.packets.clear();
        self.buffers.origins.clear();
        self.buffers.starts.clear();
        self.buffers.lengths.clear();
        let (middle, is_shared) = (self.geometry.middle(), rays.share_origin());
        at_level!(self.tracer.level(), |simd| {
            let mut eight = EightRays::ZERO;
            for i in (0..rays.len()).step_by(LANES) {
                rays.eight(simd, i, &mut eight);
                let mut unit = UnitPacket::new(&eight, middle);
                for lane in rays.len().saturating_sub(i)..LANES {
                    unit.rays.t_max.as_mut_array()[lane] = 0.0;
                }
                self.buffers.packets.push(unit.rays);
                self.buffers.lengths.push(unit.length);
                if i == 0 {
                    self.buffers.shared = unit.origin.lane(0);
                }
                if !is_shared {
                    self.buffers.origins.push(unit.origin);
                }
                if unit.start != [0.0; LANES] {
                    // The rays of all packets before begin at 0.
                    self.buffers.starts.resize(i / LANES, [0.0; LANES]);
                    self.buffers.starts.push(unit.start);
                }
            }
        });
    }

    pub(super) fn closest_of_piece(&mut self, rays: Rays<'_>, hits: &mut [G::Hit]) {
        self.prepare(rays);
        self.buffers
            .hits
            .resize(self.buffers.packets.len(), HitPacket::miss(F32x8::ZERO));
        let origins = origins(&self.buffers.origins, self.buffers.shared);
        if matches!(origins, Origins::Shared(_))
            && self
                .buffers
                .order
                .sort(self.tracer.level(), &self.buffers.packets)
        {
            let order = &mut self.buffers.order;
            self.tracer.closest_hit(origins, &order.packets, &mut order.hits);
            order.put_back(&mut self.buffers.hits);
            order.put_back_instances(self.tracer.instances_hit(), &mut self.buffers.instances);
        } else {
            self.tracer
                .closest_hit(origins, &self.buffers.packets, &mut self.buffers.hits);
            self.buffers.instances.clear();
        }
        let instances = match &self.buffers.instances[..] {
            [] => self.tracer.instances_hit(),
            sorted => sorted,
        };
        at_level!(self.tracer.level(), |simd| {
            for (i, hits) in hits.chunks_mut(LANES).enumerate() {
                let found = (
                    &self.buffers.hits[i],
                    instances.get(i).map_or(&[][..], |eight| &eight[..]),
                );
                self.geometry.put(simd, found, &self.buffers.lengths[i], hits);
            }
        });
        for (i, start) in self.buffers.starts.iter().enumerate() {
            for lane in 0..LANES {
                if start[lane] > 0.0
                    && let Some(hit) = hits.get_mut(i * LANES + lane)
                    && self.buffers.hits[i].hit(lane).is_hit()
                    && self.buffers.hits[i].t.as_array()[lane] <= start[lane]
                {
                    let ray = self.ray(i, lane);
                    *hit = self.geometry.closest(&ray).unwrap_or_default();
                }
            }
        }
    }

    /// The ray in a lane of packet `i`, which does not begin at its origin.
    fn ray(&self, i: usize, lane: usize) -> UnitRay {
        let origin = match self.buffers.origins.get(i) {
            Some(origins) => origins.lane(lane),
            None => self.buffers.shared,
        };
        UnitRay {
            ray: self.buffers.packets[i].ray(lane, origin),
            start: self.buffers.starts[i][lane],
            length: self.buffers.lengths[i][lane],
        }
    }

    pub(super) fn occluded_of_piece(&mut self, rays: Rays<'_>, answers: &mut [bool]) {
        self.prepare(rays);
        self.buffers.occluded.resize(self.buffers.packets.len(), 0);
        let origins = origins(&self.buffers.origins, self.buffers.shared);
        self.tracer
            .occluded(origins, &self.buffers.packets, &mut self.buffers.occluded);
        for (i, answer) in answers.iter_mut().enumerate() {
            *answer = self.buffers.occluded[i / LANES] >> (i % LANES) & 1 != 0;
        }
        for (i, start) in self.buffers.starts.iter().enumerate() {
            for lane in 0..LANES {
                if start[lane] > 0.0
                    && let Some(answer) = answers.get_mut(i * LANES + lane)
                    && *answer
                {
                    *answer = self.geometry.blocks(&self.ray(i, lane));
                }
            }
        }
    }
}

fn origins(separate: &[Vec3x8], shared: Vec3) -> Origins<'_> {
    if separate.is_empty() {
        Origins::Shared(shared)
    } else {
        Origins::Separate(separate)
    }
}

/// Writes up to eight hits, as they are reported.
#[inline(always)]
pub(super) fn put<S: Simd>(simd: S, found: &HitPacket, lengths: &[f64; LANES], hits: &mut [Hit]) {
    let mut t = [0.0; LANES];
    for lane in 0..LANES {
        t[lane] = reported(found.t.as_array()[lane], lengths[lane]);
    }
    let infinite = simd.splat(f32::INFINITY);
    let missed = S::V8::equal_lanes(simd, &found.primitive, PrimitiveId::NONE.0);
    let t = S::V8::select(simd.mask(missed), infinite, simd.load(&F32x8::new(t)));
    let overflow = t.eq(infinite).bits() & !missed;
    let (u, v) = (simd.load(&found.u), simd.load(&found.v));
    let id = simd.load(&F32x8::new(bytemuck::must_cast(found.primitive)));
    let rows = S::V8::transposed([t, u, v, id, t, u, v, id]);
    for (hit, row) in hits.iter_mut().zip(rows) {
        let [t, u, v, id, ..] = row.to8().to_array();
        *hit = Hit {
            t,
            u,
            v,
            primitive: PrimitiveId(id.to_bits()),
        };
    }
    for (lane, hit) in hits.iter_mut().enumerate() {
        if overflow >> lane & 1 != 0 {
            *hit = Hit::miss(f32::INFINITY);
        }
    }
}
