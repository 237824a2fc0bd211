//! The sinks of visits, in a geometry or in instances: the closest hit, any hit, all hits, or crossings.

use super::{
    InstancedHit,
    crossings::{self, Crossing},
    unit::{UnitRay, last_reported_as, reported},
};
use crate::{
    ray::{Hit, InstanceId, PrimitiveId},
    trace::{Found, FoundThere, HitSink, InstanceSink},
};
use glam::Vec3;
use std::{cmp::Ordering, collections::BinaryHeap};

/// A hit as it is reported.
fn hit_of(found: &Found, length: f64) -> Hit {
    Hit {
        t: reported(found.t, length),
        ..found.hit()
    }
}

/// The closest hit behind the beginning; of equally near ones, the one with the lowest id.
pub(super) struct Closest {
    best: Found,
    start: f32,
    length: f64,
}

impl Closest {
    pub(super) fn new(ray: &UnitRay) -> Self {
        Self {
            best: Found {
                t: ray.ray.t_max,
                primitive: PrimitiveId::NONE,
                weights: [0.0; 3],
            },
            start: ray.start,
            length: ray.length,
        }
    }

    pub(super) fn hit(&self) -> Option<Hit> {
        let is_hit = self.best.primitive != PrimitiveId::NONE;
        let hit = is_hit.then(|| hit_of(&self.best, self.length));
        hit.filter(|hit| hit.t < f32::INFINITY)
    }
}

impl HitSink for Closest {
    #[inline(always)]
    fn end(&self) -> f32 {
        self.best.t
    }
    #[inline(always)]
    fn take(&mut self, found: Found) {
        let best = Hit {
            primitive: self.best.primitive,
            ..Hit::miss(self.best.t)
        };
        if found.t > self.start && best.loses_to(found.t, found.primitive) {
            self.best = found;
        }
    }
}

/// The closest hit in instances; of equally near ones, that in the first instance.
pub(super) struct ClosestThere {
    /// In the prototype's space.
    best: Hit,
    instance: InstanceId,
    distance: f32,
    start: f32,
    length: f64,
}

impl ClosestThere {
    pub(super) fn new(ray: &UnitRay) -> Self {
        Self {
            best: Hit::default(),
            instance: InstanceId::NONE,
            distance: ray.ray.t_max,
            start: ray.start,
            length: ray.length,
        }
    }

    /// The hit, with the scene's ids.
    pub(super) fn hit(&self) -> Option<InstancedHit> {
        let t = reported(self.distance, self.length);
        let is_hit = self.best.is_hit() && t < f32::INFINITY;
        is_hit.then(|| InstancedHit::new(Hit { t, ..self.best }, self.instance))
    }
}

impl InstanceSink for ClosestThere {
    #[inline(always)]
    fn end(&self) -> f32 {
        self.distance
    }
    #[inline(always)]
    fn take(&mut self, there: &FoundThere<'_>) {
        let wins_tie = match self.instance {
            InstanceId::NONE => false,
            instance if instance == there.instance => {
                self.best.loses_to(there.found.t, there.found.primitive)
            }
            instance => there.instance < instance,
        };
        let is_nearer = there.distance < self.distance || there.distance == self.distance && wins_tie;
        if there.distance > self.start && is_nearer {
            self.best = there.found.hit();
            (self.instance, self.distance) = (there.instance, there.distance);
        }
    }
}

/// Whether there is a hit.
pub(super) struct Any {
    start: f32,
    end: f32,
    pub is_hit: bool,
}

impl Any {
    pub(super) fn new(ray: &UnitRay) -> Self {
        Self {
            start: ray.start,
            end: ray.ray.t_max,
            is_hit: false,
        }
    }
}

impl HitSink for Any {
    const ANY: bool = true;

    #[inline(always)]
    fn end(&self) -> f32 {
        // Entries are never negative.
        if self.is_hit { -1.0 } else { self.end }
    }
    #[inline(always)]
    fn take(&mut self, found: Found) {
        self.is_hit |= found.t > self.start && found.t < self.end;
    }
}

