//! Boxes of primitives in the builder: eight lanes each.
//!
//! Functions that run for each primitive and level, here and in [`split`](super::split), are `inline(always)` and
//! free of `array::map` and iterator chains: see docs/lab-notes.md#builder-inlining

use crate::{
    geometry::padded,
    lanes::{F32x8, LANES},
    math::Aabb,
    ray::PrimitiveId,
    scene::{Primitive, Scene},
    simd::{EightLanes, Lanes, Simd},
};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// A box and its primitive: the negated lower corner, the id's bits, the upper corner, an unused lane. So a union is one
/// maximum of eight lanes (which makes the id meaningless), and moving a primitive moves 32 bytes.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub(super) struct Box8(F32x8);

impl Box8 {
    /// The empty box. Its half area is infinite, so its cost times 0 blocks is NaN and never the minimum.
    pub(super) const EMPTY: Self = Self(F32x8::new([-1e30; LANES]));

    #[inline(always)]
    pub(super) fn new(bounds: Aabb, id: PrimitiveId) -> Self {
        let (l, u) = (-bounds.lower, bounds.upper);
        Self(F32x8::new([
            l.x,
            l.y,
            l.z,
            f32::from_bits(id.0),
            u.x,
            u.y,
            u.z,
            0.0,
        ]))
    }

    #[inline(always)]
    pub(super) fn union<S: Simd>(self, simd: S, other: Self) -> Self {
        Self(simd.load(&self.0).max(simd.load(&other.0)).to8())
    }

    #[inline(always)]
    pub(super) fn id(&self) -> PrimitiveId {
        PrimitiveId(self.0.as_array()[3].to_bits())
    }

    #[inline(always)]
    pub(super) fn bounds(&self) -> Aabb {
        let b = self.0.as_array();
        Aabb {
            lower: -Vec3::new(b[0], b[1], b[2]),
            upper: Vec3::new(b[4], b[5], b[6]),
        }
    }

    /// Half of the surface area.
    #[inline(always)]
    pub(super) fn half_area<S: Simd>(self, simd: S) -> f32 {
        let corners = simd.load(&self.0);
        let size = (corners + corners.swap_halves()).to8().to_array();
        let (x, y, z) = (size[4], size[5], size[6]);
        x * (y + z) + y * z
    }

    /// The centre as a box without size, at twice its coordinates.
    #[inline(always)]
    pub(super) fn center<S: Simd>(self, simd: S) -> Self {
        Self(self.center_lanes(simd).to8())
    }

    /// [`center`](Self::center) in registers.
    #[inline(always)]
    pub(super) fn center_lanes<S: Simd>(self, simd: S) -> S::V8 {
        let corners = self.corners(simd);
        corners - corners.swap_halves()
    }

    /// Only the corners: an id that is a denormal float would slow down arithmetic.
    #[inline(always)]
    fn corners<S: Simd>(self, simd: S) -> S::V8 {
        const COORDINATES: u32 = 0b0111_0111;
        S::V8::select(simd.mask(COORDINATES), simd.load(&self.0), simd.splat(0.0))
    }

    /// [`half_area`](Self::half_area) of a primitive's box.
    #[inline(always)]
    pub(super) fn half_area_without_id<S: Simd>(self, simd: S) -> f32 {
        Self(self.corners(simd).to8()).half_area(simd)
    }

    /// The box around `boxes`.
    #[inline(always)]
    pub(super) fn around<S: Simd>(simd: S, boxes: &[Self]) -> Self {
        let mut all = simd.load(&Self::EMPTY.0);
        for b in boxes {
            all = all.max(simd.load(&b.0));
        }
        Self(all.to8())
    }

    /// The box around the centres of `boxes`; see [`Self::center`].
    #[inline(always)]
    pub(super) fn around_centers<S: Simd>(simd: S, boxes: &[Self]) -> Self {
        let mut all = simd.load(&Self::EMPTY.0);
        for b in boxes {
            all = all.max(b.center_lanes(simd));
        }
        Self(all.to8())
    }
}

/// The boxes of all primitives in these ranges of ids that a ray can hit; of many equal shapes only the first. Then, for
/// each one left out, the ids of the first and of itself, in order.
pub(super) fn boxes_of(scene: &Scene, ids: &[Range<u32>]) -> (Vec<Box8>, Vec<[PrimitiveId; 2]>) {
    let boxed = |id: PrimitiveId| primitive_box(scene, id);
    let mut boxes: Vec<Box8> = Vec::with_capacity(ids.iter().map(ExactSizeIterator::len).sum());
    for range in ids {
        let ids = range.clone().into_par_iter().map(PrimitiveId);
        if scene.degenerate_triangles() == 0 {
            boxes.par_extend(ids.map(boxed));
        } else {
            boxes.par_extend(ids.filter(|&id| can_be_hit(scene, id)).map(boxed));
        }
    }
    if has_repeats(&boxes) {
        let (first, repeats) = first_of_each_shape(scene, boxes.par_iter().map(Box8::id).collect());
        (first.into_par_iter().map(boxed).collect(), repeats)
    } else {
        (boxes, Vec::new())
    }
}

