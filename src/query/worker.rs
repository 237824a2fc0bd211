//! Many rays at a time: packets of them go through the [`Tracer`]; what it cannot tell alone is visited ray by ray.

use super::{
    Geometry, Rays,
    rays::EightRays,
    sinks::{Any, Closest},
    unit::{UnitPacket, reported},
};
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::{Hit, HitPacket, Origins, RayPacket},
    simd::at_level,
    trace::{Tracer, visit},
};

/// Packets that are prepared, traced and told at a time: they stay in the second-level cache.
const PACKETS: usize = 512;

/// Rays that are given to one thread at a time.
pub(super) const PIECE: usize = PACKETS * LANES;

/// Traces many rays on the thread that calls, with memory that is kept from call to call. [`Geometry::closest_hits`] and
/// [`Geometry::occluded_each`] use all threads of rayon's pool instead.
#[derive(Debug)]
pub struct Worker<'a> {
    geometry: &'a Geometry,
    tracer: Tracer<'a>,
    packets: Vec<RayPacket>,
    origins: Vec<Vec3x8>,
    units: Vec<UnitPacket>,
    hits: Vec<HitPacket>,
    occluded: Vec<u8>,
}

impl<'a> Worker<'a> {
    pub(super) fn new(geometry: &'a Geometry) -> Self {
        Self {
            geometry,
            tracer: Tracer::new(geometry.bvh()).at_level(geometry.level()),
            packets: Vec::new(),
            origins: Vec::new(),
            units: Vec::new(),
            hits: Vec::new(),
            occluded: Vec::new(),
        }
    }

    /// Finds what [`Geometry::closest_hits`] finds.
    ///
    /// # Panics
    /// If rays and hits differ in number.
    pub fn closest_hits<'r>(&mut self, rays: impl Into<Rays<'r>>, hits: &mut [Hit]) {
        let rays = rays.into();
        assert_eq!(rays.len(), hits.len(), "a hit for each ray");
        let is_shared = rays.share_origin();
        for (piece, hits) in hits.chunks_mut(PIECE).enumerate() {
            let start = piece * PIECE;
            self.closest_of_piece(rays.part(start..start + hits.len()), is_shared, hits);
        }
    }

    /// Finds what [`Geometry::occluded_each`] finds.
    ///
    /// # Panics
    /// If rays and answers differ in number.
    pub fn occluded_each<'r>(&mut self, rays: impl Into<Rays<'r>>, occluded: &mut [bool]) {
        let rays = rays.into();
        assert_eq!(rays.len(), occluded.len(), "an answer for each ray");
        let is_shared = rays.share_origin();
        for (piece, occluded) in occluded.chunks_mut(PIECE).enumerate() {
            let start = piece * PIECE;
            self.occluded_of_piece(rays.part(start..start + occluded.len()), is_shared, occluded);
        }
    }

    /// Makes packets of up to [`PIECE`] rays.
    fn prepare(&mut self, rays: Rays<'_>, is_shared: bool) {
        self.packets.clear();
        self.origins.clear();
        self.units.clear();
        let middle = self.geometry.middle();
        at_level!(self.tracer.level(), |_simd| {
            let mut eight = EightRays::ZERO;
            for i in (0..rays.len()).step_by(LANES) {
                rays.eight(i, &mut eight);
                let unit = UnitPacket::new(&eight, middle);
                let mut packet = unit.rays;
                for lane in rays.len().saturating_sub(i)..LANES {
                    packet.t_max.as_mut_array()[lane] = 0.0;
                }
                self.packets.push(packet);
                if !is_shared {
                    self.origins.push(unit.origin);
                }
                self.units.push(unit);
            }
        });
    }

    fn origins<'o>(origins: &'o [Vec3x8], units: &[UnitPacket]) -> Origins<'o> {
        match units.first() {
            Some(unit) if origins.is_empty() => Origins::Shared(unit.origin.lane(0)),
            _ => Origins::Separate(origins),
        }
    }

    pub(super) fn closest_of_piece(&mut self, rays: Rays<'_>, is_shared: bool, hits: &mut [Hit]) {
        self.prepare(rays, is_shared);
        let Self {
            geometry,
            tracer,
            packets,
            origins,
            units,
            hits: found,
            ..
        } = self;
        found.resize(packets.len(), HitPacket::miss(F32x8::ZERO));
        tracer.closest_hit(Self::origins(origins, units), packets, found);
        at_level!(tracer.level(), |_simd| {
            for ((hits, found), unit) in hits.chunks_mut(LANES).zip(&*found).zip(&*units) {
                let mut t = [0.0; LANES];
                for lane in 0..LANES {
                    t[lane] = reported(found.t.as_array()[lane], unit.length[lane]);
                }
                for (lane, hit) in hits.iter_mut().enumerate() {
                    *hit = Hit {
                        t: t[lane],
                        ..found.hit(lane)
                    };
                    if !hit.is_hit() || hit.t == f32::INFINITY {
                        *hit = Hit::miss(f32::INFINITY);
                    }
                }
            }
        });
        for ((hits, found), unit) in hits.chunks_mut(LANES).zip(&*found).zip(&*units) {
            if unit.start == [0.0; LANES] {
                continue;
            }
            for (lane, hit) in hits.iter_mut().enumerate() {
                if hit.is_hit() && found.t.as_array()[lane] <= unit.start[lane] {
                    let ray = unit.ray(lane);
                    let mut closest = Closest::new(&ray);
                    visit(geometry.level(), geometry.bvh(), &ray.ray, &mut closest);
                    *hit = closest.hit().unwrap_or(Hit::miss(f32::INFINITY));
                }
            }
        }
    }

    pub(super) fn occluded_of_piece(&mut self, rays: Rays<'_>, is_shared: bool, answers: &mut [bool]) {
        self.prepare(rays, is_shared);
        let Self {
            geometry,
            tracer,
            packets,
            origins,
            units,
            occluded,
            ..
        } = self;
        occluded.resize(packets.len(), 0);
        tracer.occluded(Self::origins(origins, units), packets, occluded);
        for ((answers, bits), unit) in answers.chunks_mut(LANES).zip(&*occluded).zip(&*units) {
            for (lane, answer) in answers.iter_mut().enumerate() {
                *answer = bits >> lane & 1 != 0;
                if *answer && unit.start[lane] > 0.0 {
                    let ray = unit.ray(lane);
                    let mut any = Any::new(&ray);
                    visit(geometry.level(), geometry.bvh(), &ray.ray, &mut any);
                    *answer = any.is_hit;
                }
            }
        }
    }
}