impl InstanceSink for Any {
    const ANY: bool = true;

    #[inline(always)]
    fn end(&self) -> f32 {
        HitSink::end(self)
    }
    #[inline(always)]
    fn take(&mut self, there: &FoundThere<'_>) {
        self.is_hit |= there.distance > self.start && there.distance < self.end;
    }
}

/// A hit that is reported, in order of t, then ids.
pub(super) trait Reported: Copy {
    fn t(&self) -> f32;
    fn in_order(&self, other: &Self) -> Ordering;
}

impl Reported for Hit {
    fn t(&self) -> f32 {
        self.t
    }
    fn in_order(&self, other: &Self) -> Ordering {
        in_order(self, other)
    }
}

impl Reported for InstancedHit {
    fn t(&self) -> f32 {
        self.t
    }
    fn in_order(&self, other: &Self) -> Ordering {
        let ids = |hit: &Self| (hit.instance, hit.primitive);
        self.t
            .total_cmp(&other.t)
            .then_with(|| ids(self).cmp(&ids(other)))
    }
}

#[derive(Clone, Copy, Debug)]
struct Ordered<H>(H);

impl<H: Reported> PartialEq for Ordered<H> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl<H: Reported> Eq for Ordered<H> {}

impl<H: Reported> Ord for Ordered<H> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.in_order(&other.0)
    }
}

impl<H: Reported> PartialOrd for Ordered<H> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The order of reported hits: by t, then id.
#[doc(hidden)]
pub fn in_order(a: &Hit, b: &Hit) -> Ordering {
    a.t.total_cmp(&b.t).then(a.primitive.cmp(&b.primitive))
}

/// With a limit of this many hits or more, hardly any ray meets it.
// Tuned: see docs/lab-notes.md#all-hits
const UNORDERED: usize = 16;

/// All hits, or the nearest ones up to a limit.
pub(super) struct All<'a, H = Hit> {
    ray: UnitRay,
    limit: usize,
    /// Primitives that the hierarchy left out, since they equal an earlier one, after it: in order.
    repeats: &'a [[PrimitiveId; 2]],
    /// Those without a limit.
    hits: Vec<H>,
    /// With a limit, the nearest ones, the farthest on top.
    nearest: BinaryHeap<Ordered<H>>,
    end: f32,
}

impl<'a, H: Reported> All<'a, H> {
    pub(super) fn new(
        ray: UnitRay,
        limit: Option<usize>,
        repeats: &'a [[PrimitiveId; 2]],
        hits: Vec<H>,
    ) -> Self {
        Self {
            ray,
            limit: limit.unwrap_or(usize::MAX),
            repeats,
            hits,
            nearest: BinaryHeap::new(),
            end: if limit == Some(0) { -1.0 } else { ray.ray.t_max },
        }
    }

    /// The hits from `first` on are those of this ray, in order.
    pub(super) fn into_hits(mut self, first: usize) -> Vec<H> {
        self.hits.extend(self.nearest.iter().map(|ordered| ordered.0));
        self.hits[first..].sort_unstable_by(H::in_order);
        self.hits
    }

    fn keep(&mut self, hit: H) {
        if hit.t() == f32::INFINITY {
            return;
        }
        if self.limit == usize::MAX {
            self.hits.push(hit);
            return;
        }
        if self.nearest.len() < self.limit {
            self.nearest.push(Ordered(hit));
        } else if let Some(mut farthest) = self.nearest.peek_mut()
            && Ordered(hit) < *farthest
        {
            *farthest = Ordered(hit);
        }
        if self.nearest.len() == self.limit
            && let Some(Ordered(farthest)) = self.nearest.peek()
        {
            // Of those at the same t, the id decides.
            self.end = self.end.min(last_reported_as(farthest.t(), self.ray.length));
        }
    }

    fn covers(&self, distance: f32) -> bool {
        distance > self.ray.start && distance < self.ray.ray.t_max
    }
}

