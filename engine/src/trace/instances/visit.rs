//! Visits all hits of one ray in instances, as [`crate::trace::visit`] does in one BVH: the ray goes from one instance that it
//! meets to the next, and its image visits the prototype.

use super::{Met, Slot, waves::Walk};
use crate::{
    accel::Bvh,
    ray::{InstanceId, PrimitiveId, Ray},
    scene::Scene,
    simd::Simd,
    trace::{Found, HitSink, visit_with},
};
use std::cell::Cell;

/// A hit in an instance, for an [`InstanceSink`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct FoundThere<'a> {
    pub instance: InstanceId,
    /// The scene's distance, as packets report it. Of several hits in an instance at one distance, the first is that of the
    /// least t in the prototype's space.
    pub distance: f32,
    /// The hit in the prototype's space.
    pub found: Found,
    /// Pairs of a primitive of the prototype and an equal one that its BVH leaves out, in order.
    pub repeats: &'a [[PrimitiveId; 2]],
}

/// Says which hits in instances count; see [`HitSink`].
pub(crate) trait InstanceSink {
    const ANY: bool = false;
    /// The ray's end in the scene: hits beyond it are ignored.
    fn end(&self) -> f32;
    fn in_order(&self) -> bool {
        true
    }
    /// Takes a hit, which may be at 0.
    fn take(&mut self, found: &FoundThere<'_>);
}

/// Takes hits in one instance.
struct There<'a, K> {
    met: &'a Met,
    repeats: &'a [[PrimitiveId; 2]],
    sink: &'a mut K,
    /// The sink's end in the prototype's space.
    end: f32,
}

impl<K: InstanceSink> HitSink for There<'_, K> {
    const ANY: bool = K::ANY;

    #[inline(always)]
    fn end(&self) -> f32 {
        self.end
    }
    #[inline(always)]
    fn in_order(&self) -> bool {
        self.sink.in_order()
    }
    #[inline(always)]
    fn take(&mut self, found: Found) {
        self.sink.take(&FoundThere {
            instance: self.met.id,
            distance: self.met.distance(found.t),
            found,
            repeats: self.repeats,
        });
        self.end = self.met.beyond(self.sink.end());
    }
}

thread_local! {
    /// Kept from ray to ray.
    static STACK: Cell<Vec<(f32, Slot)>> = const { Cell::new(Vec::new()) };
}

/// Passes all hits of a ray in instances before the sink's end to the sink. An [invalid](Ray::is_valid) ray has none.
#[inline(always)]
pub(crate) fn visit_instances<S: Simd, K: InstanceSink>(
    simd: S,
    (scene, bvh): (&Scene, &Bvh),
    ray: &Ray,
    sink: &mut K,
) {
    let Some(instanced) = bvh.instanced().filter(|_| ray.is_valid()) else {
        return;
    };
    let mut stack = STACK.take();
    stack.clear();
    let mut walk = Walk::new(simd, instanced, (*ray, sink.end()), (0, 0), stack);
    while let Some(met) = walk.next_met(simd, scene, instanced) {
        let prototype = instanced.prototype(scene.instances()[met.id.0 as usize].prototype());
        let mut there = There {
            end: met.beyond(sink.end()),
            met: &met,
            repeats: prototype.repeats(),
            sink,
        };
        visit_with(simd, prototype, &met.image.ray, &mut there);
        walk.end = sink.end();
    }
    STACK.set(walk.todo);
}