/// [`Scene::triangle`], inlined into the caller's loop.
#[inline(always)]
pub(super) fn corners(scene: &Scene, i: usize) -> [Vec3; 3] {
    let (t, v) = (scene.triangles(), scene.vertices());
    let [a, b, c] = t.corners[i];
    let (a, b, c) = (a as usize, b as usize, c as usize);
    [
        Vec3::new(v.x[a], v.y[a], v.z[a]),
        Vec3::new(v.x[b], v.y[b], v.z[b]),
        Vec3::new(v.x[c], v.y[c], v.z[c]),
    ]
}

fn can_be_hit(scene: &Scene, id: PrimitiveId) -> bool {
    match scene.primitive(id) {
        Primitive::Triangle(i) => scene.has_area(i),
        Primitive::Sphere(_) | Primitive::Plane(_) => true,
    }
}

#[inline(always)]
fn primitive_box(scene: &Scene, id: PrimitiveId) -> Box8 {
    let i = id.0 as usize;
    match i.checked_sub(scene.triangles().corners.len()) {
        None => triangle_box(corners(scene, i), id),
        Some(i) => sphere_box(scene, i, id),
    }
}

#[inline(always)]
pub(super) fn triangle_box([a, b, c]: [Vec3; 3], id: PrimitiveId) -> Box8 {
    let bounds = Aabb {
        lower: a.min(b).min(c),
        upper: a.max(b).max(c),
    };
    Box8::new(padded(bounds), id)
}

/// The box of sphere `i`, whose primitive id is `id`.
#[inline(always)]
pub(super) fn sphere_box(scene: &Scene, i: usize, id: PrimitiveId) -> Box8 {
    Box8::new(padded(scene.sphere_bounds(i)), id)
}

/// Reduces the ordered boxes to ids, in place: nodes and blocks need no boxes, and are written when the most memory is in
/// use.
pub(super) fn into_ids(boxes: Vec<Box8>) -> Vec<PrimitiveId> {
    let boxes = boxes.into_par_iter().with_min_len(1 << 14);
    boxes.map(|b| b.id()).collect()
}

/// This many boxes are sampled to find out whether many are equal: time for each build against certainty.
// Tuned: see docs/lab-notes.md#varied-constants
const SAMPLE: usize = 4096;

/// Whether many boxes of a sample are equal. Pairs are ignored: both triangles of an axis-aligned rectangle have one box.
fn has_repeats(boxes: &[Box8]) -> bool {
    let stride = boxes.len().div_ceil(SAMPLE).max(1);
    let bits = |b: &Box8| {
        let lanes = b.0.to_array().map(f32::to_bits);
        [lanes[0], lanes[1], lanes[2], lanes[4], lanes[5], lanes[6]]
    };
    let mut sample: Vec<_> = boxes.iter().step_by(stride).map(bits).collect();
    sample.sort_unstable();
    sample.windows(3).any(|three| three[0] == three[2])
}

/// Of primitives of the same shape, bit for bit, keeps the one with the lowest id, which wins at equal t. Otherwise a ray
/// that hits one of a million equal triangles would test them all. Primitives that some rays may pass are kept up to the
/// first that stops all. Of one-sided opaque ones only the first is kept: they have the same front.
fn first_of_each_shape(
    scene: &Scene,
    primitives: Vec<PrimitiveId>,
) -> (Vec<PrimitiveId>, Vec<[PrimitiveId; 2]>) {
    let mut keyed: Vec<_> = primitives
        .into_par_iter()
        .map(|id| (scene.shape(id).bits(), id))
        .collect();
    keyed.par_sort_unstable();
    let (mut primitives, mut repeats) = (Vec::new(), Vec::new());
    for same in keyed.chunk_by(|a, b| a.0 == b.0) {
        let (mut stops_front, mut stops_all) = (None, None);
        for &(_, id) in same {
            let (is_one_sided, is_whole) = (scene.is_one_sided(id), scene.stops_rays(id));
            if let Some(first) = stops_all.or(stops_front.filter(|_| is_one_sided)) {
                repeats.push([first, id]);
                continue;
            }
            primitives.push(id);
            let stops = if is_one_sided {
                &mut stops_front
            } else {
                &mut stops_all
            };
            *stops = stops.or(is_whole.then_some(id));
        }
    }
    primitives.par_sort_unstable();
    repeats.par_sort_unstable();
    (primitives, repeats)
}