/// The primitives that equal `id`, besides itself.
pub(super) fn repeats_of(repeats: &[[PrimitiveId; 2]], id: PrimitiveId) -> &[[PrimitiveId; 2]] {
    let start = repeats.partition_point(|two| two[0] < id);
    let count = repeats[start..].partition_point(|two| two[0] == id);
    &repeats[start..start + count]
}

/// Calls `add` with a hit on a primitive, and on each of those that equal it.
fn with_repeats(repeats: &[[PrimitiveId; 2]], hit: Hit, mut add: impl FnMut(Hit)) {
    add(hit);
    if !repeats.is_empty() {
        for &[_, primitive] in repeats_of(repeats, hit.primitive) {
            add(Hit { primitive, ..hit });
        }
    }
}

impl HitSink for All<'_> {
    #[inline(always)]
    fn end(&self) -> f32 {
        self.end
    }
    #[inline(always)]
    fn in_order(&self) -> bool {
        self.limit < UNORDERED
    }
    #[inline(always)]
    fn take(&mut self, found: Found) {
        if self.covers(found.t) {
            let hit = hit_of(&found, self.ray.length);
            with_repeats(self.repeats, hit, |hit| self.keep(hit));
        }
    }
}

impl InstanceSink for All<'_, InstancedHit> {
    #[inline(always)]
    fn end(&self) -> f32 {
        self.end
    }
    #[inline(always)]
    fn in_order(&self) -> bool {
        self.limit < UNORDERED
    }
    #[inline(always)]
    fn take(&mut self, there: &FoundThere<'_>) {
        if self.covers(there.distance) {
            let t = reported(there.distance, self.ray.length);
            let hit = Hit {
                t,
                ..there.found.hit()
            };
            with_repeats(there.repeats, hit, |hit| {
                self.keep(InstancedHit::new(hit, there.instance));
            });
        }
    }
}

/// Crossings: of the triangles that meet at an edge or vertex only those that the line crosses.
pub(super) struct Crossings<'a> {
    ray: UnitRay,
    repeats: &'a [[PrimitiveId; 2]],
    hits: Vec<Hit>,
    /// Triangles with an edge within rounding error.
    unsure: Vec<(Hit, Crossing)>,
}

impl<'a> Crossings<'a> {
    pub(super) fn new(ray: UnitRay, repeats: &'a [[PrimitiveId; 2]]) -> Self {
        Self {
            ray,
            repeats,
            hits: Vec::new(),
            unsure: Vec::new(),
        }
    }

    /// Returns the crossings in order.
    pub(super) fn into_hits(mut self) -> Vec<Hit> {
        let triangles: Vec<Crossing> = self.unsure.iter().map(|&(_, triangle)| triangle).collect();
        let passes = crossings::decide(&self.ray.ray, &triangles);
        for (&(hit, _), passes) in self.unsure.iter().zip(passes) {
            if passes {
                self.hits.push(hit);
            }
        }
        self.hits.sort_unstable_by(in_order);
        self.hits
    }
}

impl HitSink for Crossings<'_> {
    const WANTS_UNSURE: bool = true;

    #[inline(always)]
    fn in_order(&self) -> bool {
        false
    }

    #[inline(always)]
    fn end(&self) -> f32 {
        self.ray.ray.t_max
    }
    #[inline(always)]
    fn take(&mut self, found: Found) {
        if found.t > self.ray.start && found.t < self.ray.ray.t_max {
            let hit = hit_of(&found, self.ray.length);
            with_repeats(self.repeats, hit, |hit| self.hits.push(hit));
        }
    }
    fn take_unsure(&mut self, mut found: Found, corners: [Vec3; 3]) {
        // If it is ahead at all, which is decided exactly, it is not at 0.
        found.t = found.t.max(f32::MIN_POSITIVE);
        if found.t > self.ray.start && found.t < self.ray.ray.t_max {
            let hit = hit_of(&found, self.ray.length);
            with_repeats(self.repeats, hit, |hit| {
                self.unsure.push((hit, Crossing(corners)));
            });
        }
    }
}
